// A strand is points root to tip; segment k joins points k and k + 1, joint k precedes segment k (joint 0: the clamp).
//
//   ghost frame = joint 0 = [point 0]--segment 0--[point 1]-- ... --segment n-2--[point n-1] = tip joint = tip frame
//                 (half a segment long)         joint 1                            (half a segment long)
//
// The ghost frame stands at the root, where the clamp is; from there to the middle of segment 0 is half a segment. A
// clamped tip has one of its own.
//
// Words:
//   placed       set to a place instead of integrated: it has no velocity and no history there
//   resting      all points and frames close to where the strand came to rest, in this step
//   sleeping     resting for so long that it is not integrated until a push, a clamp or a body wakes it
//   invalid      it has a value that is not finite, or that no strand can have, when the step begins
//   reset        it was not finite: placed in its rest shape
//   teleported   its root jumped farther than it is long: placed there in the shape that it had
//   free move    where a point would go without its rod's forces

struct Strand {
    first_point: u32,
    first_segment: u32,
    points: u32,
    joints: u32,               // bits: ROOT_JOINT, TIP_JOINT, ROOT_HELD, TIP_HELD
    tip_frame: vec4f,          // of a clamped tip, before any motion
    tip_rest_rotation: vec4f,
    tip_compliance: vec3f,     // of the tip joint, as bend_compliance
    length: f32,               // m, at rest
    center: vec3f,             // m, of its roots' motion
    first_keyframe: u32,
    keyframes: u32,            // 0: the host says where its root goes
    still_way: f32,            // m, that a point of it may go while it is at rest
    still_time: f32,           // s, for which it must have been still before it sleeps
    still_acceleration: f32,   // m/s^2, of a push, below which it stays at rest
}

// The limits of the direct solver.
const WHOLE: f32 = 0.01;   // strain |u|/l: a start beyond it is made whole, and no solve ends beyond it
const TURN: f32 = 1.0;     // rad, of a frame at first, and of a joint in a Newton step

// A vector of at most this length.
fn clamped(v: vec3f, longest: f32) -> vec3f {
    return longest / max(length(v), longest) * v;
}

const ROOT_JOINT: u32 = 1u;   // its frame is held
const TIP_JOINT: u32 = 2u;
const ROOT_HELD: u32 = 4u;    // its point is
const TIP_HELD: u32 = 8u;

struct Point {
    weight: f32,     // over that of the mass that it moves with: below 1 where it carries air along
    friction: f32,   // Coulomb's coefficient, on other strands
    first: u32,      // first point of its strand
    end: u32,        // one past the last point of its strand
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

// How a strand is from step to step.
struct Condition {
    failed: u32,       // FAILED, INVALID: to be reset; 0: valid
    strained: u32,     // consecutive steps of over-strain
    bdf2_ready: u32,   // 1: the step before was integrated, or slept through
    resting: u32,      // consecutive steps at rest; SLEEPS
}

const FAILED: u32 = 1u;    // found by its step after the solve, and counted: the next step resets it
const INVALID: u32 = 2u;   // found by a step as it begins, and counted: the same step resets it
const SLEEPS: u32 = 0xffffffffu;
const NO_PIN: u32 = 0xffffffffu;
const STRAINED_STEPS: u32 = 50u;   // consecutive, before over-strain is counted
const STRAINED: f32 = 0.05;        // |l/l0 - 1|

// Consecutive steps of over-strain after a step with this stretch, when there were `before`.
fn strained_steps(before: u32, stretch: f32) -> u32 {
    return select(0u, min(before + 1u, STRAINED_STEPS + 1u), stretch > STRAINED);
}

// A point that is pinned, or a tip that is held.
struct Pin {
    place: vec3f,    // m, where it is held; before any motion, of a body or of a held tip's roots
    held: u32,       // 0: it is not; AT_PLACE; ON_BODY + i: it goes with body i
    goal: vec3f,     // m, where it is held at the step's end
}

const AT_PLACE: u32 = 1u;   // it goes there within a step of the host
const ON_BODY: u32 = 2u;

// Switches (`shaders/src/lib.rs`).
override PINS: bool = true;    // whether a point is pinned, or a tip held
override LOOSE: bool = true;   // whether a strand's root is not held

// A strand within a step.
struct RodStrand {
    strand: Strand,             // for `rods/solve`, which has no binding left for it
    root_displacement: vec3f,   // m, the clamp's displacement
    state: u32,                 // FREE, SOLVED, TELEPORTED, ASLEEP
    root_frame: vec4f,          // ghost frame at the step's end
    root_turn: vec4f,           // from the ghost frame at the step's start
    scheme: u32,                // of `integration`, if it is integrated: EULER, BDF2
    condition: Condition,       // as the step found it so far; `commit/frames` commits it
    pin_force: vec3f,           // N, that holds it at its last pin
    embedded: u32,              // points, from the root on, that have no contact (`rods/contacts`)
    meets: u32,                 // 1: it may meet a body in this step
    woken: u32,                 // 1: a body that moves reaches it
    comes_out: u32,             // 1: it starts the step deeper in a body than it comes out in a step
    newton: u32,                // Newton steps so far
    steep: u32,                 // 1: the next takes all of a segment's force for its tension
    settled: f32,               // rad, and strain, in a Newton step that is the last
    pin: u32,                   // its last point that is pinned or a held tip, from the root on; NO_PIN
    tip_displacement: vec3f,    // m, of a held tip
    tip_frame: vec4f,           // of a clamped tip, at the step's end
}

const FREE: u32 = 0u;         // integrated, and not solved yet
const SOLVED: u32 = 1u;       // solved, or reset
const TELEPORTED: u32 = 2u;   // moved as a whole
const ASLEEP: u32 = 3u;       // stays where it is

// A point within a step. In a strand that is reset, teleported or held force, resistance and external_dv are 0.
struct RodPoint {
    start: vec4f,                  // xyz: position at the step's start [m], w: volume [m^3]
    remainder: vec3f,              // m, left off the position by rounding, and the shift that makes the strand whole
    inverse_mass: f32,             // 1/kg
    velocity: vec3f,               // m/s, v_n and the change by the density constraint
    weight: f32,                   // part that gravity acts on: own mass over that with the air it carries
    // m/s, v_(n-1) and the change by the density constraint; from `rods/update` on `velocity`, corrected beside contacts
    before: vec3f,
    scheme: u32,                   // of `integration`: EULER, BDF2, KINEMATIC, HOLD
    previous_move: vec3f,          // m, the move of the step before
    resistance: f32,               // kg/s, external, to its velocity at the step's end
    force: vec3f,                  // N, external, at zero velocity
    effective_inverse_mass: f32,   // m/N, W: the move that a force of the rod makes; 0 where the point is held
    external_dv: vec3f,            // m/s, change by the density constraint and external forces in this step
    // m/s, external_dv less its value while the strand came to rest: the change that may wake it
    impulse_change: vec3f,
    free: vec3f,                   // m, the move without the rod's forces; of a held point, where it is held
    displacement: vec3f,           // m, the move
    rest_drift: vec3f,             // m, from where it was when the strand became still
    pin: vec3f,                    // m, to where it is pinned in this step
    pinned: u32,                   // as `Pin.held`, if the strand has a pin nearer to the tip, else 0
    pin_force: vec3f,              // N, of the pin in the step before, by which its spring need not give
}

// A segment within a step.
struct RodSegment {
    start: vec4f,        // frame at the step's start
    frame: vec4f,        // turn * start
    turn: vec4f,         // rotation in this step; a frame that `rods/gauss_seidel` has turned does not have it
    free: vec4f,         // rotation without the rod's forces
    strain: vec3f,       // m, world: u = chord - l d3
    scheme: u32,         // of `integration`: EULER, BDF2, KINEMATIC, HOLD
    rest_drift: vec3f,   // rad, turn since the strand became still
    stretch: vec3f,      // multiplier of stretch-shear in `rods/gauss_seidel`
    bend: vec3f,         // multiplier of the joint before it there
}

// History of a point, beside its position and velocity.
struct PointHistory {
    displacement: vec3f,   // m, the last step's move
    velocity: vec3f,       // m/s, of the step before, with the changes by external forces since
    remainder: vec3f,      // m, left off the position by rounding
    // m/s, change by external forces in the last step awake, a mean over the consecutive steps in which its strand was
    // still; 0 with the model PARTICLES
    external_dv: vec3f,
    // m/s, change by its rod and gravity in the last step awake; 0 with the model PARTICLES
    own: vec3f,
    // tangential friction spring (Cundall & Strack), as the slip velocity [m/s] that it opposes; `fluid/friction`
    // updates it
    tangential_spring: vec3f,
    rest_drift: vec3f,   // m, from where it was when its strand became still
    pin_force: vec3f,    // N, that holds it at a pin
}

// History of a segment, beside its frame.
struct SegmentHistory {
    turn: vec3f,               // rad, the last step's
    angular_velocity: vec3f,   // rad/s, world axes
    before: vec3f,             // rad/s, of the step before
    rest_drift: vec3f,         // rad, turn since its strand became still
}

// Where a root is, and its ghost frame.
struct Root {
    position: vec3f,   // m
    frame: vec4f,
}

// History of a strand.
struct StrandHistory {
    root: Root,             // at its clamp
    pin_force: vec3f,       // N, that holds it at its last pin
    condition: Condition,
}
