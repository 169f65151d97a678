//! `windswept measure`: numbers that describe the film of a run's hair.

use serde_json::json;
use windswept_export::{ExportError, Kind, MeasureOptions, measure_film};
use windswept_scene::Scene;

use crate::arguments::MeasureArguments;
use crate::console::Console;
use crate::failure::Failure;
use crate::output::Output;
use crate::render::{OF_HAIR, OF_SCENE, check_folder, there};

pub(crate) fn measure(arguments: &MeasureArguments, console: &mut Console<'_>) -> Result<(), Failure> {
    check_folder(&arguments.dir)?;
    let output = Output::of_run(&arguments.dir);
    let scene = Scene::load(there(output.scene(), OF_SCENE)?)?;
    let film = there(output.film(Kind::Hair), OF_HAIR)?;
    let options = MeasureOptions { from: arguments.from, to: arguments.to, gravity: scene.gravity };
    let wind = |time| scene.air.as_ref().map_or([0.0; 3], |air| air.wind_at(time));
    let measured = measure_film(&film, &options, wind).map_err(|error| match error {
        error @ (ExportError::Film { .. } | ExportError::File { .. }) => Failure::Input(error.to_string()),
        error => error.into(),
    })?;
    match arguments.json {
        true => console.print(json!(measured)),
        false => measured.to_string().lines().for_each(|row| console.print(row)),
    }
    Ok(())
}
