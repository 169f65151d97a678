//! `windswept spectrum`: the energy of the air's eddies by their size, before and after, as numbers and as a picture.

use std::f64::consts::{PI, SQRT_2};
use std::fmt::Display;
use std::path::{Path, PathBuf};

use plotters::prelude::*;
use serde_json::json;
use windswept::ops::{OpsError, Particles};
use windswept::{AdapterChoice, Frame, Gpu};
use windswept_export::{Kind, VtkHdfReader};
use windswept_scene::{AtomicFile, CheckedAir, CheckedScene, Filter, InitialState, Scene};

use crate::arguments::SpectrumOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::finished::open;
use crate::output::Output;

/// The smallest scale of the ladder in particle spacings: smaller eddies the particles cannot carry.
const SMALLEST: f64 = 1.25;
/// Steps of the ladder.
const RUNG: f64 = SQRT_2;

/// Energies of one scale at the first and at the last frame [m²/s²].
struct Row {
    /// [m]
    scale: f64,
    before: f64,
    after: f64,
}

pub(crate) fn spectrum(options: &SpectrumOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    let run = FinishedRun::open(&options.dir)?;
    let picture = place(options)?;
    let scales = run.scales(options.scales.as_deref());
    let gpu = Gpu::new(&AdapterChoice::from_flag(options.adapter.as_deref()))?;
    console.note(format_args!("running on {}", gpu.info()));
    let (first, last) = (run.air.frame(0)?, run.air.frame(run.air.times().len() - 1)?);
    // Scales of the options are measured as the scene measures its bands; the ladder up to the box by the grid, as a
    // direct sum would take minutes.
    let bands = &run.scene.turbulence.bands;
    let filter = |scale: f64| match options.scales.is_some() || bands.iter().any(|band| band.scale == scale) {
        true => run.scene.turbulence.filter,
        false => Filter::default(),
    };
    let [before, after] = [&first, &last].map(|frame| run.energies(&gpu, frame, &scales, filter));
    let energies = before?.into_iter().zip(after?);
    let rows: Vec<Row> =
        scales.iter().zip(energies).map(|(&scale, (before, after))| Row { scale, before, after }).collect();

    if options.json {
        let bands: Vec<_> = rows
            .iter()
            .map(|row| json!({ "scale": row.scale, "m2_per_s2_at_start": row.before, "m2_per_s2": row.after }))
            .collect();
        console.print(json!({ "time_s": [first.time, last.time], "band_energy": bands }));
    } else {
        console.print(format_args!("{:>10}  {:>16}  {:>16}", "scale [mm]", time(&first), time(&last)));
        for row in &rows {
            console.print(format_args!("{:>10.2}  {:>16.3e}  {:>16.3e}", 1e3 * row.scale, row.before, row.after));
        }
        console.print("mean over the air of |u|^2/2 of the band, about the mean wind [m^2/s^2]");
    }
    let failed = |error: &dyn Display| Failure::Run(format!("{}: {error}", picture.display()));
    let drawn = draw(&rows, [first.time, last.time]).map_err(|error| failed(&error))?;
    AtomicFile::write(&picture, drawn.as_bytes()).map_err(|error| failed(&error))?;
    console.note(picture.display());
    Ok(())
}

/// The file of the picture.
fn place(options: &SpectrumOptions) -> Result<PathBuf, Failure> {
    let path = options.picture.clone().unwrap_or_else(|| options.dir.join("spectrum.svg"));
    Output::of_run(&options.dir).check_place(&path, "--picture", true)?;
    Ok(path)
}

fn time(frame: &Frame) -> String {
    format!("t = {:.3} s", frame.time)
}

/// The air of a run that is over, or was stopped.
struct FinishedRun {
    scene: CheckedScene,
    settings: CheckedAir,
    initial: InitialState,
    air: VtkHdfReader,
}

impl FinishedRun {
    fn open(dir: &Path) -> Result<Self, Failure> {
        let output = Output::of_run(dir);
        let (scene, air) = (output.scene(), output.film(Kind::Air));
        for path in [&scene, &air] {
            if !path.is_file() {
                return Err(Failure::Input(format!(
                    "{}: is missing: expected the folder of a run with air",
                    path.display()
                )));
            }
        }
        let scene = Scene::load(&scene)?.check()?;
        let initial = InitialState::new(&scene)?;
        let air = open(&air, Kind::Air)?;
        let no_air = || Failure::Input(format!("{}: the run has no air particles", dir.display()));
        let settings = scene.air.clone().filter(|_| !initial.air.positions.is_empty()).ok_or_else(no_air)?;
        if air.times().is_empty() {
            return Err(Failure::Input(format!("{}: no frame was finished", dir.display())));
        }
        Ok(Self { scene, settings, initial, air })
    }

    /// Scales to measure, in rising order [m]: those asked for, or the scene's and a ladder from what particles carry
    /// to the box.
    fn scales(&self, asked: Option<&[f64]>) -> Vec<f64> {
        let air = &self.initial.air;
        // The band's wave 2πs/√2 fits the box.
        let largest = air.size.min_element() / (SQRT_2 * PI);
        let ladder = std::iter::successors(Some(SMALLEST * air.volume.cbrt()), |scale| Some(scale * RUNG));
        let mut scales: Vec<f64> = match asked {
            Some(scales) => scales.to_vec(),
            None => {
                let bands = self.scene.turbulence.bands.iter().map(|band| band.scale);
                bands.chain(ladder.take_while(|scale| *scale <= largest)).collect()
            }
        };
        scales.sort_by(f64::total_cmp);
        scales.dedup();
        scales
    }

    /// Energy per scale of the air about the mean wind [m²/s²].
    fn energies(
        &self,
        gpu: &Gpu,
        frame: &Frame,
        scales: &[f64],
        filter: impl Fn(f64) -> Filter,
    ) -> Result<Vec<f64>, Failure> {
        let (air, wind) = (&self.initial.air, self.settings.wind_at(frame.time));
        let rows = |rows: &[[f32; 3]], less: [f64; 3]| -> Vec<[f64; 3]> {
            rows.iter().map(|row| [0, 1, 2].map(|axis| f64::from(row[axis]) - less[axis])).collect()
        };
        let (positions, velocities) =
            (rows(&frame.air.positions, air.min.to_array()), rows(&frame.air.velocities, wind));
        let particles = Particles {
            positions: &positions,
            velocities: &velocities,
            mass: air.mass,
            rest_density: air.mass / air.volume,
            radius: self.settings.kernel_radius,
            bounds: Some(air.size.to_array()),
        };
        let energy = |&scale: &f64| {
            particles.band_energy(gpu, scale, filter(scale)).map_err(|error| match error {
                OpsError::Argument { name: "scale", what } => Failure::Input(format!("a scale of {scale:e} m: {what}")),
                error => error.into(),
            })
        };
        scales.iter().map(energy).collect()
    }
}

/// Both spectra on log axes, as SVG; a band without energy is not drawn.
fn draw(rows: &[Row], times: [f64; 2]) -> Result<String, Box<dyn std::error::Error>> {
    let seen = |energy: fn(&Row) -> f64| -> Vec<(f64, f64)> {
        rows.iter().map(|row| (1e3 * row.scale, energy(row))).filter(|(_, energy)| *energy > 0.0).collect()
    };
    let lines = [seen(|row| row.before), seen(|row| row.after)];
    let bounds = |value: fn(&(f64, f64)) -> f64, least: f64| {
        let values = lines.iter().flatten().map(value);
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        if low <= high { (low / 1.5).max(high * 1e-9)..high * 1.5 } else { least..10.0 * least }
    };
    let mut picture = String::new();
    let root = SVGBackend::with_string(&mut picture, (640, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .caption("Energy of the air by size of eddies", ("sans-serif", 18))
        .build_cartesian_2d(bounds(|point| point.0, 1.0).log_scale(), bounds(|point| point.1, 1e-6).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("scale s [mm]; the band's wavelength is 4.44 s")
        .y_desc("mean of |u|²/2 [m²/s²]")
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .draw()?;
    // Colours that colour-blind eyes tell apart (Okabe & Ito 2008).
    for ((line, colour), time) in lines.into_iter().zip([RGBColor(0, 114, 178), RGBColor(213, 94, 0)]).zip(times) {
        chart.draw_series(line.iter().map(|point| Circle::new(*point, 3, colour.filled())))?;
        chart
            .draw_series(LineSeries::new(line, colour.stroke_width(2)))?
            .label(format!("t = {time:.3} s"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    }
    chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.2)).draw()?;
    root.present()?;
    drop((chart, root));
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A GPU that is lost under way is a failed run, status 1; a scale that cannot be is bad input, status 2.
    #[test]
    fn a_lost_gpu_is_no_bad_input() {
        let gpu = Gpu::new(&AdapterChoice::Software).expect("the software adapter");
        let particles =
            Particles { velocities: &[[1.0, 0.0, 0.0]], bounds: Some([0.1; 3]), ..Particles::at(&[[0.05; 3]]) };
        let status = |scale| {
            let measured = particles.band_energy(&gpu, scale, Filter::default());
            measured.map_or_else(|error| Failure::from(error).status(), |_| 0)
        };
        assert_eq!([status(0.009), status(-1.0)], [0, 2]);
        gpu.device().destroy();
        assert_eq!(status(0.009), 1);
    }
}
