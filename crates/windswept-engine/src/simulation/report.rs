//! The report of a run, and the figures in it.

use glam::DVec3;
use windswept_scene::Warning;

use super::Simulation;
use crate::{
    error::RunError,
    report::{BodyReport, ParticleCounts, PassReport, Report, SkippedReport},
    status,
};

impl Simulation {
    /// The report of the run so far; of one that an error ended, up to the last good step.
    ///
    /// # Errors
    /// [`RunError`] as [`Self::density`].
    pub fn report(&mut self) -> Result<Report, RunError> {
        // Of a run that ended for want of room for its neighbours there is no density.
        let density = match self.density() {
            Err(RunError::TooManyNeighbours { .. }) => Vec::new(),
            density => density?,
        };
        let s = self.engine.state();
        let [positions, velocities] = self.engine.read_vec4([&s.position, &s.velocity])?;
        let sizes = self.engine.sizes();
        let air_errors = density.iter().skip(sizes.hair_points as usize).map(|ratio| f64::from(*ratio) - 1.0);
        let rms = |errors: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = errors.fold((0.0, 0u32), |(sum, n), e| (sum + e * e, n + 1));
            (n > 0).then(|| (sum / f64::from(n)).sqrt())
        };
        Ok(Report {
            schema: 2,
            windswept: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("WINDSWEPT_COMMIT").map(str::to_owned),
            scene: self.scene.title.clone(),
            method: format!("{:?}", self.scene.method).to_lowercase(),
            adapter: self.engine.gpu().info().clone(),
            variant: self.engine.gpu().variant(),
            particles: ParticleCounts {
                hair: sizes.hair_points.into(),
                air: sizes.air().into(),
                hair_outside_box: self.outside(&positions[..sizes.hair_points as usize]),
            },
            steps: self.steps,
            time_s: self.time(),
            failure: None,
            ms_per_step: self.ms_per_step(),
            ms_setup: self.setup_ms,
            ms_first_step: self.first_step_ms,
            passes: self.pass_times(),
            skipped: self.skipped(),
            max_stretch: self.plan.conditions.hair.runs.then(|| status::max_stretch(&self.last).into()),
            strand_steps: self.plan.conditions.hair.runs.then(|| status::strand_steps(&self.last)),
            density_error_rms: rms(&mut air_errors.clone()),
            over_density_rms: rms(&mut air_errors.map(|e| e.max(0.0))),
            momentum_kg_m_per_s: self.momentum(&velocities),
            confinement_impulse_kg_m_per_s: self.confinement_impulse()?,
            bodies: self.bodies()?,
            confinement_limited_steps: self
                .plan
                .conditions
                .turbulence
                .runs
                .then(|| status::confinement_limited_steps(&self.last)),
            band_energy: self.band_energies()?,
            memory_bytes: self.engine.memory_bytes(),
            resets: self.resets.clone(),
            changes: self.updates.clone(),
            warnings: self.warnings(),
        })
    }

    /// Median wall time of a step \[ms\], stepping alone, the first step excluded; `None` before the second.
    #[must_use]
    pub fn ms_per_step(&self) -> Option<f64> {
        median(&self.step_ms)
    }

    /// Warnings: those about the scene and a wind that was set, and those whose cause acted so far, with how often.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let strand_steps = u64::from(self.engine.sizes().strands) * self.steps * self.substeps();
        let of_wind = self.wind_set.and_then(|_| self.scene.why_too_fast());
        let of_run = status::warnings(&self.last, strand_steps);
        self.initial.warnings.iter().cloned().chain(of_wind).chain(of_run).collect()
    }

    fn outside(&self, hair: &[[f32; 4]]) -> u64 {
        if !self.plan.conditions.air.runs {
            return 0;
        }
        let size = self.initial.air.size.as_vec3().to_array();
        hair.iter().filter(|x| (0..3).any(|axis| x[axis] < 0.0 || x[axis] >= size[axis])).count() as u64
    }

    fn momentum(&self, velocities: &[[f32; 4]]) -> [f64; 3] {
        let hair = &self.initial.hair.inverse_mass;
        let mass = |i: usize| match hair.get(i) {
            Some(&w) if w > 0.0 => 1.0 / w,
            Some(_) => 0.0,
            None => self.initial.air.mass,
        };
        let mut sum = DVec3::ZERO;
        for (i, v) in velocities.iter().enumerate() {
            sum += mass(i) * DVec3::new(v[0].into(), v[1].into(), v[2].into());
        }
        sum.to_array()
    }

    /// Impulse that confinement has given the air so far \[kg m/s\]; `None` where no band is strengthened.
    ///
    /// # Errors
    /// [`RunError::Gpu`] when the device is lost.
    pub fn confinement_impulse(&self) -> Result<Option<[f64; 3]>, RunError> {
        let [impulse] = self.engine.read_vec4([&self.engine.state().confinement_impulse])?;
        let sum = impulse.first().map(|p| [p[0], p[1], p[2]].map(f64::from));
        Ok(sum.filter(|_| self.plan.conditions.turbulence.runs))
    }

    /// Impulse that the air has given each body so far, by its pressure and by friction, in the order of the scene \[kg
    /// m/s\]; empty without air particles. The force on a body in a step is the change of its impulse over the step.
    /// Impulses of hair on bodies are not in it.
    ///
    /// # Errors
    /// [`RunError::Gpu`] when the device is lost.
    pub fn body_impulses(&self) -> Result<Vec<[f64; 3]>, RunError> {
        let [impulses] = self.engine.read_vec4([&self.engine.state().body_impulse])?;
        Ok(impulses.iter().map(|p| [p[0], p[1], p[2]].map(f64::from)).collect())
    }

    fn bodies(&self) -> Result<Vec<BodyReport>, RunError> {
        let each = self.scene.bodies.iter().zip(self.body_impulses()?);
        Ok(each.map(|(body, impulse)| BodyReport { name: body.name.clone(), impulse_kg_m_per_s: impulse }).collect())
    }

    /// Number of substeps that were timed pass by pass: one in every eighth batch, from the second on, and all of
    /// [`Self::step_timed`]. The times of [`Self::pass_times`] are means over them, so that a caller who asks again and
    /// again can tell what the newest one took.
    #[must_use]
    pub fn timed_steps(&self) -> u64 {
        self.timed_steps
    }

    /// GPU time per pass and step so far: the mean of those of [`Self::timed_steps`] in which the pass ran. Empty where
    /// the adapter has no timestamps.
    #[must_use]
    pub fn pass_times(&self) -> Vec<PassReport> {
        let mut rows: Vec<PassReport> = Vec::new();
        for command in self.recording.running() {
            let (pass, label, band) = (command.pass.name, command.label, command.band);
            let Some(time) = self.profile.get(&(pass, label, band)) else { continue };
            if rows.iter().any(|row| row.pass == pass && row.name == label && row.band == band) {
                continue;
            }
            let steps = time.steps as f64 / self.substeps() as f64;
            rows.push(PassReport {
                stage: command.stage.to_owned(),
                name: label.to_owned(),
                pass: pass.to_owned(),
                band,
                ms: time.ms / steps,
                runs: (time.runs as f64 / steps).round() as u64,
            });
        }
        rows
    }

    fn skipped(&self) -> Vec<SkippedReport> {
        let skipped = self.recording.commands.iter().filter_map(|command| {
            let why = command.skipped.clone()?;
            Some(SkippedReport { name: command.label.to_owned(), why })
        });
        skipped.collect()
    }
}

fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
