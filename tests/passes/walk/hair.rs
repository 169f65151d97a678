//! Headings 4 and 5.

use glam::DVec3;
use windswept::internals::{status, step};
use windswept_reference::{
    State as Twin, contact, rods,
    step::{self as twin, Scratch},
    wind,
};
use windswept_shaders::common::integration::BDF2;

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
            let got: Vec<_> = stage.rod_strands().iter().map(|rod| [rod.torn != 0, rod.whole != 0]).collect();
            let wanted: Vec<_> = w.drives.iter().map(|drive| [drive.torn, drive.whole]).collect();
            self.same("rods/choose", differing(&got, &wanted), 0.0)?;
        }
        if passes.through("wind/sample") {
            let got = stage.engine.read(&stage.engine.state().sampled).unwrap();
            let pairs = || got.iter().zip(&w.local);
            self.same("wind/sample", largest(pairs().map(|(a, b)| (xyz(&a.wind) - b.wind).length())), bounds.speed)?;
            self.same(
                "wind/sample",
                largest(pairs().map(|(a, b)| (f64::from(a.filled) - b.filled).abs())),
                bounds.density,
            )?;
            self.same(
                "wind/sample",
                largest(pairs().map(|(a, b)| (f64::from(a.give) / b.give - 1.0).abs())),
                bounds.density,
            )?;
            let place = largest(pairs().map(|(a, b)| (xyz(&a.position) - b.position).length()));
            self.same("wind/sample", place, bounds.length)?;
        }
        if passes.through("wind/drag") {
            let schemes: Vec<_> = stage.rod_strands().iter().map(|rod| rod.scheme == BDF2).collect();
            let wanted: Vec<_> = w.drives.iter().map(|drive| drive.step < p.step).collect();
            self.same("wind/drag", differing(&schemes, &wanted), 0.0)?;
            let got = stage.engine.read(&stage.engine.state().hair_force).unwrap();
            // By what it changes a velocity; strands that are put somewhere are unloaded later.
            let apart = got.iter().zip(&w.moving.points).filter(|(_, b)| b.step.is_finite()).map(|(a, b)| {
                let scale = p.step * b.inverse_mass;
                let resisted = (f64::from(a[3]) - b.load.resistance).abs() * b.velocity.length();
                scale * ((xyz(&a[..3]) - b.load.force).length() + resisted)
            });
            self.same("wind/drag", largest(apart), bounds.wind)?;
        }
        if passes.through("rods/load") {
            let points = stage.rods().0;
            let pairs = || points.iter().zip(&w.moving.points).filter(|(_, b)| b.step.is_finite());
            self.same(
                "rods/load",
                largest(pairs().map(|(a, b)| (xyz(&a.outside) - b.outside).length())),
                bounds.speed,
            )?;
            self.same("rods/load", largest(pairs().map(|(a, b)| (xyz(&a.push) - b.push).length())), bounds.speed)?;
        }
        if passes.through("rods/start") {
            self.states("rods/start", w)?;
            let (points, segments) = stage.rods();
            let free = points.iter().zip(&w.moving.points).map(|(a, b)| (xyz(&a.free) - b.free).length());
            self.same("rods/start", largest(free), bounds.hair)?;
            let free = segments.iter().zip(&w.moving.segments).map(|(a, b)| (xyz(&a.free) - b.free).length());
            self.same("rods/start", largest(free), bounds.spin * p.step)?;
            self.moves("rods/start", w)?;
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
                let torn = rods::rescue(&p, &s.hair, strand, &mut w.drives[strand], &mut w.moving);
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
            let given = stage.vectors(&stage.engine.state().drag_impulse);
            let of = |(i, (a, b)): (usize, (&DVec3, &DVec3))| s.inverse_mass[i] * (*a - *b).length();
            self.same("rods/place", largest(given.iter().zip(&w.drag_impulse).enumerate().map(of)), bounds.speed)?;
        }
        if passes.through("wind/react") {
            let change = wind::react(&p, &w.local, &w.drag_impulse, &w.predicted, &s.volume, &s.inverse_mass, &w.near);
            w.new_velocity[p.hair_points..].iter_mut().zip(change).for_each(|(v, change)| *v += change);
            let got = self.vectors(&stage.engine.state().new_velocity, p.hair_points);
            self.same("wind/react", apart(&got, &w.new_velocity[p.hair_points..]), bounds.speed)?;
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
