//! Contacts of a strand with bodies within its Newton steps.

use glam::{DMat3, DVec3};
use nalgebra::{Matrix6, Matrix6x4, Vector6};

use super::{
    Point, cross_matrix,
    solve::{Rod, add, add_force, vector},
};
use crate::contact::{Contact, MIDDLE, Met, Place, meet, nearest, parted, renewed, resists, stiffness};

/// Part of a segment from an end, nearer to which a place of it says nothing of the other end's velocity.
const BESIDE: f64 = 0.2;

/// How contacts are after a Newton step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Touch {
    pub touches: bool,
    /// Whether some changed.
    pub changed: bool,
    /// Whether a multiplier, or the force that limits a friction, is not the force that acts.
    pub lags: bool,
}

impl Touch {
    fn count(&mut self, met: &Met) {
        self.touches |= met.contact.live;
        self.changed |= met.changed;
        self.lags |= met.lags;
    }
}

impl Rod<'_> {
    fn place_of_point(&self, k: usize) -> Place {
        let point = &self.points[k];
        Place {
            start: point.start,
            displacement: point.shift + point.displacement,
            effective_inverse_mass: point.effective_inverse_mass(self.p),
        }
    }

    fn place_of_segment(&self, k: usize, contact: &Contact) -> Place {
        Place::between(self.place_of_point(k), self.place_of_point(k + 1), contact.place)
    }

    pub(super) fn rest_length(&self, k: usize) -> f64 {
        self.hair.rest_length[self.of_segment(k)]
    }

    /// Indices of the contacts of point or segment `k` among those of all points or segments.
    fn of(&self, k: usize) -> std::ops::Range<usize> {
        k * self.bodies.len()..(k + 1) * self.bodies.len()
    }

    /// Finds the contacts of all places where they are now; `starts` for the first time in the step. `renews` makes
    /// multipliers, and the forces that limit friction, what acts.
    pub(super) fn touch(&mut self, starts: bool, renews: bool) -> Touch {
        let mut touch = Touch::default();
        if renews {
            let all = self.point_contacts.iter_mut().chain(&mut *self.segment_contacts);
            all.for_each(|contact| *contact = renewed(self.p, contact));
        }
        for b in 0..self.bodies.len() {
            for k in 0..self.points.len() {
                let i = self.of(k).start + b;
                let met = self.met_point(k, b, &self.point_contacts[i], starts);
                self.point_contacts[i] = met.contact;
                touch.count(&met);
            }
            for k in 0..self.segments.len() {
                let i = self.of(k).start + b;
                let met = self.met_segment(k, b, self.segment_contacts[i], starts);
                self.segment_contacts[i] = met.contact;
                touch.count(&met);
            }
        }
        touch
    }

    /// Contact of point `k`, which is at least so far from a body as it was, less its way.
    fn met_point(&self, k: usize, b: usize, last: &Contact, starts: bool) -> Met {
        let (body, place) = (&self.bodies[b], self.place_of_point(k));
        let beside = k.saturating_sub(1)..self.segments.len().min(k + 1);
        let reach = beside.map(|k| self.rest_length(k)).fold(0.0, f64::max);
        let least = last.before - place.way(body).length();
        if least > reach {
            return parted(last, least, starts);
        }
        let surface = body.surface(place.end());
        let contact = Contact { normal: if last.plane { last.normal } else { surface.normal }, ..*last };
        if k < self.motion.embedded {
            return parted(&contact, surface.distance, starts);
        }
        meet(self.p, &contact, body, &place, surface, starts, reach)
    }

    /// Contact of segment `k`, between points whose contacts are found.
    fn met_segment(&self, k: usize, b: usize, mut contact: Contact, starts: bool) -> Met {
        let (body, l) = (&self.bodies[b], self.rest_length(k));
        let ends = [k, k + 1].map(|k| &self.point_contacts[self.of(k).start + b]);
        if k < self.motion.embedded || ends[0].gap + ends[1].gap > l {
            return parted(&contact, l, starts);
        }
        let places = [k, k + 1].map(|k| self.place_of_point(k));
        let found = nearest(&contact, body, places, ends.map(|end| end.normal), starts);
        if !contact.plane {
            (contact.place, contact.straight) = (found.part, found.straight);
            contact.curve = if starts { found.curve } else { contact.curve };
        }
        if !(MIDDLE..=1.0 - MIDDLE).contains(&found.part) {
            return parted(&contact, l, starts);
        }
        meet(self.p, &contact, body, &found.place, found.surface, starts, l)
    }

    /// Adds the contacts of point `k` to what lies beyond it.
    pub(super) fn push_point(&self, k: usize, matrix: &mut Matrix6<f64>, vectors: &mut Matrix6x4<f64>) {
        for contact in self.point_contacts[self.of(k)].iter().filter(|contact| contact.live) {
            let (stiffness, force) =
                resists(self.p, contact, self.points[k].effective_inverse_mass(self.p), self.newton);
            add(matrix, (3, 3), stiffness);
            add_force(vectors, vector(DVec3::ZERO, force));
        }
    }

    /// Stiffness of the contacts of segment `k` to the turn of the segment, whose second point is at `arm` from the
    /// first, and the move of that, and what they resist by. They take the place for one that the segment's stretch
    /// does not move.
    pub(super) fn push_segment(&self, k: usize, arm: DVec3) -> (Matrix6<f64>, Vector6<f64>) {
        let (mut matrix, mut forces) = (Matrix6::zeros(), Vector6::zeros());
        for contact in self.segment_contacts[self.of(k)].iter().filter(|contact| contact.live) {
            let effective_inverse_mass = self.place_of_segment(k, contact).effective_inverse_mass;
            let (stiffness, force) = resists(self.p, contact, effective_inverse_mass, self.newton);
            // The place moves by B (turn, move), B = [−[r]×, 1].
            let reach = contact.place * arm;
            let swing = -cross_matrix(reach);
            add(&mut matrix, (0, 0), swing.transpose() * stiffness * swing);
            add(&mut matrix, (0, 3), swing.transpose() * stiffness);
            add(&mut matrix, (3, 0), stiffness * swing);
            add(&mut matrix, (3, 3), stiffness);
            forces += vector(reach.cross(force), force);
            // It shifts as the segment turns.
            let axis = arm.normalize().cross(contact.normal);
            let shifts = DMat3::from_cols(axis.x * axis, axis.y * axis, axis.z * axis);
            add(&mut matrix, (0, 0), shifts * (contact.force.max(0.0) * contact.curve));
        }
        (matrix, forces)
    }

    /// The linear model of the contacts of point `k`, which moves.
    pub(super) fn foresee_point(&mut self, k: usize, shift: DVec3) {
        let (range, k) = (self.of(k), stiffness(self.p, self.points[k].effective_inverse_mass(self.p)));
        for contact in &mut self.point_contacts[range] {
            contact.linear = contact.multiplier - k * (contact.gap + contact.normal.dot(shift));
        }
    }

    /// The linear model of the contacts of segment `k`, whose first point moves and whose second moves by `swing` more.
    pub(super) fn foresee_segment(&mut self, k: usize, shift: DVec3, swing: DVec3) {
        for i in self.of(k) {
            let contact = self.segment_contacts[i];
            let k = stiffness(self.p, self.place_of_segment(k, &contact).effective_inverse_mass);
            let moves = shift + contact.place * swing;
            self.segment_contacts[i].linear = contact.multiplier - k * (contact.gap + contact.normal.dot(moves));
        }
    }

    /// Leaves the contacts to the next step: those of an unsolved strand remember nothing. A point that touches, or
    /// that a touching segment moves, has the velocity of its move: all of it where it sticks, else across the surface.
    pub(super) fn leave(&mut self, solved: bool) {
        let count = self.bodies.len();
        for (k, b) in (0..self.points.len()).flat_map(|k| (0..count).map(move |b| (k, b))) {
            let segment = |k: usize| self.segment_contacts.get(k * count + b).copied();
            let before = k.checked_sub(1).and_then(segment).filter(|contact| contact.place >= BESIDE);
            let after = segment(k).filter(|contact| contact.place <= 1.0 - BESIDE);
            let contacts = [Some(self.point_contacts[k * count + b]), before, after];
            for contact in contacts.iter().flatten().filter(|contact| contact.live) {
                slow(&mut self.points[k], contact, self.p.step);
            }
        }
        if !solved {
            let all = self.point_contacts.iter_mut().chain(&mut *self.segment_contacts);
            all.for_each(|contact| (contact.friction, contact.force) = (DVec3::ZERO, 0.0));
        }
    }
}

fn slow(point: &mut Point, contact: &Contact, step: f64) {
    if point.inverse_mass == 0.0 {
        return;
    }
    let sticks = !contact.slides && contact.tangential_stiffness > 0.0;
    let part = |v: DVec3| if sticks { v } else { v.project_onto_normalized(contact.normal) };
    point.previous_move += part(point.displacement - point.previous_move);
    point.velocity += part(point.displacement / step - point.velocity);
}
