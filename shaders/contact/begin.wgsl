// How a strand stands to the bodies as the step begins: whether it may meet one, whether one that moves wakes it, how many of its points, from
// the root on, bodies let be, and what its contacts remember.
//
// From a root that is held at a depth d below a surface, a strand rises by RISE of its length. The points that are nearer to the root than
// d/RISE along the strand are *embedded*: if bodies pushed them out, they would push against the clamp in every step.
import package::common::{
    params::params, dispatch::{invocation, WORKGROUP}, quaternion::rotate,
    rod::{Strand, Segment, RodStrand, RodPoint, ROOT_HELD, TELEPORTED, SLEEPS}, body::{Placed, near, surface_move},
    contact::{Contact, ContactHistory, Place, TOUCHED, distance_before, seen_from},
};

@group(0) @binding(2) var<storage, read>       strands:         array<Strand>;
@group(0) @binding(3) var<storage, read>       segments:        array<Segment>;
@group(0) @binding(4) var<storage, read_write> rod_strands:     array<RodStrand>;
@group(0) @binding(5) var<storage, read>       rod_points:      array<RodPoint>;
@group(0) @binding(6) var<storage, read>       placed:          array<Placed>;
@group(0) @binding(7) var<storage, read>       contact_history: array<ContactHistory>;
@group(0) @binding(8) var<storage, read_write> contacts:        array<Contact>;

const RISE: f32 = 0.5;   // way to the surface [lengths of the strand]: the sine of 30 degrees

// What a contact remembers, turned with the body.
fn remembered(history: ContactHistory, body: Placed, forgets: bool) -> Contact {
    var contact = Contact();
    if forgets || history.force == 0.0 { return contact; }
    contact.friction = rotate(body.turn, history.friction);
    contact.held = contact.friction;
    contact.force = history.force;
    contact.lag = history.force;
    contact.state = TOUCHED;
    return contact;
}

fn moves(body: Placed, x: vec3f) -> bool {
    return any(surface_move(body, x) != vec3f(0.0));
}

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let s = invocation(id, groups);
    if s >= params.strands { return; }
    let strand = strands[s];
    let rod = rod_strands[s];
    let forgets = rod.condition.bad != 0u || rod.state == TELEPORTED;
    let sleeps = rod.condition.still == SLEEPS;
    let bodies = arrayLength(&placed);
    var meets = false;
    var wakes = false;
    var depth = 0.0;   // of the root
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let point = rod_points[p];
        let l = segments[strand.first_segment + min(k, strand.points - 2u)].rest_length;
        for (var b = 0u; b < bodies; b++) {
            let body = placed[b];
            contacts[p * bodies + b] = remembered(contact_history[p * bodies + b], body, forgets);
            if k > 0u {
                let j = (params.hair_points + strand.first_segment + k - 1u) * bodies + b;
                contacts[j] = remembered(contact_history[j], body, forgets);
            }
            let place = Place(point.start.xyz, point.remainder, vec3f(0.0), 0.0);
            let seen = seen_from(body, place);
            let gap = distance_before(body, place);
            if k == 0u { depth = max(depth, -gap); }
            meets = meets || gap - length(surface_move(body, point.start.xyz)) < strand.length;
            let after = near(body, seen.base, seen.way).distance;
            wakes = wakes || (sleeps && min(gap, after) < l && moves(body, point.start.xyz));
        }
    }
    var embedded = 0u;
    var along = 0.0;
    while (strand.joints & ROOT_HELD) != 0u && embedded < strand.points && RISE * along < depth {
        along += segments[strand.first_segment + min(embedded, strand.points - 2u)].rest_length;
        embedded++;
    }
    rod_strands[s].meets = u32(meets);
    rod_strands[s].woken = u32(wakes);
    rod_strands[s].embedded = embedded;
}
