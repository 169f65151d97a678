//! 5. Nothing enters a body. Bodies are not in this version: the heading has no pass yet.

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, _: &State, _: &Plan) {
    r.heading("5. contact");
}
