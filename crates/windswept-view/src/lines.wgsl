// Strands as lines, air as points or arrows, and solids, straight from the engine's positions.

struct View {
    clip_from_world: mat4x4f,
    eye:      vec4f,  // xyz: the camera [m]
    origin:   vec4f,  // xyz: what the engine's positions are less [m]
    size:     vec2f,  // of the picture [px]
    arrow:    f32,    // time that an arrow follows the air's velocity [s]; 0: points
    coloured: f32,    // 1: hair has the colours of its values
    ranges:   vec4f,  // values of the first and the last colour: of hair, of air
    ramp:     array<vec4f, 5>, // colours from low to high, linear rgb
}

@group(0) @binding(0) var<uniform>       view:     View;
@group(0) @binding(1) var<storage, read> position: array<vec4f>;    // of hair points, less the origin [m]
@group(0) @binding(2) var<storage, read> segments: array<vec2u>;    // first point, strand
@group(0) @binding(3) var<storage, read> values:   array<f32>;      // per hair point, where hair is coloured
@group(0) @binding(4) var<storage, read> air:      array<Particle>;

struct Particle {
    position: vec4f, // xyz [m], w: the value that it is coloured by
    velocity: vec4f, // xyz [m/s]
}

const LIGHT = vec3f(-0.36, 0.81, 0.46);

fn colour_of(value: f32, range: vec2f) -> vec3f {
    let at = 4.0 * clamp((value - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0);
    let stop = min(u32(at), 3u);
    return mix(view.ramp[stop].rgb, view.ramp[stop + 1u].rgb, at - f32(stop));
}

struct Vertex {
    @builtin(position) at:     vec4f,
    @location(0)       colour: vec3f,
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4f {
    return vec4f(in.colour, 1.0);
}

// A line from point to point, lit as a thin cylinder is (Kajiya & Kay 1989).
@vertex
fn hair_vertex(@builtin(vertex_index) index: u32) -> Vertex {
    let segment = segments[index / 2u];
    let point = segment.x + (index & 1u);
    let x = position[point].xyz + view.origin.xyz;
    let t = normalize(position[segment.x + 1u].xyz - position[segment.x].xyz);
    let e = normalize(view.eye.xyz - x);
    let tl = dot(t, LIGHT);
    let te = dot(t, e);
    let across = sqrt(max(1.0 - tl * tl, 0.0));
    let shine = pow(max(across * sqrt(max(1.0 - te * te, 0.0)) - tl * te, 0.0), 24.0);
    let grey = fract(sin(f32(segment.y) * 12.9898) * 43758.5453);
    let brown = mix(vec3f(0.03, 0.012, 0.006), vec3f(0.11, 0.05, 0.02), grey) * (0.35 + 0.9 * across) + 0.1 * shine;
    let value = colour_of(values[min(point, arrayLength(&values) - 1u)], view.ranges.xy) * (0.55 + 0.45 * across);
    return Vertex(view.clip_from_world * vec4f(x, 1.0), select(brown, value, view.coloured > 0.0));
}

// A triangle: small and upright for a point, else from both sides of the particle to the tip of its arrow.
@vertex
fn air_vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Vertex {
    let particle = air[index];
    let colour = colour_of(particle.position.w, view.ranges.zw);
    let x = view.clip_from_world * vec4f(particle.position.xyz, 1.0);
    if view.arrow == 0.0 {
        let offset = vec2f(1.5 * (f32(corner) - 1.0), select(-1.0, 2.0, corner == 1u));
        return Vertex(vec4f(x.xy + 2.0 * offset / view.size * x.w, x.zw), colour);
    }
    let tip = view.clip_from_world * vec4f(particle.position.xyz + view.arrow * particle.velocity.xyz, 1.0);
    let way = (tip.xy / max(tip.w, 1e-9) - x.xy / max(x.w, 1e-9)) * view.size;
    let side = vec2f(-way.y, way.x) / max(length(way), 1e-6);
    let offset = select(-1.2, 1.2, corner == 1u) * side;
    let base = vec4f(x.xy + 2.0 * offset / view.size * x.w, x.zw);
    return Vertex(select(base, tip, corner == 2u), colour);
}

@vertex
fn solid_vertex(@location(0) x: vec3f, @location(1) normal: vec3f) -> Vertex {
    let n = normalize(normal);
    let facing = max(dot(n, normalize(view.eye.xyz - x)), 0.0);
    let lit = 0.30 + 0.45 * max(dot(n, LIGHT), 0.0) + 0.25 * facing;
    return Vertex(view.clip_from_world * vec4f(x, 1.0), vec3f(0.36, 0.27, 0.23) * lit);
}
