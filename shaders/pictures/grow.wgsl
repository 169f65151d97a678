// Makes the points of every drawn hair of its follower's few: a smooth curve (Catmull-Rom) with waves of its own.
//
// A follower is a hair's course between the strands, and is worked out beside the shaders. Hairs of a strand draw
// together toward its tip and sway a little, each in another way; hairs of a groom file stay as they are. There is one
// invocation per point.
import package::common::dispatch::{invocation, WORKGROUP};
import package::pictures::common::{view, chance};

struct Hair {
    guide:  u32,  // index of the strand whose room it grows in
    seed:   u32,  // seed of the hair's random numbers
    first:  u32,  // index of its follower's root in `keyframes`
    last:   u32,  // index of its follower's tip
    styled: f32,  // share of the waves, of the drawing together and of the shortening that it gets
}

@group(0) @binding(1) var<storage, read>       hair:    array<Hair>;
// first point of each strand in `keyframes` and `frame`, and the end
@group(0) @binding(2) var<storage, read>       offsets: array<u32>;
@group(0) @binding(3) var<storage, read>       keyframes:  array<vec4f>;   // points of strands, then of followers [m]
// orientation of the segment that starts there; at a tip, of the clamp
@group(0) @binding(4) var<storage, read>       frame:   array<vec4f>;
@group(0) @binding(5) var<storage, read_write> points:  array<vec4f>;      // xyz [m]; w: 0 at the root, 1 at the tip

// The numbers below are chosen by eye.

// share of the distance between a lock's hairs that is left at its tip, in the loosest lock
const LOOSE: f32 = 1.0;
// share of the distance between a lock's hairs that is left at its tip, in the tightest lock
const TIGHT: f32 = 0.5;
const WAVE: f32 = 0.006;     // amplitude of a hair's waves [lengths of the hair]
const STRAY: f32 = 5.0;      // factor of the amplitude for the hairs that stray
const STRAYS: f32 = 0.04;    // share of the hairs that stray
const SHORTER: f32 = 0.35;   // largest part of its guide's length by which a hair is shorter

// Length over which a hair turns from its clamp's frame to its strand's [segments]: it leaves the surface as it was
// rooted.
const CLAMPED: f32 = 1.5;

fn rotate(q: vec4f, v: vec3f) -> vec3f {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

// Point `k` of a course; beyond an end, the mirror image of the point before it.
fn at(first: u32, last: u32, k: i32) -> vec3f {
    if k < 0 {
        return 2.0 * keyframes[first].xyz - keyframes[first + 1u].xyz;
    }
    if first + u32(k) > last {
        return 2.0 * keyframes[last].xyz - keyframes[last - 1u].xyz;
    }
    return keyframes[first + u32(k)].xyz;
}

fn catmull_rom(a: vec3f, b: vec3f, c: vec3f, d: vec3f, u: f32) -> vec3f {
    return b + 0.5 * u * (c - a + u * (2.0 * a - 5.0 * b + 4.0 * c - d + u * (3.0 * (b - c) + d - a)));
}

fn between(a: vec4f, b: vec4f, u: f32) -> vec4f {
    return normalize(mix(a, select(b, -b, dot(a, b) < 0.0), u));
}

// Orientation of a strand at `x` segments from the root, between those of the nearest segments. Toward the root it
// becomes that of the clamp, so that hairs stay where they are rooted whatever their strand does.
fn orientation(first: u32, last: u32, x: f32) -> vec4f {
    let segment = clamp(x - 0.5, 0.0, f32(last - first - 1u));
    let k = first + u32(segment);
    let free = between(frame[k], frame[min(k + 1u, last - 1u)], fract(segment));
    return between(frame[last], free, smoothstep(0.0, CLAMPED, x));
}

// The point of a course `t` of its length from the root.
fn along(first: u32, last: u32, t: f32) -> vec3f {
    let x = t * f32(last - first);
    let k = min(i32(x), i32(last - first) - 1);
    return catmull_rom(at(first, last, k - 1), at(first, last, k), at(first, last, k + 1), at(first, last, k + 2),
        x - f32(k));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if i >= view.hairs * view.samples {
        return;
    }
    let self_ = hair[i / view.samples];
    let t = f32(i % view.samples) / f32(view.samples - 1u);

    let short = chance(self_.seed, 0u);
    let s = t * (1.0 - self_.styled * SHORTER * short * short);
    let gather = mix(LOOSE, TIGHT, self_.styled * smoothstep(0.0, 1.0, s) * chance(self_.guide, 1u));
    let first = offsets[self_.guide];
    let last = offsets[self_.guide + 1u] - 1u;
    let reach = distance(keyframes[first].xyz, keyframes[first + 1u].xyz) * f32(last - first);

    let stray = select(1.0, STRAY, chance(self_.seed, 2u) < STRAYS);
    let turns = 6.2831853
        * vec3f(0.7 + chance(self_.seed, 3u), 1.6 + 1.4 * chance(self_.seed, 4u), chance(self_.seed, 5u));
    let phase = 6.2831853 * vec2f(chance(self_.seed, 6u), chance(self_.seed, 7u));
    let wave = self_.styled * WAVE * stray * reach * smoothstep(0.0, 0.6, s)
        * vec3f(sin(turns.x * s + phase.x) + 0.5 * sin(turns.y * s + phase.y),
            cos(turns.x * s + turns.z) + 0.5 * sin(turns.y * s + phase.x), 0.0);

    let x = mix(along(first, last, s), along(self_.first, self_.last, s), gather);
    points[i] = vec4f(x + rotate(orientation(first, last, s * f32(last - first)), wave), t);
}
