//! The camera of a picture, and the lights.

use std::f64::consts::{PI, TAU};

use glam::dcamera::lh::view::look_to_mat4;
use glam::dcamera::rh::{proj, view::look_at_mat4};
use glam::{DMat4, DVec3, Vec3, Vec4};
use windswept_scene::{Body, Camera, Drawn, Hair, LookAt, Model, Patch, Roots, Scene};

use windswept_shaders::pictures::common::{self as shader, FINE, GRID, Light};

use super::patch::ends;
use crate::ExportError;

/// Share of the picture that the automatic camera fills.
const FILLED: f64 = 0.95;

/// A camera in the world, and the size of its picture. Where the scene does not say where it stands, it sees all of the
/// hair as it streams in the wind: from the side, wind from the left, a little from above and downwind.
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
    /// The scene's camera, the same for every frame of a film. `points` \[m\] are framed where the scene says neither where
    /// it stands nor where hair grows.
    ///
    /// # Errors
    /// [`ExportError::Picture`] when the camera stands where it looks.
    pub fn new(scene: &Scene, points: &[[f32; 3]]) -> Result<Self, ExportError> {
        let camera = &scene.camera;
        let Some(LookAt { eye, target }) = camera.look_at else {
            return Ok(Self::automatic(scene, points));
        };
        let (eye, target) = (DVec3::from_array(eye), DVec3::from_array(target));
        if eye.distance(target) < 1e-9 {
            return Err(ExportError::Picture {
                problem: "camera.eye and camera.target are the same point: expected two".into(),
            });
        }
        Ok(Self { eye, target, fov: camera.fov, width: camera.width, height: camera.height })
    }

    fn automatic(scene: &Scene, points: &[[f32; 3]]) -> Self {
        let wind = scene.air.as_ref().map_or(DVec3::ZERO, |air| DVec3::from_array(air.wind));
        let mut reach = Vec::new();
        for (hair, drawn, patch) in scene.hair.iter().filter_map(on_patch) {
            let goes = where_hair_goes(hair, drawn, patch, wind, scene);
            let moved = hair.motion.keyframes.iter().map(|keyframe| keyframe.pose().0);
            reach.extend(std::iter::once(DVec3::ZERO).chain(moved).flat_map(|by| goes.iter().map(move |x| *x + by)));
        }
        // Of strands from elsewhere it is known where they are.
        if reach.is_empty() || scene.hair.iter().any(|hair| on_patch(hair).is_none()) {
            reach.extend(points.iter().map(|p| Vec3::from_array(*p).as_dvec3()));
        }
        reach.extend(scene.bodies.iter().flat_map(where_body_goes));
        // Wind from left to right; without wind the way the hair points.
        let level = |v: DVec3| DVec3::new(v.x, 0.0, v.z).normalize_or_zero();
        let directions = scene.hair.iter().filter_map(on_patch).map(|(_, _, patch)| DVec3::from_array(patch.direction));
        let right = [wind].into_iter().chain(directions).map(level).find(|v| *v != DVec3::ZERO).unwrap_or(DVec3::X);
        let side = right.cross(DVec3::Y);
        // Half way toward a three-quarter view, and 12° above.
        let away = (side + 0.42 * right + 0.26 * DVec3::Y).normalize();
        fit(&reach, away, &scene.camera)
    }

    fn up(&self) -> DVec3 {
        let forward = (self.target - self.eye).normalize_or(DVec3::NEG_Z);
        if forward.cross(DVec3::Y).length() > 1e-3 { DVec3::Y } else { DVec3::NEG_Z }
    }

    /// `depths`: of the nearest and the farthest that is seen \[m\].
    fn clip_from_world(&self, depths: [f64; 2]) -> DMat4 {
        let aspect = f64::from(self.width) / f64::from(self.height);
        proj::directx::perspective(self.fov.to_radians(), aspect, depths[0], depths[1])
            * look_at_mat4(self.eye, self.target, self.up())
    }

    /// The place of a point of the world in the picture \[px\], from the upper left; `None` behind the camera.
    #[must_use]
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        // What is near or far does not move it in the picture.
        let clip = self.clip_from_world([1.0, 2.0]) * point.extend(1.0);
        (clip.w > 0.0).then(|| {
            let at = clip.truncate() / clip.w;
            [(0.5 + 0.5 * at.x) * f64::from(self.width), (0.5 - 0.5 * at.y) * f64::from(self.height)]
        })
    }

    /// The uniform buffer of the shaders, for hair within this box \[m\].
    pub(super) fn uniform(&self, low: DVec3, high: DVec3, hairs: u32, samples: u32) -> shader::View {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up()).normalize();
        let up = right.cross(forward);
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

/// A group whose strands are rooted on a patch, and what they are drawn by.
fn on_patch(hair: &Hair) -> Option<(&Hair, &Drawn, &Patch)> {
    let drawn = hair.drawn()?;
    match &drawn.roots {
        Roots::Patch(patch) => Some((hair, drawn, patch)),
        Roots::Mesh(_) => None,
    }
}

/// The region that a film of this hair may cover: its patch, and its tips between where it points and where the wind and gravity
/// take it.
fn where_hair_goes(hair: &Hair, drawn: &Drawn, patch: &Patch, wind: DVec3, scene: &Scene) -> Vec<DVec3> {
    let (center, radius) = (hair.center(), patch.radius);
    // A helix has its root on itself, not on its axis.
    let curl = drawn.curl.map_or(0.0, |curl| 2.0 * curl.radius);
    // A curl is as long as its axis at first; the wind draws it out about half way.
    let curled = drawn.curl.map_or(1.0, |curl| curl.pitch / (TAU * curl.radius).hypot(curl.pitch));
    let (short, length) = (drawn.length * curled, drawn.length * curled.sqrt());
    let start = DVec3::from_array(patch.direction);
    let streams = streaming(hair, drawn, wind, scene).unwrap_or(start);
    let between = (start + streams).normalize_or(start);
    // Before the wind has it, and in the lee of others, hair hangs lower.
    let lower = (streams + 0.12 * DVec3::from_array(scene.gravity).normalize_or_zero()).normalize_or(start);
    let mut all: Vec<DVec3> = ends(patch).collect();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let wide = radius + curl;
        all.extend([center + wide * axis, center - wide * axis]);
        for (way, far) in [(streams, length), (lower, length), (between, 0.9 * length), (start, short)] {
            let tip = center + far * way;
            let spread = 0.9 * radius + curl + 0.04 * length;
            all.extend([tip + spread * axis, tip - spread * axis]);
        }
    }
    all
}

/// Corners of the boxes about a body at its start and at its keyframes.
fn where_body_goes(body: &Body) -> impl Iterator<Item = DVec3> + '_ {
    let times = std::iter::once(0.0).chain(body.motion.keyframes.iter().map(|keyframe| keyframe.time));
    times.flat_map(|time| {
        let [low, high] = body.at(time).bounds();
        corners(low, high)
    })
}

/// Direction of a strand at rest in the wind: its weight across itself is the drag across itself, with the drag model's
/// C_d = 1 + 10 Re^(-2/3) on its fibres, or C_d = 1 on its parcels of air. Strands shelter each other, so that one feels
/// about half of it. `None` where neither wind nor weight pulls.
fn streaming(hair: &Hair, drawn: &Drawn, wind: DVec3, scene: &Scene) -> Option<DVec3> {
    let gravity = DVec3::from_array(scene.gravity);
    let weight = gravity.length()
        * match hair.fibre.point_mass {
            Some(mass) => mass * f64::from(drawn.points - 1) / drawn.length,
            None => PI * hair.fibre.radius.powi(2) * hair.fibre.density * hair.fibre.fibres_per_strand,
        };
    let speed = wind.length();
    let drag = scene.air.as_ref().map_or(0.0, |air| {
        let reynolds = (2.0 * hair.fibre.radius * speed / air.kinematic_viscosity).max(1e-9);
        let width = match scene.interaction.model {
            Model::Particles => (air.particle_mass / air.rest_density).cbrt(),
            Model::TwoWay | Model::Drag => {
                2.0 * hair.fibre.radius * hair.fibre.fibres_per_strand * (1.0 + 10.0 * reynolds.powf(-2.0 / 3.0))
            }
            Model::None => 0.0,
        };
        0.5 * 0.5 * air.rest_density * width * speed * speed
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

/// The camera in direction `away` from the points that shows them all.
fn fit(points: &[DVec3], away: DVec3, camera: &Camera) -> View {
    let aspect = f64::from(camera.width) / f64::from(camera.height);
    let right = DVec3::Y.cross(away).normalize_or(DVec3::X);
    let up = away.cross(right);
    let slope = FILLED * (0.5 * camera.fov.to_radians()).tan();
    // The nearest eye on either side of the points for each axis of the picture: |offset| <= slope * depth for all.
    let extent = |axis: DVec3, slope: f64| {
        let over = points.iter().map(|p| p.dot(axis) + slope * p.dot(away)).fold(f64::NEG_INFINITY, f64::max);
        let under = points.iter().map(|p| p.dot(axis) - slope * p.dot(away)).fold(f64::INFINITY, f64::min);
        (0.5 * (over + under), 0.5 * (over - under) / slope)
    };
    let ((x, wide), (y, high)) = (extent(right, slope * aspect), extent(up, slope));
    let nearest = points.iter().map(|p| p.dot(away)).fold(f64::NEG_INFINITY, f64::max);
    let middle = points.iter().map(|p| p.dot(away)).sum::<f64>() / points.len().max(1) as f64;
    // Not within the hair, however small the scene.
    let z = wide.max(high).max(nearest + 1e-3);
    let eye = x * right + y * up + z * away;
    let target = eye - (z - middle).max(1e-3) * away;
    View { eye, target, fov: camera.fov, width: camera.width, height: camera.height }
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
