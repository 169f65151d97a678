//! USD: strands as BasisCurves with time samples, as text.
//!
//! ```text
//! #usda 1.0
//! ( endTimeCode, upAxis "Y", metersPerUnit 1, timeCodesPerSecond, customLayerData.windswept: version, adapter, seed, scene )
//! def BasisCurves "Hair"      cubic, catmullRom, pinned: curves go through their vertices, which are a strand's points
//!     curveVertexCounts       points of each strand
//!     widths                  [m], vertex: a fibre's diameter
//!     primvars:groom_id, primvars:groom_group_id, primvars:groom_root_uv, primvars:groom_guide    uniform
//!     points.timeSamples      [m] at time codes t timeCodesPerSecond
//!     velocities.timeSamples  [m/s]
//!     extent.timeSamples      [m]: corners of the box about the curves with their widths
//! ```
//!
//! A text file can only grow at its end, and in a file the samples of one attribute follow one another. So [`UsdWriter`], which
//! writes a film while it is simulated, gives each of the three attributes a layer of its own; the one with the points has the
//! others as its sublayers. [`write_usda`] makes one file of a film that is there already, an attribute at a time.
//!
//! A layer that grows ends with [`END`], which closes what is open and begins a comment. A sample is written into the comment, with
//! an [`END`] of its own, and then the one before it is made blank by a single write. So a layer can be read at any moment.
//!
//! Sources: OpenUSD, "UsdGeomBasisCurves"; Epic Games, "Using Alembic for Grooms", for the names after `primvars:`.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use windswept::{Frame, HairFrame};

use crate::strands::check_strands;
use crate::{ExportError, FrameSink, Provenance, Start};

/// The end of a layer: of the samples, of the attribute, of the prim; and what is behind it does not count.
const END: &str = "};}#";
/// What stands in the place of an [`END`] with a sample behind it.
const NO_END: &str = "\n   ";
/// Bytes that a system writes at once, or not: an [`END`] does not lie across a multiple of this.
const PAGE: u64 = 4096;
/// What stands before the last time code, and room for any such number.
const LAST: &str = "endTimeCode = ";
const ROOM: usize = 24;

/// An attribute with a sample per frame.
struct Sampled {
    /// Type and name.
    name: &'static str,
    /// Appends the value of a frame.
    put: fn(&HairFrame, &mut String),
}

/// The attributes with a sample per frame. The first is that of the stage's own layer.
const SAMPLED: [Sampled; 3] = [
    Sampled { name: "point3f[] points", put: |hair, text| put_rows(&hair.positions, text) },
    Sampled { name: "vector3f[] velocities", put: |hair, text| put_rows(&hair.velocities, text) },
    Sampled { name: "float3[] extent", put: |hair, text| put_rows(&extent(hair), text) },
];

/// Writes a film of strands while it is made, and keeps no frame in memory.
///
/// Every frame that [`UsdWriter::append`] returned from is in the files, whatever becomes of the process.
#[derive(Debug)]
pub struct UsdWriter {
    path: PathBuf,
    layers: Vec<Layer>,
    /// First point of each strand, and the number of points.
    offsets: Vec<u32>,
    /// Time codes per second.
    rate: f64,
    last: f64,
    /// Text of a sample; the memory is used again.
    text: String,
}

impl UsdWriter {
    /// Names of the files of a film: the stage, and the layers that it is composed of besides.
    pub const FILES: [&str; 3] = ["hair.usda", "hair.velocities.usda", "hair.extent.usda"];

    /// Begins a film in a folder with the strands of `hair`, at `rate` time codes per second. Files of its names are replaced.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if there is no strand or its arrays make no sense; [`ExportError::File`] if a file cannot be written.
    pub fn create(
        folder: &Path,
        hair: &HairFrame,
        rate: f64,
        provenance: &Provenance<'_>,
    ) -> Result<Self, ExportError> {
        let path = folder.join(Self::FILES[0]);
        check(hair).map_err(|problem| ExportError::Frame { path: path.clone(), problem })?;
        // The stage comes last: it must find its sublayers.
        let mut layers = Vec::new();
        for (name, sampled) in Self::FILES.iter().zip(&SAMPLED).rev() {
            let head = meta(sampled, rate, provenance) + &prim(sampled, hair);
            layers.push(Layer::create(folder.join(name), head)?);
        }
        layers.reverse();
        Ok(Self { path, layers, offsets: hair.offsets.clone(), rate, last: f64::NEG_INFINITY, text: String::new() })
    }

    /// Goes on with a film of such strands, which may be that of a killed run, behind its frames at these times \[s\]; those behind
    /// them are dropped.
    ///
    /// # Errors
    /// As [`Self::create`], and [`ExportError::Frame`] if the files have other strands or not these frames.
    pub fn go_on(folder: &Path, hair: &HairFrame, rate: f64, written: &[f64]) -> Result<Self, ExportError> {
        let path = folder.join(Self::FILES[0]);
        check(hair).map_err(|problem| ExportError::Frame { path: path.clone(), problem })?;
        let codes: Vec<f64> = written.iter().map(|time| code(*time, rate)).collect();
        let layers = Self::FILES.iter().zip(&SAMPLED);
        let layers = layers.map(|(name, sampled)| Layer::go_on(folder.join(name), &prim(sampled, hair), &codes));
        let layers = layers.collect::<Result<Vec<_>, _>>()?;
        let last = codes.last().copied().unwrap_or(f64::NEG_INFINITY);
        let mut film = Self { path, layers, offsets: hair.offsets.clone(), rate, last, text: String::new() };
        film.say_last()?;
        Ok(film)
    }

    /// Writes the next frame. Once this returns, readers of the files find it.
    ///
    /// # Errors
    /// [`ExportError::Frame`] if its strands differ from those of the film, or its time is not behind that of the last frame;
    /// [`ExportError::File`] if it cannot be written. The files keep the frames they had.
    pub fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        let at = code(frame.time, self.rate);
        let problem = check(&frame.hair).err().or_else(|| {
            if frame.hair.offsets != self.offsets {
                return Some("the frame has strands of other lengths than the film".to_owned());
            }
            let behind = at.is_finite() && at > self.last;
            (!behind).then(|| format!("a frame at time code {at} cannot be behind the one at {}", self.last))
        });
        if let Some(problem) = problem {
            return Err(ExportError::Frame { path: self.path.clone(), problem });
        }
        // The points come last: where they are, the rest is.
        for (layer, sampled) in self.layers.iter_mut().zip(&SAMPLED).rev() {
            self.text.clear();
            sample(at, sampled, &frame.hair, &mut self.text);
            layer.append(&mut self.text)?;
        }
        self.last = at;
        self.say_last()
    }

    /// Writes the time code of the last frame to where the stage has it.
    fn say_last(&mut self) -> Result<(), ExportError> {
        let last = format!("{:<ROOM$}", self.last.max(0.0));
        let layer = &mut self.layers[0];
        layer.write_at(layer.last, last.as_bytes())
    }

    /// Hands what was appended to the disk, so that it outlasts the machine too. It outlasts the process in any case.
    ///
    /// # Errors
    /// [`ExportError::File`] if the disk refuses.
    pub fn sync(&self) -> Result<(), ExportError> {
        self.layers.iter().try_for_each(|layer| {
            layer.file.sync_all().map_err(|e| failed(&layer.path, "could not be flushed to the disk", &e))
        })
    }
}

/// A layer that grows.
#[derive(Debug)]
struct Layer {
    path: PathBuf,
    file: File,
    /// Place of its [`END`].
    end: u64,
    /// Place of the last time code in its metadata.
    last: u64,
}

impl Layer {
    fn create(path: PathBuf, mut text: String) -> Result<Self, ExportError> {
        let last = last_code(&text);
        close(&mut text, 0);
        let end = (text.len() - END.len()) as u64;
        fs::write(&path, text).map_err(|e| failed(&path, "could not be created", &e))?;
        let file = opened(&path)?;
        Ok(Self { path, file, end, last })
    }

    /// The layer of this prim, behind its samples of these time codes.
    fn go_on(path: PathBuf, prim: &str, codes: &[f64]) -> Result<Self, ExportError> {
        let misfit = |problem: String| ExportError::Frame { path: path.clone(), problem };
        let file = opened(&path)?;
        let mut lines = Lines { reader: BufReader::new(&file), at: 0, line: Vec::new() };
        let unread = |e: std::io::Error| failed(&path, "could not be read", &e);
        let mut head = String::new();
        while !head.trim_end().ends_with(prim) {
            if !lines.next().map_err(unread)? || lines.at > (prim.len() as u64).saturating_add(MOST_META) {
                return Err(misfit(
                    "has other strands than the run that is to go on, or is no film of windswept".into(),
                ));
            }
            head += &String::from_utf8_lossy(&lines.line);
        }
        let last = last_code(&head);
        let mut end = lines.at - (head.len() - head.trim_end().len()) as u64;
        for (k, code) in codes.iter().enumerate() {
            let from = lines.at;
            let there = lines.next().map_err(unread)?;
            let sample = lines.line.trim_ascii_start().starts_with(format!("{code}: [").as_bytes());
            // Behind the last sample of all stands an end, and perhaps one that was not finished.
            let comment = lines.line.iter().position(|&byte| byte == b'#');
            let length = match comment {
                Some(at) => (at + 1).checked_sub(END.len()),
                None => lines.line.len().checked_sub(1),
            };
            match length {
                Some(length) if there && sample => end = from + length as u64,
                _ => return Err(misfit(format!("expected a frame at time code {code} as number {k}"))),
            }
        }
        let mut layer = Self { path: path.clone(), file, end, last };
        layer.write_at(end, END.as_bytes())?;
        layer.file.set_len(end + END.len() as u64).map_err(|e| failed(&path, "could not be cut", &e))?;
        Ok(layer)
    }

    /// Appends a sample.
    fn append(&mut self, sample: &mut String) -> Result<(), ExportError> {
        let from = self.end + END.len() as u64;
        close(sample, from);
        self.write_at(from, sample.as_bytes())?;
        self.write_at(self.end, NO_END.as_bytes())?;
        self.end = from + (sample.len() - END.len()) as u64;
        Ok(())
    }

    fn write_at(&mut self, place: u64, bytes: &[u8]) -> Result<(), ExportError> {
        let written = self.file.seek(SeekFrom::Start(place)).and_then(|_| self.file.write_all(bytes));
        written.map_err(|e| failed(&self.path, "could not be written", &e))
    }
}

/// Bytes of a layer before its prim, at most: mostly the scene.
const MOST_META: u64 = 64 << 20;

/// Lines of a file, and how far they go.
struct Lines<R> {
    reader: BufReader<R>,
    at: u64,
    line: Vec<u8>,
}

impl<R: Read> Lines<R> {
    /// Reads the next line; says whether there is one.
    fn next(&mut self) -> std::io::Result<bool> {
        self.line.clear();
        let read = self.reader.read_until(b'\n', &mut self.line)?;
        self.at += read as u64;
        Ok(read > 0)
    }
}

fn opened(path: &Path) -> Result<File, ExportError> {
    let file = File::options().read(true).write(true).open(path);
    file.map_err(|e| failed(path, "could not be opened", &e))
}

/// Appends an [`END`] to text that will stand at `from`, where a system writes it at once.
fn close(text: &mut String, from: u64) {
    while (from + text.len() as u64) % PAGE > PAGE - END.len() as u64 {
        text.push(' ');
    }
    *text += END;
}

/// Place of the last time code in a layer's text; behind it is room.
fn last_code(text: &str) -> u64 {
    text.find(LAST).map_or(0, |at| (at + LAST.len()) as u64)
}

/// Writes one file of a film of `frames` frames, of which `frame` makes any, time and again; each attribute's samples follow one
/// another in it. A file at `path` is replaced once all is written.
///
/// # Errors
/// [`ExportError::Frame`] if there is no frame, or frames have no strands or not the same; [`ExportError::File`] if the file cannot
/// be written; what `frame` says.
pub fn write_usda(
    path: &Path,
    frames: usize,
    frame: impl Fn(usize) -> Result<Frame, ExportError>,
    rate: f64,
    provenance: &Provenance<'_>,
) -> Result<(), ExportError> {
    let misfit = |problem: String| ExportError::Frame { path: path.to_path_buf(), problem };
    if frames == 0 {
        return Err(misfit("there is no frame".to_owned()));
    }
    let first = frame(0)?.hair;
    check(&first).map_err(misfit)?;
    let mut part = path.as_os_str().to_owned();
    part.push(".part");
    let unwritten = |e: std::io::Error| failed(path, "could not be written", &e);
    let mut file = BufWriter::new(File::create(&part).map_err(unwritten)?);
    let mut text = stage(rate, provenance, &format!("{}", code(frame(frames - 1)?.time, rate)), "") + &still(&first);
    for sampled in &SAMPLED {
        let _ = writeln!(text, "    {}.timeSamples = {{", sampled.name);
        for k in 0..frames {
            let frame = frame(k)?;
            check(&frame.hair).map_err(misfit)?;
            if frame.hair.offsets != first.offsets {
                return Err(misfit(format!("frame {k} has strands of other lengths than the first")));
            }
            sample(code(frame.time, rate), sampled, &frame.hair, &mut text);
            text.push('\n');
            file.write_all(text.as_bytes()).map_err(unwritten)?;
            text.clear();
        }
        text += "    }\n";
    }
    text += "}\n";
    file.write_all(text.as_bytes()).and_then(|()| file.flush()).map_err(unwritten)?;
    drop(file);
    fs::rename(&part, path).map_err(unwritten)
}

/// Time code of a time \[s\]: not rounded to a whole one, as a frame is where its step is.
fn code(time: f64, rate: f64) -> f64 {
    // A product of two decimal numbers, without its last bits.
    (time * rate * 1e9).round() / 1e9
}

/// Checks that the strands can be written.
fn check(hair: &HairFrame) -> Result<(), String> {
    check_strands(hair)?;
    let (velocities, points) = (hair.velocities.len(), hair.positions.len());
    if velocities != points {
        return Err(format!("the frame has {velocities} velocities, expected {points}"));
    }
    Ok(())
}

/// The metadata of a layer.
fn meta(sampled: &Sampled, rate: f64, provenance: &Provenance<'_>) -> String {
    if sampled.name != SAMPLED[0].name {
        return format!("#usda 1.0\n(\n    timeCodesPerSecond = {rate}\n)\n\n");
    }
    let [_, layers @ ..] = UsdWriter::FILES;
    let layers = layers.map(|name| format!("        @./{name}@")).join(",\n");
    stage(rate, provenance, &format!("{:<ROOM$}", 0), &format!("    subLayers = [\n{layers}\n    ]\n"))
}

/// The metadata of a stage.
fn stage(rate: f64, provenance: &Provenance<'_>, last: &str, layers: &str) -> String {
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
    metersPerUnit = 1
    startTimeCode = 0
{layers}    timeCodesPerSecond = {rate}
    upAxis = \"Y\"
)

"
    )
}

/// The prim of a layer, up to its samples.
fn prim(sampled: &Sampled, hair: &HairFrame) -> String {
    let mut text =
        if sampled.name == SAMPLED[0].name { still(hair) } else { "over BasisCurves \"Hair\"\n{\n".to_owned() };
    let _ = write!(text, "    {}.timeSamples = {{", sampled.name);
    text
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
fn sample(code: f64, sampled: &Sampled, hair: &HairFrame, text: &mut String) {
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

fn failed(path: &Path, doing: &'static str, error: &std::io::Error) -> ExportError {
    ExportError::File { path: path.into(), doing, reason: error.to_string() }
}

/// The film of a run, which is begun with its first frame, or goes on.
pub(crate) struct UsdFilm {
    folder: PathBuf,
    scene: windswept_scene::Scene,
    adapter: String,
    film: Option<UsdWriter>,
}

impl UsdFilm {
    pub(crate) fn new(start: &Start<'_>) -> Result<Self, ExportError> {
        let path = start.folder.join(UsdWriter::FILES[0]);
        check(&start.first.hair).map_err(|problem| ExportError::Frame { path, problem })?;
        let rate = start.scene.time.frame_rate;
        let go_on = || UsdWriter::go_on(start.folder, &start.first.hair, rate, start.written);
        Ok(Self {
            folder: start.folder.into(),
            scene: start.scene.clone(),
            adapter: start.gpu.info().to_string(),
            film: if start.written.is_empty() { None } else { Some(go_on()?) },
        })
    }
}

impl FrameSink for UsdFilm {
    fn append(&mut self, frame: &Frame) -> Result<(), ExportError> {
        let film = match &mut self.film {
            Some(film) => film,
            None => {
                let provenance = Provenance::of(&self.scene, &self.adapter);
                let rate = self.scene.time.frame_rate;
                self.film.insert(UsdWriter::create(&self.folder, &frame.hair, rate, &provenance)?)
            }
        };
        film.append(frame)
    }

    fn sync(&self) -> Result<(), ExportError> {
        self.film.iter().try_for_each(UsdWriter::sync)
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        Ok(())
    }
}
