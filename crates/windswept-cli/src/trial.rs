//! The time of a run, from a few steps and a picture of it.

use std::time::{Duration, Instant};

use windswept::{AdapterChoice, Gpu, RunError, Simulation};
use windswept_export::{ExportError, Renderer, Schedule, frame};
use windswept_scene::{Air, CheckedScene, InitialState, Scene};

use crate::failure::Failure;

/// Longest time that steps are tried, behind the first two \[s\].
const TRIED: Duration = Duration::from_millis(500);

/// Times of the parts of a run on an adapter.
pub(crate) struct Trial {
    adapter: String,
    /// Time of a step \[s\].
    step: f64,
    /// Time of a picture \[s\], if the run makes any.
    picture: Option<f64>,
    /// Time in which hair settles before the run \[s\].
    settling: f64,
    air_particles: u64,
}

impl Trial {
    pub(crate) fn run(
        scene: &CheckedScene,
        initial: InitialState,
        adapter: Option<&str>,
        pictures: bool,
    ) -> Result<Self, Failure> {
        let gpu = Gpu::new(&AdapterChoice::from_flag(adapter))?;
        let settling = match Simulation::settling(&gpu, scene, &initial)? {
            Some((mut settling, steps)) => steps as f64 * step_of(&mut settling)?,
            None => 0.0,
        };
        // `with_state` leaves hair where the state has it, also with `time.settle`.
        let mut simulation = Simulation::with_state(&gpu, scene, initial)?;
        let step = step_of(&mut simulation)?;
        let picture = if pictures { Some(picture_of(&mut simulation)?) } else { None };
        Ok(Self { adapter: gpu.info().to_string(), step, picture, settling, air_particles: simulation.counts().air })
    }

    /// The time of the run, and the spacings of air with which it would take a minute and an hour.
    pub(crate) fn words(&self, scene: &CheckedScene) -> String {
        let schedule = Schedule::new(&scene.time, None);
        let (steps, pictures) = (schedule.steps(), schedule.frames());
        let stepping = self.step * steps as f64;
        let others = self.picture.unwrap_or_default() * pictures as f64 + self.settling;
        let spacings: Vec<String> = [(60.0, "a minute"), (3600.0, "an hour")]
            .into_iter()
            .filter_map(|(all, period)| Some(format!("{} {period}", self.spacing(scene, stepping / (all - others))?)))
            .collect();
        let spacings =
            if spacings.is_empty() { String::new() } else { format!("; with air.spacing = {}", spacings.join(", ")) };
        let settling = if self.settling > 0.0 {
            format!(", {} in which hair settles", period(self.settling))
        } else {
            String::new()
        };
        let drawing = self
            .picture
            .map_or_else(String::new, |picture| format!(", {pictures} pictures of {:.3} ms", 1e3 * picture));
        format!(
            "about {} on {}: {steps} steps of {:.3} ms{drawing}{settling}{spacings}",
            period(stepping + others),
            self.adapter,
            1e3 * self.step,
        )
    }

    /// The spacing, to three digits, with which a step takes this part of its time, in proportion to its particles;
    /// `None` where there is none, or the scene's other keys do not go with it.
    fn spacing(&self, scene: &CheckedScene, part: f64) -> Option<f64> {
        let written = scene.scene();
        let air = written.air.as_ref().filter(|air| self.air_particles > 0 && air.kernel_radius.is_none())?;
        let spacing = format!("{:.2e}", air.spacing * part.cbrt()).parse().ok().filter(|spacing| *spacing > 0.0)?;
        let other = Scene { air: Some(Air { spacing, ..air.clone() }), ..written.clone() };
        other.check().is_ok().then_some(spacing)
    }
}

/// Time of a step \[s\].
fn step_of(simulation: &mut Simulation) -> Result<f64, RunError> {
    // The first step has its pipelines compiled, and the second one begins with the state that the first one left.
    simulation.step(2)?;
    let (start, mut steps) = (Instant::now(), 0);
    while steps == 0 || start.elapsed() < TRIED {
        simulation.step(1)?;
        steps += 1;
    }
    Ok(start.elapsed().as_secs_f64() / f64::from(steps))
}

/// Time of a picture \[s\].
fn picture_of(simulation: &mut Simulation) -> Result<f64, ExportError> {
    let followers = simulation.initial().followers.as_ref();
    let renderer = Renderer::with_groom(simulation.gpu(), simulation.scene(), &simulation.hair_at_start(), followers)?;
    // The first one has its pipelines compiled.
    renderer.render(&frame(simulation)?)?;
    let start = Instant::now();
    renderer.render(&frame(simulation)?)?;
    Ok(start.elapsed().as_secs_f64())
}

/// A time for people.
fn period(seconds: f64) -> String {
    match seconds {
        ..100.0 => format!("{seconds:.1} s"),
        ..6000.0 => format!("{:.1} minutes", seconds / 60.0),
        _ => format!("{:.1} hours", seconds / 3600.0),
    }
}
