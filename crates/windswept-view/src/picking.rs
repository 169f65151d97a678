//! What the pointer is over.

use glam::DVec3;
use windswept::{CheckedScene, Frame, Pose};
use windswept_export::View;
use windswept_scene::CheckedShape;

/// Distance from the pointer at which a point of hair is under it \[px\].
const NEAR: f64 = 10.0;
/// Steps along a ray to a surface, at most.
const MOST_STEPS: usize = 200;
/// Farthest that a ray is followed, in distances from the camera to its target.
const FARTHEST: f64 = 20.0;

/// A point of hair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Point {
    pub(crate) strand: usize,
    /// From 0 at the root.
    pub(crate) point: usize,
    /// Index of the point among those of all strands.
    pub(crate) row: usize,
}

/// The point of hair that is nearest to a place in the picture \[px\], if one is near; of several as near the one
/// before the others.
pub(crate) fn point_at(frame: &Frame, view: &View, at: [f64; 2]) -> Option<Point> {
    let clip = view.clip_from_world([1.0, 2.0]);
    let size = [f64::from(view.width), f64::from(view.height)];
    let distance = |x: &[f32; 3]| {
        let x = clip * DVec3::from_array(x.map(f64::from)).extend(1.0);
        let place = [(0.5 + 0.5 * x.x / x.w) * size[0], (0.5 - 0.5 * x.y / x.w) * size[1]];
        // Behind the camera nothing is near.
        if x.w > 0.0 { ((place[0] - at[0]).hypot(place[1] - at[1]), x.w) } else { (f64::INFINITY, x.w) }
    };
    let rows = frame.hair.positions.iter().map(distance).enumerate();
    let near = rows.filter(|(_, (distance, _))| *distance < NEAR);
    let (row, _) = near.min_by(|(_, a), (_, b)| {
        (a.0.round(), a.1).partial_cmp(&(b.0.round(), b.1)).unwrap_or(std::cmp::Ordering::Equal)
    })?;
    let strand = frame.hair.offsets.partition_point(|first| *first as usize <= row).checked_sub(1)?;
    Some(Point { strand, point: row - frame.hair.offsets[strand] as usize, row })
}

/// Unit vector from the camera through a place in the picture \[px\].
fn ray(view: &View, [x, y]: [f64; 2]) -> DVec3 {
    let [right, up, back] = view.axes();
    let slope = (0.5 * view.fov.to_radians()).tan() / (0.5 * f64::from(view.height));
    let (x, y) = (x - 0.5 * f64::from(view.width), 0.5 * f64::from(view.height) - y);
    (slope * x * right + slope * y * up - back).normalize()
}

/// A body under the pointer.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grip {
    pub(crate) name: String,
    /// Distance from the camera to what was gripped \[m\].
    pub(crate) depth: f64,
    /// The body's pose as it was gripped.
    pub(crate) pose: Pose,
}

/// The nearest body at a place in the picture \[px\] that can be dragged: no plane, which has no end, and none that
/// deforms.
pub(crate) fn body_at(scene: &CheckedScene, frame: &Frame, view: &View, at: [f64; 2]) -> Option<Grip> {
    let way = ray(view, at);
    let most = FARTHEST * view.eye.distance(view.target);
    let grips = scene.bodies.iter().enumerate().filter_map(|(i, body)| {
        let deforms = body.shape.solid().is_some_and(|solid| solid.frames().is_some());
        if deforms || matches!(body.shape, CheckedShape::Plane(_)) {
            return None;
        }
        let pose = frame.bodies.get(i).copied().unwrap_or_else(|| body.motion.at(frame.time));
        let shape = body.placed(&pose, frame.time);
        let depth = reached(&shape, view.eye, way, most)?;
        Some(Grip { name: body.name.clone(), depth, pose })
    });
    grips.min_by(|a, b| a.depth.total_cmp(&b.depth))
}

/// Way along a ray to a surface \[m\], if it comes there: by steps as long as the distance to the surface (sphere
/// tracing).
fn reached(shape: &CheckedShape, from: DVec3, way: DVec3, most: f64) -> Option<f64> {
    let mut along = 0.0;
    for _ in 0..MOST_STEPS {
        let (distance, _) = shape.signed_distance(from + along * way);
        if distance < 1e-4 * along {
            return Some(along);
        }
        along += distance;
        if !along.is_finite() || along > most {
            return None;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use windswept::{Body, HairFrame, Model, Time};

    use super::*;

    fn view() -> View {
        View { eye: DVec3::new(0.1, 0.2, 1.0), target: DVec3::new(0.1, 0.2, 0.0), fov: 40.0, width: 640, height: 480 }
    }

    /// The strand and the point of it whose picture is under the pointer are found, and nothing beside them.
    #[test]
    fn a_point_of_hair_is_found_by_its_picture() {
        let positions = vec![[0.0, 0.2, 0.0], [0.05, 0.25, 0.0], [0.1, 0.3, 0.1], [0.1, 0.2, 0.0], [0.2, 0.1, -0.1]];
        let hair = HairFrame { offsets: vec![0, 3, 5], positions: positions.clone(), ..HairFrame::default() };
        let frame = Frame { hair, ..Frame::default() };
        for (row, (strand, point)) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1)].into_iter().enumerate() {
            let x = DVec3::from_array(positions[row].map(f64::from));
            let at = view().project(x).unwrap();
            assert_eq!(point_at(&frame, &view(), [at[0] + 3.0, at[1] - 2.0]), Some(Point { strand, point, row }));
        }
        assert_eq!(point_at(&frame, &view(), [10.0, 10.0]), None);
        assert_eq!(point_at(&Frame::default(), &view(), [320.0, 240.0]), None);
    }

    /// Of two bodies behind one another the nearer one is gripped, at its surface; a plane is not.
    #[test]
    fn the_nearest_body_is_gripped() {
        let mut scene = windswept::Scene::new(Time::new(1e-3, 1.0));
        scene.interaction.model = Some(Model::None);
        scene.bodies = vec![
            Body::sphere([0.1, 0.2, -0.2], 0.1).named("far"),
            Body::sphere([0.1, 0.2, 0.3], 0.05).named("near"),
            Body::plane([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]).named("floor"),
        ];
        let scene = scene.check().unwrap();
        let grip = body_at(&scene, &Frame::default(), &view(), [320.0, 240.0]).unwrap();
        assert_eq!(grip.name, "near");
        assert!((grip.depth - 0.65).abs() < 1e-3, "{}", grip.depth);
        // The near one goes aside.
        let mut frame = Frame { bodies: vec![Pose::default(); 3], ..Frame::default() };
        frame.bodies[1].translation = DVec3::new(0.2, 0.0, 0.0);
        assert_eq!(body_at(&scene, &frame, &view(), [320.0, 240.0]).unwrap().name, "far");
        assert_eq!(body_at(&scene, &frame, &view(), [320.0, 470.0]), None);
    }
}
