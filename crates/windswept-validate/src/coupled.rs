//! Hair and air together: hair receives the momentum that air loses.

use glam::DVec3;
use windswept_engine::{Gpu, Simulation};
use windswept_reference::{self as reference, Parameters, State, fluid, step::unobserved};
use windswept_scene::{Fibre, FluidSolver, Hair, InitialState, Integrator, Model, Roots, Scene};
use windswept_shaders::common::rod::RodPoint;

use crate::{
    Error, Row,
    air::{STEP, ran, vectors},
    scenes::{afloat, still},
};

const DRAG: &str = "no formula: measured, 12 strands of 60 mm in a stream of 3 m/s, 41 ms; the tolerance keeps it \
    positive";
const BALANCE: &str = "Newton's third law, rods by BDF2; roots loose, 20 times as heavy as the next point; gain over loss: \
    rounding, at most 2.0e-7 off with pbf and 3.2e-7 with divergence at nine speeds of the stream from 1.5 to 4.5 m/s, margin 2; change of \
    all: measured 1.8e-9 and 1.5e-8, margin 4";
const HELD: &str = "Newton's third law, rods by Euler, no XSPH: air's and hair's change and what held roots take, from the \
    rods' moves and, by the reference, from the density constraint; over air's loss; measured 2.0e-7; margin 4";
const SHARES: &str = "no formula: measured, of air's loss, 6 strands of 30 mm in a stream of 3 m/s, 41 ms; the tolerance keeps \
    the sign";

/// Direction of strands that stand across the stream.
const UP: [f64; 3] = [0.0, 1.0, 0.0];
/// Velocity of the air at the start \[m/s\].
const STREAM: DVec3 = DVec3::new(3.0, 0.0, 0.0);
/// Mass of a loose root over that of the point after it: the momentum that the root receives can be read from its
/// velocity.
const ROOT_MASS: f64 = 20.0;
/// Steps of a run, 41 ms.
const STEPS: u64 = 30;

/// Rows of a stream past strands: hair and its roots, loose and heavy or clamped, receive the momentum that the air
/// loses.
pub(crate) fn drag(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = loose(gpu, FluidSolver::Pbf, 2.6e-3, 7e-9)?;
    rows.extend(loose(gpu, FluidSolver::Divergence, 12.1e-3, 6e-8)?);
    rows.extend(clamped(gpu)?);
    Ok(rows)
}

/// Hair of a hundred fibres a strand that is one fluid with air without wind, in a periodic box.
pub(crate) fn windless(size: [f64; 3], hair: Hair) -> Scene {
    let fibre = Fibre { fibres_per_strand: 100.0, ..hair.fibre };
    let mut scene = afloat(STEP, still(size), [Hair { fibre, ..hair }]);
    scene.interaction.model = Some(Model::Particles);
    scene
}

fn loose(gpu: &Gpu, solver: FluidSolver, drag: f64, balance: f64) -> Result<Vec<Row>, Error> {
    let hair = Hair::drawn(12, 12, 0.06, Roots::disc([0.04, 0.01, 0.04], 0.012).toward(UP));
    let mut scene = windless([0.12, 0.08, 0.08], hair);
    scene.fluid.solver = Some(solver);
    // The drag of 12.1 mN was found without a viscosity of small eddies.
    scene.viscosity.smagorinsky = Some(0.0);
    let solver = solver.word();
    let mut initial = InitialState::new(&scene)?;
    initial.air.velocities.fill(STREAM);
    let hair = &mut initial.hair;
    let roots: Vec<usize> = (0..hair.len()).map(|s| hair.points(s).start).collect();
    for &root in &roots {
        hair.inverse_mass[root] = hair.inverse_mass[root + 1] / ROOT_MASS;
    }
    let masses: Vec<f64> = hair.inverse_mass.iter().map(|w| 1.0 / w).collect();
    let air_mass = initial.air.mass;
    let simulation = ran(gpu, &scene, initial, STEPS)?;
    let frame = simulation.frame()?;

    let hair: Vec<DVec3> = vectors(&frame.hair.velocities).iter().zip(&masses).map(|(v, m)| *m * *v).collect();
    let gain: DVec3 = hair.iter().sum();
    let of_roots: DVec3 = roots.iter().map(|&root| hair[root]).sum();
    let loss: DVec3 = lasting(&simulation)?.into_iter().map(|v| air_mass * (STREAM - v)).sum();
    let whole = air_mass * frame.air.velocities.len() as f64 * STREAM.length();
    Ok(vec![
        Row::new(format!("stream past strands, {solver}: drag"), drag, gain.x / simulation.time(), 1e-3, DRAG)
            .in_unit("N"),
        Row::new(
            format!("stream past strands, {solver}: hair's gain over air's loss"),
            1.0,
            gain.x / loss.x,
            6.4e-7,
            BALANCE,
        ),
        Row::new(
            format!("stream past strands, {solver}: change of all momentum"),
            0.0,
            (gain - loss).length() / whole,
            balance,
            BALANCE,
        ),
        Row::new(format!("stream past strands, {solver}: share of the roots"), 0.44, of_roots.x / gain.x, 0.2, DRAG),
    ])
}

/// Velocities that air will have \[m/s\]: half of what pressure changed one by in the last step is still to come, since
/// BDF2 hands on a third of it, then a ninth, and so on.
pub(crate) fn lasting(simulation: &Simulation) -> Result<Vec<DVec3>, Error> {
    let air = vectors(&simulation.frame()?.air.velocities);
    let engine = simulation.engine();
    let pressed = engine.read(&engine.state().pressed_before)?;
    // With solver pbf nothing is kept of pressures, and nothing is to come.
    let changes = pressed.iter().skip(pressed.len().saturating_sub(air.len()));
    let coming = vectors(&engine.slots()?.by_id(changes.map(|pressed| pressed.change)));
    Ok(air.iter().zip(coming).map(|(v, change)| *v + 0.5 * change).collect())
}

/// Rows of clamped roots: they take the momentum that air and hair lose.
fn clamped(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let hair = Hair::drawn(6, 7, 0.03, Roots::disc([0.025, 0.01, 0.025], 0.01).toward(UP));
    let mut scene = windless([0.07, 0.05, 0.05], hair);
    // Only two things act on roots: the density constraint and the first segment.
    scene.rods.integrator = Some(Integrator::Euler);
    scene.fluid.solver = Some(FluidSolver::Pbf);
    (scene.viscosity.hair, scene.viscosity.air) = (Some(0.0), Some(0.0));
    let mut initial = InitialState::new(&scene)?;
    initial.air.velocities.fill(STREAM);
    let p = Parameters::new(&scene.check()?, &initial);
    let mut s = State::new(&initial, p.step);
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let momentum = |s: &State| -> (DVec3, DVec3) {
        let of = |(v, w): (&DVec3, &f64)| if *w > 0.0 { *v / *w } else { DVec3::ZERO };
        let each: Vec<DVec3> = s.velocity.iter().zip(&s.inverse_mass).map(of).collect();
        (each[..p.hair_points].iter().sum(), each[p.hair_points..].iter().sum())
    };
    let (hair_before, air_before) = momentum(&s);
    let (mut by_rods, mut by_density) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..STEPS {
        by_density += density_on_roots(&s, &p);
        simulation.step(1)?;
        let frame = simulation.frame()?;
        let both = |hair: &[[f32; 3]], air: &[[f32; 3]]| [vectors(hair), vectors(air)].concat();
        s.position = both(&frame.hair.positions, &frame.air.positions);
        s.velocity = both(&frame.hair.velocities, &frame.air.velocities);
        by_rods += rods_on_roots(&simulation, p.step)?;
    }
    let (hair, air) = momentum(&s);
    let (gain, loss) = (hair - hair_before, air_before - air);
    let left = (gain + by_rods + by_density - loss).length() / loss.length();
    let share = |part: DVec3| part.x / loss.x;
    Ok(vec![
        Row::new("stream past clamped strands: hair, roots and air together", 0.0, left, 8e-7, HELD),
        Row::new("stream past clamped strands: taken by roots from rods", 0.95, share(by_rods), 0.3, SHARES),
        Row::new("stream past clamped strands: taken by roots from air", 0.12, share(by_density), 0.1, SHARES),
    ])
}

/// Momentum that the density constraint gives held roots in the next step \[kg m/s\]: that which it would give to roots
/// of mass 1.
fn density_on_roots(s: &State, p: &Parameters) -> DVec3 {
    let mut w = reference::forcing::run(s, p, &mut unobserved);
    reference::neighbours::run(&mut w, p);
    let roots: Vec<usize> = (0..s.hair.len()).map(|strand| s.hair.points(strand).start).collect();
    let mut movable = s.inverse_mass.clone();
    roots.iter().for_each(|&root| movable[root] = 1.0);
    let mut sum = DVec3::ZERO;
    for _ in 0..p.fluid.iterations {
        let (_, lambda) = fluid::density(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near);
        let shift = fluid::correct(p, &w.predicted, &movable, &s.volume, &w.near, &lambda);
        for (i, shift) in shift.into_iter().enumerate() {
            if roots.contains(&i) { sum += shift / p.step } else { w.predicted[i] += shift }
        }
    }
    sum
}

/// Momentum that held roots had from the rods in the last step \[kg m/s\], by Euler: against it the rods moved all
/// other points, −dt Σ (x − free)/W.
fn rods_on_roots(simulation: &Simulation, step: f64) -> Result<DVec3, Error> {
    let engine = simulation.engine();
    let points = engine.read(&engine.state().rod_points)?;
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let of = |point: &RodPoint| {
        (vector(point.free) - vector(point.displacement)) * (step / f64::from(point.effective_inverse_mass))
    };
    Ok(points.iter().filter(|point| point.effective_inverse_mass > 0.0).map(of).sum())
}
