//! Heading 7.

use glam::DVec3;
use windswept::internals::{Array, BandPlan, step};
use windswept_reference::{State as Twin, step::Scratch, turbulence};

use super::{Same, Walk, apart, differing, largest};
use crate::stage::{Passes, xyz};

impl Walk<'_> {
    pub fn turbulence(&mut self, s: &mut Twin, w: &mut Scratch) -> Same {
        let (stage, bounds, p) = (self.stage, self.bounds, self.p().clone());
        let (state, plan) = (stage.engine.state(), &stage.plan);
        let mut passes = stage.passes(step::turbulence::record);
        if p.bands.is_empty() {
            assert!(!plan.turbulence.runs);
            return Ok(());
        }
        w.confinement = vec![DVec3::ZERO; w.predicted.len()];
        if plan.direct_filter.runs {
            assert!(passes.through("turbulence/locate"));
            let sorted = stage.engine.read(&state.sorted).unwrap();
            let predicted = stage.engine.read(&state.predicted).unwrap();
            let at = |i: &u32| {
                let ([x, y, z, _], air) = (predicted[*i as usize], p.is_air(*i as usize));
                [x, y, z, f32::from(air)]
            };
            let wanted: Vec<_> = sorted.iter().map(at).collect();
            let got = stage.engine.read(&state.flow_position).unwrap();
            self.same("turbulence/locate", differing(&got, &wanted), 0.0)?;
            assert!(passes.through("turbulence/weigh"));
            self.weighed(s, w)?;
        }
        if plan.published_law {
            w.vorticity = turbulence::vorticity(&p, &w.predicted, &w.new_velocity, &s.volume, &w.near);
            assert!(passes.through("turbulence/vorticity"));
            self.same("turbulence/vorticity", apart(&stage.vectors(&state.vorticity), &w.vorticity), bounds.spin)?;
        }
        for band in plan.bands.iter().filter(|band| band.runs.runs) {
            self.filter(&mut passes, band, s, w)?;
            if !plan.published_law {
                w.vorticity = turbulence::vorticity(&p, &w.predicted, &w.band_velocity, &s.volume, &w.near);
                assert!(passes.through("turbulence/vorticity"));
                let gap = apart(&self.vectors(&state.vorticity, p.hair_points), &w.vorticity[p.hair_points..]);
                self.same("turbulence/vorticity", gap, bounds.spin)?;
            }
            let own = turbulence::confine(
                &p,
                &p.turbulence.bands[band.index],
                w.blowing,
                &w.predicted,
                &w.band_velocity,
                &w.vorticity,
                &s.volume,
                &s.inverse_mass,
                &w.near,
            );
            w.confinement.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            assert!(passes.through("turbulence/confine"));
            let gap = apart(&self.vectors(&state.confinement, p.hair_points), &w.confinement[p.hair_points..]);
            self.same("turbulence/confine", gap, bounds.speed)?;
        }
        if passes.through("turbulence/sum") {
            let change = self.vectors(&state.confinement, p.hair_points);
            let wanted: Vec<DVec3> = change.chunks(64).map(|group| group.iter().sum()).collect();
            let got = &stage.vectors(&state.partial_sum)[..wanted.len()];
            self.same("turbulence/sum", apart(got, &wanted), bounds.wind)?;
        }
        let mean = if p.turbulence.conserve_momentum { turbulence::mean(&p, &w.confinement) } else { DVec3::ZERO };
        if passes.through("turbulence/mean") {
            let got = stage.vectors(&state.mean_confinement)[0];
            self.same("turbulence/mean", (got - mean).length(), bounds.speed)?;
        }
        let stronger = turbulence::strengthen(&p, &w.new_velocity, &w.confinement, mean);
        s.confinement_impulse += turbulence::impulse(&p, &s.inverse_mass, &w.new_velocity, &stronger);
        w.new_velocity = stronger;
        assert!(passes.through("turbulence/strengthen"));
        self.same(
            "turbulence/strengthen",
            apart(&self.vectors(&state.new_velocity, 0), &w.new_velocity),
            bounds.speed,
        )?;
        passes.finish();
        Ok(())
    }

    /// The velocity of a band, by the scene's filter.
    fn filter(&mut self, passes: &mut Passes<'_>, plan: &BandPlan, s: &Twin, w: &mut Scratch) -> Same {
        let (stage, bounds, p) = (self.stage, self.bounds, self.p().clone());
        let (state, band) = (stage.engine.state(), &p.turbulence.bands[plan.index]);
        let last = if stage.plan.grid_filter.runs {
            let scale = p.grid_scale(band);
            let deposited = turbulence::deposit(&p, scale, w.blowing, &w.predicted, &w.new_velocity, &s.volume);
            if plan.deposit.runs {
                assert!(passes.through("turbulence/weigh"));
                self.weighed(s, w)?;
                assert!(passes.through("turbulence/deposit"));
                self.nodes("turbulence/deposit", &state.deposited, &deposited)?;
            }
            let curved = turbulence::smooth(&p, band.scale, &deposited);
            assert!(passes.through("turbulence/smooth"));
            self.nodes("turbulence/smooth", &state.curvature, &curved)?;
            w.band_velocity = turbulence::gather(&p, band, &curved, &w.predicted);
            "turbulence/gather"
        } else {
            let (x, v) = (&w.predicted, &w.new_velocity);
            w.band_velocity = turbulence::band(&p, band, w.blowing, x, v, &s.volume);
            "turbulence/band"
        };
        assert!(passes.through(last));
        // As printed û has units and a size of its own: compared in parts of its largest, as if that were 1 m/s.
        // A neighbour exactly at the cut of 3 s is in one sum and not in the other: measured 6.3e-3; margin 3.
        let (unit, bound) = match stage.plan.published_law {
            true => (largest(w.band_velocity.iter().map(|u| u.length())), 2e-2),
            false => (1.0, bounds.speed),
        };
        let gap = apart(&self.vectors(&state.band_velocity, p.hair_points), &w.band_velocity[p.hair_points..]);
        self.same(last, gap / unit, bound)
    }

    /// What the filter sums of each particle, in the order of the cells: the velocity about the wind and the volume, or as
    /// printed the velocity.
    fn weighed(&mut self, s: &Twin, w: &Scratch) -> Same {
        let (stage, p) = (self.stage, self.p());
        let published = stage.plan.published_law;
        let sorted = stage.engine.read(&stage.engine.state().sorted).unwrap();
        let flow = stage.engine.read(&stage.engine.state().flow).unwrap();
        let gaps = flow.iter().zip(&sorted).map(|([x, y, z, weight], i)| {
            let i = *i as usize;
            let (got, weight) = (DVec3::new((*x).into(), (*y).into(), (*z).into()), f64::from(*weight));
            match (published, p.is_air(i)) {
                (true, _) => (got - w.new_velocity[i]).length(),
                (false, true) => {
                    let relative = w.new_velocity[i] - w.blowing;
                    (got / s.volume[i] - relative).length().max((weight / s.volume[i] - 1.0).abs())
                }
                (false, false) => got.length().max(weight),
            }
        });
        let gap = largest(gaps);
        self.same("turbulence/weigh", gap, self.bounds.speed)
    }

    /// Momentum or curvature, and volume, of the nodes of a grid, in parts of their largest.
    fn nodes(&mut self, pass: &'static str, array: &Array<[f32; 4]>, mesh: &turbulence::Mesh) -> Same {
        let got = self.stage.engine.read(array).unwrap();
        let pairs = || got.iter().zip(&mesh.values);
        let parts = |gap: f64, most: f64| if most > 0.0 { gap / most } else { gap };
        let vectors = largest(pairs().map(|(a, b)| (xyz(&a[..3]) - b.truncate()).length()));
        let gap = parts(vectors, largest(mesh.values.iter().map(|node| node.truncate().length())));
        self.same(pass, gap, self.bounds.nodes)?;
        let volumes = largest(pairs().map(|(a, b)| (f64::from(a[3]) - b.w).abs()));
        self.same(pass, parts(volumes, largest(mesh.values.iter().map(|node| node.w.abs()))), self.bounds.nodes)
    }
}
