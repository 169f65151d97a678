//! 5. Nothing enters a body. Bodies are not in this version: the heading has no pass yet.

use crate::{plan::Plan, recorder::Recorder, state::State};

pub fn record(r: &mut Recorder, _: &State, _: &Plan) {
    r.heading("5. contact");
}
