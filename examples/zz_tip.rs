//! scratch
use windswept::{AdapterChoice, Gpu, Simulation};
use windswept_scene::Scene;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = Gpu::new(&AdapterChoice::Software)?;
    let a: Vec<String> = std::env::args().skip(1).collect();
    let (model, u, step, time): (String, f64, f64, f64) = (a[0].clone(), a[1].parse()?, a[2].parse()?, a[3].parse()?);
    let extra = a.get(4).cloned().unwrap_or_default();
    let bx = if model == "two-way" || model == "particles" {
        "box = { min = [-0.05, -0.06, -0.0145], max = [0.075, 0.018, 0.0145] }"
    } else {
        ""
    };
    let text = format!(
        "{extra}\ninteraction = {{ model = \"{model}\" }}\n[time]\nstep = {step}\nduration = 10.0\n[air]\n{bx}\nwind = [{u}, 0.0, 0.0]\nramp = 0.05\n[hair]\nstrands = 1\npoints = 35\nlength = 0.05\nroots = {{ center = [0.0, 0.0, 0.0], radius = 1e-6 }}\n"
    );
    let scene = Scene::parse(&text)?;
    let mut sim = Simulation::new(&gpu, &scene)?;
    let root = sim.frame()?.hair.positions[0];
    let n = (time / step) as u64;
    let mut last = vec![];
    sim.step(n)?;
    for _ in 0..20 {
        sim.step(((0.1 / step) as u64 / 20).max(1))?;
        let f = sim.frame()?;
        let t = f.hair.positions[34];
        last.push([(t[0] - root[0]) / 0.05, (t[1] - root[1]) / 0.05]);
    }
    let m = |k: usize| last.iter().map(|x| x[k]).sum::<f32>() / 20.0;
    let (mx, my) = (m(0), m(1));
    let rms = (last.iter().map(|x| (x[0] - mx).powi(2) + (x[1] - my).powi(2)).sum::<f32>() / 20.0).sqrt();
    let r = sim.report()?;
    println!(
        "{model} U={u} dt={step}: tip {mx:.4} {my:.4} rms {rms:.1e} {:?} {:?} stretch {:?} ms {:?}",
        r.warnings, r.strand_steps, r.max_stretch, r.ms_per_step
    );
    Ok(())
}
