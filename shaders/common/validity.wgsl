// Valid values of a strand as a step begins, and the largest speed.
import package::common::{rod::{Strand, Root, ROOT_HELD}, status::{finite, finite3}};

const FAR: f32 = 1e3;     // lengths of the strand: no point of it is farther from its root
const WORLD: f32 = 1e9;   // m from the origin: no root is farther
const FAST: f32 = 1e6;    // m/s: largest speed of a particle

// Whether a vector is finite and at most `longest` long; false too where its square overflows f32.
fn within(v: vec3f, longest: f32) -> bool {
    return finite(dot(v, v)) && dot(v, v) <= longest * longest;
}

// Whether a particle's place is finite, and its velocity at most FAST.
fn can_be(place: vec3f, velocity: vec3f) -> bool {
    return finite3(place) && within(velocity, FAST);
}

// Where the root of a strand is: at its clamp, or where its first point drifted to if nothing holds it.
fn root_of(strand: Strand, clamp: Root, first: vec3f) -> vec3f {
    let drifts = (strand.joints & ROOT_HELD) == 0u && within(first, WORLD);
    return select(clamp.position, first, drifts);
}

fn in_reach(strand: Strand, root: vec3f, place: vec3f) -> bool {
    return within(place - root, FAR * strand.length);
}
