//! Hair and air about bodies: Coulomb's law, nothing inside, no tunnels, a wake.

use glam::DVec3;
use windswept::{Frame, Simulation};
use windswept_scene::{
    Air, Body, CheckedShape, End, FluidSolver, Groom, Hair, InitialState, Keyframe, Model, Rods, Roots, Scene, Solid,
    Solver, Time, Triangles,
};

use crate::support;

fn simulation(scene: &Scene) -> Simulation {
    Simulation::new(&support::gpu(), scene).unwrap()
}

/// A body in its place, shifted by so much along x until one time \[s\] and from another one on \[m\].
fn shifted(body: Body, from: (f64, f64), to: (f64, f64)) -> Body {
    let at = |(time, x)| Keyframe { translation: [x, 0.0, 0.0], ..Keyframe::new(time) };
    Body { motion: [at(from), at(to)].into(), ..body }
}

/// Surface of a block, by its middle and half of its sides \[m\].
fn block(middle: DVec3, half: DVec3) -> Triangles {
    let corner =
        |i: usize| middle + half * DVec3::from_array([1, 2, 4].map(|bit| if i & bit == 0 { -1.0 } else { 1.0 }));
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Triangles {
        points: (0..8).map(corner).collect(),
        corners: squares.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Triangles::default()
    }
}

fn points(of: &[[f32; 3]]) -> Vec<DVec3> {
    of.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect()
}

/// Depth of the deepest of these points below the surface of any body now \[m\]; negative if all are outside.
fn deepest(simulation: &Simulation, of: &[[f32; 3]]) -> f64 {
    let placed: Vec<CheckedShape> = simulation.scene().bodies.iter().map(|body| body.at(simulation.time())).collect();
    let depth = |x: &DVec3| placed.iter().map(|body| -body.signed_distance(*x).0).fold(f64::NEG_INFINITY, f64::max);
    points(of).iter().map(depth).fold(f64::NEG_INFINITY, f64::max)
}

/// A loose strand on a sloping bar sticks below tan(slope) = friction, and above slides with g (sin − μ cos).
#[test]
fn hair_sticks_and_slides_by_coulombs_law() {
    const FRICTION: f64 = 0.3;
    const STEPS: u64 = 200;
    for slope in [0.1_f64, 0.29, 0.31, 0.6] {
        let angle = slope.atan();
        let bar = Body::capsule([-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], 0.05);
        let mut scene = Scene { bodies: vec![Body { friction: FRICTION, ..bar }], ..support::scene() };
        scene.interaction.model = Some(Model::None);
        scene.rods.solver = Some(Solver::Direct);
        scene.gravity = [9.81 * angle.sin(), -9.81 * angle.cos(), 0.0];
        let along: Vec<DVec3> = (0..4).map(|k| DVec3::new(0.01 * f64::from(k), 0.05, 0.0)).collect();
        let mut hair = support::strands(&along, 4);
        hair.inverse_mass[0] = hair.inverse_mass[1];
        let initial = InitialState { hair, ..InitialState::default() };
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        simulation.step(STEPS).unwrap();
        let end = points(&simulation.frame().unwrap().hair.positions);
        let went: Vec<f64> = end.iter().zip(&along).map(|(b, a)| b.x - a.x).collect();
        let pull = 9.81 * (angle.sin() - FRICTION * angle.cos()).max(0.0);
        // Implicit Euler: n (n + 1)/2 dt² a.
        let wanted = 0.5 * (STEPS * (STEPS + 1)) as f64 * scene.time.step.powi(2) * pull;
        println!("slope {slope}: slid {:.6} m, Coulomb's {wanted:.6} m", went[1]);
        for slid in went {
            // Measured 7.5e-6 m in 0.28 s, 2e-5 of a free fall, and 0.3 %: velocities are differences of f32; margins 4
            // and 2.
            assert!((slid - wanted).abs() < 3e-5 + 6e-3 * wanted, "slope {slope}: {slid}, not {wanted}");
        }
        assert!(end.iter().all(|x| (x.y - 0.05).abs() < 1e-6 && x.z.abs() < 1e-6), "it leaves the bar: {end:?}");
    }
}

/// A strand with 5 mm between points, clamped above a ball, that falls over it.
fn draped(step: f64, damping: f64) -> Scene {
    let hair = Hair::drawn(1, 41, 0.2, Roots::disc([0.0, 0.051, 0.0], 1e-3).toward([1.0, 0.0, 0.0]));
    let mut scene = support::alone(step, [hair]);
    scene.bodies = vec![Body::sphere([0.0; 3], 0.05)];
    scene.rods.damping = damping;
    scene
}

/// A strand that falls on a floor, or over the edge of a box, lies on it.
#[test]
fn a_strand_lies_on_a_floor_and_on_a_box() {
    let mut scene = draped(1.38e-3, 2.0);
    for (body, least) in [(Body::plane([0.0; 3], [0.1, 1.0, 0.0]), 6), (Body::cuboid([0.0; 3], [0.1, 0.09, 0.1]), 1)] {
        scene.bodies = vec![body];
        let mut simulation = simulation(&scene);
        let mut worst = f64::NEG_INFINITY;
        for _ in 0..40 {
            simulation.step(20).unwrap();
            worst = worst.max(deepest(&simulation, &simulation.frame().unwrap().hair.positions));
        }
        let end = points(&simulation.frame().unwrap().hair.positions);
        let shape = simulation.scene().bodies[0].at(0.0);
        let lying = end.iter().filter(|x| shape.signed_distance(**x).0 < 2e-4).count();
        println!("{worst:.1e} m inside, {lying} points lie on it");
        // Measured 7e-7 m, while it falls, and 1.1e-5 m at the edge; margin 4.
        assert!(worst < 5e-5 && lying >= least, "{worst} m inside, {lying} lie on it");
    }
}

/// A strand that falls over a ball lies on it and never enters it, however rough the ball.
#[test]
fn a_strand_drapes_over_a_ball() {
    let mut scene = draped(1.38e-3, 2.0);
    for friction in [0.0, 0.5, 2.0] {
        scene.bodies[0].friction = friction;
        let mut simulation = simulation(&scene);
        let mut worst = f64::NEG_INFINITY;
        for _ in 0..40 {
            simulation.step(20).unwrap();
            worst = worst.max(deepest(&simulation, &simulation.frame().unwrap().hair.positions));
        }
        let frame = simulation.frame().unwrap();
        let lying = points(&frame.hair.positions).iter().filter(|x| x.length() < 0.0502).count();
        let tip = points(&frame.hair.positions)[40];
        let speed = points(&frame.hair.velocities).iter().map(|v| v.length()).fold(0.0, f64::max);
        println!(
            "friction {friction}: {worst:.1e} m inside, {lying} points lie on it, tip at {tip:.3}, {speed:.3} m/s"
        );

        // Measured 2.4e-9 m: rounding; margin 4.
        assert!(worst < 1e-8, "{worst} m inside");
        assert!(lying > 3 && tip.y < -0.05, "it does not drape: {lying} points, tip {tip}");
        assert!(speed < 0.5, "no rest: {speed} m/s");
    }
}

/// A bar of 20 mm comes at 2 m/s, or so late that the strand sleeps, and takes the strand along: no segment ever lies
/// across.
#[test]
fn a_bar_takes_hair_along() {
    let mut scene = support::alone(1.38e-3, [Hair::drawn(1, 51, 0.1, Roots::disc([0.0, 0.1, 0.0], 1e-3))]);
    scene.rods.damping = 20.0;
    let bar = Body::capsule([0.0, 0.05, -0.05], [0.0, 0.05, 0.05], 0.01);
    for (late, sleeping) in [(0.07, false), (0.28, true)] {
        scene.bodies = vec![shifted(bar.clone(), (0.0, -0.11), (late, 0.03))];
        let mut simulation = simulation(&scene);
        let (mut deepest, mut taken, mut stretch) = (0.0_f64, 0.0_f64, 0.0_f64);
        for _ in 0..250 {
            simulation.step(1).unwrap();
            let bar = simulation.scene().bodies[0].at(simulation.time());
            let x = points(&simulation.frame().unwrap().hair.positions);
            let eighths = |w: &[DVec3]| [0, 1, 2, 3, 4, 5, 6, 7].map(|k| w[0].lerp(w[1], 0.125 * f64::from(k)));
            deepest = x.windows(2).flat_map(eighths).map(|x| -bar.signed_distance(x).0).fold(deepest, f64::max);
            taken = x.iter().map(|x| x.x).fold(taken, f64::max);
            stretch = x.windows(2).map(|w| (w[0].distance(w[1]) / 0.002 - 1.0).abs()).fold(stretch, f64::max);
        }
        let report = simulation.report().unwrap();
        let slept = report.strand_steps.unwrap()["sleeping_steps"] > 0;
        println!("stretch {stretch:.3}, reported {:.3}", report.max_stretch.unwrap());
        // Segments of 2 mm, pushed by 2.8 mm in a step: measured 1.8e-5; margin 4.
        assert!(stretch < 7e-5 && report.max_stretch.unwrap() < 7e-5, "stretched by {stretch}");
        println!("late {late} s: segments at most {deepest:.1e} m inside; hair is taken {taken:.3} m along");
        // A chord of 2 mm lies 5e-5 m below the surface; measured 5.1e-5 m; margin 8.
        assert!(deepest < 4e-4, "{deepest} m inside");
        assert!(taken > 0.045, "{taken}");
        assert_eq!(slept, sleeping);
    }
}

/// Hair that lies on a ball falls asleep there, and wakes when the ball goes.
#[test]
fn hair_that_lies_sleeps_until_its_body_goes() {
    let mut scene = draped(4e-3, 8.0);
    let gone = Keyframe { translation: [0.0, -0.3, 0.0], ..Keyframe::new(8.5) };
    scene.bodies[0].motion = [Keyframe::new(8.0), gone].into();
    let mut simulation = simulation(&scene);
    simulation.step((7.9 / simulation.dt()) as u64).unwrap();
    let lying = points(&simulation.frame().unwrap().hair.positions);
    let slept = simulation.report().unwrap().strand_steps.unwrap()["sleeping_steps"];
    simulation.step((1.0 / simulation.dt()) as u64).unwrap();
    let after = points(&simulation.frame().unwrap().hair.positions);
    println!("slept {slept} steps; tip at {:.3}, then at {:.3}", lying[40], after[40]);
    assert!(slept > 100, "{slept}");
    assert!(lying.iter().filter(|x| x.length() < 0.0502).count() > 3, "it does not lie on the ball");
    assert!((after[20] - lying[20]).length() > 0.02, "it hangs in the air: {} {}", lying[20], after[20]);
}

/// Hair that a strong wind presses on a ball keeps its length, and stays out. Held at both ends, with a ball that comes
/// between them, it cannot do both: it keeps its length, and the run says that its steps are not solved.
#[test]
fn hair_that_cannot_go_round_a_body_is_warned_of() {
    let hair = Hair::drawn(1, 17, 0.08, Roots::disc([0.02, 0.04, 0.0], 1e-3));
    let air = Air { ramp: 0.0, ..Air::default().wind([10.0, 0.0, 0.0]) };
    let ball = Body::sphere([0.055, 0.0, 0.0], 0.03);
    let mut pressed = support::in_wind(1.38e-3, air, [hair]);
    let mut between = pressed.clone();
    between.hair[0].tip = End::Pinned;
    between.bodies = vec![shifted(ball.clone(), (0.0, 0.0), (0.1, -0.03))];
    pressed.bodies = vec![ball];
    for (scene, wanted) in [(pressed, false), (between, true)] {
        let mut simulation = simulation(&scene);
        simulation.step(150).unwrap();
        let x = points(&simulation.frame().unwrap().hair.positions);
        let stretch = x.windows(2).map(|w| (w[0].distance(w[1]) / 0.005 - 1.0).abs()).fold(0.0, f64::max);
        println!("between {wanted}: stretch {stretch:.4}");
        let deep = deepest_place(&simulation, 17);
        let unsolved = support::warned(&simulation.warnings(), "unsolved_steps");
        println!("deep {deep:.1e} m, {unsolved} unsolved steps");
        // Of 150: measured 3 and 129. A ball 25 mm beyond the line needs a stretch of more than 0.15.
        assert!(stretch < 0.011, "between {wanted}: stretch {stretch}");
        assert!(if wanted { unsolved > 60 } else { unsolved < 12 }, "between {wanted}: {unsolved}");
        assert_eq!(deep > 1e-3, wanted, "between {wanted}: {deep} m deep");
    }
}

/// Depth of the deepest place of any segment below the surface of any body now \[m\], but for each strand's first;
/// negative if all are outside.
fn deepest_place(simulation: &Simulation, points_of_strand: usize) -> f64 {
    let placed: Vec<CheckedShape> = simulation.scene().bodies.iter().map(|body| body.at(simulation.time())).collect();
    let x = points(&simulation.frame().unwrap().hair.positions);
    let depth = |x: DVec3| placed.iter().map(|body| -body.signed_distance(x).0).fold(f64::NEG_INFINITY, f64::max);
    let segments = x.chunks(points_of_strand).flat_map(|strand| strand[1..].windows(2));
    let places = segments.flat_map(|ends| (0..=32).map(|k| ends[0].lerp(ends[1], f64::from(k) / 32.0)));
    places.map(depth).fold(f64::NEG_INFINITY, f64::max)
}

/// A strand with 10 mm between points falls on a ball of 6 mm, on a ball of triangles, and on the edge of a plate of 2
/// mm, all under the middle of one of its segments: it lies on it.
#[test]
fn segments_lie_on_what_is_smaller_than_they_are() {
    let hair = Hair::drawn(1, 9, 0.08, Roots::disc([0.0, 0.01, 0.0], 1e-3).toward([1.0, 0.0, 0.0]));
    let mut ball = support::alone(1.38e-3, [hair]);
    ball.rods.damping = 10.0;
    ball.bodies = vec![Body::sphere([0.045, 0.0, 0.0], 0.003)];
    let (meshed, mut plate) = (support::meshed(&ball, 32, 64, 3e-4), ball.clone());
    let surface = block(DVec3::new(0.045, -0.017, 0.0), DVec3::new(0.001, 0.02, 0.02));
    plate.bodies[0].shape = Solid::enclosed(surface, Some(3e-4)).unwrap().into();
    for (name, scene) in [("ball", ball), ("ball of triangles", meshed), ("plate", plate)] {
        let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
        let mut moving = f64::NEG_INFINITY;
        for _ in 0..500 {
            simulation.step(1).unwrap();
            moving = moving.max(deepest_place(&simulation, 9));
        }
        let frame = simulation.frame().unwrap();
        let speed = points(&frame.hair.velocities).iter().map(|v| v.length()).fold(0.0, f64::max);
        let [rest, points] = [deepest_place(&simulation, 9), deepest(&simulation, &frame.hair.positions)];
        println!("{name}: {moving:.1e} m inside, at rest {rest:.1e} m, its points {points:.1e} m, {speed:.1e} m/s");
        assert!(moving < 1e-4 && rest < 1e-4, "{name}: {moving} m inside, {rest} m at rest");
        assert!(rest > -1e-4 && points < -5e-4, "{name}: it does not lie there: {rest}, {points}");
        assert!(speed < 0.05, "{name}: no rest: {speed} m/s");
    }
}

/// Hair that starts in a body comes out of it, slowly; out of a mesh too.
#[test]
fn hair_that_starts_inside_comes_out_slowly() {
    for (points, weight) in [(10, 0.0), (46, 9.81)] {
        let mut round = support::alone(1.38e-3, [Hair::drawn(4, points, 0.09, Roots::disc([0.0; 3], 0.004))]);
        round.gravity = [0.0, -weight, 0.0];
        round.bodies = vec![Body::sphere([0.01, -0.06, 0.004], 0.03)];
        let meshed = support::meshed(&round, 64, 128, 1e-3);
        for (name, scene) in [("ball", round), ("mesh", meshed)] {
            comes_out_slowly(name, &scene, points as usize);
        }
    }
}

fn comes_out_slowly(name: &str, scene: &Scene, points_of_strand: usize) {
    let mut simulation = Simulation::new(&support::gpu(), scene).unwrap();
    let body = simulation.scene().bodies[0].at(0.0);
    let lies_deep = |strand: &[DVec3]| strand.iter().any(|x| body.signed_distance(*x).0 < -3e-4);
    let places = |simulation: &Simulation| points(&simulation.frame().unwrap().hair.positions);
    let mut before = places(&simulation);
    let start = deepest(&simulation, &simulation.frame().unwrap().hair.positions);
    assert!(before.chunks(points_of_strand).all(lies_deep) && start > 0.02, "not all strands start inside: {start}");
    let (mut fastest, mut stretch, mut out) = (0.0_f64, 0.0_f64, 0);
    for step in 1..=200 {
        simulation.step(1).unwrap();
        let now = places(&simulation);
        let velocities = points(&simulation.frame().unwrap().hair.velocities);
        let strands = before.chunks(points_of_strand).zip(now.chunks(points_of_strand));
        for ((before, now), v) in strands.zip(velocities.chunks(points_of_strand)) {
            if lies_deep(before) {
                let moved = before.iter().zip(now).map(|(a, b)| a.distance(*b) / simulation.dt());
                fastest = moved.chain(v.iter().map(|v| v.length())).fold(fastest, f64::max);
                let rest = 0.09 / (points_of_strand - 1) as f64;
                stretch = now.windows(2).map(|x| (x[0].distance(x[1]) / rest - 1.0).abs()).fold(stretch, f64::max);
                out = step;
            }
        }
        before = now;
    }
    let left = deepest(&simulation, &simulation.frame().unwrap().hair.positions);
    println!(
        "{name}, {points_of_strand} points: started {start:.1e} m deep, at most {fastest:.3} m/s and stretched by \
         {stretch:.4} until step {out}; {left:.1e} m deep in the end"
    );
    // Hair that still moves may be as deep as a multiplier allows, 2e-5 m; measured 1.1e-5 m.
    assert!(left < 2e-5, "{left} m still inside");
    assert!(fastest < 0.2 && stretch < 2e-3, "{fastest} m/s, {stretch}");
}

/// Hair that starts through a plate, with no point in it or with one, is not thrown: the first came to 16.7 m/s in 20
/// steps where its segments did not mark it.
#[test]
fn hair_that_starts_through_a_plate_is_not_thrown() {
    let mut scene = support::in_wind(1.38e-3, Air::default().wind([0.0; 3]), []);
    scene.rods.sleep = false;
    // Thickness of the plate, distance between points, of the root from the plate's middle and of the strand from the
    // plate's edge [m].
    let cases = [
        (0.005, 0.009, -0.040, 0.02),
        (0.005, 0.009, -0.040, 0.005),
        (0.005, 0.009, -0.036, 0.02),
        (0.005, 0.003, -0.040, 0.02),
        (0.004, 0.020, -0.050, 0.02),
        (0.008, 0.020, -0.050, 0.02),
    ];
    for (thickness, apart, root, from_edge) in cases {
        let plate = block(DVec3::ZERO, DVec3::new(0.5 * thickness, 0.05, 0.05));
        scene.bodies = vec![Body::solid(Solid::enclosed(plate, Some(1e-3)).unwrap())];
        let count = (0.09 / apart) as usize;
        let strand = (0..count).map(|k| [root + apart * k as f64, 0.05 - from_edge, 0.003]).collect();
        let groom = Groom::new(strand, vec![0, count as u32]);
        let initial = InitialState::with_groom(&scene, &groom).unwrap();
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        let mut fastest = [0.0_f64; 3];
        for step in 0..500 {
            simulation.step(1).unwrap();
            let v = points(&simulation.frame().unwrap().hair.velocities);
            let part = usize::from(step >= 20) + usize::from(step >= 100);
            fastest[part] = v.iter().map(|v| v.length()).fold(fastest[part], f64::max);
        }
        println!(
            "plate of {thickness} m, points {apart} m apart, root at {root} m, {from_edge} m from the edge: \
             {fastest:.3?} m/s"
        );
        assert!(fastest[0] < 0.3, "{fastest:?} m/s");
        assert!(fastest[1] < 2.5 && fastest[2] < 2.5, "{fastest:?} m/s; what a body bent springs back when it is out");
    }
}

/// Hair that is rooted 0.2 to 1.5 mm below a surface and combed along it, or into it, comes out slowly and rests, on a
/// mesh too. Its shape at rest bends it back into the body.
#[test]
fn hair_rooted_inside_comes_out_and_rests() {
    const RADIUS: f64 = 0.04;
    const POINTS: usize = 21;
    let mut round = support::alone(1.38e-3, []);
    round.gravity = [0.0; 3];
    round.rods = Rods { damping: 20.0, sleep: false, ..Rods::default() };
    round.bodies = vec![Body::sphere([0.0; 3], RADIUS)];
    let meshed = support::meshed(&round, 64, 128, 2e-3);
    let cases: Vec<[f64; 2]> = [0.2e-3, 0.5e-3, 1.5e-3]
        .iter()
        .flat_map(|depth| [93.0, 110.0, 135.0].map(|angle: f64| [*depth, angle]))
        .collect();
    let strands = cases.iter().map(|[depth, angle]| {
        let along = DVec3::new(0.0, angle.to_radians().cos(), -angle.to_radians().sin());
        (0..POINTS).map(move |k| ((RADIUS - depth) * DVec3::Y + 0.005 * k as f64 * along).to_array())
    });
    let offsets = (0..=cases.len()).map(|s| (s * POINTS) as u32).collect();
    let groom = Groom::new(strands.flatten().collect(), offsets);
    for (name, scene, off) in [("ball", round, 1e-8), ("mesh", meshed, 1e-5)] {
        let initial = InitialState::with_groom(&scene, &groom).unwrap();
        let mut simulation = Simulation::with_state(&support::gpu(), &scene, initial).unwrap();
        let body = simulation.scene().bodies[0].shape.clone();
        let (mut coming, mut fastest) = (0.0_f64, 0.0_f64);
        let mut speeds = vec![];
        let mut x = points(&simulation.frame().unwrap().hair.positions);
        for _ in 0..900 {
            simulation.step(1).unwrap();
            let now = simulation.frame().unwrap().hair;
            let before = std::mem::replace(&mut x, points(&now.positions));
            let v = points(&now.velocities);
            speeds = v.chunks(POINTS).map(|v| v.iter().map(|v| v.length()).fold(0.0, f64::max)).collect();
            let inside = |x: &[DVec3]| x[1..].iter().any(|x| body.signed_distance(*x).0 < -3e-4);
            let out = before.chunks(POINTS).zip(&speeds).filter(|(x, _)| inside(x)).map(|(_, v)| *v);
            coming = out.fold(coming, f64::max);
            fastest = speeds.iter().copied().fold(fastest, f64::max);
        }
        let depth = x.chunks(POINTS).flat_map(|x| &x[1..]).map(|x| -body.signed_distance(*x).0).fold(-1.0, f64::max);
        let last = speeds.iter().copied().fold(0.0, f64::max);
        println!("{name}: {coming:.3} m/s inside, {fastest:.3} m/s, in the end {last:.1e} m/s and {depth:.1e} m deep");
        assert!(coming < 0.2, "{name}: {coming} m/s while it comes out");
        assert!(fastest < 1.8, "{name}: {fastest} m/s; hair that is rooted outside comes to 1.8 m/s");
        assert!(last < 0.01, "{name}: no rest: {cases:?}: {speeds:?} m/s");
        assert!(depth < off, "{name}: {depth} m inside");
    }
}

/// Wind past a ball.
fn passed() -> Scene {
    wind_past([0.16, 0.09, 0.09], Body::sphere([0.07, 0.045, 0.045], 0.02))
}

/// Wind past a body in a periodic box, in the substeps that `windswept check` asks for: in steps of 1.38 ms a void
/// opens behind the body with solver divergence.
fn wind_past(size: [f64; 3], body: Body) -> Scene {
    let mut scene = Scene::new(Time { substeps: 2, ..Time::new(1.38e-3, 1.0) });
    scene.air = Some(Air::filling(size).wind([3.0, 0.0, 0.0]));
    scene.fluid.iterations = 6;
    scene.bodies = vec![body];
    scene
}

/// Mean velocity along x of the air in a region, given in the ball's own frame \[m/s\].
fn mean_speed(frame: &Frame, ball: DVec3, place: impl Fn(DVec3) -> bool) -> f64 {
    let each = points(&frame.air.positions).into_iter().zip(&frame.air.velocities);
    let (sum, n) =
        each.filter(|(x, _)| place(*x - ball)).fold((0.0, 0), |(sum, n), (_, v)| (sum + f64::from(v[0]), n + 1));
    assert!(n > 20, "{n} particles there");
    sum / f64::from(n)
}

/// Air that streams past a ball never enters it, and leaves a wake behind it.
#[test]
fn air_flows_around_a_ball() {
    around_a_ball(FluidSolver::Pbf, 0.5);
    around_a_ball(FluidSolver::Divergence, 0.75);
}

/// Air behind the ball has at most the part `slowed` of the speed beside it.
fn around_a_ball(solver: FluidSolver, slowed: f64) {
    let mut scene = passed();
    scene.fluid.solver = Some(solver);
    let mut simulation = simulation(&scene);
    let ball = DVec3::new(0.07, 0.045, 0.045);
    let across = |r: DVec3| r.y.hypot(r.z);
    let (mut behind, mut beside, mut before) = (0.0, 0.0, 0.0);
    for step in 1..=7 {
        simulation.step(10).unwrap();
        let frame = simulation.frame().unwrap();
        let depth = deepest(&simulation, &frame.air.positions);
        // 0.4 of a spacing of 4.8 mm outside, less rounding.
        assert!(depth < -0.0019, "step {}: air {depth} m inside", 10 * step);
        assert!(frame.air.velocities.iter().flatten().all(|v| v.is_finite() && v.abs() < 9.0), "step {}", 10 * step);
        if step > 3 {
            behind += mean_speed(&frame, ball, |r| across(r) < 0.02 && (0.02..0.05).contains(&r.x)) / 4.0;
            beside += mean_speed(&frame, ball, |r| (0.024..0.045).contains(&across(r)) && r.x.abs() < 0.015) / 4.0;
            before += mean_speed(&frame, ball, |r| across(r) < 0.02 && (-0.05..-0.02).contains(&r.x)) / 4.0;
        }
    }
    println!("{}: u before {before:.2}, beside {beside:.2}, behind {behind:.2} m/s", solver.word());
    // Measured 2.58, 3.41 and 0.62 m/s with pbf, 2.43, 3.32 and 1.99 m/s with divergence: air slips on the ball, and an
    // ideal fluid would have no wake.
    assert!(behind < slowed * beside && beside > 3.0 && before < 2.7, "{before} {beside} {behind}");
}

/// A ball that moves through still air carries it along in front, and the air stays outside.
#[test]
fn a_moving_ball_pushes_air() {
    let mut scene = passed();
    scene.air = scene.air.map(|air| air.wind([0.0; 3]));
    scene.bodies[0] = shifted(scene.bodies[0].clone(), (0.0, -0.03), (0.08, 0.05));
    scene.bodies[0].motion.keyframes[1].rotation = [1.0, 2.0, 0.0];
    let mut simulation = simulation(&scene);
    simulation.step(50).unwrap();
    let frame = simulation.frame().unwrap();
    let ball = simulation.scene().bodies[0].at(simulation.time()).center();
    let before = mean_speed(&frame, ball, |r| r.y.hypot(r.z) < 0.012 && (0.02..0.028).contains(&r.x));
    let beside = mean_speed(&frame, ball, |r| r.y.hypot(r.z) > 0.024 && r.x.abs() < 0.015);
    let depth = deepest(&simulation, &frame.air.positions);
    println!("u before {before:.2}, beside {beside:.2} m/s, {depth:.1e} m inside");
    assert!(depth < -0.0019, "{depth}");
    // The ball moves at 1 m/s; the air that it displaces flows back beside it.
    // Measured 0.69 and -0.09 m/s.
    assert!((0.5..1.1).contains(&before) && beside < -0.04, "{before} {beside}");
}

/// A cylinder of 12 mm in 3 m/s is told of in a step of 1.38 ms, in which air goes a third of its radius, and not in
/// half of that.
#[test]
fn steps_too_long_for_a_body_are_counted() {
    let mut scene = wind_past([0.16, 0.09, 0.03], Body::capsule([0.05, 0.045, -0.05], [0.05, 0.045, 0.1], 0.012));
    let counted = [1, 2].map(|substeps| {
        scene.time.substeps = substeps;
        let mut simulation = simulation(&scene);
        simulation.step(80).unwrap();
        support::warned(&simulation.warnings(), "air_beside_bodies")
    });
    println!("{counted:?} steps");
    // Measured 53 and 0.
    assert!(counted[0] > 40 && counted[1] == 0, "{counted:?}");
}

/// A post that stands on the floor of the box is a wall to the air at the ceiling as well, which is next to it: without
/// that, air that left through the ceiling came out in the post, and crowded there to 1.46 of its density.
#[test]
fn a_post_through_the_floor_is_a_wall_at_the_ceiling() {
    let post = Body::capsule([0.05, -0.04, 0.035], [0.05, 0.02, 0.035], 0.012);
    let mut simulation = simulation(&wind_past([0.14, 0.07, 0.07], post));
    let (mut nearest, mut densest) = (f64::INFINITY, 0.0_f32);
    for _ in 0..12 {
        simulation.step(10).unwrap();
        let air = simulation.frame().unwrap().air;
        let over = points(&air.positions).into_iter().filter(|x| (x.x - 0.05).hypot(x.z - 0.035) < 0.01);
        nearest = over.map(|x| 0.07 - x.y).fold(nearest, f64::min);
        densest = simulation.density().unwrap().into_iter().fold(densest, f32::max);
    }
    println!("{nearest:.2e} m from the cut, density {densest:.2}");
    // Measured 1.98e-3 m, where the clearance is 1.94e-3 m, and 1.08.
    assert!(nearest > 1.9e-3 && densest < 1.25, "{nearest} {densest}");
}

/// examples/scenes/head.toml, its head turned at once: hair and air stay out of the mesh, hair goes with it, nothing to
/// be warned of.
#[test]
#[ignore = "long: 14 s of CPU time"]
fn hair_stays_on_a_head_that_turns() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/head.toml");
    let mut scene = Scene::load(file).unwrap();
    let turn = &mut scene.bodies[0].motion.keyframes;
    (turn[0].time, turn[1].time) = (0.01, 0.05);
    let mut simulation = Simulation::new(&support::gpu(), &scene).unwrap();
    assert!(simulation.initial().warnings.is_empty(), "{:?}", simulation.initial().warnings);
    simulation.step(40).unwrap();
    let frame = simulation.frame().unwrap();
    let free: Vec<[f32; 3]> = frame.hair.positions.chunks(11).flat_map(|strand| strand[1..].to_vec()).collect();
    let [hair, roots, air] = [&free, &frame.hair.positions, &frame.air.positions].map(|x| deepest(&simulation, x));
    println!("hair {hair:.1e} m inside, roots {roots:.1e} m, air {air:.1e} m");
    // Roots are on triangles, of which the grid is off next to edges that lead inward: measured 5.5e-6 m; margin 4.
    assert!(hair < 3e-8 && roots < 2.2e-5 && air < 0.0, "{hair} {roots} {air}");
    assert!(frame.hair.velocities.iter().flatten().all(|v| v.abs() < 9.0));
    let turned = scene.bodies[0].motion.at(0.04).rotation * scene.bodies[0].motion.at(0.0).rotation.inverse();
    let roots = |positions: &[[f32; 3]]| points(positions).into_iter().step_by(11).collect::<Vec<_>>();
    let start = roots(&Simulation::new(&support::gpu(), &scene).unwrap().frame().unwrap().hair.positions);
    let now = roots(&frame.hair.positions);
    assert!(turned.to_axis_angle().1 > 0.2 && start.iter().zip(&now).any(|(a, b)| a.distance(*b) > 5e-3));
}

/// examples/scenes/groom.toml: its groom sits on its head, and there is nothing to be warned of.
#[test]
fn the_groom_of_the_example_sits_on_its_head() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/scenes/groom.toml");
    let scene = Scene::load(file).unwrap().check().unwrap();
    let initial = InitialState::new(&scene).unwrap();
    assert!(initial.warnings.is_empty(), "{:?}", initial.warnings);
    assert_eq!((initial.hair.len(), initial.hair.positions.len()), (120, 1200));
    let head = scene.bodies[0].at(0.0);
    let off = initial.hair.roots().map(|root| head.signed_distance(root).0.abs()).fold(0.0, f64::max);
    // m; the grid of 1 mm makes so much of a triangle's surface.
    assert!(off < 2.5e-4, "{off:e}");
}
