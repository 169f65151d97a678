// Contact of strands with bodies, solved with the rods. A place of a strand is one of its points, or the place of a
// segment that is nearest to a body. It has a contact with each body, a one-sided spring with Coulomb friction:
//
//   normal     f = lambda - k (phi + D), where that is above 0
//       phi: distance from the surface after the step, k = max(100, h^2 OMEGA^2)/W
//   friction   F = F_old - k slip, no longer than mu f_lag
//       slip: the way along the surface in the step, F_old: F of the step before
//
// W is the move of the place by a unit of force, as of a point. D is the depth that the place may keep in this step: a
// place that starts inside comes out at RECOVERY. The multiplier lambda is f of the step before, or of the last Newton
// step that settled with more than ALLOW left open: at rest the spring carries nothing, and the gap is 0 (augmented
// Lagrangian; Hestenes 1969).
import package::common::{
    params::params, rod::RodPoint, body::{Placed, Surface, near, swing},
    symmetric::{Symmetric, dyad, minus, plus}, articulated::Spring,
};

struct Contact {
    normal: vec3f,      // out of the body; of points also where they do not touch
    gap: f32,           // m, phi + D
    friction: vec3f,    // N, F
    force: f32,         // N, f
    held: vec3f,        // N, F_old, turned with the body
    lag: f32,           // N, f_lag: f of the step before, or of the last Newton step that settled
    multiplier: f32,    // N, lambda
    before: f32,        // m, distance from the surface as the step begins
    place: f32,         // fraction of the segment
    straight: f32,      // fraction by the normals at the ends alone; `place` moves with it in later Newton steps
    curve: f32,         // m, by which the place shifts along the segment as that turns by 1 rad
    tangential_stiffness: f32,   // N/m, of the friction
    linear: f32,        // N, f by the linear model of the last Newton step
    state: u32,         // bits: LIVE, SLIDES, PLANE
}

// History of a contact.
struct ContactHistory {
    friction: vec3f,    // N
    force: f32,         // N; 0 where it did not touch
}

const LIVE: u32 = 1u;
const SLIDES: u32 = 2u;
const PLANE: u32 = 4u;     // the body is a plane to it in this step, at `before` across `normal`

const STIFFNESS: f32 = 100.0;   // of a contact, at least, over that of the place's inertia: 1/W
const OMEGA: f32 = 3.2e3;       // 1/s, frequency of a place on the spring, at least
const RECOVERY: f32 = 0.15;     // m/s, of hair that comes out of a body
const ALLOW: f32 = 2e-5;        // m, phi + D that may be left open in a step
// lengths of the segment, from the surface, at which a contact ends whatever the linear model says
const STAYS: f32 = 0.1;
const NOTICED: f32 = 1e-5;      // m: a push by less does not make the solve go on
// fraction of the segment at each end within which the end point's contact is used instead of the segment's
const MIDDLE: f32 = 0.03;
const REFINED: u32 = 3u;        // times that the nearest place of a segment is refined
const CLOSE: f32 = 0.002;       // fraction of the segment to which the search finds its nearest place
const STANDS: f32 = 0.02;       // change of `straight` beyond which a later Newton step searches again
const BENDS: f32 = 30.0;        // lengths of the segment: the longest curve
const LAGS: f32 = 0.02;         // part by which f may differ from f_lag
// rad: a strand that touches and turns by more takes all force for tension in its next Newton step
const UNEASY: f32 = 0.1;
// part of the tangential stiffness that resists sliding on, from the Newton step SLOW on
const SLIDING: f32 = 0.1;
const SLOW: u32 = 3u;

fn stiffness_of(effective_inverse_mass: f32) -> f32 {
    return max(STIFFNESS, OMEGA * OMEGA * params.step * params.step) / effective_inverse_mass;
}

// A place in the step: its start, the remainder that rounding left off the start, its move [m], and W [m/N].
struct Place {
    start: vec3f,
    remainder: vec3f,
    displacement: vec3f,
    effective_inverse_mass: f32,
}

// Move of a place relative to a body that moves [m]: `base` is where the body would have carried the place, relative to
// the body's center after the step, `way` is the move from there.
struct RelativeMove {
    base: vec3f,
    way: vec3f,
}

fn seen_from(body: Placed, place: Place) -> RelativeMove {
    let gap = place.start - body.center_before;
    let swung = swing(body, gap);
    return RelativeMove(gap + swung,
        (place.remainder + place.displacement - (body.center - body.center_before)) - swung);
}

fn place_of_point(point: RodPoint) -> Place {
    return Place(point.start.xyz, point.remainder, point.displacement, point.effective_inverse_mass);
}

// The place between two at a part of the way.
fn between(a: Place, b: Place, part: f32) -> Place {
    return Place(
        mix(a.start, b.start, part), mix(a.remainder, b.remainder, part), mix(a.displacement, b.displacement, part),
        effective_inverse_mass_between(a.effective_inverse_mass, b.effective_inverse_mass, part),
    );
}

fn effective_inverse_mass_between(first: f32, second: f32, part: f32) -> f32 {
    return (1.0 - part) * (1.0 - part) * first + part * part * second;
}

// Place of a segment that is nearest to a body.
struct Nearest {
    part: f32,                     // of the segment; 0 or 1 where an end is nearest
    straight: f32,                 // the same by the ends alone
    curve: f32,                    // m/rad, by which it shifts as the segment turns
    effective_inverse_mass: f32,   // m/N, W of the place
    seen: RelativeMove,
    surface: Surface,  // seen from there
}

// The place of a segment that is nearest to a body with these normals at its ends: as the step starts by regula falsi
// on the slope of the distance along it, from the place that it had; later anew, where the slopes at the ends say that
// it moved.
fn nearest(last: Contact, body: Placed, a: Place, b: Place, first: vec3f, second: vec3f, starts: bool) -> Nearest {
    let chord = (b.start - a.start) + (b.remainder - a.remainder) + (b.displacement - a.displacement);
    let l = length(chord);
    var low = vec2f(0.0, dot(first, chord) / l);
    var high = vec2f(1.0, dot(second, chord) / l);
    let plane = (last.state & PLANE) != 0u;
    let ends = !plane && (low.y >= 0.0 || high.y <= 0.0 || high.y - low.y <= 1e-5);
    let straight = -low.y / max(high.y - low.y, 1e-5);
    let moves = !starts && !plane && abs(straight - last.straight) > STANDS;
    var found = Nearest(last.place, straight, 0.0, 0.0, RelativeMove(), Surface());
    if moves { found.part = clamp(last.place + straight - last.straight, 0.0, 1.0); }
    if !starts && !moves { found.straight = last.straight; }
    if ends { found.part = f32(low.y + high.y < 0.0); }
    for (var k = 0u; k <= REFINED; k++) {
        let place = between(a, b, found.part);
        found.effective_inverse_mass = place.effective_inverse_mass;
        found.seen = seen_from(body, place);
        found.surface = near(body, found.seen.base, found.seen.way);
        let slope = dot(found.surface.normal, chord) / l;
        if ends || plane || !(starts || moves) || k == REFINED
            || abs(slope * (high.x - low.x)) < CLOSE * (high.y - low.y) {
            break;
        }
        if slope < 0.0 { low = vec2f(found.part, slope); } else { high = vec2f(found.part, slope); }
        found.part = low.x - low.y * (high.x - low.x) / (high.y - low.y);
    }
    found.curve = select(min(l * (high.x - low.x) / (high.y - low.y), BENDS * l), 0.0, ends);
    return found;
}

// A contact whose multiplier, and the force that limits its friction, are set to its force.
fn renewed(last: Contact) -> Contact {
    var contact = last;
    contact.lag = max(last.force, 0.0);
    if abs(last.gap) > ALLOW && !is_deep(last.before) { contact.multiplier = contact.lag; }
    return contact;
}

// Whether a place at this distance takes more than a step to come out. The body is a plane without friction to it:
// farther in, the nearest surface may be another one at each place.
fn is_deep(distance: f32) -> bool {
    return distance < -RECOVERY * params.step;
}

// How a contact is where its place arrives.
struct Met {
    contact: Contact,
    changed: bool,      // touches or slides otherwise than in the Newton step before: the solve goes on
    lags: bool,         // its multiplier, or the force that limits its friction, is not f
}

// A contact that does not touch, at a distance.
fn parted(before: Contact, distance: f32, starts: bool) -> Met {
    var contact = before;
    contact.gap = distance;
    contact.friction = vec3f(0.0);
    contact.force = 0.0;
    contact.tangential_stiffness = 0.0;
    contact.state = before.state & PLANE;
    return Met(contact, !starts && (before.state & LIVE) != 0u, false);
}

// A contact of a place that answers to a force by `effective_inverse_mass` [m/N], with the body's friction, its way
// seen from the body and the surface there; `l` is the segment's length.
fn update_contact(
    before: Contact, mu: f32, effective_inverse_mass: f32, way: vec3f, surface: Surface, starts: bool, l: f32,
) -> Met {
    let plane = (before.state & PLANE) != 0u;
    let normal = select(surface.normal, before.normal, plane);
    let distance = select(surface.distance, before.before + dot(normal, way), plane)
        + max(0.0, -before.before - RECOVERY * params.step);
    let k = stiffness_of(effective_inverse_mass);
    let force = before.multiplier - k * distance;
    let was_live = (before.state & LIVE) != 0u;
    let was_sliding = (before.state & SLIDES) != 0u;
    // A contact that was live stays, or leaves, as the linear model has it.
    let pulled = before.linear > 0.0;
    let held = force > 0.0 && (pulled || distance <= 0.0);
    let stays = force <= 0.0 && pulled && distance < STAYS * l;
    let live = select(force > 0.0, held || stays, was_live && !starts);
    if effective_inverse_mass == 0.0 || !live { return parted(before, distance, starts); }
    var met = Met(before, !starts && (force < 0.0 || (!was_live && force * effective_inverse_mass > NOTICED)), false);
    met.contact.normal = normal;
    met.contact.gap = distance;
    met.contact.force = force;
    met.contact.friction = vec3f(0.0);
    met.contact.tangential_stiffness = 0.0;
    met.contact.state = (before.state & PLANE) | LIVE;
    if is_deep(before.before) { return met; }
    met.lags = abs(distance) > ALLOW;
    if mu == 0.0 { return met; }
    let off = abs(force - before.lag);
    met.lags = met.lags || (off > LAGS * force && off * effective_inverse_mass > 1e-9);
    let slip = way - dot(way, normal) * normal;
    let tried = before.held - dot(before.held, normal) * normal - k * slip;
    let most = mu * before.lag;
    let slides = length(tried) > most && !(was_sliding && dot(tried, before.friction) < 0.0);
    let part = select(1.0, most / length(tried), slides);
    met.contact.friction = part * tried;
    met.contact.tangential_stiffness = part * k;
    met.contact.state |= select(0u, SLIDES, slides);
    met.changed = met.changed || (slides != was_sliding && !starts);
    return met;
}

// The stiffness of a contact, and the force by which it resists; the Newton step counts from 0.
fn resists(contact: Contact, effective_inverse_mass: f32, step: u32) -> Spring {
    let normal = dyad(stiffness_of(effective_inverse_mass), contact.normal);
    let stiffness = contact.tangential_stiffness;
    var along = Symmetric(vec3f(stiffness), vec3f(0.0));
    along = minus(along, dyad(stiffness, contact.normal));
    if (contact.state & SLIDES) != 0u && stiffness > 0.0 {
        let keeps = select(1.0, 1.0 - SLIDING, step >= SLOW);
        along = minus(along, dyad(keeps * stiffness, normalize(contact.friction)));
    }
    return Spring(plus(normal, along), -contact.force * contact.normal - contact.friction);
}
