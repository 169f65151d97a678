//! 4. Strands keep their length and shape.

use windswept_shaders::rods;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("4. rods");
    r.when(&plan.hair, |r| {
        prepare(r, s, plan);
        r.when(&plan.direct, |r| {
            r.repeat(plan.newton_steps, |r| direct(r, s, plan));
            rescue(r, s, plan);
        });
        // All strands, or those that were rescued. Short dispatches: see `rods::sweeps_per_dispatch`.
        r.repeat(plan.rod_dispatches, |r| gauss_seidel(r, s, plan));
        finish(r, s, plan);
    });
}

fn prepare(r: &mut Recorder, s: &State, plan: &Plan) {
    let n = &plan.sizes;
    r.run(
        &rods::PREDICT,
        "what moves hair points",
        n.hair_points,
        &[
            &s.params,
            &s.status,
            &s.inverse_mass,
            &s.velocity,
            &s.largest_move,
            &s.drag_change,
            &s.correction,
            &s.point_history,
            &s.rod_points,
        ],
    );
    r.run(
        &rods::TURN,
        "what turns segments",
        n.segments,
        &[
            &s.params,
            &s.status,
            &s.segments,
            &s.position,
            &s.point_history,
            &s.orientation,
            &s.angular_velocity,
            &s.segment_history,
            &s.rod_segments,
        ],
    );
    r.run(
        &rods::CHOOSE,
        "BDF2, Euler or sleep",
        n.strands,
        &[
            &s.params,
            &s.status,
            &s.strands,
            &s.segments,
            &s.rod_strands,
            &s.rod_points,
            &s.rod_segments,
            &s.health,
            &s.touched,
        ],
    );
}

fn direct(r: &mut Recorder, s: &State, plan: &Plan) {
    r.run(
        &rods::DIRECT,
        "Cosserat rods, solved directly",
        plan.sizes.strands,
        &[&s.params, &s.status, &s.strands, &s.segments, &s.rod_strands, &s.rod_points, &s.rod_segments, &s.factors],
    );
}

fn rescue(r: &mut Recorder, s: &State, plan: &Plan) {
    r.run(
        &rods::RESCUE,
        "torn strands are left to Gauss-Seidel",
        plan.sizes.strands,
        &[&s.params, &s.status, &s.strands, &s.rod_strands, &s.rod_points, &s.rod_segments],
    );
}

fn gauss_seidel(r: &mut Recorder, s: &State, plan: &Plan) {
    r.run(
        &rods::GAUSS_SEIDEL,
        "Cosserat rods by Gauss-Seidel",
        plan.sizes.strands,
        &[&s.params, &s.status, &s.strands, &s.segments, &s.rod_strands, &s.rod_points, &s.rod_segments],
    );
}

fn finish(r: &mut Recorder, s: &State, plan: &Plan) {
    let n = &plan.sizes;
    r.run(
        &rods::FINISH,
        "health of each strand",
        n.strands,
        &[&s.params, &s.status, &s.strands, &s.segments, &s.rod_strands, &s.rod_points, &s.rod_segments, &s.health],
    );
    r.run(
        &rods::PLACE,
        "hair goes where its rods took it",
        n.hair_points,
        &[&s.params, &s.status, &s.position, &s.point_history, &s.rod_points, &s.predicted],
    );
}
