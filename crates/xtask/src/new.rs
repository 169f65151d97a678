//! `cargo xtask new pass STAGE/NAME`, `new key TABLE.NAME` and `new format NAME`: the skeleton of something new in all
//! its places. It compiles, and its test fails with a sentence that says what to write.

use std::fs;

use crate::{Result, root};

/// A text to add to a file.
struct Place {
    path: String,
    /// The added text goes before the end of the part that begins here; at the end of the file if there is none.
    inside: Option<(&'static str, &'static str)>,
    text: String,
}

/// Writes a pass of a stage: shader, line of the step, reference function, comparison.
pub(crate) fn pass(name: &str) -> Result {
    let (stage, pass) = named(name, '/', "STAGE/NAME")?;
    let step = format!("crates/windswept/src/step/{stage}.rs");
    if !root().join(&step).exists() {
        return Err(format!("{name}: no stage is called {stage}: {step} is not there"));
    }
    let upper = pass.to_uppercase();
    let shader = format!(
        "// {pass}: say what the pass computes, with its formula and the source.
import package::common::{{params::params, dispatch::{{invocation, WORKGROUP}}, status::frozen}};

@group(0) @binding(2) var<storage, read_write> new_velocity: array<vec4f>;   // m/s

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {{
    let i = invocation(id, groups);
    if (i >= params.particles) | frozen() {{ return; }}
    new_velocity[i] += vec4f(0.0);
}}
"
    );
    let reference = format!(
        "
/// Say what the pass computes, with its equation: velocities of all particles \\[m/s\\].
#[must_use]
pub fn {pass}(velocity: &[glam::DVec3]) -> Vec<glam::DVec3> {{
    velocity.to_vec()
}}
"
    );
    let test = format!(
        "
#[test]
fn {pass}_is_that_of_the_reference() {{
    panic!(
        \"compare what {stage}/{pass} leaves with windswept_reference::{stage}::{pass}, on several sizes and in the walk of the stage; \\
         call the function in the stage's run; plant a fault of the pass in FAULTS\"
    );
}}
"
    );
    write_all(&[
        Place { path: format!("shaders/{stage}/{pass}.wgsl"), inside: None, text: shader },
        Place {
            path: step,
            inside: Some(("\npub fn record(", "\n}\n")),
            text: format!("\n    r.run(&windswept_shaders::{stage}::{upper}, \"{pass}\", plan.sizes.particles);"),
        },
        Place { path: format!("crates/windswept-reference/src/{stage}.rs"), inside: None, text: reference },
        Place { path: format!("tests/passes/{stage}.rs"), inside: None, text: test },
    ])
}

/// Writes a key of a scene that a shader reads: declaration, parameter in WGSL and in Rust, test.
pub(crate) fn key(name: &str) -> Result {
    let (table, key) = named(name, '.', "TABLE.NAME")?;
    let declared = ["scene.rs", "scene/rods.rs", "scene/turbulence.rs", "scene/viscosity.rs"];
    let heading = format!("/// `[{table}]`");
    let found = declared.iter().map(|file| format!("crates/windswept-scene/src/{file}"));
    let file =
        found.into_iter().find(|file| fs::read_to_string(root().join(file)).is_ok_and(|text| text.contains(&heading)));
    let Some(file) = file else {
        return Err(format!("{name}: no table [{table}] of numbers is declared in windswept-scene"));
    };
    let test = format!(
        "
#[test]
fn {table}_{key}_does_what_it_says() {{
    panic!(\"say in its declaration what {table}.{key} is, in which range and unit; read params.{table}_{key} in a pass, and test what it changes\");
}}
"
    );
    write_all(&[
        Place {
            path: file,
            inside: Some((leaked(heading), "\n    }\n")),
            text: format!("\n        /// Say what it is.\n        {key}: f64 = NonNegative, \"\", Value(0.0);"),
        },
        Place {
            path: "shaders/common/params.wgsl".to_owned(),
            inside: Some(("struct Params", "\n}\n")),
            text: format!("\n    {table}_{key}: f32,   // say what it is, with its unit"),
        },
        Place {
            path: "crates/windswept/src/upload/params.rs".to_owned(),
            inside: Some(("let mut params = Params {", "\n        ..Params::default()")),
            text: format!("\n        {table}_{key}: scene.{table}.{key} as f32,"),
        },
        Place { path: "crates/windswept-scene/tests/format.rs".to_owned(), inside: None, text: test },
    ])
}

/// Writes a format of frames: its sink, its row of the table, test.
pub(crate) fn format(name: &str) -> Result {
    if !is_word(name) {
        return Err(format!("{name}: expected a word of small letters, digits and _"));
    }
    let sink = format!(
        "//! Say what the files of format {name} hold, and who reads them.

use windswept::Frame;

use crate::{{ExportError, FrameSink, Start}};

/// Writes frames as {name}.
#[derive(Debug)]
pub(crate) struct Film;

impl Film {{
    pub(crate) fn new(_start: &Start<'_>) -> Self {{
        Self
    }}
}}

impl FrameSink for Film {{
    fn append(&mut self, _frame: &Frame) -> Result<(), ExportError> {{
        Ok(())
    }}

    fn finish(self: Box<Self>) -> Result<(), ExportError> {{
        Ok(())
    }}
}}
"
    );
    let test = format!(
        "//! Files of format {name}, read by another program.

#[test]
fn another_program_reads_{name}() {{
    panic!(\"write a frame in format {name}, and compare what another program reads of it with the frame\");
}}
"
    );
    write_all(&[
        Place { path: format!("crates/windswept-export/src/{name}.rs"), inside: None, text: sink },
        Place {
            path: "crates/windswept-export/src/lib.rs".to_owned(),
            inside: Some(("\nmod folder;", "\n")),
            text: format!("\nmod {name};"),
        },
        Place {
            path: "crates/windswept-export/src/sink.rs".to_owned(),
            inside: Some(("pub const FORMATS", "\n];")),
            text: format!(
                "\n    Format {{\n        name: \"{name}\",\n        writes: \"say what\",\n        files: &[\"film.{name}\"],\n        \
                 made_again: true,\n        create: |start| Ok(Box::new(crate::{name}::Film::new(start))),\n    }},"
            ),
        },
        Place { path: format!("crates/windswept-export/tests/{name}.rs"), inside: None, text: test },
    ])
}

/// The two words of a name.
fn named<'a>(name: &'a str, between: char, expected: &str) -> Result<(&'a str, &'a str)> {
    let words = name.split_once(between).filter(|(first, second)| is_word(first) && is_word(second));
    words.ok_or_else(|| format!("{name}: expected {expected}, of small letters, digits and _"))
}

fn is_word(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_lowercase())
        && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

/// The text for as long as the program runs, which is short.
fn leaked(text: String) -> &'static str {
    text.leak()
}

/// Adds all texts, or none where one does not fit.
fn write_all(places: &[Place]) -> Result {
    let mut written = Vec::new();
    for Place { path, inside, text } in places {
        let file = root().join(path);
        let whole = match (fs::read_to_string(&file), inside) {
            (Err(_), None) => text.clone(),
            (Ok(_), None) if path.starts_with("shaders/") || path.contains("windswept-export/") => {
                return Err(format!("{path} is there already"));
            }
            (Ok(before), None) => before + text,
            (Ok(before), Some((start, end))) => {
                let at =
                    before.find(start).and_then(|at| Some(at + start.len() + before[at + start.len()..].find(end)?));
                let at = at.ok_or_else(|| format!("{path} has no `{}`", start.trim()))?;
                format!("{}{text}{}", &before[..at], &before[at..])
            }
            (Err(error), Some(_)) => return Err(format!("{path}: {error}")),
        };
        written.push((path, file, whole));
    }
    for (path, file, whole) in written {
        fs::write(&file, whole).map_err(|error| format!("{path}: {error}"))?;
        println!("{path}");
    }
    Ok(())
}
