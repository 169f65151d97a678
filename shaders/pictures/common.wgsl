// What every shader of the picture shares.

struct Light {
    grid_from_world: mat4x4f,  // world [m] -> cells of the light's grid, the light travels along +z
    toward:          vec4f,    // xyz: unit, to the light; w: area of a cell across the light [m^2]
    colour:          vec4f,    // rgb: linear radiance
}

struct View {
    clip_from_world: mat4x4f,
    eye:             vec4f,    // xyz [m]; w: size of a pixel at distance 1 [m/m]
    right:           vec4f,    // xyz unit; w: distance at which the depth cue starts [m]
    up:              vec4f,    // xyz unit; w: 1 / range of the depth cue [1/m]
    size:            vec2f,    // of the picture [px]
    hairs:           u32,
    samples:         u32,      // points of a drawn hair
    lights:          array<Light, 2>,  // key, sky
}

@group(0) @binding(0) var<uniform> view: View;

// Cells of a light's grid along each axis.
const GRID: u32 = 96u;
// One unit of optical depth in the grid's whole numbers; sums of whole numbers do not depend on their order.
const DEPTH_UNIT: f32 = 65536.0;

// PCG (Jarzynski & Olano 2020, Hash Functions for GPU Rendering).
fn hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// In [0, 1).
fn chance(seed: u32, draw: u32) -> f32 {
    return f32(hash(seed ^ hash(draw)) >> 8u) / 16777216.0;
}

// Invocations of a workgroup.
const WORKGROUP: u32 = 64u;

// More workgroups than a dimension holds fold into rows.
fn invocation(group: vec3u, groups: vec3u, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * WORKGROUP + local;
}
