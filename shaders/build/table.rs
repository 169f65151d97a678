//! The Rust that the build writes: modules as folders and files of WGSL, structs, constants, passes.

use std::{collections::BTreeMap, fmt::Write as _};

use naga::{
    AddressSpace, Module, ShaderStage, StorageAccess, TypeInner,
    valid::{GlobalUse, ModuleInfo},
};

use crate::{
    Result, Shares,
    layout::{Field, Kind, Structs},
    operations::{Operations, operations},
    software::Place,
    source::{Source, StructDocs},
};

/// WebGPU's default: storage buffers that one stage may bind.
const STORAGE_BUFFERS: usize = 8;

/// Statics by folder, as text.
#[derive(Default)]
pub(crate) struct Table {
    statics: BTreeMap<&'static str, String>,
    /// Paths of the passes.
    passes: Vec<String>,
}

impl Table {
    /// Adds a pass of the step: its text in `target`, in `plain` without subgroup operations, in `software` for
    /// software adapters, with these bindings in other places.
    pub(crate) fn pass(
        &mut self,
        source: &Source,
        target: &str,
        plain: Option<&str>,
        (software, places): (&str, &BTreeMap<u32, Place>),
        shares: Shares,
        module: &Module,
        info: &ModuleInfo,
    ) -> Result<()> {
        let file = |target: &str| format!("include_str!(concat!(env!(\"OUT_DIR\"), \"/{target}\"))");
        let plain = plain.map_or_else(|| "None".to_owned(), |target| format!("Some({})", file(target)));
        let name = source.name();
        let fault = |what: &str| format!("shaders/{name}.wgsl: {what}");
        let [entry] = module.entry_points.as_slice() else {
            return Err(fault("a pass has exactly one entry point").into());
        };
        if entry.stage != ShaderStage::Compute {
            return Err(fault("a pass is a compute shader").into());
        }
        let [workgroup, 1, 1] = entry.workgroup_size else {
            return Err(fault("workgroups have one dimension").into());
        };
        let mut bindings = BTreeMap::new();
        for (handle, variable) in module.global_variables.iter() {
            let Some(binding) = &variable.binding else { continue };
            let uses = info.get_entry_point(0)[handle];
            let kind = match variable.space {
                AddressSpace::Uniform => "Uniform",
                AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => "ReadWrite",
                AddressSpace::Storage { .. } => "Read",
                other => return Err(fault(&format!("{other:?} cannot be bound")).into()),
            };
            let stride = match module.types[variable.ty].inner {
                TypeInner::Array { stride, .. } => stride,
                TypeInner::Struct { span, .. } => span,
                ref other => return Err(fault(&format!("{other:?} cannot be bound")).into()),
            };
            let written = uses.intersects(GlobalUse::WRITE | GlobalUse::ATOMIC);
            let read = uses.intersects(GlobalUse::READ | GlobalUse::ATOMIC);
            let in_software = match places.get(&binding.binding) {
                None => format!("Bound::Buffer(BufferKind::{kind})"),
                Some(Place::Uniform) => "Bound::Buffer(BufferKind::Uniform)".to_owned(),
                Some(Place::Texture(texel)) => format!("Bound::Texture {{ texel: {texel} }}"),
            };
            let row = format!(
                "Binding {{ binding: {}, name: {:?}, kind: BufferKind::{kind}, reads: {read}, writes: {written}, \
                stride: {stride}, in_software: {in_software} }}",
                binding.binding,
                variable.name.clone().unwrap_or_default(),
            );
            bindings.insert(binding.binding, (row, kind));
        }
        if bindings.values().filter(|(_, kind)| *kind != "Uniform").count() > STORAGE_BUFFERS {
            return Err(fault(&format!("more than {STORAGE_BUFFERS} storage buffers")).into());
        }
        // A switch that the engine does not set is no variant of `Switch`, which does not compile.
        let names = module.overrides.iter().filter_map(|(_, switch)| switch.name.as_deref());
        let switches: Vec<_> = names.map(|name| format!("crate::Switch::{}", in_title_case(name))).collect();
        let switches = switches.join(", ");
        let text = self.statics.entry(source.folder).or_default();
        let constant = source.stem.to_uppercase();
        writeln!(text, "{}pub static {constant}: Pass = Pass {{", doc(&source.title))?;
        writeln!(text, "name: {name:?}, workgroup: {workgroup}, switches: &[{switches}], source: {},", file(target))?;
        writeln!(text, "source_without_subgroups: {plain}, source_for_software: {},", file(software))?;
        let Shares { with_subgroups, without_subgroups, in_software } = shares;
        writeln!(
            text,
            "shares: Shares {{ with_subgroups: {with_subgroups}, without_subgroups: {without_subgroups}, in_software: \
            {in_software} }},"
        )?;
        let Operations { invocation, own_batch, other_batch, more } = operations(module, info);
        writeln!(
            text,
            "operations: Operations {{ invocation: {invocation}, own_batch: {own_batch}, other_batch: {other_batch}, \
            more: {more} }},"
        )?;
        let rows: Vec<_> = bindings.into_values().map(|(row, _)| row).collect();
        writeln!(text, "bindings: &[{}],\n}};", rows.join(",\n"))?;
        self.passes.push(format!("{}::{constant}", source.folder));
        Ok(())
    }

    /// Adds a shader of the pictures.
    pub(crate) fn picture(&mut self, source: &Source, target: &str) {
        let text = self.statics.entry(source.folder).or_default();
        let constant = source.stem.to_uppercase();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{}pub static {constant}: Picture = Picture {{ name: {:?}, source: \
            include_str!(concat!(env!(\"OUT_DIR\"), \"/{target}\")) }};",
            doc(&source.title),
            source.name(),
        );
    }

    /// The whole text that the build writes.
    pub(crate) fn write(mut self, sources: &[Source], structs: &Structs) -> Result<String> {
        let mut owners: BTreeMap<&str, (&Source, &StructDocs)> = BTreeMap::new();
        for source in sources {
            for (name, docs) in source.structs.iter().filter(|(name, _)| structs.by_name.contains_key(*name)) {
                if let Some((other, _)) = owners.insert(name, (source, docs)) {
                    return Err(format!("{} and {} both declare {name}", other.name(), source.name()).into());
                }
            }
        }
        let path = |name: &str| {
            owners.get(name).map(|(source, _)| format!("crate::{}::{}::{name}", source.folder, source.stem))
        };
        let mut text = String::new();
        let mut folders: Vec<&'static str> = Vec::new();
        for source in sources {
            if !folders.contains(&source.folder) {
                folders.push(source.folder);
            }
        }
        for folder in folders {
            writeln!(text, "/// What `shaders/{folder}/` declares.\npub mod {folder} {{")?;
            if let Some(statics) = self.statics.remove(folder) {
                writeln!(
                    text,
                    "use crate::{};\n{statics}",
                    if folder == "pictures" {
                        "Picture"
                    } else {
                        "{Binding, Bound, BufferKind, Operations, Pass, Shares}"
                    }
                )?;
            }
            for source in sources.iter().filter(|source| source.folder == folder) {
                let own: Vec<_> = owners.iter().filter(|(_, (owner, _))| std::ptr::eq(*owner, source)).collect();
                if own.is_empty() && source.constants.is_empty() {
                    continue;
                }
                writeln!(
                    text,
                    "/// What `shaders/{}.wgsl` declares.\n#[allow(missing_docs, clippy::approx_constant)] // as the \
                    WGSL has them\npub mod {} {{",
                    source.name(),
                    source.stem
                )?;
                for constant in &source.constants {
                    writeln!(
                        text,
                        "{}pub const {}: {} = {};",
                        doc(&constant.doc),
                        constant.name,
                        constant.kind,
                        constant.value
                    )?;
                }
                for (name, (_, docs)) in own {
                    write_struct(&mut text, name, docs, structs, &path)?;
                }
                writeln!(text, "}}")?;
            }
            writeln!(text, "}}")?;
        }
        writeln!(
            text,
            "/// Every pass.\npub static PASSES: [&Pass; {}] = [{}];",
            self.passes.len(),
            references(&self.passes)
        )?;
        writeln!(
            text,
            "/// Bytes of a row of texels in every texture.\npub const TEXTURE_ROW: u32 = {};",
            crate::software::ROW
        )?;
        Ok(text)
    }
}

/// A word in capitals as Rust spells an enum's variant.
fn in_title_case(word: &str) -> String {
    let (first, rest) = word.split_at(word.len().min(1));
    first.to_owned() + &rest.to_lowercase()
}

fn references(paths: &[String]) -> String {
    paths.iter().map(|path| format!("&{path}")).collect::<Vec<_>>().join(", ")
}

fn write_struct(
    text: &mut String,
    name: &str,
    docs: &StructDocs,
    structs: &Structs,
    path: &dyn Fn(&str) -> Option<String>,
) -> Result<()> {
    let layout = &structs.by_name[name];
    writeln!(
        text,
        "{}#[repr(C)]\n#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]",
        doc(&docs.doc)
    )?;
    writeln!(text, "pub struct {name} {{")?;
    for (i, field) in layout.fields.iter().enumerate() {
        match field {
            Field::Named { name, kind } => {
                let kind = match kind {
                    Kind::Plain(kind) => kind.clone(),
                    Kind::Struct { name, count } => {
                        let path = path(name).ok_or_else(|| format!("{name} is declared nowhere at a line's start"))?;
                        count.map_or(path.clone(), |n| format!("[{path}; {n}]"))
                    }
                };
                writeln!(text, "{}pub {name}: {kind},", doc(docs.fields.get(name).map_or("", String::as_str)))?;
            }
            Field::Gap { words } => writeln!(text, "#[doc(hidden)] pub gap_{i}: [u32; {words}],")?,
        }
    }
    writeln!(text, "}}")?;
    writeln!(text, "impl Default for {name} {{ fn default() -> Self {{ bytemuck::Zeroable::zeroed() }} }}")?;
    writeln!(text, "const _: () = assert!(size_of::<{name}>() == {});", layout.size)?;
    Ok(())
}

/// The doc comment that says `words`, on a line; empty without words.
fn doc(words: &str) -> String {
    if words.is_empty() {
        return String::new();
    }
    let escaped = words.replace('[', "\\[").replace(']', "\\]").replace('<', "\\<").replace('>', "\\>");
    format!("/// {escaped}\n")
}
