// Optical depth of the hair between a point and a light, from the grid that opacity.wgsl fills.
import package::pictures::common::{view, GRID, DEPTH_UNIT};

// optical depth, lights x GRID^3, as opacity.wgsl leaves it
@group(0) @binding(1) var<storage, read> grid: array<u32>;

fn cell_depth(light: u32, at: vec3u) -> f32 {
    return f32(grid[((light * GRID + at.z) * GRID + at.y) * GRID + at.x]) / DEPTH_UNIT;
}

fn optical_depth(light: u32, x: vec3f) -> f32 {
    // The depth is read a cell nearer to the light: otherwise a hair would lie in its own shadow.
    let cell = (view.lights[light].grid_from_world * vec4f(x, 1.0)).xyz - vec3f(0.5, 0.5, 1.5);
    if cell.z <= 0.0 || any(cell.xy < vec2f(-0.5)) || any(cell.xy > vec2f(f32(GRID) - 0.5)) {
        return 0.0;
    }
    let low = clamp(floor(cell), vec3f(0.0), vec3f(f32(GRID - 2u)));
    let part = clamp(cell - low, vec3f(0.0), vec3f(1.0));
    let a = vec3u(low);
    var planes: array<f32, 2>;
    for (var z = 0u; z < 2u; z++) {
        let near = mix(cell_depth(light, a + vec3u(0u, 0u, z)), cell_depth(light, a + vec3u(1u, 0u, z)), part.x);
        let far = mix(cell_depth(light, a + vec3u(0u, 1u, z)), cell_depth(light, a + vec3u(1u, 1u, z)), part.x);
        planes[z] = mix(near, far, part.y);
    }
    return mix(planes[0], planes[1], part.z);
}
