//! Stage `rods`: the passes that load, start, solve and update rods, and that exchange drag with the air.

mod predict;
mod sleep;
mod solve;

use glam::DVec3;
use windswept::internals::step;
use windswept_reference::{Parameters, State as Reference, contact, forcing, rods, step::Scratch};
use windswept_scene::{Model, Scene};
use windswept_shaders::{
    self as shaders,
    common::{integration::BDF2, rod::RodPoint},
};

use crate::{
    fixture::{Fixture, quaternion, relative, stirred, xyz},
    forcing::fields,
    steps::{
        DRAG, FIELDS_ON_HAIR, Fault, GALE, LIGHT_HAIR, LOOSE, NEWTON, PARTICLES, PUSHED, STORM, SWEEPS, TAUT, TWO_WAY,
    },
    support,
    walk::{Same, Walk, apart, differing, largest},
};

impl Walk<'_> {
    pub fn rods(&mut self, s: &mut Reference, w: &mut Scratch) -> Same {
        let (fixture, bounds, p) = (self.fixture, self.bounds, self.p().clone());
        let mut passes = fixture.passes(step::rods::record);
        rods::begin(s, w, &p);
        if passes.through("rods/begin") {
            let points = fixture.rods().0;
            let gap = |of: fn(&RodPoint, &rods::Point) -> DVec3| {
                largest(points.iter().zip(&w.moving.points).map(|(a, b)| of(a, b).length()))
            };
            let velocity = gap(|a, b| xyz(&a.velocity) - b.velocity).max(gap(|a, b| xyz(&a.before) - b.before));
            let external_dv = gap(|a, b| xyz(&a.external_dv) - b.external_dv)
                .max(gap(|a, b| xyz(&a.impulse_change) - b.impulse_change));
            self.same("rods/begin", velocity.max(external_dv), bounds.speed)?;
            let moves =
                gap(|a, b| xyz(&a.previous_move) - b.previous_move).max(gap(|a, b| xyz(&a.rest_drift) - b.rest_drift));
            self.same("rods/begin", moves, bounds.length)?;
        }
        if passes.through("rods/sample_air") {
            let got = fixture.engine.read(&fixture.engine.state().sampled).unwrap();
            let pairs = || got.iter().zip(&w.local);
            self.same(
                "rods/sample_air",
                largest(pairs().map(|(a, b)| (xyz(&a.wind) - b.wind).length())),
                bounds.speed,
            )?;
            self.same(
                "rods/sample_air",
                largest(pairs().map(|(a, b)| (f64::from(a.filled) - b.filled).abs())),
                bounds.density,
            )?;
            self.same(
                "rods/sample_air",
                largest(pairs().map(|(a, b)| (f64::from(a.give) / b.give - 1.0).abs())),
                bounds.density,
            )?;
            let place = largest(pairs().map(|(a, b)| (xyz(&a.position) - b.position).length()));
            self.same("rods/sample_air", place, bounds.length)?;
        }
        w.local = rods::sample_fields(s, w, &p);
        if passes.through("rods/sample_fields") {
            let got = fixture.engine.read(&fixture.engine.state().sampled).unwrap();
            let gaps = got.iter().zip(&w.local).map(|(a, b)| (xyz(&a.wind) - b.wind).length());
            self.same("rods/sample_fields", largest(gaps), bounds.speed)?;
        }
        for (pass, force) in rods::FORCES {
            force(s, w, &p);
            if !passes.through(pass) {
                continue;
            }
            let schemes: Vec<_> = fixture.rod_strands().iter().map(|rod| rod.scheme == BDF2).collect();
            let wanted: Vec<_> = w.motions.iter().map(|motion| motion.step < p.step).collect();
            self.same(pass, differing(&schemes, &wanted), 0.0)?;
            // A force is held against what it changes a velocity by.
            let points = fixture.rods().0;
            let gaps = points.iter().zip(&w.moving.points).map(|(a, b)| {
                let resisted = (f64::from(a.resistance) - b.load.resistance).abs() * b.velocity.length();
                p.step * b.inverse_mass * ((xyz(&a.force) - b.load.force).length() + resisted)
            });
            self.same(pass, largest(gaps), bounds.wind)?;
        }
        contact::contacts(s, w, &p);
        if passes.through("rods/contacts") {
            self.begun(w)?;
        }
        rods::predict_all(s, w, &p);
        if passes.through("rods/predict") {
            self.states("rods/predict", w)?;
            self.found("rods/predict", s)?;
            self.moves("rods/predict", w)?;
            let (points, segments) = fixture.rods();
            let pairs = || points.iter().zip(&w.moving.points);
            let push = pairs().map(|(a, b)| {
                (xyz(&a.impulse_change) - b.impulse_change).length().max((xyz(&a.external_dv) - b.external_dv).length())
            });
            self.same("rods/predict", largest(push), bounds.speed)?;
            let free = pairs().filter(|(_, b)| b.step.is_finite()).map(|(a, b)| (xyz(&a.free) - b.free).length());
            self.same("rods/predict", largest(free), bounds.hair)?;
            let starts = pairs()
                .zip(&s.position)
                .map(|((a, b), x)| (xyz(&a.start) + xyz(&a.remainder) - (*x + b.shift)).length());
            self.same("rods/predict", largest(starts), bounds.length)?;
            let turning = segments.iter().zip(&w.moving.segments).filter(|(_, b)| b.step.is_finite());
            let free = turning.map(|(a, b)| (quaternion(a.free) - b.free).length());
            self.same("rods/predict", largest(free), bounds.frame)?;
        }
        solve_all(s, w, &p);
        for pass in ["rods/solve", "rods/gauss_seidel"] {
            if passes.through(pass) {
                self.states(pass, w)?;
                self.moves(pass, w)?;
                self.contacts(pass, w)?;
            }
        }
        rods::update_all(s, w, &p);
        if passes.through("rods/update") {
            self.found("rods/update", s)?;
            let got = &fixture.vectors(&fixture.engine.state().predicted)[..p.hair_points];
            self.same("rods/update", apart(got, &w.predicted[..p.hair_points]), bounds.length)?;
            let wanted: Vec<_> = w.moving.points.iter().map(|point| point.velocity_after(&p)).collect();
            let got = fixture.vectors(&fixture.engine.state().new_velocity);
            self.same("rods/update", apart(&got[..p.hair_points], &wanted), bounds.speed)?;
            let points = fixture.rods().0;
            let before = points.iter().zip(&w.moving.points).map(|(a, b)| (xyz(&a.before) - b.before).length());
            self.same("rods/update", largest(before), bounds.speed)?;
        }
        let given = |w: &Scratch| {
            let given = fixture.vectors(&fixture.engine.state().drag_impulse);
            let of = |(i, (a, b)): (usize, (&DVec3, &DVec3))| s.inverse_mass[i] * (*a - *b).length();
            largest(given.iter().zip(&w.drag_impulse).enumerate().map(of))
        };
        if passes.through("rods/drag_impulse") {
            self.same("rods/drag_impulse", given(w), bounds.speed)?;
        }
        w.drag_impulse = rods::exclude_push(s, w, &p);
        if passes.through("rods/exclude_push") {
            self.same("rods/exclude_push", given(w), bounds.speed)?;
        }
        if passes.through("rods/react") {
            let change = rods::react(&p, &w.local, &w.drag_impulse, &w.predicted, &s.volume, &s.inverse_mass, &w.near);
            w.new_velocity[p.hair_points..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
            let got = self.vectors(&fixture.engine.state().new_velocity, p.hair_points);
            self.same("rods/react", apart(&got, &w.new_velocity[p.hair_points..]), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }

    /// Compares moves, frames and, of the direct solver, turns and strains of segments that are integrated.
    fn moves(&mut self, pass: &'static str, w: &Scratch) -> Same {
        let (points, segments) = self.fixture.rods();
        let moves = points.iter().zip(&w.moving.points).map(|(a, b)| (xyz(&a.displacement) - b.displacement).length());
        self.same(pass, largest(moves), self.bounds.hair)?;
        let pairs = || segments.iter().zip(&w.moving.segments);
        let frames = largest(pairs().map(|(a, b)| (quaternion(a.frame) - b.frame).length()));
        self.same(pass, frames, self.bounds.frame)?;
        let solved = || pairs().filter(|(_, b)| self.p().direct && b.step.is_finite());
        let turns = largest(solved().map(|(a, b)| (quaternion(a.turn) - b.turn).length()));
        let strains = largest(solved().map(|(a, b)| (xyz(&a.strain) - b.strain).length()));
        self.same(pass, turns, self.bounds.frame)?;
        self.same(pass, strains, self.bounds.hair)
    }
}

/// The solver of the reference, on every strand.
fn solve_all(s: &Reference, w: &mut Scratch, p: &Parameters) {
    for strand in 0..s.hair.len() {
        if p.direct {
            rods::solve(p, &s.hair, strand, &mut w.motions[strand], &mut w.moving);
        } else {
            rods::gauss_seidel(p, &s.hair, strand, &w.motions[strand], &mut w.moving);
        }
    }
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::rods::BEGIN, PARTICLES, &[6]),
    (&shaders::rods::BEGIN, TWO_WAY, &[19]),
    (&shaders::rods::SAMPLE_AIR, TWO_WAY, &[42]),
    (&shaders::rods::DRAG, DRAG, &[134, 213]),
    (&shaders::rods::DRAG, GALE, &[6]),
    (&shaders::rods::SAMPLE_FIELDS, FIELDS_ON_HAIR, &[22]),
    (&shaders::rods::PUSH_HAIR, PUSHED, &[13]),
    (&shaders::rods::EXCLUDE_PUSH, PUSHED, &[14]),
    (&shaders::rods::PREDICT, TWO_WAY, &[25]),
    (&shaders::rods::PREDICT, LIGHT_HAIR, &[199]),
    (&shaders::rods::PREDICT, PARTICLES, &[267]),
    (&shaders::rods::SOLVE, PARTICLES, &[100]),
    (&shaders::rods::SOLVE, NEWTON, &[127]),
    (&shaders::rods::SOLVE, STORM, &[125]),
    (&shaders::rods::SOLVE, TAUT, &[462]),
    (&shaders::rods::SOLVE, LOOSE, &[385]),
    (&shaders::rods::GAUSS_SEIDEL, SWEEPS, &[14]),
    (&shaders::rods::UPDATE, PARTICLES, &[72, 136, 138, 154]),
    (&shaders::rods::DRAG_IMPULSE, TWO_WAY, &[9]),
    (&shaders::rods::REACT, TWO_WAY, &[20]),
];

/// The wind of force fields at hair points, and an acceleration that was set, without air and outside its box.
#[test]
fn forces_on_hair_are_those_of_the_reference() {
    for model in [Model::Drag, Model::Particles] {
        for n in support::SIZES.into_iter().filter(|n| *n > 1) {
            let mut scene = Scene { forces: fields(), ..support::scene() };
            scene.interaction.model = model;
            let air = if model == Model::Particles { n / 3 } else { 0 };
            let mut fixture = Fixture::new(&scene, &support::particles(n, n - air, support::Layout::Random, 7));
            fixture.push();
            let (p, s) = (&fixture.parameters, fixture.engine.state());
            let velocity = stirred(fixture.reference.position.len());
            fixture.write_vectors(&s.velocity, &velocity);
            fixture.run(step::forcing::record);
            fixture.run_only(&["rods/begin", "rods/sample_fields", "rods/push_hair"], step::rods::record);
            let mut reference = Reference { velocity, ..fixture.reference.clone() };
            let mut w = forcing::run(&reference, p);
            w.correction = vec![DVec3::ZERO; p.hair_points];
            rods::begin(&reference, &mut w, p);
            let felt: Vec<_> = rods::sample_fields(&reference, &w, p).iter().map(|local| local.wind).collect();
            rods::push_hair(&mut reference, &mut w, p);
            let pushed: Vec<_> = w.moving.points.iter().map(|point| point.load.force).collect();
            let sampled = fixture.engine.read(&s.sampled).unwrap();
            let got: Vec<_> = sampled.iter().map(|air| xyz(&air.wind)).collect();
            let forces: Vec<_> = fixture.rods().0.iter().map(|point| xyz(&point.force)).collect();
            let errors = [relative(&got, &felt, 1e-3), relative(&forces, &pushed, 0.0)];
            println!("{model:?}, {n} particles: {:.1e}, {:.1e}", errors[0], errors[1]);
            // Measured at most 2.7e-7 and 5.2e-8; margin 4.
            assert!(errors[0] < 1.1e-6 && errors[1] < 2.1e-7, "{model:?}, {n} particles: {errors:?}");
        }
    }
}

/// Drag and lift of segments in any posture and motion, at 1000 m/s without a direction; with air particles outside the
/// box only.
#[test]
fn drag_is_that_of_the_reference() {
    for (model, lift, speed) in [
        (Model::Drag, 0.0, 3.0),
        (Model::Drag, 2.0, 3.0),
        (Model::Drag, 1.0, 100.0),
        (Model::Drag, 0.5, 1000.0),
        (Model::Particles, 0.5, 3.0),
    ] {
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
            let fixture = Fixture::new(&scene, &initial);
            let (p, reference, s) = (&fixture.parameters, &fixture.reference, fixture.engine.state());
            let v: Vec<DVec3> = reference
                .position
                .iter()
                .map(|x| (DVec3::new(x.y, x.z, -x.x) * speed * 10.0).as_vec3().as_dvec3())
                .collect();
            fixture.write_vectors(&s.velocity, &v);
            if p.hair_points == 0 {
                continue;
            }
            fixture.run(step::forcing::record);
            fixture.run_only(&["rods/begin", "rods/drag"], step::rods::record);
            let air = vec![rods::undisturbed(p.wind); p.hair_points];
            let (wanted, _) = rods::drag(p, &reference.hair, &air, &reference.position, &v);
            let points = fixture.rods().0;
            let forces: Vec<_> = wanted.iter().map(|load| load.force).collect();
            let resistances: Vec<_> = wanted.iter().map(|load| load.resistance * DVec3::X).collect();
            let got: Vec<_> = points.iter().map(|point| xyz(&point.force)).collect();
            let resists: Vec<_> = points.iter().map(|point| f64::from(point.resistance) * DVec3::X).collect();
            let error = relative(&got, &forces, 0.0).max(relative(&resists, &resistances, 0.0));
            let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
            println!("{model:?}, lift {lift}, {speed} m/s, {n}: largest {largest:.2e} N, off by {error:.1e}");
            // Measured at most 5.0e-7; margin 4.
            assert!(error < 2e-6, "{model:?}, {n}: {error}");
            assert!(n < 63 || largest > 0.0, "nothing drags");
        }
    }
}
