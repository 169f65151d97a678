//! Meshes that deform: `body.frames`, or vertices of a caller's. A mesh goes from pose to pose; its motion is a rigid
//! one, and what is left of it in the mesh's own place.
//!
//! Between two poses the rigid motion is that of keyframes, and what is left is linear: a mesh that only moves and
//! turns keeps its shape on the way.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Vec3};

use crate::{
    curves::npz::MovingMesh,
    error::SceneError,
    motion::{Keyframe, Motion, Pose},
    scene::Up,
    solid::MARGIN,
    triangles::{
        DistanceGrid, Triangles,
        band::{Lattice, MOST, VALUES, parts},
        tree::{Looks, Tree},
    },
};

/// Steps in which the rotation of a pose is found, and the change \[rad\] that ends them.
const STEPS: u32 = 100;
const FOUND: f64 = 1e-13;
/// Part of its size by which a lattice reaches beyond a mesh that a caller moves.
const ROOM: f64 = 0.15;

/// The poses of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Frames {
    /// Rigid part of the motion, with a keyframe for each pose, about [`Self::center`].
    motion: Motion,
    center: DVec3,
    /// Points of each pose in the mesh's own place, about the centre \[m\].
    poses: Vec<Arc<Vec<Vec3>>>,
    skin: Arc<Skin>,
    lattice: Lattice,
}

/// What all poses have.
#[derive(Debug, PartialEq)]
struct Skin {
    /// Corners of the mesh's triangles.
    corners: Vec<[u32; 3]>,
    /// Triangles of its surface without holes, and the points of the mesh that each of its points is the mean of.
    surface: Vec<[u32; 3]>,
    sources: Vec<Vec<u32>>,
    /// Points of the pose that others are fitted to, about the centre \[m\].
    rest: Vec<DVec3>,
}

impl Skin {
    fn new(mesh: &Triangles) -> Self {
        let closed = mesh.close();
        let (surface, sources) = (closed.surface.corners, closed.sources);
        Self { corners: mesh.corners.clone(), surface, sources, rest: mesh.points.clone() }
    }
}

/// A place on a mesh that deforms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bond {
    /// Corners of the triangle.
    pub corners: [u32; 3],
    /// Parts of the corners that the place consists of.
    pub parts: [f64; 3],
    /// Frame of the triangle in the mesh's own place: along its first edge, across it, and along its normal.
    pub frame: DQuat,
    /// The place itself, in the mesh's own place \[m\].
    pub place: DVec3,
}

/// Where a mesh is in its motion: between the pose of this index and the next, and the part of the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase {
    /// Index of the pose before.
    pub pose: usize,
    /// Part of the way to the next.
    pub part: f64,
}

impl Frames {
    /// The poses of a file's mesh, with a grid of `resolution` \[m\], and the mesh in its first pose, about its centre.
    pub(crate) fn new(
        mesh: MovingMesh,
        scale: f64,
        up: Up,
        resolution: Option<f64>,
    ) -> Result<(Self, Triangles), SceneError> {
        mesh.check()?;
        let MovingMesh { times, poses, corners, .. } = mesh;
        let in_metres = |pose: Vec<[f64; 3]>, corners: Vec<[u32; 3]>| -> Triangles {
            let points = pose.into_iter().map(DVec3::from_array).collect();
            Triangles { points, corners, ..Triangles::default() }.in_metres(scale, up)
        };
        let mut poses = poses.into_iter();
        let mut first = in_metres(poses.next().unwrap_or_default(), corners);
        let center = mean(&first.points);
        first.points.iter_mut().for_each(|x| *x -= center);
        let rest: Vec<Vec3> = first.points.iter().map(|x| x.as_vec3()).collect();
        let (mut keyframes, mut all) = (vec![Keyframe::new(times[0])], vec![Arc::new(rest)]);
        let mut before = Pose::default();
        for (pose, time) in poses.zip(&times[1..]) {
            let (fitted, own) = fit(center, &first.points, before, &in_metres(pose, Vec::new()).points);
            keyframes.push(Keyframe::posed(*time, fitted));
            all.push(Arc::new(own));
            before = fitted;
        }
        let bounds = bounds(&all);
        let spacing = resolution.unwrap_or_else(|| DistanceGrid::spacing_within(bounds, MOST));
        let lattice = Lattice::about(bounds, spacing, MARGIN * spacing);
        check_size(&lattice)?;
        let skin = Arc::new(Skin::new(&first));
        Ok((Self { motion: keyframes.into(), center, poses: all, skin, lattice }, first))
    }

    /// A mesh that a caller may let deform, as it is in its own place: it keeps its shape, and goes by a motion.
    pub(crate) fn at_rest(
        triangles: &Triangles,
        center: DVec3,
        motion: Motion,
        spacing: f64,
    ) -> Result<Self, SceneError> {
        let poses = vec![Arc::new(triangles.points.iter().map(|x| x.as_vec3()).collect())];
        let lattice = Lattice::about(bounds(&poses), spacing, MARGIN * spacing);
        check_size(&lattice)?;
        Ok(Self { motion, center, poses, skin: Arc::new(Skin::new(triangles)), lattice })
    }

    /// The mesh on the way from where it is at a time to these points \[m\] at another one \[s\].
    ///
    /// # Errors
    /// [`SceneError`] where the grid that holds it would be too large.
    pub fn toward(&self, [from, to]: [f64; 2], points: &[DVec3]) -> Result<Self, SceneError> {
        let before = self.motion.at(from);
        let phase = self.phase(from);
        // A pose that is there is taken as it is, with what has been baked of it.
        let now = if phase.part == 0.0 { self.poses[phase.pose].clone() } else { Arc::new(self.points(from)) };
        let (fitted, own) = fit(self.center, &self.skin.rest, before, points);
        let poses = vec![now, Arc::new(own)];
        let mut lattice = self.lattice;
        if !poses.iter().all(|pose| lattice.holds(pose)) {
            let [low, high] = bounds(&poses);
            let margin = ROOM * (high - low).max_element() + MARGIN * lattice.spacing;
            lattice = Lattice::about([low, high], lattice.spacing, margin);
            check_size(&lattice)?;
        }
        let motion = [Keyframe::posed(from, before), Keyframe::posed(to, fitted)].into();
        Ok(Self { motion, poses, lattice, ..self.clone() })
    }

    /// The mesh with other poses, which an earlier [`Self::toward`] has made.
    #[must_use]
    pub fn with_poses(&self, motion: Motion, poses: Vec<Arc<Vec<Vec3>>>, lattice: Lattice) -> Self {
        Self { motion, poses, lattice, ..self.clone() }
    }

    /// The mesh at rest where the grid of another one holds it.
    #[must_use]
    pub fn on(&self, lattice: &Lattice) -> Self {
        Self { lattice: *lattice, ..self.clone() }
    }

    /// Rigid part of the motion, about the centre, with a keyframe for each pose.
    #[must_use]
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Point that the motion turns about \[m\].
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Number of poses.
    #[must_use]
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// Whether there is no pose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.poses.is_empty()
    }

    /// Points of a pose in the mesh's own place \[m\].
    #[must_use]
    pub fn pose(&self, pose: usize) -> &Arc<Vec<Vec3>> {
        &self.poses[pose]
    }

    /// Nodes at which distances are baked.
    #[must_use]
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Number of values that two poses have at the nodes.
    #[must_use]
    pub fn values(&self) -> usize {
        2 * VALUES * self.lattice.nodes()
    }

    /// Where the mesh is in its motion at a time \[s\].
    #[must_use]
    pub fn phase(&self, time: f64) -> Phase {
        let (pose, part) = self.motion.phase(time);
        if pose + 1 < self.poses.len() { Phase { pose, part } } else { Phase { pose: self.poses.len() - 1, part: 0.0 } }
    }

    /// Points at a time \[s\], in the mesh's own place \[m\].
    #[must_use]
    pub fn points(&self, time: f64) -> Vec<Vec3> {
        let Phase { pose, part } = self.phase(time);
        let next = &self.poses[(pose + 1).min(self.poses.len() - 1)];
        self.poses[pose].iter().zip(next.iter()).map(|(from, to)| from.lerp(*to, part as f32)).collect()
    }

    /// Distances of the nodes from the surface of a pose \[m\], and then for each node the move of the nearest point of
    /// the surface from the pose before, x, y and z \[m\].
    #[must_use]
    pub fn bake(&self, pose: usize) -> Vec<f32> {
        let now = self.surface(&self.poses[pose]);
        let before = pose.checked_sub(1).map(|before| self.surface(&self.poses[before]));
        let moves = match before {
            Some(before) => now.iter().zip(before).map(|(now, before)| *now - before).collect(),
            None => vec![Vec3::ZERO; now.len()],
        };
        self.lattice.bake(&self.skin.surface, &now, &moves)
    }

    /// Distances of the nodes from the surface of these points of the mesh \[m\].
    pub(crate) fn distances(&self, points: &[Vec3]) -> Vec<f32> {
        let now = self.surface(points);
        let mut values = self.lattice.bake(&self.skin.surface, &now, &vec![Vec3::ZERO; now.len()]);
        values.truncate(self.lattice.nodes());
        values
    }

    /// Points of the surface, from those of the mesh.
    fn surface(&self, points: &[Vec3]) -> Vec<Vec3> {
        let mean = |of: &Vec<u32>| of.iter().map(|&i| points[i as usize]).sum::<Vec3>() / of.len().max(1) as f32;
        self.skin.sources.iter().map(mean).collect()
    }

    /// The places of the mesh that are nearest to places in its own place \[m\], at a time \[s\].
    #[must_use]
    pub fn bonds(&self, time: f64, places: &[DVec3]) -> Vec<Bond> {
        let points = self.points(time).into_iter().map(|x| x.as_dvec3()).collect();
        let mesh = Triangles { points, corners: self.skin.corners.clone(), ..Triangles::default() };
        let tree = Tree::new(&mesh);
        let bond = |x: &DVec3| {
            let (face, place) = tree.nearest_face(*x, f64::INFINITY, &mut Looks::default()).unwrap_or((0, *x));
            let corners = mesh.corners[face as usize];
            let triangle = corners.map(|i| mesh.points[i as usize]);
            Bond { corners, parts: parts(&triangle, place), frame: frame(&triangle), place }
        };
        places.iter().map(bond).collect()
    }
}

/// Frame of a triangle: along its first edge, across it, and along its normal.
fn frame(&[a, b, c]: &[DVec3; 3]) -> DQuat {
    let along = (b - a).normalize_or(DVec3::X);
    let normal = (b - a).cross(c - a).normalize_or(along.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(along, normal.cross(along), normal))
}

fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len().max(1) as f64
}

/// The rigid pose, near the one before, that brings the points `rest` about `center` nearest to others (Müller et al.
/// 2016, "A robust method to extract the rotational part of deformations"), and these in the mesh's own place.
fn fit(center: DVec3, rest: &[DVec3], before: Pose, points: &[DVec3]) -> (Pose, Vec<Vec3>) {
    let (middle, rest_middle) = (mean(points), mean(rest));
    let columns = points.iter().zip(rest).fold([DVec3::ZERO; 3], |[x, y, z], (point, rest)| {
        let (point, rest) = (*point - middle, *rest - rest_middle);
        [x + rest.x * point, y + rest.y * point, z + rest.z * point]
    });
    let mut rotation = before.rotation;
    for _ in 0..STEPS {
        let axes = DMat3::from_quat(rotation);
        let pairs = [axes.x_axis, axes.y_axis, axes.z_axis].into_iter().zip(columns);
        let (turn, size) = pairs.fold((DVec3::ZERO, 0.0), |(turn, size), (axis, column)| {
            (turn + axis.cross(column), size + axis.dot(column))
        });
        let turn = turn / (size.abs() + f64::MIN_POSITIVE);
        if turn.is_nan() || turn.length() <= FOUND {
            break;
        }
        rotation = (DQuat::from_scaled_axis(turn) * rotation).normalize();
    }
    let translation = middle - center - rotation * rest_middle;
    let back = rotation.conjugate();
    let own = points.iter().map(|x| (back * (*x - center - translation)).as_vec3()).collect();
    (Pose { translation, rotation }, own)
}

/// Corners of the box about all poses \[m\].
fn bounds(poses: &[Arc<Vec<Vec3>>]) -> [DVec3; 2] {
    let points = poses.iter().flat_map(|pose| pose.iter()).map(|x| x.as_dvec3());
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// A grid holds two poses.
fn check_size(lattice: &Lattice) -> Result<(), SceneError> {
    let nodes: f64 = lattice.counts.iter().map(|count| f64::from(*count)).product();
    if nodes <= MOST {
        return Ok(());
    }
    let words = format!(
        "a grid of {} m that holds all poses has {nodes:.2e} nodes; expected at most {MOST:.2e}",
        lattice.spacing as f32
    );
    Err(SceneError::new(words).with_help("a larger resolution has fewer nodes").at("spacing", None))
}
