//! Neighbours share velocity (eqs. 7, 8).

use std::ops::Range;

use windswept_scene::{CheckedScene, InitialState, Model, ViscosityForm};
use windswept_shaders::{common::matter::MAX_EDDIES, viscosity};

use crate::{
    recorder::{Decision, Recorder},
    setup::Setup,
    step::{Plan, conditions::Conditions},
};

/// Decisions of this stage.
#[derive(Debug, Clone)]
pub struct ViscosityPlan {
    /// Whether XSPH can overshoot, so that its limiter runs.
    pub limiter: Decision,
    /// The clusters that the limiter has to do with: of hair, where only hair can overshoot, or all.
    pub limited_clusters: Range<u32>,
}

pub(super) fn plan(setup: &Setup<'_>, c: &Conditions) -> ViscosityPlan {
    let (bounds, n) = (exchanges(setup.scene, setup.initial), setup.sizes());
    ViscosityPlan {
        limiter: c.viscosity.and(limiter(setup.scene, bounds)),
        limited_clusters: if bounds.air > 1.0 { n.clusters_of_all() } else { n.clusters_of_hair() },
    }
}

/// Records the passes of this stage.
pub fn record(r: &mut Recorder<'_>, plan: &Plan) {
    r.stage("viscosity");
    let n = r.sizes();
    r.when(&plan.viscosity.limiter, |r| {
        r.dispatch_neighbours(&viscosity::LIMIT, "limit of the exchange", plan.viscosity.limited_clusters.clone());
    });
    r.when(&plan.conditions.viscosity, |r| {
        r.dispatch_neighbours(&viscosity::XSPH, "XSPH viscosity", n.clusters_of_all());
    });
}

/// The largest S, the part of its velocity that a particle exchanges by XSPH, which the limiter need not look for.
#[derive(Debug, Clone, Copy)]
struct Exchanges {
    air: f64,
    hair: f64,
}

/// S_i = Σ c_ij w_ij ≤ 2 c √(V_max/V_min), since Σ_j V_j W ≤ θ_i, with the volumes and the coefficient of those that
/// the particle meets.
fn exchanges(scene: &CheckedScene, initial: &InitialState) -> Exchanges {
    let bound = |coefficient: f64, volumes: &mut dyn Iterator<Item = f64>| {
        let (smallest, largest) = volumes.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
        if largest > 0.0 {
            2.0 * coefficient / f64::from(scene.time.substeps) * (largest / smallest).sqrt()
        } else {
            0.0
        }
    };
    let most_eddies = if scene.viscosity.smagorinsky > 0.0 { f64::from(MAX_EDDIES) } else { 0.0 };
    let of_air = scene.viscosity.air + f64::from(scene.time.substeps) * most_eddies;
    let hair = || initial.hair.volume.iter().copied();
    let air = || (!initial.air.positions.is_empty()).then_some(initial.air.volume).into_iter();
    let of_hair = if initial.hair.is_empty() { 0.0 } else { scene.viscosity.hair };
    if scene.interaction.model == Model::TwoWay {
        return Exchanges { air: bound(of_air, &mut air()), hair: bound(of_hair, &mut hair()) };
    }
    let all = bound(of_hair.max(of_air), &mut hair().chain(air()));
    Exchanges { air: all, hair: all }
}

/// Below 1 the limiter can never act.
fn limiter(scene: &CheckedScene, bounds: Exchanges) -> Decision {
    if scene.viscosity.form == ViscosityForm::Published {
        return Decision::when(false, "viscosity.form is published");
    }
    let bound = bounds.air.max(bounds.hair);
    Decision::when(bound > 1.0, format!("no particle can exchange more than {bound:.2} of its velocity"))
}
