//! The same pass, with some of the arrays that it only reads as textures.
//!
//! Mesa's software driver reads a buffer lane by lane, and a texture eight lanes at once: there a texture is read some seven times
//! faster. A texture has words of the array's elements in texels of one, two or four, row by row; an element of more words takes
//! texels side by side. The texels hold bits, and a load turns them into what the element is made of, so that both texts of a pass
//! give the same bits.

use naga::{AddressSpace, ArraySize, Handle, Module, Scalar, ScalarKind, StorageAccess, Type, TypeInner};

use crate::Result;

/// Bytes of a row of texels in every texture.
pub(crate) const ROW: u32 = 32768;

/// Bytes of the largest texel.
const TEXEL: u32 = 16;

/// Names, as shaders bind them, of the arrays that every particle or node reads, mostly those of its neighbours. A power of two of
/// their elements fits a row of texels.
const ARRAYS: [&str; 20] = [
    "neighbour_list",
    "predicted",
    "new_velocity",
    "stress",
    "density",
    "exchange",
    "field",
    "vorticity",
    "sorted_position",
    "cell_start",
    "sorted",
    "flow",
    "deposited",
    "smoothed",
    "smoother",
    "curvature",
    "smoother_curvature",
    "brought",
    "nodes",
    "sampled",
];

/// The text of a pass with textures in place of arrays, and the numbers of their bindings; `None` where it binds none.
pub(crate) fn with_textures(text: &str, module: &Module) -> Result<Option<(String, Vec<u32>)>> {
    let (mut text, mut bindings) = (text.to_owned(), Vec::new());
    for (_, variable) in module.global_variables.iter() {
        let (Some(name), Some(binding)) = (&variable.name, &variable.binding) else { continue };
        let reads = matches!(variable.space, AddressSpace::Storage { access } if access == StorageAccess::LOAD);
        let TypeInner::Array { base, size: ArraySize::Dynamic, stride } = module.types[variable.ty].inner else {
            continue;
        };
        if !reads || !ARRAYS.contains(&name.as_str()) {
            continue;
        }
        text = with_texture(&text, name, module, base, stride)?;
        bindings.push(binding.binding);
    }
    Ok((!bindings.is_empty()).then_some((text, bindings)))
}

/// The text with a texture in place of the array `name`, and a function that loads an element of it.
fn with_texture(text: &str, name: &str, module: &Module, base: Handle<Type>, stride: u32) -> Result<String> {
    if !stride.is_power_of_two() {
        return Err(
            format!("{name} has elements of {stride} bytes, of which no whole number fits a row of texels").into()
        );
    }
    let texel = stride.min(TEXEL);
    let per_row = ROW / stride;
    let declaration = format!("var<storage, read> {name}: ");
    let (before, rest) = text.split_once(&declaration).ok_or_else(|| format!("no `{declaration}`"))?;
    let (_, after) = rest.split_once(';').ok_or_else(|| format!("no end of `{declaration}`"))?;
    let element = element(module, base, 0)?;
    let loads: String = (0..stride / texel)
        .map(|k| {
            let x = format!("{}u * (e & {}u) + {k}u", stride / texel, per_row - 1);
            format!("    let t{k} = textureLoad({name}, vec2u({x}, e >> {}u), 0);\n", per_row.ilog2())
        })
        .collect();
    let kind = type_name(module, base)?;
    let function = format!("fn load_{name}(e: u32) -> {kind} {{\n{loads}    return {element};\n}}\n");
    let before = loaded(before, name)?;
    Ok(format!("{before}var {name}: texture_2d<u32>;\n\n{function}{}", loaded(after, name)?))
}

/// The text with `load_name(u32(index))` in place of each `name[index]`.
fn loaded(text: &str, name: &str) -> Result<String> {
    let mut made = String::new();
    let mut rest = text;
    let pattern = format!("{name}[");
    while let Some(at) = rest.find(&pattern) {
        let (before, from) = rest.split_at(at);
        made += before;
        let inside = &from[pattern.len()..];
        if before.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.') {
            made += &pattern;
            rest = inside;
            continue;
        }
        let mut depth = 1;
        let end = inside.find(|c| {
            depth += match c {
                '[' => 1,
                ']' => -1,
                _ => 0,
            };
            depth == 0
        });
        let end = end.ok_or_else(|| format!("`{pattern}` is not closed"))?;
        made += &format!("load_{name}(u32({}))", loaded(&inside[..end], name)?);
        rest = &inside[end + 1..];
    }
    Ok(made + rest)
}

/// A type as WGSL spells it.
fn type_name(module: &Module, ty: Handle<Type>) -> Result<String> {
    let word = |scalar: Scalar| match scalar.kind {
        ScalarKind::Float => "f32",
        ScalarKind::Sint => "i32",
        _ => "u32",
    };
    Ok(match &module.types[ty] {
        Type { name: Some(name), .. } => name.clone(),
        Type { inner: TypeInner::Scalar(scalar), .. } => word(*scalar).to_owned(),
        Type { inner: TypeInner::Vector { size, scalar }, .. } => format!("vec{}<{}>", *size as u32, word(*scalar)),
        other => return Err(format!("{other:?} cannot be in a texture").into()),
    })
}

/// The value of a type at an offset of an element whose texels are `t0`, `t1` and so on.
fn element(module: &Module, ty: Handle<Type>, offset: u32) -> Result<String> {
    let kind = type_name(module, ty)?;
    let (texel, word) = (offset / TEXEL, (offset % TEXEL / 4) as usize);
    let words = |count: usize| format!("t{texel}.{}", &"xyzw"[word..word + count]);
    Ok(match &module.types[ty].inner {
        TypeInner::Scalar(_) => format!("bitcast<{kind}>({})", words(1)),
        TypeInner::Vector { size, .. } => format!("bitcast<{kind}>({})", words(*size as u8 as usize)),
        TypeInner::Struct { members, .. } => {
            let values = members.iter().map(|member| element(module, member.ty, offset + member.offset));
            format!("{kind}({})", values.collect::<Result<Vec<_>>>()?.join(", "))
        }
        other => return Err(format!("{other:?} cannot be in a texture").into()),
    })
}
