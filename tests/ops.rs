//! Single passes on arrays of the caller's own give the reference's numbers, in a box and in free space, and name bad
//! arguments.
#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use glam::DVec3;
use support::{Layout, MASS, RADIUS, VOLUME};
use windswept::ops::{Filter, OpsError, Particles};
use windswept_reference::{Parameters, fluid, neighbours, turbulence, viscosity};
use windswept_scene::{Air, AirParticles, Band, Fluid, InitialState, Scene};

/// The band whose velocity is compared.
const BAND: Band = Band { scale: 6e-3, strength: 1.0, intensity: 1.0 };

/// Numbers of particles, small: the passes below the operations are tried with more in `tests/passes`.
const SIZES: [usize; 5] = [1, 63, 64, 65, 3_000];

/// A crowd for the operations, with the reference's parameters for it.
struct Crowd {
    positions: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    bounds: Option<[f64; 3]>,
    scene: Scene,
    initial: InitialState,
}

impl Crowd {
    fn particles(&self) -> Particles<'_> {
        Particles {
            positions: &self.positions,
            velocities: &self.velocities,
            mass: MASS,
            rest_density: Air::REST_DENSITY,
            radius: RADIUS,
            bounds: self.bounds,
        }
    }

    fn reference(&self) -> (Parameters, Vec<DVec3>, Vec<DVec3>, Vec<f64>) {
        let p = Parameters::new(&self.scene, &self.initial);
        // The positions are rounded as the device has them: relative to the box, in f32.
        let x = self.initial.air.positions.iter().map(|x| (*x - self.initial.air.min).as_vec3().as_dvec3()).collect();
        let v = self.initial.air.velocities.iter().map(|v| v.as_vec3().as_dvec3()).collect();
        (p, x, v, vec![VOLUME; self.positions.len()])
    }
}

fn crowds() -> impl Iterator<Item = (String, Crowd)> {
    let layouts = [Layout::Random, Layout::Clustered, Layout::Lattice, Layout::OneCell];
    let cases = SIZES.into_iter().flat_map(move |n| layouts.map(|layout| (n, layout)));
    cases.flat_map(|(n, layout)| {
        // Every pair of a clump meets.
        let few = if layout == Layout::OneCell { n.min(1000) } else { n };
        [true, false].map(|closed| (format!("{few} {layout:?}, box {closed}"), crowd(few, layout, closed)))
    })
}

fn crowd(n: usize, layout: Layout, closed: bool) -> Crowd {
    let mut initial = support::particles(n, 0, layout, n as u64 + 3);
    let stir = |x: &DVec3| DVec3::new((90.0 * x.y).sin(), (70.0 * x.z).sin() + x.x, (130.0 * x.x).cos());
    let size = initial.air.size;
    let mut scene = support::scene();
    scene.turbulence.bands = vec![BAND];
    scene.turbulence.speed = 1.0;
    let shift = if closed { DVec3::ZERO } else { DVec3::new(-7.0, 120.0, 0.5) };
    let positions: Vec<DVec3> = initial.air.positions.iter().map(|x| *x - initial.air.min + shift).collect();
    let velocities: Vec<DVec3> = positions.iter().map(|x| stir(&(*x - shift))).collect();
    if !closed {
        // Free space is a box so large that nobody meets an image.
        let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = positions.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        initial.air = AirParticles { min: low - 0.1, size: high - low + 0.2, ..initial.air };
    } else {
        initial.air.min = DVec3::ZERO;
    }
    initial.air.positions.clone_from(&positions);
    initial.air.velocities.clone_from(&velocities);
    (initial.air.volume, initial.air.mass) = (VOLUME, MASS);
    let rows = |values: &[DVec3]| values.iter().map(|v| v.to_array()).collect();
    Crowd {
        positions: rows(&positions),
        velocities: rows(&velocities),
        bounds: closed.then(|| size.to_array()),
        scene,
        initial,
    }
}

fn vectors(values: &[[f32; 3]]) -> Vec<DVec3> {
    values.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect()
}

/// Largest difference over the largest value, or over `floor` if that is larger.
fn error(got: &[DVec3], wanted: &[DVec3], floor: f64) -> f64 {
    assert_eq!(got.len(), wanted.len());
    let scale = wanted.iter().map(|v| v.length()).fold(floor, f64::max);
    got.iter().zip(wanted).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max) / scale
}

/// Operations give the reference's numbers on every size and layout, in a periodic box and 120 m from the origin in
/// free space.
#[test]
fn operations_are_those_of_the_reference() {
    let gpu = support::gpu();
    let fluid_settings = Fluid::pbf(1, 0.5);
    for (name, mut crowd) in crowds() {
        crowd.scene.fluid = fluid_settings.clone();
        crowd.scene.viscosity.air = 0.9;
        let (p, x, v, volume) = crowd.reference();
        let near = neighbours::list(&p, &x);
        let inverse_mass = vec![1.0 / MASS; x.len()];
        let (theta, lambda) = fluid::density(&p, &x, &inverse_mass, &volume, &near);
        let shift = fluid::correct(&p, &x, &inverse_mass, &volume, &near, &lambda);
        let eddies = vec![0.0; x.len()];
        let exchange = viscosity::limit(&p, &x, &volume, &near, &theta, &eddies);
        let particles = crowd.particles();

        let density: Vec<DVec3> =
            particles.density(&gpu).unwrap().iter().map(|r| DVec3::X * f64::from(*r) / Air::REST_DENSITY).collect();
        let theta_wanted: Vec<DVec3> = theta.iter().map(|t| DVec3::X * *t).collect();
        let origin = if crowd.bounds.is_some() { DVec3::ZERO } else { crowd.initial.air.min };
        let gap = |(got, (x, shift)): (&[f32; 3], (&DVec3, &DVec3))| {
            let gap = DVec3::from_array(got.map(f64::from)) - origin - *x - *shift;
            (gap - crowd.bounds.map_or(DVec3::ZERO, |l| DVec3::from_array(l) * (gap / DVec3::from_array(l)).round()))
                .length()
        };
        let moved = particles.solve_density(&gpu, fluid_settings.clone()).unwrap();
        let far = moved.iter().zip(x.iter().zip(&shift)).map(gap).fold(0.0, f64::max);
        let band = turbulence::band(&p, &p.bands[0], DVec3::ZERO, &x, &v, &volume);
        let viscous = viscosity::xsph(&p, &x, &v, &inverse_mass, &volume, &near, &theta, &eddies, &exchange);
        let errors = [
            error(&density, &theta_wanted, 0.1),
            error(
                &vectors(&particles.vorticity(&gpu).unwrap()),
                &turbulence::vorticity(&p, &x, &v, &volume, &near),
                1.0,
            ),
            error(
                &vectors(&particles.band_velocity(&gpu, BAND.scale, Filter::Direct { cutoff: 4.5 }).unwrap()),
                &band,
                1e-3,
            ),
            error(&vectors(&particles.viscosity(&gpu, 0.9).unwrap()), &viscous, 1e-3),
        ];
        println!("{name}: density, vorticity, band, viscosity {errors:?}, positions {far:.1e} m");
        // Measured at most 2.5e-6, 3.1e-6, 2.3e-5 and 8.8e-7; margin 4.
        for (error, bound) in errors.into_iter().zip([1e-5, 1.3e-5, 9e-5, 3.6e-6]) {
            assert!(error < bound, "{name}: {errors:?}");
        }
        // f32 of coordinates of 120 m, handed out in world coordinates: half of 7.6e-6 m.
        let bound = if crowd.bounds.is_some() { 1e-7 } else { 7e-6 };
        assert!(far < bound, "{name}: positions {far} m");

        let lists = particles.neighbours(&gpu).unwrap();
        assert_eq!(lists.offsets.len(), x.len() + 1);
        for i in 0..x.len() {
            let listed = &lists.indices[lists.offsets[i] as usize..lists.offsets[i + 1] as usize];
            // Pairs a radius apart may be on either side in f32.
            let apart = |j: u32| p.separation(i, j as usize, x[i], x[j as usize]).length() / RADIUS;
            assert!(listed.iter().all(|j| apart(*j) < 1.0 + 1e-5), "{name}: {i} lists strangers");
            let missing = near.of(i).map(|j| j as u32).find(|j| apart(*j) < 1.0 - 1e-5 && !listed.contains(j));
            assert_eq!(missing, None, "{name}: {i} misses a neighbour");
        }
    }
}

/// Without particles there is nothing to do; a lone particle has its own density and is no one's neighbour.
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
    refused(good.band_velocity(&gpu, 0.01, Filter::Direct { cutoff: f64::NAN }), "cutoff: expected");
    let in_box = Particles { bounds: Some([0.03; 3]), ..good };
    let direct = Filter::Direct { cutoff: 4.5 };
    refused(in_box.band_velocity(&gpu, 1e3, direct), "scale: the direct filter would sum");
    refused(in_box.band_velocity(&gpu, 1e-5, Filter::default()), "scale: the filter's grid would have");
    // Few in much empty space are no work.
    assert_eq!(good.band_velocity(&gpu, 0.1, Filter::Direct { cutoff: 3.0 }).unwrap().len(), 2);
    refused(good.viscosity(&gpu, -0.1), "coefficient: expected");
    let fluid = Fluid::pbf(2, 0.5);
    refused(
        good.solve_density(&gpu, Fluid { iterations: 10_001, ..fluid.clone() }),
        "iterations: expected a whole number from 0 to 10000",
    );
    refused(good.solve_density(&gpu, Fluid { relaxation: f64::NAN, ..fluid.clone() }), "relaxation: expected");
    refused(Particles { radius: 4e-3, ..good }.solve_density(&gpu, fluid), "radius: expected at least 1.2 particle");
}
