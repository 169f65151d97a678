//! What hair and air exchange in the model `two-way`: the force on a strand that stands still beside the law, with the air
//! slowed as by a porous strip; a porous strip across a channel; momentum and energy.

use glam::DVec3;
use windswept::{Gpu, Simulation, internals::step};
use windswept_reference::elastica::{Hair, REAL};
use windswept_scene::{InitialState, Scene};

use crate::{
    Error, Row,
    air::{Cloud, RADIUS, REST_DENSITY, SIMPLE, mean, spacing, vectors},
    stage::Stage,
};

const SINGLE: &str = "the law at the wind's speed; own wake taken out; the bound is 0.98 to 1.005";
const LOCK: &str = "no formula: an earlier program of the same model has 0.70 to 0.78; self-shielding of a lock 1.3 h wide; the tolerance covers \
    0.68 to 0.80";
const POROUS: &str = "porous strip of k = f F_1(u)/(1/2 rho u² 1.3 h) across this box (Taylor 1944; Garrett & Cummins 2007); the width is fitted";
const STRIP: &str = "k (u/U)² of Taylor 1944 in a channel (Garrett & Cummins 2007), blockage 0.222, on the measured flux; at 1.38 ms the \
    pressure of 4 iterations is late";
const MOMENTUM: &str = "Newton's third law, over the sum of |J|; f32";
const ENERGY: &str = "an exchange may only lose energy: air's change plus the hair's work is below 0";

/// U \[m/s\].
const WIND: f64 = 3.0;
/// b over h.
const WIDTH: f64 = 1.3;
/// Far too heavy to be moved \[kg/m³\].
const HEAVY: f64 = 1e9;
/// Points lie this far apart at most \[m\].
const GAP: f64 = 4e-3;
/// Ends keep off the box's faces by this \[m\].
const EDGE: f64 = 1e-6;

/// Strands that stand across the wind, from one face of the box to the other along z.
struct Fence {
    cells: [usize; 3],
    /// Where they stand in x and y \[m\].
    places: Vec<[f64; 2]>,
    fibres: f64,
    radius: f64,
    viscosity: f64,
    step: f64,
}

/// What it does to the air: means over steps.
struct Felt {
    /// On all strands, downwind \[N\].
    force: f64,
    /// Air at the strands \[m/s\].
    speed: f64,
    /// Mean of all air \[m/s\].
    flux: f64,
}

impl Fence {
    /// One strand in a small box.
    fn lone(fibres: f64, step: f64, wide: usize) -> Self {
        let cells = [24, wide, 6];
        let middle = cells.map(|n| n as f64 * spacing());
        Self {
            cells,
            places: vec![[0.45 * middle[0], 0.5 * middle[1]]],
            fibres,
            radius: REAL.radius,
            viscosity: REAL.viscosity,
            step,
        }
    }

    /// A strip 8 spacings wide in a channel of 36, whose drag on an area is k times ½ρu².
    fn strip(k: f64, step: f64) -> Self {
        let cells = [60, 36, 6];
        let d = spacing();
        // Thin fibres in thin air: C_d = 1, and no wake of one fibre to speak of.
        let (radius, apart) = (4e-6, 0.5 * d);
        let places = (0..16).map(|i| [22.0 * d, 14.0 * d + apart * (f64::from(i) + 0.5)]).collect();
        Self { cells, places, fibres: k * apart / (2.0 * radius), radius, viscosity: 1e-13, step }
    }

    fn simulation(&self, gpu: &Gpu) -> Result<Simulation, Error> {
        let cloud = Cloud::lattice(self.cells, SIMPLE).jittered(0.05, 7).moving(|_| DVec3::X * WIND);
        let length = cloud.size.z - 2.0 * EDGE;
        let points = (length / GAP).ceil() as usize + 1;
        let strand = |[x, y]: &[f64; 2]| {
            format!(
                "[[hair]]\nname = \"{y}\"\nstrands = 1\npoints = {points}\nlength = {length}\nradius = {}\ndensity = {HEAVY}\n\
                 fibres_per_strand = {}\nroots = {{ center = [{x}, {y}, {EDGE}], radius = 1e-9, direction = [0, 0, 1] }}\n",
                self.radius, self.fibres
            )
        };
        let text = format!(
            "gravity = [0, 0, 0]\ninteraction = {{ model = \"two-way\" }}\nfluid = {{ iterations = 4 }}\n\
             time = {{ step = {}, duration = 10.0 }}\nrods = {{ sleep = false }}\n\
             [air]\nbox = {{ min = [0, 0, 0], max = {:?} }}\nwind = [{WIND}, 0, 0]\nramp = 0.0\n\
             kinematic_viscosity = {}\n{}",
            self.step,
            cloud.size.to_array(),
            self.viscosity,
            self.places.iter().map(strand).collect::<String>(),
        );
        let scene = Scene::parse(&text)?;
        let hair = InitialState::new(&scene)?.hair;
        Ok(Simulation::with_state(gpu, &scene, InitialState { hair, ..cloud.initial() })?)
    }

    /// Means over `watched` seconds, after `before`.
    fn felt(&self, gpu: &Gpu, before: f64, watched: f64) -> Result<Felt, Error> {
        let mut simulation = self.simulation(gpu)?;
        simulation.step((before / self.step).round() as u64)?;
        let looks = 40.0_f64.min((watched / self.step).round());
        let stride = (watched / looks / self.step).round() as u64;
        let (mut force, mut speed, mut flux) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..looks as usize {
            simulation.step(stride)?;
            let engine = simulation.engine();
            let impulses = engine.read(&engine.state().drag_impulse)?;
            force.push(impulses.iter().map(|j| f64::from(j[0])).sum::<f64>() / self.step);
            speed.push(mean(engine.read(&engine.state().sampled)?.iter().map(|air| f64::from(air.wind[0]))));
            flux.push(mean(simulation.frame()?.air.velocities.iter().map(|v| f64::from(v[0]))));
        }
        Ok(Felt { force: mean(force), speed: mean(speed), flux: mean(flux) })
    }
}

/// Force on a metre of fibre across air of this speed \[N/m\].
fn law(speed: f64) -> f64 {
    Hair { wind: speed, ..REAL }.drag(0.0)[0]
}

/// u/U in a porous strip across a channel of which it takes the part `blockage`: k u² is the head that it takes from the air
/// through it (Taylor 1944, in the channel of Garrett & Cummins 2007). In terms of the speed b past it and w behind it, over U:
///
/// ```text
/// (b − 1)(b + 2w − 1) = B (b² − w²),  u = w (b + w)/(b + 2w − 1),  k u² = b² − w²
/// ```
fn through(k: f64, blockage: f64) -> f64 {
    let at = |b: f64| {
        let more = b - 1.0;
        let w = ((more.powi(2) - blockage * (more.powi(2) - blockage * b * b)).sqrt() - more) / blockage;
        (w * (b + w) / (b + 2.0 * w - 1.0), b * b - w * w)
    };
    let (mut low, mut high) = (1.0, 1.0 / (1.0 - blockage.sqrt()));
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        let (u, head) = at(middle);
        if head < k * u * u { low = middle } else { high = middle }
    }
    at(low).0
}

/// u/U at a lone strand of so many fibres that takes the part `blockage` of the channel: a strip whose k is the law's at u.
fn shielded(fibres: f64, speed: f64, blockage: f64) -> f64 {
    let k = |u: f64| fibres * law(u) / (0.5 * REST_DENSITY * u * u * WIDTH * RADIUS);
    let (mut low, mut high) = (1e-3, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if middle < through(k(speed * middle), blockage) { low = middle } else { high = middle }
    }
    low
}

/// The force on strands that stand still, momentum, energy.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = fixed(gpu, 1.38e-3, 16)?;
    rows.extend(kept(gpu)?);
    Ok(rows)
}

/// A lone strand that stands still across 3 m/s.
pub(crate) fn fixed(gpu: &Gpu, step: f64, wide: usize) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    // The exchange with 200 fibres is capped at the paper's step, and says little of the law.
    let most = if step < 1e-3 { 200.0 } else { 100.0 };
    for fibres in [1.0, 10.0, 36.0, 200.0].into_iter().filter(|fibres| *fibres <= most) {
        let fence = Fence::lone(fibres, step, wide);
        let felt = fence.felt(gpu, 0.1, 0.06)?;
        let length = fence.cells[2] as f64 * spacing() - 2.0 * EDGE;
        let part = felt.force / (fibres * length * law(felt.flux));
        let blockage = WIDTH * RADIUS / (fence.cells[1] as f64 * spacing());
        let (wanted, got) = (shielded(fibres, felt.flux, blockage), felt.speed / felt.flux);
        let name = format!("fixed strand of {fibres} fibres, {} ms", 1e3 * step);
        if fibres == 1.0 {
            rows.push(Row::new(format!("{name}: force over the law"), 0.9925, part, 0.0125, SINGLE));
        } else if fibres == 36.0 {
            rows.push(Row::new(format!("{name}: force over the law"), 0.74, part, 0.06, LOCK));
        }
        rows.push(Row::new(format!("{name}: air at it over U"), wanted, got, 0.04, POROUS));
    }
    Ok(rows)
}

/// A lone strand that stands still in a box twice as wide, at two steps.
pub(crate) fn fixed_wide(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = fixed(gpu, 1.38e-3, 32)?;
    rows.extend(fixed(gpu, 0.345e-3, 32)?);
    Ok(rows)
}

/// Drag of a porous strip across a channel over Taylor's.
pub(crate) fn strip(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let d = spacing();
    let mut rows = Vec::new();
    for (k, step, least, most) in [
        (1.0, 1.38e-3, 0.85, 1.05),
        (4.0, 1.38e-3, 0.77, 1.05),
        (0.25, 0.345e-3, 0.95, 1.05),
        (1.0, 0.345e-3, 0.95, 1.05),
        (4.0, 0.345e-3, 0.95, 1.05),
    ] {
        let wanted = through(k, 8.0 / 36.0);
        let fence = Fence::strip(k, step);
        let felt = fence.felt(gpu, 0.15, 0.1)?;
        let area = 8.0 * d * (fence.cells[2] as f64 * d - 2.0 * EDGE);
        let part = felt.force / (0.5 * REST_DENSITY * felt.flux.powi(2) * area) / (k * wanted * wanted);
        let name = format!("porous strip, k = {k}, {} ms", 1e3 * step);
        let (middle, half) = (0.5 * (least + most), 0.5 * (most - least));
        rows.push(Row::new(format!("{name}: drag over the formula's"), middle, part, half, STRIP));
        rows.push(Row::new(format!("{name}: air in it over U"), wanted, felt.speed / felt.flux, 0.08, STRIP));
    }
    Ok(rows)
}

/// A tuft that has been blown for a while.
const TUFT: &str = "
gravity = [0, 0, 0]
interaction = { model = \"two-way\" }
time = { step = 1.38e-3, duration = 1.0 }
rods = { sleep = false }
[[hair]]
strands = 12
points = 10
length = 0.045
fibres_per_strand = 36
roots = { center = [0.03, 0.055, 0.03], radius = 0.012 }
[air]
box = { min = [0, 0, 0], max = [0.08, 0.06, 0.06] }
wind = [0, 0, 0]
ramp = 0.0
";
const STEPS: u64 = 30;

/// What air that streams past a tuft loses in whole steps is what the tuft was given; a single exchange loses energy.
fn kept(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let scene = Scene::parse(TUFT)?;
    let mut initial = InitialState::new(&scene)?;
    initial.air.velocities.fill(DVec3::X * WIND);
    let mass = initial.air.mass;
    let mut simulation = Simulation::with_state(gpu, &scene, initial.clone())?;
    let momentum = |v: &[[f32; 3]]| mass * vectors(v).into_iter().sum::<DVec3>();
    let before = momentum(&simulation.frame()?.air.velocities);
    let (mut given, mut size) = (DVec3::ZERO, 0.0);
    for _ in 0..STEPS {
        simulation.step(1)?;
        let engine = simulation.engine();
        let impulses = engine.read(&engine.state().drag_impulse)?;
        for (j, air) in impulses.iter().zip(engine.read(&engine.state().sampled)?) {
            let j = DVec3::new(j[0].into(), j[1].into(), j[2].into());
            given += f64::from(2.0 * air.filled).min(1.0) * j;
            size += j.length();
        }
    }
    let frame = simulation.frame()?;
    let change = momentum(&frame.air.velocities) - before;
    let name = "stream past a tuft, 30 steps: air's loss off the sum of impulses";
    let mut rows = vec![Row::new(name, 0.0, (change + given).length() / size, 1e-5, MOMENTUM)];

    // The same air and hair, as a state that headings are run on.
    initial.air.positions = vectors(&frame.air.positions);
    initial.air.velocities = vectors(&frame.air.velocities);
    initial.hair.positions = vectors(&frame.hair.positions);
    initial.hair.velocities = vectors(&frame.hair.velocities);
    let turned = frame.hair.orientations.iter().map(|q| glam::DQuat::from_array(q.map(f64::from)).normalize());
    initial.hair.orientations = turned.collect();
    let points = initial.hair.positions.len();
    let mut stage = Stage::new(gpu, &scene, &initial)?;
    stage.run(|r, plan| {
        step::drive::record(r, plan);
        step::neighbours::record(r, plan);
        step::fluid::record(r, plan);
    })?;
    let free = stage.read(|s| &s.new_velocity)?;
    stage.run(|r, plan| {
        step::drive::record(r, plan);
        step::neighbours::record(r, plan);
        step::fluid::record(r, plan);
        step::rods::record(r, plan);
    })?;
    let slowed = stage.read(|s| &s.new_velocity)?;
    let impulses = stage.read(|s| &s.drag_impulse)?;
    let places = stage.read(|s| &s.predicted)?;
    let starts = stage.read(|s| &s.position)?;
    let air = || free[points..].iter().zip(&slowed[points..]);
    let change: f64 = air().map(|(a, b)| 0.5 * mass * (*b - *a).dot(*b + *a)).sum();
    // Euler's first step: a point's velocity is its way.
    let work: f64 = (0..points).map(|i| impulses[i].dot((places[i] - starts[i]) / stage.p.step)).sum();
    let made = (change + work) / change.abs();
    rows.push(Row::new(
        "tuft in a stream: energy that an exchange makes, over the air's change",
        -1.0,
        made,
        1.0,
        ENERGY,
    ));
    let moved: DVec3 = air().map(|(a, b)| mass * (*b - *a)).sum();
    let all: DVec3 = impulses.iter().sum();
    let size: f64 = impulses.iter().map(|j| j.length()).sum();
    rows.push(Row::new(
        "tuft in a stream: air's loss off hair's gain",
        0.0,
        (moved + all).length() / size,
        1e-5,
        MOMENTUM,
    ));
    Ok(rows)
}
