//! Links every shader with its imports (wesl), validates it (naga) and writes what Rust needs to know of it: a module tree
//! that mirrors the folders of WGSL, with each file's constants and shared structs, and a `static` per pass.
//!
//! A mistake in a shader is a build error that names the file.

mod layout;
mod source;
mod table;

use std::{
    collections::BTreeMap,
    env, error, fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use naga::{
    Module,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use layout::Structs;
use source::Source;
use table::Table;

/// Folders of WGSL: `common` holds what passes import, `pictures` what draws frames, each other one the passes of a heading.
const FOLDERS: [&str; 10] =
    ["common", "grid", "fluid", "coarse", "turbulence", "rods", "wind", "contact", "guard", "pictures"];

/// Result of the build, whose error is shown.
pub(crate) type Result<T> = std::result::Result<T, Box<dyn error::Error>>;

fn main() -> ExitCode {
    match build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn build() -> Result<()> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(env::var("OUT_DIR")?);
    println!("cargo::rerun-if-changed=build");

    let mut sources = Vec::new();
    for folder in FOLDERS {
        println!("cargo::rerun-if-changed={folder}");
        sources.extend(
            files(&root.join(folder))?.iter().map(|file| Source::read(folder, file)).collect::<Result<Vec<_>>>()?,
        );
    }
    let mut structs = Structs::default();
    let mut table = Table::default();
    for source in &sources {
        if !source.runs() {
            continue;
        }
        let name = source.name();
        let text = link(&root, &name)?;
        let (module, info) = validate(&name, &text)?;
        let target = format!("{}.wgsl", name.replace('/', "_"));
        fs::write(out.join(&target), &text)?;
        structs.collect(&name, &module)?;
        match source.folder {
            "pictures" => table.picture(source, &target),
            _ => table.pass(source, &target, &module, &info)?,
        }
    }
    fs::write(out.join("shaders.rs"), table.write(&sources, &structs)?)?;
    Ok(())
}

/// The WGSL files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let all: BTreeMap<PathBuf, ()> =
        fs::read_dir(folder)?.map(|entry| Ok((entry?.path(), ()))).collect::<std::io::Result<_>>()?;
    Ok(all.into_keys().filter(|file| file.extension().is_some_and(|extension| extension == "wgsl")).collect())
}

/// The shader with everything that it imports, and nothing else, under the names as they are written.
fn link(root: &Path, name: &str) -> Result<String> {
    let mut compiler = wesl::Wesl::new(root);
    compiler.set_mangler(wesl::ManglerKind::None).use_condcomp(false).use_sourcemap(true);
    let path: wesl::ModulePath = format!("package::{}", name.replace('/', "::")).parse()?;
    let linked = compiler.compile(&path).map_err(|error| format!("shaders/{name}.wgsl: {error}"))?;
    Ok(linked.to_string())
}

fn validate(name: &str, text: &str) -> Result<(Module, ModuleInfo)> {
    let shown = |error: String| format!("shaders/{name}.wgsl:\n{error}");
    let module = naga::front::wgsl::parse_str(text).map_err(|error| shown(error.emit_to_string(text)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| shown(error.emit_to_string(text)))?;
    Ok((module, info))
}
