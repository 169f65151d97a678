// Moves air out of bodies, and finds the wall at a place.
import package::common::{params::params, cells::wrap, nearest::nearest, wall::{Wall, ROUNDS, gap_in, gradient_beyond, way_beside}};

struct Beside {
    x: vec3f,     // m
    wall: Wall,
}

// The wall at a place in the box, for a particle of this speed; air is moved out to its clearance by the nearest way first.
fn beside(place: vec3f, is_air: bool, speed: f32) -> Beside {
    // The neighbour search may have seen another image of it.
    let at = select(place, wrap(place), is_air);
    var x = at;
    var near = nearest(x, false);
    for (var round = 0u; round < ROUNDS && is_air; round++) {
        let gap = gap_in(round, near.distance);
        if gap >= 0.0 { break; }
        x -= gap * near.normal;
        near = nearest(x, false);
    }
    let wall = Wall(
        near.normal, gradient_beyond(near.distance), vec3f(0.0), near.body, dot(near.velocity, near.normal), near.distance,
        way_beside(near.distance, speed, near.velocity),
    );
    return Beside(place + (x - at), wall);
}
