// Where a hair point ends up: its position, what rounding had left off it, and its move.

fn placed(position: vec3f, remainder: vec3f, travel: vec3f) -> vec3f {
    return position + (travel + remainder);
}
