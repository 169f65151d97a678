//! The camera of a picture, and the lights.

use std::f64::consts::PI;

use glam::dcamera::lh::view::look_to_mat4;
use glam::dcamera::rh::{proj, view::look_at_mat4};
use glam::{DMat4, DVec3, Vec3, Vec4};
use windswept_engine::HairFrame;
use windswept_scene::{Band, Camera, CheckedAir, CheckedBody, CheckedScene, Curves, Fibre, Hair, LookAt, Model, Pose};
use windswept_shaders::pictures::common::{self as shader, FINE, GRID, Light};

use super::patch::{ends, patches};
use crate::error::ExportError;
use crate::followers::{Followers, Strand};

/// Share of the picture that the automatic camera fills.
const FILLED: f64 = 0.95;

/// A camera in the world, and the size of its picture. Where the scene does not say where it stands, it sees all of the
/// hair from where it starts to where it hangs, streams in the wind and swings in its eddies: from the side, wind from
/// the left, a little from above and downwind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// The point where the camera stands \[m\].
    pub eye: DVec3,
    /// The point that it looks at \[m\].
    pub target: DVec3,
    /// Vertical field of view [°].
    pub fov: f64,
    /// Size of the picture \[px\].
    pub width: u32,
    /// Size of the picture \[px\].
    pub height: u32,
}

impl View {
    /// The scene's cameras as pictures of a film are taken with them, whose hair is `start` at first; `groom` is a
    /// caller's own.
    ///
    /// # Errors
    /// [`ExportError::Picture`] as [`Self::new`] and [`Followers::with_groom`].
    pub fn all(scene: &CheckedScene, start: &HairFrame, groom: Option<&Curves>) -> Result<Vec<Self>, ExportError> {
        let followers = Followers::about(scene, start, groom, scene.picture.hairs)?;
        scene.cameras.iter().map(|camera| Self::new(scene, camera, &followers)).collect()
    }

    /// A camera in a scene, the same for every frame of a film; where it does not say where it stands, it sees where
    /// these strands may go from their start.
    ///
    /// # Errors
    /// [`ExportError::Picture`] when the camera stands where it looks.
    pub fn new(scene: &CheckedScene, camera: &Camera, strands: &Followers) -> Result<Self, ExportError> {
        let Some(LookAt { eye, target }) = camera.look_at else {
            return Ok(Self::automatic(scene, camera, strands));
        };
        let (eye, target) = (DVec3::from_array(eye), DVec3::from_array(target));
        if eye.distance(target) < 1e-9 {
            return Err(ExportError::Picture {
                problem: "camera.eye and camera.target are the same point: expected two".into(),
            });
        }
        Ok(Self { eye, target, fov: camera.fov, width: camera.width, height: camera.height })
    }

    fn automatic(scene: &CheckedScene, camera: &Camera, strands: &Followers) -> Self {
        // Wind from left to right; without wind the way the hair points, where most of it points one way.
        let wind = scene.air.as_ref().map_or(DVec3::ZERO, |air| DVec3::from_array(air.wind));
        let (sum, count) = strands.strands().fold((DVec3::ZERO, 0.0), |(sum, count), strand| {
            let [root, .., tip] = strand.points else { return (sum, count) };
            (sum + (point(*tip) - point(*root)).normalize_or_zero(), count + 1.0)
        });
        let level = |v: DVec3| DVec3::new(v.x, 0.0, v.z);
        let points_to = Some(level(sum)).filter(|v| v.length() > 0.05 * count);
        let right = level(wind).try_normalize().or(points_to.map(DVec3::normalize)).unwrap_or(DVec3::X);
        let side = right.cross(DVec3::Y);
        // Half way toward a three-quarter view, and 12° above.
        let mut fit = Fit::new((side + 0.42 * right + 0.26 * DVec3::Y).normalize(), camera);
        let table = scene.air.as_ref().map_or(vec![(0.0, [0.0; 3])], CheckedAir::wind_table);
        let lasts = |k: usize| table.get(k + 1).map(|next| next.0 - table[k].0);
        let winds: Vec<_> = (0..table.len()).map(|k| (DVec3::from_array(table[k].1), lasts(k))).collect();
        let unknown = Fibre::default();
        for strand in strands.strands() {
            where_hair_goes(&strand, &unknown, &winds, scene, |x, margin| fit.add(x, margin));
        }
        for x in patch_ends(scene).chain(scene.bodies.iter().flat_map(where_body_goes)) {
            fit.add(x, 0.0);
        }
        fit.view(camera)
    }

    /// Unit vectors to the picture's right and top, and from what the camera looks at to the camera.
    #[must_use]
    pub fn axes(&self) -> [DVec3; 3] {
        let back = (self.eye - self.target).normalize();
        let right = self.up().cross(back).normalize();
        [right, back.cross(right), back]
    }

    fn up(&self) -> DVec3 {
        let forward = (self.target - self.eye).normalize_or(DVec3::NEG_Z);
        if forward.cross(DVec3::Y).length() > 1e-3 { DVec3::Y } else { DVec3::NEG_Z }
    }

    /// Matrix from the world \[m\] to clip space, where depth is 0 to 1. `depths`: of the nearest and the farthest that
    /// is seen \[m\].
    #[must_use]
    pub fn clip_from_world(&self, depths: [f64; 2]) -> DMat4 {
        let aspect = f64::from(self.width) / f64::from(self.height);
        proj::directx::perspective(self.fov.to_radians(), aspect, depths[0], depths[1])
            * look_at_mat4(self.eye, self.target, self.up())
    }

    /// The place of a point of the world in the picture \[px\], from the upper left; `None` behind the camera.
    #[must_use]
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        // The near and far distances do not move the point in the picture.
        let clip = self.clip_from_world([1.0, 2.0]) * point.extend(1.0);
        (clip.w > 0.0).then(|| {
            let at = clip.truncate() / clip.w;
            [(0.5 + 0.5 * at.x) * f64::from(self.width), (0.5 - 0.5 * at.y) * f64::from(self.height)]
        })
    }

    /// The uniform buffer of the shaders, for hair within this box \[m\].
    pub(super) fn uniform(&self, low: DVec3, high: DVec3, hairs: u32, samples: u32) -> shader::View {
        let [right, up, back] = self.axes();
        let forward = -back;
        let drawn = [FINE * self.width, FINE * self.height].map(f64::from);
        let pixel = 2.0 * (0.5 * self.fov.to_radians()).tan() / drawn[1];
        let far: Vec<f64> = corners(low, high).iter().map(|x| x.distance(self.eye)).collect();
        let (nearest, farthest) =
            far.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &d| (low.min(d), high.max(d)));
        // Whatever the target, hair is between the two, with room for the patch and the air about it.
        let before = self.eye.distance(self.eye.clamp(low, high));
        let depths = [(0.1 * before).max(1e-3 * farthest), 20.0 * farthest];
        // The key stands above the camera's left shoulder, the sky straight above and a little in front.
        let key = (-0.45 * right + 0.85 * up - 0.40 * forward).normalize();
        let sky = (0.25 * right + 0.9 * DVec3::Y - 0.5 * forward).normalize();
        shader::View {
            clip_from_world: self.clip_from_world(depths).as_mat4().to_cols_array_2d(),
            eye: vec4(self.eye, pixel),
            right: vec4(right, nearest),
            up: vec4(up, 1.0 / (farthest - nearest).max(1e-9)),
            size: drawn.map(|size| size as f32),
            hairs,
            samples,
            lights: [light(key, [2.7, 2.55, 2.35], low, high), light(sky, [0.50, 0.58, 0.70], low, high)],
        }
    }
}

/// The room that a film of this strand may fill, as balls about points: its shape at the start, and its root and tip as
/// gravity and each wind, and the time that it lasts \[s\], take them, and as eddies swing the tip, all where its
/// keyframes carry them. `unknown`: its fibres where the scene says nothing of them.
fn where_hair_goes(
    strand: &Strand<'_>,
    unknown: &Fibre,
    winds: &[(DVec3, Option<f64>)],
    scene: &CheckedScene,
    mut reaches: impl FnMut(DVec3, f64),
) {
    let [root, .., tip] = strand.points else { return };
    let hair = strand.hair.and_then(|index| scene.hair.get(index));
    let known = hair.map_or(unknown, |hair| &hair.fibre);
    let fibre = Fibre {
        radius: strand.radius.map_or(known.radius, f64::from),
        fibres_per_strand: strand.fibres.map_or(known.fibres_per_strand, f64::from),
        ..*known
    };
    let (root, chord) = (point(*root), point(*tip) - point(*root));
    let axis = chord.normalize_or_zero();
    let length: f64 = strand.points.windows(2).map(|pair| point(pair[0]).distance(point(pair[1]))).sum();
    // A curl is as long as its axis at first; the wind draws it out about half way.
    let drawn_out = (length * chord.length()).sqrt();
    let curl =
        strand.points.iter().map(|x| (point(*x) - root).reject_from_normalized(axis).length()).fold(0.0, f64::max);
    // Hairs wave about their strands, and strands about where they hang.
    let margin = 0.04 * length;
    let segments = strand.points.len() - 1;
    // How far hair gets toward where a wind has it, within the time that the wind lasts: it falls freely or goes with
    // the air.
    let gravity = DVec3::from_array(scene.gravity);
    let part = |wind: DVec3, time: f64| (0.5 * gravity.length() * time * time).max(wind.length() * time) / length;
    let ways: Vec<_> = winds
        .iter()
        .map(|&(wind, lasts)| {
            (streaming(&fibre, length, segments, wind, scene), lasts.map_or(1.0, |time| part(wind, time).min(1.0)))
        })
        .collect();
    let down = gravity.normalize_or_zero();
    let swing = 2.0 * swing(length, scene) / length;
    for_each_pose(hair, |moved| {
        strand.points.iter().for_each(|x| reaches(moved(point(*x)), margin));
        let root = moved(root);
        let start = (moved(point(*tip)) - root).normalize_or_zero();
        for (way, part) in &ways {
            let streams = start.lerp(way.unwrap_or(start), *part).normalize_or(start);
            // Before the wind has it, and in the lee of others, hair hangs lower.
            let lower = (streams + 0.12 * down).normalize_or(start);
            let between = (start + streams).normalize_or(start);
            for (way, far) in [(streams, drawn_out), (lower, drawn_out), (between, 0.9 * drawn_out)] {
                reaches(root + far * way, curl + margin);
            }
            let side = streams.cross(DVec3::Y).normalize_or(streams.any_orthonormal_vector());
            for across in [side, -side, side.cross(streams)] {
                reaches(root + drawn_out * (streams + swing * across).normalize_or(start), curl + margin);
            }
        }
    });
}

/// Calls with what moves a point from where it is at the start \[m\] to where the hair's motion has it, at the start
/// and at each keyframe.
fn for_each_pose(hair: Option<&Hair>, mut pose: impl FnMut(&dyn Fn(DVec3) -> DVec3)) {
    let Some(hair) = hair else { return pose(&|x| x) };
    let center = hair.center();
    let Pose { translation: by, rotation: turn } = hair.motion.at(0.0);
    for time in std::iter::once(0.0).chain(hair.motion.keyframes.iter().map(|keyframe| keyframe.time)) {
        pose(&|x| hair.motion.place(center, center + turn.conjugate() * (x - center - by), time));
    }
}

/// The ends of every patch at the start and at its keyframes.
fn patch_ends(scene: &CheckedScene) -> impl Iterator<Item = DVec3> + '_ {
    patches(scene).flat_map(|(_, hair, patch)| {
        let times = std::iter::once(0.0).chain(hair.motion.keyframes.iter().map(|keyframe| keyframe.time));
        let ends: Vec<DVec3> = ends(&patch).collect();
        times.flat_map(move |time| ends.clone().into_iter().map(move |x| hair.motion.place(hair.center(), x, time)))
    })
}

/// Corners of the boxes about a body at its start and at its keyframes.
fn where_body_goes(body: &CheckedBody) -> impl Iterator<Item = DVec3> + '_ {
    let times = std::iter::once(0.0).chain(body.motion.keyframes.iter().map(|keyframe| keyframe.time));
    times.flat_map(|time| {
        let [low, high] = body.at(time).bounds();
        corners(low, high)
    })
}

/// Direction of a strand at rest in the wind: its weight across itself is the drag across itself, with the drag model's
/// C_d = 1 + 10 Re^(-2/3) on its fibres, or C_d = 1 on its air particles. Eddies of intensity I add I² to the wind's
/// square. Strands shelter each other, so that one feels about half of it. `None` where neither wind nor weight pulls.
fn streaming(fibre: &Fibre, length: f64, segments: usize, wind: DVec3, scene: &CheckedScene) -> Option<DVec3> {
    let gravity = DVec3::from_array(scene.gravity);
    let weight = gravity.length()
        * match fibre.point_mass {
            Some(mass) => mass * segments as f64 / length,
            None => PI * fibre.radius.powi(2) * fibre.density * fibre.fibres_per_strand,
        };
    let speed = wind.length();
    let drag = scene.air.as_ref().map_or(0.0, |air| {
        let reynolds = (2.0 * fibre.radius * speed / air.kinematic_viscosity).max(1e-9);
        let width = match scene.interaction.model {
            Model::Particles => air.spacing,
            Model::TwoWay | Model::Drag => {
                2.0 * fibre.radius * fibre.fibres_per_strand * (1.0 + 10.0 * reynolds.powf(-2.0 / 3.0))
            }
            Model::None => 0.0,
        };
        let eddies = strongest_band(scene).map_or(0.0, |band| band.intensity.powi(2));
        0.5 * 0.5 * air.rest_density * width * speed * speed * (1.0 + eddies)
    });
    if weight <= 0.0 && drag <= 0.0 {
        return None;
    }
    let (down, along) = (gravity.normalize_or_zero(), wind.normalize_or_zero());
    // drag sin² = weight cos, of the angle between strand and wind.
    let x = weight / drag;
    let cos = if drag > 0.0 { 0.5 * ((x * x + 4.0).sqrt() - x).max(0.0) } else { 0.0 };
    (cos * along + (1.0 - cos * cos).max(0.0).sqrt() * down).try_normalize()
}

/// Rms displacement of a tip to one side of its stream \[m\], in the strongest band of eddies: along its length L a
/// strand meets L / s eddies of scale s, and each turns it aside by I s / √8, which add up as a random walk does.
/// Measured 1.0 to 1.1 times this, for I = 1.5, L = 120 mm, and s of 6, 12 and 18 mm.
fn swing(length: f64, scene: &CheckedScene) -> f64 {
    strongest_band(scene).map_or(0.0, |band| band.intensity * (band.scale * length / 8.0).sqrt())
}

/// The band whose eddies swing hair the most.
fn strongest_band(scene: &CheckedScene) -> Option<&Band> {
    let bands = scene.turbulence.bands.iter().filter(|band| band.strength > 0.0);
    let swings = |band: &Band| band.intensity * band.scale.sqrt();
    bands.max_by(|a, b| swings(a).total_cmp(&swings(b)))
}

/// The camera in a direction from what it is to see, nearest to that.
struct Fit {
    /// Unit vectors to the picture's right and top and to the camera.
    axes: [DVec3; 3],
    /// Directions across the picture's four edges, each as seen from within it, and to the camera and from it.
    directions: [DVec3; 6],
    /// Farthest along each of them that something reaches \[m\].
    farthest: [f64; 6],
    /// Slopes of the picture's right and upper edges against the way from the camera.
    slopes: [f64; 2],
}

impl Fit {
    fn new(away: DVec3, camera: &Camera) -> Self {
        let right = DVec3::Y.cross(away).normalize_or(DVec3::X);
        let up = away.cross(right);
        let slope = FILLED * (0.5 * camera.fov.to_radians()).tan();
        let slopes = [slope * f64::from(camera.width) / f64::from(camera.height), slope];
        let [x, y] = slopes.map(|slope| slope * away);
        let directions = [x + right, x - right, y + up, y - up, away, -away];
        Self { axes: [right, up, away], directions, farthest: [f64::NEG_INFINITY; 6], slopes }
    }

    /// Sees the ball about `x` too.
    fn add(&mut self, x: DVec3, radius: f64) {
        for (farthest, direction) in self.farthest.iter_mut().zip(self.directions) {
            *farthest = farthest.max(x.dot(direction) + radius * direction.length());
        }
    }

    fn view(&self, camera: &Camera) -> View {
        let ([right, up, away], [a, b, c, d, near, far]) = (self.axes, self.farthest);
        // On each axis of the picture the eye is where both edges touch. Not within the hair, however small the scene.
        let z = (0.5 * (a + b) / self.slopes[0]).max(0.5 * (c + d) / self.slopes[1]).max(near + 1e-3);
        let eye = 0.5 * (a - b) * right + 0.5 * (c - d) * up + z * away;
        let target = eye - (z - 0.5 * (near - far)).max(1e-3) * away;
        View { eye, target, fov: camera.fov, width: camera.width, height: camera.height }
    }
}

fn point(x: [f32; 3]) -> DVec3 {
    Vec3::from_array(x).as_dvec3()
}

fn corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// A light from `toward` whose grid holds the box.
fn light(toward: DVec3, colour: [f32; 3], low: DVec3, high: DVec3) -> Light {
    // Left-handed: z grows with the way of the light.
    let turned = look_to_mat4(DVec3::ZERO, -toward, if toward.y.abs() < 0.99 { DVec3::Y } else { DVec3::X });
    let inside = corners(low, high).map(|x| turned.transform_point3(x));
    let (mut a, mut b) = (inside[0], inside[0]);
    for x in inside {
        (a, b) = (a.min(x), b.max(x));
    }
    let cells = f64::from(GRID);
    let cell = (b - a).max(DVec3::splat(1e-6)) / cells;
    let grid = DMat4::from_scale(1.0 / cell) * DMat4::from_translation(-a) * turned;
    let [r, g, b] = colour;
    Light {
        grid_from_world: grid.as_mat4().to_cols_array_2d(),
        toward: vec4(toward, cell.x * cell.y),
        colour: [r, g, b, 0.0],
    }
}

fn vec4(xyz: DVec3, w: f64) -> [f32; 4] {
    Vec4::from((xyz.as_vec3(), w as f32)).to_array()
}
