// Fills a grid with the optical depth of the hair between a point and a light, along the light's direction.
//
// `deposit` adds every segment's shadow (its area across the light over a cell's) to the nearest eight cells,
// `accumulate` sums each column from the light on. All are whole numbers, so that the bits do not depend on the order.
import package::common::dispatch::{invocation, WORKGROUP};
import package::pictures::{common::{view, GRID, DEPTH_UNIT}, taper::taper};

@group(0) @binding(1) var<storage, read>       points: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> grid:   array<atomic<u32>>;  // lights x GRID^3
@group(0) @binding(3) var<storage, read>       radius: array<f32>;          // drawn radius of each hair [m]

@compute @workgroup_size(WORKGROUP)
fn deposit(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= view.hairs * view.samples || i % view.samples == view.samples - 1u {
        return;
    }
    let a = points[i];
    let b = points[i + 1u];
    let width = 2.0 * radius[i / view.samples] * taper(a.w);
    for (var light = 0u; light < 2u; light++) {
        let area = width * length(cross(b.xyz - a.xyz, view.lights[light].toward.xyz));
        let depth = area / view.lights[light].toward.w * DEPTH_UNIT;
        let cell = (view.lights[light].grid_from_world * vec4f(0.5 * (a.xyz + b.xyz), 1.0)).xyz - 0.5;
        let low = clamp(floor(cell), vec3f(0.0), vec3f(f32(GRID - 2u)));
        let part = clamp(cell - low, vec3f(0.0), vec3f(1.0));
        for (var corner = 0u; corner < 8u; corner++) {
            let far = vec3f(vec3u(corner, corner >> 1u, corner >> 2u) & vec3u(1u));
            let weight = mix(1.0 - part, part, far);
            let at = vec3u(low + far);
            let index = ((light * GRID + at.z) * GRID + at.y) * GRID + at.x;
            atomicAdd(&grid[index], u32(depth * weight.x * weight.y * weight.z + 0.5));
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn accumulate(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= 2u * GRID * GRID {
        return;
    }
    let light = id.x / (GRID * GRID);
    let column = id.x % (GRID * GRID);
    var sum = 0u;
    for (var z = 0u; z < GRID; z++) {
        let index = (light * GRID + z) * GRID * GRID + column;
        let own = atomicLoad(&grid[index]);
        // The depth is that at the middle of the cell.
        atomicStore(&grid[index], sum + own / 2u);
        sum += own;
    }
}
