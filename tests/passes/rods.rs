//! Heading 4: the passes that load, start, solve and finish rods, and that exchange drag with the air.

mod choose;
mod sleep;
mod solve;

use glam::DVec3;
use windswept::internals::step;
use windswept_reference::{State as Twin, drive, rods, step::Scratch, velocity};
use windswept_scene::{Model, Scene};
use windswept_shaders::{self as shaders, common::integration::BDF2};

use crate::{
    drive::fields,
    stage::{Stage, quaternion, relative, stirred, xyz},
    steps::{DRAG, FIELDS_ON_HAIR, Fault, LIGHT_HAIR, PARTICLES, PUSHED, SWEEPS, TWO_WAY},
    support,
    walk::{Same, Walk, apart, differing, largest},
};

impl Walk<'_> {
    pub fn rods(&mut self, s: &mut Twin, w: &mut Scratch) -> Same {
        let (stage, bounds, p) = (self.stage, self.bounds, self.p().clone());
        let mut passes = stage.passes(step::rods::record);
        rods::begin(s, w, &p);
        if passes.through("rods/begin_points") {
            let points = stage.rods().0;
            let pairs = || points.iter().zip(&w.moving.points);
            let velocity = largest(pairs().map(|(a, b)| (xyz(&a.velocity) - b.velocity).length()));
            let before = largest(pairs().map(|(a, b)| (xyz(&a.before) - b.before).length()));
            let carried = largest(pairs().map(|(a, b)| (xyz(&a.carried) - b.carried).length()));
            self.same("rods/begin_points", velocity.max(before), bounds.speed)?;
            self.same("rods/begin_points", carried, bounds.length)?;
        }
        if passes.through("rods/begin_segments") {
            let segments = stage.rods().1;
            let pairs = || segments.iter().zip(&w.moving.segments);
            let start = largest(pairs().map(|(a, b)| (quaternion(a.start) - b.start).length()));
            let spin = largest(pairs().map(|(a, b)| (xyz(&a.angular_velocity) - b.angular_velocity).length()));
            let before = largest(pairs().map(|(a, b)| (xyz(&a.before) - b.before).length()));
            let carried = largest(pairs().map(|(a, b)| (xyz(&a.carried) - b.carried).length()));
            let chord = largest(pairs().map(|(a, b)| (xyz(&a.chord) - b.chord).length()));
            self.same("rods/begin_segments", start.max(carried), bounds.frame)?;
            self.same("rods/begin_segments", spin.max(before), bounds.spin)?;
            self.same("rods/begin_segments", chord, bounds.length)?;
        }
        if passes.through("rods/choose") {
            let rods = stage.rod_strands();
            let got: Vec<_> = rods.iter().map(|rod| rod.torn != 0).collect();
            let wanted: Vec<_> = w.drives.iter().map(|drive| drive.torn).collect();
            self.same("rods/choose", differing(&got, &wanted), 0.0)?;
            let before = rods.iter().zip(&w.drives).map(|(a, b)| (f64::from(a.misfit_before) - b.misfit_before).abs());
            self.same("rods/choose", largest(before), bounds.frame)?;
        }
        if passes.through("wind/sample") {
            let got = stage.engine.read(&stage.engine.state().sampled).unwrap();
            let pairs = || got.iter().zip(&w.local);
            self.same("wind/sample", largest(pairs().map(|(a, b)| (xyz(&a.wind) - b.wind).length())), bounds.speed)?;
            self.same(
                "wind/sample",
                largest(pairs().map(|(a, b)| (f64::from(a.filled) - b.filled).abs())),
                bounds.density,
            )?;
            self.same(
                "wind/sample",
                largest(pairs().map(|(a, b)| (f64::from(a.give) / b.give - 1.0).abs())),
                bounds.density,
            )?;
            let place = largest(pairs().map(|(a, b)| (xyz(&a.position) - b.position).length()));
            self.same("wind/sample", place, bounds.length)?;
        }
        w.local = rods::feel(s, w, &p);
        if passes.through("force/feel") {
            let got = stage.engine.read(&stage.engine.state().sampled).unwrap();
            let gaps = got.iter().zip(&w.local).map(|(a, b)| (xyz(&a.wind) - b.wind).length());
            self.same("force/feel", largest(gaps), bounds.speed)?;
        }
        for (pass, force) in rods::FORCES {
            force(s, w, &p);
            if !passes.through(pass) {
                continue;
            }
            let schemes: Vec<_> = stage.rod_strands().iter().map(|rod| rod.scheme == BDF2).collect();
            let wanted: Vec<_> = w.drives.iter().map(|drive| drive.step < p.step).collect();
            self.same(pass, differing(&schemes, &wanted), 0.0)?;
            let got = stage.engine.read(&stage.engine.state().hair_force).unwrap();
            // A force is held against what it changes a velocity by.
            let pairs = got.iter().zip(&w.hair_force).zip(&w.moving.points);
            let apart = pairs.map(|((got, force), point)| {
                let resisted = (f64::from(got[3]) - force.resistance).abs() * point.velocity.length();
                p.step * point.inverse_mass * ((xyz(&got[..3]) - force.force).length() + resisted)
            });
            self.same(pass, largest(apart), bounds.wind)?;
        }
        rods::bear(s, w, &p);
        if passes.through("rods/load") {
            let points = stage.rods().0;
            let pairs = || points.iter().zip(&w.moving.points);
            self.same(
                "rods/load",
                largest(pairs().map(|(a, b)| (xyz(&a.outside) - b.outside).length())),
                bounds.speed,
            )?;
            self.same("rods/load", largest(pairs().map(|(a, b)| (xyz(&a.push) - b.push).length())), bounds.speed)?;
        }
        rods::set_off(s, w, &p);
        if passes.through("rods/start") {
            self.states("rods/start", w)?;
            let (points, segments) = stage.rods();
            let integrated = || points.iter().zip(&w.moving.points).filter(|(_, b)| b.step.is_finite());
            let outside = integrated().map(|(a, b)| (xyz(&a.outside) - b.outside).length());
            self.same("rods/start", largest(outside), bounds.speed)?;
            let free = integrated().map(|(a, b)| (xyz(&a.free) - b.free).length());
            self.same("rods/start", largest(free), bounds.hair)?;
            let turning = segments.iter().zip(&w.moving.segments).filter(|(_, b)| b.step.is_finite());
            let free = turning.map(|(a, b)| (xyz(&a.free) - b.free).length());
            self.same("rods/start", largest(free), bounds.spin * p.step)?;
            self.moves("rods/start", w)?;
        }
        if p.direct {
            for strand in 0..s.hair.len() {
                for _ in 0..p.newton_steps {
                    let quiet = rods::direct(&p, &s.hair, strand, &mut w.drives[strand], &mut w.moving);
                    s.quiet_steps += usize::from(quiet);
                }
            }
            if passes.through("rods/direct") {
                self.moves("rods/direct", w)?;
            }
            for strand in 0..s.hair.len() {
                let torn = rods::rescue(&p, &s.hair, strand, &mut w.drives[strand], &mut w.moving);
                s.rescued_steps += usize::from(torn);
            }
            if passes.through("rods/rescue") {
                self.states("rods/rescue", w)?;
                self.moves("rods/rescue", w)?;
            }
        }
        for strand in 0..s.hair.len() {
            rods::gauss_seidel(&p, &s.hair, strand, &w.drives[strand], &mut w.moving);
        }
        if passes.through("rods/gauss_seidel") {
            self.moves("rods/gauss_seidel", w)?;
        }
        rods::leave(s, w, &p);
        if passes.through("rods/finish") {
            self.health("rods/finish", s)?;
        }
        let given = |w: &Scratch| {
            let given = stage.vectors(&stage.engine.state().drag_impulse);
            let of = |(i, (a, b)): (usize, (&DVec3, &DVec3))| s.inverse_mass[i] * (*a - *b).length();
            largest(given.iter().zip(&w.drag_impulse).enumerate().map(of))
        };
        if passes.through("rods/place") {
            let got = &stage.vectors(&stage.engine.state().predicted)[..p.hair_points];
            self.same("rods/place", apart(got, &w.predicted[..p.hair_points]), bounds.length)?;
            self.same("rods/place", given(w), bounds.speed)?;
            let left = |point: &rods::Point| velocity::velocity(&p, point, DVec3::ZERO);
            let wanted: Vec<_> = w.moving.points.iter().map(left).collect();
            let got = stage.vectors(&stage.engine.state().new_velocity);
            self.same("rods/place", apart(&got[..p.hair_points], &wanted), bounds.speed)?;
            let points = stage.rods().0;
            let before = points.iter().zip(&w.moving.points).map(|(a, b)| (xyz(&a.before) - b.velocity).length());
            self.same("rods/place", largest(before), bounds.speed)?;
        }
        w.drag_impulse = rods::keep(s, w, &p);
        if passes.through("force/keep") {
            self.same("force/keep", given(w), bounds.speed)?;
        }
        if passes.through("wind/react") {
            let change = rods::react(&p, &w.local, &w.drag_impulse, &w.predicted, &s.volume, &s.inverse_mass, &w.near);
            w.new_velocity[p.hair_points..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
            let got = self.vectors(&stage.engine.state().new_velocity, p.hair_points);
            self.same("wind/react", apart(&got, &w.new_velocity[p.hair_points..]), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }

    /// Compares moves and frames.
    fn moves(&mut self, pass: &'static str, w: &Scratch) -> Same {
        let (points, segments) = self.stage.rods();
        let moves = points.iter().zip(&w.moving.points).map(|(a, b)| (xyz(&a.travel) - b.travel).length());
        self.same(pass, largest(moves), self.bounds.hair)?;
        let frames = segments.iter().zip(&w.moving.segments).map(|(a, b)| (quaternion(a.frame) - b.frame).length());
        self.same(pass, largest(frames), self.bounds.frame)
    }
}

/// Planted faults of the passes of this heading.
pub const FAULTS: &[Fault] = &[
    (
        &shaders::rods::BEGIN_POINTS,
        "correction[p].xyz / params.step",
        "0.9 * correction[p].xyz / params.step",
        PARTICLES,
    ),
    (&shaders::rods::BEGIN_SEGMENTS, "before = history.angular_velocity", "before = vec3f(0.0)", PARTICLES),
    (&shaders::rods::CHOOSE, "led < TORN", "led > TORN", PARTICLES),
    (&shaders::wind::SAMPLE, "hair / params.air_density", "0.9 * hair / params.air_density", TWO_WAY),
    (&shaders::wind::DRAG, "params.lift", "0.9 * params.lift", DRAG),
    (&shaders::force::FEEL, "gale_at(air.position).wind", "0.9 * gale_at(air.position).wind", FIELDS_ON_HAIR),
    (&shaders::force::PUSH_HAIR, "/ w * pushed[p].xyz", "/ w * 0.9 * pushed[p].xyz", PUSHED),
    (&shaders::force::KEEP, "params.step * felt", "0.9 * params.step * felt", PUSHED),
    (&shaders::rods::LOAD, "params.step * point.inverse_mass", "0.9 * params.step * point.inverse_mass", TWO_WAY),
    (
        &shaders::rods::START,
        "return params.step * point.velocity",
        "return 0.9 * params.step * point.velocity",
        PARTICLES,
    ),
    (&shaders::rods::START, "point.weight * params.gravity", "params.gravity", LIGHT_HAIR),
    (&shaders::rods::DIRECT, "own.force += stretch;", "own.force += 0.9 * stretch;", PARTICLES),
    (&shaders::rods::RESCUE, "<= select(LOST, max(MISFIT, rod.misfit_before), rod.far != 0u)", "<= -1.0", PARTICLES),
    (&shaders::rods::GAUSS_SEIDEL, "0.5 * rotate(before", "0.4 * rotate(before", SWEEPS),
    (&shaders::rods::FINISH, "rest_length - 1.0", "rest_length - 1.0001", PARTICLES),
    (&shaders::rods::PLACE, "remainder, point.travel", "remainder, 0.9 * point.travel", PARTICLES),
    (&shaders::rods::PLACE, "vec4f(velocity, 0.0)", "vec4f(0.9 * velocity, 0.0)", PARTICLES),
    (&shaders::rods::PLACE, "before = point.velocity", "before = 0.9 * point.velocity", PARTICLES),
    (&shaders::wind::REACT, "params.air_inverse_mass * own.w", "0.9 * params.air_inverse_mass * own.w", TWO_WAY),
];

/// The wind of force fields at hair points, and an acceleration that was set, without air and outside its box.
#[test]
fn forces_on_hair_are_those_of_the_twin() {
    for model in [Model::Drag, Model::Particles] {
        for n in support::SIZES.into_iter().filter(|n| *n > 1) {
            let mut scene = Scene { forces: fields(), ..support::scene() };
            scene.interaction.model = model;
            let air = if model == Model::Particles { n / 3 } else { 0 };
            let mut stage = Stage::new(&scene, &support::particles(n, n - air, support::Layout::Random, 7));
            stage.push();
            let (p, s) = (&stage.parameters, stage.engine.state());
            let velocity = stirred(stage.twin.position.len());
            stage.write_vectors(&s.velocity, &velocity);
            stage.run(step::drive::record);
            stage.run_only(&["rods/begin_points", "force/feel", "force/push_hair"], step::rods::record);
            let mut twin = Twin { velocity, ..stage.twin.clone() };
            let mut w = drive::run(&twin, p);
            w.correction = vec![DVec3::ZERO; p.hair_points];
            rods::begin(&twin, &mut w, p);
            let felt: Vec<_> = rods::feel(&twin, &w, p).iter().map(|local| local.wind).collect();
            rods::push_hair(&mut twin, &mut w, p);
            let pushed: Vec<_> = w.hair_force.iter().map(|load| load.force).collect();
            let sampled = stage.engine.read(&s.sampled).unwrap();
            let got: Vec<_> = sampled.iter().map(|air| xyz(&air.wind)).collect();
            let errors = [relative(&got, &felt, 1e-3), relative(&stage.vectors(&s.hair_force), &pushed, 0.0)];
            println!("{model:?}, {n} particles: {:.1e}, {:.1e}", errors[0], errors[1]);
            // Measured at most 2.7e-7 and 4.2e-8; margin 4.
            assert!(errors[0] < 1.1e-6 && errors[1] < 1.7e-7, "{model:?}, {n} particles: {errors:?}");
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
            let air = vec![rods::undisturbed(p.wind); p.hair_points];
            let (wanted, _) = rods::drag(p, &twin.hair, &air, &twin.position, &v);
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
