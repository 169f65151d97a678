// Common part of the shaders of the picture.

struct Light {
    grid_from_world: mat4x4f,  // matrix from world [m] to cells of the light's grid; the light travels along +z
    toward:          vec4f,    // xyz: unit vector to the light; w: area of a cell across the light [m^2]
    colour:          vec4f,    // rgb: radiance, linear
}

struct View {
    clip_from_world: mat4x4f,           // matrix from world [m] to clip space
    eye:             vec4f,             // xyz: place of the camera [m]; w: size of a drawn pixel at distance 1 [m/m]
    // xyz: unit vector to the picture's right; w: distance at which the depth cue starts [m]
    right:           vec4f,
    up:              vec4f,             // xyz: unit vector to the picture's top; w: 1 / range of the depth cue [1/m]
    size:            vec2f,             // width and height of the picture [px]
    hairs:           u32,               // number of drawn hairs
    samples:         u32,               // number of points of a drawn hair
    lights:          array<Light, 2>,   // key light and sky
}

@group(0) @binding(0) var<uniform> view: View;

// Drawn pixels along each axis of a pixel of the picture: with 4 samples each, those of a single thin hair follow it
// evenly.
const FINE: u32 = 2u;

// Cells of a light's grid along each axis, chosen by eye; a grid then takes 3.5 MB.
const GRID: u32 = 96u;
// Optical depth 1 in the grid's whole numbers, whose sums do not depend on their order; 2^16 leaves room for a depth of
// 65 536.
const DEPTH_UNIT: f32 = 65536.0;

// PCG (Jarzynski & Olano 2020, Hash Functions for GPU Rendering).
fn hash(x: u32) -> u32 {
    let state = x * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// A random number in [0, 1): the draw of this number from a seed.
fn chance(seed: u32, draw: u32) -> f32 {
    return f32(hash(seed ^ hash(draw)) >> 8u) / 16777216.0;
}
