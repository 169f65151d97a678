//! Text of a film's layers and files.

use std::collections::HashSet;
use std::fmt::Write as _;

use glam::{DMat3, DVec3};
use windswept_engine::{Frame, HairFrame};
use windswept_scene::{CheckedBody, Triangles};

use crate::bodies::{pose, welded};
use crate::film::{Scenery, Units};
use crate::provenance::Provenance;
use crate::render::View;

/// Text before the last time code, and room for any such number.
pub(super) const LAST: &str = "endTimeCode = ";
pub(super) const ROOM: usize = 24;

/// The prim that has all of a film.
const ROOT: &str = "Film";

/// A prim with what moves in it.
pub(super) struct Prim {
    name: String,
    /// Text of the prim before its samples: attributes that stay the same through a film.
    pub(super) still: String,
    pub(super) sampled: Vec<Sampled>,
}

/// An attribute with a sample per frame.
pub(super) struct Sampled {
    /// Name of the file of its layer, where the film grows.
    pub(super) file: String,
    /// Type and name.
    pub(super) name: &'static str,
    of: Of,
}

enum Of {
    /// An attribute of the hair, in the units of the film.
    Hair(fn(&HairFrame, &mut String)),
    /// The transform of the body with this index.
    Body(usize),
}

/// Files of the attributes of the hair.
pub(super) const HAIR: [&str; 3] = ["hair.points.usda", "hair.velocities.usda", "hair.extent.usda"];

/// The prims of a film: its hair and its bodies.
pub(super) fn prims(hair: &HairFrame, scenery: &Scenery, units: Units) -> Vec<Prim> {
    type Put = fn(&HairFrame, &mut String);
    let attributes: [(_, Put); 3] = [
        ("point3f[] points", |hair, text| put_rows(&hair.positions, text)),
        ("vector3f[] velocities", |hair, text| put_rows(&hair.velocities, text)),
        ("float3[] extent", |hair, text| put_rows(&extent(&hair.positions, largest(&hair.radius)), text)),
    ];
    let sampled = HAIR.iter().zip(attributes);
    let sampled = sampled.map(|(file, (name, put))| Sampled { file: (*file).to_owned(), name, of: Of::Hair(put) });
    let hair = Prim { name: "Hair".to_owned(), still: still(hair), sampled: sampled.collect() };
    let names = names(scenery);
    let bodies = scenery.bodies.iter().enumerate().map(|(i, body)| {
        let name = "matrix4d xformOp:transform";
        let sampled = vec![Sampled { file: format!("bodies/{i:04}.usda"), name, of: Of::Body(i) }];
        Prim { name: names[i].prim.clone(), still: mesh(&names[i], body, units), sampled }
    });
    std::iter::once(hair).chain(bodies).collect()
}

impl Prim {
    /// The prim up to the samples of its attribute `k`, in a layer of its own.
    pub(super) fn opened(&self, k: usize) -> String {
        let still = if k == 0 { self.still.clone() } else { format!("over \"{}\"\n{{\n", self.name) };
        format!("{still}    {}.timeSamples = {{", self.sampled[k].name)
    }

    /// The prim in a stage of such layers.
    pub(super) fn composed(&self) -> String {
        let layer = |sampled: &Sampled| format!("        @./{}@</{}>", sampled.file, self.name);
        let layers = self.sampled.iter().map(layer).collect::<Vec<_>>().join(",\n");
        format!("def \"{}\" (\n    references = [\n{layers}\n    ]\n)\n{{\n}}\n", self.name)
    }
}

/// The head of a layer.
pub(super) fn layer(rate: f64) -> String {
    format!("#usda 1.0\n(\n    doc = \"{LAYER}\"\n    timeCodesPerSecond = {rate}\n)\n\n")
}

/// Says in a layer whose it is.
pub(crate) const LAYER: &str = "a layer of a film of windswept";

/// The head of a stage: its metadata, and its cameras.
pub(super) fn stage(rate: f64, provenance: &Provenance<'_>, scenery: &Scenery, units: Units, last: f64) -> String {
    let Units { metres, up } = units;
    let names = names(scenery).split_off(scenery.bodies.len());
    let cameras: String =
        names.iter().zip(&scenery.cameras).map(|(name, (_, view))| camera(name, view, units)).collect();
    let Provenance { scene, version, adapter, seed } = provenance;
    let [scene, version, adapter] = [scene, version, adapter].map(|text| quoted(text));
    format!(
        "#usda 1.0
(
    {LAST}{last:<ROOM$}
    customLayerData = {{
        dictionary windswept = {{
            string adapter = {adapter}
            string scene = {scene}
            uint64 seed = {seed}
            string version = {version}
        }}
    }}
    defaultPrim = \"{ROOT}\"
    framesPerSecond = {rate}
    metersPerUnit = {metres}
    startTimeCode = 0
    timeCodesPerSecond = {rate}
    upAxis = \"{up:?}\"
)

def Xform \"{ROOT}\"
{{
{cameras}"
    )
}

/// Names of the prims of bodies, and then of cameras, as USD takes them: each once, and none that of the hair.
fn names(scenery: &Scenery) -> Vec<Name> {
    let mut taken = vec!["Hair".to_owned()];
    let given = scenery
        .bodies
        .iter()
        .map(|body| body.name.as_str())
        .chain(scenery.cameras.iter().map(|(name, _)| name.as_str()));
    given
        .map(|given| {
            let mut prim: String = given.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
            if !prim.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
                prim.insert(0, '_');
            }
            let stem = prim.clone();
            let mut k = 1;
            while taken.contains(&prim) {
                k += 1;
                prim = format!("{stem}_{k}");
            }
            taken.push(prim.clone());
            Name { prim, given: given.to_owned() }
        })
        .collect()
}

/// Name of a thing in the scene, and of its prim.
pub(super) struct Name {
    prim: String,
    given: String,
}

impl Name {
    /// The first lines of its prim.
    fn define(&self, kind: &str) -> String {
        let Self { prim, given } = self;
        let shown = if prim == given { String::new() } else { format!(" (\n    displayName = {}\n)", quoted(given)) };
        format!("def {kind} \"{prim}\"{shown}\n{{\n")
    }
}

const TRANSFORMED: &str = "    uniform token[] xformOpOrder = [\"xformOp:transform\"]\n";

/// A body in its own axes, about its centre.
fn mesh(name: &Name, body: &CheckedBody, units: Units) -> String {
    let Triangles { points, corners, .. } = welded(&body.shape);
    let center = body.shape.center();
    let points: Vec<_> = points.iter().map(|x| units.vector(x - center).as_vec3().to_array()).collect();
    let mut text = name.define("Mesh");
    let mut rows = |name: &str, rows: &[[f32; 3]]| {
        let _ = write!(text, "    {name} = [");
        put_rows(rows, &mut text);
        text += "]\n";
    };
    rows("float3[] extent", &extent(&points, 0.0));
    rows("point3f[] points", &points);
    list(&mut text, "int[] faceVertexCounts", corners.iter().map(|_| 3), None);
    list(&mut text, "int[] faceVertexIndices", corners.as_flattened().iter(), None);
    text += "    uniform token subdivisionScheme = \"none\"\n";
    text + TRANSFORMED
}

/// A camera, whose film is 36 mm wide.
fn camera(name: &Name, view: &View, units: Units) -> String {
    let [right, up, back] = view.axes().map(|axis| units.turn() * axis);
    let matrix = matrix(DMat3::from_cols(right, up, back), units.vector(view.eye));
    // Lengths of a camera are in tenths of the unit.
    let width = 0.36 / units.metres;
    let height = width * f64::from(view.height) / f64::from(view.width);
    let focal = 0.5 * height / (0.5 * view.fov.to_radians()).tan();
    let [near, far] = [0.01, 1000.0].map(|part| part * view.eye.distance(view.target) / units.metres);
    let body = format!(
        "    float2 clippingRange = ({near}, {far})
    float focalLength = {focal}
    float horizontalAperture = {width}
    float verticalAperture = {height}
    matrix4d xformOp:transform = {matrix}
"
    );
    name.define("Camera") + &body + TRANSFORMED + "}\n"
}

/// The matrix of a rotation and a translation, which USD writes for rows.
fn matrix(turn: DMat3, to: DVec3) -> String {
    let row = |v: DVec3, w: u32| {
        let [x, y, z] = v.to_array().map(|x| (x * 1e12).round() / 1e12);
        format!("({x}, {y}, {z}, {w})")
    };
    format!("({}, {}, {}, {})", row(turn.x_axis, 0), row(turn.y_axis, 0), row(turn.z_axis, 0), row(to, 1))
}

/// The prim with all that stays through a film.
fn still(hair: &HairFrame) -> String {
    let mut text = String::from("def BasisCurves \"Hair\"\n{\n    uniform token basis = \"catmullRom\"\n");
    list(&mut text, "int[] curveVertexCounts", hair.offsets.windows(2).map(|pair| pair[1] - pair[0]), None);
    text += "    uniform token type = \"cubic\"\n    uniform token wrap = \"pinned\"\n";
    if !hair.radius.is_empty() {
        let widths = hair.radius.iter().map(|radius| Shown(2.0 * radius));
        list(&mut text, "float[] widths", widths, Some("vertex"));
    }
    let uniform = Some("uniform");
    // Strands of two groom files may have the same numbers, and a groom_id is that of one curve.
    let mut known = HashSet::new();
    if hair.ids.is_empty() || !hair.ids.iter().all(|id| known.insert(id)) {
        list(&mut text, "int[] primvars:groom_id", 0..hair.offsets.len() - 1, uniform);
    } else {
        list(&mut text, "int[] primvars:groom_id", hair.ids.iter().map(|&id| id as i32), uniform);
    }
    if !hair.groups.is_empty() {
        let groups = hair.groups.iter().map(|&group| group as i32);
        list(&mut text, "int[] primvars:groom_group_id", groups, uniform);
    }
    if !hair.guides.is_empty() {
        list(&mut text, "int[] primvars:groom_guide", hair.guides.iter().map(|&guide| i32::from(guide)), uniform);
    }
    if !hair.root_uvs.is_empty() {
        let uvs = hair.root_uvs.iter().map(|uv| format!("({}, {})", Shown(uv[0]), Shown(uv[1])));
        list(&mut text, "texCoord2f[] primvars:groom_root_uv", uvs, uniform);
    }
    text
}

/// Appends an attribute that is an array.
fn list(
    text: &mut String,
    name: &str,
    values: impl Iterator<Item = impl std::fmt::Display>,
    interpolation: Option<&str>,
) {
    let _ = write!(text, "    {name} = [");
    for (k, value) in values.enumerate() {
        let _ = write!(text, "{}{value}", if k > 0 { ", " } else { "" });
    }
    text.push(']');
    if let Some(interpolation) = interpolation {
        let _ = write!(text, " (\n        interpolation = \"{interpolation}\"\n    )");
    }
    text.push('\n');
}

/// Appends a sample, on one line and without its end.
pub(super) fn sample(code: f64, sampled: &Sampled, frame: &Frame, scenery: &Scenery, units: Units, text: &mut String) {
    let _ = write!(text, "{code}: ");
    match sampled.of {
        Of::Hair(put) => {
            text.push('[');
            put(&frame.hair, text);
            text.push(']');
        }
        Of::Body(i) => {
            let (turn, pose) = (units.turn(), pose(&scenery.bodies, i, frame));
            let place = pose.place(scenery.bodies[i].shape.center(), scenery.bodies[i].shape.center());
            let turned = DMat3::from_quat(turn * pose.rotation * turn.conjugate());
            *text += &matrix(turned, units.vector(place));
        }
    }
    text.push(',');
}

fn put_rows(rows: &[[f32; 3]], text: &mut String) {
    for (k, &[x, y, z]) in rows.iter().enumerate() {
        let _ = write!(text, "{}({}, {}, {})", if k > 0 { ", " } else { "" }, Shown(x), Shown(y), Shown(z));
    }
}

/// Corners of the box about balls of a radius at these points.
fn extent(points: &[[f32; 3]], radius: f32) -> [[f32; 3]; 2] {
    let each = |pick: fn(f32, f32) -> f32, start: f32| {
        points.iter().fold([start; 3], |a, b| [0, 1, 2].map(|k| pick(a[k], b[k])))
    };
    [each(f32::min, f32::INFINITY).map(|x| x - radius), each(f32::max, f32::NEG_INFINITY).map(|x| x + radius)]
}

fn largest(radius: &[f32]) -> f32 {
    radius.iter().copied().fold(0.0, f32::max)
}

/// The shortest text of a number that is read as the same 32 bits.
struct Shown(f32);

impl std::fmt::Display for Shown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Without an exponent a small or large number would be a row of zeros.
        if self.0 == 0.0 || (1e-5..1e7).contains(&self.0.abs()) {
            write!(f, "{}", self.0)
        } else if self.0.is_nan() {
            f.write_str("nan")
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// A text as a string of the file.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' => quoted += "\\\"",
            '\\' => quoted += "\\\\",
            '\n' => quoted += "\\n",
            '\t' => quoted += "\\t",
            c if c.is_control() && c.is_ascii() => {
                let _ = write!(quoted, "\\x{:02x}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}
