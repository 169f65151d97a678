//! Cosserat rods (Kugelstadt & Schömer 2016): integrated by BDF2 or Euler, solved directly or by Gauss-Seidel.

mod direct;
mod gauss_seidel;

use glam::{DMat3, DQuat, DVec3};
use windswept_scene::{Model, Strands};

pub use self::{
    direct::{FITS, QUIET, direct},
    gauss_seidel::gauss_seidel,
};
use crate::{Parameters, state};

/// A strand is strained where a segment is stretched or crushed by more than this.
pub const STRAINED: f64 = 0.5;
/// Over-strained steps on end at which a strand is warned of.
pub const STRAINED_STEPS: u32 = 50;
/// |C| of stretch-shear where velocities lead: beyond it a strand is not calm.
pub const TORN: f64 = 0.1;
/// Left by the direct solver, beyond it a strand is not calm.
pub const MISFIT: f64 = 1e-3;
/// Steps on end without it, until BDF2 may go on.
pub const CALM: u32 = 3;
/// Δt w D_n from which on a strand in the wind takes Euler.
pub const STORMY: f64 = 1.0 / 3.0;
/// What the air may move a free point by in a step, over the length of its strand, where the strand is whole but not calm.
pub const LOADED: f64 = 0.4;
/// So long at rest a strand falls asleep \[s\], and so many steps.
pub const STILL_TIME: f64 = 0.07;
/// See [`STILL_TIME`].
pub const STILL_STEPS: u32 = 10;
/// Its frames turn more slowly than this \[rad/s\].
pub const STILL_SPIN: f64 = 2e-3;

/// |C + α μ| of stretch-shear at which the direct solver has torn a strand.
pub const RESCUED: f64 = 1.0;

/// What a strand does within a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum State {
    /// Still to be solved.
    #[default]
    Free,
    /// Solved.
    Solved,
    /// Moved as a whole with its root.
    Teleported,
    /// Stays where it is.
    Asleep,
}

/// A strand within a step: what its clamp does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// What the root moves by \[m\].
    pub root_travel: DVec3,
    /// Ghost frame at the step's end.
    pub root_frame: DQuat,
    /// From the ghost frame at the step's start.
    pub root_turn: DQuat,
    /// How it goes through the step.
    pub state: State,
    /// μ of the tip's joint \[N m\].
    pub tip_moment: DVec3,
    /// max |C + α μ| of stretch-shear that the direct solver left.
    pub misfit: f64,
    /// Velocities lead to where the strand is torn.
    pub torn: bool,
    /// Whether the segments of the strand fit where it is.
    pub whole: bool,
    /// h of the strand, if it is integrated \[s\].
    pub step: f64,
}

/// What acts on a hair point from outside its rod: `force` − `resistance` v, v its velocity at the step's end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// On the point at rest \[N\].
    pub force: DVec3,
    /// To its velocity \[kg/s\].
    pub resistance: f64,
}

impl Load {
    /// The force on a point that moves with `velocity` \[N\].
    #[must_use]
    pub fn at(&self, velocity: DVec3) -> DVec3 {
        self.force - self.resistance * velocity
    }
}

/// A point within a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// v_n with what acts from outside in this step \[m/s\].
    pub velocity: DVec3,
    /// v_{n−1} with the same \[m/s\].
    pub before: DVec3,
    /// The move of the step before \[m\].
    pub carried: DVec3,
    /// What density moved the drifting point by, as an impulse \[m/s\].
    pub change: DVec3,
    /// What acts on it from outside.
    pub load: Load,
    /// All that acts from outside in this step \[m/s\].
    pub outside: DVec3,
    /// What of it did not act in the last step awake \[m/s\].
    pub push: DVec3,
    /// \[1/kg\]
    pub inverse_mass: f64,
    /// The largest move in a step \[m\].
    pub largest: f64,
    /// h \[s\]; infinite for what was put somewhere.
    pub step: f64,
    /// The move without the rod's forces \[m\].
    pub free: DVec3,
    /// The move \[m\].
    pub travel: DVec3,
}

/// A segment within a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment {
    /// Frame at the step's start.
    pub start: DQuat,
    /// Frame.
    pub frame: DQuat,
    /// At the step's start \[rad/s\].
    pub angular_velocity: DVec3,
    /// Of the step before \[rad/s\].
    pub before: DVec3,
    /// The turn of the step before \[rad\].
    pub carried: DVec3,
    /// h \[s\].
    pub step: f64,
    /// The turn without the rod's forces \[rad\].
    pub free: DVec3,
    /// The turn \[rad\].
    pub turn: DVec3,
    /// From its first point to its second at the step's start \[m\].
    pub chord: DVec3,
    /// μ of stretch-shear \[N m\]: world axes; Gauss-Seidel's λ in the material frame.
    pub force: DVec3,
    /// μ of the joint before it, in the frame before \[N m\].
    pub moment: DVec3,
}

/// All points and segments within a step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Moving {
    /// Per hair point.
    pub points: Vec<Point>,
    /// Per segment.
    pub segments: Vec<Segment>,
}

/// 1/3 for BDF2, whose h is 2/3 Δt, 0 for Euler.
fn carry(p: &Parameters, h: f64) -> f64 {
    if h < p.step { 1.0 / 3.0 } else { 0.0 }
}

/// carry d + h (v + h a)/(1 + c h), v = (4 v_n − v_{n−1})/3 or v_n: the move without the rod's forces. `damping` is c \[1/s\].
#[must_use]
pub fn free_move(
    p: &Parameters,
    now: DVec3,
    before: DVec3,
    carried: DVec3,
    acceleration: DVec3,
    damping: f64,
    h: f64,
) -> DVec3 {
    let v = if h < p.step { (4.0 * now - before) / 3.0 } else { now };
    carry(p, h) * carried + h * (v + h * acceleration) / (1.0 + damping * h)
}

/// v_{n+1} = (move − carry d)/h.
#[must_use]
pub fn rate(p: &Parameters, shift: DVec3, carried: DVec3, h: f64) -> DVec3 {
    (shift - carry(p, h) * carried) / h
}

/// h²/(1 + c h): what a force moves a unit of mass by. `damping` is c \[1/s\].
#[must_use]
pub fn response(damping: f64, h: f64) -> f64 {
    h * h / (1.0 + damping * h)
}

/// c of a point \[1/s\]: the scene's, and what resists its velocity.
#[must_use]
pub fn damping(p: &Parameters, point: &Point) -> f64 {
    p.damping + point.inverse_mass * point.load.resistance
}

/// Where the clamp of strand `s` goes: where its keyframes are at the step's end, else a part of the way to its target, all of
/// it in the last substep. A jump of more than
/// the strand's length is a teleport, unless the tip is held too; a strand whose clamp rests may sleep. Free roots go where
/// they will.
#[must_use]
pub fn roots(p: &Parameters, s: &state::State, strand: usize) -> Drive {
    let (held, mut goal) = (s.clamps[strand], s.root_targets[strand]);
    let mut left = u64::from(p.substeps) - s.steps % u64::from(p.substeps);
    let group = s.hair.group.get(strand).and_then(|group| p.hair_motions.get(*group as usize));
    if let Some((motion, center)) = group.filter(|(motion, _)| !motion.keyframes.is_empty()) {
        // From where it is drawn to where it is at the step's end, by way of where it started.
        let ((start, turned), (end, turning)) = (motion.at(0.0), motion.at((s.steps + 1) as f64 * p.step));
        let turn = turning * turned.conjugate();
        goal = (*center + end + turn * (goal.0 - *center - start), (turn * goal.1).normalize());
        left = 1;
    }
    let (points, free) = (s.hair.points(strand), |i: usize| s.inverse_mass[i] > 0.0);
    if free(points.start) {
        goal = held;
    }
    let way = goal.0 - held.0;
    let length: f64 = s.hair.rest_length[s.hair.segments(strand)].iter().sum();
    let jumps = free(points.end - 1) && way.length() > length;
    let part = if jumps { 1.0 } else { 1.0 / left as f64 };
    if held == goal {
        let state = if p.sleep { State::Asleep } else { State::Free };
        return Drive { root_frame: held.1, root_turn: DQuat::IDENTITY, state, ..Drive::default() };
    }
    let root_turn = rotation(part * rotation_vector(goal.1 * held.1.conjugate()));
    Drive {
        root_travel: part * way,
        root_turn,
        // To the bit where it arrives: a clamp that was off by rounding would never rest.
        root_frame: if part == 1.0 { goal.1 } else { (root_turn * held.1).normalize() },
        state: if jumps { State::Teleported } else { State::Free },
        ..Drive::default()
    }
}

/// A point that nothing holds: x + Δt (v + g Δt)/(1 + c Δt), the move capped at `largest` \[m\]. Held ones keep their velocity.
#[must_use]
pub fn drift(p: &Parameters, w: f64, position: DVec3, velocity: DVec3, largest: f64) -> DVec3 {
    if w == 0.0 {
        return position + p.step * velocity;
    }
    let shift = p.step * (velocity + p.step * p.gravity) / (1.0 + p.damping * p.step);
    position + shift.clamp_length_max(largest)
}

/// What point `i` starts from: what density moved the drifting point by is an impulse on it.
#[must_use]
pub fn begin_points(p: &Parameters, s: &state::State, i: usize, correction: DVec3, largest: f64) -> Point {
    let inverse_mass = s.inverse_mass[i];
    let change = if inverse_mass > 0.0 { correction / p.step } else { DVec3::ZERO };
    Point {
        velocity: s.velocity[i] + change,
        before: s.velocity_before[i] + change,
        carried: s.travel[i],
        change,
        inverse_mass,
        largest,
        ..Point::default()
    }
}

/// What segment `k` of strand `strand` starts from.
#[must_use]
pub fn begin_segments(s: &state::State, strand: usize, k: usize) -> Segment {
    let point = s.hair.points(strand).start + k - s.hair.segments(strand).start;
    Segment {
        start: s.orientation[k],
        angular_velocity: s.angular_velocity[k],
        before: s.angular_velocity_before[k],
        carried: s.turn[k],
        chord: s.position[point + 1] - s.position[point],
        force: s.force[k],
        moment: s.moment[k],
        ..Segment::default()
    }
}

/// What [`start`] counts of a strand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Choice {
    /// Free moves that were capped.
    pub capped: usize,
    /// Euler where BDF2 is asked for.
    pub euler: bool,
}

/// By BDF2 or by Euler a strand is integrated, if it is: by BDF2 where its velocities led without tearing it for
/// [`CALM`] steps on end.
pub fn choose(p: &Parameters, s: &state::State, strand: usize, drive: &mut Drive, m: &Moving) {
    let led = led(p, s, strand, drive, m);
    let led_turn = led_turn(p, s, strand, m);
    let first = s.hair.segments(strand).start;
    let misfit = |k: usize, travel: DVec3, turn: DVec3| {
        let segment = &m.segments[first + k];
        let tangent = rotation(turn) * segment.start * DVec3::Z;
        ((segment.chord + travel) / s.hair.rest_length[first + k] - tangent).length()
    };
    let tear = (0..led_turn.len()).map(|k| misfit(k, led[k + 1] - led[k], led_turn[k]));
    drive.torn = tear.fold(0.0, f64::max) >= TORN;
    drive.whole = (0..led_turn.len()).all(|k| misfit(k, DVec3::ZERO, DVec3::ZERO) < TORN);
    let calm = !drive.torn && s.calm[strand] + 1 >= CALM;
    drive.step = if calm && p.bdf2 { p.step * 2.0 / 3.0 } else { p.step };
}

/// Where velocities lead the points of a strand \[m\]; held ones go where they are held.
fn led(p: &Parameters, s: &state::State, strand: usize, drive: &Drive, m: &Moving) -> Vec<DVec3> {
    let points = s.hair.points(strand);
    let of = |i: usize| {
        let point = &m.points[i];
        if point.inverse_mass == 0.0 { held(points.start, i, drive) } else { p.step * point.velocity }
    };
    points.clone().map(of).collect()
}

/// Where they lead its frames \[rad\].
fn led_turn(p: &Parameters, s: &state::State, strand: usize, m: &Moving) -> Vec<DVec3> {
    s.hair.segments(strand).map(|k| p.step * m.segments[k].angular_velocity).collect()
}

/// What a held point moves by: the root with its clamp, a tip not at all \[m\].
fn held(first: usize, i: usize, drive: &Drive) -> DVec3 {
    if i == first { drive.root_travel } else { DVec3::ZERO }
}

/// Where the drag of a point is taken, and with which velocity: in a step of BDF2 x_n + Δt (3/2 v_n − 1/2 v_{n−1}) and
/// 2 v_n − v_{n−1}, in one of Euler x_n and v_n.
///
/// Taken at the step's start drag is first order, and hair in a storm flutters under BDF2; Euler stands still with nothing
/// extrapolated only.
#[must_use]
pub fn ahead(p: &Parameters, point: &Point, position: DVec3, h: f64) -> (DVec3, DVec3) {
    if h < p.step {
        let (now, before) = (point.velocity, point.before);
        (position + p.step * (1.5 * now - 0.5 * before), 2.0 * now - before)
    } else {
        (position, point.velocity)
    }
}

/// Whether the air resists no point of a strand by more than BDF2 bears: what it extrapolates of the drag grows into a flutter
/// from Δt w D_n = 0.39 on (hairs of 30 to 60 µm, 1 and 4 GPa, 30 to 100 mm in 3 to 20 m/s).
#[must_use]
pub fn follows_wind(p: &Parameters, hair: &Strands, strand: usize, drive: &Drive, m: &Moving) -> bool {
    let resisted = |point: &Point| p.step * point.inverse_mass * point.load.resistance > STORMY;
    drive.step == p.step || !m.points[hair.points(strand)].iter().any(resisted)
}

/// How a strand goes through the step: reset, teleported, asleep or integrated; and where its solver starts.
pub fn start(p: &Parameters, s: &mut state::State, strand: usize, drive: &mut Drive, m: &mut Moving) -> Choice {
    let (points, segments) = (s.hair.points(strand), s.hair.segments(strand));
    for i in points.clone() {
        let point = &mut m.points[i];
        // A held point goes where it is held, whatever pushes.
        point.outside = point.change + p.step * point.inverse_mass * point.load.at(s.velocity[i]);
        point.push = point.outside - s.outside[i];
    }
    // A sleeper has no velocity but what viscosity gave it since.
    let asleep = s.asleep[strand];
    let push = |i: usize| m.points[i].push + if asleep { s.velocity[i] } else { DVec3::ZERO };
    let pushed = points.clone().any(|i| push(i).length() > p.rest[strand].acceleration * p.step);
    if s.bad[strand] {
        s.bad[strand] = false;
        (s.calm[strand], s.still[strand], s.asleep[strand]) = (0, 0, false);
        put_at_rest(&s.hair, strand, drive, m);
        unload(&s.hair, strand, m);
        drive.state = State::Solved;
        return Choice::default();
    }
    let rested = s.still[strand] >= STILL_STEPS && f64::from(s.still[strand]) * p.step >= STILL_TIME;
    if drive.state == State::Teleported {
        (s.calm[strand], s.still[strand]) = (0, 0);
        unload(&s.hair, strand, m);
    }
    if drive.state == State::Teleported
        || drive.state == State::Asleep && rested && !pushed && !(s.asleep[strand] && s.touched[strand])
    {
        s.asleep[strand] = drive.state == State::Asleep;
        put_as_it_is(&s.hair, strand, drive, m);
        return Choice::default();
    }
    drive.state = State::Free;
    if std::mem::take(&mut s.asleep[strand]) {
        s.still[strand] = 0;
    }
    s.calm[strand] = if drive.torn { 0 } else { (s.calm[strand] + 1).min(CALM) };
    let calm = s.calm[strand] == CALM;
    let h = drive.step;
    let ahead = calm && p.direct;
    let (led, led_turn) = (led(p, s, strand, drive, m), led_turn(p, s, strand, m));

    let mut choice = Choice { capped: 0, euler: p.bdf2 && h == p.step };
    let mut free: Vec<DVec3> = points
        .clone()
        .map(|i| {
            let point = &m.points[i];
            if point.inverse_mass == 0.0 {
                return held(points.start, i, drive);
            }
            let acceleration = p.gravity + point.inverse_mass * point.load.force;
            free_move(p, point.velocity, point.before, point.carried, acceleration, damping(p, point), h)
        })
        .collect();
    let length: f64 = s.hair.rest_length[segments.clone()].iter().sum();
    let caps = !ahead || !drags(p);
    let origin = origin(m.points[points.start].inverse_mass == 0.0, drive, &free);
    for (k, i) in points.enumerate() {
        let point = &mut m.points[i];
        let far = (free[k] - origin).length();
        let loaded = response(damping(p, point), h) * point.inverse_mass * point.load.force.length();
        let largest = point.largest + if drive.whole { loaded.min(LOADED * length) } else { 0.0 };
        let capped = caps && point.inverse_mass > 0.0 && far > largest;
        if capped {
            free[k] = origin + (free[k] - origin) * (largest / far);
            choice.capped += 1;
        }

        (point.step, point.free) = (h, free[k]);
        point.travel = if ahead && !capped { led[k] } else { free[k] };
    }
    for (k, j) in segments.enumerate() {
        let segment = &mut m.segments[j];
        segment.step = h;
        segment.free =
            free_move(p, segment.angular_velocity, segment.before, segment.carried, DVec3::ZERO, p.damping, h);
        segment.turn = if ahead { led_turn[k] } else { segment.free };
        segment.frame = (rotation(segment.turn) * segment.start).normalize();
        segment.force = if ahead { segment.frame * segment.force } else { DVec3::ZERO };
        segment.moment = if ahead { segment.moment } else { DVec3::ZERO };
    }
    choice
}

/// Whether the model has a drag that the rods take.
fn drags(p: &Parameters) -> bool {
    matches!(p.model, Model::TwoWay | Model::Drag)
}

/// What free moves are measured from when they are capped: the root's, or their mean where the root is free.
fn origin(root_held: bool, drive: &Drive, free: &[DVec3]) -> DVec3 {
    if root_held { drive.root_travel } else { free.iter().sum::<DVec3>() / free.len() as f64 }
}

/// What was put somewhere felt no force on its way.
fn unload(hair: &Strands, strand: usize, m: &mut Moving) {
    for point in &mut m.points[hair.points(strand)] {
        (point.load, point.outside) = (Load::default(), DVec3::ZERO);
    }
}

/// J = Δt (force − resistance v_{n+1}): what the load of a point gave it \[N s\], v as its rod leaves it; a sleeper's is 0.
#[must_use]
pub fn place(p: &Parameters, point: &Point) -> DVec3 {
    p.step * point.load.at(rate(p, point.travel, point.carried, point.step))
}

/// The strand as it is, turned with its root and moved with it.
fn put_as_it_is(hair: &Strands, strand: usize, drive: &Drive, m: &mut Moving) {
    let mut offset = DVec3::ZERO;
    let first = hair.points(strand).start;
    put(&mut m.points[first], drive.root_travel);
    for (k, i) in hair.segments(strand).zip(first + 1..) {
        offset += m.segments[k].chord;
        let frame = drive.root_turn * m.segments[k].start;
        put_frame(&mut m.segments[k], frame);
        put(&mut m.points[i], drive.root_travel + drive.root_turn * offset - offset);
    }
}

/// The rest shape, unrolled from the clamp; a tip that is held stays.
fn put_at_rest(hair: &Strands, strand: usize, drive: &Drive, m: &mut Moving) {
    let (mut frame, mut offset, mut rest) = (drive.root_frame, DVec3::ZERO, DVec3::ZERO);
    let first = hair.points(strand).start;
    put(&mut m.points[first], drive.root_travel);
    for (k, i) in hair.segments(strand).zip(first + 1..) {
        frame = (frame * hair.rest_rotation[k]).normalize();
        offset += m.segments[k].chord;
        rest += hair.rest_length[k] * (frame * DVec3::Z);
        put_frame(&mut m.segments[k], frame);
        let stays = i + 1 == hair.points(strand).end && m.points[i].inverse_mass == 0.0;
        put(&mut m.points[i], if stays { DVec3::ZERO } else { drive.root_travel + rest - offset });
    }
}

fn put(point: &mut Point, travel: DVec3) {
    (point.travel, point.step) = (travel, f64::INFINITY);
}

fn put_frame(segment: &mut Segment, frame: DQuat) {
    (segment.frame, segment.step) = (frame.normalize(), f64::INFINITY);
    (segment.force, segment.moment) = (DVec3::ZERO, DVec3::ZERO);
}

/// q turned by the small rotation vector `angle` \[rad\], world axes.
#[must_use]
pub fn turned(q: DQuat, angle: DVec3) -> DQuat {
    let spin = DQuat::from_xyzw(angle.x, angle.y, angle.z, 0.0);
    (q + spin * q * 0.5).normalize()
}

/// The rotation by |turn| about `turn` \[rad\], half a turn at most.
#[must_use]
pub fn rotation(turn: DVec3) -> DQuat {
    DQuat::from_scaled_axis(turn.clamp_length_max(std::f64::consts::PI))
}

/// The rotation vector of q, at most π long \[rad\].
#[must_use]
pub fn rotation_vector(q: DQuat) -> DVec3 {
    (if q.w < 0.0 { -q } else { q }).to_scaled_axis()
}

/// s Im(rest), s the sign with which the rest rotation is nearer to p in 4-D.
fn nearest_rest(p: DQuat, rest: DQuat) -> DVec3 {
    if (p - rest).length_squared() <= (p + rest).length_squared() { rest.xyz() } else { -rest.xyz() }
}

fn cross_matrix(v: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, v.z, -v.y), DVec3::new(-v.z, 0.0, v.x), DVec3::new(v.y, -v.x, 0.0))
}

/// Largest move of each point in a step, max(l, 0.03 L) \[m\], l the segment before the point.
#[must_use]
pub fn largest_moves(hair: &Strands) -> Vec<f64> {
    let mut moves = vec![0.0; hair.positions.len()];
    for s in 0..hair.len() {
        let lengths = &hair.rest_length[hair.segments(s)];
        let whole: f64 = lengths.iter().sum();
        for (k, point) in hair.points(s).enumerate() {
            let own = if k == 0 { 0.0 } else { lengths[k - 1] };
            moves[point] = own.max(0.03 * whole);
        }
    }
    moves
}

/// max |l/l0 − 1| of a strand; `None` when a move or a frame of it is not finite.
#[must_use]
pub fn finish(hair: &Strands, s: usize, m: &Moving) -> Option<f64> {
    let (points, segments) = (hair.points(s), hair.segments(s));
    let finite = m.points[points.clone()].iter().all(|point| point.travel.is_finite())
        && m.segments[segments.clone()].iter().all(|segment| segment.frame.is_finite());
    let stretches = points.zip(segments).map(|(i, k)| {
        let chord = m.segments[k].chord + m.points[i + 1].travel - m.points[i].travel;
        (chord.length() / hair.rest_length[k] - 1.0).abs()
    });
    finite.then(|| stretches.fold(0.0, f64::max))
}

/// A bad strand stays where it was for this step, so that it spoils no neighbour.
pub fn hold(hair: &Strands, s: usize, m: &mut Moving) {
    m.points[hair.points(s)].iter_mut().for_each(|point| put(point, DVec3::ZERO));
    for segment in &mut m.segments[hair.segments(s)] {
        let start = segment.start;
        put_frame(segment, start);
    }
    unload(hair, s, m);
}

/// A strand that the direct solver tore is left to Gauss-Seidel: back to its free move, nothing held. Says whether it was one.
pub fn rescue(p: &Parameters, hair: &Strands, s: usize, drive: &mut Drive, m: &mut Moving) -> bool {
    if drive.state != State::Free {
        return false;
    }
    if drive.misfit < RESCUED {
        drive.state = State::Solved;
        return false;
    }
    let points = hair.points(s);
    let free: Vec<_> = m.points[points.clone()].iter().map(|point| point.free).collect();
    let origin = origin(m.points[points.start].inverse_mass == 0.0, drive, &free);
    for (point, free) in m.points[points].iter_mut().zip(free) {
        // Moves of calm strands were not capped where air drags them.
        let capped = drags(p) && point.inverse_mass > 0.0;
        point.travel = if capped { origin + (free - origin).clamp_length_max(point.largest) } else { free };
    }
    for segment in &mut m.segments[hair.segments(s)] {
        segment.frame = (rotation(segment.free) * segment.start).normalize();
    }
    forget(hair, s, m);
    true
}

/// Multipliers of Gauss-Seidel are none that the direct solver could start from.
pub fn forget(hair: &Strands, s: usize, m: &mut Moving) {
    for segment in &mut m.segments[hair.segments(s)] {
        (segment.force, segment.moment) = (DVec3::ZERO, DVec3::ZERO);
    }
}

/// Whether a strand was slow, and not pushed, when the step began.
#[must_use]
pub fn still(p: &Parameters, hair: &Strands, s: usize, m: &Moving) -> bool {
    let rest = p.rest[s];
    // A strand that nothing holds may drift as slowly as it will.
    let held = m.points[hair.points(s).start].inverse_mass == 0.0;
    let slow =
        |point: &Point| point.velocity.length() <= rest.speed && point.push.length() <= rest.acceleration * p.step;
    held && m.points[hair.points(s)].iter().all(slow)
        && m.segments[hair.segments(s)].iter().all(|segment| segment.angular_velocity.length() <= STILL_SPIN)
}

/// Velocity of a point from its move; what a contact added to that, `shift` \[m\], is an impulse on top \[m/s\].
#[must_use]
pub fn velocity(p: &Parameters, point: &Point, shift: DVec3) -> DVec3 {
    rate(p, point.travel, point.carried, point.step) + shift / p.step
}
