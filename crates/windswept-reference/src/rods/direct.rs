//! One Newton step of the dual system of a strand, as a banded matrix and its Cholesky factors.

use glam::{DMat3, DQuat, DVec3};
use windswept_scene::{End, Strands};

use super::{Drive, Moving, Point, Segment, State, cross_matrix, damping, nearest_rest, response, rotation};
use crate::Parameters;

/// Gap |C + α μ| of stretch-shear below which a strand fits.
pub const FITS: f64 = 1e-5;
/// Part of the diagonal of J W Jᵀ that is added to it in the rows of stretch-shear, as the engine needs it in f32.
const GIVE: f64 = 2e-7;
/// A strand of more points is solved once more when it fits, as the engine needs it in f32.
const FEW_POINTS: usize = 65;
/// Residual below which a strand need not be solved; see `quiet_below`.
pub const QUIET: f64 = 1e-6;

/// Part of a strand that can move: a point, or a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mover {
    Point(usize),
    Frame(usize),
}

/// Constraint of three rows, C = 0: a joint's bend-twist, or a segment's stretch-shear.
struct Constraint {
    gradient: Vec<(Mover, DMat3)>,
    /// Gap C.
    gap: DVec3,
    compliance: DMat3,
    /// Multiplier μ \[N m\].
    multiplier: DVec3,
    holds: Holds,
}

enum Holds {
    Joint(usize),
    Segment(usize),
    Tip,
}

/// Strand within a step.
struct Rod<'a> {
    p: &'a Parameters,
    hair: &'a Strands,
    strand: usize,
    points: &'a mut [Point],
    segments: &'a mut [Segment],
    drive: &'a mut Drive,
}

/// Solves one Newton step of strand `s`, unless it is done: solved, or (with `rods.sleep`) nowhere off by more than `quiet_below`.
/// Returns whether it was quiet.
pub fn direct(p: &Parameters, hair: &Strands, s: usize, drive: &mut Drive, m: &mut Moving) -> bool {
    let first = drive.state == State::Free;
    if !first && drive.state != State::Fitted {
        return false;
    }
    let mut rod = Rod {
        p,
        hair,
        strand: s,
        points: &mut m.points[hair.points(s)],
        segments: &mut m.segments[hair.segments(s)],
        drive,
    };
    let constraints = rod.constraints();
    let right: Vec<DVec3> = rod.residuals(&constraints);
    let quiet = quiet_below(p, hair, s);
    if first && p.sleep && right.iter().all(|r| r.length() < quiet) && rod.still_to_go(&constraints) < quiet {
        rod.drive.state = State::Solved;
        return true;
    }
    let changes = rod.system(&constraints).solve(&right);
    rod.apply(constraints, &changes);
    rod.drive.misfit = rod.stretch_gap();
    let once_more = first && rod.points.len() > FEW_POINTS;
    let done = rod.drive.misfit < FITS || !first && rod.drive.misfit < super::MISFIT;
    rod.drive.state = match done {
        true if once_more => State::Fitted,
        true => State::Solved,
        false => State::Free,
    };
    false
}

/// Residual below which a strand is quiet. A residual that is left out of every step, however short the step is, must not add
/// up to a push that wakes a sleeper.
fn quiet_below(p: &Parameters, hair: &Strands, s: usize) -> f64 {
    let lengths = &hair.rest_length[hair.segments(s)];
    let mean_segment = lengths.iter().sum::<f64>() / lengths.len() as f64;
    QUIET.min(p.rest[s].acceleration * p.step * p.step / mean_segment)
}

impl Rod<'_> {
    /// Constraints of joints and segments in turn, from the clamp to the tip; dC of the frames is in world rotation vectors.
    fn constraints(&self) -> Vec<Constraint> {
        let first = self.hair.segments(self.strand).start;
        let ends = self.hair.ends(self.strand);
        let mut all = Vec::new();
        for k in 0..self.segments.len() {
            let segment = &self.segments[k];
            if k > 0 || ends.root == End::Clamped {
                let before = if k > 0 { self.segments[k - 1].frame } else { self.drive.root_frame };
                let (gap, gradient) = bend_twist(before, segment.frame, self.hair.rest_rotation[first + k]);
                let mut movers = vec![(Mover::Frame(k), gradient)];
                if k > 0 {
                    movers.push((Mover::Frame(k - 1), -gradient));
                }
                all.push(Constraint {
                    gradient: movers,
                    gap,
                    compliance: DMat3::from_diagonal(self.hair.bend_compliance[first + k]),
                    multiplier: segment.moment,
                    holds: Holds::Joint(k),
                });
            }
            let l = self.hair.rest_length[first + k];
            let frame = DMat3::from_quat(segment.frame);
            let chord = segment.chord + self.points[k + 1].travel - self.points[k].travel;
            all.push(Constraint {
                gradient: vec![
                    (Mover::Point(k), DMat3::IDENTITY * (-1.0 / l)),
                    (Mover::Point(k + 1), DMat3::IDENTITY / l),
                    (Mover::Frame(k), cross_matrix(frame.z_axis)),
                ],
                gap: chord / l - frame.z_axis,
                compliance: frame * DMat3::from_diagonal(self.hair.stretch_compliance[first + k]) * frame.transpose(),
                multiplier: segment.force,
                holds: Holds::Segment(k),
            });
        }
        if ends.tip == End::Clamped {
            let last = self.segments.len() - 1;
            let (gap, gradient) = bend_twist(self.segments[last].frame, ends.tip_frame, ends.tip_rest_rotation);
            all.push(Constraint {
                gradient: vec![(Mover::Frame(last), -gradient)],
                gap,
                compliance: DMat3::from_diagonal(ends.tip_compliance),
                multiplier: self.drive.tip_moment,
                holds: Holds::Tip,
            });
        }
        all
    }

    /// Weight W: the move of `mover` by a force, or a moment. A frame under tension resists turning off the pull.
    fn weight(&self, mover: Mover) -> DMat3 {
        match mover {
            Mover::Point(k) => {
                let point = &self.points[k];
                DMat3::IDENTITY * (response(damping(self.p, point), point.step) * point.inverse_mass)
            }
            Mover::Frame(k) => {
                let segment = &self.segments[k];
                let w = self.frame_weight(k);
                let d3 = segment.frame * DVec3::Z;
                let tension = (-d3.dot(segment.force)).max(0.0);
                let along = DMat3::from_cols(d3 * d3.x, d3 * d3.y, d3 * d3.z);
                (DMat3::IDENTITY - along) * (w / (1.0 + w * tension)) + along * w
            }
        }
    }

    fn frame_weight(&self, k: usize) -> f64 {
        let first = self.hair.segments(self.strand).start;
        response(self.p.damping, self.segments[k].step) * self.hair.inverse_inertia[first + k]
    }

    /// Excesses of points and frames: their distances from where their free moves and the multipliers have them.
    fn excess(&self, constraints: &[Constraint]) -> (Vec<DVec3>, Vec<DVec3>) {
        let mut points = vec![DVec3::ZERO; self.points.len()];
        let mut frames = vec![DVec3::ZERO; self.segments.len()];
        for c in constraints {
            for (mover, gradient) in &c.gradient {
                let pull = gradient.transpose() * c.multiplier;
                match *mover {
                    Mover::Point(k) => points[k] += pull,
                    Mover::Frame(k) => frames[k] += pull,
                }
            }
        }
        for (k, (pull, point)) in points.iter_mut().zip(&*self.points).enumerate() {
            *pull = point.free + self.weight(Mover::Point(k)) * *pull - point.travel;
        }
        for (k, (pull, segment)) in frames.iter_mut().zip(&*self.segments).enumerate() {
            let w = self.frame_weight(k);
            *pull = self.weight(Mover::Frame(k)) / w * (segment.free + w * *pull - segment.turn);
        }
        (points, frames)
    }

    /// Largest excess: of points in lengths of the segment before, and of frames. A strand that falls as it is has no residual.
    fn still_to_go(&self, constraints: &[Constraint]) -> f64 {
        let (points, frames) = self.excess(constraints);
        let lengths = &self.hair.rest_length[self.hair.segments(self.strand)];
        let points = points[1..].iter().zip(lengths).map(|(excess, l)| excess.length() / l);
        points.chain(frames.iter().map(|excess| excess.length())).fold(0.0, f64::max)
    }

    /// Residuals −(C + α μ + J excess).
    fn residuals(&self, constraints: &[Constraint]) -> Vec<DVec3> {
        let (points, frames) = self.excess(constraints);
        let moved = |(mover, gradient): &(Mover, DMat3)| match *mover {
            Mover::Point(k) => *gradient * points[k],
            Mover::Frame(k) => *gradient * frames[k],
        };
        let each =
            |c: &Constraint| -(c.gap + c.compliance * c.multiplier + c.gradient.iter().map(moved).sum::<DVec3>());
        constraints.iter().map(each).collect()
    }

    /// System J W Jᵀ + α.
    fn system(&self, constraints: &[Constraint]) -> Banded {
        let mut matrix = Banded::new(3 * constraints.len());
        for (i, a) in constraints.iter().enumerate() {
            for (j, b) in constraints.iter().enumerate().take(i + 1).skip(i.saturating_sub(2)) {
                let mut block = if i == j { a.compliance } else { DMat3::ZERO };
                for (mover, ga) in &a.gradient {
                    for (_, gb) in b.gradient.iter().filter(|(other, _)| other == mover) {
                        let give = if i == j && matches!(a.holds, Holds::Segment(_)) { 1.0 + GIVE } else { 1.0 };
                        block += *ga * self.weight(*mover) * gb.transpose() * give;
                    }
                }
                matrix.add(3 * i, 3 * j, block);
            }
        }
        matrix
    }

    fn apply(&mut self, mut constraints: Vec<Constraint>, changes: &[DVec3]) {
        for (c, change) in constraints.iter_mut().zip(changes) {
            c.multiplier += *change;
        }
        let (moves, turns) = self.excess(&constraints);
        self.points.iter_mut().zip(moves).for_each(|(point, excess)| point.travel += excess);
        for (segment, excess) in self.segments.iter_mut().zip(turns) {
            segment.turn += excess;
            segment.frame = (rotation(segment.turn) * segment.start).normalize();
        }
        for c in &constraints {
            match c.holds {
                Holds::Joint(k) => self.segments[k].moment = c.multiplier,
                Holds::Segment(k) => self.segments[k].force = c.multiplier,
                Holds::Tip => self.drive.tip_moment = c.multiplier,
            }
        }
    }

    /// Largest gap |C + α μ| of stretch-shear.
    fn stretch_gap(&self) -> f64 {
        let gaps = self.constraints().into_iter().filter(|c| matches!(c.holds, Holds::Segment(_)));
        let lengths = gaps.map(|c| (c.gap + c.compliance * c.multiplier).length());
        lengths.map(|gap| if gap.is_finite() { gap } else { f64::INFINITY }).fold(0.0, f64::max)
    }
}

/// Bend-twist C = Im(q̄₀ q₁) − s Im(rest), s the sign that is nearer in 4-D; dC = A (θ₁ − θ₀), A = ½(p_w I − [p_v]×) R₀ᵀ.
fn bend_twist(before: DQuat, after: DQuat, rest: DQuat) -> (DVec3, DMat3) {
    let p = before.conjugate() * after;
    let a = (DMat3::from_diagonal(DVec3::splat(p.w)) - cross_matrix(p.xyz())) * DMat3::from_quat(before).transpose();
    (p.xyz() - nearest_rest(p, rest), a * 0.5)
}

/// Symmetric positive definite matrix, its lower half in bands: blocks reach two blocks back.
struct Banded {
    rows: Vec<[f64; WIDTH]>,
}

/// Entries of a row: the diagonal last.
const WIDTH: usize = 9;

impl Banded {
    fn new(size: usize) -> Self {
        Self { rows: vec![[0.0; WIDTH]; size] }
    }

    fn at(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.rows[row][column + WIDTH - 1 - row]
    }

    fn add(&mut self, row: usize, column: usize, block: DMat3) {
        for r in 0..3 {
            for c in 0..3 {
                if column + c <= row + r {
                    *self.at(row + r, column + c) += block.col(c)[r];
                }
            }
        }
    }

    /// Solution x of L Lᵀ x = b, by Cholesky.
    fn solve(mut self, right: &[DVec3]) -> Vec<DVec3> {
        let n = self.rows.len();
        let start = |row: usize| (row + 1).saturating_sub(WIDTH);
        for row in 0..n {
            for column in start(row)..=row {
                let mut sum = *self.at(row, column);
                for k in start(row).max(start(column))..column {
                    sum -= *self.at(row, k) * *self.at(column, k);
                }
                *self.at(row, column) = if row == column { sum.sqrt() } else { sum / *self.at(column, column) };
            }
        }
        let mut x: Vec<f64> = right.iter().flat_map(|v| v.to_array()).collect();
        for row in 0..n {
            for k in start(row)..row {
                x[row] -= *self.at(row, k) * x[k];
            }
            x[row] /= *self.at(row, row);
        }
        for row in (0..n).rev() {
            x[row] /= *self.at(row, row);
            for k in start(row)..row {
                x[k] -= *self.at(row, k) * x[row];
            }
        }
        x.chunks_exact(3).map(DVec3::from_slice).collect()
    }
}
