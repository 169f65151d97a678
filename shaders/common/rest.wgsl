// When a strand is at rest: so slow, and so little pushed, that leaving it alone moves its tip by less than 1e-4 of its
// length. A push of 1e-4 of gravity bends it by that much at most.

const STILL_ACCELERATION: f32 = 1e-3;   // m/s^2
const STILL_SPEED: f32 = 1.5e-4;        // lengths a second
