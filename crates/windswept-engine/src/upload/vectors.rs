//! Vectors and rotations as the shaders have them.

use glam::{DQuat, DVec3};

pub(crate) fn vec3(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

pub(crate) fn vec4(v: DVec3, w: f64) -> [f32; 4] {
    v.extend(w).as_vec4().to_array()
}

pub(crate) fn quat(q: DQuat) -> [f32; 4] {
    q.as_quat().to_array()
}
