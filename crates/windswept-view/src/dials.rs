//! Values of a scene that are changed by sliders while it runs.

use std::ops::RangeInclusive;

use glam::DVec3;
use windswept::{CheckedScene, Gust, Scene};
use windswept_scene::{CheckedAir, Hair, Stiffness};

/// A slider.
pub(crate) struct Dial {
    pub(crate) group: Group,
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) ends: RangeInclusive<f64>,
    pub(crate) logarithmic: bool,
    /// The value in a scene, where the scene has what it belongs to; the second scene is the one that was opened.
    pub(crate) get: fn(&CheckedScene, &Scene) -> Option<f64>,
    /// Sets the value in a scene that [`Self::get`] finds it in.
    pub(crate) set: fn(&mut Scene, &Scene, f64),
}

/// The part of a scene that a slider belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    Eddies,
    Hair,
}

/// Gravity of a scene that has none, where its slider is pulled \[m/s²\].
const DOWN: DVec3 = DVec3::NEG_Y;

/// All sliders, but for the direction of the wind.
pub(crate) const DIALS: &[Dial] = &[
    Dial {
        group: Group::Eddies,
        name: "scale",
        unit: "mm",
        ends: 3.0..=40.0,
        logarithmic: true,
        get: |scene, _| scene.turbulence.bands.first().map(|band| 1e3 * band.scale),
        set: |scene, _, value| match scene.turbulence.bands.first_mut() {
            Some(band) => band.scale = 1e-3 * value,
            None => scene.turbulence.scale = Some(1e-3 * value),
        },
    },
    Dial {
        group: Group::Eddies,
        name: "intensity",
        unit: "",
        ends: 0.05..=3.0,
        logarithmic: false,
        get: |scene, _| scene.turbulence.bands.first().map(|band| band.intensity),
        set: |scene, _, value| match scene.turbulence.bands.first_mut() {
            Some(band) => band.intensity = value,
            None => scene.turbulence.intensity = Some(value),
        },
    },
    Dial {
        group: Group::Hair,
        name: "viscosity",
        unit: "",
        ends: 0.0..=3.0,
        logarithmic: false,
        get: |scene, _| scene.interaction.model.has_air().then_some(scene.viscosity.hair),
        set: |scene, _, value| (scene.viscosity.hair, scene.viscosity.kinematic_hair) = (Some(value), None),
    },
    Dial {
        group: Group::Hair,
        name: "friction",
        unit: "",
        ends: 0.0..=1.0,
        logarithmic: false,
        get: |scene, _| {
            let first = scene.hair.first().map(|hair| hair.friction);
            first.filter(|_| scene.why_no_friction().is_none())
        },
        set: |scene, _, value| scene.hair.iter_mut().for_each(|hair| hair.friction = value),
    },
    Dial {
        group: Group::Hair,
        name: "stiffness",
        unit: "×",
        ends: 0.05..=20.0,
        logarithmic: true,
        get: |scene, opened| Some(bend(scene.hair.first()?) / bend(opened.hair.first()?)),
        set: |scene, opened, value| {
            for (hair, opened) in scene.hair.iter_mut().zip(&opened.hair) {
                hair.fibre.stiffness = stiffer(opened.fibre.stiffness, value);
            }
        },
    },
    Dial {
        group: Group::Hair,
        name: "gravity",
        unit: "m/s²",
        ends: 0.0..=20.0,
        logarithmic: false,
        get: |scene, _| Some(DVec3::from_array(scene.gravity).length()),
        set: |scene, opened, value| {
            let down = DVec3::from_array(opened.gravity).try_normalize().unwrap_or(DOWN);
            scene.gravity = (value * down).to_array();
        },
    },
];

/// Stiffness to bend of a group, in a unit of its own.
fn bend(hair: &Hair) -> f64 {
    match hair.fibre.stiffness {
        Stiffness::Moduli(moduli) => moduli.youngs_modulus,
        Stiffness::Direct(direct) => direct.bend,
    }
}

/// The stiffness to bend and twist times a factor; of moduli the stiffness to stretch changes too.
fn stiffer(stiffness: Stiffness, times: f64) -> Stiffness {
    match stiffness {
        Stiffness::Moduli(mut moduli) => {
            moduli.youngs_modulus *= times;
            Stiffness::Moduli(moduli)
        }
        Stiffness::Direct(mut direct) => {
            (direct.bend, direct.twist) = (times * direct.bend, times * direct.twist);
            Stiffness::Direct(direct)
        }
    }
}

/// Parts of a m/s that a wind is rounded to.
const FINEST: f64 = 1e9;

/// The mean wind as sliders have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wind {
    /// Speed \[m/s\].
    pub(crate) speed: f64,
    /// Where it blows to: the angle from +x toward +z \[°\].
    pub(crate) azimuth: f64,
    /// Angle above the horizon \[°\].
    pub(crate) elevation: f64,
}

impl Wind {
    /// Fastest wind of the slider \[m/s\].
    pub(crate) const FASTEST: f64 = 15.0;

    /// The wind of a scene with air.
    pub(crate) fn of(scene: &CheckedScene) -> Option<Self> {
        Some(Self::from(DVec3::from_array(scene.air.as_ref()?.wind)))
    }

    /// The wind as a vector \[m/s\].
    pub(crate) fn velocity(&self) -> DVec3 {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let toward = DVec3::new(azimuth.cos() * elevation.cos(), elevation.sin(), azimuth.sin() * elevation.cos());
        // Along an axis the others are zero, and no rest of rounding.
        (self.speed * toward * FINEST).round() / FINEST
    }

    /// Sets it as the mean wind of a scene with air.
    pub(crate) fn set(velocity: DVec3, scene: &mut Scene) {
        if let Some(air) = &mut scene.air {
            air.wind = Some(velocity.to_array());
        }
    }
}

impl From<DVec3> for Wind {
    fn from(velocity: DVec3) -> Self {
        let speed = velocity.length();
        let elevation = if speed > 0.0 { (velocity.y / speed).clamp(-1.0, 1.0).asin() } else { 0.0 };
        let azimuth = velocity.z.atan2(velocity.x);
        Self { speed, azimuth: azimuth.to_degrees(), elevation: elevation.to_degrees() }
    }
}

/// A gust that begins at once: time from its begin \[s\] and part of its velocity.
const PULSE: [(f64, f64); 4] = [(0.0, 0.0), (0.05, 1.0), (0.15, 1.0), (0.35, 0.0)];

/// The scene with a gust of this velocity \[m/s\] beside its own, from `now` \[s\] on; `None` where it has no air.
pub(crate) fn with_gust(scene: &CheckedScene, now: f64, velocity: DVec3) -> Option<Scene> {
    let own = scene.air.as_ref()?;
    let gust = PULSE.map(|(time, part)| Gust { time: now + time, velocity: (part * velocity).to_array() }).to_vec();
    let mut times: Vec<f64> = own.gust.iter().chain(&gust).map(|gust| gust.time).filter(|time| *time >= now).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let pulse = CheckedAir { gust, ..own.clone() };
    let at = |time| (DVec3::from_array(own.gust_at(time)) + DVec3::from_array(pulse.gust_at(time))).to_array();
    let mut scene = scene.scene().clone();
    scene.air.as_mut()?.gust = times.into_iter().map(|time| Gust { time, velocity: at(time) }).collect();
    Some(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quick() -> Scene {
        Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes/quick.toml")).unwrap()
    }

    /// Each slider of a scene finds the value that it has set, in a scene that a simulation can go on with, and no
    /// other slider moves.
    #[test]
    fn dials_change_what_they_show() {
        let opened = quick();
        let values = |scene: &Scene| {
            let checked = scene.check().unwrap();
            DIALS.iter().map(|dial| (dial.get)(&checked, &opened)).collect::<Vec<_>>()
        };
        let before = values(&opened);
        for (k, dial) in DIALS.iter().enumerate() {
            let mut scene = opened.clone();
            let value = 0.3 * dial.ends.start() + 0.7 * dial.ends.end();
            (dial.set)(&mut scene, &opened, value);
            let after = values(&scene);
            for (i, (before, after)) in before.iter().zip(&after).enumerate() {
                let expected = if i == k { Some(value) } else { *before };
                let [after, expected] = [*after, expected].map(Option::unwrap);
                assert!(
                    (after - expected).abs() < 1e-9 * expected.abs().max(1.0),
                    "{}: {after}, {expected}",
                    dial.name
                );
            }
            let changed = opened.check().unwrap().scene().changed(&scene);
            assert!(!changed.is_empty() && changed.iter().all(|key| !windswept_scene::is_fixed(key)), "{changed:?}");
        }
    }

    /// Scenes without air or eddies have no such sliders.
    #[test]
    fn dials_are_those_of_the_scene() {
        let mut scene = quick();
        scene.turbulence = windswept::Turbulence::default();
        scene.interaction.model = Some(windswept::Model::Drag);
        let checked = scene.check().unwrap();
        let there: Vec<&str> =
            DIALS.iter().filter(|dial| (dial.get)(&checked, &scene).is_some()).map(|dial| dial.name).collect();
        assert_eq!(there, ["stiffness", "gravity"]);
    }

    /// Speed and angles give back the wind that they were of.
    #[test]
    fn the_wind_goes_there_and_back() {
        for wind in [DVec3::new(3.0, 0.0, 0.0), DVec3::new(-1.0, 2.0, -0.5), DVec3::new(0.0, -2.0, 0.0), DVec3::ZERO] {
            assert!(Wind::from(wind).velocity().distance(wind) < 1e-12, "{wind}");
        }
        assert_eq!(Wind::from(DVec3::new(0.0, 0.0, 2.0)), Wind { speed: 2.0, azimuth: 90.0, elevation: 0.0 });
    }

    /// A gust begins now, is over after a while, and is added to what the scene has; twice at the same time adds up.
    #[test]
    fn a_gust_is_added() {
        let velocity = DVec3::new(2.0, 0.0, 0.0);
        let mut scene = quick();
        scene.air.as_mut().unwrap().gust =
            vec![Gust { time: 0.0, velocity: [0.0; 3] }, Gust { time: 1.0, velocity: [0.0, 1.0, 0.0] }];
        let gust_at =
            |scene: &Scene, time: f64| DVec3::from_array(scene.check().unwrap().air.as_ref().unwrap().gust_at(time));
        let own = gust_at(&scene, 0.6);
        scene = with_gust(&scene.check().unwrap(), 0.5, velocity).unwrap();
        assert!(gust_at(&scene, 0.6).distance(own + velocity) < 1e-12, "{}", gust_at(&scene, 0.6));
        assert!(gust_at(&scene, 0.9).distance(DVec3::new(0.0, 0.9, 0.0)) < 1e-12, "{}", gust_at(&scene, 0.9));
        scene = with_gust(&scene.check().unwrap(), 0.5, velocity).unwrap();
        assert!(gust_at(&scene, 0.6).distance(own + 2.0 * velocity) < 1e-12);
    }
}
