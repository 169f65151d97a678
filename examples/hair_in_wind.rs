//! Draws docs/hair-in-wind.svg: hair at rest in the wind beside the curves in which it must stand, its drag over that
//! of a stiff one, and the air in a porous strip of strands. `cargo run --example hair_in_wind`

use std::error::Error;

use plotters::prelude::*;
use windswept::{AdapterChoice, Gpu, Simulation};
use windswept_reference::elastica::{Hair, REAL};
use windswept_scene::{Air, Fibre, Hair as Strand, Model, Rods, Roots, Scene, Stiffness, StrandStiffness, Time};
use windswept_validate::internals::{STRIP_BLOCKAGE, in_strip, through};

const WINDS: [f64; 3] = [1.0, 3.0, 10.0];
const COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(230, 159, 0), RGBColor(213, 94, 0)];
/// \[s\]
const STEP: f64 = 1.38e-3;

/// The hair in the model `drag`, after a second and a half.
fn blown(gpu: &Gpu, hair: &Hair, points: u32, damping: f64) -> Result<Simulation, Box<dyn Error>> {
    let mut scene = Scene::new(Time::new(STEP, 10.0));
    scene.gravity = [0.0, -hair.gravity, 0.0];
    scene.interaction.model = Some(Model::Drag);
    scene.rods = Rods { sleep: false, damping, ..Rods::default() };
    let air = Air::default().wind([hair.wind, 0.0, 0.0]);
    scene.air = Some(Air { ramp: 0.0, kinematic_viscosity: hair.viscosity, ..air });
    let stretch = REAL.youngs_modulus * std::f64::consts::PI * hair.radius.powi(2);
    let (bend, poissons_ratio) = (hair.bend_stiffness(), 0.38);
    let stiffness = Stiffness::Direct(StrandStiffness { stretch, bend, twist: bend / 1.38, poissons_ratio });
    let fibre = Fibre { radius: hair.radius, stiffness, ..Fibre::default() };
    let strand = Strand::drawn(1, points, hair.length, Roots::disc([0.0; 3], 1e-9));
    scene.hair = vec![Strand { fibre, ..strand }];
    let mut simulation = Simulation::new(gpu, &scene)?;
    simulation.step((1.5 / STEP) as u64)?;
    Ok(simulation)
}

fn main() -> Result<(), Box<dyn Error>> {
    let gpu = Gpu::new(&AdapterChoice::from_flag(None))?;
    println!("adapter: {}", gpu.info());
    let root = SVGBackend::new("docs/hair-in-wind.svg", (1350, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let panels = root.split_evenly((1, 3));
    shapes(&gpu, &panels[0])?;
    reconfiguration(&gpu, &panels[1])?;
    strip(&gpu, &panels[2])?;
    root.present()?;
    Ok(())
}

type Panel<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn shapes(gpu: &Gpu, panel: &Panel<'_>) -> Result<(), Box<dyn Error>> {
    let mut chart = ChartBuilder::on(panel)
        .caption("A hair of 50 mm: lines exact, dots measured (34 segments)", ("sans-serif", 15))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(-0.05..1.05, -1.05..0.05)?;
    chart.configure_mesh().light_line_style(WHITE).x_desc("downwind / L").y_desc("up / L").draw()?;
    for (wind, colour) in WINDS.into_iter().zip(COLOURS) {
        let hair = Hair { wind, ..REAL };
        let exact = hair.shape().into_iter().step_by(10).map(|[x, down]| (x, -down));
        let points = blown(gpu, &hair, 35, 20.0)?.frame()?.hair.positions;
        let at = |x: &[f32; 3]| {
            let [dx, dy] = [0, 1].map(|axis| f64::from(x[axis] - points[0][axis]) / hair.length);
            Circle::new((dx, dy), 3, colour.filled())
        };
        chart
            .draw_series(LineSeries::new(exact, colour.stroke_width(2)))?
            .label(format!("{wind} m/s"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
        chart.draw_series(points.iter().map(at))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE.filled())
        .border_style(BLACK)
        .draw()?;
    Ok(())
}

fn reconfiguration(gpu: &Gpu, panel: &Panel<'_>) -> Result<(), Box<dyn Error>> {
    let mut chart = ChartBuilder::on(panel)
        .caption("R, drag over that of a stiff hair: line exact, dots measured", ("sans-serif", 15))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d((0.3..3000.0).log_scale(), (0.05..1.2).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("Ca = 1/2 ρ 2r U² L³/EI")
        .y_desc("R")
        .x_label_formatter(&|ca| format!("{ca:.0}"))
        .y_label_formatter(&|r| format!("{r:.1}"))
        .draw()?;
    let exact = (0..=38).map(|k| 0.3 * 10.0_f64.powf(f64::from(k) / 10.0)).filter(|ca| *ca < 3000.0);
    let exact = exact.map(|ca| (ca, Hair::with_cauchy_number(ca).reconfiguration()));
    chart.draw_series(LineSeries::new(exact, BLACK.stroke_width(2)))?;
    // U^(-2/3) is Ca^(-1/3).
    let slope = [20.0_f64, 2500.0].map(|ca| (ca, 0.7 * (20.0 / ca).cbrt() * 0.55));
    chart.draw_series(DashedLineSeries::new(slope, 6, 4, BLACK.stroke_width(1)))?;
    chart.draw_series([Text::new("slope -1/3", (200.0, 0.21), ("sans-serif", 13))])?;
    for cauchy in [1.0, 10.0, 100.0, 1000.0] {
        let hair = Hair::with_cauchy_number(cauchy);
        let simulation = blown(gpu, &hair, 69, 60.0)?;
        let engine = simulation.engine();
        let impulse: f64 = engine.read(&engine.state().drag_impulse)?.iter().map(|j| f64::from(j[0])).sum();
        let measured = impulse / STEP / (hair.length * hair.drag(0.0)[0]);
        println!("Ca = {cauchy}: R {measured:.4}, exact {:.4}", hair.reconfiguration());
        chart.draw_series([Circle::new((cauchy, measured), 4, COLOURS[0].filled())])?;
    }
    Ok(())
}

fn strip(gpu: &Gpu, panel: &Panel<'_>) -> Result<(), Box<dyn Error>> {
    let mut chart = ChartBuilder::on(panel)
        .caption("Air in a porous strip: line by Taylor's theory, dots measured", ("sans-serif", 15))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d((0.1..10.0).log_scale(), 0.3..1.05)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("k, drag of the strip over 1/2 ρ u²")
        .y_desc("u / U")
        .x_label_formatter(&|k| format!("{k}"))
        .draw()?;
    let theory = (0..=40).map(|i| 0.1 * 10.0_f64.powf(f64::from(i) / 20.0)).map(|k| (k, through(k, STRIP_BLOCKAGE)));
    chart.draw_series(LineSeries::new(theory, BLACK.stroke_width(2)))?;
    for k in [0.25, 0.5, 1.0, 2.0, 4.0] {
        let measured = in_strip(gpu, k)?;
        println!("k = {k}: u/U {measured:.4}, theory {:.4}", through(k, STRIP_BLOCKAGE));
        chart.draw_series([Circle::new((k, measured), 4, COLOURS[0].filled())])?;
    }
    Ok(())
}
