//! Wavefront files, `.obj`.

use glam::DVec3;

use super::Triangles;
use crate::error::SceneError;

pub(super) fn read(mut bytes: &[u8]) -> Result<Triangles, SceneError> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_lines: true, ignore_points: true, ..Default::default() };
    // What a surface is made of does not change its shape.
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut bytes, &options, no_materials)
        .map_err(|error| SceneError::new(format!("expected a Wavefront file: {error}")))?;
    let mut all = Triangles::default();
    for mesh in models.into_iter().map(|model| model.mesh) {
        let first = all.points.len() as u32;
        let points = mesh.positions.as_chunks::<3>().0;
        all.points.extend(points.iter().map(|point| DVec3::from_array(point.map(f64::from))));
        all.corners.extend(mesh.indices.as_chunks::<3>().0.iter().map(|corners| corners.map(|index| first + index)));
    }
    Ok(all)
}
