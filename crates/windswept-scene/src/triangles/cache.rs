//! Grids of distances that were made before, kept in the folder that `WINDSWEPT_CACHE` names; where it names none, none
//! is kept.
//!
//! ```text
//! WINDSWEPT_CACHE/windswept/grids/KEY.grid      KEY: SHA-256 of all that a grid is made of: triangles, spacing, margin, VERSION
//!   32 bytes SHA-256 of KEY and of all that follows
//!   origin \[m\], spacing \[m\], counts and values \[m\] of the grid, as the crate postcard has them
//! ```
//!
//! A file that is not as it should be counts as none, and is replaced; what cannot be written is left out. A file is
//! written beside its place and renamed; runs side by side see all of it, or one that is not as it should be.

use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant, SystemTime},
};

use sha2::{Digest, Sha256};

use super::{DistanceGrid, Triangles};
use crate::{atomic::AtomicFile, error::SceneError, limits::MAX_GRID_VALUES};

/// Version of what [`DistanceGrid::bake`] makes, and of the files: another number for any change of either.
const VERSION: u16 = 3;
/// A grid that is made in less is not kept.
const WORTH: Duration = Duration::from_millis(300);
/// Bytes of all files that are kept; the oldest go first.
const MOST: u64 = 1 << 30;
/// Bytes of a checksum.
const SUM: usize = 32;
/// Most bytes of a file: beside its values and the checksum a grid takes less than 64.
const LARGEST: usize = SUM + 64 + 4 * MAX_GRID_VALUES;

/// As [`DistanceGrid::bake`], but read if that was made before.
pub(crate) fn bake(surface: &Triangles, spacing: f64, margin: f64) -> Result<DistanceGrid, SceneError> {
    bake_in(folder(std::env::var_os("WINDSWEPT_CACHE")).as_deref(), WORTH, surface, spacing, margin)
}

/// Where grids are kept; none where they are not.
fn folder(said: Option<OsString>) -> Option<PathBuf> {
    said.filter(|said| !said.is_empty()).map(|said| Path::new(&said).join("windswept").join("grids"))
}

fn bake_in(
    folder: Option<&Path>,
    worth: Duration,
    surface: &Triangles,
    spacing: f64,
    margin: f64,
) -> Result<DistanceGrid, SceneError> {
    let Some(folder) = folder else { return DistanceGrid::bake(surface, spacing, margin) };
    let key = key(surface, spacing, margin);
    let path = folder.join(format!("{}.grid", key.iter().map(|byte| format!("{byte:02x}")).collect::<String>()));
    if let Some(grid) = read(&path, &key) {
        return Ok(grid);
    }
    let began = Instant::now();
    let grid = DistanceGrid::bake(surface, spacing, margin)?;
    let write = |content: Vec<u8>| fs::create_dir_all(folder).and_then(|()| AtomicFile::write(&path, &content));
    if began.elapsed() >= worth && bytes(&grid, &key).is_some_and(|content| write(content).is_ok()) {
        forget(folder, MOST);
    }
    Ok(grid)
}

/// Key that tells one grid from all others.
fn key(surface: &Triangles, spacing: f64, margin: f64) -> [u8; SUM] {
    let mut hash = Sha256::new();
    hash.update(VERSION.to_le_bytes());
    for number in [spacing, margin] {
        hash.update(number.to_le_bytes());
    }
    hash.update((surface.points.len() as u64).to_le_bytes());
    for number in surface.points.iter().flat_map(|x| x.to_array()) {
        hash.update(number.to_le_bytes());
    }
    for index in surface.corners.as_flattened() {
        hash.update(index.to_le_bytes());
    }
    hash.finalize().into()
}

/// The checksum of a file's content under a key.
fn sum(key: &[u8], content: &[u8]) -> [u8; SUM] {
    Sha256::new().chain_update(key).chain_update(content).finalize().into()
}

/// The content of a file.
fn bytes(grid: &DistanceGrid, key: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = postcard::to_extend(grid, vec![0; SUM]).ok()?;
    let (found, content) = bytes.split_at_mut(SUM);
    found.copy_from_slice(&sum(key, content));
    Some(bytes)
}

/// The grid in a file; none where there is no file, or one that is broken.
fn read(path: &Path, key: &[u8]) -> Option<DistanceGrid> {
    let metadata = fs::metadata(path).ok()?;
    if !metadata.is_file() || metadata.len() > LARGEST as u64 {
        return None;
    }
    let bytes = fs::read(path).ok()?;
    let (found, content) = bytes.split_at_checked(SUM)?;
    if found != sum(key, content) {
        return None;
    }
    let grid: DistanceGrid = postcard::from_bytes(content).ok()?;
    let nodes = grid.counts.iter().try_fold(1, |nodes: usize, count| nodes.checked_mul(*count as usize));
    (nodes == Some(grid.values.len())).then_some(grid)
}

/// Removes the oldest files until the others have at most this many bytes; leftover parts count as files.
fn forget(folder: &Path, most: u64) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let file = |entry: fs::DirEntry| {
        let metadata = entry.metadata().ok().filter(fs::Metadata::is_file)?;
        Some((metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH), metadata.len(), entry.path()))
    };
    let mut files: Vec<_> = entries.filter_map(|entry| file(entry.ok()?)).collect();
    files.sort();
    let mut all: u64 = files.iter().map(|(_, bytes, _)| bytes).sum();
    for (_, bytes, path) in files {
        if all <= most {
            return;
        }
        if fs::remove_file(path).is_ok() {
            all -= bytes;
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may panic

    use super::*;
    use crate::body::CheckedShape;

    /// A grid comes back to the last bit; a file that is cut, altered or another's counts as none; other triangles and
    /// other spacings have files of their own, and the oldest go.
    #[test]
    fn grids_come_back_as_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let kept = folder.path().join("grids");
        let ball = |radius: f64| CheckedShape::sphere([0.1, 0.2, 0.3], radius).surface(16, 16);
        let make = |radius: f64, spacing: f64| {
            let grid = bake_in(Some(&kept), Duration::ZERO, &ball(radius), spacing, 3.0 * spacing);
            grid.unwrap()
        };
        let files = || -> Vec<PathBuf> {
            let entries = fs::read_dir(&kept).unwrap();
            entries.filter_map(|entry| Some(entry.ok()?.path())).collect()
        };
        let first = make(0.04, 4e-3);
        let [path] = &files()[..] else { panic!("{:?}", files()) };
        let key = key(&ball(0.04), 4e-3, 3.0 * 4e-3);
        assert_eq!(read(path, &key).as_ref(), Some(&first));
        assert_eq!(bake_in(None, Duration::ZERO, &ball(0.04), 4e-3, 3.0 * 4e-3).as_ref(), Ok(&first));
        // The grid in the file is taken.
        let other = DistanceGrid { spacing: 5e-3, ..first.clone() };
        let replaced = |content: &[u8]| fs::write(path, content).unwrap();
        replaced(&bytes(&other, &key).unwrap());
        assert_eq!(make(0.04, 4e-3), other);
        let whole = bytes(&first, &key).unwrap();
        for at in (0..whole.len()).step_by(whole.len() / 97) {
            let mut altered = whole.clone();
            altered[at] ^= 0x10;
            replaced(&altered);
            assert_eq!(read(path, &key), None, "byte {at}");
            replaced(&whole[..at]);
            assert_eq!(read(path, &key), None, "{at} bytes");
        }
        assert_eq!(make(0.04, 4e-3), first);
        assert_eq!(read(path, &key).as_ref(), Some(&first), "a broken file is not replaced");
        replaced(&bytes(&first, &[0; SUM]).unwrap());
        assert_eq!(read(path, &key), None);
        make(0.041, 4e-3);
        make(0.04, 4.1e-3);
        assert_eq!(files().len(), 3);
        forget(&kept, 2 * whole.len() as u64 + 2000);
        assert!((1..3).contains(&files().len()), "{:?}", files());
        // Where nothing can be kept, grids are made all the same.
        let file = folder.path().join("file");
        fs::write(&file, b"").unwrap();
        let grid = bake_in(Some(&file), Duration::ZERO, &ball(0.04), 4e-3, 3.0 * 4e-3);
        assert_eq!(grid.as_ref(), Ok(&first));
    }

    /// Grids are kept in no folder but one that an environment variable names.
    #[test]
    fn only_a_named_folder_keeps_grids() {
        assert_eq!(folder(None), None);
        assert_eq!(folder(Some("".into())), None);
        assert_eq!(folder(Some("/cache".into())), Some(PathBuf::from("/cache/windswept/grids")));
    }
}
