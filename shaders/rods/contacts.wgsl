// State of a strand beside the bodies as the step begins: whether it may meet a body, whether a moving body wakes it,
// how many of its points, from the root on, have no contact, and the forces of its contacts in the step before.
//
// From a root that is held at a depth d below a surface, a strand rises by RISE of its length. The points that are
// nearer to the root than d/RISE along the strand are *embedded*: if bodies pushed them out, they would push against
// the clamp in every step.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::rotate,
    rod::{Strand, Segment, RodStrand, RodPoint, ROOT_HELD, TELEPORTED, SLEEPS},
    body::{Placed, Surface, near, steepest, swing},
    contact::{Contact, ContactHistory, Nearest, Place, PLANE, is_deep, nearest, seen_from},
};

@group(0) @binding(2) var<storage, read>       strands:         array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:        array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:     array<RodStrand>;
@group(0) @binding(5) var<storage, read>       rod_points:      array<RodPoint>;
@group(0) @binding(6) var<storage, read>       placed:          array<Placed>;
@group(0) @binding(7) var<storage, read>       contact_history: array<ContactHistory>;
@group(0) @binding(8) var<storage, read_write> contacts:        array<Contact>;

const RISE: f32 = 0.5;        // way to the surface [lengths of the strand]: the sine of 30 degrees
const STEPS: u32 = 16u;
const GRAZES: f32 = 0.01;     // distance from the surface at which a way enters [radii of the body]

// A point that a body carries along in the step.
fn carried(body: Placed, point: RodPoint) -> Place {
    let displacement = (body.center - body.center_before) + swing(body, point.start.xyz - body.center_before);
    return Place(point.start.xyz, point.remainder, displacement, 0.0);
}

// A contact as the step begins, with the surface seen from its place.
fn begin(history: ContactHistory, body: Placed, start: Surface, forgets: bool) -> Contact {
    var contact = Contact();
    contact.normal = start.normal;
    contact.before = start.distance;
    if is_deep(start.distance) { contact.state = PLANE; }
    if forgets || history.force == 0.0 || is_deep(start.distance) { return contact; }
    contact.friction = rotate(body.turn, history.friction);
    contact.held = contact.friction;
    contact.force = history.force;
    contact.lag = history.force;
    contact.multiplier = history.force;
    return contact;
}

// To a place whose way leads far through a body, or out of it on another side, the body is the plane that touches it
// where the way enters: steps along the way are as long as the distance allows (Hart 1996, Sphere tracing).
fn plane(contact: Contact, body: Placed, place: Place) -> Contact {
    let seen = seen_from(body, place);
    let far = length(seen.way);
    if contact.before < 0.0 || contact.before > far || far < 0.5 * body.inradius { return contact; }
    var part = 0.0;
    var surface = Surface(contact.normal, contact.before);
    for (var k = 0u; k < STEPS && surface.distance > GRAZES * body.inradius; k++) {
        part += surface.distance / (steepest(body) * far);
        if part > 1.0 { return contact; }
        surface = near(body, seen.base, part * seen.way);
    }
    if surface.distance > GRAZES * body.inradius { return contact; }
    var through = contact;
    through.normal = surface.normal;
    through.before = surface.distance - part * dot(surface.normal, seen.way);
    through.state |= PLANE;
    return through;
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    let strand = strands[s];
    let rod = rod_strands[s];
    let forgets = rod.condition.failed != 0u || rod.state == TELEPORTED;
    let sleeps = rod.condition.resting == SLEEPS;
    let bodies = arrayLength(&placed);
    var meets = false;
    var wakes = false;
    var depth = 0.0;     // of the root,
    var deepest = 0.0;   // and of the other points and segments
    for (var b = 0u; b < bodies; b++) {
        let root = carried(placed[b], rod_points[strand.first_point]);
        let seen = seen_from(placed[b], root);
        depth = max(depth, -near(placed[b], seen.base, seen.way).distance);
    }
    var embedded = 0u;
    var along = 0.0;
    while (strand.joints & ROOT_HELD) != 0u && embedded < strand.points && RISE * along < depth {
        along += segments[strand.first_segment + min(embedded, strand.points - 2u)].rest_length;
        embedded++;
    }
    for (var b = 0u; b < bodies; b++) {
        let body = placed[b];
        var begins = Place();    // of the segment,
        var first = Surface();   // seen from there
        for (var k = 0u; k < strand.points; k++) {
            let point = rod_points[strand.first_point + k];
            let ends = carried(body, point);
            let seen = seen_from(body, ends);
            let start = near(body, seen.base, seen.way);
            let moves = length(ends.displacement);
            let l = segments[strand.first_segment + max(k, 1u) - 1u].rest_length;
            meets = meets || start.distance - moves < strand.length;
            wakes = wakes || (sleeps && moves > 0.0 && start.distance - moves < l);
            if k >= max(embedded, 1u) { deepest = max(deepest, -start.distance); }
            let ahead = Place(ends.start, ends.remainder, params.step * point.velocity, 0.0);
            let i = (strand.first_point + k) * bodies + b;
            contacts[i] = plane(begin(contact_history[i], body, start, forgets), body, ahead);
            if k > 0u {
                var middle = Nearest();
                middle.surface = Surface(start.normal, l);
                if first.distance + start.distance < l {
                    var contact = Contact();
                    contact.place = 0.5;
                    middle = nearest(contact, body, begins, ends, first.normal, start.normal, true);
                }
                let j = (params.hair_points + strand.first_segment + k - 1u) * bodies + b;
                contacts[j] = begin(contact_history[j], body, middle.surface, forgets);
                contacts[j].place = middle.part;
                if k > embedded { deepest = max(deepest, -middle.surface.distance); }
            }
            begins = ends;
            first = start;
        }
    }
    rod_strands[s].meets = u32(meets);
    rod_strands[s].woken = u32(wakes);
    rod_strands[s].comes_out = u32(is_deep(-deepest));
    rod_strands[s].embedded = embedded;
}
