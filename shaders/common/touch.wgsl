// Contacts in the Newton steps of `rods/solve`: their stiffness, their linear model, their update after a Newton
// step has moved their places, and their history for the next step. `common/contact` defines a contact.
import package::common::{
    params::params, symmetric::{applied_to_columns, dyad, plus, twice_symmetric}, articulated::{Beyond, ONE, crossing},
    body::{BODIES, Placed, near},
    contact::{
        Contact, Met, Place, LIVE, MIDDLE, PLANE, SLIDES, update_contact, nearest, parted, place_of_point, renewed,
        effective_inverse_mass_between, resists, seen_from,
        stiffness_of,
    },
    rod::{Strand, Segment, RodStrand, RodPoint},
};

@group(0) @binding(3) var<storage, read>       segments:   array<Segment>;
@group(0) @binding(5) var<storage, read_write> rod_points: array<RodPoint>;
// of points, then of segments, each with every body
@group(0) @binding(7) var<storage, read_write> contacts:   array<Contact>;
@group(0) @binding(8) var<storage, read>       placed:     array<Placed>;

// part of a segment from an end, nearer to which a place of it says nothing of the other end's velocity
const BESIDE: f32 = 0.2;

// How contacts are after a Newton step.
struct Touch {
    touches: bool,
    changed: bool,   // some changed
    lags: bool,      // a multiplier, or the force that limits a friction, is not the force that acts
}

// Bodies that a strand may meet.
fn bodies(rod: RodStrand) -> u32 {
    return select(0u, arrayLength(&placed), BODIES && rod.meets != 0u);
}

// Contacts of all places where they are now; `starts`: of the first time in the step. `renews` makes multipliers and
// the limits of friction the forces that act.
fn touch(strand: Strand, rod: RodStrand, starts: bool, renews: bool) -> Touch {
    var touch = Touch();
    for (var b = 0u; b < bodies(rod); b++) {
        let body = placed[b];
        var begins = Place();    // of the segment,
        var first = Contact();   // and its contact
        var before = 0.0;        // m, length of the segment
        for (var k = 0u; k < strand.points; k++) {
            let ends = place_of_point(rod_points[strand.first_point + k]);
            let after = segments[strand.first_segment + min(k, strand.points - 2u)].rest_length;
            let i = (strand.first_point + k) * bodies(rod) + b;
            let second = met_point(contacts[i], body, ends, starts, renews, max(before, after), k >= rod.embedded);
            contacts[i] = second.contact;
            touch = counted(touch, second);
            if k > 0u {
                let j = (params.hair_points + strand.first_segment + k - 1u) * bodies(rod) + b;
                let middle = met_segment(
                    contacts[j], body, begins, ends, first, second.contact, starts, renews, before, k > rod.embedded,
                );
                contacts[j] = middle.contact;
                touch = counted(touch, middle);
            }
            begins = ends;
            first = second.contact;
            before = after;
        }
    }
    return touch;
}

fn counted(before: Touch, met: Met) -> Touch {
    return Touch(
        before.touches || (met.contact.state & LIVE) != 0u, before.changed || met.changed, before.lags || met.lags,
    );
}

// A place is at least so far from a body as it was, less its way.
fn met_point(
    last: Contact, body: Placed, place: Place, starts: bool, renews: bool, reach: f32, may_touch: bool,
) -> Met {
    var contact = last;
    if renews { contact = renewed(last); }
    let seen = seen_from(body, place);
    let least = contact.before - length(seen.way);
    if least > reach { return parted(contact, least, starts); }
    let surface = near(body, seen.base, seen.way);
    if (contact.state & PLANE) == 0u { contact.normal = surface.normal; }
    if !may_touch { return parted(contact, surface.distance, starts); }
    return update_contact(contact, body.friction, place.effective_inverse_mass, seen.way, surface, starts, reach);
}

// The segment between two places, with the contacts of its ends.
fn met_segment(
    last: Contact, body: Placed, begins: Place, ends: Place, first: Contact, second: Contact, starts: bool,
    renews: bool, l: f32,
    may_touch: bool,
) -> Met {
    var contact = last;
    if renews { contact = renewed(last); }
    if !may_touch || first.gap + second.gap > l { return parted(contact, l, starts); }
    let plane = (contact.state & PLANE) != 0u;
    let found = nearest(contact, body, begins, ends, first.normal, second.normal, starts);
    if !plane {
        contact.place = found.part;
        contact.straight = found.straight;
        if starts { contact.curve = found.curve; }
    }
    if found.part < MIDDLE || found.part > 1.0 - MIDDLE { return parted(contact, l, starts); }
    return update_contact(contact, body.friction, found.effective_inverse_mass, found.seen.way, found.surface, starts,
        l);
}

// Leaves contacts to the next step: those of an unsolved strand remember nothing. A point that touches, or that a
// touching segment moves, has the velocity of its move: all of it where it sticks, else across the surface, so that the
// integrator carries nothing into the body.
fn leave(strand: Strand, rod: RodStrand, solved: bool) {
    let count = bodies(rod);
    for (var k = 0u; k < strand.points; k++) {
        let p = strand.first_point + k;
        let j = params.hair_points + strand.first_segment + k;   // segment after it
        for (var b = 0u; b < count; b++) {
            slow(p, contacts[p * count + b]);
            if k > 0u && contacts[(j - 1u) * count + b].place >= BESIDE { slow(p, contacts[(j - 1u) * count + b]); }
            if k + 1u < strand.points && contacts[j * count + b].place <= 1.0 - BESIDE {
                slow(p, contacts[j * count + b]);
            }
        }
    }
    for (var k = 0u; k < strand.points && !solved; k++) {
        for (var b = 0u; b < count; b++) {
            let i = (strand.first_point + k) * count + b;
            forget(i);
            if k + 1u < strand.points { forget((params.hair_points + strand.first_segment + k) * count + b); }
        }
    }
}

fn forget(i: u32) {
    contacts[i].friction = vec3f(0.0);
    contacts[i].force = 0.0;
}

fn slow(p: u32, contact: Contact) {
    if (contact.state & LIVE) == 0u || rod_points[p].effective_inverse_mass == 0.0 { return; }
    let point = rod_points[p];
    let sticks = (contact.state & SLIDES) == 0u && contact.tangential_stiffness > 0.0;
    let change = point.displacement - point.previous_move;
    let faster = point.displacement / params.step - point.velocity;
    rod_points[p].previous_move += select(dot(change, contact.normal) * contact.normal, change, sticks);
    rod_points[p].velocity += select(dot(faster, contact.normal) * contact.normal, faster, sticks);
}

// Adds the contacts of a point; of the segment from point p on, whose second end is at `arm` from the first.
fn push_point(beyond: Beyond, rod: RodStrand, p: u32) -> Beyond {
    var sum = beyond;
    for (var b = 0u; b < bodies(rod); b++) {
        let contact = contacts[p * arrayLength(&placed) + b];
        if (contact.state & LIVE) == 0u { continue; }
        let push = resists(contact, rod_points[p].effective_inverse_mass, rod.newton);
        sum.own = plus(sum.own, push.stiffness);
        sum.force += push.force;
    }
    return sum;
}
fn push_segment(beyond: Beyond, rod: RodStrand, p: u32, j: u32, arm: vec3f) -> Beyond {
    var sum = beyond;
    for (var b = 0u; b < bodies(rod); b++) {
        let contact = contacts[(params.hair_points + j) * arrayLength(&placed) + b];
        if (contact.state & LIVE) == 0u { continue; }
        let between = effective_inverse_mass_between(rod_points[p].effective_inverse_mass,
            rod_points[p + 1u].effective_inverse_mass, contact.place);
        let push = resists(contact, between, rod.newton);
        let reach = contact.place * arm;
        let swung = applied_to_columns(push.stiffness, -1.0 * crossing(reach, ONE));
        sum.own = plus(sum.own, push.stiffness);
        sum.cross += swung;
        sum.other = plus(sum.other, twice_symmetric(0.5 * crossing(reach, swung)));
        sum.force += push.force;
        sum.other_force += cross(reach, push.force);
        // The place shifts as the segment turns.
        let axis = cross(normalize(arm), contact.normal);
        sum.other = plus(sum.other, dyad(max(contact.force, 0.0) * contact.curve, axis));
    }
    return sum;
}

// Predicts normal forces to first order: of the contacts of a point after `shift`, and of those of the segment from
// point p on, which also turns.
fn foresee(rod: RodStrand, p: u32, effective_inverse_mass: f32, shift: vec3f) {
    for (var b = 0u; b < bodies(rod); b++) {
        let i = p * arrayLength(&placed) + b;
        if (contacts[i].state & LIVE) == 0u { continue; }
        contacts[i].linear = contacts[i].multiplier
            - stiffness_of(effective_inverse_mass) * (contacts[i].gap + dot(contacts[i].normal, shift));
    }
}
fn foresee_segment(rod: RodStrand, p: u32, j: u32, shift: vec3f, swing: vec3f) {
    for (var b = 0u; b < bodies(rod); b++) {
        let i = (params.hair_points + j) * arrayLength(&placed) + b;
        let contact = contacts[i];
        if (contact.state & LIVE) == 0u { continue; }
        let effective_inverse_mass = effective_inverse_mass_between(rod_points[p].effective_inverse_mass,
            rod_points[p + 1u].effective_inverse_mass, contact.place);
        contacts[i].linear = contact.multiplier
            - stiffness_of(effective_inverse_mass) * (contact.gap + dot(contact.normal, shift + contact.place * swing));
    }
}
