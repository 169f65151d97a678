//! Headings 4 and 5.

use windswept::internals::{status, step};
use windswept_reference::{
    State as Twin, contact, rods,
    step::{self as twin, Scratch},
};

use super::{Same, Walk, apart, differing, largest};
use crate::stage::{condition, quaternion, xyz};

impl Walk<'_> {
    /// How many strands go through the step in another way.
    pub fn states(&mut self, pass: &'static str, w: &Scratch) -> Same {
        let wanted: Vec<u32> = w.drives.iter().map(|drive| drive.state as u32).collect();
        let got: Vec<u32> = self.stage.rod_strands().iter().map(|strand| strand.state).collect();
        self.same(pass, differing(&got, &wanted), 0.0)
    }

    pub fn rods(&mut self, s: &mut Twin, w: &mut Scratch) -> Same {
        let (stage, bounds, p) = (self.stage, self.bounds, self.p().clone());
        let mut passes = stage.passes(step::rods::record);
        twin::prepare(s, w, &p);
        if passes.through("rods/begin_points") {
            let points = stage.rods().0;
            let pairs = || points.iter().zip(&w.moving.points);
            let velocity = largest(pairs().map(|(a, b)| (xyz(&a.velocity) - b.velocity).length()));
            let before = largest(pairs().map(|(a, b)| (xyz(&a.before) - b.before).length()));
            let carried = largest(pairs().map(|(a, b)| (xyz(&a.carried) - b.carried).length()));
            self.same("rods/begin_points", velocity.max(before), bounds.speed)?;
            self.same("rods/begin_points", carried, bounds.length)?;
        }
        if passes.through("rods/begin_segments") {
            let segments = stage.rods().1;
            let pairs = || segments.iter().zip(&w.moving.segments);
            let start = largest(pairs().map(|(a, b)| (quaternion(a.start) - b.start).length()));
            let spin = largest(pairs().map(|(a, b)| (xyz(&a.angular_velocity) - b.angular_velocity).length()));
            let before = largest(pairs().map(|(a, b)| (xyz(&a.before) - b.before).length()));
            let carried = largest(pairs().map(|(a, b)| (xyz(&a.carried) - b.carried).length()));
            let chord = largest(pairs().map(|(a, b)| (xyz(&a.chord) - b.chord).length()));
            self.same("rods/begin_segments", start.max(carried), bounds.frame)?;
            self.same("rods/begin_segments", spin.max(before), bounds.spin)?;
            self.same("rods/begin_segments", chord, bounds.length)?;
        }
        if passes.through("rods/choose") {
            self.states("rods/choose", w)?;
            let (points, segments) = stage.rods();
            let free = points.iter().zip(&w.moving.points).map(|(a, b)| (xyz(&a.free) - b.free).length());
            self.same("rods/choose", largest(free), bounds.hair)?;
            let free = segments.iter().zip(&w.moving.segments).map(|(a, b)| (xyz(&a.free) - b.free).length());
            self.same("rods/choose", largest(free), bounds.spin * p.step)?;
            self.moves("rods/choose", w)?;
        }
        if p.direct {
            for strand in 0..s.hair.len() {
                for _ in 0..p.newton_steps {
                    let quiet = rods::direct(&p, &s.hair, strand, &mut w.drives[strand], &mut w.moving);
                    s.quiet_steps += usize::from(quiet);
                }
            }
            if passes.through("rods/direct") {
                self.moves("rods/direct", w)?;
            }
            for strand in 0..s.hair.len() {
                let torn = rods::rescue(&s.hair, strand, &mut w.drives[strand], &mut w.moving);
                s.rescued_steps += usize::from(torn);
            }
            if passes.through("rods/rescue") {
                self.states("rods/rescue", w)?;
                self.moves("rods/rescue", w)?;
            }
        }
        for strand in 0..s.hair.len() {
            rods::gauss_seidel(&p, &s.hair, strand, &w.drives[strand], &mut w.moving);
        }
        if passes.through("rods/gauss_seidel") {
            self.moves("rods/gauss_seidel", w)?;
        }
        twin::finish(s, w, &p);
        if passes.through("rods/finish") {
            self.health("rods/finish", s)?;
        }
        if passes.through("rods/place") {
            let got = &stage.vectors(&stage.engine.state().predicted)[..p.hair_points];
            self.same("rods/place", apart(got, &w.predicted[..p.hair_points]), bounds.length)?;
        }
        passes.finish();
        Ok(())
    }

    /// How strands are found, and the largest stretch.
    fn health(&mut self, pass: &'static str, s: &Twin) -> Same {
        let found: Vec<_> = self.stage.health().iter().map(|health| health.found).collect();
        let wanted: Vec<_> = (0..s.hair.len()).map(|strand| condition(s, strand)).collect();
        self.same(pass, differing(&found, &wanted), 0.0)?;
        let stretch = f64::from(status::max_stretch(&self.stage.engine.status().unwrap()));
        self.same(pass, (stretch - s.max_stretch).abs(), self.bounds.density)
    }

    /// Moves and frames.
    fn moves(&mut self, pass: &'static str, w: &Scratch) -> Same {
        let (points, segments) = self.stage.rods();
        let moves = points.iter().zip(&w.moving.points).map(|(a, b)| (xyz(&a.travel) - b.travel).length());
        self.same(pass, largest(moves), self.bounds.hair)?;
        let frames = segments.iter().zip(&w.moving.segments).map(|(a, b)| (quaternion(a.frame) - b.frame).length());
        self.same(pass, largest(frames), self.bounds.frame)
    }

    pub fn contact(&mut self, s: &mut Twin, w: &mut Scratch) -> Same {
        let (stage, bounds, hair) = (self.stage, self.bounds, self.p().hair_points);
        let state = stage.engine.state();
        let mut passes = stage.passes(step::contact::record);
        twin::contact(s, w, self.p());
        if passes.through("contact/place") {
            let got = stage.engine.read(&state.placed).unwrap();
            let wanted = contact::place(self.p(), s.steps);
            let ends = got.iter().zip(&wanted).map(|(got, wanted)| {
                let [start, end] = wanted.body.shape.round().ends.map(|end| wanted.after.out(end));
                (xyz(&got.start) - start).length().max((xyz(&got.end) - end).length())
            });
            self.same("contact/place", largest(ends), bounds.length)?;
        }
        if passes.through("contact/hair") {
            let got = stage.vectors(&state.predicted);
            self.same("contact/hair", apart(&got[..hair], &w.predicted[..hair]), bounds.length)?;
            let touched = stage.engine.read(&state.touched).unwrap();
            let touched: Vec<u32> = touched.iter().map(|bits| u32::from(*bits != 0)).collect();
            let wanted: Vec<u32> = w.touched.iter().map(|touched| u32::from(*touched)).collect();
            self.same("contact/hair", differing(&touched, &wanted), 0.0)?;
        }
        if passes.through("contact/stretch") {
            self.health("contact/stretch", s)?;
        }
        if passes.through("contact/air") {
            let gap = self.places(&self.vectors(&state.predicted, hair), &w.predicted[hair..], hair);
            self.same("contact/air", gap, bounds.length)?;
            let got = self.vectors(&state.new_velocity, hair);
            self.same("contact/air", apart(&got, &w.new_velocity[hair..]), bounds.speed)?;
        }
        passes.finish();
        Ok(())
    }
}
