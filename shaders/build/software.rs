//! The same pass for a software adapter: what it only reads lies in uniforms and textures instead of storage buffers.
//!
//! Mesa's software driver reads a storage buffer lane by lane. It reads a read-only storage texture eight lanes at once, some ten times
//! as fast, and a constant place of a uniform once for all. A texture has the words of an array in texels of one, two or four, row by row;
//! an element of more words takes several texels. Texels and the uniforms' words hold bits, and a load turns them into what the shader
//! reads, so that all texts of a pass give the same bits.
//!
//! A constant place of a uniform is read once only if no branch comes before, so that a text first copies what it reads of uniforms.
//!
//! A texture is a copy of the array's buffer. Where the processor reads storage buffers quickly, only arrays from which passes gather
//! are worth it, and those that no pass writes, which are copied once in a step and compile faster as textures. Each pass has a text for
//! such processors ([`Textures::Gathered`]).
//!
//! In the other text ([`Textures::All`]) some passes read an array that they also write, and no element of it after they have written
//! it. They read a texture beside the buffer that they write.

use std::collections::{BTreeMap, BTreeSet};

use naga::{
    AddressSpace, ArraySize, Handle, Module, Scalar, ScalarKind, StructMember, Type, TypeInner,
    valid::{GlobalUse, ModuleInfo},
};

use crate::Result;

/// Bytes of a row of texels in every texture.
pub(crate) const ROW: u32 = 32768;

/// Names, as shaders bind them, of the arrays that passes gather from, whose elements are read several times, and of `points`, `segments`
/// and `strands`, which no pass writes. They are textures on every software adapter.
const GATHERED: [&str; 37] = [
    "band_velocity",
    "cell_count",
    "cell_rows",
    "cell_start",
    "curvature",
    "density",
    "deposited",
    "distances",
    "exchange",
    "field",
    "final_velocity",
    "flow",
    "flow_position",
    "gradients",
    "inverse_mass",
    "members",
    "multiplier",
    "neighbour_list",
    "new_velocity",
    "nodes",
    "points",
    "position",
    "predicted",
    "rubbing",
    "sampled",
    "segments",
    "smoothed",
    "smoother",
    "smoother_curvature",
    "sorted",
    "sorted_position",
    "squeezed",
    "strands",
    "stress",
    "taps",
    "velocity",
    "vorticity",
];

/// Names of the arrays of which passes read each element about once in a step, and write it. They are textures where storage buffers are
/// read slowly.
const STREAMED: [&str; 20] = [
    "air_id",
    "air_id_before",
    "brought",
    "cell_place",
    "coarse_change",
    "confinement",
    "correction",
    "drag_impulse",
    "felt_shift",
    "grip",
    "orientation",
    "point_history",
    "pressed",
    "pressed_before",
    "rod_points",
    "rod_strands",
    "scattered",
    "segment_history",
    "shift",
    "wind_change",
];

/// Names of the arrays that have so few elements that they are uniforms, and how many elements those are.
const FEW: [(&str, u32); 3] = [("missed", 2), ("coarse_total", 2), ("confinement_total", 2)];

/// Passes that read no element of an array after they have written it. They read a texture of it where storage buffers are read slowly.
const READ_FIRST: [&str; 13] = [
    "coarse/push",
    "contact/air",
    "fluid/friction",
    "fluid/limit",
    "fluid/move",
    "fluid/place",
    "fluid/push",
    "fluid/velocity",
    "guard/commit_hair",
    "turbulence/confine",
    "turbulence/strengthen",
    "wind/drag",
    "wind/react",
];

/// What the number of a buffer's binding is less than that of the texture beside it.
const BESIDE: u32 = 32;

/// What stands in the text for software adapters in place of a storage buffer.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place {
    /// A uniform.
    Uniform,
    /// A uniform array of so many elements.
    Few(u32),
    /// A texture of texels of so many bytes.
    Texture(u32),
    /// The buffer, to write, and a texture, to read, with the number of its binding and the bytes of its texels.
    Beside(u32, u32),
}

/// Which arrays a text reads from textures, as the table has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Textures {
    All,
    Gathered,
}

impl Textures {
    /// In the order of the table.
    pub(crate) const BOTH: [Self; 2] = [Self::All, Self::Gathered];

    /// What the files of such texts are called, after the pass.
    pub(crate) fn suffix(self) -> &'static str {
        match self {
            Self::All => "software",
            Self::Gathered => "software_gathers",
        }
    }

    /// Features of the shaders in such texts.
    pub(crate) fn features(self) -> &'static [&'static str] {
        match self {
            Self::All => &["subgroups", "software"],
            Self::Gathered => &["subgroups", "software"],
        }
    }

    fn has(self, array: &str) -> bool {
        GATHERED.contains(&array) || (self == Self::All && STREAMED.contains(&array))
    }
}

/// The text of a pass for software adapters, and what is in another place there, by the numbers of the bindings. Names of
/// what is are added to `found`, and so is that of a pass of [`READ_FIRST`].
pub(crate) fn text_for_software(
    textures: Textures,
    pass: &str,
    text: &str,
    module: &Module,
    info: &ModuleInfo,
    found: &mut BTreeSet<String>,
) -> Result<(String, BTreeMap<u32, Place>)> {
    let (mut text, mut places) = (text.to_owned(), BTreeMap::new());
    let mut words = BTreeMap::new();
    for (handle, variable) in module.global_variables.iter() {
        let (Some(name), Some(binding)) = (variable.name.as_deref(), &variable.binding) else { continue };
        let AddressSpace::Storage { access } = variable.space else { continue };
        let uses = info.get_entry_point(0)[handle];
        let written = uses.contains(GlobalUse::WRITE);
        let reads_first = textures == Textures::All && uses.contains(GlobalUse::READ) && READ_FIRST.contains(&pass);
        if uses.contains(GlobalUse::ATOMIC) || (written && !reads_first) {
            continue;
        }
        let mode = if access.contains(naga::StorageAccess::STORE) { "read_write" } else { "read" };
        let declaration = format!("var<storage, {mode}> {name}: ");
        let (before, rest) = text.split_once(&declaration).ok_or_else(|| format!("no `{declaration}`"))?;
        let (_, after) = rest.split_once(';').ok_or_else(|| format!("no end of `{declaration}`"))?;
        let few = FEW.iter().find(|(few, _)| *few == name).map(|(_, count)| *count);
        let (made, place) = match (&module.types[variable.ty].inner, few) {
            (TypeInner::Struct { members, span }, _) if !written => {
                let declaration = format!("var<uniform> {name}: array<vec4<u32>, {}>;", span.div_ceil(16));
                let read = words.entry(name.to_owned()).or_default();
                let mut with_words = |text| with_words(text, name, module, members, read);
                (format!("{}{declaration}{}", with_words(before)?, with_words(after)?), Place::Uniform)
            }
            (TypeInner::Array { base, size: ArraySize::Dynamic, .. }, Some(count)) if !written => {
                let kind = type_name(module, *base)?;
                (format!("{before}var<uniform> {name}: array<{kind}, {count}>;{after}"), Place::Few(count))
            }
            (TypeInner::Array { base, size: ArraySize::Dynamic, stride }, None) if textures.has(name) => {
                let (before, after, texel) = (loaded(before, name)?, loaded(after, name)?, texel(*stride));
                let load = load(name, module, *base, *stride)?;
                let texture = format!("var {name}_texels: texture_storage_2d<{}, read>;\n\n{load}", format_of(texel));
                if written {
                    found.insert(pass.to_owned());
                    let number = binding.binding + BESIDE;
                    let buffer = format!("{declaration}array<{}>;", type_name(module, *base)?);
                    let both = format!("{buffer}\n\n@group(0) @binding({number})\n{texture}");
                    (format!("{before}{both}{after}"), Place::Beside(number, texel))
                } else {
                    (format!("{before}{texture}{after}"), Place::Texture(texel))
                }
            }
            _ => continue,
        };
        text = made;
        places.insert(binding.binding, place);
        found.insert(name.to_owned());
    }
    Ok((with_copies_of_uniforms(&text, &words)?, places))
}

/// The text with a private copy of each uniform, which the entry point makes before all else; of a uniform of words, a copy of
/// each word whose place is a number in the text.
///
/// The driver reads a constant place of a uniform once for all lanes if no branch comes before, and else lane by lane.
fn with_copies_of_uniforms(text: &str, words: &BTreeMap<String, BTreeSet<u32>>) -> Result<String> {
    const UNIFORM: &str = "var<uniform> ";
    let (mut made, mut copies, mut rest) = (String::new(), String::new(), text);
    while let Some((before, after)) = rest.split_once(UNIFORM) {
        let (declaration, after) = after.split_once(';').ok_or("the declaration of a uniform does not end")?;
        let (name, kind) = declaration.split_once(": ").ok_or("a uniform has no type")?;
        let taken: Vec<_> = match words.get(name) {
            Some(words) => {
                made += &format!("{before}{UNIFORM}{declaration};");
                let from = |word: &u32| format!("{name}[{}u][{}u]", word / 4, word % 4);
                words.iter().map(|word| (copy_of_word(name, *word), "u32", from(word))).collect()
            }
            None => {
                let uniform = format!("{name}_uniform");
                made += &format!("{before}{UNIFORM}{uniform}: {kind};");
                vec![(name.to_owned(), kind, uniform)]
            }
        };
        for (copy, kind, from) in taken {
            made += &format!("\n\nvar<private> {copy}: {kind};");
            copies += &format!("    {copy} = {from};\n");
        }
        rest = after;
    }
    made += rest;
    let entry = made.find("fn main(").ok_or("no entry point `main`")?;
    let body = made[entry..].find("{\n").ok_or("the entry point has no body")? + entry + 2;
    made.insert_str(body, &copies);
    Ok(made)
}

/// What the copy of a uniform's word is called.
fn copy_of_word(name: &str, word: u32) -> String {
    format!("{name}_word_{word}")
}

/// An error if a name of [`GATHERED`], [`STREAMED`], [`FEW`] or [`READ_FIRST`] was of no use: it may have been renamed.
pub(crate) fn all_found(found: &BTreeSet<String>) -> Result<()> {
    let mut names = GATHERED.into_iter().chain(STREAMED).chain(FEW.map(|(name, _)| name)).chain(READ_FIRST);
    match names.find(|name| !found.contains(*name)) {
        Some(name) => Err(format!("shaders/build/software.rs: no array or pass {name} is read elsewhere").into()),
        None => Ok(()),
    }
}

/// Bytes of a texel for elements of so many bytes: the most of 4, 8 and 16 of which they are a multiple.
fn texel(stride: u32) -> u32 {
    1 << stride.trailing_zeros().min(4)
}

/// The format of texels of so many bytes.
fn format_of(texel: u32) -> &'static str {
    match texel {
        4 => "r32uint",
        8 => "rg32uint",
        _ => "rgba32uint",
    }
}

/// A function that loads an element of the array `name` from its texture.
fn load(name: &str, module: &Module, base: Handle<Type>, stride: u32) -> Result<String> {
    let texel = texel(stride);
    let (texels, per_row) = (stride / texel, ROW / texel);
    let (across, down) = (per_row - 1, per_row.ilog2());
    let loads: String = (0..texels)
        .map(|k| {
            let at = if texels > 1 { format!("({texels}u * e + {k}u)") } else { "e".to_owned() };
            format!("    let t{k} = textureLoad({name}_texels, vec2u({at} & {across}u, {at} >> {down}u));\n")
        })
        .collect();
    let (kind, element) = (type_name(module, base)?, element(module, base, 0, texel)?);
    Ok(format!("fn load_{name}(e: u32) -> {kind} {{\n{loads}    return {element};\n}}\n"))
}

/// The text with words of the uniform `name` in place of each `name.member`, atomic or not. Words whose place is a number are
/// those of the copies, and are added to `read`.
fn with_words(
    text: &str,
    name: &str,
    module: &Module,
    members: &[StructMember],
    read: &mut BTreeSet<u32>,
) -> Result<String> {
    let mut word = |scalar: Scalar, first: u32, index: &str| {
        let bits = match index.trim_end_matches('u').parse::<u32>() {
            Ok(index) => {
                read.insert(first + index);
                copy_of_word(name, first + index)
            }
            Err(_) => format!("{name}[({first}u + u32({index})) / 4u][({first}u + u32({index})) % 4u]"),
        };
        if scalar.kind == ScalarKind::Uint { bits } else { format!("bitcast<{}>({bits})", scalar_name(scalar)) }
    };
    let mut made = String::new();
    let mut rest = text;
    let pattern = format!("{name}.");
    while let Some(at) = rest.find(&pattern) {
        let (before, from) = rest.split_at(at);
        let inside = &from[pattern.len()..];
        if ends_in_word(before) {
            made += before;
            made += &pattern;
            rest = inside;
            continue;
        }
        let end = inside.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(inside.len());
        let (field, after) = inside.split_at(end);
        let member = members.iter().find(|member| member.name.as_deref() == Some(field));
        let member = member.ok_or_else(|| format!("{name} has no member {field:?}"))?;
        let first = member.offset / 4;
        let scalar = |ty: Handle<Type>| match module.types[ty].inner {
            TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => Ok(scalar),
            ref other => Err(format!("{name}.{field}: {other:?} is no word")),
        };
        let (before, value, after) = match (&module.types[member.ty].inner, after.strip_prefix('[')) {
            (TypeInner::Array { base, .. }, Some(inside)) => {
                let (index, after) = closed(inside)?;
                (before, word(scalar(*base)?, first, index), after)
            }
            _ => (before, word(scalar(member.ty)?, first, "0"), after),
        };
        let (before, after) = match (before.strip_suffix("atomicLoad(&"), after.strip_prefix(')')) {
            (Some(before), Some(after)) => (before, after),
            _ => (before, after),
        };
        made += before;
        made += &value;
        rest = after;
    }
    Ok(made + rest)
}

/// Whether a text ends within a word, or with the dot before a member.
fn ends_in_word(text: &str) -> bool {
    text.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.')
}

/// What is inside a bracket that a text begins in, and what follows the bracket.
fn closed(text: &str) -> Result<(&str, &str)> {
    let mut depth = 1;
    let end = text.find(|c| {
        depth += match c {
            '[' => 1,
            ']' => -1,
            _ => 0,
        };
        depth == 0
    });
    let end = end.ok_or_else(|| format!("a bracket is not closed: {text:?}"))?;
    Ok((&text[..end], &text[end + 1..]))
}

/// The text with `load_name(u32(index))` in place of each `name[index]` that is read.
fn loaded(text: &str, name: &str) -> Result<String> {
    let mut made = String::new();
    let mut rest = text;
    let pattern = format!("{name}[");
    while let Some(at) = rest.find(&pattern) {
        let (before, from) = rest.split_at(at);
        made += before;
        let inside = &from[pattern.len()..];
        if ends_in_word(before) {
            made += &pattern;
            rest = inside;
            continue;
        }
        let (index, after) = closed(inside)?;
        let index = loaded(index, name)?;
        let load = format!("load_{name}(u32({index}))");
        let (path, behind) = path(after)?;
        (made, rest) = match assigned(behind) {
            None => (made + &load, after),
            Some(("", _)) => (format!("{made}{name}[{index}]"), after),
            Some((operator, behind)) => {
                let (value, behind) = behind.split_once(';').ok_or("an assignment does not end")?;
                let value = loaded(value.trim_start(), name)?;
                (format!("{made}{name}[{index}]{path} = {load}{path} {operator} ({value});"), behind)
            }
        };
    }
    Ok(made + rest)
}

/// Members and elements that a text begins with, and what follows them.
fn path(text: &str) -> Result<(&str, &str)> {
    let mut rest = text;
    loop {
        rest = if let Some(inside) = rest.strip_prefix('[') {
            closed(inside)?.1
        } else if let Some(member) = rest.strip_prefix('.') {
            member.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_')
        } else {
            return Ok(text.split_at(text.len() - rest.len()));
        };
    }
}

/// The operator of an assignment to what stands before a text, and what follows it: none in `=`, `+` in `+=`.
fn assigned(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    if text.starts_with("==") {
        return None;
    }
    let end = text.find(|c| !"+-*/%&|^".contains(c))?;
    let (operator, rest) = text.split_at(end);
    rest.strip_prefix('=').map(|rest| (operator, rest))
}

/// A scalar as WGSL spells it.
fn scalar_name(scalar: Scalar) -> &'static str {
    match scalar.kind {
        ScalarKind::Float => "f32",
        ScalarKind::Sint => "i32",
        _ => "u32",
    }
}

/// A type as WGSL spells it.
fn type_name(module: &Module, ty: Handle<Type>) -> Result<String> {
    Ok(match &module.types[ty] {
        Type { name: Some(name), .. } => name.clone(),
        Type { inner: TypeInner::Scalar(scalar), .. } => scalar_name(*scalar).to_owned(),
        Type { inner: TypeInner::Vector { size, scalar }, .. } => {
            format!("vec{}<{}>", *size as u32, scalar_name(*scalar))
        }
        other => return Err(format!("{other:?} cannot be in a texture").into()),
    })
}

/// The value of a type at an offset of an element whose texels, each of so many bytes, are `t0`, `t1` and so on.
fn element(module: &Module, ty: Handle<Type>, offset: u32, texel: u32) -> Result<String> {
    let kind = type_name(module, ty)?;
    let word = |k: u32| {
        format!("t{}.{}", (offset + 4 * k) / texel, ["x", "y", "z", "w"][((offset + 4 * k) % texel / 4) as usize])
    };
    Ok(match &module.types[ty].inner {
        TypeInner::Scalar(_) => format!("bitcast<{kind}>({})", word(0)),
        TypeInner::Vector { size, .. } => {
            let count = *size as u32;
            format!("bitcast<{kind}>(vec{count}u({}))", (0..count).map(word).collect::<Vec<_>>().join(", "))
        }
        TypeInner::Struct { members, .. } => {
            let values = members.iter().map(|member| element(module, member.ty, offset + member.offset, texel));
            format!("{kind}({})", values.collect::<Result<Vec<_>>>()?.join(", "))
        }
        other => return Err(format!("{other:?} cannot be in a texture").into()),
    })
}
