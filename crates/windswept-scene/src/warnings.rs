//! Warnings of scenes that are valid, but may not do what their user expects.

mod unread;
pub(crate) use unread::of_unread;

use std::fmt;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{
    body::{CheckedBody, CheckedShape, blocked},
    box_fit,
    error::spelled,
    force::ForceField,
    initial::AirParticles,
    limits::MAX_REPEATS,
    scene::{Bounds, CheckedAir, Fibre, FluidSolver, Law, Model, Moduli, SceneValues, Stiffness},
    solid,
    strands::{End, Strands},
    units::with_scale,
};

/// Kernel radii in particle spacings between which the density constraint was tried; the paper's is 1.92.
const TRIED: std::ops::RangeInclusive<f64> = 1.5..=3.0;
/// Scale of the smallest eddies that particles carry \[particle spacings\]: smaller ones are passed at the particles'
/// Nyquist wave number with a gain above 7.5 %.
const SMALLEST_EDDY: f64 = 1.03;

/// Longest side of a mesh below which it is likely that its scale is wrong \[m\].
const SMALLEST_MESH: f64 = 1e-3;

/// Places of a segment, at most, that are asked whether they are inside a body.
const STEPS_ALONG: f64 = 32.0;

/// Part of a mesh's surface that may cover holes without a warning: the neck of a head is 5 %.
const MUCH_COVERED: f64 = 0.1;

/// How far a grid may put a hundredth of a mesh's surface off without a warning \[m\]. The default spacing of 2 mm is
/// off by less on a head with ears (h²/(4 R): 0.22 mm where the radius of curvature R is 5 mm) and at edges.
const COARSE: f64 = 5e-4;

/// Part of its shortest segment by which a strand's places may be rounded without a warning.
const MUCH_ROUNDED: f64 = 0.02;

/// Distance from a body up to which a root is on it \[m\].
const ROOTED: f64 = 5e-3;

/// Density of air over that of hair from which what is left out is said: a hundredth of the weight.
const MUCH_BUOYANCY: f64 = 0.01;

/// Radii \[m\] and Young's moduli \[Pa\] of fibres without a warning: those of wool, hair and bristles, and a decade
/// beyond on either side.
const RADII: std::ops::RangeInclusive<f64> = 1e-6..=2e-3;
const MODULI: std::ops::RangeInclusive<f64> = 1e7..=1e11;
/// Longest hair without a warning \[m\].
const LONGEST: f64 = 10.0;
/// Fastest wind without a warning \[m/s\]: beyond a Mach number of 0.3 air is compressed.
const FASTEST: f64 = 100.0;

/// Part of the box's cross-section that bodies may block without a warning.
const MUCH_BLOCKED: f64 = 0.3;

/// Way of air past a round body in a step for which its density stays even \[radii of the body\], and past any
/// \[particle spacings\].
const WAY_BY_RADIUS: f64 = 0.25;
const WAY: f64 = 0.9;

/// Largest speed of eddies, over the wind's, at which steps of nearly a spacing were found right
/// (`docs/decisions/air.md`).
const WEAK: f64 = 0.3;

/// A warning: a scene is valid, or a run goes on, but it may not do what its user expects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warning {
    /// Kind of the warning, for programs: `unread_key`, `strand_reset`.
    pub code: String,
    /// Key or table of the scene that it is about; empty where it is about none.
    pub key: String,
    /// The warning in words.
    pub text: String,
    /// How often its cause acted in the run; 0 for a warning about the scene.
    pub count: u64,
}

impl Warning {
    /// A warning about the scene. It may quote names of a stranger's file: control characters in them are spelled.
    pub fn new(code: &str, key: &str, text: impl AsRef<str>) -> Self {
        let [key, text] = [key, text.as_ref()].map(|words| spelled(words).into_owned());
        Self { code: code.to_owned(), key, text, count: 0 }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { code, key, text, count } = self;
        match (key.is_empty(), count) {
            (_, 1..) => write!(f, "{code}: {count} ({text})"),
            (true, 0) => write!(f, "{text}"),
            (false, 0) => write!(f, "{key}: {text}"),
        }
    }
}

/// Warnings about step, wind, particles and bands.
pub(crate) fn of_air(scene: &SceneValues, air: &CheckedAir, particles: &AirParticles) -> Vec<Warning> {
    let mut warnings = Vec::from_iter(of_wind(scene, air));
    let spacing = particles.volume.cbrt();
    for jet in scene.forces.iter().filter(|force| force.field == ForceField::Jet && air.is_still()) {
        warnings.push(Warning::new(
            "jet_without_wind",
            &format!("force.{}", jet.name),
            "without a mean wind the air that a jet blows out of the box comes in again on the other side",
        ));
    }
    let ratio = air.kernel_radius / spacing;
    if !TRIED.contains(&ratio) {
        let (least, most) = (TRIED.start(), TRIED.end());
        let text = format!("{ratio:.2} particle spacings of {spacing:.2e} m; {least:.1} to {most:.1} are tried");
        warnings.push(Warning::new("kernel_radius", "air.kernel_radius", text));
    }
    for band in &scene.turbulence.bands {
        let smallest = SMALLEST_EDDY * spacing;
        if band.scale < smallest {
            let text = format!(
                "a scale of {} m is below that which particles {spacing:.2e} m apart can carry, {smallest:.2e} m",
                band.scale
            );
            warnings.push(Warning::new("small_eddies", "turbulence", text));
        }
    }
    warnings.extend(of_eddies(scene, air));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if (air.blows(axis, 1.0) || air.blows(axis, -1.0)) && air.fringe > 0.5 * particles.size[axis] {
            let side = particles.size[axis];
            let text = format!("{} m take more than half of the box in {name}, {side} m", air.fringe);
            warnings.push(Warning::new("thick_fringe", "air.fringe", text));
        }
    }
    warnings
}

/// A warning where the fastest band would be strengthened to a speed that steps do not resolve.
fn of_eddies(scene: &SceneValues, air: &CheckedAir) -> Option<Warning> {
    if scene.turbulence.law == Law::Published {
        return None;
    }
    let strengthened = scene.turbulence.bands.iter().filter(|band| band.strength > 0.0);
    let band = strengthened.max_by(|a, b| a.intensity.total_cmp(&b.intensity))?;
    let (wanted, most) = (band.intensity * scene.turbulence.speed, scene.largest_eddy_speed(band, scene.time.substeps));
    if wanted <= most {
        return None;
    }
    let needed = (wanted * scene.time.step / air.kernel_radius).ceil();
    let what = if needed <= f64::from(MAX_REPEATS) {
        format!("take time.substeps = {needed}, or a smaller intensity")
    } else {
        "take a smaller intensity".to_owned()
    };
    let text = format!(
        "eddies of scale {} m are strengthened up to {most:.3} m/s, not to {wanted:.3} m/s, at which they would go farther than \
         air.kernel_radius, {} m, in a substep: {what}",
        band.scale, air.kernel_radius
    );
    Some(Warning::new("fast_eddies", "turbulence", text))
}

/// A warning where the mean wind and a force field carry air farther in a substep than its pressure keeps up with.
pub(crate) fn of_wind(scene: &SceneValues, air: &CheckedAir) -> Option<Warning> {
    let way = scene.largest_wind() * scene.time.step / air.spacing;
    let most = farthest(scene);
    if way <= most * f64::from(scene.time.substeps) {
        return None;
    }
    let needed = (way / most).ceil();
    let what = if needed <= f64::from(MAX_REPEATS) {
        format!("take time.substeps = {needed}")
    } else {
        format!("more substeps than there may be, {MAX_REPEATS}, would do")
    };
    let text = format!(
        "air moves {:.2} particle spacings in a substep, where its pressure keeps up with at most {most}: {what}",
        way / f64::from(scene.time.substeps)
    );
    Some(Warning::new("fast_wind", "air.wind", text))
}

/// Way of the air in a step for which its pressure is right \[particle spacings\]. The coarse grid doubles it where
/// eddies are weak.
fn farthest(scene: &SceneValues) -> f64 {
    match scene.fluid.solver {
        FluidSolver::Divergence if scene.has_coarse_grid() && has_weak_eddies(scene) => WAY,
        FluidSolver::Divergence => 0.45,
        FluidSolver::Pbf => 1.0,
    }
}

/// Whether nothing but hair stirs air by more than [`WEAK`] of the largest wind.
fn has_weak_eddies(scene: &SceneValues) -> bool {
    let turbulence = &scene.turbulence;
    let bands: f64 = turbulence.bands.iter().map(|band| band.intensity * turbulence.speed).sum();
    let stirred = !scene.forces.is_empty() || scene.air.as_ref().is_some_and(|air| air.inflow.is_some());
    !stirred && turbulence.law == Law::Band && bands <= WEAK * scene.largest_wind()
}

/// A warning for each force field that moves nothing: a point's among air that cannot be compressed, and one that
/// neither air nor hair ever comes near to; `air` is where particles are.
pub(crate) fn of_fields(scene: &SceneValues, hair: &Strands, air: &AirParticles) -> Vec<Warning> {
    if scene.interaction.model == Model::None {
        return Vec::new();
    }
    let mut places = vec![box_fit::of_hair(scene, hair)];
    if !air.positions.is_empty() {
        places.push([air.min, air.min + air.size]);
    }
    let who = if air.positions.is_empty() { "hair never gets" } else { "neither air nor hair ever gets" };
    let pressed = scene.interaction.model.has_air() && scene.fluid.solver == FluidSolver::Divergence;
    let each = scene.forces.iter().filter_map(|force| {
        let why = if !places.iter().any(|place| force.reaches(*place)) {
            format!("{who} within its reach")
        } else if pressed && force.field == ForceField::Point {
            "a point's wind would compress the air, whose pressure takes it up; only hair outside the box feels it"
                .into()
        } else {
            return None;
        };
        Some(Warning::new("idle_force", &format!("force.{}", force.name), format!("does nothing: {why}")))
    });
    each.collect()
}

/// A warning where places in the world, which films, pictures and arrays have in f32, are too coarse for the segments.
pub(crate) fn of_place(hair: &Strands) -> Option<Warning> {
    let far = hair.positions.iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
    // Largest rounding error of a coordinate: half a unit in its last place.
    let rounding = 0.5 * f64::from(f32::EPSILON) * far;
    let shortest = hair.rest_length.iter().copied().fold(f64::INFINITY, f64::min);
    (rounding > MUCH_ROUNDED * shortest).then(|| {
        let text = format!(
            "begins {far:.3e} m from the origin, where films, pictures and arrays round places to {rounding:.1e} m, and the shortest \
             segment has {shortest:.1e} m: put the scene nearer to the origin"
        );
        Warning::new("far_from_origin", "hair", text)
    })
}

/// Warnings about where the hair stands in its box.
pub(crate) fn of_hair(hair: &Strands, air: &AirParticles, wind: DVec3) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let local = hair.positions.iter().map(|x| *x - air.min);
    let outside = local.filter(|x| x.cmplt(DVec3::ZERO).any() || x.cmpge(air.size).any()).count();
    if outside > 0 {
        let all = hair.positions.len();
        let text =
            format!("{outside} of {all} hair points start outside the box of air, where the mean wind drags them");
        warnings.push(Warning::new("starts_outside_box", "air.box", text));
    }
    let low = hair.roots().fold(DVec3::INFINITY, DVec3::min);
    let high = hair.roots().fold(DVec3::NEG_INFINITY, DVec3::max);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let across = wind != DVec3::ZERO && wind[axis].abs() < 0.9 * wind.length();
        let part = (high - low)[axis] / air.size[axis];
        if across && part > 0.5 {
            let text = format!(
                "the roots span {:.0} % of the box in {name}: the air beside the hair is sped up",
                100.0 * part
            );
            warnings.push(Warning::new("narrow_box", "air.box", text));
        }
    }
    warnings
}

/// A warning about hair that starts inside bodies, by more than rounding and grids make of a surface: points, and
/// segments whose two points are outside.
pub(crate) fn of_bodies(hair: &Strands, bodies: &[CheckedShape]) -> Option<Warning> {
    let slack: Vec<f64> = bodies.iter().map(CheckedShape::slack).collect();
    let bodies = || bodies.iter().zip(&slack);
    let inside = |x: &DVec3| bodies().any(|(body, slack)| body.signed_distance(*x).0 < -slack);
    let n = hair.positions.iter().filter(|x| inside(x)).count();
    let ends = (0..hair.len()).flat_map(|s| hair.positions[hair.points(s)].windows(2));
    let crosses = |ends: &&[DVec3]| bodies().any(|(body, slack)| crosses(body, *slack, [ends[0], ends[1]]));
    let segments = ends.clone().filter(|ends| !ends.iter().any(inside)).filter(|ends| crosses(ends)).count();
    let points = (n > 0).then(|| format!("{n} of {} hair points", hair.positions.len()));
    let segments = (segments > 0).then(|| format!("{segments} of {} segments between points outside", ends.count()));
    let what: Vec<String> = points.into_iter().chain(segments).collect();
    (!what.is_empty()).then(|| {
        let text = format!("{} start inside bodies, which push them out", what.join(" and "));
        Warning::new("starts_inside_bodies", "hair", text)
    })
}

/// Warnings about roots that are far from the body whose motion they take part in, and about hair that grows on a body
/// that moves, and rests.
pub(crate) fn of_roots(scene: &SceneValues, hair: &Strands, bodies: &[CheckedShape]) -> Vec<Warning> {
    let each = scene.hair.iter().enumerate().filter_map(|(group, own)| {
        let on = |(body, _): &(&CheckedBody, _)| match own.body() {
            Some(name) => body.name == name,
            None => !body.motion.keyframes.is_empty() && own.motion.keyframes.is_empty(),
        };
        let roots = || hair.roots().zip(&hair.group).filter(|(_, of)| **of as usize == group).map(|(root, _)| root);
        let distances = |shape: &CheckedShape| roots().map(|root| shape.signed_distance(root).0.abs()).collect();
        scene.bodies.iter().zip(bodies).filter(on).find_map(|(body, shape)| {
            let far: Vec<f64> = distances(shape);
            let all = far.len();
            let away = far.iter().filter(|far| **far > ROOTED).count();
            let name = &body.name;
            match own.body() {
                Some(_) if away > 0 && own.root != End::Free => {
                    let most = 1e3 * far.iter().copied().fold(0.0, f64::max);
                    let text = format!(
                        "{away} of {all} roots are farther than {} mm from body.{name}, which they move with; the farthest {most:.1} mm",
                        1e3 * ROOTED
                    );
                    Some(Warning::new("far_from_body", &scene.called(group), text))
                }
                None if own.root != End::Free && 2 * away < all => {
                    let text = format!("the roots rest on body.{name}, which moves: body = \"{name}\" makes them go with it");
                    Some(Warning::new("left_by_body", &scene.called(group), text))
                }
                _ => None,
            }
        })
    });
    each.collect()
}

/// Warnings of hair and winds that there are not, often by another unit, and of a run without a step.
pub(crate) fn of_numbers(scene: &SceneValues) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let time = &scene.time;
    if time.duration < 0.5 * time.step {
        let text = format!("{} s are less than half a step of {} s: a run takes none", time.duration, time.step);
        warnings.push(Warning::new("no_steps", "time.duration", text));
    }
    // Force fields have their own keys.
    let wind = scene.air.as_ref().map_or(0.0, CheckedAir::largest_wind);
    if wind > FASTEST {
        let text = format!("blows at {wind} m/s: beyond {FASTEST} m/s air is compressed, here it is not");
        warnings.push(Warning::new("fast_wind", "air.wind", text));
    }
    for (group, hair) in scene.hair.iter().enumerate() {
        let Fibre { radius, stiffness, .. } = hair.fibre;
        let modulus = match stiffness {
            Stiffness::Moduli(Moduli { youngs_modulus, .. }) => Some(youngs_modulus),
            Stiffness::Direct(_) => None,
        };
        let wide = (!RADII.contains(&radius)).then(|| ("radius", format!("{radius} m, where hair has 15 to 150 µm")));
        let odd = modulus.filter(|modulus| !MODULI.contains(modulus));
        let odd = odd.map(|modulus| ("youngs_modulus", format!("{modulus} Pa, where hair has 1 to 7 GPa")));
        let length = hair.as_drawn().map(|drawn| drawn.length).filter(|length| *length > LONGEST);
        let long = length.map(|length| ("length", format!("{length} m, where hair has at most some metres")));
        for (key, text) in wide.into_iter().chain(odd).chain(long) {
            warnings.push(Warning::new("unlike_hair", &format!("{}.{key}", scene.called(group)), text));
        }
    }
    warnings
}

/// A warning where hair is hardly heavier than what it moves in: buoyancy and added mass are left out.
pub(crate) fn of_buoyancy(scene: &SceneValues) -> Option<Warning> {
    let air = scene.air.as_ref().filter(|_| scene.interaction.model != Model::None)?;
    let lightest = scene.hair.iter().map(|hair| hair.fibre.density).fold(f64::INFINITY, f64::min);
    (air.rest_density > MUCH_BUOYANCY * lightest).then(|| {
        let part = 100.0 * air.rest_density / lightest;
        let text = format!(
            "is {part:.0} % of the density of hair: buoyancy and the mass of what moves with hair are left out"
        );
        Warning::new("buoyant_hair", "air.rest_density", text)
    })
}

/// Whether a segment between two points outside is deeper inside a body than `slack` \[m\] somewhere. A step from a
/// place leads as far as no place inside can be: a trilinear distance grows by at most √3 m in a metre.
fn crosses(body: &CheckedShape, slack: f64, [from, to]: [DVec3; 2]) -> bool {
    let length = from.distance(to);
    let least = length / STEPS_ALONG;
    let mut at = 0.0;
    while at < length {
        let distance = body.signed_distance(from + at / length * (to - from)).0;
        if distance < -slack {
            return true;
        }
        at += least.max(distance / 3.0_f64.sqrt());
    }
    false
}

/// Warnings about meshes that are so small that their scale may be that of other units, have a large part missing, or
/// more detail than their grids.
pub(crate) fn of_meshes(scene: &SceneValues) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for (name, solid) in scene.bodies.iter().filter_map(|body| Some((&body.name, body.shape.solid()?))) {
        let (size, covered) = (solid.size(), solid.covered());
        let warning = |code: &str, text: String| Warning::new(code, &format!("body.{name}"), text);
        if size < SMALLEST_MESH {
            // A file that says its unit is in metres.
            let scale = solid.file().scale.unwrap_or(1.0);
            warnings.push(warning("mesh_scale", format!("the mesh is {}", with_scale(size, scale, &solid::LIKELY))));
        }
        if covered > MUCH_COVERED {
            let text = format!(
                "{:.0} % of the surface covers holes of the mesh ({}): a part of the mesh may be missing",
                100.0 * covered,
                solid.holes()
            );
            warnings.push(warning("mesh_holes", text));
        }
        let (error, spacing) = (solid.grid_error(), solid.grid().spacing);
        if error > COARSE {
            let text = format!(
                "its grid of distances, {:.3} mm apart, puts 1 % of the surface {:.2} mm or more off the triangles: \
                 body.{name}.resolution = {:.2e} would make that a half, or a quarter where the surface is smooth, with eight times the memory",
                1e3 * spacing,
                1e3 * error,
                0.5 * spacing
            );
            warnings.push(warning("coarse_mesh", text));
        }
    }
    warnings
}

/// A warning for each body beside which air goes too far in a substep for its density to stay even: more than a quarter
/// of the radius of a round body, or more than 0.9 particle spacings where the body moves. The error of the density is
/// 0.8 (U Δt/R)² (`docs/decisions/air.md`).
pub(crate) fn of_way_beside(scene: &SceneValues, air: &CheckedAir) -> Vec<Warning> {
    if scene.fluid.solver == FluidSolver::Pbf {
        return Vec::new();
    }
    let each = scene.bodies.iter().filter_map(|body| {
        let speed = air.fastest_past(&scene.in_frame(&body.motion));
        let spacing = air.spacing;
        let round = body.shape.solid().is_none().then(|| WAY_BY_RADIUS * body.shape.inradius());
        let (most, of) = match round {
            Some(way) if way < WAY * spacing => (way, "a quarter of its radius"),
            // The wind's own warning says it of a body that rests.
            _ if speed > air.largest_wind() => (WAY * spacing, "0.9 particle spacings"),
            _ => return None,
        };
        let needed = (speed * scene.time.step / most).ceil();
        (needed > f64::from(scene.time.substeps)).then(|| {
            let text = format!(
                "air passes at {speed:.3} m/s, more than {of} in a step: its density beside the body is uneven; take time.substeps = \
                 {needed}"
            );
            Warning::new("fast_past_body", &format!("body.{}", body.name), text)
        })
    });
    each.collect()
}

/// Warnings about bodies that the wind must pass, or that it steps over.
pub(crate) fn of_blocked(
    scene: &SceneValues,
    air: &CheckedAir,
    bounds: &Bounds,
    bodies: &[CheckedShape],
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let far = scene.largest_wind() * scene.time.step / f64::from(scene.time.substeps);
    for body in scene.bodies.iter().filter(|body| far > 2.0 * body.shape.inradius()) {
        let text = format!(
            "air moves {far:.1e} m in a step and may pass through this body, which is thinner: a shorter time.step stops it"
        );
        warnings.push(Warning::new("thin_body", &format!("body.{}", body.name), text));
    }
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let part = if bodies.is_empty() || air.wind[axis] == 0.0 { 0.0 } else { blocked(bodies, bounds, axis) };
        if part > MUCH_BLOCKED {
            let text =
                format!("bodies block {:.0} % of the box across {name}: the air beside them is sped up", 100.0 * part);
            warnings.push(Warning::new("blocked_box", "air.box", text));
        }
    }
    warnings
}
