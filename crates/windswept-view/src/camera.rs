//! A camera that orbits, pans and zooms.

use glam::DVec3;
use windswept_export::View;

/// Turn by a drag over a pixel \[rad\].
const TURN: f64 = 0.008;
/// Largest angle above and below the horizon \[rad\]: the camera does not turn over.
const STEEPEST: f64 = 1.55;
/// Part of the picture's lesser side that framed hair fills.
const FILLED: f64 = 0.9;

/// A camera about its target, upright.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Orbit {
    /// Angle about the vertical \[rad\]; at 0 the camera is toward +z from its target.
    yaw: f64,
    /// Angle above the horizon \[rad\].
    pitch: f64,
    /// Distance from the target \[m\].
    distance: f64,
    /// The point that the camera looks at \[m\].
    target: DVec3,
    /// Vertical field of view \[°\].
    fov: f64,
}

impl Orbit {
    /// The camera of a picture, which must not stand where it looks.
    pub(crate) fn of(view: &View) -> Self {
        let away = view.eye - view.target;
        let distance = away.length();
        Self {
            yaw: away.x.atan2(away.z),
            pitch: (away.y / distance).clamp(-1.0, 1.0).asin().clamp(-STEEPEST, STEEPEST),
            distance,
            target: view.target,
            fov: view.fov,
        }
    }

    /// What it sees in a picture of this size \[px\].
    pub(crate) fn view(&self, [width, height]: [u32; 2]) -> View {
        View { eye: self.target + self.distance * self.away(), target: self.target, fov: self.fov, width, height }
    }

    /// Unit vector from the target to the camera.
    fn away(&self) -> DVec3 {
        let ((ys, yc), (ps, pc)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        DVec3::new(ys * pc, ps, yc * pc)
    }

    /// Turns about the target by a drag \[px\].
    pub(crate) fn turn(&mut self, [x, y]: [f64; 2]) {
        self.yaw -= TURN * x;
        self.pitch = (self.pitch + TURN * y).clamp(-STEEPEST, STEEPEST);
    }

    /// The way in the plane of the picture through `depth` \[m\] before the camera that a drag \[px\] over a picture so
    /// high \[px\] makes \[m\].
    pub(crate) fn way(&self, [x, y]: [f64; 2], height: f64, depth: f64) -> DVec3 {
        let [right, up, _] = self.view([1, 1]).axes();
        let metres = 2.0 * depth * (0.5 * self.fov.to_radians()).tan() / height.max(1.0);
        metres * (x * right - y * up)
    }

    /// Moves with the target, so that what is there stays under the pointer.
    pub(crate) fn pan(&mut self, drag: [f64; 2], height: f64) {
        self.target -= self.way(drag, height, self.distance);
    }

    /// Comes nearer by a scroll \[px\].
    pub(crate) fn zoom(&mut self, scroll: f64) {
        self.distance = (self.distance * (-0.002 * scroll).exp()).clamp(1e-4, 1e4);
    }

    /// Sees all of these points \[m\] from the same side, in a picture of this size \[px\].
    pub(crate) fn frame(&mut self, points: &[[f32; 3]], [width, height]: [u32; 2]) {
        let points = points.iter().map(|x| DVec3::from_array(x.map(f64::from))).filter(|x| x.is_finite());
        let (low, high) = points.fold((DVec3::MAX, DVec3::MIN), |(low, high), x| (low.min(x), high.max(x)));
        if low.x > high.x {
            return;
        }
        let radius = (0.5 * (high - low).length()).max(1e-3);
        let aspect = f64::from(width) / f64::from(height.max(1));
        let slope = (0.5 * self.fov.to_radians()).tan() * aspect.min(1.0) * FILLED;
        self.target = 0.5 * (low + high);
        self.distance = radius / slope.atan().sin();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orbit() -> Orbit {
        let eye = DVec3::new(0.3, 0.25, 0.4);
        Orbit::of(&View { eye, target: DVec3::new(0.1, 0.05, 0.0), fov: 26.0, width: 800, height: 600 })
    }

    /// The camera of a picture is taken over as it stands.
    #[test]
    fn it_begins_where_the_picture_was_taken() {
        let view = orbit().view([800, 600]);
        assert!(view.eye.distance(DVec3::new(0.3, 0.25, 0.4)) < 1e-12, "{}", view.eye);
        assert_eq!((view.target, view.fov), (DVec3::new(0.1, 0.05, 0.0), 26.0));
    }

    /// A turn keeps distance and target, however far it is dragged, and never turns over.
    #[test]
    fn a_turn_keeps_the_distance() {
        let mut turned = orbit();
        let before = turned.view([800, 600]);
        turned.turn([300.0, 5000.0]);
        let view = turned.view([800, 600]);
        assert!((view.eye.distance(view.target) - before.eye.distance(before.target)).abs() < 1e-12);
        assert_eq!(view.target, before.target);
        assert!(view.eye.y > view.target.y && view.axes().iter().all(|axis| axis.is_finite()));
        assert!(view.eye.distance(before.eye) > 0.1);
    }

    /// What is at the target's depth under the pointer stays there while the camera pans.
    #[test]
    fn a_pan_goes_with_the_pointer() {
        let mut panned = orbit();
        let seen = panned.view([800, 600]).target;
        panned.pan([40.0, -25.0], 600.0);
        let at = panned.view([800, 600]).project(seen).unwrap();
        assert!((at[0] - 440.0).abs() < 1e-6 && (at[1] - 275.0).abs() < 1e-6, "{at:?}");
    }

    /// All points are in the picture after framing, whatever its shape, and not lost in it.
    #[test]
    fn framing_shows_all_points() {
        let points = [[0.0, 0.0, 0.0], [0.2, 0.1, 0.05], [-0.1, 0.02, 0.3], [0.05, -0.2, 0.1]];
        for size in [[800, 300], [300, 800]] {
            let mut framed = orbit();
            framed.frame(&points, size);
            let view = framed.view(size);
            let places = points.map(|x| view.project(DVec3::from_array(x.map(f64::from))).unwrap());
            let inside =
                |[x, y]: &[f64; 2]| (0.0..f64::from(size[0])).contains(x) && (0.0..f64::from(size[1])).contains(y);
            assert!(places.iter().all(inside), "{places:?}");
            let spread = places.iter().map(|at| at[0]).fold(f64::MIN, f64::max)
                - places.iter().map(|at| at[0]).fold(f64::MAX, f64::min);
            assert!(spread > 0.2 * f64::from(size[0].min(size[1])), "{places:?}");
        }
    }

    /// Hair that is not finite, or none, leaves the camera where it is.
    #[test]
    fn framing_nothing_changes_nothing() {
        let mut framed = orbit();
        framed.frame(&[[f32::NAN, 0.0, 0.0]], [800, 600]);
        framed.frame(&[], [800, 600]);
        assert_eq!(framed, orbit());
    }
}
