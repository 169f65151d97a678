//! Checks of a frame's strands before anything is made of them.

use windswept_engine::HairFrame;

/// Says what is wrong with strands whose points do not make strands, or whose arrays do not fit them.
pub(crate) fn check_strands(hair: &HairFrame) -> Result<(), String> {
    let points = hair.positions.len();
    if points == 0 {
        return Err("the frame has no strands".to_owned());
    }
    let (first, last) = (hair.offsets.first(), hair.offsets.last());
    if first != Some(&0) || last.map(|&last| last as usize) != Some(points) {
        return Err(format!("the strands' offsets go from {first:?} to {last:?}, not from 0 to the {points} points"));
    }
    if let Some(strand) = hair.offsets.windows(2).position(|w| w[1] < w[0].saturating_add(2)) {
        return Err(format!("strand {strand} has fewer than two points"));
    }
    let strands = hair.offsets.len() - 1;
    let or_none = [
        ("ids", hair.ids.len(), strands),
        ("groups", hair.groups.len(), strands),
        ("numbers of fibres", hair.fibres.len(), strands),
        ("root_uvs", hair.root_uvs.len(), strands),
        ("root_frames", hair.root_frames.len(), strands),
        ("guides", hair.guides.len(), strands),
        ("radii", hair.radius.len(), points),
    ];
    match or_none.into_iter().find(|(_, found, expected)| ![0, *expected].contains(found)) {
        Some((what, found, expected)) => Err(format!("the frame has {found} {what}, expected {expected} or none")),
        None => Ok(()),
    }
}
