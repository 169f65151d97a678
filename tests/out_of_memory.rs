//! A machine that has no memory left for the GPU. A program of its own, as the limit is that of the process.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

mod support;

use std::{fs, process::Command};

use windswept::{AdapterChoice, Gpu, Simulation, gpu::wgpu};
use windswept_scene::{Air, InitialState, Scene, Time};

/// Air of so many particles.
fn air(particles: f64) -> Scene {
    let volume = 0.1_f64.powi(3) / particles;
    let (spacing, kernel_radius) = (volume.cbrt(), Some(2.0 * volume.cbrt()));
    let air = Air::filling([0.1; 3]).wind([2.0, 0.0, 0.0]);
    let mut scene = Scene::new(Time::new(1e-3, 1.0));
    scene.air = Some(Air { spacing, kernel_radius, jitter: Some(0.0), ..air });
    scene
}

/// Sets the most address space that this process may have, `spare` more than it has; none for no limit.
fn limit(spare: Option<u64>) {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmSize:")).unwrap();
    let now = 1024 * line.split_whitespace().next().unwrap().parse::<u64>().unwrap();
    let most = spare.map_or("unlimited".to_owned(), |spare| (now + spare).to_string());
    let mut prlimit = Command::new("prlimit");
    prlimit.args(["--pid", &std::process::id().to_string(), &format!("--as={most}:unlimited")]);
    assert!(prlimit.status().unwrap().success());
}

/// A buffer that does not fit into the memory that is left is an error that says what it was for. The device goes on,
/// and takes another simulation. A simulation that does not fit is an error that says for which array; where the driver
/// gives its device up for that, the process opens another one.
#[test]
fn memory_that_runs_out_is_an_error() {
    let gpu = support::gpu();
    let mut small = Simulation::new(&gpu, &air(2e3)).unwrap();
    small.step(2).unwrap();
    let buffer = wgpu::BufferDescriptor {
        label: Some("too much"),
        size: 1 << 30,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    };
    limit(Some(500 << 20));
    let refused = gpu.checked(|| "making room".to_owned(), || gpu.device().create_buffer(&buffer)).err();
    limit(None);
    let said = refused.unwrap().to_string();
    assert!(said.starts_with("making room: ") && said.to_lowercase().contains("memory"), "{said}");
    small.step(2).unwrap();
    let places = |simulation: &Simulation| simulation.frame().unwrap().air.positions;
    let fresh = |gpu: &Gpu| {
        let mut fresh = Simulation::new(gpu, &air(2e3)).unwrap();
        fresh.step(4).unwrap();
        places(&fresh)
    };
    let before = fresh(&gpu);
    assert_eq!(places(&small), before);

    let large = air(1e6);
    let initial = InitialState::new(&large).unwrap();
    // The arrays that are made of the state take 0.3 GB, those on the device another 0.7.
    limit(Some(450 << 20));
    let failed = Simulation::with_state(&gpu, &large, initial).err();
    limit(None);
    let said = failed.unwrap().to_string();
    println!("{said}");
    let words = ["allocating ", "the device was lost: writing ", "the device was lost: allocating "];
    assert!(words.iter().any(|words| said.starts_with(words)), "{said}");
    let anew = Gpu::new(&AdapterChoice::Named(gpu.info().name.clone())).unwrap();
    assert_eq!(fresh(&anew), before);
}
