//! Scenes that several checks are of.

use windswept_scene::{Air, Hair, Model, Scene, Time};

/// Hair alone, in steps of `step` \[s\].
pub fn alone(step: f64, hair: impl Into<Vec<Hair>>) -> Scene {
    let mut scene = Scene::new(Time::new(step, 10.0));
    scene.interaction.model = Some(Model::None);
    scene.hair = hair.into();
    scene
}

/// Hair that the mean wind drags, in steps of `step` \[s\].
pub fn in_wind(step: f64, air: Air, hair: impl Into<Vec<Hair>>) -> Scene {
    let mut scene = alone(step, hair);
    scene.interaction.model = Some(Model::Drag);
    scene.air = Some(air);
    scene
}

/// Hair without weight, awake, that exchanges drag with particles of this air, in steps of `step` \[s\].
pub(crate) fn afloat(step: f64, air: Air, hair: impl Into<Vec<Hair>>) -> Scene {
    let mut scene = alone(step, hair);
    scene.interaction.model = Some(Model::TwoWay);
    scene.gravity = [0.0; 3];
    scene.rods.sleep = false;
    scene.air = Some(air);
    scene
}

/// Air that fills a box from the origin to `size` \[m\], in a wind that blows at once \[m/s\].
pub(crate) fn blowing(size: [f64; 3], wind: [f64; 3]) -> Air {
    Air { ramp: 0.0, ..Air::filling(size).wind(wind) }
}

/// Air without wind, and so without a fringe, that fills a box from the origin to `size` \[m\].
pub(crate) fn still(size: [f64; 3]) -> Air {
    blowing(size, [0.0; 3])
}
