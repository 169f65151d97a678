// A strand is points root to tip; segment k joins points k and k + 1, joint k precedes segment k (joint 0: the clamp).
//
//   ghost frame = joint 0 = [point 0]--segment 0--[point 1]-- ... --segment n-2--[point n-1] = tip joint = tip frame
//                 (half a segment long)         joint 1                            (half a segment long)
//
// The ghost frame stands at the root, where the clamp is; from there to the middle of segment 0 is half a segment. A
// clamped tip has one of its own.
//
// Words (docs/glossary.md has them all):
//   torn         a segment breaks its stretch-shear constraint by more than a stated part of its length
//   calm         where velocities led it was not torn, for three steps on end: BDF2 may integrate it
//   quiet        its equations already hold where it starts: the direct solver leaves it alone in this step
//   still        where it became still, within a little, in this step
//   asleep       still for so long that it is not integrated until something wakes it
//   rescued      the direct solver did not solve it: Gauss-Seidel does in this step, or it is put, going with its root as it is
//   put          placed instead of moved: it arrives without a velocity and remembers nothing
//   spoilt       it has a value that is not finite, or that no strand can have, when the step begins
//   reset        it was not finite: put into its rest shape
//   teleported   its root jumped farther than it is long: put there in the shape that it had
//   free move    where a point would go without its rod's forces

struct Strand {
    first_point: u32,
    first_segment: u32,
    points: u32,
    joints: u32,               // bits: ROOT_JOINT, TIP_JOINT, ROOT_HELD, TIP_HELD
    tip_frame: vec4f,
    tip_rest_rotation: vec4f,
    tip_compliance: vec3f,     // of the tip joint, as bend_compliance
    length: f32,               // m, at rest
    center: vec3f,             // m, of its roots' motion
    first_keyframe: u32,
    keyframes: u32,            // 0: the host says where its root goes
    still_way: f32,            // m, that a point of it may go while it is at rest
    still_time: f32,           // s, for which it must have been still before it sleeps
    still_acceleration: f32,   // m/s^2, of what pushes it, below which it stays at rest
}

const ROOT_JOINT: u32 = 1u;   // its frame is held
const TIP_JOINT: u32 = 2u;
const ROOT_HELD: u32 = 4u;    // its point is
const TIP_HELD: u32 = 8u;

struct Point {
    largest_move: f32,   // m, in a step
    weight: f32,         // over that of the mass that it moves with: below 1 where it carries air along
    friction: f32,       // Coulomb's coefficient, on other strands
    first: u32,          // first point of its strand
    end: u32,            // one past the last point of its strand
}

struct Segment {
    rest_rotation: vec4f,        // of the joint before it
    stretch_compliance: vec3f,   // shear d1, shear d2, stretch d3 [1/(N m)]
    rest_length: f32,            // m
    bend_compliance: vec3f,      // of the joint before it: bend d1, bend d2, twist d3 [1/(N m)]
    inverse_inertia: f32,        // 1/(kg m^2)
    radius: f32,                 // m, of a fibre
    fibres: f32,                 // that the strand stands for
    point: u32,                  // where it begins
}

// What a strand does within a step.
struct RodStrand {
    root_travel: vec3f,   // m, what the clamp moves by
    state: u32,           // FREE, SOLVED, TELEPORTED, ASLEEP, LEFT, FITTED
    root_frame: vec4f,    // ghost frame at the step's end
    root_turn: vec4f,     // from the ghost frame at the step's start
    tip_moment: vec3f,    // multiplier of the tip joint [N m]
    misfit: f32,          // max |C + alpha mu| of stretch-shear that the direct solver left
    scheme: u32,          // of `integration`, if it is integrated: EULER, BDF2
    torn: u32,            // 1: velocities lead to where it is torn
    misfit_before: f32,   // max |C| of stretch-shear where it is
    far: u32,             // 1: a free point would move farther than `largest`, capped or not; set if it is integrated
}

const FREE: u32 = 0u;         // still to be solved
const SOLVED: u32 = 1u;
const TELEPORTED: u32 = 2u;   // moved as a whole
const ASLEEP: u32 = 3u;       // stays where it is
const LEFT: u32 = 4u;         // rescued, and left to Gauss-Seidel
const FITTED: u32 = 5u;       // its segments fit, and it is solved once more if there are Newton steps left

// A point within a step. One that is put somewhere felt no force on its way: force, resistance and outside are 0, and its free move and
// its reply mean nothing.
struct RodPoint {
    velocity: vec3f,       // m/s, v_n with what acts from outside in this step
    inverse_mass: f32,     // 1/kg
    before: vec3f,         // m/s, v_(n-1) with the same; from `rods/place` on v_n, with what contact adds as well
    largest: f32,          // m, the largest move in a step
    carried: vec3f,        // m, the move of the step before
    scheme: u32,           // of `integration`: EULER, BDF2, PUT, STAY
    force: vec3f,          // N, from outside, on the point at rest
    resistance: f32,       // kg/s, from outside, to its velocity at the step's end
    outside: vec3f,        // m/s, all that acts from outside in this step
    weight: f32,           // over that of the mass that it moves with
    push: vec3f,           // m/s, what of it did not act while the strand came to rest
    stir: vec3f,           // m/s, the push with the velocity that a sleeper has got since
    free: vec3f,           // m, the move without the rod's forces
    reply: f32,            // m/N, W: the move that a force of the rod makes; 0 where the point is held
    travel: vec3f,         // m, the move
    strayed: vec3f,        // m, from where it was when the strand became still
}

// A segment within a step. The free turn of one that is put means nothing.
struct RodSegment {
    start: vec4f,              // frame at the step's start
    frame: vec4f,
    angular_velocity: vec3f,   // rad/s, at the step's start
    scheme: u32,               // of `integration`: EULER, BDF2, PUT, STAY
    before: vec3f,             // rad/s, of the step before
    carried: vec3f,            // rad, the turn of the step before
    free: vec3f,               // rad, the turn without the rod's forces
    turn: vec3f,               // rad
    chord: vec3f,              // m, from its first point to its second at the step's start
    force: vec3f,              // multiplier of stretch-shear, material frame [N m]
    moment: vec3f,             // multiplier of the joint before it, in the frame before [N m]
    strayed: vec3f,            // rad, turn since the strand became still
}

// What a point keeps from step to step beside its position and velocity.
struct PointHistory {
    travel: vec3f,      // m, the last step's move
    velocity: vec3f,    // m/s, of the step before, with all that acted from outside since
    remainder: vec3f,   // m, what rounding left off the position
    outside: vec3f,     // m/s, all that acted from outside in the last step awake, a mean of those on end in which its strand was
                        // still; nothing with the model PARTICLES
    own: vec3f,         // m/s, what its rod and gravity gave it in the last step awake; nothing with the model PARTICLES
    grip: vec3f,        // m/s, slip that friction of hair on hair holds it back from
    strayed: vec3f,     // m, from where it was when its strand became still
}

// What a segment keeps from step to step beside its frame and spin.
struct SegmentHistory {
    turn: vec3f,               // rad, the last step's
    angular_velocity: vec3f,   // rad/s, of the step before
    force: vec3f,              // multipliers, as above [N m]
    moment: vec3f,
    strayed: vec3f,            // rad, turn since its strand became still
}

// How a strand is.
struct Condition {
    bad: u32,        // BAD, SPOILT: not finite, to be reset; MENDED; 0: sound
    strained: u32,   // steps of over-strain on end
    calm: u32,       // steps on end that BDF2 could take
    still: u32,      // steps on end at rest; SLEEPS
    reach: f32,      // m, the farthest free move of the last step awake; below 0: it was put, and minus this is the most that it takes next
    touched: u32,    // bits PUSHED and MOVED of `body.wgsl`: what bodies did to it
}

struct Health {
    committed: Condition,   // after the last committed step
    found: Condition,       // in this step; `commit` makes it the other
}

const BAD: u32 = 1u;               // what its step found after the solve, and counted: the next step resets it
const SPOILT: u32 = 2u;            // what its step finds as it begins, and counts: the same step resets it
const MENDED: u32 = 3u;            // a bad strand that its step has reset
const CALM_STEPS: u32 = 3u;        // on end, before a strand takes BDF2
const SLEEPS: u32 = 0xffffffffu;
const STRAINED_STEPS: u32 = 50u;   // on end, before it is counted
const GROWTH: f32 = 2.0;           // times the farthest free move of the step before: what a strand bears where air drags hair, or once it was put
const EASED: f32 = 0.25;           // of what a strand could not follow: what the next step asks of it
const STRAINED: f32 = 0.05;        // |l/l0 - 1|
const TORN: f32 = 0.1;             // |C| of stretch-shear
const MISFIT: f32 = 1e-2;          // |C + alpha mu| of stretch-shear that the direct solver may leave in a calm strand
const LOST: f32 = 1.0;             // that from which it has lost a strand

// Whether the segments of a strand fit where it is.
fn is_whole(rod: RodStrand) -> bool {
    return rod.misfit_before < TORN;
}

// Whether the direct solver left more than it may. One that is carried far may be left as it was. What is not a number is no solution.
fn misses(rod: RodStrand) -> bool {
    return !(rod.misfit <= select(LOST, max(MISFIT, rod.misfit_before), rod.far != 0u));
}

// Whether the direct solver did not solve a strand, so that it is to be rescued.
fn unsolved(rod: RodStrand) -> bool {
    return (rod.state == FREE) & misses(rod);
}

// Steps of over-strain on end after a step that stretched by this much, when there were `before`.
fn strained_steps(before: u32, stretch: f32) -> u32 {
    return select(0u, min(before + 1u, STRAINED_STEPS + 1u), stretch > STRAINED);
}

// Where a root is, and its ghost frame.
struct Root {
    position: vec3f,   // m
    frame: vec4f,
}
