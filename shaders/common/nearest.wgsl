// The body that is nearest to a place.
import package::common::body::{Placed, Surface, surface};

struct Nearest {
    body: u32,          // index of the body
    surface: Surface,   // its surface, seen from the place
}

@group(0) @binding(8) var<storage, read> placed: array<Placed>;

fn nearest(x: vec3f) -> Nearest {
    var found = Nearest(0u, surface(placed[0], x));
    for (var k = 1u; k < arrayLength(&placed); k++) {
        let other = surface(placed[k], x);
        if other.distance < found.surface.distance { found = Nearest(k, other); }
    }
    return found;
}
