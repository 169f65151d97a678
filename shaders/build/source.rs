//! A WGSL file as people read it: its heading, its constants, its structs, and what their comments say.

use std::{collections::BTreeMap, fs, path::Path};

use naga::{Expression, Literal};

use crate::Result;

/// A file of WGSL.
pub(crate) struct Source {
    /// The folder, without `shaders/`.
    pub(crate) folder: &'static str,
    /// The file's name without `.wgsl`.
    pub(crate) stem: String,
    /// The heading, up to its first full stop.
    pub(crate) title: String,
    /// The constants that are one number or a vector of them.
    pub(crate) constants: Vec<Constant>,
    /// The structs, by name.
    pub(crate) structs: BTreeMap<String, StructDocs>,
    text: String,
}

/// A named constant.
pub(crate) struct Constant {
    pub(crate) name: String,
    /// The type in Rust.
    pub(crate) kind: String,
    /// The value in Rust.
    pub(crate) value: String,
    pub(crate) doc: String,
}

/// The comments on a struct.
#[derive(Default)]
pub(crate) struct StructDocs {
    pub(crate) doc: String,
    /// The comment behind or above each field, by the field's name.
    pub(crate) fields: BTreeMap<String, String>,
}

impl Source {
    pub(crate) fn read(folder: &'static str, file: &Path) -> Result<Self> {
        let text = fs::read_to_string(file)?;
        let stem = file.file_stem().and_then(|stem| stem.to_str()).ok_or("a shader's name is not UTF-8")?.to_owned();
        let heading: Vec<_> = text.lines().map_while(comment).collect();
        let title = sentence(&heading.join(" "));
        let mut source = Self { folder, stem, title, constants: Vec::new(), structs: BTreeMap::new(), text };
        source.read_declarations()?;
        Ok(source)
    }

    /// The file's name as passes have it: `folder/stem`.
    pub(crate) fn name(&self) -> String {
        format!("{}/{}", self.folder, self.stem)
    }

    /// Whether the file has an entry point; files without one are imported by others.
    pub(crate) fn runs(&self) -> bool {
        ["@compute", "@vertex"].iter().any(|stage| self.text.lines().any(|line| line.starts_with(stage)))
    }

    /// Whether the file is a pass of the step, and not of the pictures.
    pub(crate) fn is_pass(&self) -> bool {
        self.runs() && self.folder != "pictures"
    }

    fn read_declarations(&mut self) -> Result<()> {
        let lines: Vec<String> = self.text.lines().map(str::to_owned).collect();
        // The lines of comment right above a declaration.
        let mut above: Vec<&str> = Vec::new();
        let mut inside: Option<(String, StructDocs)> = None;
        for line in &lines {
            if let Some((name, docs)) = &mut inside {
                if line.starts_with('}') {
                    let (name, docs) = (std::mem::take(name), std::mem::take(docs));
                    self.structs.insert(name, docs);
                    inside = None;
                } else if let Some(words) = comment(line.trim()) {
                    above.push(words);
                    continue;
                } else if let Some((field, rest)) = line.trim().split_once(':') {
                    let field = field.rsplit(' ').next().unwrap_or(field);
                    docs.fields.insert(field.to_owned(), either(&above, rest));
                }
                above.clear();
                continue;
            }
            if let Some(words) = comment(line) {
                above.push(words);
                continue;
            }
            if let Some(name) = line.strip_prefix("struct ").and_then(|rest| rest.strip_suffix(" {")) {
                inside = Some((name.to_owned(), StructDocs { doc: above.join(" "), ..StructDocs::default() }));
            } else if line.starts_with("const ") {
                let doc = either(&above, line);
                self.constants.extend(constant(line, doc).map_err(|e| format!("{}: {e}", self.name()))?);
            }
            above.clear();
        }
        Ok(())
    }
}

/// The words of a line that is nothing but a comment.
fn comment(line: &str) -> Option<&str> {
    line.strip_prefix("//").map(str::trim)
}

/// The comment above a line, or else the one at its end.
fn either(above: &[&str], line: &str) -> String {
    if above.is_empty() { trailing(line) } else { above.join(" ") }
}

/// The comment at the end of a line.
fn trailing(line: &str) -> String {
    line.split_once("//").map(|(_, words)| words.trim().to_owned()).unwrap_or_default()
}

/// The first sentence of a heading.
fn sentence(heading: &str) -> String {
    heading.split_inclusive(['.', ':']).next().unwrap_or_default().replace(':', ".")
}

/// The constant of a line, unless it is a matrix.
fn constant(line: &str, doc: String) -> Result<Option<Constant>> {
    let module = naga::front::wgsl::parse_str(line)
        .map_err(|_| format!("`{line}`: a constant is a line of its own, without other constants in it"))?;
    let Some((_, constant)) = module.constants.iter().find(|(_, constant)| constant.name.is_some()) else {
        return Ok(None);
    };
    let literal = |expression: &Expression| match expression {
        Expression::Literal(Literal::F32(x)) => Some(("f32", format!("{x:?}"))),
        Expression::Literal(Literal::U32(x)) => Some(("u32", x.to_string())),
        Expression::Literal(Literal::I32(x)) => Some(("i32", x.to_string())),
        _ => None,
    };
    let (kind, value) = match &module.global_expressions[constant.init] {
        Expression::Compose { components, .. } => {
            let parts: Option<Vec<_>> =
                components.iter().map(|part| literal(&module.global_expressions[*part])).collect();
            let Some(parts) = parts else { return Ok(None) };
            let values: Vec<_> = parts.iter().map(|(_, value)| value.as_str()).collect();
            (format!("[{}; {}]", parts[0].0, parts.len()), format!("[{}]", values.join(", ")))
        }
        other => match literal(other) {
            Some((kind, value)) => (kind.to_owned(), value),
            None => return Ok(None),
        },
    };
    let name = constant.name.clone().unwrap_or_default();
    Ok(Some(Constant { name, kind, value, doc }))
}
