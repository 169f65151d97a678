// Per strand: BDF2 or Euler, if it is integrated. A calm strand goes where its velocities lead without being torn: it takes BDF2.
// From where a strand is torn BDF2 blows up: it takes Euler until CALM_STEPS steps on end were calm.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::{product, rotation, tangent},
    integration::{EULER, BDF2}, led::{led_move, led_turn},
    rod::{Strand, Segment, RodStrand, RodPoint, RodSegment, Health, CALM_STEPS, TORN}, share::{owner_of, worker_of, stretch_of, largest_shared},
    status::frozen,
};

@group(0) @binding(2) var<storage, read>       strands:      array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:     array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:  array<RodStrand>;
@group(0) @binding(5) var<storage, read>       rod_points:   array<RodPoint>;
@group(0) @binding(6) var<storage, read>       rod_segments: array<RodSegment>;
@group(0) @binding(7) var<storage, read>       health:       array<Health>;

// |C| of stretch-shear of a segment.
fn misfit(chord: vec3f, rest_length: f32, frame: vec4f) -> f32 {
    return length(chord / rest_length - tangent(frame));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let at = invocation(id, groups);
    let s = owner_of(at);
    if (s >= params.strands) | frozen() { return; }
    let strand = strands[s];
    let rod = rod_strands[s];
    let own = stretch_of(strand.points, worker_of(at));
    var led = 0.0;
    var now = 0.0;
    var before = vec3f(0.0);
    for (var k = own.before; k < own.end; k++) {
        let after = led_move(rod_points[strand.first_point + k], rod, k);
        if k > own.before {
            let j = strand.first_segment + k - 1u;
            let segment = rod_segments[j];
            let rest_length = segments[j].rest_length;
            let turned = product(rotation(led_turn(segment)), segment.start);
            led = max(led, misfit(segment.chord + (after - before), rest_length, turned));
            now = max(now, misfit(segment.chord, rest_length, segment.start));
        }
        before = after;
    }
    led = largest_shared(led);
    now = largest_shared(now);
    if worker_of(at) > 0u { return; }
    let torn = !(led < TORN);
    let calm = !torn && health[s].committed.calm + 1u >= CALM_STEPS;
    rod_strands[s].torn = u32(torn);
    rod_strands[s].misfit_before = now;
    rod_strands[s].scheme = select(EULER, BDF2, calm && params.bdf2 != 0u);
}
