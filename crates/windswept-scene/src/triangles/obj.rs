//! Wavefront files, `.obj`.

use std::{collections::HashSet, sync::Arc};

use glam::DVec3;

use super::Triangles;
use crate::{error::SceneError, limits::MAX_TRIANGLES};

/// Most groups that a face is in: names of each part are kept, so that more would take memory without end.
const MAX_GROUPS: usize = 64;

/// The line, from 1, with which the lines up to it begin to be faulty, of those that were read until the fault was
/// seen.
fn line_of(read: &[u8], is_faulty: impl Fn(&[u8]) -> bool) -> usize {
    let lines: Vec<&[u8]> = read.split_inclusive(|byte| *byte == b'\n').collect();
    let (mut sound, mut faulty) = (0, lines.len());
    let mut end = 0;
    // The last line is the one, unless the fault is seen where a part of the mesh ends.
    let mut middle = faulty.saturating_sub(1);
    while faulty - sound > 1 {
        let to = end + lines[sound..middle].iter().map(|line| line.len()).sum::<usize>();
        if is_faulty(&read[..to]) {
            faulty = middle;
        } else {
            (sound, end) = (middle, to);
        }
        middle = usize::midpoint(sound, faulty);
    }
    faulty
}

/// Keywords of the lines that indices refer to, and the content of these lines.
const INDEXED: [(&str, &str); 3] = [("v", "points"), ("vt", "places in the texture"), ("vn", "normals")];

/// Refuses more faces than a mesh may have, and an index without a line that it refers to: the crate multiplies indices
/// before it checks them. An index below 0 counts back from its line.
fn check_faces(text: &str) -> Result<(), SceneError> {
    let lines = || {
        let lines = text.split('\n').map(str::split_whitespace);
        lines.map(|mut words| (words.next().unwrap_or_default(), words))
    };
    let kind = |word: &str| INDEXED.iter().position(|(name, _)| *name == word);
    let mut all = [0_u64; 3];
    lines().filter_map(|(word, _)| kind(word)).for_each(|kind| all[kind] += 1);
    let (mut before, mut triangles) = ([0_u64; 3], 0);
    for (number, (word, corners)) in (1..).zip(lines()) {
        if let Some(kind) = kind(word) {
            before[kind] += 1;
        }
        if word == "f" {
            triangles += corners.clone().count().saturating_sub(2);
            if triangles > MAX_TRIANGLES {
                return Err(SceneError::new(format!(
                    "line {number}: expected at most {MAX_TRIANGLES} triangles in the file"
                )));
            }
        }
        for corner in corners.filter(|_| ["f", "l", "p"].contains(&word)) {
            for (kind, index) in corner.split('/').enumerate().take(INDEXED.len()) {
                // A corner without a point is as wrong as one with point 0.
                let index = if kind == 0 && index.is_empty() { "0" } else { index };
                let Ok(index) = index.parse::<i64>() else { continue };
                let (count, whose) = if index < 0 { (before[kind], "before it") } else { (all[kind], "of the file") };
                if index == 0 || index.unsigned_abs() > count {
                    let what = INDEXED[kind].1;
                    return Err(SceneError::new(format!(
                        "line {number}: {corner:?} has index {index}, which none of the {count} {what} {whose} has"
                    )));
                }
            }
        }
    }
    Ok(())
}

/// Refuses faces that are none, and a file that ends within a line although some of its points are of no face yet: it
/// was cut off there.
fn check_whole(text: &str) -> Result<(), SceneError> {
    let is_whole = text.ends_with('\n');
    let (mut points, mut used) = (0_u64, HashSet::new());
    for (number, mut words) in (1..).zip(text.lines().map(str::split_whitespace)) {
        match words.next() {
            Some("v") => points += 1,
            Some("f") => {
                let corners = words.clone().count();
                if corners < 3 {
                    let words = format!("line {number}: a face of {corners} corners: expected at least 3");
                    return Err(SceneError::new(words));
                }
                used.extend(words.filter(|_| !is_whole).filter_map(|corner| {
                    let index: i64 = corner.split('/').next()?.parse().ok()?;
                    Some(if index < 0 { points.saturating_add_signed(index) } else { index.unsigned_abs() - 1 })
                }));
            }
            _ => {}
        }
    }
    let unused = points - used.len() as u64;
    if is_whole || unused == 0 {
        return Ok(());
    }
    let words = format!("expected the end of the line: {unused} of the {points} points are of no face yet");
    let fault = SceneError::new(format!("line {}: {words}", text.lines().count()));
    Err(fault.with_help("the file is cut off there, or lacks the line break at its end"))
}

/// Names of faces, from a line of the file on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Names<'a> {
    object: &'a str,
    /// As many groups as it has words.
    groups: &'a str,
    material: &'a str,
}

impl Names<'_> {
    /// Each name by itself. Some programs write groups with blanks in their names: all words of the groups are a name
    /// too.
    fn each(self) -> Vec<Arc<str>> {
        let groups = self.groups.split_whitespace().filter(|group| *group != self.groups);
        let names = [self.object, self.groups].into_iter().chain(groups).chain([self.material]);
        names.filter(|name| !name.is_empty()).map(Arc::from).collect()
    }
}

/// The file with the number of its names as the one name of each face, and what the numbers stand for: the crate knows
/// an object or a group of each face, and materials only of a library, whose properties do not matter here. Lines keep
/// their numbers.
fn numbered(given: &str) -> Result<(String, Vec<Names<'_>>), SceneError> {
    let mut text = String::with_capacity(given.len() + 1);
    let mut names = vec![Names::default()];
    let mut last = Names::default();
    for (number, line) in (1..).zip(given.split('\n')) {
        let words = line.trim();
        let (word, name) = words.split_once(char::is_whitespace).unwrap_or((words, ""));
        let name = name.trim();
        let now = match word {
            // A group is one of an object.
            "o" => Names { object: name, groups: "", ..last },
            "g" => Names { groups: name, ..last },
            "usemtl" => Names { material: name, ..last },
            _ => {
                text.push_str(line);
                text.push('\n');
                continue;
            }
        };
        let groups = now.groups.split_whitespace().count();
        if groups > MAX_GROUPS {
            return Err(SceneError::new(format!(
                "line {number}: names {groups} groups; expected at most {MAX_GROUPS}"
            )));
        }
        if now != last {
            text.push_str(&format!("g {}", names.len()));
            names.push(now);
            last = now;
        }
        text.push('\n');
    }
    Ok((text, names))
}

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, SceneError> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_lines: true, ignore_points: true, ..Default::default() };
    // The bytes that are left are behind the last line that was read.
    let load = |left: &mut &[u8]| tobj::load_obj_buf(left, &options, |_| Err(tobj::LoadError::OpenFileFailed));
    // Comments and names may be of any encoding: numbers are text of all.
    let given = String::from_utf8_lossy(bytes);
    let (text, names) = numbered(&given)?;
    check_faces(&text)?;
    let mut left = text.as_bytes();
    let loaded = load(&mut left);
    let (models, _) = loaded.map_err(|error| {
        let read = &text.as_bytes()[..text.len() - left.len()];
        let line = line_of(read, |mut part| load(&mut part).is_err_and(|other| other == error));
        SceneError::new(format!("line {line}: expected a Wavefront file: {error}"))
    })?;
    check_whole(&given)?;
    let mut all = Triangles::default();
    for model in models {
        let mesh = model.mesh;
        let first = all.points.len() as u32;
        let points = mesh.positions.as_chunks::<3>().0;
        all.points.extend(points.iter().map(|point| DVec3::from_array(point.map(f64::from))));
        let triangles = mesh.indices.as_chunks::<3>().0;
        let of_corners = |indices: &[u32]| -> Vec<[u32; 3]> {
            if indices.len() == mesh.indices.len() { indices.as_chunks::<3>().0.to_vec() } else { Vec::new() }
        };
        let normal = |i: u32| {
            let normal = mesh.normals.as_chunks::<3>().0.get(i as usize).copied().unwrap_or_default();
            DVec3::from_array(normal.map(f64::from)).normalize_or_zero()
        };
        let uv = |i: u32| mesh.texcoords.as_chunks::<2>().0.get(i as usize).copied().unwrap_or_default();
        let normals = of_corners(&mesh.normal_indices).into_iter().map(|corners| corners.map(normal)).collect();
        let uvs = of_corners(&mesh.texcoord_indices).into_iter().map(|corners| corners.map(uv)).collect();
        // The crate has a name of its own for faces before any.
        let names = model.name.parse().ok().and_then(|number: usize| names.get(number)).copied().unwrap_or_default();
        all.append(names.each(), triangles.iter().map(|corners| corners.map(|index| first + index)), normals, uvs);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::line_of;

    /// A line that is wrong by itself is the last that was read: all before it is looked at once, however much it is.
    #[test]
    fn the_last_line_is_looked_at_first() {
        for (faulty, most) in [(1000, 1), (640, 12), (1, 12)] {
            let text: Vec<u8> = (1..=1000).flat_map(|line| if line == faulty { *b"x\n" } else { *b".\n" }).collect();
            let looks = Cell::new(0);
            let line = line_of(&text, |part| {
                looks.set(looks.get() + 1);
                part.contains(&b'x')
            });
            assert!(line == faulty && looks.get() <= most, "line {line} after {} looks", looks.get());
        }
    }
}
