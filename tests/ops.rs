//! Single passes on arrays of the caller's own work in free space as in a box, and name bad arguments.
//! `windswept_validate`'s check `reference` compares them with the reference, `tests/passes` the passes below them on
//! many sizes and layouts.

use glam::DVec3;
use windswept::ops::{OpsError, Particles};
use windswept_scene::{Air, DirectFilter, Filter};
use windswept_validate::internals::{Cloud, vectors};

use crate::support;

/// Largest difference over the largest value.
fn error(got: &[[f32; 3]], wanted: &[[f32; 3]]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    let (got, wanted) = (vectors(got), vectors(wanted));
    let scale = wanted.iter().map(|v| v.length()).fold(0.0, f64::max);
    got.iter().zip(&wanted).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max) / scale
}

/// Free space, 120 m from the origin, gives the numbers of a box in which no particle meets an image.
#[test]
fn free_space_is_a_box_without_images() {
    let gpu = support::gpu();
    let cloud = Cloud::centred(8).jittered(0.3, 7).stirred(1.0, 5);
    let side = 2.0 * cloud.size.x;
    let boxed = Particles { bounds: Some([side; 3]), ..cloud.particles() };
    let shift = DVec3::new(-7.0, 120.0, 0.5);
    let shifted: Vec<_> = cloud.positions.iter().map(|x| (DVec3::from_array(*x) + shift).to_array()).collect();
    let free = Particles { positions: &shifted, bounds: None, ..boxed };

    let density =
        |all: Particles<'_>| all.density(&gpu).unwrap().into_iter().map(|rho| [rho, 0.0, 0.0]).collect::<Vec<_>>();
    let band =
        |all: Particles<'_>| all.band_velocity(&gpu, 6e-3, Filter::Direct(DirectFilter { cutoff: 4.5 })).unwrap();
    let errors = [
        error(&density(free), &density(boxed)),
        error(&free.vorticity(&gpu).unwrap(), &boxed.vorticity(&gpu).unwrap()),
        error(&band(free), &band(boxed)),
        error(&free.viscosity(&gpu, 0.9).unwrap(), &boxed.viscosity(&gpu, 0.9).unwrap()),
    ];
    println!("density, vorticity, band, viscosity {errors:?}");
    assert!(errors.iter().all(|error| *error < 1e-5), "{errors:?}");
    let moved = |all: Particles<'_>| vectors(&all.solve_density(&gpu, 1, 0.5).unwrap());
    for (free, boxed) in moved(free).into_iter().zip(moved(boxed)) {
        // A box wraps; f32 of coordinates of 120 m: half of 7.6e-6 m.
        let gap = free - shift - boxed;
        assert!((gap - side * (gap / side).round()).length() < 7e-6, "{free} {boxed}");
    }
    let lists = free.neighbours(&gpu).unwrap();
    assert_eq!(lists, boxed.neighbours(&gpu).unwrap());
    let x: Vec<DVec3> = cloud.positions.iter().map(|x| DVec3::from_array(*x)).collect();
    for i in 0..x.len() {
        let listed = &lists.indices[lists.offsets[i] as usize..lists.offsets[i + 1] as usize];
        for j in (0..x.len()).filter(|j| *j != i) {
            let apart = x[i].distance(x[j]) / free.radius;
            // Pairs a radius apart may be on either side in f32.
            assert!(
                (apart - 1.0).abs() < 1e-5 || listed.contains(&(j as u32)) == (apart < 1.0),
                "{i} and {j}: {apart}"
            );
        }
    }
}

/// Without particles there is nothing to do; a lone particle has its own density and no neighbour.
#[test]
fn none_and_one_are_answered() {
    let gpu = support::gpu();
    let none = Particles::at(&[]);
    assert!(none.density(&gpu).unwrap().is_empty() && none.vorticity(&gpu).unwrap().is_empty());
    assert_eq!(none.neighbours(&gpu).unwrap().offsets, [0]);
    let at = [[3.0, -2.0, 1e3]];
    let one = Particles { velocities: &[[1.0, 2.0, 3.0]], ..Particles::at(&at) };
    // V W(0) = 0.2204423 (reference).
    assert!((f64::from(one.density(&gpu).unwrap()[0]) / Air::REST_DENSITY - 0.220_442_3).abs() < 1e-6);
    assert_eq!(one.neighbours(&gpu).unwrap().offsets, [0, 0]);
    assert_eq!(one.viscosity(&gpu, 5.0).unwrap(), [[1.0, 2.0, 3.0]]);
    assert_eq!(one.vorticity(&gpu).unwrap(), [[0.0; 3]]);
}

/// Particles so far apart that there would be too many cells get larger cells.
#[test]
fn a_wide_cloud_is_answered() {
    let gpu = support::gpu();
    let at = [[0.0; 3], [0.004, 0.0, 0.0], [900.0, 700.0, -800.0]];
    let lists = Particles::at(&at).neighbours(&gpu).unwrap();
    assert_eq!((lists.offsets, lists.indices), (vec![0, 1, 2, 2], vec![1, 0]));
}

/// Arguments that cannot be used are named in an error, and nothing panics.
#[test]
fn bad_arguments_are_named() {
    let gpu = support::gpu();
    let at = [[0.0; 3], [0.01, 0.0, 0.0]];
    let good = Particles { velocities: &at, ..Particles::at(&at) };
    let broken = [[0.0, f64::NAN, 0.0]];
    let refused = |result: Result<Vec<f32>, OpsError>, words: &str| {
        let error = result.unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(Particles::at(&broken).density(&gpu), "positions: row 0 is [0.0, NaN, 0.0]");
    refused(Particles { mass: 0.0, ..good }.density(&gpu), "mass: expected a number from");
    refused(Particles { rest_density: -1.0, ..good }.density(&gpu), "rest_density: expected");
    refused(Particles { radius: f64::INFINITY, ..good }.density(&gpu), "radius: expected");
    refused(
        Particles { bounds: Some([1.0, 0.02, 1.0]), ..good }.density(&gpu),
        "box: expected sides of at least 3 radii",
    );
    let refused = |result: Result<Vec<[f32; 3]>, OpsError>, words: &str| {
        let error = result.unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(
        Particles { velocities: &at[..1], ..good }.vorticity(&gpu),
        "velocities: expected 2 rows as positions, found 1",
    );
    refused(good.band_velocity(&gpu, 0.0, Filter::default()), "scale: expected");
    let direct = |cutoff| Filter::Direct(DirectFilter { cutoff });
    refused(good.band_velocity(&gpu, 0.01, direct(f64::NAN)), "cutoff: expected");
    let in_box = Particles { bounds: Some([0.03; 3]), ..good };
    refused(in_box.band_velocity(&gpu, 1e3, direct(4.5)), "scale: the direct filter would sum");
    refused(in_box.band_velocity(&gpu, 1e-5, Filter::default()), "scale: the filter's grid would have");
    // Few in much empty space are no work.
    assert_eq!(good.band_velocity(&gpu, 0.1, direct(3.0)).unwrap().len(), 2);
    refused(good.viscosity(&gpu, -0.1), "coefficient: expected");
    refused(good.solve_density(&gpu, 10_001, 0.5), "iterations: expected a whole number from 0 to 10000");
    refused(good.solve_density(&gpu, 2, f64::NAN), "relaxation: expected");
    refused(Particles { radius: 4e-3, ..good }.solve_density(&gpu, 2, 0.5), "radius: expected at least 1.2 particle");
}
