//! One step, in execution order. Read this file first.

pub mod contact;
pub mod drive;
pub mod fluid;
pub mod guard;
pub mod neighbours;
pub mod rods;
pub mod turbulence;
pub mod velocity;
pub mod viscosity;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records one step.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    drive::record(r, s, plan); //      1. Bad strands are reset; wind enters, gravity pulls; predict positions.
    neighbours::record(r, s, plan); // 2. Sort particles into cells, list who is near whom.
    fluid::record(r, s, plan); //      3. Hair and air share one density constraint (eq. 1).
    rods::record(r, s, plan); //       4. Strands keep their length and shape.
    contact::record(r, s, plan); //    5. Nothing enters a body.
    velocity::record(r, s, plan); //   6. Velocities from positions.
    turbulence::record(r, s, plan); // 7. Strengthen the eddies of each band (eqs. 2, 4-6), air only.
    viscosity::record(r, s, plan); //  8. Neighbours share velocity (eqs. 7, 8).
    guard::record(r, s, plan); //      9. Commit, or freeze and report.
}

/// Records the density of the committed state, for reports: headings 2 and 3 over positions copied to `predicted`.
pub fn record_density(r: &mut Recorder, s: &State, plan: &Plan) {
    neighbours::record(r, s, plan);
    fluid::record_density(r, s, plan);
}
