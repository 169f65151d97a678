//! A fault of a GPU is an error that names it, or the engine works in another way: a device that is lost, that runs out
//! of memory or allows little.

use windswept::{Error, Gpu, GpuError, Simulation, gpu::wgpu};
use windswept_scene::{Air, Body, FluidSolver, Groom, Hair, InitialState, Model, Roots, Scene, Time, Turbulence};

use crate::support;

fn scene() -> Scene {
    let mut scene = Scene::new(Time::new(1e-3, 1.0));
    scene.hair = vec![Hair::drawn(3, 6, 0.03, Roots::disc([0.05, 0.01, 0.03], 0.01).toward([0.0, 1.0, 0.0]))];
    scene.air = Some(Air::filling([0.12, 0.06, 0.06]).wind([2.0, 0.0, 0.0]));
    scene
}

/// A device with these limits, and the engine's result for it.
fn with_limits(limits: wgpu::Limits) -> (wgpu::Device, Result<Gpu, GpuError>) {
    support::callers_device(&wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() })
}

fn places(simulation: &Simulation) -> Vec<[f32; 3]> {
    let frame = simulation.frame().unwrap();
    [frame.hair.positions, frame.air.positions].concat()
}

/// A device that is destroyed in the middle of a run: whatever the caller does next is an error, nothing panics, and
/// another simulation of the same process goes on.
#[test]
fn a_lost_device_is_an_error() {
    let (device, gpu) = with_limits(wgpu::Limits::default());
    let gpu = gpu.unwrap();
    let mut simulation = Simulation::new(&gpu, &scene()).unwrap();
    let mut other = Simulation::new(&support::gpu(), &scene()).unwrap();
    simulation.step(2).unwrap();
    other.step(2).unwrap();
    device.destroy();
    let name_it = |what: &str, error: String| {
        println!("{what}: {error}");
        assert!(error.contains("lost"), "{what}: {error}");
    };
    name_it("step", simulation.step(1).unwrap_err().to_string());
    name_it("step again", simulation.step(3).unwrap_err().to_string());
    name_it("timed step", simulation.step_timed(1).unwrap_err().to_string());
    name_it("frame", simulation.frame().unwrap_err().to_string());
    name_it("density", simulation.density().unwrap_err().to_string());
    // A write to a lost device is silently left out; the next step says why.
    let _ = simulation.set_wind([1.0, 0.0, 0.0].into());
    name_it("step with a wind", simulation.step(1).unwrap_err().to_string());
    name_it("new", Simulation::new(&gpu, &scene()).err().unwrap().to_string());
    drop(simulation);
    other.step(2).unwrap();
    let mut anew = Simulation::new(&support::gpu(), &scene()).unwrap();
    anew.step(4).unwrap();
    assert_eq!(places(&other), places(&anew));
}

/// A device that is destroyed before it is used.
#[test]
fn a_device_that_was_lost_before_is_an_error() {
    let (device, gpu) = with_limits(wgpu::Limits::default());
    device.destroy();
    let error = Simulation::new(&gpu.unwrap(), &scene()).err().unwrap();
    assert!(error.to_string().contains("lost"), "{error}");
}

/// WebGPU's default limits, and each feature alone or none: without timestamps nothing is timed, without subgroups the
/// passes run in another way, and hair and air are where they are with all features, up to rounding.
#[test]
fn webgpus_defaults_are_enough() {
    let mut full = Simulation::new(&support::gpu(), &scene()).unwrap();
    full.step(20).unwrap();
    let timestamps = wgpu::Features::TIMESTAMP_QUERY
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES
        | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    for features in [wgpu::Features::empty(), wgpu::Features::SUBGROUP, timestamps] {
        // Without what the adapter lacks.
        let required_features = features & support::gpu().device().features();
        let (_, gpu) = support::callers_device(&wgpu::DeviceDescriptor { required_features, ..Default::default() });
        let mut plain = Simulation::new(&gpu.unwrap(), &scene()).unwrap();
        plain.step(20).unwrap();
        let timed = !plain.report().unwrap().passes.is_empty();
        assert_eq!(timed, required_features.contains(timestamps), "with {required_features:?}");
        let pairs = places(&plain).into_iter().zip(places(&full));
        let apart = pairs.flat_map(|(a, b)| [0, 1, 2].map(|k| (a[k] - b[k]).abs()));
        // A particle that goes through a face of the box in one of them would be 0.06 m off.
        let apart: Vec<f32> = apart.filter(|gap| *gap < 0.03).collect();
        let farthest = apart.iter().copied().fold(0.0, f32::max);
        println!("farthest apart with {required_features:?}: {farthest:.2e} m");
        assert!(apart.len() > 3 * 1000 && farthest < 1e-4, "{farthest} m apart with {required_features:?}");
    }
}

/// A device below WebGPU's default limits is refused, with the limit, what it is and what is needed.
#[test]
fn limits_below_the_defaults_are_named() {
    let defaults = wgpu::Limits::default;
    let cases = [
        (
            "max_storage_buffers_per_shader_stage",
            wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..defaults() },
            (4, 8),
        ),
        (
            "max_compute_invocations_per_workgroup",
            wgpu::Limits { max_compute_invocations_per_workgroup: 32, ..defaults() },
            (32, 256),
        ),
        ("max_compute_workgroup_size_x", wgpu::Limits { max_compute_workgroup_size_x: 32, ..defaults() }, (32, 256)),
        (
            "max_compute_workgroups_per_dimension",
            wgpu::Limits { max_compute_workgroups_per_dimension: 255, ..defaults() },
            (255, 65_535),
        ),
    ];
    for (name, limits, (found, wanted)) in cases {
        let (_, gpu) = with_limits(limits);
        match gpu.unwrap_err() {
            GpuError::Limit { limit, has, needs } => assert_eq!((limit, has, needs), (name, found, wanted)),
            other => panic!("{name}: {other}"),
        }
    }
}

/// Bindings too small for the scene are refused before anything is allocated, with the array and what would fit. Where
/// a binding holds every array but a neighbour list of the usual length, the list is as long as fits.
#[test]
fn small_bindings_are_named() {
    let with_binding = |bytes: u64| {
        let limits = wgpu::Limits { max_storage_buffer_binding_size: bytes, ..wgpu::Limits::default() };
        Simulation::new(&with_limits(limits).1.unwrap(), &scene())
    };
    let error = with_binding(16 << 10).err().unwrap();
    assert!(matches!(error, Error::Gpu(GpuError::TooLarge { limit: 16_384, .. })), "{error}");
    assert!(error.to_string().contains("expected a larger air.spacing"), "{error}");
    let mut enough = with_binding(256 << 10).unwrap();
    enough.step(2).unwrap();
}

/// A simulation that is too large by the counts of the scene or the groom is refused before the initial state is made,
/// which here cannot be made. The error is that of an initial state that was made.
#[test]
fn what_cannot_fit_is_refused_before_it_is_made() {
    let limits = wgpu::Limits { max_storage_buffer_binding_size: 16 << 10, ..wgpu::Limits::default() };
    let gpu = with_limits(limits).1.unwrap();
    let quick = Scene::parse(include_str!("../examples/scenes/quick.toml")).unwrap();
    let (mut no_air, no_bands) = (quick.clone(), Scene { turbulence: Turbulence::default(), ..quick });
    no_air.interaction.model = Some(Model::Drag);
    let mut pbf = no_bands.clone();
    pbf.fluid.solver = Some(FluidSolver::Pbf);
    // All strands would be rooted deep inside a body.
    let deep = Scene { bodies: vec![Body::sphere([0.056, 0.065, 0.035], 0.05)], ..no_air.clone() };
    for (whole, unmade) in [(&no_air, Some(deep)), (&pbf, None), (&no_bands, None)] {
        let said = |scene: &Scene| Simulation::new(&gpu, scene).err().unwrap().to_string();
        let made = InitialState::new(whole).unwrap();
        let of_state = Simulation::with_state(&gpu, whole, made).err().unwrap().to_string();
        assert_eq!(said(whole), of_state);
        if let Some(unmade) = unmade {
            assert!(InitialState::new(&unmade).unwrap_err().to_string().contains("is rooted"));
            assert_eq!(said(&unmade), of_state);
        }
    }
    // Strands that are twice in one place cannot be made.
    let groom = Groom::new(vec![[0.0; 3]; 2000], (0..=200).map(|s| 10 * s).collect());
    let error = Simulation::with_groom(&gpu, &no_air, &groom).err().unwrap();
    assert!(matches!(error, Error::Gpu(GpuError::TooLarge { limit: 16_384, .. })), "{error}");
}

/// A device that has no memory left: the allocation that fails is named, with its bytes, and the device can be used on.
#[test]
fn allocations_that_fail_are_named() {
    let (_, gpu) = with_limits(wgpu::Limits::default());
    let gpu = gpu.unwrap();
    let huge = wgpu::BufferDescriptor {
        label: Some("too much"),
        size: wgpu::Limits::default().max_buffer_size + 4,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    };
    let error = gpu.checked(|| "allocating too much".to_owned(), || gpu.device().create_buffer(&huge)).unwrap_err();
    assert!(error.to_string().starts_with("allocating too much: "), "{error}");
    Simulation::new(&gpu, &scene()).unwrap().step(1).unwrap();
}
