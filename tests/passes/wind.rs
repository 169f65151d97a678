//! fringe, drag.

use glam::DVec3;
use windswept::step;
use windswept_reference::wind;
use windswept_scene::Model;

use crate::{
    stage::{Stage, relative},
    support,
};

#[test]
fn fringe_is_that_of_the_twin() {
    for (wind_speed, steps) in [([3.0, 0.0, 0.0], 0), ([-2.0, 0.5, 1.0], 12), ([0.0, 0.0, -6.0], 500)] {
        for n in support::SIZES {
            let mut scene = support::scene();
            if let Some(air) = &mut scene.air {
                air.wind = wind_speed;
                air.fringe = 0.02;
            }
            let initial = support::particles(n, n / 3, support::Layout::Random, 4);
            let stage = Stage::new(&scene, &initial);
            let s = stage.engine.state();
            let mut status = stage.engine.status().unwrap();
            status.step = steps;
            stage.engine.set_status(&status).unwrap();
            let v: Vec<DVec3> = stage.twin.position.iter().map(|x| (*x * 20.0).as_vec3().as_dvec3()).collect();
            stage.write_vectors(&s.velocity, &v);
            stage.run(step::drive::record);
            let air = stage.parameters.hair_points..stage.twin.position.len();
            let wanted: Vec<DVec3> = air
                .clone()
                .map(|i| wind::fringe(&stage.parameters, steps.into(), stage.twin.position[i], v[i]))
                .collect();
            let error = relative(&stage.vectors(&s.wind_change)[air], &wanted, 1e-3);
            println!("wind {wind_speed:?}, step {steps}, {n} particles: {error:.1e}");
            // Measured at most 1e-6; margin 4.
            assert!(error < 4e-6, "{wind_speed:?}: {error}");
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
            scene.model = model;
            scene.lift = lift;
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
            stage.run(step::drive::record);
            let wanted = wind::drag(p, &twin.hair, p.wind, &twin.position, &v, &twin.inverse_mass);
            let error = relative(&stage.vectors(&s.drag_change)[..p.hair_points], &wanted[..p.hair_points], 1e-3);
            let largest = wanted.iter().map(|dv| dv.length()).fold(0.0, f64::max);
            println!("{model:?}, lift {lift}, {speed} m/s, {n}: largest {largest:.2} m/s, off by {error:.1e}");
            assert!(error < 1e-4, "{model:?}, {n}: {error}");
            assert!(n < 63 || largest > 0.0, "nothing drags");
        }
    }
}
