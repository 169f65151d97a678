//! Polygon files, `.ply`: points as the element `vertex`, and strands as the element `strand` with `nsegs` each, as
//! hairutil has it. Without it, as GaussianHaircut and NeuralHaircut write them, strands have equally many points.
//!
//! Source: Greg Turk's "The PLY polygon file format"; hairutil, `src/io/ply.cpp`.

use std::{
    borrow::Cow,
    fmt,
    io::{BufRead, ErrorKind, Read},
};

use serde::{
    Deserialize, Deserializer,
    de::{SeqAccess, Visitor},
};
use serde_ply::{PlyFormat, PlyHeader, PlyReader};

use super::{
    Curves,
    bytes::{fault_at, put_floats},
    count32,
};
use crate::{document::short, error::SceneError, limits::LONGEST_PLY_HEADER};

/// Elements whose numbers are kept, and the properties that these must have. A file has each of them once: the numbers
/// of a second one would mingle with those of the first.
const KEPT: [(&str, &[&str]); 3] = [("vertex", &["x", "y", "z"]), ("strand", &["nsegs"]), ("face", &[])];

/// A row of the element `vertex`.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Vertex {
    x: f64,
    y: f64,
    z: f64,
    thickness: Option<f64>,
    nx: Option<f64>,
    ny: Option<f64>,
    nz: Option<f64>,
    // Names that writers give to a vertex's place in a texture.
    s: Option<f64>,
    t: Option<f64>,
    u: Option<f64>,
    v: Option<f64>,
    texture_u: Option<f64>,
    texture_v: Option<f64>,
}

/// A row of the element `strand`.
#[derive(Deserialize)]
struct Strand {
    nsegs: u32,
}

/// A row of the element `face`.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Face {
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<u32>,
}

/// A row of another element.
#[derive(Deserialize)]
struct Other {}

/// The rows of the element `vertex`; lists of what the file does not have are empty.
#[derive(Default)]
struct Vertices {
    points: Vec<[f64; 3]>,
    thickness: Vec<f64>,
    normals: Vec<[f64; 3]>,
    /// Places in a texture.
    places: Vec<[f64; 2]>,
}

impl<'de> Deserialize<'de> for Vertices {
    fn deserialize<D: Deserializer<'de>>(rows: D) -> Result<Self, D::Error> {
        rows.deserialize_seq(Self::default())
    }
}

impl<'de> Visitor<'de> for Vertices {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("vertices")
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut rows: A) -> Result<Self, A::Error> {
        while let Some(row) = rows.next_element::<Vertex>()? {
            self.points.push([row.x, row.y, row.z]);
            self.thickness.extend(row.thickness);
            if let (Some(x), Some(y), Some(z)) = (row.nx, row.ny, row.nz) {
                self.normals.push([x, y, z]);
            }
            let pairs = [(row.s, row.t), (row.u, row.v), (row.texture_u, row.texture_v)];
            self.places.extend(pairs.into_iter().find_map(|(u, v)| Some([u?, v?])));
        }
        Ok(self)
    }
}

/// Data in a file of a groom, or of a surface.
#[derive(Default)]
struct Found {
    vertices: Vertices,
    strands: Option<Vec<Strand>>,
    faces: Vec<Face>,
    /// Byte at which the header ends.
    at: usize,
}

/// The header, and its text. Comments may be of any encoding; words that matter are of ASCII.
fn header(bytes: &[u8]) -> Result<(PlyHeader, Cow<'_, str>, usize), SceneError> {
    if !bytes.starts_with(b"ply") {
        return Err(fault_at(0, "expected the word ply"));
    }
    let start = &bytes[..bytes.len().min(LONGEST_PLY_HEADER as usize)];
    let mut lines = start.split_inclusive(|byte| *byte == b'\n').scan(0, |end, line| {
        *end += line.len();
        Some((line, *end))
    });
    let last = lines.find(|(line, _)| line.trim_ascii() == b"end_header" && line.ends_with(b"\n"));
    let (_, end) = last.ok_or_else(|| {
        let words = "expected a line of a header that ends in end_header";
        fault_at(start.len(), format!("{words}, within {LONGEST_PLY_HEADER} bytes"))
    })?;
    let text = String::from_utf8_lossy(&bytes[..end]);
    let fault = |words: String| SceneError::new(format!("in the header: {words}"));
    let reader = PlyReader::from_reader(text.as_bytes()).map_err(|error| fault(short(&error.0.to_string())))?;
    let header = reader.header().clone();
    for (name, properties) in KEPT {
        let mut elements = header.elem_defs.iter().filter(|element| element.name == name);
        let Some(element) = elements.next() else { continue };
        if elements.next().is_some() {
            return Err(fault(format!("expected one element {name}, found a second")));
        }
        if let Some(lacks) = properties.iter().find(|property| !element.has_property(property)) {
            return Err(fault(format!("expected element {name} to have a property {lacks}")));
        }
    }
    // Rows without a byte have no end.
    match header.elem_defs.iter().find(|element| element.properties.is_empty()) {
        Some(element) => Err(fault(format!("expected element {} to have a property", short(&element.name)))),
        None => Ok((header, text, end)),
    }
}

/// Checks the header of a file that begins with these bytes, which are [`LONGEST_PLY_HEADER`] or all.
pub(super) fn check_header(start: &[u8]) -> Result<(), SceneError> {
    header(start).map(drop)
}

/// The elements of a file.
fn found(bytes: &[u8]) -> Result<Found, SceneError> {
    let (header, text, at) = header(bytes)?;
    if !header.has_element("vertex") {
        return Err(fault_at(at, "expected an element vertex"));
    }
    // The last number of a text may end with the file.
    let end: &[u8] = if header.format == PlyFormat::Ascii { b"\n" } else { b"" };
    let mut rest = text.as_bytes().chain(&bytes[at..]).chain(end);
    let read = elements(&header, &mut rest);
    let left = *rest.get_ref().0.get_ref().1;
    let found = read.map_err(|words| fault_at(bytes.len() - left.len(), words))?;
    let left = if header.format == PlyFormat::Ascii { left.trim_ascii_start() } else { left };
    match left.len() {
        0 => Ok(Found { at, ..found }),
        more => {
            let words = format!("expected the end of the file, found {more} bytes more");
            Err(fault_at(bytes.len() - more, words))
        }
    }
}

/// Reads all elements, and keeps what there is of a groom or of a surface.
fn elements(header: &PlyHeader, rest: impl BufRead) -> Result<Found, String> {
    let mut reader = PlyReader::from_reader(rest).map_err(|error| error.0.to_string())?;
    let mut found = Found::default();
    for element in &header.elem_defs {
        let read = match &*element.name {
            "vertex" => reader.next_element().map(|all| found.vertices = all),
            "strand" => reader.next_element().map(|all| found.strands = Some(all)),
            "face" => reader.next_element().map(|all| found.faces = all),
            _ => reader.next_element::<Vec<Other>>().map(drop),
        };
        read.map_err(|error| {
            let why = match error.0.kind() {
                ErrorKind::UnexpectedEof => "the file ends".to_owned(),
                _ => short(&error.0.to_string()),
            };
            format!("expected before it {} rows of element {}: {why}", element.count, short(&element.name))
        })?;
    }
    Ok(found)
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
    let Found { vertices, faces, at, .. } = found(bytes)?;
    let corners: Vec<_> = faces.into_iter().map(|face| face.vertex_indices).filter(|face| !face.is_empty()).collect();
    if corners.is_empty() {
        return Err(fault_at(at, "expected an element face with a list vertex_indices"));
    }
    Ok(Polygons { points: vertices.points, corners, normals: vertices.normals, places: vertices.places })
}

pub(super) fn read(bytes: &[u8], points_per_strand: Option<u32>) -> Result<Curves, SceneError> {
    let Found { vertices: Vertices { points, thickness, .. }, strands, at, .. } = found(bytes)?;
    let radius = thickness.iter().map(|thickness| 0.5 * thickness).collect();
    let curves = match strands {
        None => Curves::even(points, points_per_strand)?,
        Some(strands) => {
            let sum: u64 = strands.iter().map(|strand| u64::from(strand.nsegs) + 1).sum();
            let found = count32(points.len())?;
            if sum != u64::from(found) {
                let words = format!("expected the {sum} points that the strands' nsegs make, found {found}");
                return Err(fault_at(at, words));
            }
            Curves::of(points, strands.into_iter().map(|strand| strand.nsegs + 1))
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
