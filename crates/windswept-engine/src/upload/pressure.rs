//! Constants of solver `divergence`: relaxations of the pressure's iterations (`shaders/fluid/divergence.wgsl`), and
//! how air is spread (`shaders/fluid/spread.wgsl`; `docs/decisions/air.md`).

use windswept_scene::{CheckedScene, Model};
use windswept_shaders::fluid::divergence::Iteration;

/// Share of its unevenness that still air takes out in a second: all of it in 1.38 ms.
const SETTLING_RATE: f64 = 725.0;

/// Largest eigenvalue of an iteration with a relaxation of 1, with a margin: 3.5 to 4.3 were measured, on lattices and
/// in flow.
const LARGEST_EIGENVALUE: f64 = 4.5;

/// Share f of the way of air in a substep by which its particles are spread: the coarse grid bears more.
pub(crate) fn spreading(scene: &CheckedScene) -> f64 {
    if scene.has_coarse_grid() { 0.1 } else { 0.05 }
}

/// Share of its unevenness that still air takes out in a substep; 0 with the model `particles`, where hair takes the
/// place of air.
pub(crate) fn settling(scene: &CheckedScene) -> f64 {
    match scene.interaction.model {
        Model::Particles => 0.0,
        _ => (SETTLING_RATE * scene.time.step / f64::from(scene.time.substeps)).min(1.0),
    }
}

/// The uniforms of `count` iterations, after one that only finds the divergence.
pub(crate) fn iterations(count: u32) -> Vec<Iteration> {
    let all = std::iter::once(0.0).chain(relaxations(count));
    all.map(|relaxation| Iteration { relaxation: relaxation as f32 }).collect()
}

/// Relaxations ω of so many iterations.
///
/// The pressures of the step before are kept, and an iteration that took out more of a divergence than there is would
/// let them swing up: under BDF2 from 16/13 of it on. So the part that is left, Π(1 − ω_k μ), must lie between 0 and 1
/// for every eigenvalue μ up to the largest. Its roots are double, in the middle of the upper three quarters of the
/// spectrum, so that an iteration by itself makes nothing larger up to 5.6 either: where hair is crowded, eigenvalues
/// may be larger than those of air. Odd counts have one more, simple root at the largest eigenvalue, and the others
/// below 0.8 of it.
fn relaxations(count: u32) -> Vec<f64> {
    let odd = count % 2 == 1;
    let (low, high) = (LARGEST_EIGENVALUE / 4.0, if odd { 0.8 } else { 1.0 } * LARGEST_EIGENVALUE);
    let single = odd.then_some(1.0 / LARGEST_EIGENVALUE);
    let pairs = count - count % 2;
    single.into_iter().chain((0..pairs).map(|_| 2.0 / (low + high))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rest of a divergence is never negative, and never more than there was.
    #[test]
    fn no_iteration_overshoots() {
        for count in 1..=4 {
            let all = relaxations(count);
            assert_eq!(all.len(), count as usize);
            for k in 0..=1000 {
                let eigenvalue = LARGEST_EIGENVALUE * f64::from(k) / 1000.0;
                let left: f64 = all.iter().map(|omega| 1.0 - omega * eigenvalue).product();
                assert!((-1e-12..=1.0).contains(&left), "{count} iterations leave {left} of {eigenvalue}");
                assert!(all.iter().all(|omega| (1.0 - omega * eigenvalue).abs() <= 1.0), "of {eigenvalue}: {all:?}");
            }
        }
    }

    /// Relaxations as the scheme was measured with.
    #[test]
    fn relaxations_are_those_that_were_measured() {
        let expected: [&[f64]; 4] = [&[0.2222], &[0.3556, 0.3556], &[0.2222, 0.4233, 0.4233], &[0.3556; 4]];
        for (count, expected) in (1..).zip(expected) {
            let found = relaxations(count);
            println!("{count}: {found:?}");
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{count}: {found:?}");
        }
    }
}
