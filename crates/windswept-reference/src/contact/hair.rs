//! Contact of strands with bodies, solved with the rods. A place of a strand is one of its points, or the place of a
//! segment that is nearest to a body. It has a contact with each body, a one-sided spring with Coulomb friction:
//!
//! ```text
//!   normal     f = λ − k (φ + D), where that is above 0     φ: distance after the step, k = max(100, h² Ω²)/W
//!   friction   F = F_old − k slip, no longer than μ f_lag
//! ```
//! W is the move of the place by a unit of force, D the depth that the place may keep in this step: a place that starts
//! inside comes out at `RECOVERY`. The multiplier λ is f of the step before, or of the last Newton step that settled
//! with more than `ALLOW` left open: at rest the spring carries nothing, and the gap is 0 (augmented Lagrangian;
//! Hestenes 1969). The way of a place is seen from the body: from where the body carries it to where it goes.

use glam::{DMat3, DVec3};

use super::Placed;
use crate::{Parameters, State, rods, step::Scratch};

/// Stiffness of a contact, at least, over that of the place's inertia 1/W.
const STIFFNESS: f64 = 100.0;
/// Frequency Ω of a place on the spring, at least \[1/s\].
const OMEGA: f64 = 3.2e3;
/// Speed at which hair comes out of a body \[m/s\].
pub(crate) const RECOVERY: f64 = 0.15;
/// Gap φ + D that may be left open in a step \[m\].
const ALLOW: f64 = 2e-5;
/// Distance from the surface at which a contact ends whatever the linear model says \[lengths of the segment\].
const STAYS: f64 = 0.1;
/// Smallest push that the solve has to settle \[m\].
const NOTICED: f64 = 1e-5;
/// Part of a segment at each end in which the end's point makes contact in place of the segment.
pub(crate) const MIDDLE: f64 = 0.03;
/// Times that the nearest place of a segment is refined.
const REFINED: usize = 3;
/// Tolerance of the search for the nearest place of a segment \[parts of the segment\].
const CLOSE: f64 = 0.002;
/// Estimated move of that place that starts another search in later Newton steps \[parts of the segment\].
const STANDS: f64 = 0.02;
/// Longest way by which a place shifts as its segment turns by 1 rad \[lengths of the segment\].
const BENDS: f64 = 30.0;
/// Part by which f may differ from the force that limits friction.
const LAGS: f64 = 0.02;
/// Turn after which a strand that touches takes all force for tension \[rad\].
pub(crate) const UNEASY: f64 = 0.1;
/// Part of the tangential stiffness that resists sliding on, from Newton step `SLOW` on.
const SLIDING: f64 = 0.1;
const SLOW: u32 = 3;
/// Way by which a strand rises to a body's surface from a root that is held within \[lengths\]: the sine of 30 degrees.
const RISE: f64 = 0.5;
/// Steps along a way that may enter a body, at most.
const STEPS: usize = 16;
/// Distance from the surface at which a way enters \[radii of the body\].
const GRAZES: f64 = 0.01;

/// A surface seen from a place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Surface {
    /// Unit vector out of the body.
    pub normal: DVec3,
    /// Distance of the place from the surface, negative inside \[m\].
    pub distance: f64,
}

/// A place of a strand in the step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Place {
    /// Where it starts \[m\].
    pub start: DVec3,
    /// Move of the place \[m\].
    pub displacement: DVec3,
    /// Response W: its move by a unit of force \[m/N\].
    pub effective_inverse_mass: f64,
}

impl Place {
    /// The place between two at a part of the way from `a` to `b`.
    #[must_use]
    pub fn between(a: Self, b: Self, part: f64) -> Self {
        Self {
            start: a.start.lerp(b.start, part),
            displacement: a.displacement.lerp(b.displacement, part),
            effective_inverse_mass: (1.0 - part).powi(2) * a.effective_inverse_mass
                + part * part * b.effective_inverse_mass,
        }
    }

    /// Where the place goes \[m\].
    #[must_use]
    pub fn end(&self) -> DVec3 {
        self.start + self.displacement
    }

    /// Way of the place seen from a body \[m\].
    #[must_use]
    pub fn way(&self, body: &Placed) -> DVec3 {
        self.end() - body.carried(self.start)
    }
}

/// Contact of a place with a body within a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Contact {
    /// Normal out of the body, of a point also where it does not touch.
    pub normal: DVec3,
    /// Gap φ + D \[m\].
    pub gap: f64,
    /// Friction F \[N\].
    pub friction: DVec3,
    /// Normal force f \[N\].
    pub force: f64,
    /// Friction of the step before, turned with the body \[N\].
    pub held: DVec3,
    /// Normal force that limits friction: of the step before, or of the last Newton step that settled \[N\].
    pub lag: f64,
    /// Multiplier λ \[N\].
    pub multiplier: f64,
    /// Distance from the surface as the step begins \[m\].
    pub before: f64,
    /// Part of the segment.
    pub place: f64,
    /// Part of the segment at which the slopes at its ends alone have the place.
    pub straight: f64,
    /// Way by which the place shifts along the segment as that turns \[m/rad\].
    pub curve: f64,
    /// Stiffness of the friction \[N/m\].
    pub tangential_stiffness: f64,
    /// Normal force by the linear model of the last Newton step \[N\].
    pub linear: f64,
    /// Whether it touches.
    pub live: bool,
    /// Whether it slides.
    pub slides: bool,
    /// Whether the body is a plane to it in this step, at `before` across `normal`.
    pub plane: bool,
}

/// Memory of a contact from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Memory {
    /// Friction \[N\].
    pub friction: DVec3,
    /// Normal force \[N\]; 0 where it did not touch.
    pub force: f64,
}

/// Memories of contacts of points and then of segments, each with every body.
#[must_use]
pub fn memories(m: &rods::Moving) -> Vec<Memory> {
    let kept = |contact: &Contact| Memory { friction: contact.friction, force: contact.force.max(0.0) };
    m.point_contacts.iter().chain(&m.segment_contacts).map(kept).collect()
}

/// Finds the state of strands beside the bodies as the step begins: the forces of their contacts in the step before,
/// whether they may meet a body, whether a moving body wakes them, how many points have no contact, from a root on that
/// is held inside a body, and whether others are deep in a body.
pub fn contacts(s: &State, w: &mut Scratch, p: &Parameters) {
    let (bodies, count) = (&w.moving.bodies, w.moving.bodies.len());
    let memory = |i: usize| s.contacts.get(i).copied().unwrap_or_default();
    w.moving.point_contacts = vec![Contact::default(); p.hair_points * count];
    w.moving.segment_contacts = vec![Contact::default(); s.orientation.len() * count];
    for (strand, motion) in w.motions.iter_mut().enumerate() {
        let (points, first_segment) = (s.hair.points(strand), s.hair.segments(strand).start);
        let rests = &s.hair.rest_length[s.hair.segments(strand)];
        let length: f64 = rests.iter().sum();
        let forgets = s.failed[strand] || motion.state == rods::State::Teleported;
        let held = s.inverse_mass[points.start] == 0.0;
        let root = s.position[points.start];
        let depth = bodies.iter().map(|body| -body.surface(body.carried(root)).distance).fold(0.0, f64::max);
        let risen = (0..=rests.len()).map(|k| RISE * rests[..k].iter().sum::<f64>());
        motion.embedded = if held { risen.take_while(|risen| *risen < depth).count() } else { 0 };
        (motion.meets, motion.woken, motion.comes_out) = (false, false, false);
        for (b, body) in bodies.iter().enumerate() {
            let mut segment_begins = None;
            for (k, i) in points.clone().enumerate() {
                let x = s.position[i];
                let ends = Place { start: x, displacement: body.moves(x), effective_inverse_mass: 0.0 };
                let start = body.surface(ends.end());
                let moves = ends.displacement.length();
                let l = rests[k.max(1) - 1];
                motion.meets |= start.distance - moves < length;
                motion.woken |= s.sleeping[strand] && moves > 0.0 && start.distance - moves < l;
                motion.comes_out |= k >= motion.embedded.max(1) && is_deep(p, start.distance);
                let ahead = Place { displacement: p.step * w.moving.points[i].velocity, ..ends };
                let contact = recall(p, memory(i * count + b), body, start, forgets);
                w.moving.point_contacts[i * count + b] = flattened(contact, body, &ahead);
                if let Some((begins, first)) = segment_begins {
                    let j = first_segment + k - 1;
                    let (place, surface) = middle(body, [begins, ends], [first, start], l);
                    let contact = recall(p, memory((p.hair_points + j) * count + b), body, surface, forgets);
                    motion.comes_out |= k > motion.embedded && is_deep(p, surface.distance);
                    w.moving.segment_contacts[j * count + b] = Contact { place, ..contact };
                }
                segment_begins = Some((ends, start));
            }
        }
    }
}

/// Place of a segment that is nearest to a body as the step begins, as a part of it, and the surface seen from there.
fn middle(body: &Placed, ends: [Place; 2], surfaces: [Surface; 2], l: f64) -> (f64, Surface) {
    if surfaces[0].distance + surfaces[1].distance >= l {
        return (0.0, Surface { distance: l, ..surfaces[1] });
    }
    let contact = Contact { place: 0.5, ..Contact::default() };
    let found = nearest(&contact, body, ends, surfaces.map(|surface| surface.normal), true);
    (found.part, found.surface)
}

/// A contact as the step begins, with the surface seen from its place.
fn recall(p: &Parameters, memory: Memory, body: &Placed, start: Surface, forgets: bool) -> Contact {
    let plane = is_deep(p, start.distance);
    let contact = Contact { normal: start.normal, before: start.distance, plane, ..Contact::default() };
    if forgets || plane || memory.force == 0.0 {
        return contact;
    }
    let friction = body.turn() * memory.friction;
    let Memory { force, .. } = memory;
    Contact { friction, held: friction, force, lag: force, multiplier: force, ..contact }
}

/// The contact of a place that is to go `ahead`. To one whose way leads far through a body the body is the plane that
/// touches it where the way enters: no body is nearer than its distance says, so the search goes on by that (Hart 1996,
/// Sphere tracing).
fn flattened(contact: Contact, body: &Placed, ahead: &Place) -> Contact {
    let (base, way, radius) = (body.carried(ahead.start), ahead.way(body), body.body.shape.inradius());
    let far = way.length();
    if contact.before < 0.0 || contact.before > far || far < 0.5 * radius {
        return contact;
    }
    let (mut part, mut surface) = (0.0, Surface { normal: contact.normal, distance: contact.before });
    for _ in 0..STEPS {
        if surface.distance <= GRAZES * radius {
            break;
        }
        part += surface.distance / (body.steepest() * far);
        if part > 1.0 {
            return contact;
        }
        surface = body.surface(base + part * way);
    }
    if surface.distance > GRAZES * radius {
        return contact;
    }
    let before = surface.distance - part * surface.normal.dot(way);
    Contact { normal: surface.normal, before, plane: true, ..contact }
}

/// Nearest place of a segment to a body.
pub(crate) struct Nearest {
    /// Part of the segment; 0 or 1 where an end is nearest.
    pub part: f64,
    /// The same by the slopes at the ends alone.
    pub straight: f64,
    /// Way by which it shifts as the segment turns \[m/rad\].
    pub curve: f64,
    pub place: Place,
    /// The surface seen from there.
    pub surface: Surface,
}

/// Finds where a segment is nearest to a body with these normals at its ends: as the step starts by regula falsi on the
/// slope of the distance along it, from the place that it had; later anew, where the slopes at the ends say that it
/// moved. A place to which the body is a plane stays.
pub(crate) fn nearest(last: &Contact, body: &Placed, [a, b]: [Place; 2], normals: [DVec3; 2], starts: bool) -> Nearest {
    let chord = b.end() - a.end();
    let along = chord / chord.length();
    let [mut low, mut high] = [(0.0, normals[0].dot(along)), (1.0, normals[1].dot(along))];
    let at_end = !last.plane && (low.1 >= 0.0 || high.1 <= 0.0 || high.1 - low.1 <= 1e-5);
    let now = -low.1 / (high.1 - low.1).max(1e-5);
    let moves = !starts && !last.plane && (now - last.straight).abs() > STANDS;
    let straight = if starts || moves { now } else { last.straight };
    let mut part = match (at_end, low.1 + high.1 < 0.0) {
        (false, _) if moves => (last.place + now - last.straight).clamp(0.0, 1.0),
        (false, _) => last.place,
        (true, true) => 1.0,
        (true, false) => 0.0,
    };
    let mut refined = 0;
    loop {
        let place = Place::between(a, b, part);
        let surface = body.surface(place.end());
        let slope = surface.normal.dot(along);
        let per_slope = (high.0 - low.0) / (high.1 - low.1);
        if at_end || last.plane || !(starts || moves) || refined == REFINED || (slope * per_slope).abs() < CLOSE {
            let curve = if at_end { 0.0 } else { chord.length() * per_slope.min(BENDS) };
            return Nearest { part, straight, curve, place, surface };
        }
        *(if slope < 0.0 { &mut low } else { &mut high }) = (part, slope);
        part = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        refined += 1;
    }
}

/// A contact whose multiplier, and the force that limits its friction, are set to its force.
pub(crate) fn renewed(p: &Parameters, last: &Contact) -> Contact {
    let lag = last.force.max(0.0);
    let open = last.gap.abs() > ALLOW && !is_deep(p, last.before);
    Contact { lag, multiplier: if open { lag } else { last.multiplier }, ..*last }
}

/// Whether a place is so deep that leaving at [`RECOVERY`] takes more than a step. The body is a plane without friction
/// to it: deep inside, places beside one another may have different nearest surfaces.
fn is_deep(p: &Parameters, distance: f64) -> bool {
    distance < -RECOVERY * p.step
}

/// How a contact is where its place arrives.
pub(crate) struct Met {
    pub contact: Contact,
    /// Whether it touches or slides otherwise than in the Newton step before: the solve goes on.
    pub changed: bool,
    /// Whether its multiplier, or the force that limits its friction, still differs from f.
    pub lags: bool,
}

/// A contact that does not touch, at a distance \[m\].
pub(crate) fn parted(before: &Contact, distance: f64, starts: bool) -> Met {
    let at_rest = Contact { gap: distance, friction: DVec3::ZERO, force: 0.0, tangential_stiffness: 0.0, ..*before };
    Met { contact: Contact { live: false, slides: false, ..at_rest }, changed: !starts && before.live, lags: false }
}

/// Stiffness k of a contact of a place with this response \[N/m\].
pub(crate) fn stiffness(p: &Parameters, effective_inverse_mass: f64) -> f64 {
    STIFFNESS.max((OMEGA * p.step).powi(2)) / effective_inverse_mass
}

/// A contact with the surface seen from the place; `l` is the length of the segment \[m\].
pub(crate) fn meet(
    p: &Parameters,
    before: &Contact,
    body: &Placed,
    place: &Place,
    surface: Surface,
    starts: bool,
    l: f64,
) -> Met {
    let way = place.way(body);
    let (normal, distance) = if before.plane {
        (before.normal, before.before + before.normal.dot(way))
    } else {
        (surface.normal, surface.distance)
    };
    let distance = distance + (-before.before - RECOVERY * p.step).max(0.0);
    let k = stiffness(p, place.effective_inverse_mass);
    let force = before.multiplier - k * distance;
    // A contact that was live stays, or leaves, as the linear model has it.
    let pulled = before.linear > 0.0;
    let live = match (before.live && !starts, force > 0.0) {
        (false, pushes) => pushes,
        (true, true) => pulled || distance <= 0.0,
        (true, false) => pulled && distance < STAYS * l,
    };
    if place.effective_inverse_mass == 0.0 || !live {
        return parted(before, distance, starts);
    }
    let pushed = !before.live && force * place.effective_inverse_mass > NOTICED;
    let contact = Contact { normal, force, live: true, ..parted(before, distance, starts).contact };
    let mut met = Met { contact, changed: !starts && (force < 0.0 || pushed), lags: false };
    if is_deep(p, before.before) {
        return met;
    }
    met.lags = distance.abs() > ALLOW;
    if body.body.friction == 0.0 {
        return met;
    }
    let off = (force - before.lag).abs();
    met.lags |= off > LAGS * force && off * place.effective_inverse_mass > 1e-9;
    let tried = before.held.reject_from_normalized(normal) - k * way.reject_from_normalized(normal);
    let most = body.body.friction * before.lag;
    let turns_back = before.slides && tried.dot(before.friction) < 0.0;
    let slides = tried.length() > most && !turns_back;
    let part = if slides { most / tried.length() } else { 1.0 };
    met.contact = Contact { friction: part * tried, tangential_stiffness: part * k, slides, ..met.contact };
    met.changed |= !starts && slides != before.slides;
    met
}

/// The stiffness of a contact \[N/m\], and the force by which it resists \[N\]; the Newton step counts from 0.
pub(crate) fn resists(p: &Parameters, contact: &Contact, effective_inverse_mass: f64, step: u32) -> (DMat3, DVec3) {
    let dyad = |k: f64, v: DVec3| DMat3::from_cols(k * v.x * v, k * v.y * v, k * v.z * v);
    let normal = dyad(stiffness(p, effective_inverse_mass) - contact.tangential_stiffness, contact.normal);
    let mut stiffness = normal + DMat3::from_diagonal(DVec3::splat(contact.tangential_stiffness));
    if contact.slides && contact.tangential_stiffness > 0.0 {
        let keeps = if step >= SLOW { 1.0 - SLIDING } else { 1.0 };
        stiffness -= dyad(keeps * contact.tangential_stiffness, contact.friction.normalize());
    }
    (stiffness, -contact.force * contact.normal - contact.friction)
}
