// Place of a hair point after a step: its position before, the remainder that rounding had left off it, and its move
// [m].

fn placed(position: vec3f, remainder: vec3f, displacement: vec3f) -> vec3f {
    return position + (displacement + remainder);
}
