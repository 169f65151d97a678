// Where bodies let a hair point go in a step, with Coulomb friction (Macklin et al. 2014, Unified particle physics, eq. 24).
//
//   The way of a point in this step, seen from the body, ends at the plane that touches the body where the way enters it:
//   however far the point goes, it does not come out behind a thin body. The part of the way along the plane is shortened
//   by up to mu times the depth that the point would have had behind the plane.
//
//            start          A point that starts inside is pushed out by no more than RECOVERY allows in a step: it comes
//               \           out slowly, not at the speed of its whole depth in one step.
//   ------.------*--- plane
//       /   body  \\ depth
//
// It goes through all bodies in order, twice, for points between two bodies.
import package::common::{params::params, body::{Placed, ROUNDS, surface, carried, entry}};

@group(0) @binding(5) var<storage, read> placed: array<Placed>;

const RECOVERY: f32 = 0.2;   // speed at which a point that starts inside comes out [m/s]: slow enough not to throw the strand

// Place of a point that was at `before` when the step began and would go to `goal` [m].
fn outside(before: vec3f, goal: vec3f) -> vec3f {
    var x = goal;
    let bodies = arrayLength(&placed);
    for (var k = 0u; k < ROUNDS * bodies; k++) {
        let body = placed[k % bodies];
        let start = carried(body, before);
        let part = entry(body, start, x - start);
        if part > 1.0 { continue; }
        let contact = start + part * (x - start);
        let touch = surface(body, contact);
        let depth = min(-touch.distance, RECOVERY * params.step) - dot(touch.normal, x - contact);
        if depth <= 0.0 { continue; }
        x += depth * touch.normal;
        let way = x - start;
        let slide = way - dot(way, touch.normal) * touch.normal;
        let far = length(slide);
        if far > 0.0 { x -= min(body.friction * depth / far, 1.0) * slide; }
    }
    return x;
}
