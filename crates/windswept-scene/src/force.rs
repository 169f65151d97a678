//! Force fields: `[[force]]`. A field is a wind of its own within its reach.

use glam::DVec3;

use crate::{
    declare::{table, words},
    faults::At,
    keys::{
        Fallback::{Derived, Required, RequiredIf, Value},
        Kind::{Choice, Direction, Length, NonNegative, Number, Tables, Text, Vector},
    },
    scene::{CheckedAir, Model, Scene, SceneValues},
    wind::check_speed,
};

words! {
    /// `force.field`: the shape of a field's wind.
    pub enum ForceField {
        /// Wind along the axis, in a cylinder that begins at the origin.
        Jet = "jet",
        /// Wind about the axis, which is a line through the origin.
        Vortex = "vortex",
        /// Wind away from the origin, or towards it where the strength is negative.
        Point = "point",
    }
}

table! {
    /// One `[[force]]`: a wind u that is added to the mean wind U, with a weight w that falls smoothly from 1 to 0.
    ///
    /// Air particles are drawn to U + u at the rate w S/uptake, S the strength's magnitude. Hair is dragged by U + u
    /// where there are no air particles.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Force => CheckedForce, checked by Force::check {
        /// Name of the field, for dotted keys and errors.
        name: String = Text, "", Value("force".to_owned());
        /// Shape of the field's wind: along the axis, about it, or away from the origin.
        field: ForceField = Choice(ForceField::WORDS), "", Required;
        /// Point where a jet begins, through which a vortex's axis goes, or from which a point blows.
        origin: [f64; 3] = Vector, "m", Required;
        /// Direction of a jet, or axis that a vortex turns about, right-handed.
        axis: Option<[f64; 3]> = Direction, "", RequiredIf("with fields jet and vortex");
        /// Distance at which the field ends: along a jet, from a vortex's axis, from a point; from half of it on it
        /// fades.
        reach: f64 = Length, "m", Required;
        /// Radius of a jet, which fades from half of it on; or distance at which a vortex or a point blows with its
        /// strength: inside it is slower in proportion to the distance. At most half of reach with a vortex or a point.
        radius: f64 = Length, "m", Derived("a quarter of reach") => value(|_scene| 0.25 * reach);
        /// Way over which air takes the field's wind up, at the strength's speed.
        uptake: f64 = Length, "m", Derived("radius") => value(|_scene| radius);
        /// Largest speed of the field's wind; negative turns it round.
        strength: Option<f64> = Number, "m/s", RequiredIf("without keyframes");
        /// Keyframes of the strength, in place of a steady one: linear between them, held before and after.
        keyframes: Vec<Strength> = Tables, "", Derived("a steady strength");
    }
}

table! {
    /// One of `[[force.keyframes]]`: linear between two, held before the first and after the last.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Strength {
        /// Time of the keyframe; each is later than the one before.
        time: f64 = NonNegative, "s", Required;
        /// Strength at that time.
        strength: f64 = Number, "m/s", Required;
    }
}

/// Times \[s\], rising, and the strength \[m/s\] at each: of a steady one, or of keyframes.
fn strengths(steady: Option<f64>, keyframes: &[Strength]) -> Vec<(f64, f64)> {
    match steady {
        Some(steady) => vec![(0.0, steady)],
        None => keyframes.iter().map(|key| (key.time, key.strength)).collect(),
    }
}

/// Largest magnitude of a strength \[m/s\], steady or by keyframes.
pub(crate) fn fastest(steady: Option<f64>, keyframes: &[Strength]) -> f64 {
    strengths(steady, keyframes).iter().map(|(_, strength)| strength.abs()).fold(0.0, f64::max)
}

impl Force {
    /// A jet named `force` that begins at `origin` and blows along `axis` as far as `reach` \[m\], with a strength
    /// \[m/s\].
    #[must_use]
    pub fn jet(origin: [f64; 3], axis: [f64; 3], reach: f64, strength: f64) -> Self {
        Self { axis: Some(axis), ..Self::of(ForceField::Jet, origin, reach, strength) }
    }

    /// A vortex named `force` about the `axis` through `origin`, which ends `reach` \[m\] from it, with a strength
    /// \[m/s\].
    #[must_use]
    pub fn vortex(origin: [f64; 3], axis: [f64; 3], reach: f64, strength: f64) -> Self {
        Self { axis: Some(axis), ..Self::of(ForceField::Vortex, origin, reach, strength) }
    }

    /// Wind named `force` away from `origin`, as far as `reach` \[m\], with a strength \[m/s\]; negative draws in.
    #[must_use]
    pub fn point(origin: [f64; 3], reach: f64, strength: f64) -> Self {
        Self::of(ForceField::Point, origin, reach, strength)
    }

    fn of(field: ForceField, origin: [f64; 3], reach: f64, strength: f64) -> Self {
        let (axis, radius, uptake, keyframes) = (None, None, None, Vec::new());
        Self {
            name: "force".to_owned(),
            field,
            origin,
            axis,
            reach,
            radius,
            uptake,
            strength: Some(strength),
            keyframes,
        }
    }

    fn check(&self, checked: &mut CheckedForce, _: &Scene, at: &At<'_>) {
        let word = self.field.word();
        match (self.field, self.axis) {
            (ForceField::Point, Some(_)) => {
                at.fault("axis", format!("expected no axis with field \"{word}\", which has none"));
            }
            (ForceField::Jet | ForceField::Vortex, None) => {
                at.fault("axis", format!("is missing: field \"{word}\" has one, [x, y, z]"));
            }
            _ => {}
        }
        if self.field != ForceField::Jet && checked.radius > 0.5 * self.reach {
            let words = format!("expected at most half of reach, {} m, with field \"{word}\"", 0.5 * self.reach);
            at.fault("radius", format!("{words}; found {}", checked.radius));
        }
        match (self.strength, self.keyframes.is_empty()) {
            (None, true) => at.fault("strength", "is missing: expected a number [m/s], or keyframes"),
            (Some(_), false) => at.fault("strength", "expected none beside keyframes, which stand in its place"),
            _ => {}
        }
        check_speed(at, "strength", self.strength.unwrap_or_default());
        for (i, key) in self.keyframes.iter().enumerate() {
            check_speed(at, &format!("keyframes.{i}.strength"), key.strength);
        }
        at.rising("keyframes", self.keyframes.iter().map(|key| key.time));
    }
}

impl CheckedForce {
    /// Times \[s\], rising, and the strength \[m/s\] at each: linear in between, held before the first and after the
    /// last.
    #[must_use]
    pub fn strengths(&self) -> Vec<(f64, f64)> {
        strengths(self.strength, &self.keyframes)
    }

    /// Largest speed of the field's wind in the whole run \[m/s\].
    #[must_use]
    pub fn fastest(&self) -> f64 {
        fastest(self.strength, &self.keyframes)
    }

    /// Whether the field may blow somewhere in a box of these corners \[m\]. A jet counts as round at its ends.
    pub(crate) fn reaches(&self, [low, high]: [DVec3; 2]) -> bool {
        let origin = DVec3::from_array(self.origin);
        if low.cmpgt(high).any() || !(low.is_finite() && high.is_finite()) {
            return low.cmple(high).all();
        }
        let off = |along: f64| {
            let x = origin + along * self.axis();
            x.distance(x.clamp(low, high))
        };
        match self.field {
            ForceField::Point => off(0.0) <= self.reach,
            ForceField::Jet => least(off, 0.0, self.reach) <= self.radius,
            ForceField::Vortex => {
                let (middle, half) = ((0.5 * (low + high) - origin).dot(self.axis()), 0.5 * low.distance(high));
                least(off, middle - half, middle + half) <= self.reach
            }
        }
    }

    /// Direction of the axis; of a point any, as it has none.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        self.axis.map_or(DVec3::Y, DVec3::from_array)
    }
}

/// The least value of a convex function from `low` to `high`, to within a millionth of the way.
fn least(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..35 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if f(a) < f(b) { high = b } else { low = a }
    }
    f(0.5 * (low + high))
}

impl SceneValues {
    /// Largest speed that the mean wind and the strongest force field have together \[m/s\].
    #[must_use]
    pub fn largest_wind(&self) -> f64 {
        self.air.as_ref().map_or(0.0, CheckedAir::largest_wind)
            + self.forces.iter().map(CheckedForce::fastest).fold(0.0, f64::max)
    }

    /// Reason why force fields do nothing in this scene; `None` where they act.
    #[must_use]
    pub fn why_no_fields(&self) -> Option<&'static str> {
        if self.interaction.model == Model::None {
            Some("interaction.model is none: hair alone")
        } else if self.forces.is_empty() {
            Some("the scene has no [[force]]")
        } else if self.forces.iter().all(|force| force.fastest() == 0.0) {
            Some("every force.strength is 0")
        } else {
            None
        }
    }
}
