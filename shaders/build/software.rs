//! The same pass for a software adapter: arrays that it only reads lie in uniforms and textures instead of storage
//! buffers.
//!
//! Mesa's software driver reads a storage buffer lane by lane. It reads a read-only storage texture eight lanes at
//! once, some ten times as fast, and a constant place of a uniform once for all. A texture has the words of an array in
//! texels of one, two or four, row by row; an element of more words takes several texels. Texels hold bits, and a load
//! turns them into what the shader reads, so that all texts of a pass give the same bits.
//!
//! A texture is a copy of the array's buffer, which is worth it for arrays whose elements some pass reads in a loop,
//! and for those that no pass writes, which are copied once in a step and compile faster as textures.

use std::collections::{BTreeMap, BTreeSet};

use naga::{
    AddressSpace, ArraySize, Block, Expression, Function, GlobalVariable, Handle, Module, Scalar, ScalarKind,
    Statement, StructMember, Type, TypeInner, VectorSize,
    valid::{GlobalUse, ModuleInfo},
};

use crate::Result;

/// Bytes of a row of texels in every texture.
pub(crate) const ROW: u32 = 32768;

/// Replacement of a storage buffer in the software variant.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place {
    /// A uniform.
    Uniform,
    /// A texture of texels of so many bytes.
    Texture(u32),
}

/// Which arrays passes read, by their names as shaders bind them.
#[derive(Default)]
pub(crate) struct Reads {
    /// Some pass reads elements of these in a loop.
    gathered: BTreeSet<String>,
    /// Some pass writes these.
    written: BTreeSet<String>,
}

impl Reads {
    /// Adds those of a pass.
    pub(crate) fn add(&mut self, module: &Module, info: &ModuleInfo) {
        for (handle, variable) in module.global_variables.iter() {
            let written = info.get_entry_point(0)[handle].intersects(GlobalUse::ATOMIC | GlobalUse::WRITE);
            if let (true, Some(name)) = (written, &variable.name) {
                self.written.insert(name.clone());
            }
        }
        self.add_loops(module, &module.entry_points[0].function, &module.entry_points[0].function.body, false);
    }

    fn add_loops(&mut self, module: &Module, function: &Function, block: &Block, in_loop: bool) {
        for statement in block {
            match statement {
                Statement::Emit(range) if in_loop => {
                    let loads = range.clone().filter_map(|handle| match function.expressions[handle] {
                        Expression::Load { pointer } => variable_of(function, pointer),
                        _ => None,
                    });
                    self.gathered.extend(loads.filter_map(|variable| module.global_variables[variable].name.clone()));
                }
                Statement::Call { function, .. } => {
                    let called = &module.functions[*function];
                    self.add_loops(module, called, &called.body, in_loop);
                }
                Statement::Block(block) => self.add_loops(module, function, block, in_loop),
                Statement::If { accept, reject, .. } => {
                    self.add_loops(module, function, accept, in_loop);
                    self.add_loops(module, function, reject, in_loop);
                }
                Statement::Switch { cases, .. } => {
                    cases.iter().for_each(|case| self.add_loops(module, function, &case.body, in_loop));
                }
                Statement::Loop { body, continuing, .. } => {
                    self.add_loops(module, function, body, true);
                    self.add_loops(module, function, continuing, true);
                }
                _ => {}
            }
        }
    }

    /// Whether the array is worth a texture.
    fn in_texture(&self, name: &str) -> bool {
        self.gathered.contains(name) || !self.written.contains(name)
    }
}

/// The global variable that a pointer leads into.
fn variable_of(function: &Function, pointer: Handle<Expression>) -> Option<Handle<GlobalVariable>> {
    match function.expressions[pointer] {
        Expression::GlobalVariable(variable) => Some(variable),
        Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => variable_of(function, base),
        _ => None,
    }
}

/// The text of a pass for software adapters, and which arrays lie elsewhere there, by the numbers of their bindings.
pub(crate) fn text_for_software(
    text: &str,
    module: &Module,
    info: &ModuleInfo,
    reads: &Reads,
) -> Result<(String, BTreeMap<u32, Place>)> {
    let (mut text, mut places) = (text.to_owned(), BTreeMap::new());
    for (handle, variable) in module.global_variables.iter() {
        let (Some(name), Some(binding)) = (variable.name.as_deref(), &variable.binding) else { continue };
        let AddressSpace::Storage { access } = variable.space else { continue };
        // A texture does not know the length of its array.
        if info.get_entry_point(0)[handle].intersects(GlobalUse::ATOMIC | GlobalUse::WRITE | GlobalUse::QUERY) {
            continue;
        }
        let mode = if access.contains(naga::StorageAccess::STORE) { "read_write" } else { "read" };
        let declaration = format!("var<storage, {mode}> {name}: ");
        let (before, rest) = text.split_once(&declaration).ok_or_else(|| format!("no `{declaration}`"))?;
        let (kind, after) = rest.split_once(';').ok_or_else(|| format!("no end of `{declaration}`"))?;
        let place;
        (text, place) = match &module.types[variable.ty].inner {
            TypeInner::Struct { members, .. } => {
                let (before, after) = (without_atomics(before, name)?, without_atomics(after, name)?);
                let fields = fields_in_uniform(module, members)?;
                let declared =
                    format!("var<uniform> {name}: {kind}InUniform;\n\nstruct {kind}InUniform {{\n{fields}}}\n");
                (format!("{before}{declared}{after}"), Place::Uniform)
            }
            TypeInner::Array { base, size: ArraySize::Dynamic, stride } if reads.in_texture(name) => {
                let (before, after, texel) = (loaded(before, name)?, loaded(after, name)?, texel(*stride));
                let load = load(name, module, *base, *stride)?;
                let texture = format!("var {name}_texels: texture_storage_2d<{}, read>;\n\n{load}", format_of(texel));
                (format!("{before}{texture}{after}"), Place::Texture(texel))
            }
            _ => continue,
        };
        places.insert(binding.binding, place);
    }
    Ok((with_copies_of_uniforms(&text)?, places))
}

/// The text with a private copy of each uniform, which the entry point makes before all else.
///
/// The driver reads a constant place of a uniform once for all lanes if no branch comes before, and else lane by lane.
fn with_copies_of_uniforms(text: &str) -> Result<String> {
    const UNIFORM: &str = "var<uniform> ";
    let (mut made, mut copies, mut rest) = (String::new(), String::new(), text);
    while let Some((before, after)) = rest.split_once(UNIFORM) {
        let (declaration, after) = after.split_once(';').ok_or("the declaration of a uniform does not end")?;
        let (name, kind) = declaration.split_once(": ").ok_or("a uniform has no type")?;
        made += &format!("{before}{UNIFORM}{name}_uniform: {kind};\n\nvar<private> {name}: {kind};");
        copies += &format!("    {name} = {name}_uniform;\n");
        rest = after;
    }
    made += rest;
    let entry = made.find("fn main(").ok_or("no entry point `main`")?;
    let body = made[entry..].find("{\n").ok_or("the entry point has no body")? + entry + 2;
    made.insert_str(body, &copies);
    Ok(made)
}

/// Members of a struct as they lie in a uniform: without atomics, and up to the first array: a uniform cannot have arrays of
/// words.
fn fields_in_uniform(module: &Module, members: &[StructMember]) -> Result<String> {
    let kinds = members.iter().map_while(|member| match module.types[member.ty].inner {
        TypeInner::Array { .. } => None,
        TypeInner::Atomic(scalar) => Some((member, Ok(scalar_name(scalar).to_owned()))),
        _ => Some((member, type_name(module, member.ty))),
    });
    kinds
        .map(|(member, kind)| Ok(format!("    {}: {},\n", member.name.as_deref().unwrap_or_default(), kind?)))
        .collect()
}

/// The text with plain loads of the members of a struct in place of atomic ones.
fn without_atomics(text: &str, name: &str) -> Result<String> {
    let pattern = format!("atomicLoad(&{name}.");
    let mut parts = text.split(&pattern);
    let mut made = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (member, after) = part.split_once(')').ok_or_else(|| format!("no end of `{pattern}`"))?;
        made += &format!("{name}.{member}{after}");
    }
    Ok(made)
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

/// Whether a text ends within a word, or with the dot before a member.
fn ends_in_word(text: &str) -> bool {
    text.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.')
}

/// Text up to the end of the bracket that it begins in, and the text behind the bracket.
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
        made += &format!("load_{name}(u32({index}))");
        rest = after;
    }
    Ok(made + rest)
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
        Type { inner: TypeInner::Matrix { columns, rows: VectorSize::Quad, scalar }, .. } => {
            format!("mat{}x4<{}>", *columns as u32, scalar_name(*scalar))
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
        TypeInner::Matrix { columns, .. } => {
            let column = |k: u32| {
                let words: Vec<_> = (0..4).map(|row| word(4 * k + row)).collect();
                format!("bitcast<vec4f>(vec4u({}))", words.join(", "))
            };
            format!("{kind}({})", (0..*columns as u32).map(column).collect::<Vec<_>>().join(", "))
        }
        TypeInner::Struct { members, .. } => {
            let values = members.iter().map(|member| element(module, member.ty, offset + member.offset, texel));
            format!("{kind}({})", values.collect::<Result<Vec<_>>>()?.join(", "))
        }
        other => return Err(format!("{other:?} cannot be in a texture").into()),
    })
}
