//! Links every pass with its imports (wesl), validates it (naga) and writes the table that the engine reads:
//! per pass its name, text, workgroup size and bindings with their access; per shared struct its layout.
//!
//! A mistake in a shader is a build error that names the file.

use std::{
    collections::BTreeMap,
    env, error,
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use naga::{
    AddressSpace, Module, ShaderStage, StorageAccess, TypeInner,
    valid::{Capabilities, ValidationFlags, Validator},
};

/// One folder a heading; `common` holds what they import.
const FOLDERS: [&str; 7] = ["grid", "fluid", "turbulence", "rods", "wind", "contact", "guard"];
/// WebGPU's default: storage buffers that one stage may bind.
const STORAGE_BUFFERS: usize = 8;
/// Structs shared with Rust, which asserts their layout.
const SHARED: [&str; 18] = [
    "Params",
    "Status",
    "Strand",
    "Segment",
    "Band",
    "Root",
    "Health",
    "RodStrand",
    "RodPoint",
    "RodSegment",
    "PointHistory",
    "SegmentHistory",
    "Factor",
    "Keyframe",
    "Body",
    "Placed",
    "Mesh",
    "Wave",
];

/// Per struct: size, and fields with their offsets [bytes].
type Layouts = BTreeMap<String, (u32, Vec<(String, u32)>)>;

fn main() -> ExitCode {
    match build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn build() -> Result<(), Box<dyn error::Error>> {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(env::var("OUT_DIR")?);
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=common");

    let mut table = String::new();
    let mut layouts = Layouts::new();
    for folder in FOLDERS {
        println!("cargo::rerun-if-changed={folder}");
        writeln!(
            table,
            "/// Passes of `shaders/{folder}/`.\npub mod {folder} {{\n    use crate::{{Access, Binding, Pass}};"
        )?;
        let mut files: Vec<_> =
            fs::read_dir(root.join(folder))?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
        files.sort();
        for file in files.iter().filter(|file| file.extension().is_some_and(|e| e == "wgsl")) {
            let stem = file.file_stem().and_then(|s| s.to_str()).ok_or("a shader's name is not UTF-8")?;
            let name = format!("{folder}/{stem}");
            let text = link(&root, &name)?;
            let module = validate(&name, &text)?;
            let target = format!("/{folder}_{stem}.wgsl");
            fs::write(out.join(&target[1..]), &text)?;
            write_pass(&mut table, &name, stem, file, &target, &module)?;
            collect_layouts(&module, &mut layouts);
        }
        writeln!(table, "}}")?;
    }
    write_layouts(&mut table, &layouts)?;
    fs::write(out.join("passes.rs"), table)?;
    Ok(())
}

/// The pass with everything that it imports, and nothing else; names as written.
fn link(root: &Path, name: &str) -> Result<String, Box<dyn error::Error>> {
    let mut compiler = wesl::Wesl::new(root);
    compiler.set_mangler(wesl::ManglerKind::None).use_condcomp(false).use_sourcemap(true);
    let path: wesl::ModulePath = format!("package::{}", name.replace('/', "::")).parse()?;
    let linked = compiler.compile(&path).map_err(|error| format!("shaders/{name}.wgsl: {error}"))?;
    Ok(linked.to_string())
}

fn validate(name: &str, text: &str) -> Result<Module, String> {
    let module = naga::front::wgsl::parse_str(text)
        .map_err(|error| format!("shaders/{name}.wgsl:\n{}", error.emit_to_string(text)))?;
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| format!("shaders/{name}.wgsl:\n{}", error.emit_to_string(text)))?;
    Ok(module)
}

fn write_pass(
    table: &mut String,
    name: &str,
    stem: &str,
    file: &Path,
    target: &str,
    module: &Module,
) -> Result<(), Box<dyn error::Error>> {
    let [entry] = module.entry_points.as_slice() else {
        return Err(format!("shaders/{name}.wgsl: a pass has exactly one entry point").into());
    };
    if entry.stage != ShaderStage::Compute {
        return Err(format!("shaders/{name}.wgsl: a pass is a compute shader").into());
    }
    let [workgroup, 1, 1] = entry.workgroup_size else {
        return Err(format!("shaders/{name}.wgsl: workgroups have one dimension").into());
    };
    let mut bindings = BTreeMap::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = variable.binding else { continue };
        let access = match variable.space {
            AddressSpace::Uniform => "Uniform",
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => "ReadWrite",
            AddressSpace::Storage { .. } => "Read",
            other => return Err(format!("shaders/{name}.wgsl: {other:?} cannot be bound").into()),
        };
        let stride = match module.types[variable.ty].inner {
            TypeInner::Array { stride, .. } => stride,
            TypeInner::Struct { span, .. } => span,
            ref other => return Err(format!("shaders/{name}.wgsl: {other:?} cannot be bound").into()),
        };
        let buffer = variable.name.clone().unwrap_or_default();
        bindings.insert(binding.binding, (buffer, access, stride));
    }
    if bindings.values().filter(|(_, access, _)| *access != "Uniform").count() > STORAGE_BUFFERS {
        return Err(format!("shaders/{name}.wgsl: more than {STORAGE_BUFFERS} storage buffers").into());
    }
    let head = fs::read_to_string(file)?;
    let head: Vec<_> = head.lines().map_while(|line| line.strip_prefix("// ")).collect();
    let title = head
        .join(" ")
        .split_inclusive(['.', ':'])
        .next()
        .unwrap_or_default()
        .replace(':', ".")
        .replace(['[', ']'], "|");
    writeln!(table, "    /// {title}")?;
    writeln!(table, "    pub static {}: Pass = Pass {{", stem.to_uppercase())?;
    writeln!(
        table,
        "        name: {name:?}, workgroup: {workgroup}, source: include_str!(concat!(env!(\"OUT_DIR\"), {target:?})),\n        bindings: &["
    )?;
    for (binding, (buffer, access, stride)) in &bindings {
        writeln!(
            table,
            "            Binding {{ binding: {binding}, name: {buffer:?}, access: Access::{access}, stride: {stride} }},"
        )?;
    }
    writeln!(table, "        ],\n    }};")?;
    Ok(())
}

fn collect_layouts(module: &Module, layouts: &mut Layouts) {
    for (_, kind) in module.types.iter() {
        let (Some(name), TypeInner::Struct { members, span }) = (&kind.name, &kind.inner) else { continue };
        if SHARED.contains(&name.as_str()) {
            let fields = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect();
            layouts.insert(name.clone(), (*span, fields));
        }
    }
}

fn write_layouts(table: &mut String, layouts: &Layouts) -> std::fmt::Result {
    writeln!(
        table,
        "/// Sizes and offsets \\[bytes\\] of the structs that Rust and WGSL share, as naga lays them out.\npub mod layout {{"
    )?;
    for (name, (span, fields)) in layouts {
        writeln!(
            table,
            "    /// `{name}`.\n    #[allow(non_snake_case)]\n    pub mod {name} {{\n        /// Size.\n        pub const SIZE: usize = {span};"
        )?;
        for (field, offset) in fields {
            writeln!(
                table,
                "        /// Offset.\n        #[allow(non_upper_case_globals)]\n        pub const {field}: usize = {offset};"
            )?;
        }
        writeln!(table, "    }}")?;
    }
    writeln!(table, "}}")
}
