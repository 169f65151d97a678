//! Air particles on their lattice, and the mean wind.

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::{
    body::{CheckedShape, inside},
    initial::AirParticles,
    scene::{Bounds, CheckedAir, SceneValues},
    strands::Strands,
};

/// Distance to a hair point below which air is left out \[particle spacings\]: that of a sphere of one particle's
/// volume.
const CLEARANCE: f64 = 0.62;

/// Parts along each axis in which a lattice cell is counted that the surface of a body cuts.
const PARTS: usize = 6;

/// Largest part of the box that hair to be blown in may take.
const LARGEST_SHARE: f64 = 0.5;

impl CheckedAir {
    /// Volume V of a particle before the count is rounded \[m³\].
    #[must_use]
    pub fn particle_volume(&self) -> f64 {
        self.spacing.powi(3)
    }

    /// Sites of the lattice that fills a box, along each axis.
    pub(crate) fn lattice(&self, bounds: &Bounds) -> DVec3 {
        let size = DVec3::from_array(bounds.max) - DVec3::from_array(bounds.min);
        (size / self.spacing).round().max(DVec3::splat(3.0))
    }
}

impl SceneValues {
    /// Air and the box that its particles fill; `None` without particles.
    pub(crate) fn filled(&self) -> Option<(&CheckedAir, Bounds)> {
        let air = self.air.as_ref().filter(|_| self.interaction.model.has_air())?;
        Some((air, air.bounds?))
    }
}

/// Fills the box: a simple cubic lattice with the volumes of hair points and bodies left out, and a volume that makes
/// the mean density of what bodies leave of the box exact once all hair streams in it: strands that hang out of it at
/// the start are blown in.
///
/// Each particle stands off its site by up to `air.jitter` spacings along each axis: by chance, which is PCG XSL 128/64
/// seeded by `seed`.
pub(crate) fn particles(
    air: &CheckedAir,
    bounds: &Bounds,
    hair: &Strands,
    bodies: &[CheckedShape],
    seed: u64,
) -> AirParticles {
    let min = DVec3::from_array(bounds.min);
    let size = DVec3::from_array(bounds.max) - min;
    let spacing = air.spacing;
    let counts = air.lattice(bounds);
    let pitch = size / counts;
    let [nx, ny, nz] = counts.to_array().map(|n| n as usize);

    let mut taken = vec![false; nx * ny * nz];
    let mut within = 0.0;
    let reach = CLEARANCE * spacing;
    for (point, volume) in hair.positions.iter().zip(&hair.volume) {
        let x = *point - min;
        if x.cmpge(DVec3::ZERO).all() && x.cmplt(size).all() {
            within += volume;
        }
        let first = ((x - reach) / pitch - 0.5).ceil().max(DVec3::ZERO);
        let last = ((x + reach) / pitch - 0.5).floor().min(counts - 1.0);
        if first.cmpgt(last).any() {
            continue;
        }
        for k in first.z as usize..=last.z as usize {
            for j in first.y as usize..=last.y as usize {
                for i in first.x as usize..=last.x as usize {
                    let site = pitch * (DVec3::new(i as f64, j as f64, k as f64) + 0.5);
                    if site.distance(x) < reach {
                        taken[i + nx * (j + ny * k)] = true;
                    }
                }
            }
        }
    }

    let wind = DVec3::from_array(air.wind_at(0.0));
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut offset = || DVec3::from_array([(); 3].map(|()| air.jitter * rng.random_range(-1.0..=1.0)));
    let mut positions = Vec::with_capacity(taken.len());
    let mut room = 0.0;
    for (index, taken) in taken.iter().enumerate() {
        let site = DVec3::new((index % nx) as f64, (index / nx % ny) as f64, (index / nx / ny) as f64);
        let x = min + pitch * (site + 0.5);
        room += outside(bodies, x, pitch);
        if !taken && !inside(bodies, x) {
            let shaken = min + (x + pitch * offset() - min).rem_euclid(size);
            positions.push(if inside(bodies, shaken) { x } else { shaken });
        }
    }
    let whole = room * pitch.element_product();
    let all = hair.volume.iter().sum::<f64>();
    let hair = within.max(all.min(LARGEST_SHARE * whole));
    let volume = if positions.is_empty() { 0.0 } else { (whole - hair) / positions.len() as f64 };
    AirParticles {
        min,
        size,
        velocities: vec![wind; positions.len()],
        positions,
        volume,
        mass: air.rest_density * volume,
    }
}

/// The part of a lattice cell about `center` that is in no body.
fn outside(bodies: &[CheckedShape], center: DVec3, cell: DVec3) -> f64 {
    let deepest = bodies.iter().map(|body| body.signed_distance(center).0).fold(f64::INFINITY, f64::min);
    let reach = 0.5 * cell.length();
    if deepest.abs() >= reach {
        return if deepest > 0.0 { 1.0 } else { 0.0 };
    }
    // The surface passes through: count.
    let seat = |k: usize| DVec3::new((k % PARTS) as f64, (k / PARTS % PARTS) as f64, (k / PARTS / PARTS) as f64);
    let parts = (0..PARTS.pow(3)).map(|k| center + cell * ((seat(k) + 0.5) / PARTS as f64 - 0.5));
    let free = parts.filter(|x| !inside(bodies, *x)).count();
    free as f64 / PARTS.pow(3) as f64
}
