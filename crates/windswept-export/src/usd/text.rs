//! Text of a film's layers and files.

use std::fmt::Write as _;

use windswept_engine::HairFrame;

use crate::film::Units;
use crate::provenance::Provenance;

/// Text before the last time code, and room for any such number.
pub(super) const LAST: &str = "endTimeCode = ";
pub(super) const ROOM: usize = 24;

/// An attribute with a sample per frame.
pub(super) struct Sampled {
    /// Name of the layer's file.
    pub(super) file: &'static str,
    /// Type and name.
    pub(super) name: &'static str,
    /// Appends the value of a frame.
    put: fn(&HairFrame, &mut String),
}

/// The attributes with a sample per frame. The first is that of the stage's own layer.
pub(super) const SAMPLED: [Sampled; 3] = [
    Sampled { file: "hair.usda", name: "point3f[] points", put: |hair, text| put_rows(&hair.positions, text) },
    Sampled {
        file: "hair.velocities.usda",
        name: "vector3f[] velocities",
        put: |hair, text| put_rows(&hair.velocities, text),
    },
    Sampled { file: "hair.extent.usda", name: "float3[] extent", put: |hair, text| put_rows(&extent(hair), text) },
];

/// The metadata of a layer.
pub(super) fn meta(sampled: &Sampled, rate: f64, provenance: &Provenance<'_>) -> String {
    if sampled.name != SAMPLED[0].name {
        return format!("#usda 1.0\n(\n    timeCodesPerSecond = {rate}\n)\n\n");
    }
    let [_, layers @ ..] = &SAMPLED;
    let layers = layers.each_ref().map(|layer| format!("        @./{}@", layer.file)).join(",\n");
    stage(
        rate,
        provenance,
        Units::default(),
        &format!("{:<ROOM$}", 0),
        &format!("    subLayers = [\n{layers}\n    ]\n"),
    )
}

/// The metadata of a stage.
pub(super) fn stage(rate: f64, provenance: &Provenance<'_>, units: Units, last: &str, layers: &str) -> String {
    let Units { metres, up } = units;
    let Provenance { scene, version, adapter, seed } = provenance;
    let [scene, version, adapter] = [scene, version, adapter].map(|text| quoted(text));
    format!(
        "#usda 1.0
(
    {LAST}{last}
    customLayerData = {{
        dictionary windswept = {{
            string adapter = {adapter}
            string scene = {scene}
            uint64 seed = {seed}
            string version = {version}
        }}
    }}
    defaultPrim = \"Hair\"
    framesPerSecond = {rate}
    metersPerUnit = {metres}
    startTimeCode = 0
{layers}    timeCodesPerSecond = {rate}
    upAxis = \"{up:?}\"
)

"
    )
}

/// The prim of a layer, up to its samples.
pub(super) fn prim(sampled: &Sampled, hair: &HairFrame) -> String {
    let mut text =
        if sampled.name == SAMPLED[0].name { still(hair) } else { "over BasisCurves \"Hair\"\n{\n".to_owned() };
    let _ = write!(text, "    {}.timeSamples = {{", sampled.name);
    text
}

/// The prim with all that stays through a film.
pub(super) fn still(hair: &HairFrame) -> String {
    let mut text = String::from("def BasisCurves \"Hair\"\n{\n    uniform token basis = \"catmullRom\"\n");
    list(&mut text, "int[] curveVertexCounts", hair.offsets.windows(2).map(|pair| pair[1] - pair[0]), None);
    text += "    uniform token type = \"cubic\"\n    uniform token wrap = \"pinned\"\n";
    if !hair.radius.is_empty() {
        let widths = hair.radius.iter().map(|radius| Shown(2.0 * radius));
        list(&mut text, "float[] widths", widths, Some("vertex"));
    }
    let uniform = Some("uniform");
    match &hair.ids[..] {
        [] => list(&mut text, "int[] primvars:groom_id", 0..hair.offsets.len() - 1, uniform),
        ids => list(&mut text, "int[] primvars:groom_id", ids.iter().map(|&id| id as i32), uniform),
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
pub(super) fn sample(code: f64, sampled: &Sampled, hair: &HairFrame, text: &mut String) {
    let _ = write!(text, "{code}: [");
    (sampled.put)(hair, text);
    *text += "],";
}

fn put_rows(rows: &[[f32; 3]], text: &mut String) {
    for (k, &[x, y, z]) in rows.iter().enumerate() {
        let _ = write!(text, "{}({}, {}, {})", if k > 0 { ", " } else { "" }, Shown(x), Shown(y), Shown(z));
    }
}

/// Corners of the box about the curves, with the widths that they have \[m\].
fn extent(hair: &HairFrame) -> [[f32; 3]; 2] {
    let margin = hair.radius.iter().copied().fold(0.0, f32::max);
    let each = |pick: fn(f32, f32) -> f32, start: f32| {
        hair.positions.iter().fold([start; 3], |a, b| [0, 1, 2].map(|k| pick(a[k], b[k])))
    };
    [each(f32::min, f32::INFINITY).map(|x| x - margin), each(f32::max, f32::NEG_INFINITY).map(|x| x + margin)]
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
