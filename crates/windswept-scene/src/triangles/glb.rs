//! Binary glTF 2.0 files, `.glb`: the triangles of every node of the default scene, where the nodes or the joints of a
//! skin have them.
//!
//! Read here and not by the crate `gltf`, whose check of a file panics on some that are broken.
//!
//! Source: Khronos Group, "glTF 2.0 Specification", sections 3 (skins: 3.7.3) and 4.4.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use glam::{DMat4, DQuat, DVec3};
use serde::Deserialize;

use super::{Triangles, of_corners};
use crate::{
    curves::{Bytes, fault_at},
    error::SceneError,
    limits::{MAX_PRIMITIVES, MAX_TRIANGLES},
};

/// A primitive's mode, or kind of numbers, as the format numbers them.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;
/// What each point of a skin needs.
const WEIGHTED: &str = "expected four joints and four weights a point";
/// Kinds of extensions of a surface's looks: `KHR_texture_basisu`, `KHR_materials_unlit`.
const LOOKS: [&str; 3] = ["texture", "materials", "lights"];
const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// Fields of a file about its triangles; the rest is passed over.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
struct Document {
    /// The scene that is shown, by its index; none: the first.
    scene: Option<usize>,
    scenes: Vec<Nodes>,
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    materials: Vec<Named>,
    skins: Vec<Skin>,
    extensions_required: Vec<String>,
}

/// Joints that carry the points of a mesh.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Skin {
    /// Nodes.
    joints: Vec<usize>,
    /// Accessor of a matrix for each joint, from the mesh to the joint; none: identities.
    inverse_bind_matrices: Option<usize>,
}

#[derive(Deserialize)]
struct Named {
    name: Option<Arc<str>>,
}

#[derive(Deserialize)]
struct Nodes {
    #[serde(default)]
    nodes: Vec<usize>,
}

#[derive(Deserialize, Clone)]
#[serde(default)]
struct Node {
    name: Option<Arc<str>>,
    children: Vec<usize>,
    mesh: Option<usize>,
    skin: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

impl Default for Node {
    fn default() -> Self {
        Self {
            name: None,
            children: Vec::new(),
            mesh: None,
            skin: None,
            matrix: None,
            translation: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            scale: DVec3::ONE,
        }
    }
}

#[derive(Deserialize)]
struct Mesh {
    name: Option<Arc<str>>,
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: HashMap<String, usize>,
    indices: Option<usize>,
    material: Option<usize>,
    mode: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: u64,
    component_type: u32,
    count: u64,
    r#type: String,
    sparse: Option<serde_json::Value>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_stride: Option<u64>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, SceneError> {
    let (document, numbers) = parts(bytes)?;
    // What a surface looks like does not change its shape.
    let is_of_looks = |name: &&String| LOOKS.iter().any(|word| name.split('_').nth(1) == Some(word));
    if let Some(extension) = document.extensions_required.iter().find(|name| !is_of_looks(name)) {
        return Err(SceneError::new(format!("the file requires {extension}: expected plain glTF 2.0")));
    }
    let places = document.places()?;
    let shown = document.nodes.iter().zip(&places).any(|(node, place)| node.mesh.is_some() && place.is_some());
    if !shown && !document.meshes.is_empty() {
        return Err(SceneError::new("the file's default scene shows no mesh: expected one in it"));
    }
    let mut all = Triangles { unit: Some(1.0), ..Triangles::default() };
    let mut primitives = 0;
    for (node, place) in document.nodes.iter().zip(&places).filter_map(|(node, place)| Some((node, (*place)?))) {
        if let Some(m) = node.mesh {
            let mesh = item(&document.meshes, m, "mesh")?;
            // The joints of a skin carry its mesh, whatever its node.
            let carry = node.skin.map(|skin| document.joints(skin, &places, numbers)).transpose()?;
            // Many nodes may have one mesh.
            primitives += mesh.primitives.len();
            if primitives > MAX_PRIMITIVES {
                return Err(SceneError::new(format!("expected at most {MAX_PRIMITIVES} primitives in all nodes")));
            }
            for (k, primitive) in mesh.primitives.iter().enumerate() {
                let material = primitive.material.and_then(|i| document.materials.get(i)?.name.as_ref());
                let names = [node.name.as_ref(), mesh.name.as_ref(), material].into_iter().flatten().cloned().collect();
                let added = document.append(primitive, numbers, place, carry.as_deref(), names, &mut all);
                added.map_err(|error| SceneError::new(format!("mesh {m}, primitive {k}: {}", error.message())))?;
            }
        }
    }
    Ok(all)
}

/// The two chunks of a file: what it says, and its numbers.
fn parts(bytes: &[u8]) -> Result<(Document, &[u8]), SceneError> {
    let all = bytes.len() as u64;
    let mut bytes = Bytes::new(bytes);
    if bytes.array("the word glTF")? != *b"glTF" || bytes.u32("a version")? != 2 {
        return Err(fault_at(0, "expected a binary glTF file of version 2"));
    }
    let length = bytes.u32("the length of the file")?;
    if u64::from(length) != all {
        return Err(fault_at(8, format!("expected a file of {length} bytes, found {all}")));
    }
    let mut chunk = |name: &[u8; 4]| {
        let length = bytes.u32("the length of a chunk")?;
        let at = bytes.at();
        if bytes.array("the name of a chunk")? != *name {
            return Err(fault_at(at, format!("expected the chunk {:?}", name.escape_ascii().to_string())));
        }
        Ok((bytes.at(), bytes.take(length.into(), 1, "the bytes of a chunk")?))
    };
    let (at, text) = chunk(b"JSON")?;
    let document = serde_json::from_slice(text);
    let document = document.map_err(|error| fault_at(at, format!("expected what a glTF file says: {error}")))?;
    Ok((document, chunk(b"BIN\0")?.1))
}

/// The item of a list.
fn item<'a, T>(list: &'a [T], i: usize, what: &str) -> Result<&'a T, SceneError> {
    list.get(i).ok_or_else(|| SceneError::new(format!("found {what} {i}: expected less than {}", list.len())))
}

impl Document {
    /// Place of each node of the scene that is shown; `None` for the others.
    fn places(&self) -> Result<Vec<Option<DMat4>>, SceneError> {
        let mut places = vec![None; self.nodes.len()];
        let roots: Vec<usize> = if self.scenes.is_empty() {
            // A file without scenes shows all that it has.
            let children: HashSet<usize> = self.nodes.iter().flat_map(|node| &node.children).copied().collect();
            (0..self.nodes.len()).filter(|i| !children.contains(i)).collect()
        } else {
            item(&self.scenes, self.scene.unwrap_or(0), "scene")?.nodes.clone()
        };
        let mut waiting: Vec<_> = roots.into_iter().map(|i| (i, DMat4::IDENTITY)).collect();
        while let Some((i, parent)) = waiting.pop() {
            let node = item(&self.nodes, i, "node")?;
            // A node has one parent: one that comes again is part of a ring.
            if places[i].is_some() {
                continue;
            }
            let own = DMat4::from_scale_rotation_translation(node.scale, node.rotation, node.translation);
            let place = parent * node.matrix.map_or(own, |matrix| DMat4::from_cols_array(&matrix));
            places[i] = Some(place);
            waiting.extend(node.children.iter().map(|&child| (child, place)));
        }
        Ok(places)
    }

    /// Matrices that carry points of a mesh with the joints of its skin, where the file has the joints.
    fn joints(&self, skin: usize, places: &[Option<DMat4>], numbers: &[u8]) -> Result<Vec<DMat4>, SceneError> {
        let skin = item(&self.skins, skin, "skin")?;
        let inverse = match skin.inverse_bind_matrices {
            Some(accessor) => self.numbers(accessor, numbers, "MAT4")?,
            None => DMat4::IDENTITY.to_cols_array().repeat(skin.joints.len()),
        };
        let inverse = inverse.as_chunks::<16>().0;
        if inverse.len() < skin.joints.len() {
            let words = format!("found {} inverse bind matrices: expected {}", inverse.len(), skin.joints.len());
            return Err(SceneError::new(words));
        }
        let joints = skin.joints.iter().zip(inverse).map(|(joint, inverse)| {
            let place = item(places, *joint, "node")?.ok_or_else(|| {
                SceneError::new(format!("joint {joint} of a skin is no node of the scene: expected one that is shown"))
            })?;
            Ok(place * DMat4::from_cols_array(inverse))
        });
        joints.collect()
    }

    /// The matrix that carries each point of a primitive on joints: theirs by the point's weights.
    fn carried(&self, primitive: &Primitive, numbers: &[u8], carry: &[DMat4]) -> Result<Vec<DMat4>, SceneError> {
        let mut sums: Vec<(DMat4, f64)> = Vec::new();
        for set in 0.. {
            let [joints, weights] =
                ["JOINTS", "WEIGHTS"].map(|name| primitive.attributes.get(&format!("{name}_{set}")));
            let (Some(joints), Some(weights)) = (joints, weights) else { break };
            let (joints, weights) = (self.numbers(*joints, numbers, "VEC4")?, self.numbers(*weights, numbers, "VEC4")?);
            if joints.len() != weights.len() || (set > 0 && joints.len() != 4 * sums.len()) {
                return Err(SceneError::new(WEIGHTED));
            }
            sums.resize(joints.len() / 4, (DMat4::ZERO, 0.0));
            for (k, (joint, weight)) in joints.iter().zip(weights).enumerate() {
                let sum = &mut sums[k / 4];
                *sum = (sum.0 + *item(carry, *joint as usize, "joint")? * weight, sum.1 + weight);
            }
        }
        // Weights of whole numbers have another sum than 1.
        Ok(sums.into_iter().map(|(sum, weight)| if weight > 0.0 { sum * (1.0 / weight) } else { sum }).collect())
    }

    /// Adds the triangles of a primitive, each point carried to its place, or by the joints of its skin; nothing if it
    /// has none.
    fn append(
        &self,
        primitive: &Primitive,
        numbers: &[u8],
        place: DMat4,
        carry: Option<&[DMat4]>,
        names: Vec<Arc<str>>,
        all: &mut Triangles,
    ) -> Result<(), SceneError> {
        let mode = primitive.mode.unwrap_or(TRIANGLES);
        if mode < TRIANGLES {
            // Points and lines enclose nothing.
            return Ok(());
        }
        if mode > FAN {
            return Err(SceneError::new(format!("found mode {mode}: expected at most {FAN}")));
        }
        let points = primitive.attributes.get("POSITION");
        let points = *points.ok_or_else(|| SceneError::new("expected the attribute POSITION"))?;
        if item(&self.accessors, primitive.indices.unwrap_or(points), "accessor")?.count < 3 {
            return Ok(());
        }
        let points = self.numbers(points, numbers, "VEC3")?;
        let points = points.as_chunks::<3>().0;
        let indices = match primitive.indices {
            Some(indices) => self.numbers(indices, numbers, "SCALAR")?.iter().map(|&x| x as u32).collect(),
            None => (0..points.len() as u32).collect::<Vec<_>>(),
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= points.len()) {
            let words = format!("found index {index}: expected less than {}, the points", points.len());
            return Err(SceneError::new(words));
        }
        let first = all.points.len() as u32;
        let carried = carry.map(|carry| self.carried(primitive, numbers, carry)).transpose()?;
        if carried.as_ref().is_some_and(|carried| carried.len() != points.len()) {
            return Err(SceneError::new(WEIGHTED));
        }
        let carried = carried.unwrap_or_default();
        let place_of = |k: usize| carried.get(k).copied().unwrap_or(place);
        let moved = points.iter().enumerate().map(|(k, x)| place_of(k).transform_point3(DVec3::from_array(*x)));
        all.points.extend(moved);
        let attribute = |name: &str, kind: &str| -> Result<Vec<f64>, SceneError> {
            match primitive.attributes.get(name) {
                Some(&i) => {
                    let found = self.numbers(i, numbers, kind)?;
                    let each = found.len() / points.len().max(1);
                    let fits = found.len() == each * points.len() && format!("VEC{each}") == kind;
                    fits.then_some(found).ok_or_else(|| SceneError::new(format!("expected one {name} a point")))
                }
                None => Ok(Vec::new()),
            }
        };
        let (normals, uvs) = (attribute("NORMAL", "VEC3")?, attribute("TEXCOORD_0", "VEC2")?);
        // Normals stay across the surface, however their node is stretched.
        let across = |k: usize| place_of(k).inverse().transpose();
        let normals = normals.as_chunks::<3>().0.iter().enumerate();
        let normals = normals.map(|(k, n)| across(k).transform_vector3(DVec3::from_array(*n)).normalize_or_zero());
        let normals: Vec<_> = normals.collect();
        // Here (0, 0) is the texture's upper left corner, in the other formats its lower left one.
        let uvs: Vec<_> = uvs.as_chunks::<2>().0.iter().map(|[u, v]| [*u as f32, (1.0 - v) as f32]).collect();
        let mirrored = place_of(0).determinant() < 0.0;
        let triangles: Vec<[u32; 3]> = match mode {
            STRIP => (0..).zip(indices.windows(3)).map(|(k, w)| [w[k % 2], w[1 - k % 2], w[2]]).collect(),
            FAN => indices[1..].windows(2).map(|pair| [indices[0], pair[0], pair[1]]).collect(),
            _ => indices.as_chunks::<3>().0.to_vec(),
        };
        let triangles = triangles.into_iter().map(|[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] });
        let triangles: Vec<_> = triangles.collect();
        let (normals, uvs) = (of_corners(&triangles, &normals), of_corners(&triangles, &uvs));
        all.append(names, triangles.iter().map(|corners| corners.map(|index| first + index)), normals, uvs);
        if all.corners.len().max(all.points.len() / 3) > MAX_TRIANGLES {
            return Err(SceneError::new(format!("expected at most {MAX_TRIANGLES} triangles in all nodes")));
        }
        Ok(())
    }

    /// The numbers of an accessor, one after the other.
    fn numbers(&self, i: usize, bytes: &[u8], kind: &str) -> Result<Vec<f64>, SceneError> {
        let accessor = item(&self.accessors, i, "accessor")?;
        let fault = |words: &str| SceneError::new(format!("accessor {i}: {words}"));
        if accessor.r#type != kind {
            return Err(fault(&format!("expected {kind}, found {:?}", accessor.r#type)));
        }
        let (Some(view), None) = (accessor.buffer_view, &accessor.sparse) else {
            return Err(fault("expected all of its numbers in a buffer view"));
        };
        let view = item(&self.buffer_views, view, "buffer view")?;
        if view.buffer != 0 {
            return Err(fault("expected its numbers in this file, found another buffer"));
        }
        type Number = fn(&[u8]) -> f64;
        let (number, size, each): (Number, usize, usize) = match (kind, accessor.component_type) {
            ("VEC3", F32) => (|x| f32::from_le_bytes(std::array::from_fn(|i| x[i])).into(), 4, 3),
            ("VEC4" | "MAT4", F32) => {
                (|x| f32::from_le_bytes(std::array::from_fn(|i| x[i])).into(), 4, if kind == "MAT4" { 16 } else { 4 })
            }
            ("VEC4", U8) => (|x| x[0].into(), 1, 4),
            ("VEC4", U16) => (|x| u16::from_le_bytes([x[0], x[1]]).into(), 2, 4),
            ("VEC2", F32) => (|x| f32::from_le_bytes(std::array::from_fn(|i| x[i])).into(), 4, 2),
            ("VEC2", U8) => (|x| f64::from(x[0]) / f64::from(u8::MAX), 1, 2),
            ("VEC2", U16) => (|x| f64::from(u16::from_le_bytes([x[0], x[1]])) / f64::from(u16::MAX), 2, 2),
            ("SCALAR", U8) => (|x| x[0].into(), 1, 1),
            ("SCALAR", U16) => (|x| u16::from_le_bytes([x[0], x[1]]).into(), 2, 1),
            ("SCALAR", U32) => (|x| u32::from_le_bytes(std::array::from_fn(|i| x[i])).into(), 4, 1),
            (_, other) => return Err(fault(&format!("found numbers of the kind {other}"))),
        };
        let item = size * each;
        let stride = view.byte_stride.unwrap_or(item as u64);
        let start = view.byte_offset.checked_add(accessor.byte_offset);
        let of = |k: u64| {
            let at = start?.checked_add(k.checked_mul(stride)?)?;
            let at = usize::try_from(at).ok()?;
            bytes.get(at..at.checked_add(item)?)
        };
        // Strides of 0 would make any number of items of a few bytes.
        if stride < item as u64 || (accessor.count > 0 && of(accessor.count - 1).is_none()) {
            return Err(fault(&format!("expected {} items of {item} bytes in the file", accessor.count)));
        }
        Ok((0..accessor.count).filter_map(of).flat_map(|bytes| bytes.chunks_exact(size).map(number)).collect())
    }
}
