// When a strand is at rest: so slow for so long, and so little pushed, that leaving it alone moves its tip by less than 1e-4
// of its length. Each strand has its own limits of speed and push (`Strand`): a soft strand in much air creeps for
// long, and nothing but its stiffness resists a push where there is no gravity. A strand that swings is slow at its
// turning points too, but stays slow for as long as STILL_TIME only where it hardly swings.

const STILL_SPIN: f32 = 2e-3;   // angular speed of a frame below which it is at rest [rad/s]
const STILL_TIME: f32 = 0.07;   // time for which a strand must have been still before it sleeps [s]
const STILL_STEPS: u32 = 10u;   // number of steps for which it must have been still at least, however long they are
