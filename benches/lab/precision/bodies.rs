//! A cylinder in the wind: the density of the air beside it, by substeps and by the spacing of particles.

use windswept_scene::{FluidSolver, InitialState};
use windswept_validate::internals::Tunnel;

use crate::{Lab, Result, timing};

use super::{Measured, role};

/// Substeps of a step of 1.38 ms.
const SUBSTEPS: [u32; 3] = [1, 2, 4];
/// Spacings of particles, over the usual one, with the radius of the cylinder in them.
const SPACINGS: [(f64, &str); 2] = [(1.0, "2.5"), (0.75, "3.3")];
/// Times between which the density is looked at \[s\].
const LOOKS: [f64; 2] = [0.1, 0.17];

/// Errors and time of each setting.
pub(super) fn measure(lab: &Lab) -> Result<Measured> {
    let mut settings = Vec::new();
    for solver in [FluidSolver::Divergence, FluidSolver::Pbf] {
        for &spacing in lab.some(&SPACINGS) {
            settings.extend(lab.some(&SUBSTEPS).iter().map(|&substeps| (solver, spacing, substeps)));
        }
    }
    let tunnel = |(solver, (spacing, _), substeps)| Tunnel::cylinder(solver, spacing, substeps);
    let scenes = settings.iter().map(|&setting| {
        let scene = tunnel(setting).scene();
        let initial = InitialState::new(&scene)?;
        Ok((scene, initial))
    });
    let scenes = scenes.collect::<Result<Vec<_>>>()?;
    let times = timing::of_passes(&lab.gpu, &scenes, &[""], lab.rounds(3))?;
    let mut measured = Measured::default();
    for (setting, ms) in settings.into_iter().zip(times) {
        let [beside, behind] = tunnel(setting).unevenness(&lab.gpu, if lab.quick { [0.0, 2e-3] } else { LOOKS })?;
        let (solver, (spacing, radius), substeps) = setting;
        let divergence = solver == FluidSolver::Divergence;
        let role = role(divergence && spacing == 1.0 && substeps == 1, divergence);
        let errors =
            [("density error beside the cylinder, rms", beside, 0.0), ("density behind it, off the mean", behind, 0.0)];
        let series = format!("{}, a radius of {radius} spacings", solver.word());
        measured.add(&series, &format!("{substeps} substeps"), ms, role, errors);
    }
    measured.notes = vec![
        "a cylinder of 12 mm in 3 m/s, in a box of 160 x 121 x 29 mm; means from 0.1 to 0.17 s".into(),
        "beside: within 9.3 mm of the surface; behind: within 14.5 mm of it, a quarter of the shell".into(),
    ];
    Ok(measured)
}
