//! weigh, band, deposit, smooth, gather, vorticity, confine, sum, mean, strengthen.

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::internals::{Array, step};
use windswept_reference::{turbulence, wind};
use windswept_scene::{Band, Filter, InitialState, Law, Order, Scene};

use crate::{
    stage::{Stage, crowds, relative},
    support,
};

/// Steps since the start: half of the ramp.
const STEPS: u32 = 18;

/// A law with two bands in a wind on two axes that has not fully risen, with a thin fringe.
fn scene(law: Law, filter: Filter) -> Scene {
    let mut scene = support::scene();
    scene.turbulence.law = law;
    scene.turbulence.filter = filter;
    scene.turbulence.cutoff = if law == Law::Published { 3.0 } else { 4.5 };
    scene.turbulence.conserve_momentum = law == Law::Band;
    scene.turbulence.speed = 3.0;
    // The second shares the grid of the first.
    scene.turbulence.bands = vec![
        Band { scale: 0.0065, strength: 20.0, intensity: 0.3 },
        Band { scale: 0.009, strength: 1.0, intensity: 2.0 },
    ];
    if let Some(air) = &mut scene.air {
        air.wind = [2.0, 0.0, -1.0];
        air.fringe = 0.004;
    }
    scene
}

/// Velocities about the wind: eddies of many sizes and noise.
fn stirred(positions: &[DVec3]) -> Vec<DVec3> {
    let mut rng = Pcg64::seed_from_u64(23);
    let eddy = |x: &DVec3| DVec3::new((180.0 * x.y).sin(), (210.0 * x.z).cos(), (170.0 * x.x).sin());
    let noise = |rng: &mut Pcg64| DVec3::from_array(rng.random()) - 0.5;
    positions.iter().map(|x| (DVec3::X + eddy(x) + noise(&mut rng)).as_vec3().as_dvec3()).collect()
}

/// Heading 7 on the engine and in the twin, pass by pass: each pass of the twin takes what the engine's pass before it
/// left, so that an error is that pass's own.
fn compare(law: Law, filter: Filter, bounds: [f64; 4]) {
    let mut worst = [0.0_f64; 4];
    // With the direct filter the twin looks at every pair and image: of the large crowds it has two.
    let slow = |what: &str| filter == Filter::Direct && what.starts_with("6701");
    let chosen = |what: &str| what.contains("2233 of hair, Random") || what.contains("Clustered");
    for (what, initial) in crowds().filter(|(what, _)| !slow(what) || chosen(what)) {
        let scene = scene(law, filter);
        let stage = Stage::new(&scene, &initial);
        let (p, twin, s) = (&stage.parameters, &stage.twin, stage.engine.state());
        let mut status = stage.engine.status().unwrap();
        status.step = STEPS;
        status.wind = wind::blow(p, u64::from(STEPS) + 1).as_vec3().to_array();
        stage.engine.set_status(&status).unwrap();
        let v = stirred(&twin.position);
        stage.write_vectors(&s.velocity, &v);
        let near = stage.meet();
        stage.run(step::turbulence::record);

        let x = &twin.position;
        let blowing = wind::blow(p, u64::from(STEPS) + 1);
        // What is left of the last band, the changes of both.
        let mut change = vec![DVec3::ZERO; x.len()];
        for band in &scene.turbulence.bands {
            let eddies = turbulence::band_velocity(p, band, blowing, x, &v, &twin.volume);
            let omega = turbulence::vorticity(p, x, if law == Law::Band { &eddies } else { &v }, &twin.volume, &near);
            let add =
                turbulence::confine(p, band, blowing, x, &eddies, &omega, &twin.volume, &twin.inverse_mass, &near);
            change.iter_mut().zip(add).for_each(|(sum, add)| *sum += add);
            if band == &scene.turbulence.bands[1] {
                worst[0] = worst[0].max(relative(&air(&stage, &s.band_velocity), &eddies[p.hair_points..], 1e-3));
                let got = stage.vectors(&s.vorticity);
                let from = if law == Law::Band { p.hair_points } else { 0 };
                worst[1] = worst[1].max(relative(&got[from..], &omega[from..], 1.0));
            }
        }
        let got = air(&stage, &s.confinement);
        let error = relative(&got, &change[p.hair_points..], 1e-3);
        worst[2] = worst[2].max(error);
        let mean = if law == Law::Band { turbulence::mean(p, &change) } else { DVec3::ZERO };
        let stronger = turbulence::strengthen(p, &v, &change, mean);
        worst[3] = worst[3].max(relative(&stage.vectors(&s.new_velocity), &stronger, 1.0));

        let largest = change.iter().map(|dv| dv.length()).fold(0.0, f64::max);
        println!("{law:?}, {what}: largest change {largest:.1e} m/s, worst so far {worst:?}");
        assert!(worst.iter().zip(bounds).all(|(error, bound)| *error < bound), "{law:?}, {what}: {worst:?}");
        let impulse = stage.vectors(&s.mean_confinement)[1];
        let wanted = turbulence::impulse(p, &twin.inverse_mass, &v, &stronger);
        let scale: f64 = (p.hair_points..x.len()).map(|i| change[i].length() / twin.inverse_mass[i]).sum();
        assert!(
            (impulse - wanted).length() <= 1e-5 * scale + 1e-20,
            "{what}: impulse {impulse}, expected {wanted} of {scale:e}"
        );
    }
}

fn air(stage: &Stage, array: &Array<[f32; 4]>) -> Vec<DVec3> {
    stage.vectors(array).split_off(stage.parameters.hair_points)
}

#[test]
fn the_band_law_is_that_of_the_twin() {
    // Measured 4e-6, 5e-6, 1.6e-4 (of clumps, where neighbours nearly coincide), 2.8e-5; margin 4.
    compare(Law::Band, Filter::Direct, [2e-5, 2e-5, 6e-4, 1.2e-4]);
}

#[test]
fn the_published_law_is_that_of_the_twin() {
    // Measured 7.2e-4 (a pair just at the cut of 3 s, where the hat is not 0 yet), 6.4e-7, 1.4e-4, 4.9e-5; margin 4.
    compare(Law::Published, Filter::Direct, [3e-3, 3e-6, 6e-4, 2e-4]);
}

#[test]
fn the_band_law_on_a_grid_is_that_of_the_twin() {
    // Measured 1.8e-6, 3.2e-6, 8.4e-4 (of clumps; taps are left out), 8.1e-5; margin 4.
    compare(Law::Band, Filter::Grid, [8e-6, 1.5e-5, 3.5e-3, 3.5e-4]);
}

/// A band's grid, pass by pass, each from what the engine's pass before it left. Particles near the faces stand outside the
/// box by a little, as the density constraint leaves them.
#[test]
fn the_grid_filter_is_that_of_the_twin() {
    let mut worst = [0.0_f64; 3];
    for (what, mut initial) in crowds() {
        for (order, spacing, scale, normalise) in
            [(Order::Cubic, 0.55, 0.006, true), (Order::Tsc, 0.4, 0.009, false), (Order::Cic, 0.9, 0.02, true)]
        {
            let mut scene = scene(Law::Band, Filter::Grid);
            scene.turbulence.bands = vec![Band { scale, strength: 1.0, intensity: 0.3 }];
            (scene.turbulence.order, scene.turbulence.spacing) = (order, spacing);
            scene.turbulence.normalise = normalise;
            stray(&mut initial);
            let stage = Stage::new(&scene, &initial);
            let (p, twin, s) = (&stage.parameters, &stage.twin, stage.engine.state());
            let v = stirred(&twin.position);
            stage.write_vectors(&s.velocity, &v);
            stage.engine.copy_state_to_scratch().unwrap();
            stage.run(step::turbulence::record_band);

            let band = &scene.turbulence.bands[0];
            let blowing = wind::blow(p, 0);
            let deposited = turbulence::deposit(p, scale, blowing, &twin.position, &v, &twin.volume);
            let curved = turbulence::smooth(p, scale, &deposited);
            let eddies = turbulence::gather(p, band, &curved, &twin.position);
            let nodes = |array: &Array<[f32; 4]>| -> [Vec<DVec3>; 2] {
                let read = stage.engine.read(array).unwrap();
                let read = &read[..deposited.values.len()];
                let volume = read.iter().map(|node| f64::from(node[3]) * DVec3::X).collect();
                [read.iter().map(|node| DVec3::new(node[0].into(), node[1].into(), node[2].into())).collect(), volume]
            };
            let of_twin = |mesh: &turbulence::Mesh| -> [Vec<DVec3>; 2] {
                let values = &mesh.values;
                [values.iter().map(|v| v.truncate()).collect(), values.iter().map(|v| v.w * DVec3::X).collect()]
            };
            for (k, (array, mesh)) in [(&s.deposited, &deposited), (&s.curvature, &curved)].into_iter().enumerate() {
                for (got, wanted) in nodes(array).iter().zip(&of_twin(mesh)) {
                    worst[k] = worst[k].max(relative(got, wanted, 1e-12));
                }
            }
            worst[2] = worst[2].max(relative(&air(&stage, &s.band_velocity), &eddies[p.hair_points..], 1e-3));
            println!("{what}, {order:?}: {worst:?}");
            // Measured 3.1e-6, 1.4e-5, 6.2e-5 (of clumps: hardly any volume is divided by between them); margin 4.
            let within = worst.iter().zip([1.3e-5, 5.5e-5, 2.5e-4]).all(|(error, bound)| *error < bound);
            assert!(within, "{what}, {order:?}: {worst:?}");
        }
    }
}

/// Every seventh particle of air is moved to just outside a face of its box.
fn stray(initial: &mut InitialState) {
    let size = initial.air.size;
    for (i, x) in initial.air.positions.iter_mut().enumerate().filter(|(i, _)| i % 7 == 0) {
        let axis = i / 7 % 3;
        x[axis] = if i % 2 == 0 { -1e-3 } else { size[axis] + 1e-3 };
    }
}
