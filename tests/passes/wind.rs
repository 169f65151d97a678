//! fringe, drag.

use glam::DVec3;
use windswept::internals::step;
use windswept_reference::wind;
use windswept_scene::{Gust, Inflow, Model};

use crate::{
    stage::{Stage, relative, xyz},
    support,
};

/// The table of the mean wind, and what the fringe makes of it: any direction, gusts that turn the wind round, turbulence
/// that it brings in, at any step of a run.
#[test]
fn fringe_is_that_of_the_twin() {
    let turning = vec![
        Gust { time: 0.01, velocity: [0.0; 3] },
        Gust { time: 0.03, velocity: [4.0, -1.0, 0.0] },
        Gust { time: 0.7, velocity: [3.0, 0.0, 0.5] },
    ];
    let eddies = Some(Inflow { intensity: 0.2, scale: 0.009, seed: 3 });
    for (wind_speed, gust, inflow, steps) in [
        ([3.0, 0.0, 0.0], Vec::new(), None, 0),
        ([-2.0, 0.5, 1.0], Vec::new(), eddies, 12),
        ([0.0, 0.0, -6.0], Vec::new(), None, 500),
        ([0.0; 3], turning.clone(), None, 3),
        ([-2.0, 0.5, 0.0], turning.clone(), eddies, 18),
        ([-2.0, 0.0, 1.0], turning, None, 300),
    ] {
        for n in support::SIZES {
            let mut scene = support::scene();
            if let Some(air) = &mut scene.air {
                (air.wind, air.gust, air.inflow) = (wind_speed, gust.clone(), inflow);
                air.fringe = 0.02;
            }
            let initial = support::particles(n, n / 3, support::Layout::Random, 4);
            let stage = Stage::new(&scene, &initial);
            let (p, s) = (&stage.parameters, stage.engine.state());
            let mut status = stage.engine.status().unwrap();
            status.step = steps;
            // What committed steps leave.
            let ways = (0..steps.into()).map(|k| 0.5 * p.step * (wind::blow(p, k) + wind::blow(p, k + 1)));
            status.way = ways.sum::<DVec3>().rem_euclid(p.box_size).as_vec3().to_array();
            stage.engine.set_status(&status).unwrap();
            let v: Vec<DVec3> = stage.twin.position.iter().map(|x| (*x * 20.0).as_vec3().as_dvec3()).collect();
            stage.write_vectors(&s.velocity, &v);
            stage.run(step::drive::record);
            let blown = DVec3::from_array(stage.engine.status().unwrap().wind.map(f64::from));
            let air = p.hair_points..stage.twin.position.len();
            let wanted: Vec<DVec3> =
                air.clone().map(|i| wind::fringe(p, steps.into(), stage.twin.position[i], v[i])).collect();
            let error = relative(&stage.vectors(&s.wind_change)[air], &wanted, 1e-3);
            let off = (blown - wind::blow(p, u64::from(steps) + 1)).length();
            println!("wind {wind_speed:?}, step {steps}, {n} particles: {error:.1e}, mean wind {off:.1e} m/s off");
            // Measured at most 1e-6, and 5e-7 m/s; margin 4.
            assert!(error < 4e-6, "{wind_speed:?}: {error}");
            assert!(off < 2e-6, "{wind_speed:?}: {off} m/s");
        }
    }
}

/// Drag and lift of segments in any posture and motion, up to 100 m/s; with air particles outside the box only.
#[test]
fn drag_is_that_of_the_twin() {
    for (model, lift, speed) in
        [(Model::Drag, 0.0, 3.0), (Model::Drag, 2.0, 3.0), (Model::Drag, 1.0, 100.0), (Model::Particles, 0.5, 3.0)]
    {
        for n in support::SIZES {
            let mut scene = support::scene();
            scene.interaction.model = model;
            scene.interaction.lift = lift;
            if let Some(air) = &mut scene.air {
                air.wind = [0.8 * speed, -0.6 * speed, 0.0];
                air.ramp = 0.0;
            }
            let mut initial = support::particles(n, n, support::Layout::Random, 9);
            initial.air.positions.clear();
            initial.air.velocities.clear();
            if model == Model::Particles {
                // Half of the hair out of the box, in which there is one particle of air at least.
                let size = initial.air.size;
                initial.hair.positions.iter_mut().for_each(|x| x.x += 0.5 * size.x);
                initial.air.positions.push(0.5 * size);
                initial.air.velocities.push(DVec3::ZERO);
            }
            let stage = Stage::new(&scene, &initial);
            let (p, twin, s) = (&stage.parameters, &stage.twin, stage.engine.state());
            let v: Vec<DVec3> = twin
                .position
                .iter()
                .map(|x| (DVec3::new(x.y, x.z, -x.x) * speed * 10.0).as_vec3().as_dvec3())
                .collect();
            stage.write_vectors(&s.velocity, &v);
            if p.hair_points == 0 {
                continue;
            }
            stage.run(step::drive::record);
            stage.run_only(&["rods/begin_points", "wind/drag"], step::rods::record);
            let air = vec![wind::undisturbed(p.wind); p.hair_points];
            let (wanted, _) = wind::drag(p, &twin.hair, &air, &twin.position, &v);
            let got = stage.engine.read(&s.hair_force).unwrap();
            let forces: Vec<_> = wanted.iter().map(|load| load.force).collect();
            let resistances: Vec<_> = wanted.iter().map(|load| DVec3::splat(load.resistance)).collect();
            let error = relative(&got.iter().map(|f| xyz(&f[..3])).collect::<Vec<_>>(), &forces, 0.0).max(relative(
                &got.iter().map(|f| DVec3::splat(f[3].into())).collect::<Vec<_>>(),
                &resistances,
                0.0,
            ));
            let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
            println!("{model:?}, lift {lift}, {speed} m/s, {n}: largest {largest:.2e} N, off by {error:.1e}");
            // Measured at most 5.0e-7; margin 4.
            assert!(error < 2e-6, "{model:?}, {n}: {error}");
            assert!(n < 63 || largest > 0.0, "nothing drags");
        }
    }
}
