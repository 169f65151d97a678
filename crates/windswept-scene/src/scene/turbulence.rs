//! `[turbulence]`: vorticity confinement.

use glam::DVec3;

use crate::{
    declare::{table, variants, words},
    faults::At,
    force::{self, ForceField},
    keys::{
        Fallback::{self, Derived, Required, Value},
        Kind::{Bool, Choice, Length, NonNegative, Positive, Table, Tables},
    },
    limits::COARSEST_SPACING,
    scene::{Method, Scene, SceneValues},
    wind,
};

table! {
    /// `[turbulence]`: vorticity confinement.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Turbulence => CheckedTurbulence, with defaults, checked by Turbulence::check {
        /// Bands of eddies to strengthen, instead of `scale`; each has a scale and an intensity of its own, and none
        /// enters with the wind.
        bands: Vec<Band> = Tables, "", Derived("the band of scale and intensity");
        /// Speed U of the law.
        speed: f64 = NonNegative, "m/s", Derived("the largest wind, those of jets and vortices included") => value(|scene| largest_wind(scene));
        /// Confinement law.
        law: Law = Choice(Law::WORDS), "", Fallback::Method(Law::Band, Law::Published) => method;
        /// Filter that finds the band velocity; law published takes direct only.
        filter as "": Filter = Table, "", Derived("") => value(|scene| Filter::without_word(scene.method, law));
        /// Whether the mean change of the air is taken out, so that confinement drives no wind.
        conserve_momentum: bool = Bool, "", Derived("true with law band, false with published") => value(|_scene| law == Law::Band);
    }
    and before the check {
        /// How large eddies are: s of eq. 6. A whirl of the band measures about 2 s across.
        scale: Option<f64> = Length, "m", Derived("no turbulence, unless there are bands");
        /// How wild eddies are: the rms speed of their band over the wind's (turbulence.speed).
        intensity: Option<f64> = Positive, "", Derived("0.6 with scale");
        /// Whether eddies of scale and intensity also enter with the wind; otherwise hair and bodies alone make them.
        inflow: Option<bool> = Bool, "", Derived("true with scale, but false with method published");
    }
}

variants! {
    /// Filter that finds the velocity of a band; the published law takes the direct one only.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum Filter by "filter" = Fallback::Method("grid", "direct"), "Filter that finds the band velocity; law published takes direct only." {
        /// Three Gaussian passes on a grid.
        Grid(GridFilter) = "grid",
        /// The sum of eq. 5.
        Direct(DirectFilter) = "direct",
    }
}

table! {
    /// `turbulence.filter = "grid"`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct GridFilter, with defaults {
        /// Spacing of the grid filter's nodes in units of the scale, at most 1; never more than a kernel radius.
        spacing: f64 = Positive, "", Value(0.65);
    }
}

table! {
    /// `turbulence.filter = "direct"`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct DirectFilter, with defaults {
        /// Cutoff of the direct filter in units of the scale.
        cutoff: f64 = Positive, "", Fallback::Method(4.5, Filter::PUBLISHED_CUTOFF);
    }
}

table! {
    /// One of `turbulence.bands`.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Band {
        /// Scale of the eddies to strengthen: s of the Mexican hat.
        scale: f64 = Length, "m", Required;
        /// Strength S of the band law, by which eddies come to their intensity sooner; the published law has a strength
        /// of its own. 0 leaves the band out.
        strength: f64 = NonNegative, "", Value(Band::STRENGTH);
        /// Intensity I: the rms speed of the band over turbulence.speed. The band law strengthens no faster eddies, and
        /// none that pass a kernel radius in a substep.
        intensity: f64 = Positive, "", Value(Band::INTENSITY);
    }
}

words! {
    /// `turbulence.law`.
    pub enum Law {
        /// Vorticity of the band, self-limiting.
        Band = "band",
        /// Eqs. 2-6 as printed.
        Published = "published",
    }
}

/// Largest speed of the mean wind and of the force fields that air can follow \[m/s\]: not of a point's, which would
/// compress it.
fn largest_wind(scene: &Scene) -> f64 {
    let Some(air) = &scene.air else { return 0.0 };
    let fields = scene.forces.iter().filter(|force| force.field != ForceField::Point);
    let fastest = fields.map(|force| force::fastest(force.strength, &force.keyframes)).fold(0.0, f64::max);
    wind::largest(air.wind.unwrap_or_default(), &air.gust) + fastest
}

impl Default for Filter {
    fn default() -> Self {
        Self::Grid(GridFilter::default())
    }
}

impl Filter {
    /// Whether bands are filtered on a grid.
    #[must_use]
    pub fn is_grid(self) -> bool {
        matches!(self, Self::Grid(_))
    }

    /// Cutoff of the published method's direct filter, where a scene does not say it, in units of the scale.
    pub(crate) const PUBLISHED_CUTOFF: f64 = 3.0;

    /// The filter of a scene that names none: the published law knows the direct one only.
    fn without_word(method: Method, law: Law) -> Self {
        match (method, law) {
            (Method::Published, _) => Self::Direct(DirectFilter { cutoff: Self::PUBLISHED_CUTOFF }),
            (_, Law::Published) => Self::Direct(DirectFilter::default()),
            _ => Self::default(),
        }
    }
}

impl Band {
    /// `strength` where a scene does not say it.
    pub const STRENGTH: f64 = 6.0;
    /// `intensity` where a scene does not say it.
    pub const INTENSITY: f64 = 0.6;
}

impl Turbulence {
    /// Eddies of this scale s \[m\], of the default intensity, which also enter with the wind.
    #[must_use]
    pub fn scale(scale: f64) -> Self {
        Self { scale: Some(scale), ..Self::default() }
    }

    /// The band of `scale` and `intensity`.
    pub(crate) fn band(&self) -> Option<Band> {
        let intensity = self.intensity.unwrap_or(Band::INTENSITY);
        self.scale.map(|scale| Band { scale, strength: Band::STRENGTH, intensity })
    }

    fn check(&self, checked: &mut CheckedTurbulence, _: &Scene, at: &At<'_>) {
        if self.scale.is_some() && !self.bands.is_empty() {
            at.fault("scale", "turbulence.bands is given too: expected one of them; --set 'turbulence={ bands = [...] }' replaces both");
        }
        for (key, said) in [("intensity", self.intensity.is_some()), ("inflow", self.inflow.is_some())] {
            if said && self.scale.is_none() {
                at.fault(key, "expected turbulence.scale with it: bands have an intensity each, and no inflow");
            }
        }
        checked.bands.extend(self.band());
        if let Filter::Grid(GridFilter { spacing }) = checked.filter {
            if checked.law == Law::Published {
                at.fault(
                    "filter",
                    "expected \"direct\" with turbulence.law = \"published\", which sums hair too, without volumes",
                );
            }
            if spacing > COARSEST_SPACING {
                at.fault("spacing", format!("expected at most {COARSEST_SPACING} scales, found {spacing}"));
            }
        }
    }
}

impl SceneValues {
    /// Speed beyond which the band law does not strengthen a band's eddies in a step of `substeps` substeps \[m/s\]: I
    /// U, and at most a kernel radius in a substep, beyond which steps do not resolve them; 0 without air.
    #[must_use]
    pub fn largest_eddy_speed(&self, band: &Band, substeps: u32) -> f64 {
        let radius = self.air.as_ref().map_or(0.0, |air| air.kernel_radius);
        let resolved = radius * f64::from(substeps) / self.time.step;
        (band.intensity * self.turbulence.speed).min(resolved)
    }

    /// Refuses bands whose filter would take too much memory or time ([`CheckedTurbulence::excess`]).
    pub(super) fn check_bands(&self, written: &Scene, at: &At<'_>) {
        let Some((air, bounds)) = self.filled() else { return };
        let size = DVec3::from_array(bounds.max) - DVec3::from_array(bounds.min);
        let particles = size.element_product() / air.particle_volume();
        for (i, band) in self.turbulence.bands.iter().enumerate() {
            if let Some(excess) = self.turbulence.excess(band.scale, air.kernel_radius, particles, size) {
                let spelled = if written.turbulence.scale.is_some() { "" } else { &format!("bands.{i}.") };
                at.fault(&format!("turbulence.{spelled}scale"), format!("{}; {}", excess.what, excess.expected));
            }
        }
    }
}
