//! Films made by formula, of which every number is known.
#![allow(clippy::unwrap_used)] // a test may panic

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::*;

/// Frames per second.
const RATE: f64 = 60.0;
const WIND: [f64; 3] = [2.0, 0.0, 0.0];
/// Length of the strands [m].
const LENGTH: f64 = 0.1;

/// The strands of a frame, point by point.
type Strands = Vec<Vec<DVec3>>;

fn hair(strands: &Strands) -> HairFrame {
    let mut hair = HairFrame { offsets: vec![0], ..HairFrame::default() };
    for points in strands {
        hair.positions.extend(points.iter().map(|point| point.as_vec3().to_array()));
        hair.offsets.push(hair.positions.len() as u32);
    }
    hair
}

/// A film of so many frames without velocities, measured.
fn measured(frames: usize, wind: [f64; 3], strands: impl Fn(f64) -> Strands) -> Measurement {
    let mut measure = Measure::new(MeasureOptions::default());
    for time in (0..frames).map(|k| k as f64 / RATE) {
        measure.add(time, &hair(&strands(time)), wind).unwrap();
    }
    measure.finish().unwrap()
}

/// A still film.
fn still(strands: Strands) -> Measurement {
    measured(60, [0.0; 3], |_| strands.clone())
}

/// A strand of these directions, in segments of one length.
fn along(directions: impl ExactSizeIterator<Item = DVec3>) -> Vec<DVec3> {
    let step = LENGTH / directions.len() as f64;
    let mut points = vec![DVec3::new(0.01, 0.02, 0.03)];
    for direction in directions {
        points.push(points[points.len() - 1] + step * direction.normalize());
    }
    points
}

/// A strand in a plane whose direction has the angle `angle(s)` at part s of its length.
fn plane(segments: usize, angle: impl Fn(f64) -> f64) -> Vec<DVec3> {
    let part = |k: usize| k as f64 / (segments - 1) as f64;
    along((0..segments).map(|k| DVec3::new(angle(part(k)).sin(), -angle(part(k)).cos(), 0.0)))
}

/// A straight strand of 5 points from `root` down, its tip moved by `shift`.
fn straight(root: DVec3, shift: DVec3) -> Vec<DVec3> {
    (0..5).map(|k| 0.25 * f64::from(k)).map(|part| root + part * (LENGTH * DVec3::NEG_Y + shift)).collect()
}

/// Roots on a circle: of each, the four nearest are the next two on both sides.
fn ring(strands: usize) -> impl Iterator<Item = (f64, DVec3)> {
    let angle = move |k: usize| TAU * k as f64 / strands as f64;
    (0..strands).map(angle).map(|angle| (angle, 0.02 * DVec3::new(angle.cos(), 0.0, angle.sin())))
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance}");
}

/// Tips that swing alike are a bundle that swings. Whole periods are in the window; f32 rounds to 2e-9 m here.
#[test]
fn a_bundle_swings() {
    let (a, f) = (0.01, 5.0);
    let swing = |time: f64| DVec3::new(0.004 * (TAU * 10.0 * time).cos(), 0.0, a * (TAU * f * time).sin());
    let film = |time| ring(12).map(|(_, root)| straight(root, swing(time))).collect();
    let found = measured(60, WIND, film);
    assert_eq!((found.strands, found.frames, found.axis), (12, 48, [1.0, 0.0, 0.0]));
    near(found.from_s, 0.2, 1e-12);
    near(found.to_s, 59.0 / RATE, 1e-12);
    near(found.swing_m, a / 2f64.sqrt(), 1e-8);
    near(found.swing_bundle_m, a / 2f64.sqrt(), 1e-8);
    near(found.swing_strands_m, 0.0, 1e-8);
    near(found.frequency_hz.unwrap(), f, 1e-6);
    near(found.coherence.unwrap(), 1.0, 1e-6);
    // Without wind, sideways is across the strands.
    let calm = measured(60, [0.0; 3], film);
    near(calm.axis[1], -1.0, 1e-3);
    near(calm.swing_m.powi(2), 0.5 * (a * a + 0.004f64.powi(2)), 1e-8);
}

/// The spectrum has its power at the frequencies of the motion, and all of the swing's square.
#[test]
fn the_spectrum_sums_to_the_swing() {
    let (a, b) = (0.01, 0.003);
    let swing = |time: f64| DVec3::new(0.0, b * (TAU * 15.0 * time).sin(), a * (TAU * 5.0 * time).sin());
    let found = measured(60, WIND, |time| vec![straight(DVec3::ZERO, swing(time))]);
    let step = found.spectrum_frequency_hz[0];
    near(step, RATE / 48.0, 1e-9);
    near(*found.spectrum_frequency_hz.last().unwrap(), 0.5 * RATE, 1e-9);
    near(found.spectrum_power_m2_per_hz.iter().sum::<f64>() * step, found.swing_m.powi(2), 1e-10);
    // A Hann window spreads a line over three frequencies: 1/6, 2/3 and 1/6 of its power.
    let power = |f: f64| found.spectrum_power_m2_per_hz[(f / step).round() as usize - 1] * step;
    for (at, amplitude) in [(5.0, a), (15.0, b)] {
        let whole = 0.5 * amplitude * amplitude;
        near(power(at), whole * 2.0 / 3.0, 1e-3 * whole);
        near(power(at + step), whole / 6.0, 1e-3 * whole);
    }
    near(power(25.0), 0.0, 1e-12);
    // A motion without whole periods in the window: its frequency lies between two of the spectrum.
    let found = measured(60, WIND, |time| vec![straight(DVec3::ZERO, a * (TAU * 5.5 * time).sin() * DVec3::Z)]);
    // Measured 0.016.
    near(found.frequency_hz.unwrap(), 5.5, 0.05);
}

/// Tips a phase apart: their mean stands still, and the correlation of neighbours is the mean cosine of their phases.
#[test]
fn strands_swing_apart() {
    let swing = |phase: f64, time: f64| 0.01 * (TAU * 5.0 * time + phase).sin();
    let rate = |phase: f64, time: f64| TAU * 0.05 * (TAU * 5.0 * time + phase).cos();
    let film = |time: f64| -> Strands {
        ring(12).map(|(phase, root)| straight(root, swing(phase, time) * DVec3::Z)).collect()
    };
    let expected = 0.5 * ((TAU / 12.0).cos() + (TAU / 6.0).cos());
    let found = measured(60, WIND, film);
    near(found.swing_m, 0.01 / 2f64.sqrt(), 1e-8);
    near(found.swing_bundle_m, 0.0, 1e-8);
    near(found.swing_strands_m, 0.01 / 2f64.sqrt(), 1e-8);
    near(found.coherence.unwrap(), expected, 1e-6);
    // The film's own velocities are taken where it has them; here those of another phase, which is that of the
    // neighbours' neighbours.
    let mut measure = Measure::new(MeasureOptions::default());
    for time in (0..60).map(|k| f64::from(k) / RATE) {
        let mut hair = hair(&film(time));
        let tip =
            |(phase, _): (f64, DVec3)| [[0.0; 3]; 4].into_iter().chain([[0.0, 0.0, rate(3.0 * phase, time) as f32]]);
        hair.velocities = ring(12).flat_map(tip).collect();
        measure.add(time, &hair, WIND).unwrap();
    }
    let found = measure.finish().unwrap();
    near(found.coherence.unwrap(), 0.5 * ((TAU / 4.0).cos() + (TAU / 2.0).cos()), 1e-5);
}

/// A wave that travels along strands has its wavelength, whatever its amplitude and wherever it ends; a bow has twice
/// the length.
#[test]
fn waves_have_their_length() {
    // The displacement a sin(k s − ω t) of a strand of any slope: its derivative is the sine of the direction.
    let wave = |slope: f64, waves: f64, time: f64| -> Strands {
        vec![plane(60, |part| (slope * (TAU * (waves * part - 5.0 * time)).cos()).asin())]
    };
    // From the first segment to the last are 59/60 of the length. Measured 0.4 % more, of which segments that are not
    // short take 0.4 %;
    // 0.6 % less where waves are not whole; 0.8 % more for the bow.
    let check = |found: Measurement, waves: f64| {
        let expected = 59.0 / 60.0 * LENGTH / waves;
        near(found.wavelength_m.unwrap(), expected, 0.012 * expected);
    };
    for slope in [0.05, 0.7] {
        check(measured(60, WIND, |time| wave(slope, 3.0, time)), 3.0);
        check(measured(60, WIND, |time| wave(slope, 2.4, time)), 2.4);
    }
    check(still(vec![plane(60, |part| (0.3 * (PI * part).cos()).asin())]), 0.5);
    assert_eq!(still(vec![straight(DVec3::ZERO, DVec3::Z)]).wavelength_m, None);
}

/// An arc turns by its angle, beyond half a circle too; a wave by twice its slope; and the largest is named.
#[test]
fn strands_turn_by_their_angle() {
    for degrees in [0.0, 90.0, 180.0, 360.0, 500.0_f64] {
        let found = still(vec![plane(31, |part| degrees.to_radians() * part)]);
        near(found.turning_mean_degrees, degrees, 0.01);
        near(found.turning_largest_degrees, degrees, 0.01);
    }
    let wave = still(vec![plane(61, |part| 0.4 * (TAU * 3.0 * part).sin())]);
    near(wave.turning_mean_degrees, 0.8f64.to_degrees(), 0.1);
    // The arc of strand 1 is widest in the film's last frame but one.
    let widest = 58.0 / RATE;
    let arc = |time: f64| plane(31, |part| (3.0 - (time - widest).abs()) * part);
    let found = measured(60, WIND, |time| vec![plane(31, |_| 0.0), arc(time), plane(31, |part| part)]);
    assert_eq!(found.turning_strand, 1);
    near(found.turning_time_s, widest, 1e-9);
    near(found.turning_largest_degrees, 3f64.to_degrees(), 0.01);
    let mean = (12..60).map(|k| 4.0 - (f64::from(k) / RATE - widest).abs()).sum::<f64>() / 48.0 / 3.0;
    near(found.turning_mean_degrees, mean.to_degrees(), 0.01);
    // A strand that goes straight back on itself.
    near(still(vec![vec![DVec3::ZERO, DVec3::X, DVec3::ZERO]]).turning_mean_degrees, 180.0, 1e-6);
}

/// A helix has its turns, of either sense and about a bent axis; a curve in a plane has none.
#[test]
fn curls_keep_their_turns() {
    let (segments, turns) = (80, 5.0);
    let spin = |k: usize, sense: f64| sense * TAU * turns * k as f64 / segments as f64;
    let helix = |sense: f64| along((0..segments).map(|k| DVec3::new(spin(k, sense).cos(), -1.0, spin(k, sense).sin())));
    near(still(vec![helix(1.0)]).turns, turns, 1e-4);
    near(still(vec![helix(-1.0)]).turns, turns, 1e-4);
    near(still(vec![helix(1.0), plane(80, |part| part)]).turns, 0.5 * turns, 1e-3);
    near(still(vec![helix(1.0)]).wavelength_m.unwrap(), LENGTH / turns, 0.02 * LENGTH / turns);
    let bent = along((0..segments).map(|k| {
        let bend = 0.5 * PI * k as f64 / segments as f64;
        let (across, axis) = (DVec3::new(bend.cos(), bend.sin(), 0.0), DVec3::new(bend.sin(), -bend.cos(), 0.0));
        axis + spin(k, 1.0).cos() * across + spin(k, 1.0).sin() * DVec3::Z
    }));
    // Measured 0.014.
    near(still(vec![bent]).turns, turns, 0.05);
    for flat in [plane(80, |_| 0.1), plane(80, |part| 6.0 * part), plane(80, |part| (TAU * 4.0 * part).sin())] {
        near(still(vec![flat]).turns, 0.0, 1e-3);
    }
}

/// A bundle that is drawn together by a factor that grows along its strands.
#[test]
fn strands_gather() {
    let gathered = |closer: f64, strands: usize| {
        let roots = ring(strands).map(|(_, root)| root);
        still(roots.map(|root| straight(root, -closer * root)).collect())
    };
    for closer in [0.5, 0.0, -1.0] {
        near(gathered(closer, 30).gathering.unwrap(), 1.0 - 0.8 * closer, 1e-5);
    }
    near(gathered(0.5, 3).gathering.unwrap(), 0.6, 1e-5);
    let lone = gathered(0.5, 1);
    assert_eq!((lone.gathering, lone.coherence, lone.frequency_hz), (None, None, None));
}

/// The four nearest are those of a search through all pairs, however points lie.
#[test]
fn nearest_are_nearest() {
    let mut random = Pcg64::seed_from_u64(7);
    for (count, flat) in [(1, 1.0), (2, 1.0), (5, 1.0), (300, 1.0), (300, 0.0)] {
        let mut part = || random.random_range(-1.0..1.0);
        let points: Vec<_> = (0..count).map(|_| DVec3::new(part(), part() * flat, part() * flat)).collect();
        let found = nearest::nearest(&points);
        let each = 4.min(count - 1);
        assert_eq!(found.len(), each * count);
        for (k, point) in points.iter().enumerate() {
            let others = (0..count).filter(|other| *other != k);
            let mut all: Vec<_> = others.map(|other| (point.distance(points[other]), other)).collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(found[each * k..][..each], all[..each]);
        }
    }
    assert!(nearest::nearest(&[DVec3::ONE; 50]).iter().all(|(distance, _)| *distance == 0.0));
}

/// A bundle that leans, by gravity's direction; and a segment that is longer for one frame.
#[test]
fn strands_lean_and_stretch() {
    let lean = |gravity| {
        let options = MeasureOptions { gravity, ..MeasureOptions::default() };
        let mut measure = Measure::new(options);
        let tip = LENGTH * DVec3::new(0.5, -0.75f64.sqrt(), 0.0);
        for k in 0..9 {
            measure.add(f64::from(k), &hair(&vec![vec![DVec3::ONE, DVec3::ONE + tip]; 3]), WIND).unwrap();
        }
        measure.finish().unwrap().lean_degrees
    };
    near(lean([0.0, -9.81, 0.0]), 30.0, 1e-3);
    near(lean([0.0; 3]), 30.0, 1e-3);
    near(lean([0.0, 0.0, -1.0]), 90.0, 1e-3);
    let longer = |time: f64| if (time - 0.5).abs() < 0.1 / RATE { 0.01 } else { 0.0 };
    let film =
        |time: f64| vec![straight(DVec3::ZERO, DVec3::ZERO), straight(DVec3::X, longer(time) * LENGTH * DVec3::NEG_Y)];
    near(measured(60, WIND, film).stretch, 0.01, 1e-5);
}

/// The window, its defaults, and what is refused.
#[test]
fn windows_are_found_or_refused() {
    let film = |times: &[f64], from, to| {
        let mut measure = Measure::new(MeasureOptions { from, to, ..MeasureOptions::default() });
        let strand = hair(&vec![straight(DVec3::ZERO, DVec3::Z)]);
        times.iter().try_for_each(|time| measure.add(*time, &strand, WIND))?;
        measure.finish().map(|found| (found.frames, found.from_s, found.to_s))
    };
    let times: Vec<_> = (0..101).map(|k| 0.01 * f64::from(k)).collect();
    assert_eq!(film(&times, None, None).unwrap(), (81, times[20], times[100]));
    assert_eq!(film(&times[..40], None, None).unwrap(), (40, 0.0, times[39]));
    assert_eq!(film(&times[..41], None, None).unwrap(), (21, times[20], times[40]));
    assert_eq!(film(&times, Some(0.0), Some(0.5)).unwrap(), (51, 0.0, times[50]));
    let refused = |times: &[f64], from, to, words: &str| {
        let said = film(times, from, to).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    };
    refused(&times[..7], None, None, "has 7 frames from 0 to 0.06 s, expected at least 8");
    refused(
        &times,
        Some(2.0),
        Some(3.0),
        "has 0 frames from 2 to 3 s, expected at least 8; its frames are from 0.000 to 1.000 s",
    );
    refused(&times, Some(0.5), Some(0.5), "expected a window that ends after it starts, found one from 0.5 to 0.5 s");
    refused(&times, Some(f64::NAN), None, "expected a window");
    refused(&[], None, None, "has no frame");
    refused(&[0.0, 0.1, 0.1], None, None, "frame 2: is at 0.1 s, the one before at 0.1 s; expected a later one");
    // A frame that is missing, and frames that come slower from the middle on.
    let gap: Vec<_> = times.iter().copied().filter(|time| (time - 0.5).abs() > 1e-3).collect();
    refused(&gap, None, None, "expected frames at even times");
    let slower: Vec<_> = times.iter().map(|time| time.max(2.0 * time - 0.5)).collect();
    refused(&slower, None, None, "expected frames at even times");
    // Frames of a run are at whole steps, here 3.02 to a frame.
    let steps: Vec<_> = (0..100).map(|k| 1.38e-3 * (f64::from(k) * 3.02).round()).collect();
    assert!(film(&steps, None, None).is_ok());
}

/// Strands that are broken or change are refused.
#[test]
fn other_strands_are_refused() {
    let refused = |hair: &HairFrame, words: &str| {
        let mut measure = Measure::new(MeasureOptions::default());
        measure.add(0.0, &self::hair(&vec![straight(DVec3::ZERO, DVec3::Z)]), WIND).unwrap();
        let said = measure.add(1.0, hair, WIND).unwrap_err().to_string();
        assert!(said.contains("frame 1: ") && said.contains(words), "{said}");
    };
    refused(&HairFrame::default(), "has no strands");
    refused(&hair(&vec![straight(DVec3::ZERO, DVec3::Z); 2]), "has other strands than the first");
    let mut broken = hair(&vec![straight(DVec3::ZERO, DVec3::Z)]);
    broken.positions[3][1] = f32::NAN;
    refused(&broken, "point 3 is not finite");
    let short = HairFrame { velocities: vec![[0.0; 3]; 4], ..hair(&vec![straight(DVec3::ZERO, DVec3::Z)]) };
    refused(&short, "has 4 velocities, expected 5 or none");
}

/// A film's file is measured as its frames are, and what is no film of hair is refused by its name.
#[cfg(feature = "vtkhdf")]
#[test]
fn files_are_measured() {
    use crate::{Kind, Provenance, VtkHdfWriter};
    use windswept_engine::{AirFrame, Frame};

    let folder = tempfile::tempdir().unwrap();
    let provenance = Provenance { scene: "", version: "", adapter: "", seed: 1 };
    let frame = |k: usize| {
        let time = k as f64 / RATE;
        let strands: Strands =
            ring(6).map(|(phase, root)| straight(root, 0.01 * (9.0 * time + phase).sin() * DVec3::Z)).collect();
        let hair = hair(&strands);
        let orientations = vec![[0.0, 0.0, 0.0, 1.0]; 24];
        let hair = HairFrame { velocities: hair.positions.clone(), orientations, ..hair };
        Frame {
            time,
            hair,
            air: AirFrame { positions: vec![[0.0; 3]], velocities: vec![[0.0; 3]], ..AirFrame::default() },
            ..Frame::default()
        }
    };
    let write = |kind: Kind| {
        let path = folder.path().join(kind.file_name());
        let mut writer = VtkHdfWriter::create(&path, kind, &frame(0), 60, &provenance).unwrap();
        (0..60).for_each(|k| writer.append(&frame(k)).unwrap());
        writer.finish().unwrap();
        path
    };
    let options = MeasureOptions { from: Some(0.3), to: Some(0.8), ..MeasureOptions::default() };
    let mut measure = Measure::new(options);
    for k in 0..60 {
        let frame = frame(k);
        measure.add(frame.time, &frame.hair, [frame.time, 1.0, 0.0]).unwrap();
    }
    let film = write(Kind::Hair);
    assert_eq!(measure_film(&film, &options, |time| [time, 1.0, 0.0]).unwrap(), measure.finish().unwrap());
    let said = |path: &std::path::Path, options| measure_film(path, options, |_| WIND).unwrap_err().to_string();
    assert!(said(&write(Kind::Air), &options).contains("air.vtkhdf: expected Hair, found Air"));
    let missing = folder.path().join("missing.vtkhdf");
    assert!(said(&missing, &options).contains("missing.vtkhdf: could not be read: No such file"));
    let outside = MeasureOptions { from: Some(5.0), to: Some(6.0), ..options };
    assert!(said(&film, &outside).contains("hair.vtkhdf: has 0 frames from 5 to 6 s"));
}

/// A table has a line for each number, and a dash for one without meaning.
#[test]
fn numbers_are_shown() {
    let found = still(vec![straight(DVec3::ZERO, DVec3::ZERO)]);
    let table = found.to_string();
    assert!(table.starts_with("1 strands, 48 frames from 0.200 to 0.983 s\nswing "), "{table}");
    assert!(table.contains("\ngathering                -"), "{table}");
    assert!(table.lines().count() == 14 && !table.contains("NaN"), "{table}");
}
