//! The band filter's error against the whole sum, by where the direct sum is cut and how fine the grid is.

use glam::DVec3;
use windswept_reference::turbulence::{mexican_hat, peak_gain};
use windswept_scene::{Band, DirectFilter, Filter, GridFilter, Scene};
use windswept_validate::internals::{Cloud, RADIUS, VOLUME, air_scene, rms, vectors};

use crate::{Lab, Result, timing};

use super::{Measured, role};

/// Scales s of the bands \[m\].
const SCALES: [f64; 3] = [0.007, 0.011, 0.018];
/// Distances at which the direct sum is cut \[s\].
const CUTOFFS: [f64; 5] = [3.0, 3.5, 4.0, 4.5, 5.0];
/// Spacings of the grid's nodes \[s\].
const SPACINGS: [f64; 5] = [1.0, 0.8, 0.65, 0.55, 0.45];
/// Distance along an axis beyond which images add less than 1e-12 of the hat's middle \[s\].
const REACH: f64 = 8.0;
/// Passes that the filters' time is of, or how their names start: all up to û. The grid sorts once more than the direct
/// sum.
const PASSES: [&str; 5] =
    ["turbulence/weigh", "turbulence/band", "turbulence/deposit", "turbulence/smooth", "turbulence/gather"];

/// The settings that differ at this scale, each with its series and its name: no grid is coarser than a kernel radius.
fn settings(lab: &Lab, scale: f64) -> Vec<(Filter, &'static str, String)> {
    let direct = lab.some(&CUTOFFS).iter();
    let direct =
        direct.map(|&cutoff| (Filter::Direct(DirectFilter { cutoff }), "direct sum", format!("cut at {cutoff} s")));
    let grids = lab.some(&SPACINGS).iter().map(|&spacing| {
        let spacing = spacing.min(RADIUS / scale);
        (Filter::Grid(GridFilter { spacing }), "grid", format!("nodes {spacing:.3} s apart at most"))
    });
    let mut all: Vec<_> = direct.chain(grids).collect();
    all.dedup_by(|a, b| a.0 == b.0);
    all
}

/// Error and time of each filter, at each scale.
pub(super) fn measure(lab: &Lab) -> Result<Measured> {
    let air = Cloud::centred(if lab.quick { 8 } else { 17 }).jittered(0.3, 7).stirred(1.0, 5);
    let mut measured = Measured::default();
    for &scale in lab.some(&SCALES) {
        let whole = whole_sum(&air, scale);
        let kind = format!("s = {} mm: rms error of û over its rms", 1e3 * scale);
        let usual = match air_scene().check()?.turbulence.filter {
            Filter::Grid(GridFilter { spacing }) => Filter::Grid(GridFilter { spacing: spacing.min(RADIUS / scale) }),
            direct => direct,
        };
        let settings = settings(lab, scale);
        let scenes: Vec<_> = settings.iter().map(|(filter, ..)| (scene(scale, *filter), air.initial())).collect();
        let times = timing::of_passes(&lab.gpu, &scenes, &PASSES, lab.rounds(4))?;
        for ((filter, series, setting), ms) in settings.iter().zip(times) {
            let got = vectors(&air.particles().band_velocity(&lab.gpu, scale, *filter)?);
            let error =
                rms(got.iter().zip(&whole).map(|(a, b)| (*a - *b).length())) / rms(whole.iter().map(|u| u.length()));
            measured.add(series, setting, ms, role(*filter == usual, true), [(&kind, error, 0.0)]);
        }
    }
    measured.notes = vec![
        "field: box of 17 d, jitter 0.3 d, six solenoidal waves of 1-3 periods per axis (d the particles' spacing)"
            .into(),
        "error: against the f64 sum over all particles and all periodic images in which the hat is above 1e-12".into(),
        "time: without the grid's sort into its own cells, a few percent".into(),
    ];
    Ok(measured)
}

/// A band that is filtered and hardly fed.
fn scene(scale: f64, filter: Filter) -> Scene {
    let mut scene = air_scene();
    scene.turbulence.speed = Some(1.0);
    scene.turbulence.bands = vec![Band { scale, strength: 1e-9, intensity: 1.0 }];
    scene.turbulence.filter = Some(filter);
    scene
}

/// Velocity û by the sum over all pairs and periodic images, f64: (3 − r²/s²) exp(−r²/2s²) falls into sums along the
/// axes.
fn whole_sum(air: &Cloud, scale: f64) -> Vec<DVec3> {
    let factor = VOLUME * mexican_hat(0.0, scale) / 3.0 / peak_gain(scale);
    let hat = |a: &[f64; 3], b: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|axis| images((a[axis] - b[axis]) / scale, air.size[axis] / scale));
        3.0 * x.0 * y.0 * z.0 - (x.1 * y.0 * z.0 + x.0 * y.1 * z.0 + x.0 * y.0 * z.1)
    };
    let at = |a: &[f64; 3]| {
        let all = air.positions.iter().zip(&air.velocities);
        all.map(|(b, v)| factor * hat(a, b) * DVec3::from_array(*v)).sum()
    };
    air.positions.iter().map(at).collect()
}

/// Sums Σ exp(−g²/2) and Σ g² exp(−g²/2) over the images of a gap along an axis, gap and side of the box in units of s.
fn images(gap: f64, side: f64) -> (f64, f64) {
    let most = (REACH / side + 0.5).ceil() as i32;
    let nearest = gap - side * (gap / side).round();
    (-most..=most).map(|n| (nearest + side * f64::from(n)).powi(2)).fold((0.0, 0.0), |(plain, squared), square| {
        let part = (-0.5 * square).exp();
        (plain + part, squared + square * part)
    })
}
