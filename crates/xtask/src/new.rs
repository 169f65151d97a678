//! `cargo xtask new pass STAGE/NAME`, `new key TABLE.NAME` and `new format NAME`: the skeleton of something new in all
//! its places. It compiles, and its test fails with a sentence that says what to write.

use std::fs;

use crate::{Result, root};

/// A text, the file that it goes into, and its place there.
struct Place {
    path: String,
    at: At,
    text: String,
}

/// Place of a text in a file.
enum At {
    /// The whole of a new file.
    New,
    /// The end of the file.
    End,
    /// Before the second text, behind the first.
    Inside(String, &'static str),
}

/// Writes the skeleton of a `pass`, a `key` or a `format`.
pub(crate) fn write(kind: &str, name: &str) -> Result {
    let written = filled(&places(kind, name)?)?;
    for (path, text) in written {
        fs::write(root().join(&path), text).map_err(|error| format!("{path}: {error}"))?;
        println!("{path}");
    }
    Ok(())
}

fn places(kind: &str, name: &str) -> Result<Vec<Place>> {
    match kind {
        "pass" => pass(name),
        "key" => key(name),
        "format" => format(name),
        other => Err(format!("new {other}: expected pass, key or format")),
    }
}

/// A pass of a stage: shader, line of the step, reference function, comparison.
fn pass(name: &str) -> Result<Vec<Place>> {
    let (stage, pass) = named(name, '/', "STAGE/NAME")?;
    let step = format!("crates/windswept-engine/src/step/{stage}.rs");
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
        \"compare what {stage}/{pass} leaves with windswept_reference::{stage}::{pass}, on several sizes and in ROWS; \\
         call the function in the stage's run, and then its observer; plant a fault of the pass in FAULTS\"
    );
}}
"
    );
    Ok(vec![
        Place { path: format!("shaders/{stage}/{pass}.wgsl"), at: At::New, text: shader },
        Place {
            path: step,
            at: At::Inside("\npub fn record(".to_owned(), "\n}\n"),
            text: format!("\n    r.run(&windswept_shaders::{stage}::{upper}, \"{pass}\", r.sizes().particles);"),
        },
        Place { path: format!("crates/windswept-reference/src/{stage}.rs"), at: At::End, text: reference },
        Place { path: format!("tests/passes/{stage}.rs"), at: At::End, text: test },
    ])
}

/// A key of a scene that a shader reads: declaration, parameter in WGSL and in Rust, test.
fn key(name: &str) -> Result<Vec<Place>> {
    let (table, key) = named(name, '.', "TABLE.NAME")?;
    let declared = ["scene.rs", "scene/rods.rs", "scene/turbulence.rs", "scene/viscosity.rs"];
    let heading = format!("/// `[{table}]`");
    let found = declared.iter().map(|file| format!("crates/windswept-scene/src/{file}"));
    let file =
        found.into_iter().find(|file| fs::read_to_string(root().join(file)).is_ok_and(|text| text.contains(&heading)));
    let Some(file) = file else {
        return Err(format!("{name}: no table [{table}] of numbers is declared in windswept-scene"));
    };
    Ok(vec![
        Place {
            path: file,
            at: At::Inside(heading, "\n    }\n"),
            text: format!("\n        /// Say what it is.\n        {key}: f64 = NonNegative, \"\", Value(0.0);"),
        },
        Place {
            path: "shaders/common/params.wgsl".to_owned(),
            at: At::Inside("struct Params".to_owned(), "\n}\n"),
            text: format!("\n    {table}_{key}: f32,   // say what it is, with its unit"),
        },
        Place {
            path: "crates/windswept-engine/src/upload/params.rs".to_owned(),
            at: At::Inside("let mut params = Params {".to_owned(), "\n        ..Params::default()"),
            text: format!("\n        {table}_{key}: scene.{table}.{key} as f32,"),
        },
        Place {
            path: "tests/keys.rs".to_owned(),
            at: At::Inside("const COMMON: &[(&str, &str)] = &[".to_owned(), "\n];"),
            text: format!(
                "\n    (\"{table}.{key}\", \"'another value, which changes the result once a pass reads it'\"),"
            ),
        },
    ])
}

/// A format of frames: its sink, its row of the table, test.
fn format(name: &str) -> Result<Vec<Place>> {
    if !is_word(name) {
        return Err(format!("{name}: expected a word of small letters, digits and _"));
    }
    let sink = format!(
        "//! Say what the files of format {name} hold, and who reads them.

use windswept_engine::Frame;

use crate::error::ExportError;
use crate::sink::{{FrameSink, Start}};

/// Writes frames as {name}.
#[derive(Debug)]
pub(crate) struct Sink;

impl Sink {{
    pub(crate) fn new(_start: &Start<'_>) -> Self {{
        Self
    }}
}}

impl FrameSink for Sink {{
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
        "
#[test]
fn another_program_reads_{name}() {{
    panic!(\"write a frame in format {name}, and compare what another program reads of it with the frame\");
}}
"
    );
    Ok(vec![
        Place { path: format!("crates/windswept-export/src/{name}.rs"), at: At::New, text: sink },
        Place {
            path: "crates/windswept-export/src/lib.rs".to_owned(),
            at: At::Inside("\nmod folder;".to_owned(), "\n"),
            text: format!("\nmod {name};"),
        },
        Place {
            path: "crates/windswept-export/src/formats.rs".to_owned(),
            at: At::Inside("pub const FORMATS".to_owned(), "\n];"),
            text: format!(
                "\n    Format {{\n        name: \"{name}\",\n        writes: \"say what\",\n        files: &[\"hair.{name}\"],\n        \
                 made_again: true,\n        create: Some(|start| Ok(Box::new(crate::{name}::Sink::new(start)))),\n        \
                 film: None,\n    }},"
            ),
        },
        Place { path: "crates/windswept-export/tests/formats.rs".to_owned(), at: At::End, text: test },
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

/// The files with their texts added, by their paths; an error where one does not fit.
fn filled(places: &[Place]) -> Result<Vec<(String, String)>> {
    let fill = |Place { path, at, text }: &Place| {
        let before = fs::read_to_string(root().join(path));
        let whole = match (before, at) {
            (Ok(_), At::New) => return Err(format!("{path} is there already")),
            (Err(_), At::New) => text.clone(),
            (Err(error), _) => return Err(format!("{path}: {error}")),
            (Ok(before), At::End) => before + text,
            (Ok(before), At::Inside(start, end)) => {
                let missing = || format!("{path} has no `{}`, or no end of it", start.trim());
                let (head, rest) = before.split_once(start.as_str()).ok_or_else(missing)?;
                let (inside, tail) = rest.split_once(*end).ok_or_else(missing)?;
                format!("{head}{start}{inside}{text}{end}{tail}")
            }
        };
        Ok((path.clone(), whole))
    };
    places.iter().map(fill).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every skeleton finds its places in the tree as it is, and each text is added once.
    #[test]
    fn skeletons_fit_the_tree() {
        for (kind, name, count) in [("pass", "fluid/dummy", 4), ("key", "rods.dummy", 4), ("format", "dummy", 4)] {
            let places = places(kind, name).unwrap_or_else(|error| panic!("{kind}: {error}"));
            let files = filled(&places).unwrap_or_else(|error| panic!("{kind}: {error}"));
            assert_eq!(files.len(), count);
            for (place, (path, text)) in places.iter().zip(&files) {
                assert_eq!(text.matches(&place.text).count(), 1, "{path}");
            }
        }
        for (kind, name, words) in [
            ("pass", "flow/dummy", "no stage is called flow"),
            ("pass", "fluid/density", "is there already"),
            ("key", "dummy.key", "no table [dummy]"),
            ("format", "Bad name", "expected a word"),
            ("shader", "dummy", "expected pass, key or format"),
        ] {
            let refused = places(kind, name).and_then(|places| filled(&places)).err().unwrap_or_default();
            assert!(refused.contains(words), "{kind} {name}: {refused}");
        }
    }
}
