// The surface that is nearest to a place in the box of air.
//
// Air is periodic: where a body crosses a face of the box, its cut is a wall to the air at the opposite face. That air
// sees the foot of its place on the face: inside the body the wall is as far as the face, and beside it farther.
import package::common::{params::params, body::{Placed, surface, surface_move, carried_on}};

struct Nearest {
    normal: vec3f,     // unit vector out of the body
    distance: f32,     // of the place from the surface, negative inside [m]
    velocity: vec3f,   // of the surface there [m/s]
    body: u32,         // index of the body
}

@group(0) @binding(8) var<storage, read> placed: array<Placed>;

// The nearest surface to a place after the step, or to a place before it.
fn nearest(x: vec3f, before: bool) -> Nearest {
    var found = Nearest(vec3f(), 3.4e38, vec3f(), 0u);
    // From the place itself, then from its feet. The call stands here once, as drivers inline it.
    for (var k = 0u; k <= 3u; k++) {
        var foot = x;
        var way_back = vec3f(0.0);
        if k > 0u {
            let axis = k - 1u;
            let is_low = x[axis] < 0.5 * params.box_size[axis];
            let depth = select(params.box_size[axis] - x[axis], x[axis], is_low);
            if depth >= params.kernel_radius { continue; }
            foot[axis] = select(0.0, params.box_size[axis], is_low);
            way_back[axis] = select(-depth, depth, is_low);
        }
        var other = here(foot, before);
        if k > 0u {
            let way = max(other.distance, 0.0) * other.normal + way_back;
            other.distance = length(way);
            if other.distance == 0.0 { continue; }
            other.normal = way / other.distance;
        }
        if other.distance < found.distance { found = other; }
    }
    return found;
}

fn here(x: vec3f, before: bool) -> Nearest {
    var found = Nearest(vec3f(), 3.4e38, vec3f(), 0u);
    var place = x;
    for (var k = 0u; k < arrayLength(&placed); k++) {
        let at = select(x, carried_on(placed[k], x), before);
        let seen = surface(placed[k], at);
        if seen.distance < found.distance {
            found = Nearest(seen.normal, seen.distance, vec3f(), k);
            place = at;
        }
    }
    found.velocity = surface_move(placed[found.body], place) / params.step;
    return found;
}
