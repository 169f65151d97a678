//! 9. Commit, or freeze and report.

use windswept_shaders::guard;

use crate::{plan::Plan, recorder::Recorder, state::State};

/// Records the passes of this heading.
pub fn record(r: &mut Recorder, s: &State, plan: &Plan) {
    r.heading("9. guard");
    let n = &plan.sizes;
    let velocity = plan.final_velocity(s);
    r.when(&plan.hair, |r| {
        r.run(
            &guard::HOLD,
            "strands that are not finite stand still",
            n.strands,
            &[&s.params, &s.status, &s.strands, &s.health, &velocity],
        );
    });
    r.run(&guard::CHECK, "is all finite", n.particles, &[&s.params, &s.status, &s.predicted, &velocity]);
    r.when(&plan.hair, |r| {
        r.run(
            &guard::COMMIT_FRAMES,
            "commit orientations",
            n.segments,
            &[
                &s.params,
                &s.status,
                &s.rod_strands,
                &s.rod_segments,
                &s.orientation,
                &s.angular_velocity,
                &s.segment_history,
                &s.clamps,
            ],
        );
        r.run(
            &guard::COMMIT_HAIR,
            "commit what hair remembers",
            n.hair_points,
            &[
                &s.params,
                &s.status,
                &s.position,
                &s.predicted,
                &s.new_velocity,
                &velocity,
                &s.rod_points,
                &s.point_history,
            ],
        );
    });
    r.run(
        &guard::COMMIT,
        "commit positions and velocities",
        n.particles,
        &[
            &s.params,
            &s.status,
            &s.predicted,
            &velocity,
            &s.position,
            &s.velocity,
            &s.health,
            &s.mean_confinement,
            &s.confinement_impulse,
        ],
    );
}
