// Where bodies let hair go in a step, with Coulomb friction (Macklin et al. 2014, Unified particle physics, eq. 24).
//
//   The way of a place of the hair in this step, seen from the body, ends at the plane that touches the body where the way
//   enters it: however far the place goes, it does not come out behind a thin body. The part of the way along the plane is
//   shortened by up to mu times the depth that the place would have had behind the plane.
//
//            start          A place that starts inside is pushed out by no more than RECOVERY allows in a step: it comes
//               \           out slowly, not at the speed of its whole depth in one step.
//   ------.------*--- plane
//       /   body  \\ depth
//
// Points are such places, and so is the place of a segment that is nearest to a body: that one moves by moves of both ends.
import package::common::{
    params::params, matter::inverse_mass, body::{Placed, ROUNDS, surface, carried, entry, nearest},
};

@group(0) @binding(5) var<storage, read> placed: array<Placed>;

const RECOVERY: f32 = 0.2;    // speed at which a place that starts inside comes out [m/s]: slow enough not to throw the strand
const SAME_SIDE: f32 = 0.5;   // cosine of the angle between normals on one side of a body
const AT_MOST: f32 = 2.0;     // depths of a place that an end of its segment is moved by, at most

// A place of the hair after a body has had its say.
struct Kept {
    place: vec3f,     // where it may go [m]
    inside: f32,      // depth below the surface at which it begins the step [m]; 0 or less if it begins outside
}

// Place that was at `before` when the step began and would go to `goal` [m], kept out of a body.
fn keep(body: Placed, before: vec3f, goal: vec3f) -> Kept {
    let start = carried(body, before);
    let part = entry(body, start, goal - start);
    if part > 1.0 { return Kept(goal, 0.0); }
    let contact = start + part * (goal - start);
    let touch = surface(body, contact);
    let depth = min(-touch.distance, RECOVERY * params.step) - dot(touch.normal, goal - contact);
    return Kept(stopped(body, start, goal, touch.normal, depth), -touch.distance);
}

// Place that is lifted by a depth along the normal of a plane, if that is more than nothing, and held back by friction along the plane.
fn stopped(body: Placed, start: vec3f, goal: vec3f, normal: vec3f, depth: f32) -> vec3f {
    if depth <= 0.0 { return goal; }
    var x = goal + depth * normal;
    let way = x - start;
    let slide = way - dot(way, normal) * normal;
    let far = length(slide);
    if far > 0.0 { x -= min(body.friction * depth / far, 1.0) * slide; }
    return x;
}

// The same for a place of a segment that is nearest to the body where it goes. A segment slides over the body, and other places of it come
// to be the nearest: the plane touches the body where the place ends, unless that is on another side than where its way enters.
fn keep_nearest(body: Placed, before: vec3f, goal: vec3f) -> Kept {
    let start = carried(body, before);
    let part = entry(body, start, goal - start);
    if part > 1.0 { return Kept(goal, 0.0); }
    let contact = start + part * (goal - start);
    let touch = surface(body, contact);
    let near = surface(body, goal);
    let recovered = min(-touch.distance, RECOVERY * params.step);
    let beside = dot(near.normal, touch.normal) > SAME_SIDE;
    let depth = select(recovered - dot(touch.normal, goal - contact), recovered + touch.distance - near.distance, beside);
    return Kept(stopped(body, start, goal, select(touch.normal, near.normal, beside), depth), -touch.distance);
}

// Point that was at `before` and would go to `goal` [m], kept out of all bodies: in order, and twice, for points between two bodies.
fn outside(before: vec3f, goal: vec3f) -> Kept {
    var x = Kept(goal, 0.0);
    let bodies = arrayLength(&placed);
    for (var k = 0u; k < ROUNDS * bodies; k++) {
        let kept = keep(placed[k % bodies], before, x.place);
        x = Kept(kept.place, max(x.inside, kept.inside));
    }
    return x;
}

// Whether a place that began the step so far below a surface takes more than this step to come out.
fn is_deep(inside: f32) -> bool {
    return inside > RECOVERY * params.step;
}

// The two ends of a segment.
struct Ends {
    first: vec3f,     // m
    second: vec3f,    // m
}

// A segment after bodies have had their say.
struct Cleared {
    ends: Ends,
    push: f32,        // longest way by which one of its places was pushed [m]
    inside: f32,      // depth below a surface at which one of these places begins the step [m]; 0 if they begin outside
}

// The segment from point p to the next, with its ends before the step and where they would go, kept out of all bodies by its place that
// is nearest to each. A push of that place moves both ends by their masses and by how near they are to it. Where the second end is held
// inside a body the segment is left as it is.
fn clear(p: u32, before: Ends, goal: Ends) -> Cleared {
    var x = Cleared(goal, 0.0, 0.0);
    let give = vec2f(inverse_mass[p], inverse_mass[p + 1u]);
    for (var k = 0u; k < arrayLength(&placed); k++) {
        let body = placed[k];
        let t = nearest(body, x.ends.first, x.ends.second);
        let share = vec2f(1.0 - t, t) * give;
        let response = dot(share, vec2f(1.0 - t, t));
        if response == 0.0 { continue; }
        if give.y == 0.0 && surface(body, x.ends.second).distance < 0.0 { continue; }
        let goes = mix(x.ends.first, x.ends.second, t);
        let kept = keep_nearest(body, mix(before.first, before.second, t), goes);
        let push = kept.place - goes;
        let parts = min(share / response, vec2f(AT_MOST));
        x.ends.first += parts.x * push;
        x.ends.second += parts.y * push;
        x.push = max(x.push, length(push));
        x.inside = max(x.inside, kept.inside);
    }
    return x;
}
