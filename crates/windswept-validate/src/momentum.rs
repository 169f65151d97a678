//! Momentum, which nothing inside may change.

use std::f64::consts::TAU;

use glam::DVec3;
use windswept_engine::{Gpu, RunError, Simulation};
use windswept_scene::{End, Fibre, FluidSolver, Hair, InitialState, Roots};
use windswept_shaders::common::integration::BDF2;

use crate::{
    Error, Row,
    air::{self, Cloud, SIMPLE, ran, vectors},
    coupled::{lasting, windless},
    scenes::{afloat, still},
};

const KEPT: &str = "over sum m |v| at the end; 1000 particles stirred at 0.3 m/s; measured 2.3e-8 in 300 steps with pbf, 2.1e-7 in 100 with \
    divergence, whose coarse push is balanced by a sum over all; margin 2 over that: f32";
const BOTH: &str = "over sum m |v| at the end; 4 loose strands by BDF2 in 1700 of air, swirling at 0.3 m/s; measured 1.1e-8, \
    3.8e-8 in 300 steps; margin 2 over that: f32";

const CUT: &str = "over sum |J| of 6 steps; measured 5.6e-7 and 5.4e-7: f32";

/// Steps of a run.
const STEPS: u64 = 100;
/// Speed of a storm that is there at once \[m/s\].
const STORM: f64 = 100.0;
/// Number of steps of a storm.
const STORM_STEPS: u64 = 6;

/// Rows of the momentum Σ m v of air, and of air with loose hair, stirred in a closed periodic box without wind and
/// confinement: it stays.
pub(crate) fn closed_box(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows =
        vec![air_alone(gpu, FluidSolver::Pbf, STEPS, 1.2e-8)?, air_alone(gpu, FluidSolver::Divergence, STEPS, 9e-8)?];
    rows.push(hair_in_air(gpu)?);
    rows.push(streamed(gpu, 0.055, 1320.0, (STORM, 16e-3, STORM_STEPS))?);
    rows.push(streamed(gpu, 0.085, 132.0, (STORM, 5e-3, STORM_STEPS))?);
    rows.push(streamed(gpu, 0.03, 1320.0, (1.0, 1.38e-3, STEPS))?);
    Ok(rows)
}

/// Row of the momentum of hair and air with loose strands in a stream: strands of this density \[kg/m³\] with
/// their roots at this height \[m\], in air of a speed \[m/s\], in so many steps of a length \[s\].
fn streamed(gpu: &Gpu, height: f64, density: f64, (speed, step, steps): (f64, f64, u64)) -> Result<Row, Error> {
    let hair = Hair::drawn(6, 10, 0.045, Roots::disc([0.03, height, 0.03], 0.012));
    let fibre = Fibre { density, ..Fibre::default() };
    let scene = afloat(step, still([0.08, 0.06, 0.06]), [Hair { fibre, root: End::Free, ..hair }]);
    let mut initial = InitialState::new(&scene)?;
    initial.air.velocities.fill(DVec3::X * speed);
    let mut simulation = Simulation::with_state(gpu, &scene, initial)?;
    let (change, exchanged) = exchanged(&mut simulation, steps)?;
    let name = format!("loose strands at {speed} m/s, {steps} steps of {} ms: change of all momentum", 1e3 * step);
    Ok(Row::new(name, 0.0, change.length() / exchanged, 1e-5, CUT))
}

/// Change of the momentum of hair, of which no point is held, and air in so many steps of the model `two-way` \[kg
/// m/s\], less what the mean wind gives where air is thin; and the sum of the impulses |J| that they exchange \[N s\].
/// The steps have no substeps, since the impulses that can be read are those of the last one. BDF2's momentum of a
/// point is m (3 v_n − v_(n−1))/2, Euler's m v_n.
pub(crate) fn exchanged(simulation: &mut Simulation, steps: u64) -> Result<(DVec3, f64), Error> {
    let substeps = simulation.scene().time.substeps;
    if substeps != 1 {
        return Err(
            RunError::Measurement(format!("{substeps} substeps: only the last one's impulses can be read")).into()
        );
    }
    let initial = simulation.initial();
    let air_mass = initial.air.mass;
    let hair_mass: Vec<f64> = initial.hair.inverse_mass.iter().map(|w| 1.0 / w).collect();
    // Velocities of hair, those of the step before, and of air.
    let velocities = |simulation: &Simulation| -> Result<_, Error> {
        let engine = simulation.engine();
        let before: Vec<_> = engine.read(&engine.state().point_history)?.iter().map(|point| point.velocity).collect();
        let frame = simulation.frame()?;
        Ok((vectors(&frame.hair.velocities), vectors(&before), lasting(simulation)?))
    };
    let (mut change, mut exchanged) = (DVec3::ZERO, 0.0);
    let mut start = velocities(simulation)?;
    for _ in 0..steps {
        simulation.step(1)?;
        let engine = simulation.engine();
        let end = velocities(simulation)?;
        let points = engine.read(&engine.state().rod_points)?;
        let sampled = engine.read(&engine.state().sampled)?;
        let impulses = vectors(&engine.read(&engine.state().drag_impulse)?);
        for (i, mass) in hair_mass.iter().enumerate() {
            let (now, earlier) = (end.0[i] - start.0[i], end.1[i] - start.1[i]);
            change += *mass * if points[i].scheme == BDF2 { 1.5 * now - 0.5 * earlier } else { now };
            let impulse = impulses[i];
            exchanged += impulse.length();
            // Where air is thin, the mean wind gives part of the impulse, and air particles do not.
            change -= impulse * (1.0 - f64::from(2.0 * sampled[i].filled)).max(0.0);
        }
        change += air_mass * end.2.iter().zip(&start.2).map(|(end, start)| *end - *start).sum::<DVec3>();
        start = end;
    }
    Ok((change, exchanged))
}

/// The same for the model `particles`, whose impulses cannot be read: in place of them there is the change of the
/// momentum of each point of hair in each step. Returns the number of steps that it ran. The exchange in the step in
/// which hair leaves the box, outside of which the mean wind drags it, does not count, and ends the run.
pub(crate) fn received(simulation: &mut Simulation, steps: u64) -> Result<(DVec3, f64, u64), Error> {
    let initial = simulation.initial().clone();
    let air = initial.air.mass;
    let mass: Vec<f64> = initial.hair.inverse_mass.iter().map(|w| 1.0 / w).collect();
    let inside = |x: &DVec3| {
        let from_corner = *x - initial.air.min;
        from_corner.cmpge(DVec3::ZERO).all() && from_corner.cmple(initial.air.size).all()
    };
    let look = |simulation: &Simulation| -> Result<_, Error> {
        let hair = simulation.frame()?.hair;
        let momenta: Vec<_> = vectors(&hair.velocities).iter().zip(&mass).map(|(v, m)| *m * *v).collect();
        let whole = air * lasting(simulation)?.iter().sum::<DVec3>() + momenta.iter().sum::<DVec3>();
        Ok((vectors(&hair.positions).iter().all(inside), momenta, whole))
    };
    let (_, mut before, start) = look(simulation)?;
    let (mut change, mut received) = (DVec3::ZERO, 0.0);
    for step in 1..=steps {
        simulation.step(1)?;
        let (within, momenta, whole) = look(simulation)?;
        if !within {
            return Ok((change, received, step));
        }
        received += before.iter().zip(&momenta).map(|(before, now)| before.distance(*now)).sum::<f64>();
        (before, change) = (momenta, whole - start);
    }
    Ok((change, received, steps))
}

fn hair_in_air(gpu: &Gpu) -> Result<Row, Error> {
    let hair = Hair::drawn(4, 7, 0.025, Roots::disc([0.03, 0.018, 0.03], 0.006).toward([0.0, 1.0, 0.0]));
    let scene = windless([0.06; 3], Hair { root: End::Free, ..hair });
    let mut initial = InitialState::new(&scene)?;
    let k = TAU / initial.air.size;
    for (v, x) in initial.air.velocities.iter_mut().zip(&initial.air.positions) {
        let at = *x * k;
        *v = 0.3 * DVec3::new(at.y.sin(), at.z.sin(), at.x.sin());
    }
    let hair: Vec<f64> = initial.hair.inverse_mass.iter().map(|w| 1.0 / w).collect();
    let air = initial.air.mass;
    let each = |hair_v: &[DVec3], air_v: &[DVec3]| -> (DVec3, f64) {
        let of_hair = hair_v.iter().zip(&hair).map(|(v, m)| *m * *v);
        let all: Vec<DVec3> = of_hair.chain(air_v.iter().map(|v| air * *v)).collect();
        (all.iter().sum(), all.iter().map(|p| p.length()).sum())
    };
    let (before, _) = each(&initial.hair.velocities, &initial.air.velocities);
    let simulation = ran(gpu, &scene, initial.clone(), STEPS)?;
    let (after, whole) = each(&vectors(&simulation.frame()?.hair.velocities), &lasting(&simulation)?);
    Ok(Row::new(
        "closed box of air and hair: change of momentum in 100 steps",
        0.0,
        (after - before).length() / whole,
        8e-8,
        BOTH,
    ))
}

/// Row of the momentum of stirred air in a closed box, in parts of the speeds that the air starts with.
pub(crate) fn air_alone(gpu: &Gpu, solver: FluidSolver, steps: u64, tolerance: f64) -> Result<Row, Error> {
    let cloud = Cloud::lattice([10; 3], SIMPLE).jittered(0.1, 5).stirred(0.3, 5);
    let mut scene = air::scene();
    scene.fluid.solver = Some(solver);
    let simulation = ran(gpu, &scene, cloud.initial(), steps)?;
    let after = lasting(&simulation)?;
    let change: DVec3 = after.iter().zip(&cloud.velocities).map(|(v, start)| *v - DVec3::from_array(*start)).sum();
    let whole: f64 = cloud.velocities.iter().map(|v| DVec3::from_array(*v).length()).sum();
    let name = format!("closed box of air, {}: change of momentum in {steps} steps", solver.word());
    Ok(Row::new(name, 0.0, change.length() / whole, tolerance, KEPT))
}
