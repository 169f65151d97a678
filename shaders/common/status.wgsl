// Causes that freeze a step, and counters that are saved with the state. In a frozen step no pass of `commit` writes
// state; the host reads the causes after each batch of steps, removes those that it can, and replays from the same
// state.

const NEIGHBOUR_OVERFLOW: u32 = 1u;   // the list is too short: grow and replay
const NON_FINITE_AIR: u32 = 2u;       // replay with the passes that recover strands; if they ran, the run ends
const TOO_MANY_FAILED_STRANDS: u32 = 4u; // the same
const UNRECOVERED_STRAND: u32 = 8u;      // a strand is bad or lost: replay with the passes that recover it

const STRAND_RESET: u32 = 0u;          // a non-finite strand goes back to its rest pose
const OVER_STRAINED: u32 = 1u;         // a strand with a segment a twentieth too long or short for 50 steps in a row
// a step, once more than a twentieth of the hair points have been outside the box for 0.1 s on end
const HAIR_OUTSIDE: u32 = 2u;
const CONFINEMENT_LIMITED: u32 = 3u;   // a step in which a band would have grown by more than half of its speed
const EULER_STEP: u32 = 4u;            // a strand took implicit Euler where BDF2 is asked for
const SLEEPING_STEP: u32 = 5u;         // a strand slept
const TELEPORT: u32 = 6u;              // a strand moved as a whole with its root
const UNSOLVED_STEP: u32 = 7u;         // a strand had not settled after the last Newton step
const EXCHANGE_LIMITED: u32 = 8u;      // a hair point whose exchange with the air was limited
// a step in which air beside bodies was not as dense as it should be, or went too far
const AIR_BESIDE: u32 = 9u;
const COUNTERS: u32 = 10u;

const BY_RESET: u32 = 0u;    // passes that find strands which are not finite: forcing/reset as the step begins,
const BY_UPDATE: u32 = 1u;   // rods/update after the solve,
const BY_HOLD: u32 = 2u;     // commit/hold at the end
const NO_POINT: u32 = 0xffffffffu;

// Software adapters read the status as a uniform, which has no arrays of words: these stand at the end.
struct Status {
    causes: atomic<u32>,              // bits above
    step: u32,                        // committed engine steps
    // 1 once a step that froze has ended: those behind it in the same batch find nothing out
    ended: u32,
    // elements that the longest page of the list needs in this step, the low half of 64 bits
    neighbours: atomic<u32>,
    neighbour_carries: atomic<u32>,   // the high half
    failed_strands: atomic<u32>,      // non-finite in this step
    // smallest hair point that is not finite in this step, times 4, and the pass that found it
    first_bad: atomic<u32>,
    reset_first: u32,                 // `first_bad` of the last committed step that reset a strand
    reset_step: u32,                  // number of that step, from 1; 0 if none
    first_bad_air: atomic<u32>,       // smallest id
    stretch: atomic<u32>,             // max |l/l0 - 1| in this step, the bits of a positive f32
    max_stretch: u32,                 // that of the committed steps
    wind: vec3f,                      // m/s, mean wind at the end of this step
    inspected: u32,                   // 1: this step began with `forcing/reset`
    wind_before: vec3f,               // m/s, mean wind at the start of this step
    fastest_wind: f32,                // m/s, largest speed of the mean wind in its table
    wind_path: vec3f,                 // m, that the wind has blown in committed steps, wrapped into the box
    hair_outside: atomic<u32>,        // hair points outside the box of air, this step
    frame_place: vec3f,               // m, way of the frame (`common/frame.wgsl`) from the run's start to this step's end
    outside_steps: u32,               // consecutive steps with more than a twentieth of the hair points outside
    frame_velocity: vec3f,            // m/s, of the frame in this step
    // largest displacement of air beside bodies in this step [spacings], the bits of a positive f32
    path_beside: atomic<u32>,
    frame_change: vec3f,              // m/s, of `frame_velocity` from the step before
    off_steps: u32,                   // consecutive steps in which the density of the air beside bodies was off
    frame_step: u32,                  // step, from 1, that `frame_place`, `frame_velocity` and `frame_change` are for
    counted: array<u32, COUNTERS>,    // by cause, committed steps
    counting: array<atomic<u32>, COUNTERS>, // by cause, this step
}

@group(0) @binding(1) var<storage, read_write> status: Status;

fn frozen() -> bool {
    return atomicLoad(&status.causes) != 0u;
}

fn freeze(cause: u32) {
    atomicOr(&status.causes, cause);
}

fn count(cause: u32) {
    atomicAdd(&status.counting[cause], 1u);
}

fn count_many(cause: u32, times: u32) {
    if times > 0u { atomicAdd(&status.counting[cause], times); }
}

// A strand that is to be reset, since its point p is not finite, as a pass has found.
fn count_bad_strand(p: u32, pass_of: u32) {
    count(STRAND_RESET);
    atomicAdd(&status.failed_strands, 1u);
    atomicMin(&status.first_bad, 4u * p + pass_of);
}

// Once a step, however many say so.
fn count_step(cause: u32) {
    if atomicLoad(&status.counting[cause]) == 0u { atomicMax(&status.counting[cause], 1u); }
}

// IEEE 754 exponent all ones. `x != x` may be optimised away.
fn finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn finite3(v: vec3f) -> bool {
    return finite(v.x) && finite(v.y) && finite(v.z);
}

fn finite4(v: vec4f) -> bool {
    return finite3(v.xyz) && finite(v.w);
}
