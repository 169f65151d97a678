// When a strand is at rest: when for a while (`Strand.still_time`) no point of it went farther than a little
// (`Strand.still_way`), no frame turned by more than a little, and nothing pushed it by much
// (`Strand.still_acceleration`). Each strand has its own measures (`Strands::rest`). They are of ways, not of speeds:
// rounding lets points and frames tremble, by as much however short the step is, and so the faster the shorter it is.

const STILL_TURN: f32 = 1e-3;     // turn of a frame at rest [rad]
// number of steps for which a strand must have been still at least, however long they are
const RESTING_STEPS: u32 = 10u;
