//! What nothing may change.

use glam::DVec3;
use windswept::Gpu;

use crate::{
    Error, Row,
    air::{self, Cloud, MASS, SIMPLE},
};

const KEPT: &str = "over sum m |v| at the end; 1000 particles stirred at 0.3 m/s; measured 1.7e-7; margin 6: f32";

/// Air stirred in a closed periodic box, no wind and no confinement: Σ m v stays.
pub(crate) fn closed_box(gpu: &Gpu) -> Result<Vec<Row>, Error> {
    let cloud = Cloud::lattice([10; 3], SIMPLE).jittered(0.1, 5).stirred(0.3, 5);
    let after = air::run(gpu, &air::scene("")?, &cloud, 1000)?;
    let (before, _) = momentum(&cloud);
    let (sum, whole) = momentum(&after);
    let change = (sum - before).length() / whole;
    Ok(vec![Row::new("closed box of air: change of momentum in 1000 steps", 0.0, change, 1e-6, KEPT)])
}

/// Σ m v and Σ m |v| \[kg m/s\].
fn momentum(cloud: &Cloud) -> (DVec3, f64) {
    let each = cloud.velocities.iter().map(|v| MASS * DVec3::from_array(*v));
    (each.clone().sum(), each.map(|p| p.length()).sum())
}
