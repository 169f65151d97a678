//! Air beside bodies: its density, the drag and the wake, the impulse of a body that starts, rest, and momentum.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use windswept_engine::{Frame, Gpu, Simulation, internals::step};
use windswept_scene::{Air, Body, End, FluidSolver, Hair, Keyframe, Roots, Scene, Time};
use windswept_shaders::{common::pressure::Stress, fluid};

use crate::{
    Error, Row,
    air::{STEP, farthest, mean, spacing, vectors},
    contact::meshed,
    coupled::lasting,
    momentum,
    runner::Runner,
    scenes::blowing,
};

const FULL: &str = "density is uniform; within 3 spacings of the surface, before, behind and beside; measured up to 0.06 off where air goes a \
    third of the radius in a step, and 0.02 at half of that";
const EVEN: &str =
    "density is uniform: rms of theta - 1 within a kernel radius; 0.8 (U dt/R)^2 and the scatter of particles";
const DRAG: &str = "no formula: skin friction makes a layer of one spacing, and with it the drag of a Reynolds number of 100 to 200, near 1.2 \
    (Roshko 1961); measured 1.08 to 1.26 with a tenth of the box blocked";
const SHED: &str = "no formula: near 0.2 at such Reynolds numbers (Roshko 1954); measured 0.212 to 0.224";
const POTENTIAL: &str =
    "Lamb, Hydrodynamics, art. 92: 3/2 sin of the flux beside a sphere, 1 + R^3/2r^3 at the layer's radius";
const ADDED: &str = "Maxwell (1873): 1/2 (1 - c)/(1 + c/2) of the displaced mass in a periodic box of which the sphere takes c; particles of a \
    quarter of the radius see a body that is larger by some of their spacing";
const BALANCED: &str =
    "a constant pressure pushes nothing: what the wall pushes, over what the air alone would be pushed by";
const STILL: &str = "air that is at rest stays there: exactly";
const KEPT: &str =
    "Newton: what air and hair gain the body loses; over the sum of the impulses; measured 2.3e-7 at most; f32";
const FASTEST: &str =
    "potential flow past a sphere comes to 1.5 U, past a cylinder to 2 U, and blockage and shed vortices add to it";

/// Distance from a surface within which the density is looked at \[spacings\].
const SHELL: f64 = 3.0;
/// Wind \[m/s\].
const WIND: f64 = 3.0;

/// A body in a box of so many of the paper's spacings.
#[derive(Debug, Clone, Copy)]
pub struct Tunnel {
    solver: FluidSolver,
    /// Spacing of the particles, over the paper's.
    coarseness: f64,
    /// Sides of the box \[spacings\].
    sides: [f64; 3],
    /// Radius of the body \[spacings\].
    radius: f64,
    /// Whether the body is a sphere; else it is a cylinder along z.
    sphere: bool,
    /// Center of the body, in parts of the box.
    center: [f64; 3],
    /// Wind along x \[m/s\].
    wind: f64,
    /// Substeps of a step of 1.38 ms.
    substeps: u32,
    /// Skin friction coefficient C_f.
    friction: f64,
    /// Time at which the body is set off, and its speed \[s, m/s\].
    motion: Option<[f64; 2]>,
}

/// A cylinder of 12 mm in a wind of 3 m/s.
const THIN: Tunnel = Tunnel {
    solver: FluidSolver::Divergence,
    coarseness: 1.0,
    sides: [33.0, 25.0, 6.0],
    radius: 2.479,
    sphere: false,
    center: [0.3125, 0.5, 0.5],
    wind: WIND,
    substeps: 1,
    friction: 0.1,
    motion: None,
};
/// A cylinder that blocks a tenth of the wind.
const TENTH: Tunnel = Tunnel { sides: [110.0, 80.0, 6.0], radius: 4.0, friction: 0.2, ..THIN };
/// A sphere in a wind.
const BALL: Tunnel = Tunnel { sides: [48.0, 28.0, 28.0], radius: 4.0, sphere: true, ..THIN };
/// A sphere in the middle of still air.
const STOOD: Tunnel =
    Tunnel { sides: [24.0; 3], radius: 4.0, sphere: true, center: [0.5; 3], wind: 0.0, friction: 0.0, ..THIN };

/// Air and its densities in a shell about the body.
#[derive(Default)]
struct Beside {
    /// Density behind the body, before it and beside it, over the mean.
    sectors: [f64; 3],
    /// rms of θ − 1 within a kernel radius of the body.
    error: f64,
    /// Smallest and largest θ there.
    range: [f64; 2],
    /// Largest speed of air \[m/s\].
    fastest: f64,
}

impl Tunnel {
    /// A cylinder of 12 mm in a wind of 3 m/s, in air of so many times the paper's spacing, with so many substeps.
    #[must_use]
    pub fn cylinder(solver: FluidSolver, coarseness: f64, substeps: u32) -> Self {
        Self { solver, coarseness, substeps, ..THIN }
    }

    /// rms of θ − 1 within a kernel radius of the body, and the density behind it off the mean, from one time to
    /// another \[s\].
    ///
    /// # Errors
    /// [`Error`] if the run cannot be.
    pub fn unevenness(&self, gpu: &Gpu, times: [f64; 2]) -> Result<[f64; 2], Error> {
        let (beside, _) = self.run(gpu, times, 9)?;
        Ok([beside.error, (beside.sectors[0] - 1.0).abs()])
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> Scene {
        let size = self.sides.map(|side| side * spacing());
        let [x, y, z] = [0, 1, 2].map(|axis| self.center[axis] * self.sides[axis] * spacing());
        let radius = self.radius * spacing();
        let mut body = match self.sphere {
            true => Body::sphere([x, y, z], radius),
            false => Body::capsule([x, y, -0.05], [x, y, size[2] + 0.05], radius),
        };
        if let Some([start, speed]) = self.motion {
            let end = Keyframe { translation: [speed, 0.0, 0.0], ..Keyframe::new(start + 1.0) };
            body.motion = [Keyframe::new(start), end].into();
        }
        let mut scene = Scene::new(Time { substeps: self.substeps, ..Time::new(STEP, 10.0) });
        scene.gravity = [0.0; 3];
        scene.fluid.solver = Some(self.solver);
        scene.air = Some(Air {
            spacing: Air::SPACING * self.coarseness,
            skin_friction: self.friction,
            fringe: (self.wind == 0.0).then_some(0.0),
            ..blowing(size, [self.wind, 0.0, 0.0])
        });
        scene.bodies = vec![body];
        scene
    }

    fn simulation(&self, gpu: &Gpu) -> Result<Simulation, Error> {
        Ok(Simulation::new(gpu, &self.scene())?)
    }

    /// Volume of the body's inside in the box \[m³\], of a body that is larger by `more` \[m\].
    fn volume(&self, more: f64) -> f64 {
        let radius = self.radius * spacing() + more;
        if self.sphere { 4.0 / 3.0 * PI * radius.powi(3) } else { PI * radius.powi(2) * self.sides[2] * spacing() }
    }

    /// Parts of a shell that are behind the body, before it and beside it.
    fn parts(&self) -> [f64; 3] {
        let cap = if self.sphere { 0.5 * (1.0 - 0.5_f64.sqrt()) } else { 0.25 };
        [cap, cap, 1.0 - 2.0 * cap]
    }

    /// Air about the body now.
    fn beside(&self, simulation: &mut Simulation) -> Result<Beside, Error> {
        let density = simulation.density()?;
        let frame = simulation.frame()?;
        let body = simulation.scene().bodies[0].at(simulation.time());
        let (d, hair) = (spacing(), frame.hair.positions.len());
        let volume = simulation.initial().air.volume;
        let mut found = Beside { range: [f64::INFINITY, 0.0], ..Beside::default() };
        let (mut errors, mut near) = (0.0, 0.0);
        for ((x, v), theta) in
            vectors(&frame.air.positions).iter().zip(vectors(&frame.air.velocities)).zip(&density[hair..])
        {
            let (distance, normal) = body.signed_distance(*x);
            let theta = f64::from(*theta);
            found.fastest = found.fastest.max(v.length());
            if distance < SHELL * d {
                let sector = usize::from(normal.x < 0.5_f64.sqrt())
                    + usize::from(normal.x > -0.5_f64.sqrt() && normal.x < 0.5_f64.sqrt());
                found.sectors[sector] += volume;
            }
            if distance < Air::KERNEL_RADIUS {
                errors += (theta - 1.0).powi(2);
                near += 1.0;
                found.range = [found.range[0].min(theta), found.range[1].max(theta)];
            }
        }
        let shell = self.volume(SHELL * d) - self.volume(0.0);
        found.sectors = [0, 1, 2].map(|k| found.sectors[k] / (shell * self.parts()[k]));
        found.error = (errors / near).sqrt();
        Ok(found)
    }

    /// Air beside the body from one time to another \[s\], on average, its largest speed, and each step's force on the
    /// body \[N\].
    fn run(&self, gpu: &Gpu, [from, to]: [f64; 2], every: u64) -> Result<(Beside, Vec<DVec3>), Error> {
        let mut simulation = self.simulation(gpu)?;
        simulation.step((from / STEP).round() as u64)?;
        let (mut all, mut count, mut forces) = (Beside::default(), 0.0, vec![]);
        let mut before = DVec3::from_array(simulation.body_impulses()?[0]);
        for number in 0..((to - from) / STEP).round() as u64 {
            simulation.step(1)?;
            let impulse = DVec3::from_array(simulation.body_impulses()?[0]);
            forces.push((impulse - before) / STEP);
            before = impulse;
            if number % every == 0 {
                let now = self.beside(&mut simulation)?;
                count += 1.0;
                (0..3).for_each(|k| all.sectors[k] += now.sectors[k]);
                all.error += now.error;
                all.fastest = all.fastest.max(now.fastest);
            }
        }
        all.sectors = all.sectors.map(|sum| sum / count);
        all.error /= count;
        Ok((all, forces))
    }

    /// Force over ½ ρ U² and the body's cross-section.
    fn coefficient(&self, force: f64) -> f64 {
        let radius = self.radius * spacing();
        let area = if self.sphere { PI * radius.powi(2) } else { 2.0 * radius * self.sides[2] * spacing() };
        force / (0.5 * Air::REST_DENSITY * self.wind.powi(2) * area)
    }

    /// Frequency at which the force across the wind is strongest, by 2 R/U: Strouhal's number.
    fn strouhal(&self, forces: &[DVec3]) -> f64 {
        let middle = mean(forces.iter().map(|force| force.y));
        let power = |number: f64| {
            let turn = TAU * number * self.wind / (2.0 * self.radius * spacing()) * STEP;
            let n = forces.len() as f64;
            let sum = forces.iter().enumerate().fold((0.0, 0.0), |(a, b), (k, force)| {
                // Hann's window.
                let part = (force.y - middle) * (0.5 - 0.5 * (TAU * k as f64 / n).cos());
                let phase = turn * k as f64;
                (a + part * phase.cos(), b + part * phase.sin())
            });
            sum.0.hypot(sum.1)
        };
        let numbers = (0..105).map(|k| 0.08 + 0.004 * f64::from(k));
        numbers.max_by(|a, b| power(*a).total_cmp(&power(*b))).unwrap_or_default()
    }

    fn name(&self) -> String {
        let shape = if self.sphere { "sphere" } else { "cylinder" };
        format!("{shape} of {:.1} d in {} m/s, {} substeps", self.radius, self.wind, self.substeps)
    }

    /// Rows of a wind past the body: how even the air is about it, within these bounds.
    fn wind(&self, beside: &Beside, sectors: f64, error: f64, fastest: f64) -> Vec<Row> {
        let name = self.name();
        let mut rows: Vec<Row> = ["behind", "before", "beside"]
            .into_iter()
            .zip(beside.sectors)
            .map(|(place, density)| Row::new(format!("{name}: density {place} it"), 1.0, density, sectors, FULL))
            .collect();
        rows.push(Row::new(format!("{name}: density error at the surface"), 0.0, beside.error, error, EVEN));
        rows.push(
            Row::new(format!("{name}: fastest air"), 0.5 * fastest, beside.fastest, 0.5 * fastest, FASTEST)
                .in_unit("m/s"),
        );
        rows
    }
}

/// Rows of bodies in wind and in still air, small enough for every day.
pub(crate) fn rows(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (substeps, sectors, error) in [(1, 0.1, 0.11), (2, 0.05, 0.04)] {
        let tunnel = Tunnel { substeps, ..THIN };
        let (beside, _) = tunnel.run(gpu, [0.15, 0.3], 9)?;
        rows.extend(tunnel.wind(&beside, sectors, error, 2.5 * WIND));
    }
    rows.push(at_the_start(gpu)?);
    for (substeps, steps, most) in [(1, 4, 1.25), (4, 1, 1.15)] {
        rows.push(set_off(gpu, substeps, steps, most)?);
    }
    rows.push(balanced(gpu)?);
    rows.extend(at_rest(gpu)?);
    rows.extend(moving(gpu, 1.0, 1)?);
    rows.extend(moving(gpu, 3.0, 1)?);
    rows.push(exchanged(gpu)?);
    Ok(rows)
}

/// Rows of larger bodies, with their drag and the wake, and of shorter steps.
pub(crate) fn large(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    // The whole depth, as bodies in a scene have it.
    let deep = Tunnel { sides: [33.0, 25.0, 14.5], ..THIN };
    for (substeps, sectors, error) in [(1, 0.1, 0.11), (2, 0.05, 0.04), (4, 0.05, 0.035)] {
        let tunnel = Tunnel { substeps, ..deep };
        let (beside, _) = tunnel.run(gpu, [0.25, 0.5], 9)?;
        rows.extend(tunnel.wind(&beside, sectors, error, 2.5 * WIND));
    }
    for (radius, substeps) in [(4.0, 1), (4.0, 2), (3.0, 1), (5.0, 1)] {
        let sides = TENTH.sides.map(|side| (side * radius / TENTH.radius).max(6.0));
        let tunnel = Tunnel { sides: [sides[0], sides[1], 6.0], radius, substeps, ..TENTH };
        let (beside, forces) = tunnel.run(gpu, [0.2, 0.6], 16)?;
        rows.extend(tunnel.wind(&beside, 0.05, 0.06, 2.5 * WIND));
        let drag = tunnel.coefficient(mean(forces.iter().map(|force| force.x)));
        rows.push(Row::new(format!("{}: drag coefficient", tunnel.name()), 1.2, drag, 0.2, DRAG));
        rows.push(Row::new(
            format!("{}: Strouhal number", tunnel.name()),
            0.215,
            tunnel.strouhal(&forces),
            0.025,
            SHED,
        ));
    }
    for radius in [4.0, 3.0, 5.0] {
        let tunnel = Tunnel { sides: BALL.sides.map(|side| side * radius / BALL.radius), radius, ..BALL };
        let (beside, _) = tunnel.run(gpu, [0.12, 0.25], 9)?;
        rows.extend(tunnel.wind(&beside, 0.05, 0.06, 2.0 * WIND));
    }
    let early = Tunnel { sides: [36.0, 28.0, 28.0], radius: 6.6, ..BALL };
    let (beside, _) = early.run(gpu, [0.028, 0.055], 1)?;
    let name = format!("{}, 28 to 55 ms after the start: density behind it", early.name());
    rows.push(Row::new(name, 1.0, beside.sectors[0], 0.07, FULL));
    rows.extend(moving(gpu, 10.0, 8)?);
    Ok(rows)
}

/// Row of the speed of air along a sphere before the first step, over that of a flow without a curl.
fn at_the_start(gpu: &Gpu) -> Result<Row, Error> {
    let tunnel = Tunnel { wind: 1.0, ..STOOD };
    let frame = tunnel.simulation(gpu)?.frame()?;
    let center = DVec3::splat(12.0 * spacing());
    let radius = tunnel.radius * spacing();
    // Flux of the periodic box over its wind: Maxwell's.
    let taken = tunnel.volume(0.0) / (24.0 * spacing()).powi(3);
    let flux = flux(&frame, center);
    let (mut along, mut potential) = (0.0, 0.0);
    for (x, v) in vectors(&frame.air.positions).iter().zip(vectors(&frame.air.velocities)) {
        let r = *x - center;
        if r.length() < radius + spacing() {
            let normal = r.normalize();
            let sine = (1.0 - normal.x.powi(2)).sqrt();
            let wanted = flux * sine * (1.0 + 0.5 * (radius / r.length()).powi(3)) / (1.0 - taken);
            along += v.reject_from_normalized(normal).length() * wanted;
            potential += wanted * wanted;
        }
    }
    Ok(Row::new(
        "sphere of 4 d at the start: speed of air along it, over potential flow",
        1.0,
        along / potential,
        0.06,
        POTENTIAL,
    ))
}

/// Mean velocity along x of the air that is far from a center, where the whole box is open \[m/s\].
fn flux(frame: &Frame, center: DVec3) -> f64 {
    let air = vectors(&frame.air.positions).into_iter().zip(vectors(&frame.air.velocities));
    mean(air.filter(|(x, _)| (x.x - center.x).abs() > 10.0 * spacing()).map(|(_, v)| v.x))
}

/// Row of the impulse that a sphere takes to be set off at 1 m/s in one step, over that of its added mass.
fn set_off(gpu: &Gpu, substeps: u32, steps: u64, most: f64) -> Result<Row, Error> {
    let speed = 1.0;
    let tunnel = Tunnel { substeps, motion: Some([STEP, speed]), ..STOOD };
    let mut simulation = tunnel.simulation(gpu)?;
    simulation.step(1 + steps)?;
    let impulse = -simulation.body_impulses()?[0][0];
    let taken = tunnel.volume(0.0) / (24.0 * spacing()).powi(3);
    let added = 0.5 * (1.0 - taken) / (1.0 + 0.5 * taken) * Air::REST_DENSITY * tunnel.volume(0.0);
    let name = format!("sphere of 4 d set off, {substeps} substeps: impulse over that of its added mass");
    Ok(Row::new(name, 0.5 * (1.0 + most), impulse / (added * speed), 0.5 * (most - 1.0), ADDED))
}

/// Row of a pressure that is the same everywhere: the residual of its push within a kernel radius of a sphere, in
/// layers of a quarter of a spacing.
fn balanced(gpu: &Gpu) -> Result<Row, Error> {
    let tunnel = Tunnel { wind: WIND, ..STOOD };
    let mut simulation = tunnel.simulation(gpu)?;
    // Positions as a flow leaves them.
    simulation.step(30)?;
    let mut initial = simulation.initial().clone();
    initial.air.positions = vectors(&simulation.frame()?.air.positions);
    let mut runner = Runner::new(gpu, &tunnel.scene(), &initial)?;
    runner.run(|r, plan| {
        step::forcing::record_bodies(r, plan);
        step::forcing::record_walls(r, plan);
        step::neighbours::record(r, plan);
        r.dispatch_neighbours(&fluid::MOMENTS, "gradients corrected", plan.fluid.flowing_clusters.clone());
    })?;
    let state = runner.engine().state();
    let volume = initial.air.volume as f32;
    let unit = |g: windswept_shaders::common::pressure::Gradients| Stress {
        diagonal: g.diagonal.map(|b| b / volume),
        off_diagonal: g.off_diagonal.map(|b| b / volume),
        pressure: 1.0 / volume,
        ..Stress::default()
    };
    let gradients = runner.engine().read(&state.gradients)?;
    let walls = runner.engine().read(&state.wall)?;
    runner.engine().write(&state.stress, &gradients.into_iter().map(unit).collect::<Vec<_>>())?;
    runner.engine().write(&state.new_velocity, &vec![[0.0; 4]; walls.len()])?;
    runner.replay(|r, plan| {
        r.dispatch_neighbours(&fluid::PUSH, "a constant pressure pushes", plan.fluid.flowing_clusters.clone());
    })?;
    let pushed = runner.read(|s| &s.new_velocity)?;
    let radius = Air::KERNEL_RADIUS;
    let mut layers = [(0.0, 0.0); 7];
    for (wall, v) in walls.iter().zip(&pushed).skip(initial.hair.positions.len()) {
        let layer = (f64::from(wall.distance) / (0.25 * spacing())) as usize;
        if let Some((sum, count)) = layers.get_mut(layer) {
            *sum += v.dot(DVec3::from_array(wall.normal.map(f64::from))) * radius;
            *count += 1.0;
        }
    }
    let left = layers.iter().filter(|(_, count)| *count > 20.0).map(|(sum, count)| (sum / count).abs());
    Ok(Row::new("sphere of 4 d: push of a constant pressure", 0.0, farthest(left, 0.0), 0.15, BALANCED).in_unit("1/h"))
}

/// Rows of still air about a sphere and a mesh.
fn at_rest(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let round = Tunnel { sides: [16.0; 3], radius: 3.0, ..STOOD }.scene();
    let meshed = meshed(&round, [32, 64], 1e-3)?;
    let each = [("sphere", round), ("mesh", meshed)].map(|(name, scene)| {
        let mut simulation = Simulation::new(gpu, &scene)?;
        simulation.step(100)?;
        let fastest = farthest(vectors(&simulation.frame()?.air.velocities).iter().map(|v| v.length()), 0.0);
        Ok(Row::new(format!("still air about a {name}: speed after 100 steps"), 0.0, fastest, 0.0, STILL)
            .in_unit("m/s"))
    });
    each.into_iter().collect()
}

/// Rows of a sphere that moves through still air: the densities beside it from 20 ms on, and the momentum of air and
/// body.
fn moving(gpu: &Gpu, speed: f64, substeps: u32) -> Result<Vec<Row>, Error> {
    let sides = [if speed > 5.0 { 64.0 } else { 40.0 }, 20.0, 20.0];
    let tunnel = Tunnel { sides, center: [8.0 / sides[0], 0.5, 0.5], substeps, motion: Some([0.0, speed]), ..STOOD };
    let mut simulation = tunnel.simulation(gpu)?;
    let mass = simulation.initial().air.mass;
    let start = lasting(&simulation)?.into_iter().sum::<DVec3>();
    let (mut range, mut off, mut sum) = ([f64::INFINITY, 0.0_f64], 0.0_f64, 0.0);
    let mut before = DVec3::ZERO;
    // It stays in the box.
    let steps = ((0.02 + 8.0 * spacing() / speed.max(3.0)) / STEP) as u64;
    for number in 1..=steps {
        simulation.step(1)?;
        let impulse = DVec3::from_array(simulation.body_impulses()?[0]);
        sum += (impulse - before).length();
        before = impulse;
        if simulation.time() > 0.02 && number % 3 == 0 {
            let beside = tunnel.beside(&mut simulation)?;
            range = [range[0].min(beside.range[0]), range[1].max(beside.range[1])];
        }
        if number == steps {
            let gained = mass * (lasting(&simulation)?.into_iter().sum::<DVec3>() - start);
            off = (gained + impulse).length() / sum;
        }
    }
    let name = format!("sphere of 4 d at {speed} m/s, {substeps} substeps");
    Ok(vec![
        Row::new(format!("{name}: least density beside it"), 1.0, range[0], 0.2, EVEN),
        Row::new(format!("{name}: largest density beside it"), 1.0, range[1], 0.12, EVEN),
        Row::new(format!("{name}: momentum of air and sphere"), 0.0, off, 1e-6, KEPT),
    ])
}

/// Row of loose hair in air that a sphere passes: the momentum of hair, air and body.
fn exchanged(gpu: &Gpu) -> Result<Row, Error> {
    let tunnel = Tunnel { center: [0.3, 0.5, 0.5], motion: Some([STEP, 2.0]), friction: 0.1, ..STOOD };
    let hair = Hair::drawn(6, 8, 0.03, Roots::disc([0.07, 0.114, 0.05], 0.012));
    let scene = Scene { hair: vec![Hair { root: End::Free, ..hair }], ..tunnel.scene() };
    let mut simulation = Simulation::new(gpu, &scene)?;
    let (change, _) = momentum::exchanged(&mut simulation, 16)?;
    let impulse = DVec3::from_array(simulation.body_impulses()?[0]);
    let off = (change + impulse).length() / impulse.length();
    Ok(Row::new("loose hair in air that a sphere passes: momentum of all", 0.0, off, 1e-6, KEPT))
}
