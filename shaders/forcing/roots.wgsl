// Moves of the clamps in this step. A clamp with keyframes goes to its pose at the step's end; any other goes a part of
// the way to the host's target, and arrives in the last substep. A strand whose root jumps farther than the
// strand is long is teleported, unless its tip is held too. A strand whose clamp does not move may sleep. Free roots
// are left alone. A tip that is held goes along: by the keyframes, or where its pin is.
//
// Runs after `forcing/reset`. If that pass is left out and a strand is invalid, the step freezes and is replayed with
// it.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP},
    quaternion::{product, conjugate, rotate, rotation, rotation_vector},
    motion::{moves, pose_after},
    integration::{EULER, BDF2},
    rod::{Strand, RodStrand, Root, Pin, StrandHistory, FREE, TELEPORTED, ASLEEP, ROOT_HELD, TIP_HELD},
    status::{status, frozen, freeze, UNRECOVERED_STRAND},
};

@group(0) @binding(2) var<storage, read>       strands:        array<Strand>;
@group(0) @binding(3) var<storage, read>       root_targets:   array<Root>;
@group(0) @binding(4) var<storage, read>       strand_history: array<StrandHistory>;
@group(0) @binding(5) var<storage, read_write> rod_strands:    array<RodStrand>;
@group(0) @binding(6) var<storage, read>       pins:           array<Pin>;
@group(0) @binding(7) var<storage, read>       position:       array<vec4f>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if (s >= params.strands) | frozen() { return; }
    let condition = strand_history[s].condition;
    if condition.failed != 0u && status.inspected == 0u {
        freeze(UNRECOVERED_STRAND);
        return;
    }
    let held = strand_history[s].root;
    let strand = strands[s];
    var goal = root_targets[s];
    let tip = strand.first_point + strand.points - 1u;
    var tip_goal = pins[tip].place;
    var tip_frame = strand.tip_frame;
    var left = params.substeps - status.step % params.substeps;   // substeps of this time step
    if moves(strand.keyframes) {
        let pose = pose_after(status.step + 1u, strand.first_keyframe, strand.keyframes);
        goal.position = strand.center + pose.translation + rotate(pose.rotation, goal.position - strand.center);
        goal.frame = normalize(product(pose.rotation, goal.frame));
        tip_goal = strand.center + pose.translation + rotate(pose.rotation, tip_goal - strand.center);
        tip_frame = normalize(product(pose.rotation, tip_frame));
        left = 1u;
    }
    if (strand.joints & ROOT_HELD) == 0u { goal = held; }
    let way = goal.position - held.position;
    let turn = rotation_vector(product(goal.frame, conjugate(held.frame)));
    let jumps = (strand.joints & TIP_HELD) == 0u && length(way) > strand.length;
    let part = select(1.0 / f32(left), 1.0, jumps);
    let tip_way = select(vec3f(0.0), tip_goal - position[tip].xyz, (strand.joints & TIP_HELD) != 0u);
    let resting = all(way == vec3f(0.0)) && all(held.frame == goal.frame) && all(tip_way == vec3f(0.0));
    let root_turn = select(rotation(part * turn), vec4f(0.0, 0.0, 0.0, 1.0), resting);
    rod_strands[s].strand = strand;
    rod_strands[s].root_displacement = part * way;
    rod_strands[s].root_turn = root_turn;
    // A clamp that arrives takes the goal's frame to the bit: if it were off by rounding, it would never rest.
    rod_strands[s].root_frame = select(normalize(product(root_turn, held.frame)), goal.frame, resting || part == 1.0);
    rod_strands[s].state = select(select(FREE, ASLEEP, resting && params.sleep != 0u), TELEPORTED, jumps);
    // BDF2 needs the previous step of this strand; without it the strand takes Euler.
    rod_strands[s].scheme = select(EULER, BDF2, params.bdf2 != 0u && condition.bdf2_ready != 0u);
    rod_strands[s].condition = condition;
    rod_strands[s].pin_force = strand_history[s].pin_force;
    rod_strands[s].tip_displacement = part * tip_way;
    rod_strands[s].tip_frame = tip_frame;
    rod_strands[s].meets = 0u;
    rod_strands[s].woken = 0u;
    rod_strands[s].comes_out = 0u;
}
