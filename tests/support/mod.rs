//! Code that the tests share: the software adapter, scenes made in code, particles in awkward numbers.
#![allow(dead_code, unused_imports, unreachable_pub, clippy::unwrap_used, missing_docs)]

pub mod fault;

use std::sync::{Mutex, MutexGuard, PoisonError};

use glam::{DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept::{AdapterChoice, Gpu, GpuError, gpu::wgpu};
use windswept_scene::*;
use windswept_validate::internals::Cloud;
pub use windswept_validate::internals::{MASS, RADIUS, VOLUME, alone, in_wind};

/// A device on the adapter that every test runs on: the one that WGPU_ADAPTER_NAME names, else a software one. A test
/// fails where there is no such adapter.
///
/// A device does one thing at a time. Tests that run side by side have one each, and hand it on to those that come
/// after them.
pub fn gpu() -> Gpu {
    thread_local! {
        // Each test has a thread of its own.
        static OWN: Lent = Lent(free().pop().unwrap_or_else(open));
    }
    OWN.with(|own| own.0.clone())
}

/// The devices that no test has.
fn free() -> MutexGuard<'static, Vec<Gpu>> {
    static FREE: Mutex<Vec<Gpu>> = Mutex::new(Vec::new());
    FREE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A device until the thread ends that has it.
struct Lent(Gpu);

impl Drop for Lent {
    fn drop(&mut self) {
        free().push(self.0.clone());
    }
}

fn open() -> Gpu {
    let asked = std::env::var("WGPU_ADAPTER_NAME").ok();
    let choice = asked.as_ref().map_or(AdapterChoice::Software, |_| AdapterChoice::from_flag(None));
    let gpu = Gpu::new(&choice).unwrap_or_else(|error| panic!("tests need an adapter: {error}"));
    println!("adapter: {}", gpu.info());
    match asked {
        Some(name) if name != "software" => assert!(
            gpu.info().name.to_lowercase().contains(&name.to_lowercase()),
            "asked for {name}, got {}",
            gpu.info()
        ),
        _ => assert_eq!(gpu.info().kind, "software"),
    }
    gpu
}

/// A device that an application would own, on the adapter of the tests, and what the engine says of it.
pub fn callers_device(asked: &wgpu::DeviceDescriptor<'_>) -> (wgpu::Device, Result<Gpu, GpuError>) {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    let instance = wgpu::Instance::new(descriptor);
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
    let adapter = adapters.into_iter().find(|adapter| adapter.get_info().name == gpu().info().name).unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(asked)).unwrap();
    (device.clone(), Gpu::from_device(&adapter, device, queue))
}

/// Scene with the paper's parameters, without hair, in still air; hair that a test puts in is one fluid with the air.
/// The box of the air is that of the particles which a test puts in, whatever box the scene has.
pub fn scene() -> Scene {
    let mut scene = Scene::new(Time::new(1.38e-3, 1.0));
    scene.interaction.model = Some(Model::Particles);
    scene.fluid.solver = Some(FluidSolver::Pbf);
    scene.air = Some(Air::filling([0.1; 3]).wind([0.0; 3]));
    scene.turbulence.filter = Some(Filter::Direct(DirectFilter::default()));
    let (solver, integrator) = (Some(Solver::GaussSeidel), Some(Integrator::Euler));
    scene.rods = Rods { solver, integrator, sleep: false, ..Rods::default() };
    scene
}

/// The solid of a shape as so many rows and sides of triangles, in a grid of this spacing \[m\].
pub fn solid(shape: &Shape, rows: u32, sides: u32, resolution: f64) -> Solid {
    let body = Body { shape: shape.clone(), ..Body::sphere([0.0; 3], 1.0) };
    let checked = Scene { bodies: vec![body], ..scene() }.check().unwrap();
    Solid::enclosed(checked.bodies[0].shape.surface(rows, sides), Some(resolution)).unwrap()
}

/// The scene with its only body as so many rows and sides of triangles, in a grid of this spacing \[m\].
pub fn meshed(scene: &Scene, rows: u32, sides: u32, resolution: f64) -> Scene {
    let mut scene = scene.clone();
    scene.bodies[0].shape = solid(&scene.bodies[0].shape, rows, sides, resolution).into();
    scene
}

/// Hair for tests of particles, in strands of `points_per_strand`, at the positions that the caller gives; rest lengths
/// are those of the positions.
pub fn strands(positions: &[DVec3], points_per_strand: usize) -> Strands {
    let mut hair = Strands { point_offsets: vec![0], ..Strands::default() };
    for points in positions.chunks(points_per_strand).filter(|points| points.len() >= 2) {
        for (k, x) in points.iter().enumerate() {
            hair.positions.push(*x);
            hair.velocities.push(DVec3::ZERO);
            // Masses and volumes differ from air's and from one another.
            hair.inverse_mass.push(if k == 0 { 0.0 } else { 1.0 / (MASS * (1 + k % 4) as f64) });
            hair.volume.push(VOLUME / (1 + k % 3) as f64);
        }
        for pair in points.windows(2) {
            let gap = pair[1] - pair[0];
            let l = gap.length().max(1e-6);
            hair.orientations.push(DQuat::from_rotation_arc(DVec3::Z, (gap / l).normalize()));
            hair.angular_velocities.push(DVec3::ZERO);
            hair.rest_length.push(l);
            hair.radius.push(4e-5);
            hair.fibres.push(1.0 + (hair.radius.len() % 2) as f64);
            hair.inverse_inertia.push(1.0 / (0.5 * MASS * l * l));
            hair.stretch_compliance.push(DVec3::new(1.0 / (7.3 * l), 1.0 / (7.3 * l), 1.0 / (20.1 * l)));
            hair.bend_compliance.push(DVec3::new(l / (4.0 * 8.04e-9), l / (4.0 * 8.04e-9), l / (4.0 * 5.8e-9)));
        }
        for k in 0..points.len() - 1 {
            let own = hair.orientations.len() - (points.len() - 1) + k;
            let before = if k == 0 { hair.orientations[own] } else { hair.orientations[own - 1] };
            hair.rest_rotation.push(before.conjugate() * hair.orientations[own]);
        }
        hair.root_frame.push(hair.orientations[hair.orientations.len() - (points.len() - 1)]);
        hair.group.push(0);
        hair.point_offsets.push(hair.positions.len() as u32);
    }
    hair
}

/// Layouts of particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Layout {
    /// Particles anywhere in the box.
    Random,
    /// Particles in a few tight clumps.
    Clustered,
    /// Particles on a simple cubic lattice.
    Lattice,
    /// Particles that are all within one cell.
    OneCell,
}

/// State of `n` particles, `hair` of them hair points (rounded down to strands of 3), in a box that holds them at rest
/// density, but at least 4 kernel radii wide. Some hair stands outside the box.
pub fn particles(n: usize, hair: usize, layout: Layout, seed: u64) -> InitialState {
    let mut rng = Pcg64::seed_from_u64(seed);
    let side = (n as f64 * VOLUME).cbrt().max(4.0 * RADIUS);
    let count = (n as f64).cbrt().ceil() as usize;
    let centres: Vec<DVec3> = (0..20).map(|_| DVec3::from_array(rng.random()) * side).collect();
    let mut place = |i: usize| match layout {
        Layout::Random => DVec3::from_array(rng.random()) * side,
        Layout::Clustered => {
            let jitter = DVec3::from_array(rng.random()) - 0.5;
            (centres[i % centres.len()] + 2.0 * RADIUS * jitter).rem_euclid(DVec3::splat(side))
        }
        Layout::Lattice => {
            let cell = DVec3::new((i % count) as f64, (i / count % count) as f64, (i / count / count) as f64);
            (cell + 0.5) * side / count as f64
        }
        Layout::OneCell => DVec3::splat(0.1 * RADIUS) + 0.5 * RADIUS * DVec3::from_array(rng.random()),
    };
    let mut all: Vec<DVec3> = (0..n).map(&mut place).collect();
    let hair_points = if hair < 2 { 0 } else { hair - usize::from(hair % 3 == 1) };
    let mut hair = all[..hair_points].to_vec();
    for (i, x) in hair.iter_mut().enumerate() {
        // Every fifth hair point stands outside the box, near it or far from it.
        if i % 5 == 0 {
            *x += DVec3::new(side, 0.0, -0.3 * side) * (1 + i % 3) as f64;
        }
    }
    let air = all.split_off(hair_points);
    InitialState {
        followers: None,
        origin: DVec3::ZERO,
        hair: strands(&hair, 3),
        air: AirParticles {
            min: DVec3::ZERO,
            size: DVec3::splat(side),
            velocities: vec![DVec3::ZERO; air.len()],
            positions: air,
            volume: VOLUME,
            mass: MASS,
        },
        pins: Vec::new(),
        warnings: Vec::new(),
    }
}

/// The awkward sizes: one, a workgroup less one, a workgroup, one more, and many: with a third of it hair, more than 64
/// workgroups of air, so that sums over workgroups take more than one turn.
pub const SIZES: [usize; 5] = [1, 63, 64, 65, 6_701];

/// Air alone in a periodic box.
pub fn air(size: DVec3, positions: Vec<DVec3>) -> InitialState {
    let velocities = vec![DVec3::ZERO; positions.len()];
    InitialState {
        air: AirParticles { min: DVec3::ZERO, size, positions, velocities, volume: VOLUME, mass: MASS },
        ..InitialState::default()
    }
}

/// Lattice of `cells` copies of a cubic unit cell that holds `basis` (fractions), at one particle per `VOLUME`.
pub fn lattice(cells: [usize; 3], basis: &[[f64; 3]]) -> InitialState {
    Cloud::lattice(cells, basis).initial()
}

/// How often a warning of this code acted in a run.
pub fn warned(warnings: &[Warning], code: &str) -> u64 {
    warnings.iter().filter(|warning| warning.code == code).map(|warning| warning.count).sum()
}
