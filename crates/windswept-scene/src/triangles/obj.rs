//! Wavefront files, `.obj`.
//!
//! Read here and not by the crate `tobj`, which does not say the line of a fault, knows one name of a face, and takes
//! indices for whole before it checks them: more had to be done about it than a reader has to do.

use std::{collections::HashSet, ops::Range, sync::Arc};

use glam::DVec3;

use super::{Part, Triangles};
use crate::{document::short, error::SceneError, limits::MAX_TRIANGLES};

/// Most groups that a face is in: names of each part are kept, so that more would take memory without end.
const MAX_GROUPS: usize = 64;
/// Keywords of the lines that the indices of a corner refer to, in their order, and the content of these lines.
const INDEXED: [(&str, &str); 3] = [("v", "points"), ("vt", "places in the texture"), ("vn", "normals")];
/// A blank in the place of a line break behind a backslash, by which lines are counted.
const CONTINUED: &str = "\u{b}";
/// Index of a corner that has no place in the texture, or no normal.
const NONE: u32 = u32::MAX;

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

/// Lines of a file, up to one.
#[derive(Default)]
struct Lines<'a> {
    /// Number of lines of each kind in the whole file: indices above 0 may refer to later ones.
    all: [usize; 3],
    points: Vec<DVec3>,
    places: Vec<[f32; 2]>,
    normals: Vec<DVec3>,
    /// Indices of the corners of each triangle, of each kind.
    corners: [Vec<[u32; 3]>; 3],
    /// Names of the faces from here on.
    names: Names<'a>,
    parts: Vec<(Names<'a>, Range<usize>)>,
}

impl<'a> Lines<'a> {
    /// Takes the next line, with this keyword; returns its fault.
    fn take(&mut self, keyword: &str, rest: &'a str) -> Result<(), String> {
        match keyword {
            "v" => self.points.push(DVec3::from_array(match numbers(rest)?[..] {
                // Some programs write colours behind the coordinates.
                [x, y, z] | [x, y, z, _, _, _] | [x, y, z, _, _, _, _] => [x, y, z].map(f64::from),
                [x, y, z, w] if w != 0.0 => [x / w, y / w, z / w].map(f64::from),
                _ => return Err(format!("expected a Wavefront file: found the point {:?}", short(rest))),
            })),
            "vt" => self.places.push(match numbers(rest)?[..] {
                [u, v, ..] => [u, v],
                _ => {
                    return Err(format!("expected a Wavefront file: found the place {:?} in the texture", short(rest)));
                }
            }),
            "vn" => self.normals.push(match numbers(rest)?[..] {
                [x, y, z, ..] => DVec3::from_array([x, y, z].map(f64::from)).normalize_or_zero(),
                _ => return Err(format!("expected a Wavefront file: found the normal {:?}", short(rest))),
            }),
            "f" => self.face(rest)?,
            // A group is one of an object.
            "o" => self.names = Names { object: rest, groups: "", ..self.names },
            "g" => {
                let groups = rest.split_whitespace().count();
                if groups > MAX_GROUPS {
                    return Err(format!("names {groups} groups; expected at most {MAX_GROUPS}"));
                }
                self.names.groups = rest;
            }
            "usemtl" => self.names.material = rest,
            _ => {}
        }
        Ok(())
    }

    /// Adds a face as a fan of triangles about its first corner.
    fn face(&mut self, words: &str) -> Result<(), String> {
        let (first, count) = (self.corners[0].len(), words.split_whitespace().count());
        if count < 3 {
            return Err(format!("a face of {count} corners: expected at least 3"));
        }
        if first + count - 2 > MAX_TRIANGLES {
            return Err(format!("expected at most {MAX_TRIANGLES} triangles in the file"));
        }
        let corners = words.split_whitespace().map(|corner| self.corner(corner));
        let corners = corners.collect::<Result<Vec<_>, _>>()?;
        for pair in corners[1..].windows(2) {
            for (kind, indices) in self.corners.iter_mut().enumerate() {
                indices.push([corners[0], pair[0], pair[1]].map(|corner| corner[kind]));
            }
        }
        match self.parts.last_mut() {
            Some((names, triangles)) if *names == self.names => triangles.end = self.corners[0].len(),
            _ => self.parts.push((self.names, first..self.corners[0].len())),
        }
        Ok(())
    }

    /// Indices of a corner of a face, from 0. One below 0 counts back from its line.
    fn corner(&self, corner: &str) -> Result<[u32; 3], String> {
        let before = [self.points.len(), self.places.len(), self.normals.len()];
        let mut indices = [NONE; 3];
        for (kind, word) in corner.split('/').enumerate().filter(|(kind, word)| *kind == 0 || !word.is_empty()) {
            // A corner without a point is as wrong as one with point 0.
            let index = if word.is_empty() { Ok(0) } else { word.parse::<i64>() };
            let (Ok(index), Some((_, what))) = (index, INDEXED.get(kind)) else {
                return Err(format!("expected a Wavefront file: found the corner {:?}", short(corner)));
            };
            let (count, whose) = if index < 0 { (before[kind], "before it") } else { (self.all[kind], "of the file") };
            if index == 0 || index.unsigned_abs() > count as u64 {
                let corner = short(corner);
                return Err(format!("{corner:?} has index {index}, which none of the {count} {what} {whose} has"));
            }
            indices[kind] = (if index < 0 { count as i64 + index } else { index - 1 }) as u32;
        }
        Ok(indices)
    }
}

fn numbers(words: &str) -> Result<Vec<f32>, String> {
    let number = |word: &str| {
        word.parse().map_err(|_| format!("expected a Wavefront file: found {:?} in the place of a number", short(word)))
    };
    words.split_whitespace().map(number).collect()
}

/// Keyword of a line, and what follows it.
fn words(line: &str) -> (&str, &str) {
    line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), ""))
}

/// The text of a file, lines ended as here. A line goes on behind a backslash at its end, unless it is a comment: in
/// the place of the break stands [`CONTINUED`].
fn joined(text: &str) -> String {
    let text = text.trim_start_matches('\u{feff}').replace("\r\n", "\n").replace('\r', "\n");
    let mut joined = String::with_capacity(text.len());
    let mut is_comment = None;
    for line in text.split_inclusive('\n') {
        let comment = *is_comment.get_or_insert_with(|| line.trim_start().starts_with('#'));
        match line.strip_suffix("\\\n").filter(|_| !comment) {
            Some(part) => joined.extend([part, CONTINUED]),
            None => {
                joined.push_str(line);
                is_comment = None;
            }
        }
    }
    joined
}

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, SceneError> {
    // Comments and names may be of any encoding: numbers are text of all.
    let text = joined(&String::from_utf8_lossy(bytes));
    let all = INDEXED.map(|(keyword, _)| text.lines().filter(|line| words(line).0 == keyword).count());
    let mut read = Lines { all, ..Lines::default() };
    let mut number = 1;
    for line in text.lines() {
        let (keyword, rest) = words(line);
        let taken = read.take(keyword, rest.trim());
        taken.map_err(|words| SceneError::new(format!("line {number}: {words}")))?;
        number += 1 + line.matches(CONTINUED).count();
    }
    let Lines { points, places, normals, corners: [corners, of_places, of_normals], parts, .. } = read;
    // A file that ends within a line although some of its points are of no face yet was cut off there.
    let unused = points.len() - corners.as_flattened().iter().collect::<HashSet<_>>().len();
    if unused > 0 && !text.ends_with('\n') {
        let words = format!("expected the end of the line: {unused} of the {} points are of no face yet", points.len());
        let fault = SceneError::new(format!("line {}: {words}", number - 1));
        return Err(fault.with_help("the file is cut off there, or lacks the line break at its end"));
    }
    let parts = parts.into_iter().map(|(names, triangles)| Part { names: names.each(), triangles });
    Ok(Triangles {
        parts: parts.filter(|part| !part.names.is_empty()).collect(),
        normals: of_lines(&normals, &of_normals),
        uvs: of_lines(&places, &of_places),
        points,
        corners,
        unit: None,
    })
}

/// Value of the line of each corner, where there are such lines.
fn of_lines<T: Copy + Default>(lines: &[T], corners: &[[u32; 3]]) -> Vec<[T; 3]> {
    let value = |index: u32| lines.get(index as usize).copied().unwrap_or_default();
    if lines.is_empty() { Vec::new() } else { corners.iter().map(|corners| corners.map(value)).collect() }
}
