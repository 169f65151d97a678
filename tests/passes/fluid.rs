//! Stage `fluid`: the passes of the density constraint.

use glam::DVec3;
use windswept::internals::step;
use windswept_reference::{State as Reference, fluid, step::Scratch};
use windswept_scene::{FluidSolver, Model};
use windswept_shaders as shaders;

use crate::{
    fixture::{Fixture, Passes, each, stirred, xyz},
    steps::{BOUNDS, CROWDED, DIVERGENCE, Fault, LIGHT_HAIR, PARTICLES, PRESSED_HAIR, STARTED, WALLS},
    support,
    walk::{Bounds, Same, Walk, apart, largest, mean_change, numbers_apart, walk},
};

impl Walk<'_> {
    pub fn fluid(&mut self, s: &Reference, w: &mut Scratch) -> Same {
        let (fixture, bounds) = (self.fixture, self.bounds);
        let state = fixture.engine.state();
        w.correction = vec![DVec3::ZERO; w.predicted.len()];
        w.pressed.clone_from(&s.pressed);
        let mut passes = fixture.passes(step::fluid::record);
        let count = fixture.engine.sizes().constrained as usize;
        w.density = vec![0.0; w.predicted.len()];
        let mut multiplier = vec![0.0; self.p().hair_points];
        while passes.through("fluid/density") {
            let x = &w.predicted[..count];
            let (density, lambda) = fluid::density(self.p(), x, &s.inverse_mass, &s.volume, &w.near);
            let densest = largest(density.iter().copied()).max(1.0);
            let gap = numbers_apart(&fixture.numbers(&state.density)[..count], &density) / densest;
            w.density[..count].copy_from_slice(&density);
            self.same("fluid/density", gap, bounds.density)?;
            let most = largest(lambda.iter().map(|lambda| lambda.abs())).max(self.of_one_percent());
            let felt = fluid::felt(self.p(), &density, &lambda);
            let got = fixture.engine.read(&state.multiplier).unwrap();
            for (k, wanted) in [&lambda, &felt].into_iter().enumerate() {
                let got: Vec<_> = got[..count].iter().map(|parts| f64::from(parts[k])).collect();
                self.same("fluid/density", numbers_apart(&got, wanted) / most, bounds.multiplier)?;
            }
            if !passes.through("fluid/correct") {
                break;
            }
            let correct = |lambda: &[f64]| fluid::correct(self.p(), x, &s.inverse_mass, &s.volume, &w.near, lambda);
            let (shift, felt) = (correct(&lambda), correct(&felt));
            // In parts of the largest, or of 10 µm: a density error of 1 % asks for about as much.
            let most = largest(shift.iter().map(|shift| shift.length())).max(1e-5);
            for (array, wanted) in [(&state.shift, &shift), (&state.velocity_shift, &felt)] {
                let gap = apart(&fixture.vectors(array)[..count], wanted) / most;
                self.same("fluid/correct", gap, bounds.multiplier)?;
            }
            passes.through("fluid/move");
            let relaxation = self.p().relaxation;
            multiplier.iter_mut().zip(&lambda).for_each(|(sum, lambda)| *sum += relaxation * lambda);
            for (i, (shift, felt)) in shift.into_iter().zip(felt).enumerate() {
                w.predicted[i] += shift;
                w.correction[i] += felt;
            }
            let got = fixture.vectors(&state.predicted);
            self.same("fluid/move", self.places(&got[..count], &w.predicted[..count], 0), bounds.length)?;
            let gap = apart(&fixture.vectors(&state.correction)[..count], &w.correction[..count]);
            self.same("fluid/move", gap, bounds.length)?;
        }
        self.friction(s, w, &multiplier, &mut passes)?;
        if passes.through("fluid/velocity") {
            let hair = self.p().hair_points;
            for i in hair..w.predicted.len() {
                w.new_velocity[i] = fluid::velocity(self.p(), w.new_velocity[i], w.correction[i]);
                w.correction[i] = DVec3::ZERO;
            }
            let got = self.vectors(&state.new_velocity, hair);
            self.same("fluid/velocity", apart(&got, &w.new_velocity[hair..]), bounds.speed)?;
        }
        if self.p().solver == FluidSolver::Divergence {
            self.pressure(s, w, &mut passes)?;
        }
        passes.finish();
        Ok(())
    }

    /// Friction of hair on hair, if it runs.
    fn friction(&mut self, s: &Reference, w: &mut Scratch, multiplier: &[f64], passes: &mut Passes<'_>) -> Same {
        let (fixture, bounds, p) = (self.fixture, self.bounds, self.p());
        let (state, hair) = (fixture.engine.state(), p.hair_points);
        w.tangential_spring.clone_from(&s.tangential_spring);
        if !passes.through("fluid/slip") {
            return Ok(());
        }
        let points: Vec<_> = (0..hair).map(|i| fluid::slip(p, s, i, w.correction[i], multiplier[i])).collect();
        let normal_impulses = fluid::normal_impulse(p, &w.predicted, &s.inverse_mass, &s.volume, &points, &w.near);
        let (change, springs) = fluid::friction(
            p,
            &w.predicted,
            &s.tangential_spring,
            &s.inverse_mass,
            &s.volume,
            &points,
            &normal_impulses,
            &w.near,
        );
        let got = fixture.engine.read(&state.friction_points).unwrap();
        let pairs = || got.iter().zip(&points);
        let speed = |a: &[f32], b: DVec3| (xyz(a) - b).length();
        let slips = pairs().map(|(a, b)| speed(&a.pull, b.pull).max(speed(&a.moved, b.moved)));
        // A point's move by the constraint is an impulse; positions are compared where they move.
        self.same("fluid/slip", largest(slips), bounds.length / self.p().step)?;
        let most = largest(points.iter().map(|point| point.multiplier.abs())).max(self.of_one_percent());
        let multipliers = pairs().map(|(a, b)| (f64::from(a.multiplier) - b.multiplier).abs() / most);
        self.same("fluid/slip", largest(multipliers), bounds.multiplier)?;
        passes.through("fluid/normal_impulse");
        let most = largest(normal_impulses.iter().copied()).max(bounds.length / self.p().step);
        let gap = numbers_apart(&fixture.numbers(&state.normal_impulses), &normal_impulses) / most;
        self.same("fluid/normal_impulse", gap, bounds.multiplier)?;
        passes.through("fluid/friction");
        let moves: Vec<DVec3> = change.iter().map(|change| self.p().step * *change).collect();
        self.same("fluid/friction", apart(&fixture.vectors(&state.shift)[..hair], &moves), bounds.length)?;
        self.same("fluid/friction", apart(&fixture.vectors(&state.tangential_spring), &springs), bounds.speed)?;
        passes.through("fluid/move");
        for (i, shift) in moves.into_iter().enumerate() {
            w.predicted[i] += shift;
            w.correction[i] += shift;
        }
        w.tangential_spring = springs;
        Ok(())
    }

    /// Pressure: spread, moments, the pressures of the step before, the coarse grid, iterations.
    fn pressure(&mut self, s: &Reference, w: &mut Scratch, passes: &mut Passes<'_>) -> Same {
        let (fixture, bounds, p) = (self.fixture, self.bounds, self.p().clone());
        let (state, hair) = (fixture.engine.state(), p.hair_points);
        let first = if p.model == Model::Particles { 0 } else { hair };
        let (mass, volume) = (&s.inverse_mass, &s.volume);
        let deformation = fluid::deform(&p, &w.predicted, &w.new_velocity, volume, &w.near);
        if passes.through("fluid/deform") {
            w.eddies = deformation.iter().map(|deformation| fluid::eddies(&p, *deformation)).collect();
            let gap = numbers_apart(&fixture.exchange(|all| all.deformation), &deformation);
            self.same("fluid/deform", gap, bounds.density)?;
        }
        let shift = fluid::spread(&p, &w.predicted, &w.new_velocity, volume, &w.near, &deformation, &w.walls);
        assert!(passes.through("fluid/spread"));
        self.same("fluid/spread", apart(&self.vectors(&state.shift, hair), &shift[hair..]), bounds.length)?;
        let before = w.predicted.clone();
        w.predicted.iter_mut().zip(shift).for_each(|(x, shift)| *x += shift);
        passes.through("fluid/place");
        if fixture.plan.conditions.walls.runs {
            fluid::walls(w, &p);
            self.walls("fluid/place", w)?;
        }
        let gap = self.places(&self.vectors(&state.predicted, hair), &w.predicted[hair..], hair);
        self.same("fluid/place", gap, bounds.length)?;

        w.moments = fluid::moments(&p, &w.predicted, mass, volume, &w.near, &w.walls);
        let of_hair = w.density.clone();
        w.density = w.moments.iter().map(|moments| moments.density).collect();
        w.density[..first].copy_from_slice(&of_hair[..first]);
        passes.through("fluid/moments");
        let densest = largest(w.density.iter().copied()).max(1.0);
        let gap = numbers_apart(&fixture.numbers(&state.density)[first..], &w.density[first..]) / densest;
        self.same("fluid/moments", gap, bounds.density)?;
        let got = fixture.engine.read(&state.gradients).unwrap();
        let gaps = got.iter().zip(&w.moments).skip(first).map(|(got, wanted)| {
            let b = wanted.correction;
            let diagonal = DVec3::new(b.x_axis.x, b.y_axis.y, b.z_axis.z);
            let off_diagonal = DVec3::new(b.y_axis.z, b.z_axis.x, b.x_axis.y);
            let response = (f64::from(got.response) / wanted.diagonal - 1.0).abs();
            let size = (xyz(&got.diagonal) - diagonal).length() + (xyz(&got.off_diagonal) - off_diagonal).length();
            size.max(response)
        });
        self.same("fluid/moments", largest(gaps), bounds.multiplier)?;
        let walls = fixture.engine.read(&state.wall).unwrap();
        let gaps = walls.iter().zip(&w.moments).zip(&w.walls).skip(first).map(|((got, moments), _)| {
            p.kernel_radius * (f64::from(got.weight) * xyz(&got.normal) - moments.wall).length()
        });
        self.same("fluid/moments", largest(gaps), bounds.multiplier)?;
        let each = |i: usize| fluid::start(&p, i, &w.moments[i], &s.pressed[i]);
        w.pressed = (0..w.predicted.len()).map(each).collect();
        let lambda: Vec<f64> = w.pressed.iter().map(|pressed| pressed.pressure).collect();
        self.push(s, w, passes, &lambda)?;

        if p.coarse {
            self.coarse(&before, w, passes)?;
        }
        for omega in fluid::relaxations(p.pressure_iterations) {
            let rate = fluid::divergence(&p, &w.predicted, &w.new_velocity, volume, &w.near, &w.moments);
            let each =
                |i: usize| fluid::relax(omega, p.part(s.volume[i]), rate[i], &w.moments[i], w.pressed[i].pressure);
            let mu: Vec<f64> = (0..rate.len()).map(each).collect();
            w.pressed.iter_mut().zip(&mu).for_each(|(pressed, mu)| pressed.pressure += mu);
            assert!(passes.through("fluid/divergence"));
            self.diverging(&rate, w)?;
            self.push(s, w, passes, &mu)?;
        }
        if passes.through("fluid/path") {
            fluid::path(s, w, &p);
            let gap = self.places(&self.vectors(&state.predicted, hair), &w.predicted[hair..], hair);
            self.same("fluid/path", gap, bounds.length)?;
        }
        if passes.through("fluid/impulse") {
            for i in 0..hair {
                w.correction[i] = fluid::LASTING * p.step * w.pressed[i].change;
            }
            let gap = apart(&fixture.vectors(&state.correction)[..hair], &w.correction[..hair]);
            self.same("fluid/impulse", gap, bounds.length)?;
        }
        Ok(())
    }

    /// The divergence and the pressures that it leaves.
    fn diverging(&mut self, rate: &[f64], w: &Scratch) -> Same {
        let (fixture, bounds) = (self.fixture, self.bounds);
        let first = if self.p().model == Model::Particles { 0 } else { self.p().hair_points };
        let state = fixture.engine.state();
        let stress = fixture.engine.read(&state.stress).unwrap();
        let gaps = stress.iter().zip(rate).skip(first).map(|(got, wanted)| (f64::from(got.divergence) - wanted).abs());
        // In parts of the largest, or of 8/s: a difference of 4 cm/s from one particle to the next.
        let most = largest(rate.iter().map(|rate| rate.abs())).max(8.0);
        self.same("fluid/divergence", largest(gaps) / most, bounds.multiplier)?;
        let pressed = fixture.engine.read(&state.pressed).unwrap();
        let most = largest(w.pressed.iter().map(|pressed| pressed.pressure.abs())).max(1e-6);
        let both = pressed.iter().zip(&w.pressed).skip(first);
        let gaps = both.map(|(got, wanted)| (f64::from(got.pressure) - wanted.pressure).abs() / most);
        self.same("fluid/divergence", largest(gaps), bounds.multiplier)
    }

    /// Push of the pressures.
    fn push(&mut self, s: &Reference, w: &mut Scratch, passes: &mut Passes<'_>, pressure: &[f64]) -> Same {
        let p = self.p();
        let first = if p.model == Model::Particles { 0 } else { p.hair_points };
        let change = fluid::push(p, &w.predicted, &s.inverse_mass, &s.volume, &w.near, &w.moments, pressure);
        give(w, &change);
        fluid::give_bodies(w, pressure);
        assert!(passes.through("fluid/push"));
        self.pushed("fluid/push", w, first)?;
        self.impulses("fluid/push", w, first)
    }

    /// Velocities, and what of them pressure made, of the particles from `first` on.
    fn pushed(&mut self, pass: &'static str, w: &Scratch, first: usize) -> Same {
        let (fixture, bounds) = (self.fixture, self.bounds);
        let state = fixture.engine.state();
        // Where air is pressed together it is shot out: in parts of the largest speed if that is more than 10 m/s.
        let most = largest(w.new_velocity.iter().map(|v| v.length())).max(10.0) / 10.0;
        let gap = apart(&self.vectors(&state.new_velocity, first), &w.new_velocity[first..]);
        self.same(pass, gap / most, bounds.speed)?;
        let pressed = fixture.engine.read(&state.pressed).unwrap();
        let both = pressed.iter().zip(&w.pressed).skip(first);
        let gap = largest(both.map(|(got, wanted)| (xyz(&got.change) - wanted.change).length()));
        self.same(pass, gap / most, bounds.speed)
    }

    /// The coarse grid, of air that was at `before` when it was sorted.
    fn coarse(&mut self, before: &[DVec3], w: &mut Scratch, passes: &mut Passes<'_>) -> Same {
        let (fixture, bounds, p) = (self.fixture, self.bounds, self.p().clone());
        let (state, hair) = (fixture.engine.state(), p.hair_points);
        let rate = fluid::divergence(&p, &w.predicted, &w.new_velocity, &fixture.reference.volume, &w.near, &w.moments);
        assert!(passes.through("fluid/divergence"));
        self.diverging(&rate, w)?;
        assert!(passes.through("fluid/coarse_source"));
        let sorted = fixture.engine.read(&state.sorted).unwrap();
        let got = fixture.engine.read(&state.deposit_source).unwrap();
        // Air stands first.
        let deposit_source = || sorted.iter().map(|i| *i as usize).zip(&got).take(before.len() - hair);
        let source = |i: usize| fluid::source(rate[i], &w.moments[i], w.new_velocity[i]);
        let gaps = deposit_source().map(|(i, got)| (f64::from(got[3]) - source(i)).abs());
        let most = largest(rate.iter().map(|rate| rate.abs())).max(8.0);
        self.same("fluid/coarse_source", largest(gaps) / most, bounds.multiplier)?;
        let spacing = p.box_size / DVec3::from_array(p.coarse_nodes.map(|n| n as f64));
        let wrapped = |x: DVec3| (x - p.box_size * (x / p.box_size).floor()) / spacing;
        let gaps = deposit_source().map(|(i, got)| (xyz(&got[..3]) - wrapped(before[i])).length());
        self.same("fluid/coarse_source", largest(gaps), bounds.nodes)?;

        let nodes = |array| -> Vec<f64> { fixture.engine.read(array).unwrap().into_iter().map(f64::from).collect() };
        let deposited = fluid::coarse_deposit(&p, before, &w.new_velocity, &rate, &w.moments);
        passes.through("fluid/coarse_deposit");
        let most = largest(deposited.iter().map(|sum| sum.abs())).max(1e-3);
        let gap = numbers_apart(&nodes(&state.coarse), &deposited) / most;
        self.same("fluid/coarse_deposit", gap, bounds.nodes)?;

        let pressure = fluid::coarse_solve(&p, &deposited);
        let most = largest(pressure.iter().map(|c| c.abs())).max(1e-9);
        passes.through("fluid/coarse_wave");
        passes.through("fluid/coarse_wave");
        // The way back leaves a factor of the number of nodes, which is taken out here.
        let count = pressure.len() as f64;
        let solved: Vec<f64> = fluid::coarse_waves(&p, &pressure).iter().map(|wave| wave / count).collect();
        let largest_wave = largest(solved.iter().map(|wave| wave.abs())).max(1e-9);
        self.same(
            "fluid/coarse_wave",
            numbers_apart(&nodes(&state.coarse_waves), &solved) / largest_wave,
            bounds.nodes,
        )?;
        passes.through("fluid/coarse_wave");
        self.same("fluid/coarse_wave", numbers_apart(&nodes(&state.coarse), &pressure) / most, bounds.nodes)?;

        let change = fluid::coarse_gather(&p, before, &pressure);
        passes.through("fluid/coarse_gather");
        let gap = apart(&self.vectors(&state.coarse_change, hair), &change[hair..]);
        self.same("fluid/coarse_gather", gap, bounds.speed)?;
        passes.through("reduce/changes");
        let (parts, most) = (fixture.engine.read(&state.partial_sum).unwrap(), self.p().largest_wind.max(1.0));
        let sum = |k: usize| parts.iter().map(|part| f64::from(part[k])).sum::<f64>();
        let air = || change.iter().zip(&w.new_velocity).skip(hair);
        let vectors = [(0, air().map(|(q, _)| *q).sum::<DVec3>()), (4, air().map(|(_, v)| *v).sum())];
        for (k, wanted) in vectors {
            let got = DVec3::new(sum(k), sum(k + 1), sum(k + 2));
            self.same("reduce/changes", (got - wanted).length() / air().len() as f64, bounds.speed)?;
        }
        for (k, wanted) in [(3, air().map(|(q, v)| q.dot(*v)).sum::<f64>()), (7, air().map(|(q, _)| q.dot(*q)).sum())] {
            self.same("reduce/changes", (sum(k) - wanted).abs() / air().len() as f64, most * bounds.speed)?;
        }
        passes.through("reduce/total");
        let totals = fixture.engine.read(&state.coarse_total).unwrap();
        for k in 0..8 {
            let gap = (f64::from(totals[k / 4][k % 4]) - sum(k)).abs() / air().len() as f64;
            self.same("reduce/total", gap, most * bounds.speed)?;
        }
        let solids = fluid::coarse_solid(&p, &w.moving.bodies, &pressure);
        self.solids(&solids, passes)?;
        let (mean, part) = fluid::coarse_mean(&p, &w.new_velocity, &change, &solids);
        give(w, &fluid::coarse_push(&p, &change, mean, part));
        w.coarse_impulse = fluid::coarse_impulse(&solids, mean, part);
        let unpushed = self.vectors(&state.new_velocity, hair);
        passes.through("fluid/coarse_push");
        let impulse = self.vectors(&state.coarse_impulse, 0);
        let air = (unpushed.len() as f64).max(1.0);
        self.same("fluid/coarse_push", apart(&impulse, &w.coarse_impulse) / air, bounds.speed)?;
        // With what bodies get no wind is driven.
        let given = impulse.into_iter().sum::<DVec3>() / fluid::LASTING / air;
        let driven = mean_change(&unpushed, &self.vectors(&state.new_velocity, hair)) + given;
        self.same("fluid/coarse_push", driven.length(), 0.1 * bounds.wind)?;
        self.pushed("fluid/coarse_push", w, hair)
    }

    /// Multiplier that a density error of 1 % asks for where air is nearly at rest density \[kg m²\]: the softening is
    /// a thousandth of the lattice's gradients.
    fn of_one_percent(&self) -> f64 {
        1e-2 * 1e-3 / self.p().density_softening.max(f64::MIN_POSITIVE)
    }
}

/// Adds what pressure changes velocities by.
fn give(w: &mut Scratch, change: &[DVec3]) {
    for (i, change) in change.iter().enumerate() {
        w.new_velocity[i] += *change;
        w.pressed[i].change += *change;
    }
}

/// Planted faults of the passes of this stage.
pub const FAULTS: &[Fault] = &[
    (&shaders::fluid::DENSITY, PARTICLES, &[314, 0]),
    (&shaders::fluid::CORRECT, PARTICLES, &[37, 21]),
    (&shaders::fluid::MOVE, PARTICLES, &[11]),
    (&shaders::fluid::DEFORM, DIVERGENCE, &[14]),
    (&shaders::fluid::SPREAD, DIVERGENCE, &[0]),
    (&shaders::fluid::PLACE, DIVERGENCE, &[9]),
    (&shaders::fluid::MOMENTS, DIVERGENCE, &[0]),
    (&shaders::forcing::WALLS, WALLS, &[335, 328]),
    (&shaders::fluid::SPREAD, WALLS, &[5]),
    (&shaders::fluid::MOMENTS, WALLS, &[435, 68]),
    (&shaders::fluid::DIVERGENCE, WALLS, &[15]),
    (&shaders::fluid::PUSH, WALLS, &[26, 32]),
    (&shaders::fluid::SOLID, STARTED, &[9]),
    (&shaders::fluid::COARSE_SOURCE, WALLS, &[0]),
    (&shaders::fluid::COARSE_SOLID, WALLS, &[28]),
    (&shaders::reduce::BY_BODY, WALLS, &[3]),
    (&shaders::fluid::COARSE_PUSH, WALLS, &[44]),
    (&shaders::fluid::PATH, WALLS, &[7]),
    (&shaders::fluid::PUSH, DIVERGENCE, &[37]),
    (&shaders::fluid::DIVERGENCE, DIVERGENCE, &[62]),
    (&shaders::fluid::DIVERGENCE, LIGHT_HAIR, &[47]),
    (&shaders::fluid::IMPULSE, PRESSED_HAIR, &[21]),
    (&shaders::fluid::COARSE_SOURCE, DIVERGENCE, &[20, 25]),
    (&shaders::fluid::COARSE_DEPOSIT, DIVERGENCE, &[16]),
    (&shaders::fluid::COARSE_WAVE, DIVERGENCE, &[85, 4, 10]),
    (&shaders::fluid::COARSE_GATHER, DIVERGENCE, &[129]),
    (&shaders::reduce::CHANGES, DIVERGENCE, &[0]),
    (&shaders::reduce::TOTAL, DIVERGENCE, &[12]),
    (&shaders::fluid::COARSE_PUSH, DIVERGENCE, &[19, 34, 50]),
    (&shaders::fluid::VELOCITY, PARTICLES, &[10]),
    (&shaders::fluid::SLIP, CROWDED, &[12]),
    (&shaders::fluid::NORMAL_IMPULSE, CROWDED, &[25]),
    (&shaders::fluid::FRICTION, CROWDED, &[39]),
];

/// An iteration of the density constraint on any crowd.
#[test]
fn the_density_constraint_is_that_of_the_reference() {
    let mut scene = support::scene();
    scene.fluid.iterations = 1;
    each(&scene, |what, fixture| {
        let (near, s) = (fixture.list_neighbours(), &fixture.reference);
        let (predicted, new_velocity) = (s.position.clone(), s.velocity.clone());
        let mut w = Scratch { predicted, new_velocity, near, ..Scratch::default() };
        // Measured 6e-8 m, 8.4e-7 and 1.3e-5; margin 4.
        let bounds = Bounds { length: 2.4e-7, density: 3.4e-6, multiplier: 5e-5, ..BOUNDS };
        walk(what, fixture, &bounds, |walk| walk.fluid(s, &mut w));
    });
}

/// Pressure on any crowd: of air that hair slows, and of hair and air together, from velocities that are anything.
#[test]
fn pressure_is_that_of_the_reference() {
    for model in [Model::TwoWay, Model::Particles] {
        let mut scene = support::scene();
        (scene.fluid.solver, scene.fluid.coarse) = (FluidSolver::Divergence, true);
        (scene.fluid.iterations, scene.interaction.model) = (0, model);
        scene.fluid.pressure_iterations = Some(2);
        each(&scene, |what, fixture| {
            let (near, s) = (fixture.list_neighbours(), &fixture.reference);
            let velocities = stirred(s.position.len());
            fixture.write_vectors(&fixture.engine.state().new_velocity, &velocities);
            let pressed = vec![Default::default(); s.position.len()];
            let mut w = Scratch {
                predicted: s.position.clone(),
                new_velocity: velocities,
                near,
                pressed,
                ..Scratch::default()
            };
            // Clumps of thousands in a few kernels are hard on f32: measured at most 1.7e-4 of densities, 2.1e-3 of the
            // largest divergence, 4.5e-3 of speeds of 10 m/s, 1.6e-6 m of what
            // hair is moved by; margin 4.
            let bounds = Bounds { density: 7e-4, multiplier: 8e-3, speed: 2e-2, length: 8e-6, wind: 4.4e-5, ..BOUNDS };
            walk(&format!("{what}, {model:?}"), fixture, &bounds, |walk| walk.fluid(s, &mut w));
        });
    }
}

/// Coincident particles separate, in opposite directions, by the same draw as the reference's.
#[test]
fn coincident_particles_separate() {
    let mut initial = support::particles(400, 0, support::Layout::Lattice, 2);
    initial.air.positions[101] = initial.air.positions[100];
    let fixture = Fixture::new(&support::scene(), &initial);
    let near = fixture.list_neighbours();
    fixture.run(step::fluid::record);
    let after = fixture.vectors(&fixture.engine.state().predicted);
    let gap = (after[101] - after[100]).length();
    println!("after 2 iterations they are {gap:.2e} m apart");
    assert!(gap > 1e-4, "{gap}");
    let (p, reference) = (&fixture.parameters, &fixture.reference);
    let mut x = reference.position.clone();
    for _ in 0..p.fluid_iterations {
        let (_, lambda) = fluid::density(p, &x, &reference.inverse_mass, &reference.volume, &near);
        let shift = fluid::correct(p, &x, &reference.inverse_mass, &reference.volume, &near, &lambda);
        x.iter_mut().zip(shift).for_each(|(x, dx)| *x += dx);
    }
    let error = (after[101] - x[101]).length();
    assert!(error < 1e-6, "{error} m from the reference");
}
