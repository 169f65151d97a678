//! A real hair in a steady wind, beside the curve in which it must stand: in the model `drag` at steps from 0.35 to 16
//! ms, and in `two-way`, whose air it slows. Then the two limits of it: a hair without weight in thin air, and one
//! without stiffness.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use windswept_engine::{Gpu, Simulation};
use windswept_reference::{
    elastica::{Hair, REAL},
    tables,
};
use windswept_scene::{Air, Fibre, InitialState, Model, Roots, Scene};

use crate::{
    Error, Row,
    air::{Cloud, SIMPLE, mean, vectors},
    rods::stiffness,
    scenes::in_wind,
};

const TABLE: &str = "hair_in_wind.csv, part (b); 34 segments by themselves are 2.8e-4 and 7.4e-4 L off";
const SPREAD: &str = "the drag is implicit: what a hair rests in has no step in it";
const STORM: &str = "windswept_reference::elastica; 34 segments by themselves are 1.4e-3 L off";
const STILL: &str = "steady wind, no damping: any motion is the integrator's; BDF2 alone has 1.5e-2 L at 5 ms";
const OTHER: &str = "windswept_reference::elastica, at values that no table has";
const ORDER: &str = "second order in segments: (2)² = 4 from 12 to 24 and from 24 to 48; measured 3.8 and 3.9";
const SUDDEN: &str = "no formula: 1 ms beside its eighth, wanted 1e-3 L; a wind that is there at once leaves 1.2e-3 and \
    2.7e-3 L, half of it by the first step, which is Euler's; margin 1.2 there";
const PARTICLES: &str = "hair_in_wind.csv, part (b); box of 24 x 16 x 6 spacings, from rest in the wind";
const ON_ITS_WAY: &str = "the model drag at the same step: XSPH is between strands, and leaves a lone one alone";
const TREMBLES: &str = "no formula: steady wind, so any motion is the air's noise; measured 1.1e-5 to 3.3e-5 L, most of it \
    how the flow settles; margin 1.5";
const SETTLED: &str =
    "no formula: steady wind, so any motion is the air's noise; measured 1.6e-6 to 6.2e-6 L; margin 1.6";
const BENT: &str = "windswept_reference::elastica with quadratic drag only (C_d = 1), 68 segments";
const SLOPE: &str = "the Vogel exponent of a hair (Alben, Shelley & Zhang 2002), reached as Ca grows; the elastica has -0.667 \
    here, 68 segments -0.669";
const LIMP: &str = "drag across the hair = weight across it, no stiffness; the hair has 1e-4 of a real one's, measured away \
    from the clamp";

/// Segments of a strand.
const SEGMENTS: usize = 34;
/// Damping that brings a strand to rest soon and leaves where it rests \[1/s\].
const DAMPING: f64 = 35.0;
/// Looks at a tip, over [`WATCHED`] seconds.
const LOOKS: u32 = 20;
const WATCHED: f64 = 0.1;

/// How a hair is blown.
struct Blown {
    hair: Hair,
    segments: usize,
    step: f64,
    model: Model,
    damping: f64,
    /// Time over which the wind rises \[s\].
    ramp: f64,
}

impl Blown {
    fn drag(hair: Hair, step: f64) -> Self {
        Self { hair, segments: SEGMENTS, step, model: Model::Drag, damping: DAMPING, ramp: 0.0 }
    }

    /// The scene of the blown hair, in this air with its wind, and the strand hanging straight down from `root`.
    fn scene(&self, root: DVec3, air: Air) -> Scene {
        let Hair { radius, density, length, gravity, wind, viscosity, .. } = self.hair;
        // The strand bends like the hair and stretches like a real one, however limp.
        let (stretch, bend) = (REAL.youngs_modulus * PI * radius.powi(2), self.hair.bend_stiffness());
        let fibre = Fibre { radius, density, stiffness: stiffness(stretch, bend), ..Fibre::default() };
        let roots = Roots::disc(root.to_array(), 1e-9);
        let strand = windswept_scene::Hair::drawn(1, self.segments as u32 + 1, length, roots);
        let air = Air { ramp: self.ramp, kinematic_viscosity: viscosity, ..air.wind([wind, 0.0, 0.0]) };
        let mut scene = in_wind(self.step, air, [windswept_scene::Hair { fibre, ..strand }]);
        scene.interaction.model = Some(self.model);
        scene.gravity = [0.0, -gravity, 0.0];
        (scene.rods.sleep, scene.rods.damping) = (false, self.damping);
        scene
    }

    /// The hair in the model `drag`, at a time after the wind has set in \[s\].
    fn after(&self, gpu: &Gpu, time: f64) -> Result<Simulation, Error> {
        let scene = self.scene(DVec3::ZERO, Air::default());
        let mut simulation = Simulation::new(gpu, &scene)?;
        simulation.step((time / self.step).round() as u64)?;
        Ok(simulation)
    }

    /// The hair in the model `two-way`, in a box of so many spacings of air: at rest in the shape that it has in `drag`
    /// at a time after the wind has set in \[s\].
    fn in_air(&self, gpu: &Gpu, cells: [usize; 3], settled: f64) -> Result<Simulation, Error> {
        let settled = Self::drag(self.hair, 1.38e-3).after(gpu, settled)?.frame()?.hair;
        let cloud = Cloud::lattice(cells, SIMPLE).jittered(0.05, 7).moving(|_| DVec3::X * self.hair.wind);
        let root = cloud.size * DVec3::new(0.45, 0.5, 0.5) + 0.5 * self.hair.length * DVec3::Y;
        let scene = self.scene(root, Air::filling(cloud.size.to_array()));
        let mut hair = InitialState::new(&scene)?.hair;
        let places = vectors(&settled.positions);
        let first = hair.positions[0] - places[0];
        hair.positions = places.into_iter().map(|x| x + first).collect();
        hair.orientations =
            settled.orientations.iter().map(|q| DQuat::from_array(q.map(f64::from)).normalize()).collect();
        Ok(Simulation::with_state(gpu, &scene, InitialState { hair, ..cloud.initial() })?)
    }
}

/// Tip from root over L.
fn tip(simulation: &Simulation, hair: &Hair) -> Result<DVec3, Error> {
    let points = vectors(&simulation.frame()?.hair.positions);
    Ok((points[points.len() - 1] - points[0]) / hair.length)
}

/// Mean of the tip over the next [`WATCHED`] seconds, and its rms about the mean.
fn watched(simulation: &mut Simulation, hair: &Hair, step: f64) -> Result<(DVec3, f64), Error> {
    let stride = (WATCHED / f64::from(LOOKS) / step).round().max(1.0) as u64;
    let mut tips = Vec::new();
    for _ in 0..LOOKS {
        simulation.step(stride)?;
        tips.push(tip(simulation, hair)?);
    }
    let middle = tips.iter().sum::<DVec3>() / f64::from(LOOKS);
    Ok((middle, mean(tips.iter().map(|tip| tip.distance_squared(middle))).sqrt()))
}

fn off(tip: DVec3, wanted: [f64; 2]) -> f64 {
    (tip - DVec3::new(wanted[0], -wanted[1], 0.0)).length()
}

/// Where a real hair stands in a wind that nothing slows, and how it gets there.
pub(crate) fn prescribed(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for row in tables::hair_in_wind().iter().filter(|row| row.gravity > 0.0) {
        let hair = Hair { wind: row.wind, ..REAL };
        let (mut low, mut high, mut worst) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0_f64);
        for step in [0.35e-3, 1.38e-3, 5e-3, 16e-3] {
            let mut simulation = Blown::drag(hair, step).after(gpu, 0.35)?;
            let (tip, _) = watched(&mut simulation, &hair, step)?;
            (low, high) = (low.min(tip), high.max(tip));
            worst = worst.max(off(tip, [row.tip, row.drop]));
        }
        let name = format!("hair at {} m/s, steps of 0.35, 1.38, 5, 16 ms", row.wind);
        rows.push(Row::new(format!("{name}: tip off the solution"), 0.0, worst, 1.5e-3, TABLE).in_unit("L"));
        rows.push(Row::new(format!("{name}: spread"), 0.0, (high - low).length(), 2e-4, SPREAD).in_unit("L"));
    }
    let storm = Hair { wind: 10.0, ..REAL };
    for step in [0.35e-3, 1.38e-3, 5e-3, 16e-3] {
        let blown = Blown { damping: 0.0, ..Blown::drag(storm, step) };
        let mut simulation = blown.after(gpu, 1.0)?;
        let (tip, rms) = watched(&mut simulation, &storm, step)?;
        let name = format!("hair at 10 m/s, {} ms", 1e3 * step);
        rows.push(
            Row::new(format!("{name}: tip off the solution"), 0.0, off(tip, storm.tip()), 3e-3, STORM).in_unit("L"),
        );
        rows.push(Row::new(format!("{name}: rms of the tip"), 0.0, rms, 1e-3, STILL).in_unit("L"));
    }
    for (length, wind, step, bound) in [
        (0.03, 6.5, 0.9e-3, 1.5e-3),
        (0.03, 10.0, 16e-3, 1.5e-3),
        (0.08, 1.7, 3e-3, 1.5e-3),
        (0.11, 0.5, 7e-3, 1.5e-3),
        (0.15, 2.6, 4e-3, 3e-3),
    ] {
        let hair = Hair { length, wind, ..REAL };
        let simulation = Blown { damping: 10.0, ..Blown::drag(hair, step) }.after(gpu, 20.0 * length)?;
        let name = format!("hair of {:.0} mm at {wind} m/s, {} ms: tip off the solution", 1e3 * length, 1e3 * step);
        rows.push(Row::new(name, 0.0, off(tip(&simulation, &hair)?, hair.tip()), bound, OTHER).in_unit("L"));
    }
    let error = |segments: usize| -> Result<f64, Error> {
        let simulation = Blown { segments, ..Blown::drag(REAL, 2e-3) }.after(gpu, 1.4)?;
        Ok(off(tip(&simulation, &REAL)?, REAL.tip()))
    };
    let (coarse, middle, fine) = (error(12)?, error(24)?, error(48)?);
    rows.push(Row::new("hair at 3 m/s: error of 12 segments over that of 24", 4.0, coarse / middle, 0.4, ORDER));
    rows.push(Row::new("hair at 3 m/s: error of 24 segments over that of 48", 4.0, middle / fine, 0.4, ORDER));
    for (wind, ramp, bound) in [(1.0, 0.04, 1e-3), (3.0, 0.04, 1e-3), (1.0, 0.0, 1.5e-3), (3.0, 0.0, 3.3e-3)] {
        let hair = Hair { wind, ..REAL };
        let blown = |step: f64| Blown { damping: 0.0, ramp, ..Blown::drag(hair, step) };
        let [coarse, fine] = [1e-3, 0.125e-3].map(|step| tip(&blown(step).after(gpu, 0.04)?, &hair));
        let name = format!("{wind} m/s within {} ms: tip after 40 ms at 1 ms from that at 0.125 ms", 1e3 * ramp);
        rows.push(Row::new(name, 0.0, (coarse? - fine?).length(), bound, SUDDEN).in_unit("L"));
    }
    Ok(rows)
}

/// Rows of where the hair stands in air that it slows, and how little it trembles.
pub(crate) fn two_way(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for row in tables::hair_in_wind().iter().filter(|row| row.gravity > 0.0) {
        for step in [1.38e-3, 5e-3] {
            let hair = Hair { wind: row.wind, ..REAL };
            let blown = Blown { model: Model::TwoWay, damping: 0.0, ..Blown::drag(hair, step) };
            let mut simulation = blown.in_air(gpu, [24, 16, 6], 0.6)?;
            simulation.step((0.12 / step).round() as u64)?;
            let (tip, rms) = watched(&mut simulation, &hair, step)?;
            let name = format!("two-way hair at {} m/s, {} ms", row.wind, 1e3 * step);
            let wanted = [row.tip, row.drop];
            rows.push(
                Row::new(format!("{name}: tip off the solution"), 0.0, off(tip, wanted), 3e-3, PARTICLES).in_unit("L"),
            );
            rows.push(Row::new(format!("{name}: rms of the tip"), 0.0, rms, 5e-5, TREMBLES).in_unit("L"));
            // By now 0.12 s and the time that was watched have passed.
            simulation.step(((0.6 - 0.12 - WATCHED) / step).round() as u64)?;
            let (_, rms) = watched(&mut simulation, &hair, step)?;
            rows.push(Row::new(format!("{name}: rms of the tip after 0.6 s"), 0.0, rms, 1e-5, SETTLED).in_unit("L"));
        }
    }
    let free = Blown { damping: 0.0, ..Blown::drag(REAL, 1.25e-3) };
    let wanted = tip(&free.after(gpu, 0.04)?, &REAL)?;
    let mut simulation = Blown { model: Model::TwoWay, ..free }.in_air(gpu, [24, 16, 6], 0.0)?;
    simulation.step((0.04 / 1.25e-3_f64).round() as u64)?;
    let gap = (tip(&simulation, &REAL)? - wanted).length();
    rows.push(
        Row::new("two-way hair 40 ms after a sudden 3 m/s: tip off drag's", 0.0, gap, 1e-3, ON_ITS_WAY).in_unit("L"),
    );
    Ok(rows)
}

/// A hair that only bends loses drag as Ca^(-2/3) in the end, and one that only weighs hangs as a straight line.
pub(crate) fn limits(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    let mut drags = Vec::new();
    for cauchy in [1.0, 10.0, 100.0, 1e3] {
        let hair = Hair::with_cauchy_number(cauchy);
        let blown = Blown { segments: 68, damping: 60.0, ..Blown::drag(hair, 1.38e-3) };
        let got = force(&blown.after(gpu, 1.5)?)?.x / blown.step / (hair.length * hair.drag(0.0)[0]);
        let name = format!("hair without weight, Ca = {cauchy}: R, its drag over that of a stiff one");
        let wanted = hair.reconfiguration();
        rows.push(Row::new(name, wanted, got, 0.01 * wanted, BENT));
        drags.push(got);
    }
    // Ca goes with the square of the wind.
    let slope = 2.0 * (drags[3] / drags[2]).log10();
    rows.push(Row::new(
        "hair without weight, Ca = 100 to 1000: R goes with this power of the wind",
        -2.0 / 3.0,
        slope,
        0.01,
        SLOPE,
    ));
    for wind in [1.0, 3.0] {
        let hair = Hair { wind, youngs_modulus: 1e-4 * REAL.youngs_modulus, ..REAL };
        let simulation = Blown::drag(hair, 1.38e-3).after(gpu, 1.2)?;
        let points = vectors(&simulation.frame()?.hair.positions);
        let beyond = points[SEGMENTS] - points[SEGMENTS / 2];
        let name = format!("limp hair at {wind} m/s: angle from the vertical");
        let (wanted, got) = (hair.limp_angle().to_degrees(), beyond.x.atan2(-beyond.y).to_degrees());
        rows.push(Row::new(name, wanted, got, 0.05, LIMP).in_unit("degrees"));
    }
    Ok(rows)
}

/// Impulse that the air gave the hair in the last step \[N s\].
fn force(simulation: &Simulation) -> Result<DVec3, Error> {
    let engine = simulation.engine();
    Ok(vectors(&engine.read(&engine.state().drag_impulse)?).into_iter().sum())
}
