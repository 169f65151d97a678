//! Curves of groom files: the contents of a file, in its own units and axes, and their conversion into strands.

mod bytes;
mod cyhair;
mod farthest;
mod fit;
mod npy;
pub(crate) mod npz;
mod padding;
mod ply;
mod usc;

use std::{collections::HashSet, fs, io::Read as _, path::Path};

use serde::{Deserialize, Serialize};

pub(crate) use bytes::{Bytes, fault_at};
pub use fit::Dropped;
pub(crate) use fit::no_unit;
pub use npy::npy_head;
pub(crate) use ply::polygons as ply_polygons;

use crate::{
    atomic::AtomicFile,
    error::SceneError,
    limits::{LARGEST, LARGEST_DATA_FILE, LARGEST_OBJ_FILE, LONGEST_PLY_HEADER},
};

/// Curves of a groom file, in the units and axes of the file.
///
/// Offsets rise from 0 to the number of points; there is an id for each strand, a radius for each point or none, and a
/// group, a place of the root and a mark for each strand or none. Curves that are read from a file are so; curves that
/// are made in code are checked where they are written or become strands. Elsewhere arrays that do not belong together
/// panic, as an index that is too large does.
///
/// ```no_run
/// use windswept_scene::Curves;
///
/// let curves = Curves::load("wCurly.hair", None)?;
/// println!("{} strands in {:?}", curves.len(), curves.bounds());
/// curves.save("curly.npz")?;
/// # Ok::<(), windswept_scene::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Curves {
    /// Points of all strands, strand by strand, root to tip \[units of the file\].
    pub points: Vec<[f64; 3]>,
    /// Index of each strand's first point, and the number of points: strands + 1.
    pub offsets: Vec<u32>,
    /// Number of each strand: the file's, or its index in the file.
    pub ids: Vec<u32>,
    /// Radius at each point \[units of the file\]; empty where the file has none.
    pub radius: Vec<f64>,
    /// Metres per unit, where the file says it.
    pub unit: Option<f64>,
    /// Group of each strand; empty where the file has none.
    pub groups: Vec<u32>,
    /// Place of each root in the texture of what it grows on; empty where the file has none.
    pub root_uvs: Vec<[f32; 2]>,
    /// Whether each strand is a guide, which others follow; empty where nothing says which are.
    pub guides: Vec<bool>,
}

/// Curves of a file's bytes; the number is that of each strand's points, where the file does not say.
type Read = fn(&[u8], Option<u32>) -> Result<Curves, SceneError>;
/// Bytes of a file with the curves.
type Write = fn(&Curves) -> Result<Vec<u8>, SceneError>;

/// A format of groom files.
pub struct GroomFormat {
    /// Ending of the files' names, without the dot.
    pub extension: &'static str,
    /// Description of the format, for people.
    pub what: &'static str,
    read: Read,
    write: Option<Write>,
    /// Arrays of a written file beside points, by the names of [`Curves::arrays`].
    holds: &'static [&'static str],
}

impl GroomFormat {
    /// Every format there is.
    pub const ALL: &'static [Self] = &[
        Self {
            extension: "hair",
            what: "Cem Yuksel's hair files",
            read: |bytes, _| cyhair::read(bytes),
            write: Some(cyhair::write),
            holds: &["radius"],
        },
        Self {
            extension: "data",
            what: "USC-HairSalon, Perm",
            read: |bytes, _| usc::read(bytes, usc::Record::Point),
            write: Some(usc::write),
            holds: &[],
        },
        Self {
            extension: "bin",
            what: "CT2Hair",
            read: |bytes, _| usc::read(bytes, usc::Record::Labelled),
            write: None,
            holds: &[],
        },
        Self {
            extension: "npz",
            what: "NumPy arrays; keeps everything",
            read: npz::read,
            write: Some(npz::write),
            holds: &["ids", "radius", "groups", "root_uv", "guides"],
        },
        Self {
            extension: "npy",
            what: "a NumPy array (strands, n, 3)",
            read: npy::read,
            write: Some(npy::write),
            holds: &[],
        },
        Self {
            extension: "ply",
            what: "GaussianHaircut, hairutil",
            read: ply::read,
            write: Some(ply::write),
            holds: &["radius"],
        },
    ];

    /// The format of a file by the ending of its name, among those that `fits` says are of use.
    fn of(path: &Path, fits: impl Fn(&Self) -> bool) -> Result<&'static Self, SceneError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        Self::ALL.iter().find(|format| format.extension == ending).ok_or_else(|| {
            let known = Self::ALL.iter().filter(|format| fits(format)).map(|format| format!(".{}", format.extension));
            let fault = SceneError::new(format!("expected a groom file: {}", known.collect::<Vec<_>>().join(", ")));
            match ending.as_str() {
                "usd" | "usda" | "usdc" | "usdz" => {
                    fault.with_help("windswept.usd.to_npz(FILE, \"groom.npz\") in Python makes one of a USD file")
                }
                "abc" => fault.with_help(
                    "Blender imports Alembic and exports USD, of which windswept.usd.to_npz(FILE, \"groom.npz\") in Python makes one",
                ),
                _ => fault,
            }
        })
    }

    /// The format of a file to write, and how that is written.
    fn to_write(path: &Path) -> Result<(&'static Self, Write), SceneError> {
        let format = Self::of(path, Self::writes)?;
        let write = format.write.ok_or_else(|| {
            let words = format!(".{} files are read, not written", format.extension);
            SceneError::new(words)
        })?;
        Ok((format, write))
    }

    /// Whether a file of this name can be a groom file that is written: by the ending of its name alone.
    ///
    /// # Errors
    /// [`SceneError`] names the file and the endings that there are.
    pub fn check_output(path: impl AsRef<Path>) -> Result<(), SceneError> {
        let path = path.as_ref();
        Self::to_write(path).map(drop).map_err(|error| error.of(&path.display().to_string(), ""))
    }

    /// Reads a file of the format from its bytes; `points_per_strand` is for files that do not say where a strand ends.
    ///
    /// # Errors
    /// [`SceneError`] names the byte, and says what was expected there.
    pub fn read(&self, bytes: &[u8], points_per_strand: Option<u32>) -> Result<Curves, SceneError> {
        (self.read)(bytes, points_per_strand)
    }

    /// Whether files of the format can be written.
    #[must_use]
    pub fn writes(&self) -> bool {
        self.write.is_some()
    }
}

impl Curves {
    /// Reads a groom file; `points_per_strand` is for files that do not say where a strand ends.
    ///
    /// # Errors
    /// [`SceneError`] names the file and the byte, and says what was expected there.
    pub fn load(path: impl AsRef<Path>, points_per_strand: Option<u32>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let read = || {
            let format = GroomFormat::of(path, |_| true)?;
            format.read(&file_bytes(path)?, points_per_strand)
        };
        read().map_err(|error: SceneError| error.of(&path.display().to_string(), ""))
    }

    /// Writes a groom file of the format that its name ends in; a file of this name is replaced once all is written.
    /// The returned note names the data of the curves that such a file does not hold.
    ///
    /// # Errors
    /// [`SceneError`] where the format cannot hold the curves, and where the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<Option<String>, SceneError> {
        let path = path.as_ref();
        let write = || {
            let (format, write) = GroomFormat::to_write(path)?;
            self.check()?;
            AtomicFile::write(path, &write(self)?)
                .map_err(|error| SceneError::new(format!("cannot be written: {error}")))?;
            Ok(format)
        };
        let format = write().map_err(|error: SceneError| error.of(&path.display().to_string(), ""))?;
        let lost: Vec<&str> = self.arrays().filter(|name| !format.holds.contains(name)).collect();
        let words = || format!("{} has no {}: a .npz file holds them", path.display(), lost.join(", "));
        Ok((!lost.is_empty()).then(words))
    }

    /// Names that a `.npz` file has for what the curves have beside their points, and no rule says: ids that are not
    /// the strands' indices, radii that are not one.
    fn arrays(&self) -> impl Iterator<Item = &'static str> {
        let arrays = [
            ("ids", self.ids.iter().zip(0..).any(|(id, index)| *id != index)),
            ("radius", self.radius.windows(2).any(|pair| pair[0] != pair[1])),
            ("groups", !self.groups.is_empty()),
            ("root_uv", !self.root_uvs.is_empty()),
            ("guides", !self.guides.is_empty()),
        ];
        arrays.into_iter().filter(|(_, there)| *there).map(|(name, _)| name)
    }

    /// Curves from the number of points of each; `points` are as many in all.
    fn of(points: Vec<[f64; 3]>, counts: impl Iterator<Item = u32>) -> Self {
        let mut offsets = vec![0];
        let mut end = 0u32;
        offsets.extend(counts.map(|count| {
            end += count;
            end
        }));
        let ids = (0..offsets.len() as u32 - 1).collect();
        Self { points, offsets, ids, ..Self::default() }
    }

    /// Curves of equally many points each.
    fn even(points: Vec<[f64; 3]>, each: Option<u32>) -> Result<Self, SceneError> {
        let Some(each) = each else {
            let words = format!(
                "the {} points do not say where a strand ends: expected how many points each strand has",
                points.len()
            );
            return Err(SceneError::new(words).at("points_per_strand", None));
        };
        let total = count32(points.len())?;
        if each == 0 || total % each != 0 {
            let words = format!("expected a number that divides the {total} points of the file, found {each}");
            return Err(SceneError::new(words).at("points_per_strand", None));
        }
        Ok(Self::of(points, std::iter::repeat_n(each, (total / each) as usize)))
    }

    /// Whether the arrays belong together.
    pub(crate) fn check(&self) -> Result<(), SceneError> {
        let (points, strands) = (self.points.len(), self.len());
        let ends = (self.offsets.first().copied(), self.offsets.last().map(|&last| last as usize));
        let radii = self.radius.len();
        if ends != (Some(0), Some(points)) || !self.offsets.is_sorted() {
            return Err(SceneError::new(format!("offsets: expected rising numbers from 0 to {points}, the points")));
        }
        let (ids, groups) = (self.ids.len(), self.groups.len());
        if ids != strands {
            return Err(SceneError::new(format!("ids: expected {strands}, one a strand, found {ids}")));
        }
        let or_none = [("groups", groups), ("root_uvs", self.root_uvs.len()), ("guides", self.guides.len())];
        if let Some((name, found)) = or_none.into_iter().find(|(_, found)| ![0, strands].contains(found)) {
            return Err(SceneError::new(format!("{name}: expected {strands}, one a strand, or none, found {found}")));
        }
        if radii != 0 && radii != points {
            return Err(SceneError::new(format!("radius: expected {points}, one a point, or none, found {radii}")));
        }
        Ok(())
    }

    /// Number of strands.
    #[must_use]
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there is no strand.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The points of strand `s`.
    #[must_use]
    pub fn strand(&self, s: usize) -> &[[f64; 3]] {
        &self.points[self.range(s)]
    }

    fn range(&self, s: usize) -> std::ops::Range<usize> {
        self.offsets[s] as usize..self.offsets[s + 1] as usize
    }

    /// Number of points of each strand.
    fn counts(&self) -> impl Iterator<Item = u32> + '_ {
        self.offsets.windows(2).map(|pair| pair[1] - pair[0])
    }

    /// Number of segments of each strand, as `format` has it.
    fn segments(&self, format: &str) -> Result<Vec<u16>, SceneError> {
        let segments = |(s, count): (usize, u32)| {
            let words = || format!("strand {s} has {count} points; {format} holds strands of 1 to 65536");
            let fits = count.checked_sub(1).and_then(|segments| u16::try_from(segments).ok());
            fits.ok_or_else(|| SceneError::new(words()))
        };
        self.counts().enumerate().map(segments).collect()
    }

    /// Number of strands that the file marks as guides.
    #[must_use]
    pub fn marked(&self) -> usize {
        self.guides.iter().filter(|mark| **mark).count()
    }

    /// Whether the marks tell strands that are simulated from others, which follow them: not where all or none are
    /// marked.
    #[must_use]
    pub(crate) fn follow(&self) -> bool {
        (1..self.len()).contains(&self.marked())
    }

    /// Number of strands that are simulated: those that are marked, where others follow them, and else all.
    pub(crate) fn simulated(&self) -> usize {
        if self.follow() { self.marked() } else { self.len() }
    }

    /// Number of strands with the id of a strand before them.
    #[must_use]
    pub fn doubled_ids(&self) -> usize {
        let mut seen = HashSet::with_capacity(self.ids.len());
        self.ids.iter().filter(|id| !seen.insert(**id)).count()
    }

    /// Corners of the box about all points that are finite; `None` where there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        let finite = self.points.iter().filter(|x| is_finite(x));
        finite.fold(None, |all, x| {
            let [low, high] = all.unwrap_or([*x, *x]);
            let each = |pick: fn(f64, f64) -> f64, y: [f64; 3]| [0, 1, 2].map(|k| pick(x[k], y[k]));
            Some([each(f64::min, low), each(f64::max, high)])
        })
    }
}

/// All bytes of a groom or mesh file.
pub(crate) fn file_bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    let unread = |error: std::io::Error| SceneError::new(format!("cannot be read: {error}"));
    // A pipe or a device, which is no file, may never end.
    let metadata = fs::metadata(path).map_err(unread)?;
    if !metadata.is_file() {
        return Err(SceneError::new("expected a file"));
    }
    let length = metadata.len();
    let ends_in = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
    let most = if ends_in("obj") { LARGEST_OBJ_FILE } else { LARGEST_DATA_FILE };
    if length > most {
        return Err(SceneError::new(format!("expected a file of at most {most} bytes, found {length}")));
    }
    let mut file = fs::File::open(path).map_err(unread)?;
    let mut bytes = Vec::new();
    if ends_in("ply") {
        // The rest of a file that is no polygon file is left alone.
        file.by_ref().take(LONGEST_PLY_HEADER).read_to_end(&mut bytes).map_err(unread)?;
        ply::check_header(&bytes)?;
    }
    file.read_to_end(&mut bytes).map_err(unread)?;
    Ok(bytes)
}

/// Whether a point can be computed with.
fn is_finite(x: &[f64; 3]) -> bool {
    x.iter().all(|x| x.abs() <= LARGEST)
}

/// A number of points or strands: 32 bits number them.
fn count32(count: usize) -> Result<u32, SceneError> {
    u32::try_from(count).map_err(|_| SceneError::new(format!("expected at most {} points, found {count}", u32::MAX)))
}
