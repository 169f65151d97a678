//! Newton steps on the incremental potential of a strand, each solved by a Riccati recursion over 6-vectors.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix6, Vector6};
use windswept_scene::{End, Strands};

use super::{Drive, Moving, Point, Segment, State, cross_matrix, nearest_rest, response, rotation};
use crate::Parameters;

/// Strain |u|/l of a segment beyond which a start is made whole, and no solve ends.
pub const WHOLE: f64 = 0.01;
/// Largest turn of a frame at first, and of a joint in a Newton step \[rad\].
pub const TURN: f64 = 1.0;
/// Turn of a frame \[rad\], and change of a strain, in a Newton step that is the last,
pub const SETTLED: f64 = 1e-3;
/// or this part of that in the first one.
pub const RELATIVE: f64 = 1e-2;
/// Smallest compliance that counts \[1/(N m)\],
const STIFFEST: f64 = 1e-6;
/// and smallest part of the largest of a spring's, as the engine needs it in f32.
const UNEVEN: f64 = 1e-3;
/// Mass of a held tip, over the square of the step, over the stiffness of the stiffest segment.
const HEAVY: f64 = 1e6;

/// A strand within a step.
struct Rod<'a> {
    p: &'a Parameters,
    hair: &'a Strands,
    strand: usize,
    points: &'a mut [Point],
    segments: &'a mut [Segment],
    drive: &'a mut Drive,
}

/// A spring between two frames or along a segment: its stiffness and the moment or force by which it resists.
struct Spring {
    stiffness: DMat3,
    force: DVec3,
}

/// Answer z = −(K + Q)⁻¹ (f + q + Q s) of a joint and its segment to the state s before it, with what clamped joints need of it.
struct Answer {
    constant: Vector6<f64>,
    gain: Matrix6<f64>,
    /// Q and q at the segment's first point.
    beyond: (Matrix6<f64>, Vector6<f64>),
    stretch: Spring,
}

/// Solves strand `s`: Newton steps until frames and strains have settled, or as many as there are.
///
/// ```text
///   Φ = Σ |x_i − free_i|²/(2 W_i) + Σ 4 J_k (1 − |p_w|) + Σ ½ εᵀ α_s⁻¹ ε + Σ ½ Cᵀ α_b⁻¹ C      ε = Rᵀ u/l, J = 1/W of a frame
/// ```
/// with p = turn · conj(free turn) and C = Im(q̄₀ q₁) − s Im(rest). The unknowns are frames and strains u = chord − l d₃, from which
/// points follow.
///
/// # Panics
/// When a Newton step is no direction in which the potential falls.
pub fn solve(p: &Parameters, hair: &Strands, s: usize, drive: &mut Drive, m: &mut Moving) {
    if drive.state != State::Free {
        return;
    }
    let mut rod = Rod {
        p,
        hair,
        strand: s,
        points: &mut m.points[hair.points(s)],
        segments: &mut m.segments[hair.segments(s)],
        drive,
    };
    let (mut steep, mut settled) = (false, SETTLED);
    for step in 0..p.newton_steps {
        let most = rod.newton_step(steep);
        if step == 0 {
            settled = SETTLED.max(RELATIVE * most);
        }
        if most < settled {
            rod.drive.state = State::Solved;
            break;
        }
        steep = most > TURN;
    }
    rod.finish();
}

/// The incremental potential Φ of strand `s` where the solve has it \[J s²\], without a held tip.
#[must_use]
pub fn potential(p: &Parameters, hair: &Strands, s: usize, drive: &Drive, m: &Moving) -> f64 {
    let (points, segments) = (&m.points[hair.points(s)], &m.segments[hair.segments(s)]);
    let reply = |point: &Point| point.reply(p);
    let moved = points.iter().filter(|point| point.inverse_mass > 0.0);
    let mut sum: f64 = moved.map(|point| (point.travel - point.free).length_squared() / (2.0 * reply(point))).sum();
    let first = hair.segments(s).start;
    for (k, segment) in segments.iter().enumerate() {
        let off = segment.turn * segment.free.conjugate();
        let inertia = 1.0 / (response(p.damping, segment.step) * hair.inverse_inertia[first + k]);
        sum += 4.0 * inertia * (1.0 - off.w.abs());
        let strain = segment.frame.conjugate() * segment.strain / hair.rest_length[first + k];
        sum += 0.5 * (strain * strain * stiffness(hair.stretch_compliance[first + k])).element_sum();
        if k > 0 || hair.ends(s).root == End::Clamped {
            let before = if k > 0 { segments[k - 1].frame } else { drive.root_frame };
            let gap = gap(before, segment.frame, hair.rest_rotation[first + k]);
            sum += 0.5 * (gap * gap * stiffness(hair.bend_compliance[first + k])).element_sum();
        }
    }
    if hair.ends(s).tip == End::Clamped {
        let ends = hair.ends(s);
        let gap = gap(segments[segments.len() - 1].frame, ends.tip_frame, ends.tip_rest_rotation);
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

fn vector(turn: DVec3, shift: DVec3) -> Vector6<f64> {
    Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
}

/// The turn and the shift of a 6-vector.
fn parts(v: &Vector6<f64>) -> (DVec3, DVec3) {
    (DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5]))
}

/// Adds a block of three rows and columns to a 6 × 6 matrix; `at` is 0 for turns and 3 for shifts.
fn add(matrix: &mut Matrix6<f64>, at: (usize, usize), block: DMat3) {
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

/// A strand from tip to root.
struct Eliminated {
    answers: Vec<Answer>,
    /// Pull of what lies beyond each segment \[N\].
    pulls: Vec<DVec3>,
    /// Decrease of the potential by the Newton step, to first order \[J s²\].
    decrease: f64,
    /// P and p at the root.
    root: (Matrix6<f64>, Vector6<f64>),
}

impl Rod<'_> {
    fn ends(&self) -> windswept_scene::Ends {
        self.hair.ends(self.strand)
    }

    fn of_segment(&self, k: usize) -> usize {
        self.hair.segments(self.strand).start + k
    }

    /// One Newton step; returns its largest turn of a frame \[rad\], or change of a strain.
    fn newton_step(&mut self, steep: bool) -> f64 {
        let held = self.points[self.points.len() - 1].inverse_mass == 0.0;
        // Tensions are those under the force that holds a held tip so far. Then the tip is a point of large mass.
        let light = self.eliminate(steep, None);
        let eliminated = if held { self.eliminate(steep, Some(&light.pulls)) } else { light };
        assert!(!(eliminated.decrease < 0.0), "the potential rises by {}", -eliminated.decrease);
        if held {
            self.drive.tip_force += self.heavy() * self.tip_gap(&eliminated);
        }
        self.apply(&eliminated.answers, &eliminated.root)
    }

    /// Answers of all joints and segments. With the pulls on segments that are known, a held tip is a point of large mass; else it is free.
    fn eliminate(&self, steep: bool, pulls: Option<&[DVec3]>) -> Eliminated {
        let mut beyond = (Matrix6::zeros(), vector(DVec3::ZERO, self.drive.tip_force));
        if self.ends().tip == End::Clamped {
            let ends = self.ends();
            let last = self.segments[self.segments.len() - 1].frame;
            let tip = joint(last, ends.tip_frame, ends.tip_rest_rotation, ends.tip_compliance);
            add(&mut beyond.0, (0, 0), tip.stiffness);
            beyond.1 -= vector(tip.force, DVec3::ZERO);
        }
        let mut all = Eliminated { answers: Vec::new(), pulls: Vec::new(), decrease: 0.0, root: beyond };
        for k in (0..self.segments.len()).rev() {
            let (answer, pull, after) = self.answer(k, all.root, steep, pulls.map(|pulls| pulls[k]), &mut all.decrease);
            all.root = after;
            all.answers.push(answer);
            all.pulls.push(pull);
        }
        all.answers.reverse();
        all.pulls.reverse();
        all
    }

    /// Mass of a held tip over the square of the step \[kg/s²\].
    fn heavy(&self) -> f64 {
        HEAVY * self.stiffest()
    }

    /// Way that is left to a held tip's place after a Newton step that is not cut \[m\].
    fn tip_gap(&self, eliminated: &Eliminated) -> DVec3 {
        let mut state = vector(DVec3::ZERO, self.root_move(&eliminated.root));
        for (k, answer) in eliminated.answers.iter().enumerate() {
            let segment = &self.segments[k];
            let arm = self.hair.rest_length[self.of_segment(k)] * (segment.frame * DVec3::Z) + segment.strain;
            let (turn, shift) = parts(&(state + answer.constant + answer.gain * state));
            state = vector(turn, shift + turn.cross(arm));
        }
        let tip = &self.points[self.points.len() - 1];
        tip.travel - tip.free + parts(&state).1
    }

    /// Move of the root's point by a Newton step; 0 where it is held.
    fn root_move(&self, root: &(Matrix6<f64>, Vector6<f64>)) -> DVec3 {
        let first = &self.points[0];
        if first.inverse_mass == 0.0 {
            return DVec3::ZERO;
        }
        let mass = 1.0 / first.reply(self.p);
        let all = block(&root.0, (3, 3)) + DMat3::from_diagonal(DVec3::splat(mass));
        -(all.inverse() * (parts(&root.1).1 + mass * (first.travel - first.free)))
    }

    /// Answer of joint and segment `k`, when `after` (P, p) is what lies beyond the segment, ½ sᵀ P s + pᵀ s; and what lies beyond the
    /// joint then. Adds to `decrease` what the step lowers the potential by, to first order.
    fn answer(
        &self,
        k: usize,
        after: (Matrix6<f64>, Vector6<f64>),
        steep: bool,
        pull: Option<DVec3>,
        decrease: &mut f64,
    ) -> (Answer, DVec3, (Matrix6<f64>, Vector6<f64>)) {
        let (j, segment, end) = (self.of_segment(k), &self.segments[k], &self.points[k + 1]);
        let (l, axes) = (self.hair.rest_length[j], DMat3::from_quat(segment.frame));
        let stretch = spring(
            axes.transpose() * (1.0 / l),
            self.hair.stretch_compliance[j],
            segment.frame.conjugate() * segment.strain / l,
        );
        let (mut q_matrix, mut q_vector) = after;
        let mass = match (end.inverse_mass > 0.0, pull) {
            (true, _) => 1.0 / end.reply(self.p),
            (false, Some(_)) => self.heavy(),
            (false, None) => 0.0,
        };
        add(&mut q_matrix, (3, 3), DMat3::from_diagonal(DVec3::splat(mass)));
        q_vector += vector(DVec3::ZERO, mass * (end.travel - end.free));

        // From the segment's end to its first point: s' = T (s + z).
        let arm = l * axes.z_axis + segment.strain;
        let mut carried = Matrix6::identity();
        add(&mut carried, (3, 0), -cross_matrix(arm));
        // The pull of what lies beyond, which the frame resists turning off.
        let pull = pull.unwrap_or_else(|| -self.passed(&q_matrix, &q_vector, &stretch));
        let (q_matrix, q_vector) = (carried.transpose() * q_matrix * carried, carried.transpose() * q_vector);
        let mut own = q_matrix;
        let mut own_vector = q_vector;
        let inertia = self.inertia(k);
        let off = segment.turn * segment.free.conjugate();
        let tension = l * if steep { pull.length() } else { pull.dot(axes.z_axis).max(0.0) };
        let across = DMat3::IDENTITY
            - DMat3::from_cols(axes.z_axis * axes.z_axis.x, axes.z_axis * axes.z_axis.y, axes.z_axis * axes.z_axis.z);
        add(&mut own, (0, 0), DMat3::from_diagonal(DVec3::splat(inertia)) + across * tension);
        own_vector += vector(2.0 * inertia * off.w.signum() * off.xyz(), DVec3::ZERO);

        let mut springs = Matrix6::zeros();
        let mut forces = vector(DVec3::ZERO, stretch.force);
        add(&mut springs, (3, 3), stretch.stiffness);
        if k > 0 || self.ends().root == End::Clamped {
            let before = if k > 0 { self.segments[k - 1].frame } else { self.drive.root_frame };
            let bend = joint(before, segment.frame, self.hair.rest_rotation[j], self.hair.bend_compliance[j]);
            add(&mut springs, (0, 0), bend.stiffness);
            forces += vector(bend.force, DVec3::ZERO);
        }
        let factors = (springs + own).cholesky().unwrap_or_else(|| panic!("segment {k}: the Hessian is not positive"));
        let constant = -factors.solve(&(forces + own_vector));
        let gain = -factors.solve(&own);
        *decrease -= constant.dot(&(forces + own_vector));
        let before = (own + own * gain, own_vector + own * constant);
        let symmetric = (before.0 + before.0.transpose()) * 0.5;
        (Answer { constant, gain, beyond: (own, own_vector), stretch }, pull, (symmetric, before.1))
    }

    /// Force that what lies beyond a segment passes on through its stretch, at the segment's first point.
    fn passed(&self, matrix: &Matrix6<f64>, vector: &Vector6<f64>, stretch: &Spring) -> DVec3 {
        let (moves, force) = (block(matrix, (3, 3)), parts(vector).1);
        force - moves * ((moves + stretch.stiffness).inverse() * (force + stretch.force))
    }

    fn inertia(&self, k: usize) -> f64 {
        1.0 / (response(self.p.damping, self.segments[k].step) * self.hair.inverse_inertia[self.of_segment(k)])
    }

    /// Stiffness of the stiffest segment \[N/m\].
    fn stiffest(&self) -> f64 {
        let of = |k: usize| {
            let l = self.hair.rest_length[k];
            stiffness(self.hair.stretch_compliance[k]).max_element() / (l * l)
        };
        self.hair.segments(self.strand).map(of).fold(0.0, f64::max)
    }

    /// Turns frames and strains by a Newton step, and places the points that follow from them.
    fn apply(&mut self, answers: &[Answer], root: &(Matrix6<f64>, Vector6<f64>)) -> f64 {
        let mut most = 0.0_f64;
        let (mut turn, mut shift) = (DVec3::ZERO, self.root_move(root));
        self.points[0].travel += shift;
        for (k, answer) in answers.iter().enumerate() {
            let j = self.of_segment(k);
            let l = self.hair.rest_length[j];
            let segment = &mut self.segments[k];
            let arm = l * (segment.frame * DVec3::Z) + segment.strain;
            let (bend, _) = parts(&(answer.constant + answer.gain * vector(turn, shift)));
            let turned = (turn + bend.clamp_length_max(TURN)).clamp_length_max(std::f64::consts::PI);
            // The segment's stretch, given the turn of its joint as it was cut.
            let (own, own_vector) = &answer.beyond;
            let at_end = parts(&(own_vector + own * vector(turned, shift))).1 + answer.stretch.force;
            let stretch = -((block(own, (3, 3)) + answer.stretch.stiffness).inverse() * at_end);
            (turn, shift) = (turned, shift + turned.cross(arm) + stretch);
            let rotated = rotation(turn);
            let strain = (segment.strain + stretch).clamp_length_max(WHOLE * l);
            most = most.max(turn.length()).max((strain - segment.strain).length() / l);
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
            self.points[k + 1].travel = self.points[k].travel + now - segment.chord;
        }
    }

    /// A strand that nothing holds keeps its momentum. What is left of the way to a held tip is spread over the points.
    fn finish(&mut self) {
        let last = self.points.len() - 1;
        let (root, tip) = (self.points[0].inverse_mass, self.points[last].inverse_mass);
        if tip == 0.0 {
            let gap = self.points[last].travel - self.points[last].free;
            for k in 1..=last {
                self.points[k].travel -= k as f64 / last as f64 * gap;
            }
        } else if root > 0.0 {
            let mass = |point: &Point| 1.0 / point.reply(self.p);
            let all: f64 = self.points.iter().map(mass).sum();
            let momentum: DVec3 = self.points.iter().map(|point| mass(point) * (point.travel - point.free)).sum();
            self.points.iter_mut().for_each(|point| point.travel -= momentum / all);
        }
    }
}
