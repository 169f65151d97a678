//! `windswept measure`: numbers that describe the film of a run's hair.

use serde_json::json;
use windswept_export::{Kind, MeasureOptions, measure_film};
use windswept_scene::Scene;

use crate::arguments::MeasureArguments;
use crate::console::Console;
use crate::failure::Failure;
use crate::finished::{OF_HAIR, OF_SCENE, check_folder, there};
use crate::output::Output;

pub(crate) fn measure(arguments: &MeasureArguments, console: &mut Console<'_>) -> Result<(), Failure> {
    check_folder(&arguments.dir)?;
    let output = Output::of_run(&arguments.dir);
    let (scene, film) = (there(output.scene(), OF_SCENE)?, there(output.film(Kind::Hair), OF_HAIR)?);
    let scene = Scene::load(scene)?;
    let wind = scene.mean_wind()?;
    let options = MeasureOptions { from: arguments.from, to: arguments.to, gravity: scene.gravity };
    // A film that cannot be read or measured is bad input: no file has been written.
    let found = measure_film(&film, &options, wind).map_err(|error| Failure::Input(error.to_string()))?;
    if options.from.is_none() && found.from_s < MeasureOptions::START {
        let end = 2.0 * MeasureOptions::START;
        console.note(format_args!("the film ends before {end} s: it is measured from its first frame on"));
    }
    if arguments.json {
        console.print(json!(found));
    } else {
        console.print_lines(found);
    }
    Ok(())
}
