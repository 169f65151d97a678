//! fringe.

use glam::DVec3;
use windswept::step;
use windswept_reference::wind;

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
