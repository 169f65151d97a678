//! `[turbulence]`: vorticity confinement.

use glam::DVec3;

use crate::{
    declare::{Keys, table, words},
    error::SceneError,
    force::{Force, ForceField},
    keys::{
        Fallback::{Derived, Method, Required, Value},
        Kind::{Bool, Choice, Length, NonNegative, Positive, Tables},
    },
    limits::COARSEST_SPACING,
    reader::Reader,
    scene::{Air, Scene},
};

table! {
    /// `[turbulence]`: vorticity confinement.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Turbulence, checked by Turbulence::checked {
        /// Bands of eddies to strengthen, instead of `scale`; each has a scale and an intensity of its own, and none
        /// enters with the wind.
        bands: Vec<Band> = Tables, "", Derived("the band of scale and intensity");
        /// Speed U of the law.
        speed: f64 = NonNegative, "m/s", Derived("the largest wind, those of jets and vortices included") => |turbulence| largest_wind(turbulence)?;
        /// Confinement law.
        law: Law = Choice(Law::WORDS), "", Method(Law::Band, Law::Published);
        /// Filter that finds the band velocity; law published takes direct only.
        filter: Filter = Choice(Filter::WORDS), "", Method(Filter::Grid, Filter::Direct);
        /// Spacing of the grid filter's nodes in units of the scale, at most 1; never more than a kernel radius.
        spacing: f64 = Positive, "", Value(Turbulence::SPACING);
        /// Cutoff of the direct filter in units of the scale.
        cutoff: f64 = Positive, "", Method(Turbulence::CUTOFF, 3.0);
        /// Whether the mean change of the air is taken out, so that confinement drives no wind.
        conserve_momentum: bool = Bool, "", Derived("true with law band, false with published") => |_turbulence| law == Law::Band;
    }
    without a field {
        /// How large eddies are: s of eq. 6. A whirl of the band measures about 2 s across.
        scale: f64 = Length, "m", Derived("no turbulence, unless there are bands");
        /// How wild eddies are: the rms speed of their band over the wind's (turbulence.speed).
        intensity: f64 = Positive, "", Derived("0.6 with scale");
        /// Whether eddies of scale and intensity also enter with the wind; otherwise hair and bodies alone make them.
        inflow: bool = Bool, "", Derived("true with scale, but false with method published");
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

words! {
    /// `turbulence.filter`.
    pub enum Filter {
        /// Three Gaussian passes on a grid.
        Grid = "grid",
        /// The sum of eq. 5.
        Direct = "direct",
    }
}

/// Largest speed of the mean wind and of the force fields that air can follow \[m/s\]: not of a point's, which would
/// compress it.
fn largest_wind(reader: &Reader<'_>) -> Result<f64, SceneError> {
    let root = reader.root();
    if !root.has("air") {
        return Ok(0.0);
    }
    let forces = root.tables("force").map(|table| Force::read(&table)).collect::<Result<Vec<_>, _>>()?;
    let fields = forces.iter().filter(|force| force.field != ForceField::Point);
    Ok(root.read::<Air>("air")?.largest_wind() + fields.map(Force::fastest).fold(0.0, f64::max))
}

impl Band {
    /// `strength` where a scene does not say it.
    pub const STRENGTH: f64 = 6.0;
    /// `intensity` where a scene does not say it.
    pub const INTENSITY: f64 = 0.6;

    /// The band of `turbulence.scale` and `turbulence.intensity`.
    pub(crate) fn of_dials(turbulence: &Reader<'_>) -> Option<Self> {
        let scale = turbulence.said("scale")?;
        let intensity = turbulence.said("intensity").unwrap_or(Self::INTENSITY);
        Some(Self { scale, strength: Self::STRENGTH, intensity })
    }
}

impl Turbulence {
    /// Spacing of the grid filter's nodes, where a scene does not say it, in units of the scale.
    pub const SPACING: f64 = 0.65;
    /// Cutoff of the accurate method's direct filter, where a scene does not say it, in units of the scale.
    pub const CUTOFF: f64 = 4.5;

    fn checked(mut self, reader: &Reader<'_>) -> Result<Self, SceneError> {
        self.read_dials(reader)?;
        // The published law knows no other.
        if self.law == Law::Published && !reader.has("filter") {
            self.filter = Filter::Direct;
        }
        if self.filter == Filter::Grid && self.law == Law::Published {
            let words = "expected \"direct\" with turbulence.law = \"published\", which sums hair too, without volumes";
            return Err(reader.fault("filter", words));
        }
        if self.spacing > COARSEST_SPACING {
            let words = format!("expected at most {COARSEST_SPACING} scales, found {}", self.spacing);
            return Err(reader.fault("spacing", words));
        }
        Ok(self)
    }
}

impl Turbulence {
    /// `scale` and `intensity` are one band, which goes with no others.
    fn read_dials(&mut self, reader: &Reader<'_>) -> Result<(), SceneError> {
        let dial = ["scale", "intensity", "inflow"].into_iter().find(|dial| reader.has(dial));
        match (dial, Band::of_dials(reader)) {
            (Some("scale"), _) if reader.has("bands") => {
                Err(reader.fault("scale", "turbulence.bands is given too: expected one of them; --set 'turbulence={ bands = [...] }' replaces both"))
            }
            (Some("scale") | None, band) => {
                self.bands.extend(band);
                Ok(())
            }
            (Some(dial), _) => {
                Err(reader
                    .fault(dial, "expected turbulence.scale with it: bands have an intensity each, and no inflow"))
            }
        }
    }
}

impl Scene {
    /// Speed beyond which the band law does not strengthen a band's eddies in a step of `substeps` substeps \[m/s\]: I
    /// U, and at most a kernel radius in a substep, beyond which steps do not resolve them; 0 without air.
    #[must_use]
    pub fn largest_eddy_speed(&self, band: &Band, substeps: u32) -> f64 {
        let radius = self.air.as_ref().map_or(0.0, |air| air.kernel_radius);
        let resolved = radius * f64::from(substeps) / self.time.step;
        (band.intensity * self.turbulence.speed).min(resolved)
    }

    /// Filters must be made and run in a time that somebody can wait for.
    pub(super) fn check_bands(&self, reader: &Reader<'_>) -> Result<(), SceneError> {
        let Some((air, bounds)) = self.filled() else { return Ok(()) };
        let size = DVec3::from_array(bounds.max) - DVec3::from_array(bounds.min);
        let particles = size.element_product() / air.particle_volume();
        for (i, band) in self.turbulence.bands.iter().enumerate() {
            if let Some(excess) = self.turbulence.excess(band.scale, air.kernel_radius, particles, size) {
                let words = format!("{}; {}", excess.what, excess.expected);
                let spelled = if reader.table("turbulence").has("scale") { "" } else { &format!("bands.{i}.") };
                return Err(reader.fault(&format!("turbulence.{spelled}scale"), words));
            }
        }
        Ok(())
    }
}
