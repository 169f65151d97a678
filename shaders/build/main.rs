//! Links every shader with its imports (wesl), validates it (naga) and writes what Rust needs to know of it: a module
//! tree that mirrors the folders of WGSL, with each file's constants and shared structs, and a `static` per pass.
//!
//! A mistake in a shader is a build error that names the file.

mod layout;
mod operations;
mod software;
mod source;
mod table;

use std::{
    borrow::Cow,
    collections::BTreeMap,
    env, error, fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use naga::{
    AddressSpace, Expression, Literal, Module,
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};

use layout::Structs;
use software::Reads;
use source::Source;
use table::Table;

/// Folders of WGSL: `common` holds what passes import, `pictures` what draws frames, `sort` and `reduce` passes that
/// several stages run, and each other one the passes of a stage.
const FOLDERS: [&str; 12] = [
    "common",
    "forcing",
    "neighbours",
    "fluid",
    "rods",
    "contact",
    "turbulence",
    "viscosity",
    "commit",
    "sort",
    "reduce",
    "pictures",
];

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

/// WebGPU's default: bytes of memory that the invocations of a workgroup share.
const WORKGROUP_BYTES: u32 = 16384;

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
    let mut for_software = BTreeMap::new();
    let mut reads = Reads::default();
    for source in sources.iter().filter(|source| source.is_pass()) {
        let text = link(&root, &source.name(), &["subgroups", "software"])?;
        let (module, info) = validate(&source.name(), &text)?;
        reads.add(&module, &info);
        for_software.insert(source.name(), (text, module, info));
    }
    for source in &sources {
        if !source.runs() {
            continue;
        }
        let name = source.name();
        let text = link(&root, &name, &["subgroups"])?;
        let (module, info) = validate(&name, &text)?;
        let target = format!("{}.wgsl", name.replace('/', "_"));
        fs::write(out.join(&target), &text)?;
        structs.collect(&name, &module)?;
        if source.folder == "pictures" {
            table.picture(source, &target);
            continue;
        }
        let plain = link(&root, &name, &[])?;
        let mut other = None;
        let of_all = share(&name, &module)?;
        let mut shares = Shares { with_subgroups: of_all, without_subgroups: of_all, in_software: of_all };
        if plain != text {
            shares.without_subgroups = share(&name, &validate(&name, &plain)?.0)?;
            let target = format!("{}_plain.wgsl", name.replace('/', "_"));
            fs::write(out.join(&target), &plain)?;
            other = Some(target);
        }
        let (text, module_in_software, info_in_software) = &for_software[&name];
        shares.in_software = share(&name, module_in_software)?;
        let (text, places) = software::text_for_software(text, module_in_software, info_in_software, &reads)
            .map_err(|error| format!("shaders/{name}.wgsl: for software adapters: {error}"))?;
        validate(&name, &text)?;
        let software = format!("{}_software.wgsl", name.replace('/', "_"));
        fs::write(out.join(&software), &text)?;
        table.pass(source, &target, other.as_deref(), (&software, &places), shares, &module, &info)?;
    }
    fs::write(out.join("shaders.rs"), table.write(&sources, &structs)?)?;
    Ok(())
}

/// How many invocations share the work of one in the texts of a pass: the constant `SHARE` of each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shares {
    pub(crate) with_subgroups: u32,
    pub(crate) without_subgroups: u32,
    pub(crate) in_software: u32,
}

/// `SHARE` of one text; 1 where there is none.
fn share(name: &str, module: &Module) -> Result<u32> {
    let of_name = module.constants.iter().find(|(_, constant)| constant.name.as_deref() == Some("SHARE"));
    match of_name.map(|(_, constant)| &module.global_expressions[constant.init]) {
        None => Ok(1),
        Some(Expression::Literal(Literal::U32(share))) => Ok(*share),
        Some(other) => Err(format!("shaders/{name}.wgsl: SHARE is a u32, not {other:?}").into()),
    }
}

/// The WGSL files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let all: BTreeMap<PathBuf, ()> =
        fs::read_dir(folder)?.map(|entry| Ok((entry?.path(), ()))).collect::<std::io::Result<_>>()?;
    Ok(all.into_keys().filter(|file| file.extension().is_some_and(|extension| extension == "wgsl")).collect())
}

/// The module name of the shader that is linked, by which what it imports can import from it.
const PASS: &str = "pass";

/// Files of WGSL by their module paths, and the shader that is linked by the name of [`PASS`].
struct Files<'a> {
    all: wesl::FileResolver,
    name: &'a str,
}

impl wesl::Resolver for Files<'_> {
    fn resolve_source<'a>(&'a self, path: &wesl::ModulePath) -> std::result::Result<Cow<'a, str>, wesl::ResolveError> {
        let mut path = path.clone();
        if path.components == [PASS] {
            path.components = self.name.split('/').map(str::to_owned).collect();
        }
        self.all.resolve_source(&path)
    }
}

/// Features of the shaders: `subgroups`, their operations; `software`, lanes of a subgroup that need no barrier
/// (`common/lanes.wgsl`).
const FEATURES: [&str; 2] = ["subgroups", "software"];

/// The shader with everything that it imports, and nothing else, under the names as they are written; with these
/// features.
fn link(root: &Path, name: &str, features: &[&str]) -> Result<String> {
    let files = Files { all: wesl::FileResolver::new(root), name };
    let mut compiler = wesl::Wesl::new(root).set_custom_resolver(files);
    compiler.set_mangler(wesl::ManglerKind::None).use_sourcemap(true);
    for feature in FEATURES {
        compiler.set_feature(feature, features.contains(&feature));
    }
    let path: wesl::ModulePath = format!("package::{PASS}").parse()?;
    let linked = compiler.compile(&path).map_err(|error| format!("shaders/{name}.wgsl: {error}"))?;
    Ok(linked.to_string())
}

fn validate(name: &str, text: &str) -> Result<(Module, ModuleInfo)> {
    let shown = |error: String| format!("shaders/{name}.wgsl:\n{error}");
    let module = naga::front::wgsl::parse_str(text).map_err(|error| shown(error.emit_to_string(text)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::SUBGROUP)
        .validate(&module)
        .map_err(|error| shown(error.emit_to_string(text)))?;
    let shared = module.global_variables.iter().filter(|(_, variable)| variable.space == AddressSpace::WorkGroup);
    let bytes: u32 = shared.map(|(_, variable)| module.types[variable.ty].inner.size(module.to_ctx())).sum();
    if bytes > WORKGROUP_BYTES {
        return Err(format!("shaders/{name}.wgsl: {bytes} bytes of a workgroup's memory, of {WORKGROUP_BYTES}").into());
    }
    Ok((module, info))
}
