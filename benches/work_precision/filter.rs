//! The band filter: where it is cut, against the sum that is not.

use glam::DVec3;
use windswept_reference::turbulence::{mexican_hat, peak_gain};
use windswept_scene::{Band, Scene};

use crate::{
    Bench, Measured, Result,
    air::{self, Air, VOLUME, rms, vectors},
    point::Point,
    timing,
};

/// s \[m\].
const SCALES: [f64; 3] = [0.007, 0.011, 0.018];
/// In units of s.
const CUTOFFS: [f64; 5] = [3.0, 3.5, 4.0, 4.5, 5.0];
/// Images that are farther off along an axis, in units of s, add less than 1e-12 of the hat's middle.
const REACH: f64 = 8.0;

/// Error and time of each cut, at each scale.
pub(crate) fn measure(bench: &Bench) -> Result<Measured> {
    let air = Air::lattice(if bench.quick { 8 } else { 17 }).jittered(0.3).stirred(1.0);
    let mut points = Vec::new();
    for &scale in bench.some(&SCALES) {
        let whole = whole_sum(&air, scale);
        let kind = format!("s = {} mm: rms error of û over its rms", 1e3 * scale);
        let cutoffs = bench.some(&CUTOFFS);
        let scenes =
            cutoffs.iter().map(|cutoff| Ok((scene(scale, *cutoff)?, air.initial()))).collect::<Result<Vec<_>>>()?;
        let times = timing::passes(&bench.gpu, &scenes, &["turbulence/band"], bench.rounds(6))?;
        for (&cutoff, time) in cutoffs.iter().zip(&times) {
            let got = vectors(&air.particles().band_velocity(&bench.gpu, scale, cutoff)?);
            let error =
                rms(got.iter().zip(&whole).map(|(a, b)| (*a - *b).length())) / rms(whole.iter().map(|u| u.length()));
            let default = cutoff == air::scene("")?.turbulence.cutoff;
            points
                .push(Point { default, ..Point::new(&kind, "direct sum", &format!("cut at {cutoff} s"), time, error) });
        }
    }
    let notes = vec![
        "field: box of 17 d, jitter 0.3 d, six solenoidal waves of 1-3 periods per axis (d the particles' spacing)"
            .into(),
        "error: against the f64 sum over all particles and all periodic images in which the hat is above 1e-12".into(),
    ];
    Ok(Measured { points, notes })
}

/// A band that is filtered and hardly fed.
fn scene(scale: f64, cutoff: f64) -> Result<Scene> {
    let mut scene = air::scene("turbulence.speed = 1.0")?;
    scene.turbulence.bands = vec![Band { scale, strength: 1e-9, intensity: 1.0 }];
    scene.turbulence.cutoff = cutoff;
    Ok(scene)
}

/// û by the sum over all pairs and periodic images, f64: (3 − r²/s²) exp(−r²/2s²) falls into sums along the axes.
fn whole_sum(air: &Air, scale: f64) -> Vec<DVec3> {
    let factor = VOLUME * mexican_hat(0.0, scale) / 3.0 / peak_gain(scale);
    let hat = |a: &[f64; 3], b: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|axis| images((a[axis] - b[axis]) / scale, air.side / scale));
        3.0 * x.0 * y.0 * z.0 - (x.1 * y.0 * z.0 + x.0 * y.1 * z.0 + x.0 * y.0 * z.1)
    };
    let at = |a: &[f64; 3]| {
        let all = air.positions.iter().zip(&air.velocities);
        all.map(|(b, v)| factor * hat(a, b) * DVec3::from_array(*v)).sum()
    };
    air.positions.iter().map(at).collect()
}

/// Σ exp(−g²/2) and Σ g² exp(−g²/2) over the images of a gap along an axis, gap and side of the box in units of s.
fn images(gap: f64, side: f64) -> (f64, f64) {
    let most = (REACH / side + 0.5).ceil() as i32;
    let nearest = gap - side * (gap / side).round();
    (-most..=most).map(|n| (nearest + side * f64::from(n)).powi(2)).fold((0.0, 0.0), |(plain, squared), square| {
        let part = (-0.5 * square).exp();
        (plain + part, squared + square * part)
    })
}
