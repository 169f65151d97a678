// What a body pushed pulls the rest of its strand along: the rods were solved before the push.
//
// Turn by turn, from root to tip and from tip to root: segments that are longer or shorter than their rest length by more than GIVE are brought
// back to it, one after the other, by moves of their two points against one another by their masses, so that momentum is kept
// (Müller et al. 2007, Position based dynamics), and leave the bodies that they are in between their points. After each turn all points
// stay out of bodies.
//
// Where that does not end, the strand is laid out: from the root on each point goes as far as its segment reaches, in the direction in which it
// should be, and the segment turns out of bodies about the point before (Müller, Kim & Chentanez 2012, Fast simulation of inextensible
// hair and fur). All segments have their lengths then, whatever the bodies do: a strand that cannot go around a body slips through it.
//
// A strand that is embedded is laid out only where it is far off its length: its clamp presses it on the body in every step, and to be laid out would
// throw its tip in every step.
//
// A strand that begins the step deep in a body moves so little that no point of it is faster than what comes out, and is laid out without bodies.
//
// In a scene with meshes the turns are shared out among several dispatches; the last of them lays out.
//
// It runs on in a frozen step, in which nothing that it writes is committed or read: whether a step is frozen stands in a ninth buffer, and
// WebGPU's default allows eight.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, matter::inverse_mass, owner::strands,
    outside::{Ends, outside, clear, placed, AT_MOST, RECOVERY}, rod::{Strand, Segment},
    body::{PUSHED, INSIDE, PULLED, PART, EMBEDDED, PARTS, MESHES, loops_of_point, loops_of_segment, loops_to_turn, nearest, surface},
};

@group(0) @binding(3) var<storage, read>       position:  array<vec4f>;
@group(0) @binding(6) var<storage, read_write> predicted: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> touched:   array<u32>;
@group(0) @binding(8) var<storage, read>       segments:  array<Segment>;

const TURNS: u32 = 100u;
const LOOPS: u32 = 60000u;   // of an invocation in all, at most: Mesa's software adapter ends them after 65535, without a word
const GIVE: f32 = 1e-3;   // lengths of the segment: weight and wind stretch hair by less, and are the rods'
const DONE: f32 = 1e-5;   // lengths of the segment: what is more than GIVE by less is done
const SLACK: f32 = 2e-2;    // lengths of the segment: an embedded strand that is more than GIVE by less after all turns is not laid out
const CLOSE: f32 = 1e-3;  // lengths of the segment, by which it may be pushed in the last turn
const UNHURRIED: f32 = 0.6;    // of RECOVERY: speed of a strand that comes out, before its lengths are mended
const TRIES: u32 = 6u;    // times that a laid out segment turns out of each body

// What segment j from point p to the next is too long [m]; negative where it is too short.
fn excess(p: u32, j: u32) -> f32 {
    let l = segments[j].rest_length;
    let off = distance(predicted[p].xyz, predicted[p + 1u].xyz) - l;
    return sign(off) * max(abs(off) - GIVE * l, 0.0);
}

fn fits(strand: Strand, most: f32) -> bool {
    for (var k = 0u; k < strand.points - 1u; k++) {
        let j = strand.first_segment + k;
        // What is not finite is not pulled.
        if abs(excess(strand.first_point + k, j)) > most * segments[j].rest_length { return false; }
    }
    return true;
}

fn pull(p: u32, j: u32) {
    let gap = predicted[p + 1u].xyz - predicted[p].xyz;
    let w = vec2f(inverse_mass[p], inverse_mass[p + 1u]);
    let far = length(gap) * (w.x + w.y);
    if !(far > 0.0) { return; }
    let shift = excess(p, j) / far * gap;
    predicted[p] += vec4f(w.x * shift, 0.0);
    predicted[p + 1u] -= vec4f(w.y * shift, 0.0);
}

// Gets the segment from point p out of bodies; returns by how much it was inside [m].
fn leave(p: u32) -> f32 {
    let before = Ends(position[p].xyz, position[p + 1u].xyz);
    let cleared = clear(p, before, Ends(predicted[p].xyz, predicted[p + 1u].xyz));
    predicted[p] = vec4f(cleared.ends.first, predicted[p].w);
    predicted[p + 1u] = vec4f(cleared.ends.second, predicted[p + 1u].w);
    return cleared.push;
}

// The end of a segment of length l from a point on, in the direction of a goal.
fn reach(start: vec3f, goal: vec3f, l: f32) -> vec3f {
    let gap = goal - start;
    let far = length(gap);
    return start + select(vec3f(0.0, -l, 0.0), l / far * gap, far > 0.0);
}

// Bodies let embedded points be: of a segment that begins at one, all but the end.
fn lead(p: u32, j: u32, bodies: u32, embedded: bool) {
    let start = predicted[p].xyz;
    let l = segments[j].rest_length;
    var x = reach(start, predicted[p + 1u].xyz, l);
    for (var k = 0u; k < TRIES * bodies; k++) {
        let body = placed[k % bodies];
        let t = select(nearest(body, start, x), 1.0, embedded);
        let near = surface(body, mix(start, x, t));
        let parts = 1.0 / max(t, 1.0 / AT_MOST);
        x = reach(start, x - parts * min(near.distance, 0.0) * near.normal, l);
    }
    // What is left of the depth, the length bears.
    for (var k = 0u; k < bodies; k++) {
        let near = surface(placed[k], x);
        x -= min(near.distance, 0.0) * near.normal;
    }
    predicted[p + 1u] = vec4f(x, predicted[p + 1u].w);
}

// The strand goes its way through the step, beside that of a held root, only in part, so that no point of it is faster than what comes out
// of a body.
fn slow(strand: Strand) {
    let root = strand.first_point;
    let travel = select(vec3f(0.0), predicted[root].xyz - position[root].xyz, inverse_mass[root] == 0.0);
    var far = 0.0;
    for (var k = 0u; k < strand.points; k++) {
        far = max(far, distance(predicted[root + k].xyz, position[root + k].xyz + travel));
    }
    let part = min(UNHURRIED * RECOVERY * params.step / far, 1.0);
    for (var k = 0u; k < strand.points; k++) {
        let p = root + k;
        if inverse_mass[p] > 0.0 {
            predicted[p] = vec4f(mix(position[p].xyz + travel, predicted[p].xyz, part), predicted[p].w);
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    if (touched[s] & PUSHED) == 0u { return; }
    let strand = strands[s];
    let n = strand.points - 1u;
    let bodies = arrayLength(&placed);
    let inside = (touched[s] & INSIDE) != 0u;
    let embedded = touched[s] >> EMBEDDED;
    let each = 3u + loops_of_point(bodies) + loops_of_segment(bodies);
    let laying = strand.points * (4u + (TRIES + 1u) * loops_to_turn(bodies));
    let parts = select(1u, PARTS, MESHES);
    let turns = min(TURNS / parts, (LOOPS - min(laying, LOOPS)) / (strand.points * each));
    let part = (touched[s] >> PART) % (1u << (EMBEDDED - PART));
    var done = (touched[s] & PULLED) != 0u;
    for (var turn = 0u; turn < turns && !done; turn++) {
        done = true;
        for (var i = 0u; i < n; i++) {
            let k = select(i, n - 1u - i, turn % 2u == 1u);
            pull(strand.first_point + k, strand.first_segment + k);
            if k < embedded { continue; }
            let push = leave(strand.first_point + k);
            if push > CLOSE * segments[strand.first_segment + k].rest_length { done = false; }
        }
        for (var k = embedded; k < strand.points; k++) {
            let p = strand.first_point + k;
            if inverse_mass[p] > 0.0 {
                predicted[p] = vec4f(outside(position[p].xyz, predicted[p].xyz).place, predicted[p].w);
            }
        }
        done = done && fits(strand, DONE);
    }
    touched[s] = (touched[s] | select(0u, PULLED, done)) + (1u << PART);
    if part + 1u < parts { return; }
    if inside { slow(strand); }
    // A strand whose tip is held has no end that could give. One that comes out of a body keeps its lengths before it keeps out.
    if inverse_mass[strand.first_point + n] == 0.0 || fits(strand, select(DONE, SLACK, embedded > 0u && !inside)) { return; }
    for (var k = 0u; k < n; k++) {
        let p = strand.first_point + k;
        let felt = select(bodies, 0u, inside || k + 1u < embedded);
        if inverse_mass[p + 1u] > 0.0 { lead(p, strand.first_segment + k, felt, k < embedded); }
    }
}
