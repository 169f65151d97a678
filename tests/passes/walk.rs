//! One step of engine and twin, pass by pass: the first pass that parts is named.

mod hair;
mod neighbours;
mod turbulence;

use glam::DVec3;
use windswept::internals::{Array, step};
use windswept_reference::{
    Parameters, State as Twin, fluid,
    step::{self as twin, Scratch},
};
use windswept_shaders::common::status::{ASLEEP_STEP, EULER_STEP, MOVE_CAPPED, RESCUED_STEP, STRAND_RESET, TELEPORT};

use crate::stage::{Stage, quaternion, xyz};

/// How much may differ: lengths \[m\], also the moves of hair, speeds \[m/s\], also those that the wind adds, frames, spins \[1/s\], ρ/ρ0 (also S), and what is compared in parts
/// of its largest: multipliers and nodes of the filter's grid.
pub struct Bounds {
    pub length: f64,
    pub hair: f64,
    pub speed: f64,
    pub wind: f64,
    pub frame: f64,
    pub spin: f64,
    pub density: f64,
    pub multiplier: f64,
    pub nodes: f64,
}

/// Names the pass where they part.
type Same = Result<(), String>;

/// Both walk from the same state, and compare what every pass left.
pub struct Walk<'a> {
    stage: &'a Stage,
    bounds: &'a Bounds,
    /// Per pass and bound the largest difference.
    worst: &'a mut Vec<(&'static str, f64, f64)>,
}

fn largest(gaps: impl Iterator<Item = f64>) -> f64 {
    gaps.fold(0.0, |most, gap| if gap.is_nan() { f64::INFINITY } else { most.max(gap) })
}

fn apart(got: &[DVec3], wanted: &[DVec3]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    largest(got.iter().zip(wanted).map(|(a, b)| (*a - *b).length()))
}

fn numbers_apart(got: &[f64], wanted: &[f64]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    largest(got.iter().zip(wanted).map(|(a, b)| (a - b).abs()))
}

fn differing<T: PartialEq>(got: &[T], wanted: &[T]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    got.iter().zip(wanted).filter(|(a, b)| a != b).count() as f64
}

/// One step of both; the twin's state becomes what it arrived at.
pub fn step_of_both(
    stage: &mut Stage,
    bounds: &Bounds,
    worst: &mut Vec<(&'static str, f64, f64)>,
) -> Result<(), String> {
    let mut s = stage.twin.clone();
    Walk { stage, bounds, worst }.step(&mut s)?;
    stage.twin = s;
    Ok(())
}

impl Walk<'_> {
    fn p(&self) -> &Parameters {
        &self.stage.parameters
    }

    fn same(&mut self, pass: &'static str, difference: f64, bound: f64) -> Same {
        if difference.is_nan() || difference > bound {
            return Err(format!("{pass} differs by {difference:.2e} (bound {bound:.1e})"));
        }
        match self.worst.iter_mut().find(|row| row.0 == pass && row.2 == bound) {
            Some(row) => row.1 = row.1.max(difference),
            None => self.worst.push((pass, difference, bound)),
        }
        Ok(())
    }

    /// Of the engine's vectors those from `from` on.
    fn vectors(&self, array: &Array<[f32; 4]>, from: usize) -> Vec<DVec3> {
        let mut all = self.stage.vectors(array);
        all.truncate(self.stage.twin.position.len());
        all.split_off(from)
    }

    /// The largest distance of positions, those from `from` on through the faces of the box for air.
    fn places(&self, got: &[DVec3], wanted: &[DVec3], from: usize) -> f64 {
        let (p, size) = (self.p(), self.p().box_size);
        largest(got.iter().zip(wanted).enumerate().map(|(i, (a, b))| {
            let gap = *a - *b;
            if p.is_air(from + i) { (gap - size * (gap / size).round()).length() } else { gap.length() }
        }))
    }

    fn step(&mut self, s: &mut Twin) -> Same {
        let mut w = self.drive(s)?;
        self.neighbours(&mut w)?;
        self.fluid(s, &mut w)?;
        self.rods(s, &mut w)?;
        self.contact(s, &mut w)?;
        self.velocity(s, &mut w)?;
        self.turbulence(s, &mut w)?;
        self.viscosity(s, &mut w)?;
        self.guard(s, w)
    }

    fn drive(&mut self, s: &Twin) -> Result<Scratch, String> {
        let (stage, bounds, hair) = (self.stage, self.bounds, self.p().hair_points);
        let state = stage.engine.state();
        let w = twin::drive(s, self.p());
        let mut passes = stage.passes(step::drive::record);
        if passes.through("wind/blow") {
            let wind = stage.engine.status().unwrap().wind.map(f64::from);
            self.same("wind/blow", (DVec3::from_array(wind) - w.blowing).length(), bounds.wind)?;
        }
        if passes.through("rods/roots") {
            let got = stage.rod_strands();
            let gap = |f: &dyn Fn(usize) -> f64| largest((0..got.len()).map(f));
            let travel = gap(&|k| (xyz(&got[k].root_travel) - w.drives[k].root_travel).length());
            let frame = gap(&|k| (quaternion(got[k].root_frame) - w.drives[k].root_frame).length());
            let turn = gap(&|k| (quaternion(got[k].root_turn) - w.drives[k].root_turn).length());
            self.same("rods/roots", travel, bounds.length)?;
            self.same("rods/roots", frame.max(turn), bounds.frame)?;
            self.states("rods/roots", &w)?;
        }
        if passes.through("rods/drift") {
            let got = &stage.vectors(&state.predicted)[..hair];
            self.same("rods/drift", apart(got, &w.predicted[..hair]), bounds.length)?;
        }
        if passes.through("wind/fringe") {
            self.same("wind/fringe", apart(&self.vectors(&state.wind_change, hair), &w.wind_change), bounds.wind)?;
        }
        if passes.through("fluid/predict") {
            let gap = self.places(&self.vectors(&state.predicted, hair), &w.predicted[hair..], hair);
            self.same("fluid/predict", gap, bounds.length)?;
        }
        passes.finish();
        Ok(w)
    }

    fn fluid(&mut self, s: &Twin, w: &mut Scratch) -> Same {
        let (stage, bounds) = (self.stage, self.bounds);
        let state = stage.engine.state();
        w.correction = vec![DVec3::ZERO; w.predicted.len()];
        let mut passes = stage.passes(step::fluid::record);
        while passes.through("fluid/density") {
            let lambda;
            (w.density, lambda) = fluid::density(self.p(), &w.predicted, &s.inverse_mass, &s.volume, &w.near);
            self.same("fluid/density", numbers_apart(&stage.numbers(&state.density), &w.density), bounds.density)?;
            // In parts of the largest, or of what a density error of 1 % asks for where air is nearly at rest density: the
            // softening is a thousandth of the lattice's gradients.
            let of_one_percent = 1e-2 * 1e-3 / self.p().density_softening.max(f64::MIN_POSITIVE);
            let most = largest(lambda.iter().map(|lambda| lambda.abs())).max(of_one_percent);
            let gap = numbers_apart(&stage.numbers(&state.multiplier), &lambda) / most;
            self.same("fluid/density", gap, bounds.multiplier)?;
            if !passes.through("fluid/correct") {
                break;
            }
            let shift = fluid::correct(self.p(), &w.predicted, &s.inverse_mass, &s.volume, &w.near, &lambda);
            self.same("fluid/correct", apart(&stage.vectors(&state.shift), &shift), bounds.length)?;
            passes.through("fluid/move");
            for (i, shift) in shift.into_iter().enumerate() {
                w.predicted[i] += shift;
                w.correction[i] += shift;
            }
            let got = stage.vectors(&state.predicted);
            self.same("fluid/move", self.places(&got, &w.predicted, 0), bounds.length)?;
            self.same("fluid/move", apart(&stage.vectors(&state.correction), &w.correction), bounds.length)?;
        }
        if passes.through("fluid/velocity") {
            let hair = self.p().hair_points;
            for i in hair..w.predicted.len() {
                w.new_velocity[i] = fluid::velocity(self.p(), w.new_velocity[i], w.correction[i]);
                w.correction[i] = DVec3::ZERO;
            }
            let got = self.vectors(&state.new_velocity, hair);
            self.same("fluid/velocity", apart(&got, &w.new_velocity[hair..]), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }

    fn velocity(&mut self, s: &Twin, w: &mut Scratch) -> Same {
        let (stage, bounds, hair) = (self.stage, self.bounds, self.p().hair_points);
        let state = stage.engine.state();
        let mut passes = stage.passes(step::velocity::record);
        twin::velocity(s, w, self.p());
        if passes.through("rods/velocity") {
            let got = stage.vectors(&state.new_velocity);
            self.same("rods/velocity", apart(&got[..hair], &w.new_velocity[..hair]), bounds.speed)?;
        }
        if passes.through("fluid/velocity") {
            let got = self.vectors(&state.new_velocity, hair);
            self.same("fluid/velocity", apart(&got, &w.new_velocity[hair..]), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }

    fn viscosity(&mut self, s: &Twin, w: &mut Scratch) -> Same {
        let (stage, bounds) = (self.stage, self.bounds);
        let state = stage.engine.state();
        let mut passes = stage.passes(step::viscosity::record);
        twin::viscosity(s, w, self.p());
        if passes.through("fluid/limit") {
            self.same("fluid/limit", numbers_apart(&stage.numbers(&state.exchange), &w.exchange), bounds.density)?;
        }
        if passes.through("fluid/viscosity") {
            let got = self.vectors(&state.viscous_velocity, 0);
            self.same("fluid/viscosity", apart(&got, &w.new_velocity), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }

    fn guard(&mut self, s: &mut Twin, w: Scratch) -> Same {
        let (stage, bounds, p) = (self.stage, self.bounds, self.p().clone());
        let state = stage.engine.state();
        let mut passes = stage.passes(step::guard::record);
        twin::guard(s, w, &p).map_err(|frozen| format!("the twin froze: {frozen:?}"))?;
        if passes.through("guard/hold") {
            let bad = differing(&stage.health().iter().map(|health| health.found.bad != 0).collect::<Vec<_>>(), &s.bad);
            self.same("guard/hold", bad, 0.0)?;
        }
        assert!(passes.through("guard/check"));
        self.same("guard/check", stage.engine.status().unwrap().causes.into(), 0.0)?;
        if passes.through("guard/commit_frames") {
            let frames = stage.quaternions(&state.orientation);
            let frames = largest(frames.iter().zip(&s.orientation).map(|(a, b)| (*a - *b).length()));
            self.same("guard/commit_frames", frames, bounds.frame)?;
            let spin = apart(&stage.vectors(&state.angular_velocity), &s.angular_velocity);
            self.same("guard/commit_frames", spin, bounds.spin)?;
            let history = stage.engine.read(&state.segment_history).unwrap();
            let turns = largest(history.iter().zip(&s.turn).map(|(a, b)| (xyz(&a.turn) - *b).length()));
            self.same("guard/commit_frames", turns, bounds.frame)?;
            let clamps = stage.engine.read(&state.clamps).unwrap();
            let clamps = clamps.iter().zip(&s.clamps).map(|(root, clamp)| (xyz(&root.position) - clamp.0).length());
            self.same("guard/commit_frames", largest(clamps), bounds.length)?;
        }
        if passes.through("guard/commit_hair") {
            let points = stage.engine.read(&state.point_history).unwrap();
            let travel = largest(points.iter().zip(&s.travel).map(|(a, b)| (xyz(&a.travel) - *b).length()));
            self.same("guard/commit_hair", travel, bounds.length)?;
            let before = largest(points.iter().zip(&s.velocity_before).map(|(a, b)| (xyz(&a.velocity) - *b).length()));
            self.same("guard/commit_hair", before, bounds.speed)?;
        }
        assert!(passes.through("guard/commit"));
        passes.finish();
        let position = self.places(&self.vectors(&state.position, 0), &s.position, 0);
        self.same("guard/commit", position, bounds.length)?;
        self.same("guard/commit", apart(&self.vectors(&state.velocity, 0), &s.velocity), bounds.speed)?;
        let status = stage.engine.status().unwrap();
        self.same("guard/commit", (f64::from(status.step) - s.steps as f64).abs(), 0.0)?;
        let counters = [STRAND_RESET, MOVE_CAPPED, EULER_STEP, ASLEEP_STEP, TELEPORT, RESCUED_STEP];
        let got = counters.map(|counter| status.counted[counter as usize] as usize);
        let wanted = [s.resets, s.capped, s.euler_steps, s.asleep_steps, s.teleports, s.rescued_steps];
        self.same("guard/commit", differing(&got, &wanted), 0.0)
    }
}
