//! Hair alone, of every kind of end, which tests move about.

use glam::{DQuat, DVec3, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use windswept_reference::State as Reference;
use windswept_scene::{End, Ends, Fibre, Hair, InitialState, Integrator, Rods, Roots, Scene, Solver, Strands};
use windswept_shaders::common::rod::Root;

use crate::{fixture::Fixture, support::alone};

/// Scene of `n` strands alone, of 2 to 40 points, some curled, in random places; of 2 points where they are many.
pub fn scene_of(n: usize, solved: &Rods) -> Scene {
    scene_with(n, solved, if n > 1000 { [2; 4] } else { [2, 11, 40, 7] })
}

/// Scene of `n` strands alone, of so many points in four groups; those of the second curled if they have more than 2.
pub fn scene_with(n: usize, solved: &Rods, points: [u32; 4]) -> Scene {
    let group = |(group, points): (usize, u32)| {
        let roots = Roots::disc([0.0, 0.1, group as f64], 0.05).toward([1.0, 0.3, 0.2]);
        let hair = Hair::drawn(((n + 3 - group) / 4) as u32, points, 0.1, roots).named(format!("g{group}"));
        match group {
            1 if points > 2 => hair.curled(0.003, 0.02),
            3 if points > 2 => Hair { fibre: Fibre { taper: 0.5, ..Fibre::default() }, ..hair },
            _ => hair,
        }
    };
    // There may be fewer strands than groups.
    let groups: Vec<Hair> = points.into_iter().enumerate().take(n).map(group).collect();
    Scene { rods: Rods { damping: 2.0, ..solved.clone() }, ..alone(1.38e-3, groups) }
}

/// Scene of [`scene_of`], and the state that it starts from.
pub fn strands(n: usize, solved: &Rods) -> (Scene, InitialState) {
    let scene = scene_of(n, solved);
    let initial = InitialState::new(&scene).unwrap();
    (scene, initial)
}

/// Rods that never sleep.
pub fn awake() -> Rods {
    Rods { sleep: false, ..Rods::default() }
}

/// Rods of at most so many Newton steps.
pub fn newton(newton: u32) -> Rods {
    Rods { newton, ..Rods::default() }
}

/// Rods by implicit Euler.
pub fn euler() -> Rods {
    Rods { integrator: Some(Integrator::Euler), ..Rods::default() }
}

/// Rods by Gauss-Seidel.
pub fn gauss_seidel() -> Rods {
    Rods { solver: Some(Solver::GaussSeidel), ..Rods::default() }
}

/// Gives strands every kind of end: clamped, pinned and free roots, and tips, in turn.
pub fn ends(hair: &mut Strands, tips: bool) {
    let kinds = [End::Clamped, End::Pinned, End::Free];
    for s in 0..hair.len() {
        hold(hair, s, kinds[s % 3], if tips { kinds[(s / 3) % 3] } else { End::Free });
    }
}

/// Gives the next strand its ends.
pub fn hold(hair: &mut Strands, s: usize, root: End, tip: End) {
    let (points, segments) = (hair.points(s), hair.segments(s));
    if root == End::Free {
        hair.inverse_mass[points.start] = 2.0 * hair.inverse_mass[points.end - 1].max(1e6);
    }
    if tip != End::Free {
        hair.inverse_mass[points.end - 1] = 0.0;
    }
    let tip_rest_rotation = DQuat::from_scaled_axis(DVec3::new(0.02, 0.05, -0.03));
    hair.ends.push(Ends {
        root,
        tip,
        tip_frame: hair.orientations[segments.end - 1] * tip_rest_rotation,
        tip_rest_rotation,
        tip_compliance: 0.5 * hair.bend_compliance[segments.end - 1],
    });
}

/// Gives all points and segments speeds and spins, rounded to f32.
pub fn motion(hair: &mut Strands, speed: f64, spin: f64, seed: u64) {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut any = |size: f64| (size * (2.0 * DVec3::from_array(rng.random()) - 1.0)).as_vec3().as_dvec3();
    for (v, w) in hair.velocities.iter_mut().zip(&hair.inverse_mass) {
        *v = if *w > 0.0 { any(speed) } else { DVec3::ZERO };
    }
    hair.angular_velocities.iter_mut().for_each(|w| *w = any(spin));
}

/// Vector of up to `size` on each axis, rounded to f32.
pub fn any(rng: &mut Pcg64, size: f64) -> DVec3 {
    (size * (2.0 * DVec3::from_array(rng.random()) - 1.0)).as_vec3().as_dvec3()
}

/// Sets where clamps go, on engine and reference; rounded to f32.
pub fn set_roots(fixture: &Fixture, s: &mut Reference, target: impl Fn(usize, DVec3, DQuat) -> (DVec3, DQuat)) {
    let targets = s.clamps.iter().enumerate().map(|(strand, (x, q))| {
        let (x, q) = target(strand, *x, *q);
        (x.as_vec3(), q.as_quat())
    });
    let targets: Vec<_> = targets.collect();
    let root = |(x, q): &(Vec3, Quat)| Root { position: x.to_array(), frame: q.to_array(), ..Root::default() };
    let rows: Vec<Root> = targets.iter().map(root).collect();
    fixture.engine.write(&fixture.engine.state().root_targets, &rows).unwrap();
    s.root_targets = targets.iter().map(|(x, q)| (x.as_dvec3(), q.as_dquat())).collect();
}
