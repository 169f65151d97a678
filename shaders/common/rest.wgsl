// When a strand is at rest: so slow for so long, and so little pushed, that leaving it alone moves its tip by less than 1e-4
// of its length. A push of 1e-4 of gravity bends it by that much at most; at a turning point a strand is slow for long only
// where it hardly swings; one that creeps to rest in air, at a rate of 1/s, has 7e-5 to go.

const STILL_ACCELERATION: f32 = 1e-3;   // m/s^2, of a push
const STILL_SPEED: f32 = 7e-5;        // lengths a second
const STILL_TIME: f32 = 0.07;           // s
const STILL_STEPS: u32 = 10u;
