//! Newton steps on the incremental potential of a strand, each solved by a Riccati recursion over 6-vectors.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix6, Matrix6x4, Vector4, Vector6};
use windswept_scene::{End, Strands};

use super::{
    Moving, Point, Segment, State, StrandMotion, cross_matrix, nearest_rest, response, rotation, rotation_vector,
};
use crate::{
    Parameters,
    contact::{Contact, Placed, RECOVERY, UNEASY},
};

/// Strain |u|/l of a segment beyond which a start is made whole, and no solve ends.
pub const WHOLE: f64 = 0.01;
/// Largest turn of a frame at first, and of a joint in a Newton step \[rad\].
pub const TURN: f64 = 1.0;
/// Turn of a frame in a Newton step of a strand whose tip is held \[rad\]: the whole step is cut to it.
const HELD_TURN: f64 = 0.5;
/// Turn of a frame \[rad\], and change of a strain, in a Newton step that is the last,
pub const SETTLED: f64 = 1e-3;
/// or this part of that in the first one.
pub const RELATIVE: f64 = 1e-2;
/// Smallest compliance that counts \[1/(N m)\],
const STIFFEST: f64 = 1e-6;
/// and smallest part of the largest of a spring's, as the engine needs it in f32.
const UNEVEN: f64 = 1e-3;

/// A strand within a step.
pub(super) struct Rod<'a> {
    pub p: &'a Parameters,
    pub hair: &'a Strands,
    strand: usize,
    pub points: &'a mut [Point],
    pub segments: &'a mut [Segment],
    pub motion: &'a mut StrandMotion,
    /// Bodies that the strand may meet.
    pub bodies: &'a [Placed],
    /// Contacts of each point with each of them.
    pub point_contacts: &'a mut [Contact],
    /// Contacts of each segment with each of them.
    pub segment_contacts: &'a mut [Contact],
    /// Newton steps so far.
    pub newton: u32,
}

/// A spring between two frames or along a segment: its stiffness and the moment or force by which it resists.
struct Spring {
    stiffness: DMat3,
    force: DVec3,
}

/// Potential beyond a point or a joint, ½ sᵀ P s + sᵀ p (1, λ): s its turn and its move, λ a change of the force that
/// holds a held tip.
#[derive(Clone, Copy)]
struct Beyond {
    matrix: Matrix6<f64>,
    vectors: Matrix6x4<f64>,
}

/// Answer z = constant (1, λ) + gain s of a joint and its segment to the state s before it, with what cut joints need
/// of it.
struct Answer {
    constant: Matrix6x4<f64>,
    gain: Matrix6<f64>,
    /// Potential beyond the joint, at the segment's first point.
    beyond: Beyond,
    stretch: Spring,
}

/// Solves strand `s`: Newton steps until frames, strains, a held tip and contacts have settled, or as many as there
/// are.
///
/// ```text
///   Φ = Σ |x_i − free_i|²/(2 W_i) + Σ 4 J_k (1 − |p_w|) + Σ ½ εᵀ α_s⁻¹ ε + Σ ½ Cᵀ α_b⁻¹ C      ε = Rᵀ u/l, J = 1/W of a frame
/// ```
/// with p = turn · conj(free turn) and C = Im(q̄₀ q₁) − s Im(rest). The unknowns are frames and strains u = chord − l
/// d₃, from which points follow. Contacts with bodies are springs on points and segments (`contact/hair.rs`).
///
/// # Panics
/// Where the Hessian is not positive definite, so that the potential need not fall along a Newton step.
pub fn solve(p: &Parameters, hair: &Strands, s: usize, motion: &mut StrandMotion, m: &mut Moving) {
    if motion.state != State::Free {
        return;
    }
    let (points, segments) = (hair.points(s), hair.segments(s));
    let count = if motion.meets { m.bodies.len() } else { 0 };
    let mut rod = Rod {
        p,
        hair,
        strand: s,
        bodies: &m.bodies[..count],
        point_contacts: &mut m.point_contacts[points.start * count..points.end * count],
        segment_contacts: &mut m.segment_contacts[segments.start * count..segments.end * count],
        points: &mut m.points[points],
        segments: &mut m.segments[segments],
        motion,
        newton: 0,
    };
    if !rod.points.iter().all(|point| (point.free + point.displacement).is_finite()) {
        // Frames that are not finite lead points to where nothing is.
        return;
    }
    let mut now = rod.touch(true, false);
    let (mut steep, mut settled) = (false, SETTLED);
    while rod.newton < p.newton_steps {
        let most = rod.newton_step(steep);
        if rod.newton == 0 {
            settled = SETTLED.max(RELATIVE * most);
        }
        rod.newton += 1;
        now = rod.touch(false, false);
        if most < settled && !now.changed {
            if !now.lags {
                rod.motion.state = State::Solved;
                break;
            }
            now = rod.touch(false, true);
        }
        steep = most > TURN || now.touches && (now.changed || most > UNEASY);
    }
    if rod.motion.comes_out {
        rod.crawl();
    }
    rod.finish(now.touches);
    rod.leave(rod.motion.state == State::Solved);
}

/// The incremental potential Φ of strand `s` where the solve has it \[J s²\], without a held tip and contacts.
#[must_use]
pub fn potential(p: &Parameters, hair: &Strands, s: usize, motion: &StrandMotion, m: &Moving) -> f64 {
    let (points, segments) = (&m.points[hair.points(s)], &m.segments[hair.segments(s)]);
    let effective_inverse_mass = |point: &Point| point.effective_inverse_mass(p);
    let moved = points.iter().filter(|point| point.inverse_mass > 0.0);
    let mut sum: f64 = moved
        .map(|point| (point.displacement - point.free).length_squared() / (2.0 * effective_inverse_mass(point)))
        .sum();
    let first = hair.segments(s).start;
    for (k, segment) in segments.iter().enumerate() {
        let off = segment.turn * segment.free.conjugate();
        let inertia = 1.0 / (response(p.rods.damping, segment.step) * hair.inverse_inertia[first + k]);
        sum += 4.0 * inertia * (1.0 - off.w.abs());
        let strain = segment.frame.conjugate() * segment.strain / hair.rest_length[first + k];
        sum += 0.5 * (strain * strain * stiffness(hair.stretch_compliance[first + k])).element_sum();
        if k > 0 || hair.ends(s).root == End::Clamped {
            let before = if k > 0 { segments[k - 1].frame } else { motion.root_frame };
            let gap = gap(before, segment.frame, hair.rest_rotation[first + k]);
            sum += 0.5 * (gap * gap * stiffness(hair.bend_compliance[first + k])).element_sum();
        }
    }
    if hair.ends(s).tip == End::Clamped {
        let ends = hair.ends(s);
        let gap = gap(segments[segments.len() - 1].frame, motion.tip_frame, ends.tip_rest_rotation);
        sum += 0.5 * (gap * gap * stiffness(ends.tip_compliance)).element_sum();
    }
    sum
}

/// Gap C = Im(q̄₀ q₁) − s Im(rest), s the sign that is nearer in 4-D.
fn gap(before: DQuat, after: DQuat, rest: DQuat) -> DVec3 {
    let p = before.conjugate() * after;
    p.xyz() - nearest_rest(p, rest)
}

/// Stiffnesses of a spring, of its compliances as they count.
fn stiffness(compliance: DVec3) -> DVec3 {
    compliance.max(DVec3::splat(STIFFEST.max(UNEVEN * compliance.max_element()))).recip()
}

/// Stiffness Aᵀ α⁻¹ A and force Aᵀ α⁻¹ C of a constraint C with the derivative A.
fn spring(derivative: DMat3, compliance: DVec3, gap: DVec3) -> Spring {
    let stiffness = stiffness(compliance);
    let weighted = derivative.transpose() * DMat3::from_diagonal(stiffness);
    Spring { stiffness: weighted * derivative, force: weighted * gap }
}

/// The joint between two frames, for turns of the second: dC = ½(p_w I − [p_v]×) R₀ᵀ θ.
fn joint(before: DQuat, after: DQuat, rest: DQuat, compliance: DVec3) -> Spring {
    let p = before.conjugate() * after;
    let derivative =
        (DMat3::from_diagonal(DVec3::splat(p.w)) - cross_matrix(p.xyz())) * DMat3::from_quat(before).transpose() * 0.5;
    spring(derivative, compliance, gap(before, after, rest))
}

pub(super) fn vector(turn: DVec3, shift: DVec3) -> Vector6<f64> {
    Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
}

/// The turn and the shift of a 6-vector.
fn parts(v: &Vector6<f64>) -> (DVec3, DVec3) {
    (DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5]))
}

/// Adds a block of three rows and columns to a 6 × 6 matrix; `at` is 0 for turns and 3 for shifts.
pub(super) fn add(matrix: &mut Matrix6<f64>, at: (usize, usize), block: DMat3) {
    for row in 0..3 {
        for column in 0..3 {
            matrix[(at.0 + row, at.1 + column)] += block.col(column)[row];
        }
    }
}

/// A block of three rows and columns of a 6 × 6 matrix.
fn block(matrix: &Matrix6<f64>, at: (usize, usize)) -> DMat3 {
    let column = |c: usize| DVec3::from_array([0, 1, 2].map(|row| matrix[(at.0 + row, at.1 + c)]));
    DMat3::from_cols(column(0), column(1), column(2))
}

/// Adds a force to the first of four vectors.
pub(super) fn add_force(vectors: &mut Matrix6x4<f64>, force: Vector6<f64>) {
    vectors.set_column(0, &(vectors.column(0) + force));
}

/// Force that what lies beyond a segment passes on through its stretch.
fn passed(matrix: &Matrix6<f64>, vectors: &Matrix6x4<f64>, stretch: &Spring) -> DVec3 {
    let (moves, force) = (block(matrix, (3, 3)), parts(&vectors.column(0).into()).1);
    force - moves * ((moves + stretch.stiffness).inverse() * (force + stretch.force))
}

impl Rod<'_> {
    fn ends(&self) -> windswept_scene::Ends {
        self.hair.ends(self.strand)
    }

    pub(super) fn of_segment(&self, k: usize) -> usize {
        self.hair.segments(self.strand).start + k
    }

    /// One Newton step; returns its largest turn of a frame \[rad\], or change of a strain.
    fn newton_step(&mut self, steep: bool) -> f64 {
        let mut vectors = Matrix6x4::zeros();
        vectors.fixed_view_mut::<3, 3>(3, 1).fill_with_identity();
        vectors.set_column(0, &vector(DVec3::ZERO, self.motion.tip_force));
        let mut beyond = Beyond { matrix: Matrix6::zeros(), vectors };
        if self.ends().tip == End::Clamped {
            let ends = self.ends();
            let last = self.segments[self.segments.len() - 1].frame;
            let tip = joint(last, self.motion.tip_frame, ends.tip_rest_rotation, ends.tip_compliance);
            add(&mut beyond.matrix, (0, 0), tip.stiffness);
            add_force(&mut beyond.vectors, vector(-tip.force, DVec3::ZERO));
        }
        let mut answers: Vec<Answer> = Vec::new();
        for k in (0..self.segments.len()).rev() {
            let (answer, before) = self.answer(k, beyond, steep);
            beyond = before;
            answers.push(answer);
        }
        answers.reverse();
        let root_moves = self.root_moves(&beyond);
        let (change, part) = self.tip_change(&answers, &root_moves);
        let most = self.apply(&answers, &root_moves, Vector4::new(1.0, change.x, change.y, change.z), part);
        self.motion.tip_force += part * change;
        let tip = &self.points[self.points.len() - 1];
        let length: f64 = self.hair.rest_length[self.hair.segments(self.strand)].iter().sum();
        if tip.inverse_mass == 0.0 { most.max((tip.displacement - tip.free).length() / length) } else { most }
    }

    /// Answer of joint and segment `k`, with `after` beyond the segment; and what lies beyond the joint then.
    fn answer(&self, k: usize, after: Beyond, steep: bool) -> (Answer, Beyond) {
        let (j, segment, end) = (self.of_segment(k), &self.segments[k], &self.points[k + 1]);
        let (l, axes) = (self.hair.rest_length[j], DMat3::from_quat(segment.frame));
        let stretch = spring(
            axes.transpose() * (1.0 / l),
            self.hair.stretch_compliance[j],
            segment.frame.conjugate() * segment.strain / l,
        );
        let Beyond { mut matrix, mut vectors } = after;
        let mass = if end.inverse_mass > 0.0 { 1.0 / end.effective_inverse_mass(self.p) } else { 0.0 };
        add(&mut matrix, (3, 3), DMat3::from_diagonal(DVec3::splat(mass)));
        add_force(&mut vectors, vector(DVec3::ZERO, mass * (end.displacement - end.free)));
        self.push_point(k + 1, &mut matrix, &mut vectors);
        let passed = passed(&matrix, &vectors, &stretch);

        // From the segment's end to its first point: s' = T (s + z).
        let arm = l * axes.z_axis + segment.strain;
        let mut transport = Matrix6::identity();
        add(&mut transport, (3, 0), -cross_matrix(arm));
        (matrix, vectors) = (transport.transpose() * matrix * transport, transport.transpose() * vectors);
        let (contacts, push) = self.push_segment(k, arm);
        // The pull of what lies beyond, which the frame resists turning off.
        let pull = -(passed + parts(&push).1);
        let tension = l * if steep { pull.length() } else { pull.dot(axes.z_axis).max(0.0) };
        let inertia = 1.0 / (response(self.p.rods.damping, segment.step) * self.hair.inverse_inertia[j]);
        let off = segment.turn * segment.free.conjugate();
        let cross = cross_matrix(axes.z_axis);
        add(&mut matrix, (0, 0), DMat3::from_diagonal(DVec3::splat(inertia)) - cross * cross * tension);
        add_force(&mut vectors, vector(2.0 * inertia * off.w.signum() * off.xyz(), DVec3::ZERO));

        // Of z, contacts feel the turn alone.
        let turns = Matrix6::from_diagonal(&Vector6::new(1.0, 1.0, 1.0, 0.0, 0.0, 0.0));
        let mut springs = turns * contacts * turns;
        let mut forces = vectors;
        add_force(&mut forces, turns * push);
        add(&mut springs, (3, 3), stretch.stiffness);
        add_force(&mut forces, vector(DVec3::ZERO, stretch.force));
        if k > 0 || self.ends().root == End::Clamped {
            let before = if k > 0 { self.segments[k - 1].frame } else { self.motion.root_frame };
            let bend = joint(before, segment.frame, self.hair.rest_rotation[j], self.hair.bend_compliance[j]);
            add(&mut springs, (0, 0), bend.stiffness);
            add_force(&mut forces, vector(bend.force, DVec3::ZERO));
        }
        let factors =
            (springs + matrix).cholesky().unwrap_or_else(|| panic!("segment {k}: the Hessian is not positive"));
        let by_state = matrix + turns * contacts;
        let (constant, gain) = (-factors.solve(&forces), -factors.solve(&by_state));
        let before = matrix + contacts + by_state.transpose() * gain;
        let mut before =
            Beyond { matrix: (before + before.transpose()) * 0.5, vectors: vectors + by_state.transpose() * constant };
        add_force(&mut before.vectors, push);
        (Answer { constant, gain, beyond: Beyond { matrix, vectors }, stretch }, before)
    }

    /// Moves of the root's point by a Newton step, of (1, λ); 0 where it is held.
    fn root_moves(&self, root: &Beyond) -> Matrix6x4<f64> {
        let (first, mut moves) = (&self.points[0], Matrix6x4::zeros());
        if first.inverse_mass > 0.0 {
            let mass = 1.0 / first.effective_inverse_mass(self.p);
            let Beyond { mut matrix, mut vectors } = *root;
            add_force(&mut vectors, vector(DVec3::ZERO, mass * (first.displacement - first.free)));
            add(&mut matrix, (3, 3), DMat3::from_diagonal(DVec3::splat(mass)));
            self.push_point(0, &mut matrix, &mut vectors);
            let all = block(&matrix, (3, 3)).inverse();
            for column in 0..4 {
                moves.set_column(column, &vector(DVec3::ZERO, -(all * parts(&vectors.column(column).into()).1)));
            }
        }
        moves
    }

    /// Change of the force on a held tip with which a Newton step brings the tip to its place \[N\], and the part of
    /// the step that is taken: the whole of it is cut, since joints that are cut by themselves lead the tip away.
    fn tip_change(&self, answers: &[Answer], root_moves: &Matrix6x4<f64>) -> (DVec3, f64) {
        let tip = &self.points[self.points.len() - 1];
        if tip.inverse_mass > 0.0 {
            return (DVec3::ZERO, 1.0);
        }
        let (mut states, mut turns) = (*root_moves, Vec::new());
        for (k, answer) in answers.iter().enumerate() {
            let segment = &self.segments[k];
            let arm = self.rest_length(k) * (segment.frame * DVec3::Z) + segment.strain;
            let mut transport = Matrix6::identity();
            add(&mut transport, (3, 0), -cross_matrix(arm));
            states = transport * (states + answer.constant + answer.gain * states);
            turns.push(states);
        }
        let column = |c: usize| parts(&states.column(c).into()).1;
        let by_force = DMat3::from_cols(column(1), column(2), column(3));
        let change = -(by_force.inverse() * (tip.displacement - tip.free + column(0)));
        let both = Vector4::new(1.0, change.x, change.y, change.z);
        let most = turns.iter().map(|states| parts(&(states * both)).0.length()).fold(0.0, f64::max);
        (change, (HELD_TURN / most).min(1.0))
    }

    /// Turns frames and strains by a part of a Newton step, and places the points that follow from them. Returns the
    /// largest turn of a frame \[rad\] or change of a strain, as if turns were not cut.
    fn apply(&mut self, answers: &[Answer], root_moves: &Matrix6x4<f64>, tip: Vector4<f64>, part: f64) -> f64 {
        let mut most = 0.0_f64;
        let (mut turn, mut shift) = parts(&(root_moves * tip));
        self.points[0].displacement += part * shift;
        self.foresee_point(0, shift);
        let cut = |v: DVec3, longest: f64| if part < 1.0 { v } else { v.clamp_length_max(longest) };
        for (k, answer) in answers.iter().enumerate() {
            let (l, segment) = (self.rest_length(k), self.segments[k]);
            let arm = l * (segment.frame * DVec3::Z) + segment.strain;
            let (bend, _) = parts(&(answer.constant * tip + answer.gain * vector(turn, shift)));
            turn = cut(turn + cut(bend, TURN), std::f64::consts::PI);
            self.foresee_segment(k, shift, turn.cross(arm));
            // The segment's stretch, given the turn of its joint as it was cut.
            let Beyond { matrix, vectors } = &answer.beyond;
            let at_end = parts(&(vectors * tip + matrix * vector(turn, shift))).1 + answer.stretch.force;
            let stretch = -((block(matrix, (3, 3)) + answer.stretch.stiffness).inverse() * at_end);
            shift += turn.cross(arm) + stretch;
            self.foresee_point(k + 1, shift);
            let rotated = rotation(part * turn);
            let strain = (segment.strain + part * stretch).clamp_length_max(WHOLE * l);
            most = most.max(turn.length()).max((strain - segment.strain).length() / l);
            let segment = &mut self.segments[k];
            segment.strain = rotated * strain;
            segment.turn = (rotated * segment.turn).normalize();
            segment.frame = (segment.turn * segment.start).normalize();
        }
        self.chain();
        most
    }

    /// Points follow from frames and strains: x_{k+1} = x_k + l d₃ + u, in moves since the step's start.
    fn chain(&mut self) {
        for k in 0..self.segments.len() {
            let segment = &self.segments[k];
            let l = self.hair.rest_length[self.of_segment(k)];
            let now = l * (segment.frame * DVec3::Z) + segment.strain;
            self.points[k + 1].displacement = self.points[k].displacement + now - segment.chord;
        }
    }

    /// Hair that comes out of a body goes its way through the step, beside that of its root, only in part, so that no
    /// point of it is faster than [`RECOVERY`]: all frames turn by that part.
    fn crawl(&mut self) {
        let root = self.points[0].displacement;
        let far = self.points.iter().map(|point| point.displacement.distance(root)).fold(0.0, f64::max);
        let part = (RECOVERY * self.p.step / far).min(1.0);
        for segment in &mut *self.segments {
            let turn = rotation(part * rotation_vector(segment.turn));
            segment.strain = turn * (segment.turn.conjugate() * segment.strain);
            (segment.turn, segment.frame) = (turn, (turn * segment.start).normalize());
        }
        self.chain();
    }

    /// A strand that nothing holds and that touches nothing keeps its momentum. The rest of the way to a held tip is
    /// spread over the points.
    fn finish(&mut self, touches: bool) {
        let last = self.points.len() - 1;
        let (root, tip) = (self.points[0].inverse_mass, self.points[last].inverse_mass);
        if tip == 0.0 {
            let gap = self.points[last].displacement - self.points[last].free;
            for k in 1..=last {
                self.points[k].displacement -= k as f64 / last as f64 * gap;
            }
        } else if root > 0.0 && !touches {
            let mass = |point: &Point| 1.0 / point.effective_inverse_mass(self.p);
            let all: f64 = self.points.iter().map(mass).sum();
            let momentum: DVec3 = self.points.iter().map(|point| mass(point) * (point.displacement - point.free)).sum();
            self.points.iter_mut().for_each(|point| point.displacement -= momentum / all);
        }
    }
}
