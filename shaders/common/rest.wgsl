// When a strand is at rest: so slow for so long, and so little pushed, that leaving it alone moves its tip by less than 1e-4
// of its length. How slow and how little is each strand's own (`Strand`): a soft one in much air creeps for long, and nothing
// but its stiffness resists a push where there is no gravity. At a turning point a strand is slow for long only where it
// hardly swings.

const STILL_SPIN: f32 = 2e-3;   // rad/s, of a frame
const STILL_TIME: f32 = 0.07;   // s
const STILL_STEPS: u32 = 10u;
