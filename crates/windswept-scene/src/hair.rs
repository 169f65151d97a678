//! Strands from `[[hair]]`: roots and rest shapes.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::{
    curves::Curves,
    error::SceneError,
    groom::{Groom, PerStrand},
    keys::Key,
    limits::MAX_HAIR_POINTS,
    scatter::{Seat, scatter},
    scene::{Curl, Drawn, Fibre, GroomFile, Hair, HairSource, RootPatch, RootShape, Roots, SceneValues},
    strand::{AirParticle, Shape, frame, turn},
    strands::{End, Strands},
    warnings::Warning,
};

/// Turns between successive points of a sunflower.
const GOLDEN_TURN: f64 = 0.381_966_011_250_105;
/// Roots leave their sunflower seat by up to this part of the spacing.
const JITTER: f64 = 0.15;
/// A joint that turns by more than this samples its curl too coarsely.
const COARSE_TURN: f64 = PI / 2.0;

/// The strands of every group.
///
/// Chance is PCG XSL 128/64 (`rand_pcg`), seeded by the scene's seed and the group's index: the same on every machine.
///
/// # Errors
/// [`SceneError`] where a groom file cannot be read, or its strands cannot be simulated, and where roots are on a body
/// that is not there. Its key is a real path, for [`Scene::located`].
pub(crate) fn strands(
    scene: &SceneValues,
    particle: AirParticle,
    warnings: &mut Vec<Warning>,
) -> Result<Strands, SceneError> {
    let mut all = Strands { point_offsets: vec![0], ..Strands::default() };
    for (group, hair) in scene.hair.iter().enumerate() {
        match &hair.source {
            HairSource::Drawn(drawn) => draw(scene, group, hair, drawn, particle, &mut all, warnings)?,
            HairSource::File(file) => {
                let groom = groom(scene, group, hair, file, warnings);
                let groom = groom.map_err(|error| of_group(group, &file.file, &error))?;
                let points = all.positions.len() + groom.simulated_points();
                if points > MAX_HAIR_POINTS as usize {
                    let words = format!("makes {points} hair points; expected at most {MAX_HAIR_POINTS}");
                    return Err(SceneError::new(words).at(format!("hair.{group}.strands"), None));
                }
                let notes = groom.append(scene, particle, &mut all);
                warnings.extend(notes.iter().map(|note| Warning::new("groom", &scene.called(group), note)));
            }
        }
    }
    if scene.hair.iter().all(|hair| hair.as_drawn().is_some()) {
        all.ids.clear();
    }
    Ok(all)
}

/// The error of a groom file as one of the group's key that is at fault, by its real path.
fn of_group(group: usize, file: &str, error: &SceneError) -> SceneError {
    let own = error.key().filter(|key| Key::find(&format!("hair.{key}")).is_some());
    let fault = SceneError::new(format!("{file}: {}", error.message()));
    let fault = fault.at(format!("hair.{group}.{}", own.unwrap_or("file")), None);
    error.help().into_iter().fold(fault, |fault, help| fault.with_help(help))
}

/// The strands of a group's file, where the group's motion has them at the start.
fn groom(
    scene: &SceneValues,
    group: usize,
    hair: &Hair,
    file: &GroomFile,
    warnings: &mut Vec<Warning>,
) -> Result<Groom, SceneError> {
    let (read, notes) = file.groom(hair.seed.unwrap_or(scene.seed))?;
    warnings.extend(notes.iter().map(|note| Warning::new("groom", &scene.called(group), note)));
    let fibre = match read.fibre {
        PerStrand::All(_) => hair.fibre.into(),
        PerStrand::Each(fibres) => {
            fibres.iter().map(|own| Fibre { radius: own.radius, ..hair.fibre }).collect::<Vec<_>>().into()
        }
    };
    let place = |x: [f64; 3]| hair.motion.place(hair.center(), DVec3::from_array(x), 0.0).to_array();
    let groom = Groom {
        points: read.points.into_iter().map(place).collect(),
        group: (group as u32).into(),
        fibre,
        stiffness: hair.stiffness.clone(),
        rest: file.rest,
        friction: hair.friction.into(),
        root: hair.root.into(),
        tip: hair.tip.into(),
        ids: read.ids,
        groups: read.groups,
        root_uvs: read.root_uvs,
        guides: read.guides,
        ..Groom::new(Vec::new(), read.offsets)
    };
    groom.check()?;
    Ok(groom)
}

impl Hair {
    /// How many strands of the group are simulated, and all that its groom file has where those are more, where the
    /// group's motion has them at the start \[m\]: the others follow the simulated ones.
    ///
    /// # Errors
    /// As [`GroomFile::curves`].
    pub fn followers(&self, seed: u64) -> Result<(usize, Option<Curves>), SceneError> {
        match &self.source {
            HairSource::Drawn(drawn) => Ok((drawn.strands as usize, None)),
            HairSource::File(file) => {
                let (simulated, mut all) = file.followers(self.seed.unwrap_or(seed))?;
                for point in all.iter_mut().flat_map(|curves| &mut curves.points) {
                    *point = self.motion.place(self.center(), DVec3::from_array(*point), 0.0).to_array();
                }
                Ok((simulated, all))
            }
        }
    }
}

/// Appends the strands of a group that is drawn.
///
/// # Errors
/// As [`Scene::scalp`].
fn draw(
    scene: &SceneValues,
    group: usize,
    hair: &Hair,
    drawn: &Drawn,
    particle: AirParticle,
    all: &mut Strands,
    warnings: &mut Vec<Warning>,
) -> Result<(), SceneError> {
    let seed = hair.seed.unwrap_or(scene.seed);
    let mut rng = Pcg64::seed_from_u64(seed.wrapping_mul(0x9e37_79b9).wrapping_add(group as u64));
    let patch = drawn.roots.patch();
    let on_mesh = match &drawn.roots {
        Roots::Mesh(scalp) => {
            let found = scene.scalp(scalp).map_err(|error| error.within(&format!("hair.{group}.roots")));
            let (_, solid, triangles) = found?;
            scatter(solid, &triangles, drawn.strands, &mut rng)
        }
        _ => Vec::new(),
    };
    for i in 0..drawn.strands {
        let Seat { root, normal: axis, uv } = match &patch {
            Some(patch) => {
                let (root, normal) = seat(patch, i, drawn.strands, &mut rng);
                Seat { root, normal, uv: [0.0; 2] }
            }
            None => on_mesh[i as usize],
        };
        // Where the motion has it at the start.
        let turn = hair.motion.at(0.0).rotation;
        let root = hair.motion.place(hair.center(), root, 0.0);
        let length = drawn.length * (1.0 - drawn.length_variation * rng.random::<f64>());
        let phase = rng.random::<f64>();
        let root_frame = turn * drawn.root_frame(axis, phase);
        let stiffness = hair.stiffness.clone();
        let shape = Shape { stiffness, ..drawn.shape(root, root_frame, length, [hair.root, hair.tip]) };
        shape.append(&hair.fibre, particle, all);
        all.group.push(group as u32);
        all.ids.push(i);
        all.groups.push(group as u32);
        all.root_uvs.push(uv);
        all.friction.push(hair.friction);
    }
    let turn = darboux(drawn.curl).length() * drawn.length / f64::from(drawn.points - 1);
    if turn > COARSE_TURN {
        let degrees = turn.to_degrees();
        let text = format!("the curl turns by {degrees:.0} degrees per segment; more points would follow it better");
        warnings.push(Warning::new("few_points", &scene.called(group), text));
    }
    Ok(())
}

/// Position and direction of root `i` of `n`: a jittered sunflower on disc and cap, equal parts of a line. A lone root
/// is in the middle.
fn seat(roots: &RootPatch, i: u32, n: u32, rng: &mut Pcg64) -> (DVec3, DVec3) {
    let [center, axis, normal] = [roots.center, roots.direction, roots.normal].map(DVec3::from_array);
    if n == 1 {
        let height = if roots.shape == RootShape::Cap { roots.radius } else { 0.0 };
        return (center + height * axis, axis);
    }
    let level = DVec3::Y.cross(normal);
    let across = if level.length() > 1e-6 { level.normalize() } else { DVec3::X };
    let up = normal.cross(across);
    let part = (f64::from(i) + 0.5) / f64::from(n);
    let jitter = [rng.random::<f64>() - 0.5, rng.random::<f64>() - 0.5].map(|u| 2.0 * JITTER * u);
    match roots.shape {
        RootShape::Line => (center + roots.radius * (2.0 * part - 1.0 + 2.0 * jitter[0] / f64::from(n)) * across, axis),
        RootShape::Disc => {
            let spacing = roots.radius * (PI / f64::from(n)).sqrt();
            let angle = TAU * GOLDEN_TURN * f64::from(i);
            let seat = roots.radius * part.sqrt() * (angle.cos() * across + angle.sin() * up);
            let seat = seat + spacing * (jitter[0] * across + jitter[1] * up);
            // Chance must not lead off the disc.
            (center + seat.clamp_length_max(roots.radius), axis)
        }
        RootShape::Cap => {
            let angle = TAU * (GOLDEN_TURN * f64::from(i) + jitter[0] / f64::from(n).sqrt());
            let height = 1.0 - part;
            let ring = (1.0 - height * height).sqrt();
            let normal = height * axis + ring * (angle.cos() * across + angle.sin() * up);
            (center + roots.radius * normal, normal)
        }
    }
}

/// Rest Darboux vector of a helix of radius a and pitch 2π b: (0, κ, τ) = (0, a, b)/(a² + b²) \[1/m\].
fn darboux(curl: Option<Curl>) -> DVec3 {
    curl.map_or(DVec3::ZERO, |curl| {
        let (a, b) = (curl.radius, curl.pitch / TAU);
        DVec3::new(0.0, a, b) / (a * a + b * b)
    })
}

impl Drawn {
    /// A strand at rest, whose root and tip are held as `ends` say.
    fn shape(&self, root: DVec3, root_frame: DQuat, length: f64, ends: [End; 2]) -> Shape {
        let segments = self.points as usize - 1;
        let l = length / segments as f64;
        let kappa = darboux(self.curl);
        // The clamp's joint is half a segment long, as the tip's.
        let mut turns = vec![turn(kappa, l); segments];
        turns[0] = turn(kappa, 0.5 * l);
        let mut frames = Vec::with_capacity(segments);
        let mut points = vec![root];
        let (mut frame, mut x) = (root_frame, root);
        for turn in &turns {
            frame = (frame * *turn).normalize();
            x += l * (frame * DVec3::Z);
            frames.push(frame);
            points.push(x);
        }
        let tip = ((frame * turn(kappa, 0.5 * l)).normalize(), turn(kappa, 0.5 * l));
        Shape { points, root_frame, frames, lengths: vec![l; segments], turns, ends, tip, stiffness: None }
    }

    /// The clamp: a helix is tilted so that its axis, the direction of the Darboux vector, runs along the strand's;
    /// `phase` from 0 to 1.
    fn root_frame(&self, axis: DVec3, phase: f64) -> DQuat {
        let straight = frame(axis);
        if self.curl.is_none() {
            return straight;
        }
        let phase = DQuat::from_rotation_z(TAU * self.curl_phase * phase);
        (straight * phase * DQuat::from_rotation_arc(darboux(self.curl).normalize(), DVec3::Z)).normalize()
    }
}
