// The surface that is nearest to a particle; air is moved out of bodies first, to its clearance. Where two surfaces are
// near to one another, the clearance from one may lead into the other: in the last rounds air is moved to the surface
// only.
import package::common::{
    params::params, cells::wrap, nearest::{Nearest, nearest}, wall::{Wall, gradient_beyond, path_beside},
};

const CLEARANCE: f32 = 0.4;   // least distance of air from a surface [d]
const ROUNDS: u32 = 4u;       // the first half to the clearance

struct Cleared {
    x: vec3f,        // m
    moved: bool,
    near: Nearest,   // the surface that is nearest then
}

// Moves air at `place`, which may be in another image of the box, out to its clearance. Of hair it only finds the
// nearest surface.
fn cleared(place: vec3f, is_air: bool) -> Cleared {
    let at = select(place, wrap(place), is_air);
    var x = at;
    var near: Nearest;
    var round = 0u;
    loop {
        near = nearest(x, false);
        let gap = near.distance - select(0.0, CLEARANCE * params.spacing, 2u * round < ROUNDS);
        if !is_air || gap >= 0.0 || round == ROUNDS { break; }
        x -= gap * near.normal;
        round++;
    }
    return Cleared(place + (x - at), round > 0u, near);
}

// The wall to a particle of this speed.
fn wall_of(near: Nearest, speed: f32) -> Wall {
    return Wall(
        near.normal, gradient_beyond(near.distance), vec3f(0.0), near.body, dot(near.velocity, near.normal),
        near.distance,
        path_beside(near.distance, speed, near.velocity),
    );
}
