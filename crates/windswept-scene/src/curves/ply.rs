//! Polygon files, `.ply`: points as the element `vertex`, and strands as the element `strand` with `nsegs` each, as
//! hairutil has it. Without it, as GaussianHaircut and NeuralHaircut write them, strands have equally many points.
//!
//! Source: Greg Turk's "The PLY polygon file format"; hairutil, `src/io/ply.cpp`.

use std::borrow::Cow;

use super::{
    Curves,
    bytes::{Bytes, fault_at, put_floats},
};
use crate::{error::SceneError, limits::LONGEST_PLY_HEADER};

/// Encoding of the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Length \[bytes\].
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

struct Property {
    name: String,
    scalar: Scalar,
    /// Kind of the number of them, where there are many.
    many: Option<Scalar>,
}

/// Elements whose numbers are kept. A file has each of them once: the numbers of a second one would mingle with those
/// of the first.
const KEPT: [&str; 3] = ["vertex", "strand", "face"];

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    /// Place of the property of this name.
    fn property(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name && property.many.is_none())
    }

    /// Least number of bytes that one of them takes.
    fn least(&self, encoding: Encoding) -> usize {
        match encoding {
            // A digit and a space each; the last of all may lack the space.
            Encoding::Ascii => (2 * self.properties.len()).saturating_sub(1),
            _ => self.properties.iter().map(|property| property.many.unwrap_or(property.scalar).size()).sum(),
        }
    }
}

/// A line of the header, without the end. Comments may be of any encoding; words that matter are of ASCII.
fn line<'a>(bytes: &mut Bytes<'a>) -> Result<Cow<'a, str>, SceneError> {
    let at = bytes.at();
    let line = bytes.until(b'\n').filter(|_| bytes.at() as u64 <= LONGEST_PLY_HEADER).ok_or_else(|| {
        let words = "expected a line of a header that ends in end_header";
        fault_at(at, format!("{words}, within {LONGEST_PLY_HEADER} bytes"))
    })?;
    Ok(String::from_utf8_lossy(line.trim_ascii()))
}

/// Checks the header of a file that begins with these bytes, which are [`LONGEST_PLY_HEADER`] or all.
pub(super) fn check_header(start: &[u8]) -> Result<(), SceneError> {
    header(&mut Bytes::new(start)).map(drop)
}

fn header(bytes: &mut Bytes<'_>) -> Result<(Encoding, Vec<Element>), SceneError> {
    if line(bytes)? != "ply" {
        return Err(fault_at(0, "expected the word ply"));
    }
    let (mut encoding, mut elements) = (None, Vec::<Element>::new());
    loop {
        let at = bytes.at();
        let line = line(bytes)?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let scalar = |name: &str| {
            Scalar::named(name).ok_or_else(|| fault_at(at, format!("expected a type of numbers, found {name:?}")))
        };
        let property = match words[..] {
            ["end_header"] => break,
            [] | ["comment" | "obj_info", ..] => continue,
            ["format", name, _] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(fault_at(at, format!("expected a format, found {name:?}"))),
                });
                continue;
            }
            ["element", name, count] => {
                let count =
                    count.parse().map_err(|_| fault_at(at, format!("expected a number of {name}, found {count:?}")))?;
                if KEPT.contains(&name) && elements.iter().any(|element| element.name == name) {
                    return Err(fault_at(at, format!("expected one element {name}, found a second")));
                }
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                continue;
            }
            ["property", "list", many, kind, name] => {
                Property { name: name.to_owned(), scalar: scalar(kind)?, many: Some(scalar(many)?) }
            }
            ["property", kind, name] => Property { name: name.to_owned(), scalar: scalar(kind)?, many: None },
            _ => {
                let words = "expected format, element, property, comment or end_header";
                return Err(fault_at(at, words));
            }
        };
        let Some(element) = elements.last_mut() else {
            return Err(fault_at(at, "expected an element before its properties"));
        };
        element.properties.push(property);
    }
    let encoding = encoding.ok_or_else(|| fault_at(bytes.at(), "expected a format in the header"))?;
    Ok((encoding, elements))
}

/// The next number.
fn number(bytes: &mut Bytes<'_>, encoding: Encoding, scalar: Scalar) -> Result<f64, SceneError> {
    fn of<const N: usize>(bytes: &mut Bytes<'_>, encoding: Encoding) -> Result<[u8; N], SceneError> {
        let mut taken = bytes.array("a number")?;
        if encoding == Encoding::Big {
            taken.reverse();
        }
        Ok(taken)
    }
    if encoding == Encoding::Ascii {
        let word = bytes.word();
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        return number.ok_or_else(|| {
            let found = String::from_utf8_lossy(&word[..word.len().min(20)]);
            fault_at(bytes.at() - word.len(), format!("expected a number, found {found:?}"))
        });
    }
    Ok(match scalar {
        Scalar::I8 => i8::from_le_bytes(of(bytes, encoding)?).into(),
        Scalar::U8 => u8::from_le_bytes(of(bytes, encoding)?).into(),
        Scalar::I16 => i16::from_le_bytes(of(bytes, encoding)?).into(),
        Scalar::U16 => u16::from_le_bytes(of(bytes, encoding)?).into(),
        Scalar::I32 => i32::from_le_bytes(of(bytes, encoding)?).into(),
        Scalar::U32 => u32::from_le_bytes(of(bytes, encoding)?).into(),
        Scalar::F32 => f32::from_le_bytes(of(bytes, encoding)?).into(),
        Scalar::F64 => f64::from_le_bytes(of(bytes, encoding)?),
    })
}

/// Names that writers give to a vertex's place in a texture.
const PLACES: [[&str; 2]; 3] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];

/// Data in a file of a groom, or of a surface.
#[derive(Default)]
struct Found {
    points: Option<Vec<[f64; 3]>>,
    thickness: Vec<f64>,
    /// Points of each strand.
    counts: Option<Vec<u32>>,
    /// Indices of the points of each polygon.
    polygons: Vec<Vec<u32>>,
    /// Normals of the points, and their places in a texture; empty where the file has none.
    normals: Vec<[f64; 3]>,
    places: Vec<[f64; 2]>,
}

impl Found {
    /// Reads an element, and keeps what it has of a groom or of a surface.
    fn read(&mut self, element: &Element, bytes: &mut Bytes<'_>, encoding: Encoding) -> Result<(), SceneError> {
        let (name, count) = (&element.name, element.count);
        let at = bytes.at();
        // The last number of a text may end with the file.
        let short = usize::from(encoding == Encoding::Ascii && !element.properties.is_empty());
        bytes.has(
            count.saturating_mul((element.least(encoding) + short) as u64).saturating_sub(short as u64),
            1,
            name,
        )?;
        if element.properties.is_empty() {
            return Ok(());
        }
        let place = |property: &str| {
            let words = || fault_at(at, format!("expected element {name} to have a property {property}"));
            element.property(property).ok_or_else(words)
        };
        let axes = if name == "vertex" { Some([place("x")?, place("y")?, place("z")?]) } else { None };
        let of_vertex = |name: &str| element.property(name).filter(|_| axes.is_some());
        let thickness = of_vertex("thickness");
        let normal = [of_vertex("nx"), of_vertex("ny"), of_vertex("nz")];
        let normal = if let [Some(x), Some(y), Some(z)] = normal { Some([x, y, z]) } else { None };
        let texture = PLACES.iter().find_map(|[u, v]| Some([of_vertex(u)?, of_vertex(v)?]));
        let segments = if name == "strand" { Some(place("nsegs")?) } else { None };
        let polygon = |property: &Property| {
            name == "face" && ["vertex_indices", "vertex_index"].contains(&property.name.as_str())
        };
        let room = if axes.is_some() || segments.is_some() { count as usize } else { 0 };
        let mut points = Vec::with_capacity(if axes.is_some() { room } else { 0 });
        let mut counts = Vec::new();
        let mut row = vec![0.0; element.properties.len()];
        for _ in 0..count {
            for (property, value) in element.properties.iter().zip(&mut row) {
                match property.many {
                    None => *value = number(bytes, encoding, property.scalar)?,
                    Some(many) => {
                        let at = bytes.at();
                        let n = number(bytes, encoding, many)?;
                        if n.is_nan() || n < 0.0 {
                            return Err(fault_at(at, format!("expected the length of a list, found {n}")));
                        }
                        let mut list = Vec::new();
                        for _ in 0..n as u64 {
                            let index = number(bytes, encoding, property.scalar)?;
                            if polygon(property) {
                                list.push(index32(index).ok_or_else(|| {
                                    fault_at(
                                        bytes.at(),
                                        format!("expected before it the index of a vertex, found {index}"),
                                    )
                                })?);
                            }
                        }
                        if polygon(property) {
                            self.polygons.push(list);
                        }
                    }
                }
            }
            if let Some(axes) = axes {
                points.push(axes.map(|axis| row[axis]));
                self.thickness.extend(thickness.map(|place| row[place]));
                self.normals.extend(normal.map(|axes| axes.map(|axis| row[axis])));
                self.places.extend(texture.map(|pair| pair.map(|place| row[place])));
            }
            if let Some(segments) = segments {
                let segments = row[segments];
                let segments = index32(segments).ok_or_else(|| {
                    fault_at(bytes.at(), format!("expected before it nsegs of at least 0, found {segments}"))
                })?;
                counts.push(segments + 1);
            }
        }
        if axes.is_some() {
            self.points = Some(points);
        }
        if segments.is_some() {
            self.counts = Some(counts);
        }
        Ok(())
    }
}

/// A number as an index.
fn index32(x: f64) -> Option<u32> {
    (0.0..f64::from(u32::MAX)).contains(&x).then_some(x as u32)
}

/// The elements of a file, and the byte at which its header ends.
fn found(bytes: &[u8]) -> Result<(Found, usize), SceneError> {
    let mut bytes = Bytes::new(bytes);
    let (encoding, elements) = header(&mut bytes)?;
    let at = bytes.at();
    let mut found = Found::default();
    for element in &elements {
        found.read(element, &mut bytes, encoding)?;
    }
    if encoding == Encoding::Ascii {
        bytes.skip_space();
    }
    bytes.end()?;
    Ok((found, at))
}

/// Polygons of a file.
pub(crate) struct Polygons {
    pub(crate) points: Vec<[f64; 3]>,
    /// Indices of the points of each polygon.
    pub(crate) corners: Vec<Vec<u32>>,
    /// Normal of each point; empty where the file has none.
    pub(crate) normals: Vec<[f64; 3]>,
    /// Place of each point in a texture; empty where the file has none.
    pub(crate) places: Vec<[f64; 2]>,
}

/// The polygons of the element `face`.
pub(crate) fn polygons(bytes: &[u8]) -> Result<Polygons, SceneError> {
    let (found, at) = found(bytes)?;
    let points = found.points.ok_or_else(|| fault_at(at, "expected an element vertex"))?;
    if found.polygons.is_empty() {
        return Err(fault_at(at, "expected an element face with a list vertex_indices"));
    }
    Ok(Polygons { points, corners: found.polygons, normals: found.normals, places: found.places })
}

pub(super) fn read(bytes: &[u8], points_per_strand: Option<u32>) -> Result<Curves, SceneError> {
    let (found, at) = found(bytes)?;
    let points = found.points.ok_or_else(|| fault_at(at, "expected an element vertex"))?;
    let radius = found.thickness.iter().map(|thickness| 0.5 * thickness).collect();
    let curves = match found.counts {
        None => Curves::even(points, points_per_strand)?,
        Some(counts) => {
            let sum: u64 = counts.iter().map(|&count| u64::from(count)).sum();
            if sum != points.len() as u64 || u32::try_from(sum).is_err() {
                let found = points.len();
                return Err(fault_at(
                    at,
                    format!("expected the {sum} points that the strands' nsegs make, found {found}"),
                ));
            }
            Curves::of(points, counts.into_iter())
        }
    };
    Ok(Curves { radius, ..curves })
}

pub(super) fn write(curves: &Curves) -> Result<Vec<u8>, SceneError> {
    let segments = curves.segments("a .ply file")?;
    let thickness = if curves.radius.is_empty() { "" } else { "property float thickness\n" };
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment windswept {}\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\n{thickness}element strand {}\nproperty ushort nsegs\nend_header\n",
        env!("CARGO_PKG_VERSION"),
        curves.points.len(),
        curves.len(),
    )
    .into_bytes();
    for (i, point) in curves.points.iter().enumerate() {
        put_floats(point, &mut bytes);
        put_floats(curves.radius.get(i).map(|radius| 2.0 * radius).iter(), &mut bytes);
    }
    bytes.extend(segments.iter().flat_map(|segments| segments.to_le_bytes()));
    Ok(bytes)
}
