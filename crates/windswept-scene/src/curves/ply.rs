//! Polygon files, `.ply`: points as the element `vertex`, and strands as the element `strand` with `nsegs` each, as
//! hairutil has it, or as the chains that the element `edge` makes, as MeshLab and Blender write lines. Without either,
//! as GaussianHaircut and NeuralHaircut write them, strands have equally many points.
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

/// A row of the element `edge`.
#[derive(Deserialize)]
struct Edge {
    vertex1: u32,
    vertex2: u32,
}

/// A row of the element `tristrips`: indices of strips, each of which ends in -1.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Strips {
    vertex_indices: Vec<i64>,
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
    edges: Option<Vec<Edge>>,
    faces: Vec<Face>,
    strips: Vec<Strips>,
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
            "edge" if ["vertex1", "vertex2"].iter().all(|name| element.has_property(name)) => {
                reader.next_element().map(|all| found.edges = Some(all))
            }
            "tristrips" => reader.next_element().map(|all| found.strips = all),
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

/// The triangles of strips, of which every second one turns the other way; those with a corner twice join two parts.
fn of_strips(strips: Vec<Strips>) -> impl Iterator<Item = Vec<u32>> {
    let index = |i: i64| u32::try_from(i).unwrap_or(u32::MAX);
    strips.into_iter().flat_map(move |row| {
        let parts = row.vertex_indices.split(|i| *i == -1).flat_map(|strip| {
            strip.windows(3).enumerate().map(|(k, ends)| match k % 2 {
                0 => [ends[0], ends[1], ends[2]],
                _ => [ends[1], ends[0], ends[2]],
            })
        });
        let whole = parts.filter(|[a, b, c]| a != b && b != c && c != a);
        whole.map(|corners| corners.map(index).to_vec()).collect::<Vec<_>>()
    })
}

/// The polygons of the elements `face` and `tristrips`.
pub(crate) fn polygons(bytes: &[u8]) -> Result<Polygons, SceneError> {
    let Found { vertices, faces, strips, at, .. } = found(bytes)?;
    let faces = faces.into_iter().map(|face| face.vertex_indices).filter(|face| !face.is_empty());
    let corners: Vec<_> = faces.chain(of_strips(strips)).collect();
    if corners.is_empty() {
        return Err(fault_at(at, "expected an element face with a list vertex_indices"));
    }
    Ok(Polygons { points: vertices.points, corners, normals: vertices.normals, places: vertices.places })
}

pub(super) fn read(bytes: &[u8], points_per_strand: Option<u32>) -> Result<Curves, SceneError> {
    let Found { vertices: Vertices { points, thickness, .. }, strands, edges, at, .. } = found(bytes)?;
    let radius: Vec<f64> = thickness.iter().map(|thickness| 0.5 * thickness).collect();
    let curves = match (strands, edges) {
        (None, None) => Curves::even(points, points_per_strand)?,
        (None, Some(edges)) => {
            let (order, counts) = chains(count32(points.len())?, &edges).map_err(|words| fault_at(at, words))?;
            let radius = order.iter().filter_map(|&i| radius.get(i as usize).copied()).collect();
            let curves = Curves::of(order.iter().map(|&i| points[i as usize]).collect(), counts.into_iter());
            return Ok(Curves { radius, ..curves });
        }
        (Some(strands), _) => {
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

/// The points of strands, one strand after the other, and how many each has, by the edges of so many points. A strand
/// begins at its end that is first in the file.
fn chains(points: u32, edges: &[Edge]) -> Result<(Vec<u32>, Vec<u32>), String> {
    let mut beside = vec![[None; 2]; points as usize];
    for (row, &Edge { vertex1, vertex2 }) in edges.iter().enumerate() {
        for (from, to) in [(vertex1, vertex2), (vertex2, vertex1)] {
            let own = beside.get_mut(from as usize);
            let own = own.ok_or_else(|| format!("edge {row}: expected vertices below {points}, found {from}"))?;
            let Some(free) = own.iter_mut().find(|other| other.is_none()) else {
                return Err(format!(
                    "edge {row}: expected strands, which do not branch, found a third edge at vertex {from}"
                ));
            };
            *free = Some(to);
        }
    }
    let (mut order, mut counts, mut seen) = (Vec::new(), Vec::new(), vec![false; points as usize]);
    for root in 0..points {
        if seen[root as usize] || beside[root as usize][1].is_some() {
            continue;
        }
        let (first, mut at) = (order.len(), Some(root));
        while let Some(point) = at {
            seen[point as usize] = true;
            order.push(point);
            at = beside[point as usize].into_iter().flatten().find(|next| !seen[*next as usize]);
        }
        counts.push((order.len() - first) as u32);
    }
    match seen.iter().position(|seen| !seen) {
        Some(point) => Err(format!("expected strands with two ends, found a ring of edges through vertex {point}")),
        None => Ok((order, counts)),
    }
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
