//! Air in the order of cells: the order in memory changes from step to step, and a caller sees stable ids.

use glam::DVec3;
use rand::{SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64;
use windswept::{Simulation, ops::Particles};
use windswept_scene::{Band, Filter, FluidSolver, InitialState, Scene};

use crate::support::{self, MASS, RADIUS, VOLUME};

/// Side of the box \[m\].
const SIDE: f64 = 0.06;
/// Speed of the vortex \[m/s\].
const SPEED: f64 = 1.0;

/// Air in a box, listed in no order, which a vortex stirs.
fn stirred() -> InitialState {
    let cells = (SIDE / VOLUME.cbrt()).round() as usize;
    let mut positions: Vec<_> = (0..cells.pow(3))
        .map(|i| DVec3::new((i % cells) as f64, (i / cells % cells) as f64, (i / cells / cells) as f64) + 0.5)
        .map(|x| SIDE / cells as f64 * x)
        .collect();
    positions.shuffle(&mut Pcg64::seed_from_u64(5));
    let turn = std::f64::consts::TAU / SIDE;
    let vortex = |x: &DVec3| SPEED * DVec3::new((turn * x.y).sin(), (turn * x.x).sin(), 0.3);
    let mut initial = support::air(DVec3::splat(SIDE), positions);
    initial.air.velocities = initial.air.positions.iter().map(vortex).collect();
    initial
}

/// Scenes with either solver; in the second the band filter sorts air again, into the cells of its grid.
fn scenes() -> [Scene; 2] {
    let mut with_bands = support::scene();
    with_bands.fluid.solver = Some(FluidSolver::Divergence);
    with_bands.turbulence.filter = Some(Filter::default());
    with_bands.turbulence.speed = Some(SPEED);
    with_bands.turbulence.bands = vec![Band { scale: 0.006, strength: 3.0, intensity: 0.3 }];
    [support::scene(), with_bands]
}

fn vectors(rows: &[[f32; 3]]) -> Vec<DVec3> {
    rows.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect()
}

/// Distance through the faces of the box \[m\].
fn gap(a: DVec3, b: DVec3) -> f64 {
    let gap = a - b;
    (gap - SIDE * (gap / SIDE).round()).length()
}

/// Mean distance of each particle from the next in a list \[kernel radii\].
fn to_next(positions: &[DVec3]) -> f64 {
    positions.windows(2).map(|pair| gap(pair[0], pair[1])).sum::<f64>() / (positions.len() - 1) as f64 / RADIUS
}

/// In memory a particle is near the one before it, whatever order the air came in. By their ids particles go as their
/// velocities say, and every particle has a slot.
#[test]
fn air_lies_in_memory_as_it_lies_in_the_box() {
    for scene in scenes() {
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, stirred()).unwrap();
        let mut before = simulation.frame().unwrap().air;
        let (mut farthest, mut moved) = (0.0_f64, 0);
        for _ in 0..36 {
            let slots = simulation.engine().slots().unwrap();
            simulation.step(1).unwrap();
            let now = simulation.frame().unwrap().air;
            let rows = vectors(&before.positions).into_iter().zip(vectors(&before.velocities));
            for ((x, v), after) in rows.zip(vectors(&now.positions)) {
                farthest = farthest.max(gap(x + simulation.dt() * v, after) / VOLUME.cbrt());
            }
            let next = simulation.engine().slots().unwrap();
            moved += next.ids().iter().zip(slots.ids()).filter(|(a, b)| a != b).count();
            let mut ids = next.ids().to_vec();
            ids.sort_unstable();
            assert!(ids.into_iter().eq(0..before.positions.len() as u32));
            before = now;
        }
        let engine = simulation.engine();
        let memory: Vec<_> =
            engine.read(&engine.state().position).unwrap().iter().map(|x| [x[0], x[1], x[2]]).collect();
        let (in_memory, by_id) = (to_next(&vectors(&memory)), to_next(&vectors(&before.positions)));
        println!(
            "{:?}: {farthest:.3} spacings from where velocities lead; to the next {in_memory:.3} h in memory, \
             {by_id:.2} h by id; {moved} moves",
            scene.fluid.solver
        );
        assert!(moved > before.positions.len(), "slots hardly change");
        assert!(farthest < 0.4, "a particle jumped");
        assert!(in_memory < 0.8 && by_id > 2.5);
    }
}

/// Quantities of a simulation at its particles are by their ids: single passes find the same at the places of a frame.
#[test]
fn quantities_go_by_id() {
    let [_, scene] = scenes();
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, stirred()).unwrap();
    simulation.step(12).unwrap();
    let frame = simulation.frame().unwrap().air;
    let rows = |rows: &[[f32; 3]]| -> Vec<_> { rows.iter().map(|x| x.map(f64::from)).collect() };
    let (positions, velocities) = (rows(&frame.positions), rows(&frame.velocities));
    let particles = Particles {
        velocities: &velocities,
        mass: MASS,
        rest_density: MASS / VOLUME,
        radius: RADIUS,
        bounds: Some([SIDE; 3]),
        ..Particles::at(&positions)
    };
    let gpu = support::gpu();
    let apart = |got: &[f32], wanted: &[f32]| {
        assert_eq!(got.len(), wanted.len());
        let most = wanted.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        got.iter().zip(wanted).map(|(a, b)| (a - b).abs() / most).fold(0.0, f32::max)
    };
    let density: Vec<_> = particles.density(&gpu).unwrap().iter().map(|rho| rho * (VOLUME / MASS) as f32).collect();
    let length = |v: &[f32; 3]| v.iter().map(|x| x * x).sum::<f32>();
    let vorticity: Vec<_> = particles.vorticity(&gpu).unwrap().iter().map(|omega| length(omega).sqrt()).collect();
    let band = particles.band_velocity(&gpu, 0.006, Filter::default()).unwrap();
    let energy: Vec<_> = band.iter().map(|u| 0.5 * length(u)).collect();
    let off = [
        apart(&simulation.density().unwrap(), &density),
        apart(&simulation.air_vorticity().unwrap(), &vorticity),
        apart(&simulation.band_energy().unwrap(), &energy),
    ];
    println!("density, vorticity and energy off by {off:?}");
    assert!(off.iter().all(|off| *off < 1e-6), "{off:?}");
}

/// Rows that a caller gives go to the particles of their ids, and an array that is not given stays theirs.
#[test]
fn air_is_put_where_its_ids_say() {
    let [scene, _] = scenes();
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, stirred()).unwrap();
    simulation.step(12).unwrap();
    let before = simulation.frame().unwrap().air;
    let n = before.positions.len();
    let velocities: Vec<_> = (0..n).map(|i| DVec3::new(i as f64 / n as f64, 0.5, -0.25)).collect();
    simulation.set_air(None, Some(&velocities)).unwrap();
    let now = simulation.frame().unwrap().air;
    assert_eq!(now.positions, before.positions);
    assert!(now.velocities.iter().zip(&velocities).all(|(got, given)| *got == given.as_vec3().to_array()));
    let mut positions = vectors(&before.positions);
    positions.rotate_left(n / 3);
    simulation.set_air(Some(&positions), None).unwrap();
    let after = simulation.frame().unwrap().air;
    assert_eq!(vectors(&after.positions), positions);
    assert_eq!(after.velocities, now.velocities);
    simulation.step(1).unwrap();
    let went = vectors(&simulation.frame().unwrap().air.positions);
    let off = went.iter().zip(&positions).zip(&velocities).map(|((got, x), v)| gap(*got, *x + simulation.dt() * *v));
    assert!(off.fold(0.0, f64::max) < 0.4 * VOLUME.cbrt(), "the step took other particles");
}

/// Where nothing asks for neighbours nothing is sorted: air stays in its slots and moves all the same.
#[test]
fn air_that_does_not_meet_stays_in_its_slots() {
    let mut scene = support::scene();
    scene.fluid.iterations = 0;
    (scene.viscosity.hair, scene.viscosity.air) = (Some(0.0), Some(0.0));
    let initial = stirred();
    let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial.clone()).unwrap();
    simulation.step(20).unwrap();
    assert!(simulation.density().unwrap().is_empty());
    assert!(simulation.engine().slots().unwrap().ids().iter().copied().eq(0..initial.air.positions.len() as u32));
    let way = 20.0 * simulation.dt();
    let rows = initial.air.positions.iter().zip(&initial.air.velocities);
    let now = vectors(&simulation.frame().unwrap().air.positions);
    let off = rows.zip(now).map(|((x, v), now)| gap(*x + way * *v, now)).fold(0.0, f64::max);
    assert!(off < 1e-6, "{off} m from the straight way");
}
