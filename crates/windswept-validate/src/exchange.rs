//! Exchange of hair and air in the model `two-way`: the force on a strand that stands still beside the law, with the
//! air slowed as by a porous strip; a porous strip across a channel; a bundle of strands; momentum and energy.

use glam::DVec3;
use windswept_engine::{Gpu, Simulation, internals::step};
use windswept_reference::elastica::{self, REAL};
use windswept_scene::{Air, AirParticles, Fibre, Hair, InitialState, Roots};

use crate::{
    Error, Row,
    air::{Cloud, RADIUS, REST_DENSITY, SIMPLE, STEP, mean, spacing, vectors},
    runner::Runner,
    scenes::{afloat, blowing, still},
};

const SINGLE: &str = "the law at the wind's speed; own wake taken out; the bound is 0.98 to 1.005";
const POROUS: &str = "porous strip of k = f F_1(u)/(1/2 rho u² 1.3 h) across this box (Taylor 1944; Garrett & Cummins 2007); the width is fitted";
const STRIP: &str = "k (u/U)² of Taylor 1944 in a channel (Garrett & Cummins 2007), blockage 0.222, on the measured flux; mean over \
    three places, for the coarse pressure's nodes are three spacings apart";
const STEADY: &str =
    "no formula: a strip that stands still in steady wind; another program, in f64, measured 0.01 to 0.03";
const HALVED: &str = "no formula: drag must have a limit as the step falls";
const BUNDLE: &str = "no formula: another program of the same air, in f64, measured 0.730 for 1 fibre and 0.065 to 0.069 for 36; each \
    fibre more shelters the others, so the share falls";
const GROWING: &str = "no formula: another program of the same air, in f64, measured 0.075 to 0.079; the wake grows until 0.25 s, and \
    the force falls as it does";
const FINER: &str = "the disc is 21 spacings wide, so that its drag does not depend on them; as many steps per spacing";
const BACKWARDS: &str = "behind a dense array of cylinders air flows back (Chen, Ortiz, Zong & Nepf 2012): 0 to -U";
pub(crate) const MOMENTUM: &str = "Newton's third law, over the sum of |J|; f32";
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
    /// How many times finer the air is than the paper's: lattice and kernel.
    finer: f64,
    /// Middles of the discs in which they stand, in x and y \[m\].
    places: Vec<[f64; 2]>,
    /// Strands in each disc, and its radius \[m\].
    disc: (u32, f64),
    fibres: f64,
    radius: f64,
    viscosity: f64,
    step: f64,
}

/// A disc that holds one strand, in its middle.
const ALONE: (u32, f64) = (1, 1e-9);
/// Strands of the bundle, and the radius of their disc \[m\].
const DENSE: (u32, f64) = (550, 52e-3);

/// Effect of a fence on the air: means over steps.
struct Felt {
    /// On all strands, downwind \[N\], and its rms about that \[N\].
    force: f64,
    unsteady: f64,
    /// Air at the strands \[m/s\].
    speed: f64,
    /// Mean of all air \[m/s\].
    flux: f64,
    /// Air behind the first disc's axis, 3 to 6 of the paper's spacings away \[m/s\].
    wake: f64,
}

impl Fence {
    /// Strands of real fibres in one disc.
    fn around(disc: (u32, f64), fibres: f64, step: f64, cells: [usize; 3]) -> Self {
        let [x, y, _] = cells.map(|n| n as f64 * spacing());
        Self {
            cells,
            finer: 1.0,
            places: vec![[0.45 * x, 0.5 * y]],
            disc,
            fibres,
            radius: REAL.radius,
            viscosity: REAL.viscosity,
            step,
        }
    }

    /// A bundle of strands; in finer air as many steps per spacing.
    fn bundle(fibres: f64, finer: f64) -> Self {
        let coarse = Self::around(DENSE, fibres, 1.38e-3 / finer, [84, 60, 6]);
        // The box is as long and wide; the flow does not vary along its depth.
        let cells = [(84.0 * finer) as usize, (60.0 * finer) as usize, 6];
        Self { cells, finer, ..coarse }
    }

    /// A strip 8 spacings wide in a channel of 36, so many spacings from its start, whose drag on an area is k times
    /// ½ρu².
    fn strip(k: f64, step: f64, place: f64) -> Self {
        let cells = [60, 36, 6];
        let d = spacing();
        // Thin fibres in thin air: C_d = 1, and no wake of one fibre to speak of.
        let (radius, apart) = (4e-6, 0.5 * d);
        let places = (0..16).map(|i| [place * d, 14.0 * d + apart * (f64::from(i) + 0.5)]).collect();
        let fibres = k * apart / (2.0 * radius);
        Self { cells, finer: 1.0, places, disc: ALONE, fibres, radius, viscosity: 1e-13, step }
    }

    /// Length of a strand \[m\].
    fn length(&self) -> f64 {
        self.cells[2] as f64 * spacing() / self.finer - 2.0 * EDGE
    }

    /// Force on all strands by the law alone, each by itself in air of this speed \[N\].
    fn alone(&self, speed: f64) -> f64 {
        self.fibres * (f64::from(self.disc.0) * self.places.len() as f64) * self.length() * law(speed)
    }

    /// Air of the wind's speed.
    fn air(&self) -> AirParticles {
        let cloud = Cloud::lattice(self.cells, SIMPLE).jittered(0.05, 7).moving(|_| DVec3::X * WIND);
        let mut air = cloud.initial().air;
        air.positions.iter_mut().for_each(|x| *x /= self.finer);
        let part = self.finer.powi(-3);
        AirParticles { size: air.size / self.finer, volume: part * air.volume, mass: part * air.mass, ..air }
    }

    fn simulation(&self, gpu: &Gpu) -> Result<Simulation, Error> {
        let air = self.air();
        let length = self.length();
        let points = (length / GAP).ceil() as u32 + 1;
        let (strands, disc) = self.disc;
        let (radius, fibres_per_strand) = (self.radius, self.fibres);
        let fibre = Fibre { radius, density: HEAVY, fibres_per_strand, ..Fibre::default() };
        let group = |&[x, y]: &[f64; 2]| {
            let roots = Roots::disc([x, y, EDGE], disc).toward([0.0, 0.0, 1.0]);
            Hair { fibre, ..Hair::drawn(strands, points, length, roots).named(y.to_string()) }
        };
        let wind = Air {
            spacing: air.volume.cbrt(),
            kernel_radius: Some(RADIUS / self.finer),
            kinematic_viscosity: self.viscosity,
            ..blowing(air.size.to_array(), [WIND, 0.0, 0.0])
        };
        let scene = afloat(self.step, wind, self.places.iter().map(group).collect::<Vec<_>>());
        let hair = InitialState::new(&scene)?.hair;
        Ok(Simulation::with_state(gpu, &scene, InitialState { hair, air, ..InitialState::default() })?)
    }

    /// Means over `watched` seconds, after `before`.
    fn felt(&self, gpu: &Gpu, before: f64, watched: f64) -> Result<Felt, Error> {
        let mut simulation = self.simulation(gpu)?;
        simulation.step((before / self.step).round() as u64)?;
        let looks = 40.0_f64.min((watched / self.step).round());
        let stride = (watched / looks / self.step).round() as u64;
        let (mut force, mut speed, mut flux, mut wake) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for _ in 0..looks as usize {
            simulation.step(stride)?;
            let engine = simulation.engine();
            let impulses = engine.read(&engine.state().drag_impulse)?;
            force.push(impulses.iter().map(|j| f64::from(j[0])).sum::<f64>() / self.step);
            speed.push(mean(engine.read(&engine.state().sampled)?.iter().map(|air| f64::from(air.wind[0]))));
            let air = simulation.frame()?.air;
            flux.push(mean(air.velocities.iter().map(|v| f64::from(v[0]))));
            let behind = air.positions.iter().zip(&air.velocities).filter(|(x, _)| self.shaded(x.map(f64::from)));
            wake.push(mean(behind.map(|(_, v)| f64::from(v[0]))));
        }
        let middle = mean(force.iter().copied());
        let unsteady = mean(force.iter().map(|force| (force - middle).powi(2))).sqrt();
        Ok(Felt { force: middle, unsteady, speed: mean(speed), flux: mean(flux), wake: mean(wake) })
    }

    /// Whether a place lies behind the first disc, 3 to 6 of the paper's spacings away and at most 1.5 from its axis.
    fn shaded(&self, [x, y, _]: [f64; 3]) -> bool {
        let [front, axis] = self.places[0];
        let behind = (x - front - self.disc.1) / spacing();
        (3.0..6.0).contains(&behind) && (y - axis).abs() < 1.5 * spacing()
    }
}

/// Force on a metre of fibre across air of this speed \[N/m\].
fn law(speed: f64) -> f64 {
    elastica::Hair { wind: speed, ..REAL }.drag(0.0)[0]
}

/// u/U in a porous strip across a channel of which it takes the part `blockage`: k u² is the head that it takes from
/// the air through it (Taylor 1944, in the channel of Garrett & Cummins 2007). In terms of the speed b past it and w
/// behind it, over U:
///
/// ```text
/// (b − 1)(b + 2w − 1) = B (b² − w²),  u = w (b + w)/(b + 2w − 1),  k u² = b² − w²
/// ```
pub fn through(k: f64, blockage: f64) -> f64 {
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

/// u/U at a lone strand of so many fibres that takes the part `blockage` of the channel: a strip whose k is the law's
/// at u.
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
    let mut rows = fixed(gpu, 1.38e-3, [24, 16, 6])?;
    rows.extend(kept(gpu)?);
    Ok(rows)
}

/// A lone strand that stands still across 3 m/s.
fn fixed(gpu: &Gpu, step: f64, cells: [usize; 3]) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    // With 200 fibres the air at the strand is 0.048 U off the formula at the paper's step, in the wide box.
    let most = if step < 1e-3 { 200.0 } else { 100.0 };
    for fibres in [1.0, 10.0, 36.0, 200.0].into_iter().filter(|fibres| *fibres <= most) {
        let fence = Fence::around(ALONE, fibres, step, cells);
        let felt = fence.felt(gpu, 0.1, 0.06)?;
        let part = felt.force / fence.alone(felt.flux);
        let blockage = WIDTH * RADIUS / (fence.cells[1] as f64 * spacing());
        let (wanted, got) = (shielded(fibres, felt.flux, blockage), felt.speed / felt.flux);
        let name = format!("fixed strand of {fibres} fibres, {} ms, box {} spacings wide", 1e3 * step, cells[1]);
        if fibres == 1.0 {
            rows.push(Row::new(format!("{name}: force over the law"), 0.9925, part, 0.0125, SINGLE));
        } else {
            let wanted = law(wanted * felt.flux) / law(felt.flux);
            rows.push(Row::new(format!("{name}: force over the law"), wanted, part, 0.06, POROUS));
        }
        rows.push(Row::new(format!("{name}: air at it over U"), wanted, got, 0.04, POROUS));
    }
    Ok(rows)
}

/// A lone strand that stands still in a box that is long and wide enough for the flow around it, at two steps.
pub(crate) fn fixed_wide(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = fixed(gpu, 1.38e-3, [64, 40, 6])?;
    rows.extend(fixed(gpu, 0.345e-3, [64, 40, 6])?);
    Ok(rows)
}

/// When the bundle is watched, with a wake that still grows and one that has grown: after so long, and for how long
/// \[s\].
const YOUNG: [f64; 2] = [0.04, 0.08];
const GROWN: [f64; 2] = [0.15, 0.15];

/// Force on the bundle over that on as many lone strands, and all that it does to the air: means over `watched`
/// seconds, after `before`.
fn sheltered(gpu: &Gpu, fibres: f64, finer: f64, [before, watched]: [f64; 2]) -> Result<(f64, Felt), Error> {
    let fence = Fence::bundle(fibres, finer);
    let felt = fence.felt(gpu, before, watched)?;
    Ok((felt.force / fence.alone(felt.flux), felt))
}

/// A bundle of strands that stands still across 3 m/s, and in finer air.
pub(crate) fn bundle(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let mut fewer = f64::INFINITY;
    for (fibres, least, most) in [(1.0, 0.70, 0.76), (4.0, 0.2, 0.5), (36.0, 0.05, 0.085), (200.0, 0.005, 0.03)] {
        let (share, felt) = sheltered(gpu, fibres, 1.0, GROWN)?;
        // It falls with the fibres.
        let most = fewer.min(most);
        fewer = share;
        let name = format!("bundle of 550 strands of {fibres} fibres, 1.38 ms");
        let (middle, half) = (0.5 * (least + most), 0.5 * (most - least));
        rows.push(Row::new(format!("{name}: force over that on lone strands"), middle, share, half, BUNDLE));
        if fibres == 36.0 {
            let (share, _) = sheltered(gpu, fibres, 1.0, YOUNG)?;
            let young = format!("{name}, 0.04 to 0.12 s: force over that on lone strands");
            rows.push(Row::new(young, 0.076, share, 4e-3, GROWING));
            let name = format!("{name}: air behind its axis over U");
            rows.push(Row::new(name, -0.5, felt.wake / felt.flux, 0.5, BACKWARDS));
        }
        if [1.0, 36.0].contains(&fibres) {
            let name = format!("{name}: force in air 1.5 times finer over that");
            rows.push(Row::new(name, 1.0, sheltered(gpu, fibres, 1.5, GROWN)?.0 / share, 0.08, FINER));
        }
    }
    Ok(rows)
}

/// A porous strip across a channel.
struct Strained {
    /// Drag of the strip over what Taylor's theory gives.
    drag: f64,
    /// Rms of the drag about its mean, over that mean.
    unsteady: f64,
    /// Speed of the air in the strip over U: measured, and by Taylor's theory.
    speed: [f64; 2],
}

/// Places of the strip from the start of the channel \[spacings\]: all places that differ for nodes three spacings
/// apart.
const PLACES: [f64; 3] = [22.0, 23.0, 24.0];

/// Part of the channel that the strip takes.
pub const STRIP_BLOCKAGE: f64 = 8.0 / 36.0;

/// The air in a porous strip across a channel over U, at steps of 1.38 ms.
pub fn in_strip(gpu: &Gpu, k: f64) -> Result<f64, Error> {
    Ok(Strained::new(gpu, k, 1.38e-3, PLACES[1])?.speed[0])
}

impl Strained {
    fn new(gpu: &Gpu, k: f64, step: f64, place: f64) -> Result<Self, Error> {
        let wanted = through(k, STRIP_BLOCKAGE);
        let fence = Fence::strip(k, step, place);
        let felt = fence.felt(gpu, 0.15, 0.1)?;
        let area = 8.0 * spacing() * fence.length();
        Ok(Self {
            drag: felt.force / (0.5 * REST_DENSITY * felt.flux.powi(2) * area) / (k * wanted * wanted),
            unsteady: felt.unsteady / felt.force,
            speed: [felt.speed / felt.flux, wanted],
        })
    }
}

/// A porous strip across a channel, at the paper's step and half of it.
pub(crate) fn strip(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (k, step, within) in
        [(0.25, 1.38e-3, 0.02), (1.0, 1.38e-3, 0.03), (4.0, 1.38e-3, 0.05), (1.0, 0.69e-3, 0.02), (4.0, 0.69e-3, 0.05)]
    {
        let strips: Vec<Strained> =
            PLACES.iter().map(|place| Strained::new(gpu, k, step, *place)).collect::<Result<_, _>>()?;
        let over = |what: fn(&Strained) -> f64| mean(strips.iter().map(what));
        let name = format!("porous strip, k = {k}, {} ms", 1e3 * step);
        rows.push(Row::new(format!("{name}: drag over the formula's"), 1.0, over(|s| s.drag), within, STRIP));
        rows.push(Row::new(format!("{name}: air in it over U"), strips[0].speed[1], over(|s| s.speed[0]), 0.08, STRIP));
        rows.push(Row::new(format!("{name}: rms of the drag over it"), 0.015, over(|s| s.unsteady), 0.015, STEADY));
    }
    Ok(rows)
}

/// A porous strip at a step and half of it.
pub(crate) fn strip_halved(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for k in [1.0, 4.0] {
        let drag = |step: f64| Ok::<_, Error>(Strained::new(gpu, k, step, PLACES[0])?.drag);
        let gap = drag(0.69e-3)? - drag(0.345e-3)?;
        let name = format!("porous strip, k = {k}: drag at 0.69 ms off that at 0.345 ms, over the formula's");
        rows.push(Row::new(name, 0.0, gap, 0.02, HALVED));
    }
    Ok(rows)
}

/// Steps in which a tuft is blown.
const STEPS: u64 = 30;

/// The momentum that air loses to a tuft in whole steps is that which the tuft gets; a single exchange loses energy.
fn kept(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let hair = Hair::drawn(12, 10, 0.045, Roots::disc([0.03, 0.055, 0.03], 0.012));
    let fibre = Fibre { fibres_per_strand: 36.0, ..Fibre::default() };
    let scene = afloat(STEP, still([0.08, 0.06, 0.06]), [Hair { fibre, ..hair }]);
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
        let impulses = vectors(&engine.read(&engine.state().drag_impulse)?);
        for (j, air) in impulses.into_iter().zip(engine.read(&engine.state().sampled)?) {
            given += f64::from(2.0 * air.filled).min(1.0) * j;
            size += j.length();
        }
    }
    let frame = simulation.frame()?;
    let change = momentum(&frame.air.velocities) - before;
    let name = "stream past a tuft, 30 steps: air's loss off the sum of impulses";
    let mut rows = vec![Row::new(name, 0.0, (change + given).length() / size, 1e-5, MOMENTUM)];

    // The same air and hair, as a state that stages are run on.
    initial.air.positions = vectors(&frame.air.positions);
    initial.air.velocities = vectors(&frame.air.velocities);
    initial.hair.positions = vectors(&frame.hair.positions);
    initial.hair.velocities = vectors(&frame.hair.velocities);
    let turned = frame.hair.orientations.iter().map(|q| glam::DQuat::from_array(q.map(f64::from)).normalize());
    initial.hair.orientations = turned.collect();
    let points = initial.hair.positions.len();
    let mut runner = Runner::new(gpu, &scene, &initial)?;
    runner.run(|r, plan| {
        step::forcing::record(r, plan);
        step::neighbours::record(r, plan);
        step::fluid::record(r, plan);
    })?;
    let free = runner.read(|s| &s.new_velocity)?;
    runner.run(|r, plan| {
        step::forcing::record(r, plan);
        step::neighbours::record(r, plan);
        step::fluid::record(r, plan);
        step::rods::record(r, plan);
    })?;
    let slowed = runner.read(|s| &s.new_velocity)?;
    let impulses = runner.read(|s| &s.drag_impulse)?;
    let places = runner.read(|s| &s.predicted)?;
    let starts = runner.read(|s| &s.position)?;
    let air = || free[points..].iter().zip(&slowed[points..]);
    let change: f64 = air().map(|(a, b)| 0.5 * mass * (*b - *a).dot(*b + *a)).sum();
    // Euler's first step: a point's velocity is its way.
    let work: f64 = (0..points).map(|i| impulses[i].dot((places[i] - starts[i]) / runner.p.step)).sum();
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
