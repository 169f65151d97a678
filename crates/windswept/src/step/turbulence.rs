//! 7. Strengthen the eddies of each band (eqs. 2, 4-6), air only. Not in this version: the heading has no pass yet.

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, _: &State, _: &Plan) {
    r.heading("7. turbulence");
}
