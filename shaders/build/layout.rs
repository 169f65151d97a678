//! Structs that Rust and WGSL share, laid out as naga lays them out.

use std::collections::BTreeMap;

use naga::{ArraySize, Handle, Module, Scalar, ScalarKind, Type, TypeInner};

use crate::Result;

/// Shared structs by name.
#[derive(Default)]
pub(crate) struct Structs {
    pub(crate) by_name: BTreeMap<String, Layout>,
}

/// A struct in Rust: its fields fill it to the last byte.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) fields: Vec<Field>,
    /// Size \[bytes\].
    pub(crate) size: u32,
}

/// A field of a struct, or a gap between two.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Field {
    /// A field of the WGSL.
    Named { name: String, kind: Kind },
    /// A gap of this many words of 4 bytes, which WGSL leaves unnamed.
    Gap { words: u32 },
}

/// A type, as Rust spells it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A built-in type, or an array of one.
    Plain(String),
    /// A shared struct, or an array of `count` of them.
    Struct { name: String, count: Option<u32> },
}

/// Size of an f32, an i32 or a u32 \[bytes\].
const WORD: u32 = 4;

impl Structs {
    /// The structs that this shader binds, and those within them.
    pub(crate) fn collect(&mut self, shader: &str, module: &Module) -> Result<()> {
        for (_, variable) in module.global_variables.iter().filter(|(_, variable)| variable.binding.is_some()) {
            let ty = element(module, variable.ty);
            // A texture has no layout.
            if !matches!(module.types[ty].inner, TypeInner::Image { .. }) {
                self.of(shader, module, ty)?;
            }
        }
        Ok(())
    }

    /// The type as Rust spells it, and its size \[bytes\]; the structs in it are collected on the way.
    fn of(&mut self, shader: &str, module: &Module, ty: Handle<Type>) -> Result<(Kind, u32)> {
        let kind = &module.types[ty];
        let plain = |text: String, bytes: u32| Ok((Kind::Plain(text), bytes));
        match &kind.inner {
            TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => plain(word(*scalar)?.to_owned(), WORD),
            TypeInner::Vector { size, scalar } => {
                let n = *size as u32;
                plain(format!("[{}; {n}]", word(*scalar)?), n * WORD)
            }
            TypeInner::Matrix { columns, rows, scalar } => {
                let (columns, rows) = (*columns as u32, (*rows as u32).next_power_of_two());
                plain(format!("[[{}; {rows}]; {columns}]", word(*scalar)?), columns * rows * WORD)
            }
            TypeInner::Array { base, size: ArraySize::Constant(n), stride } => {
                let n = n.get();
                let (base, bytes) = self.of(shader, module, *base)?;
                if bytes != *stride {
                    return Err(
                        format!("shaders/{shader}.wgsl: an array of elements with gaps cannot be shared").into()
                    );
                }
                Ok((
                    match base {
                        Kind::Plain(text) => Kind::Plain(format!("[{text}; {n}]")),
                        Kind::Struct { name, .. } => Kind::Struct { name, count: Some(n) },
                    },
                    n * bytes,
                ))
            }
            TypeInner::Struct { members, span } => {
                let name = kind.name.clone().unwrap_or_default();
                let mut layout = Layout { fields: Vec::new(), size: *span };
                let mut end = 0;
                for member in members {
                    layout.gap(member.offset - end);
                    let (kind, bytes) = self.of(shader, module, member.ty)?;
                    layout.fields.push(Field::Named { name: member.name.clone().unwrap_or_default(), kind });
                    end = member.offset + bytes;
                }
                layout.gap(span - end);
                match self.by_name.get(&name) {
                    Some(other) if *other != layout => {
                        return Err(format!("shaders/{shader}.wgsl: another struct is called {name} too").into());
                    }
                    _ => self.by_name.insert(name.clone(), layout),
                };
                Ok((Kind::Struct { name, count: None }, *span))
            }
            other => Err(format!("shaders/{shader}.wgsl: {other:?} cannot be shared").into()),
        }
    }
}

impl Layout {
    fn gap(&mut self, bytes: u32) {
        if bytes > 0 {
            self.fields.push(Field::Gap { words: bytes / WORD });
        }
    }
}

/// Type of a binding's elements if it is an array, else its own type.
pub(crate) fn element(module: &Module, ty: Handle<Type>) -> Handle<Type> {
    match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Dynamic, .. } => base,
        _ => ty,
    }
}

fn word(scalar: Scalar) -> Result<&'static str> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => Ok("f32"),
        (ScalarKind::Uint, 4) => Ok("u32"),
        (ScalarKind::Sint, 4) => Ok("i32"),
        other => Err(format!("{other:?} cannot be shared").into()),
    }
}
