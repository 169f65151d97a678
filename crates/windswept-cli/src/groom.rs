//! `windswept groom`: describes the contents of a groom file, and converts one into another format.

use std::{collections::BTreeSet, path::Path};

use windswept_scene::{Curves, GroomFile, GroomFormat, Up};

use crate::arguments::{ConvertOptions, Groom};
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn groom(command: &Groom, console: &mut Console<'_>) -> Result<(), Failure> {
    match command {
        Groom::Info { file, points_per_strand } => info(file, *points_per_strand, console),
        Groom::Convert(options) => convert(options, console),
    }
}

fn info(file: &Path, points_per_strand: Option<u32>, console: &mut Console<'_>) -> Result<(), Failure> {
    let curves = load(file, points_per_strand)?;
    for (what, value) in summary(&curves) {
        console.print(format_args!("{what:<9} {value}"));
    }
    Ok(())
}

/// The curves of a file. A key of a scene that is at fault is an option here.
fn load(file: &Path, points_per_strand: Option<u32>) -> Result<Curves, Failure> {
    Curves::load(file, points_per_strand).map_err(|error| match error.key() {
        Some(key) => {
            let option = key.replace('_', "-");
            Failure::Input(format!("{}: --{option}: {}", error.source_name(), error.message()))
        }
        None => error.into(),
    })
}

/// Content of a groom file, line by line.
fn summary(curves: &Curves) -> Vec<(&'static str, String)> {
    let range = |of: &mut dyn Iterator<Item = f64>| {
        of.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let mut rows = vec![("strands", curves.len().to_string())];
    let [fewest, most] = range(&mut (0..curves.len()).map(|s| curves.strand(s).len() as f64));
    let points = if curves.is_empty() { String::new() } else { format!(", {fewest} to {most} a strand") };
    rows.push(("points", format!("{}{points}", curves.points.len())));
    if !curves.guides.is_empty() {
        let (marked, total) = (curves.marked(), curves.len());
        let others = if marked == 0 { String::new() } else { format!(", {} left to followers", total - marked) };
        rows.push(("guides", format!("{marked} of {total} strands are marked{others}")));
    }
    if let (Some(least), Some(most)) = (curves.groups.iter().min(), curves.groups.iter().max()) {
        let groups: BTreeSet<u32> = curves.groups.iter().copied().collect();
        rows.push(("groups", format!("{}, numbered from {least} to {most}", groups.len())));
    }
    if curves.doubled_ids() > 0 {
        rows.push(("ids", format!("{} strands have the id of a strand before them", curves.doubled_ids())));
    }
    let unit = if curves.unit.is_some() { "m" } else { "units" };
    let scale = curves.unit.unwrap_or(1.0);
    if let Some(corners) = curves.clone().without_padding().0.bounds() {
        rows.push(("box", shown_box(corners.map(|corner| corner.map(|x| scale * x)), unit)));
    }
    if let [thinnest, thickest] = range(&mut curves.radius.iter().copied())
        && thinnest.is_finite()
    {
        rows.push(("radius", format!("{:.3e} to {:.3e} {unit}", scale * thinnest, scale * thickest)));
    }
    rows.push((
        "unit",
        match curves.unit {
            Some(unit) => format!("{unit} m"),
            None => "not in the file: a scene needs hair.scale, the metres per unit".to_owned(),
        },
    ));
    let (fit, dropped) = curves.clone().fit();
    if dropped.padded > 0 {
        rows.push(("padding", format!("behind the tips of {} strands, where a run cuts it off", dropped.padded)));
    }
    if dropped.total() > 0 {
        rows.push(("left out", format!("{} strands, which cannot be simulated: {dropped}", dropped.total())));
    }
    let lengths = |s: usize| fit.strand(s).windows(2).map(|pair| distance(pair[0], pair[1])).sum::<f64>();
    let [shortest, longest] = range(&mut (0..fit.len()).map(lengths));
    if !fit.is_empty() {
        let [from, to] = [shortest, longest].map(|x| digits(scale * longest)(scale * x));
        rows.push(("length", format!("{from} to {to} {unit} along a strand")));
    }
    rows
}

/// The size of a box, and its lower and upper corner, in this unit.
pub(crate) fn shown_box([low, high]: [[f64; 3]; 2], unit: &str) -> String {
    let sides = [0, 1, 2].map(|k| high[k] - low[k]);
    let shown = digits(sides.into_iter().fold(0.0, f64::max));
    let corner = |x: [f64; 3]| x.map(&shown).join(", ");
    format!("{} {unit}, from ({}) to ({})", sides.map(&shown).join(" x "), corner(low), corner(high))
}

/// Shows numbers of which the largest is this, so that what is small has digits too.
fn digits(largest: f64) -> impl Fn(f64) -> String {
    // A 0 has no sign.
    move |x| if largest < 0.01 { format!("{:.3e}", x + 0.0) } else { format!("{:.4}", x + 0.0) }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    [0, 1, 2].map(|k| (a[k] - b[k]).powi(2)).iter().sum::<f64>().sqrt()
}

fn convert(options: &ConvertOptions, console: &mut Console<'_>) -> Result<(), Failure> {
    if options.output.exists() && !options.overwrite {
        let words = format!("{} is there already: --overwrite replaces it", options.output.display());
        return Err(Failure::Input(words));
    }
    GroomFormat::check_output(&options.output)?;
    let curves = load(&options.input, options.points_per_strand)?;
    let up = options.up.unwrap_or(Up::Y);
    let curves = match options.scale.or(curves.unit) {
        Some(scale) => curves.in_metres(scale, up),
        // The unit stays whatever it is.
        None => Curves { unit: None, ..curves.in_metres(1.0, up) },
    };
    let file = GroomFile {
        points: options.points,
        strands: options.strands,
        ..GroomFile::new(options.input.display().to_string())
    };
    let (curves, notes) = file.fitted(curves, options.seed)?;
    for note in notes {
        console.warn(note);
    }
    let lost = curves.save(&options.output).map_err(|error| Failure::Run(error.to_string()))?;
    lost.into_iter().for_each(|what| console.warn(what));
    let (strands, points) = (curves.len(), curves.points.len());
    console.print(format_args!("{}: {strands} strands, {points} points", options.output.display()));
    Ok(())
}
