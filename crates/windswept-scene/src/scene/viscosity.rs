//! `[viscosity]`: XSPH.

use crate::{
    declare::{table, words},
    error::SceneError,
    keys::{
        Fallback::{Derived, Method, Value},
        Kind::{Choice, NonNegative},
    },
    reader::Reader,
    scene::{Air, Fluid, FluidSolver, Interaction, Model, Time},
};

/// c = 22 ν Δt/h²: XSPH with the kernel Poly6, of fluid at rest density.
const COEFFICIENT: f64 = 22.0;

table! {
    /// `[viscosity]`: c of eqs. 7 and 8 for the step as written (`time.step`).
    #[derive(Debug, Clone, PartialEq)]
    pub struct Viscosity, checked by Viscosity::checked {
        /// Coefficient c of hair, per step as written. With interaction.model two-way it acts between strands; with
        /// particles it also acts between the points of one strand.
        hair: f64 = NonNegative, "", Value(1.4);
        /// Coefficient c of air, per step as written.
        air: f64 = NonNegative, "", Value(0.014);
        /// Constant C of the viscosity of eddies smaller than the spacing d of air, ν = (C d)² |∇v| (Smagorinsky 1963),
        /// on top of air's; 0 leaves it out. 0.34 is the usual 0.17 of a filter of two spacings. For fluid.solver
        /// divergence; at most 1.
        smagorinsky: f64 = NonNegative, "", Derived("0, or 0.34 with model particles and solver divergence") => |viscosity| {
            usual_constant(viscosity)?
        };
        /// Form of the exchange: with or without the symmetric limiter.
        form: ViscosityForm = Choice(ViscosityForm::WORDS), "", Method(ViscosityForm::Limited, ViscosityForm::Published);
    }
    without a field {
        /// Kinematic viscosity ν of hair instead of hair: c = 22 ν Δt/h².
        kinematic_hair: f64 = NonNegative, "m²/s", Derived("from viscosity.hair");
        /// Kinematic viscosity ν of air instead of air: c = 22 ν Δt/h².
        kinematic_air: f64 = NonNegative, "m²/s", Derived("from viscosity.air");
    }
}

words! {
    /// `viscosity.form`.
    pub enum ViscosityForm {
        /// Exchange c w / max(1, S_i, S_j): stable at any c.
        Limited = "limited",
        /// Exchange c w, as printed.
        Published = "published",
    }
}

/// Where hair is in air's own sums it makes eddies that are hardly larger than the spacing, which have a limit of short
/// steps only with this viscosity (`docs/decisions/air.md`).
fn usual_constant(reader: &Reader<'_>) -> Result<f64, SceneError> {
    let root = reader.root();
    let in_sums = root.read::<Interaction>("interaction")?.model == Model::Particles;
    let in_velocity = root.read::<Fluid>("fluid")?.solver == FluidSolver::Divergence;
    Ok(if in_sums && in_velocity { Viscosity::USUAL_CONSTANT } else { 0.0 })
}

impl Viscosity {
    /// `smagorinsky` of a scene with `interaction.model` particles and `fluid.solver` divergence that does not say it.
    pub const USUAL_CONSTANT: f64 = 0.34;

    /// Whether anything is viscous.
    #[must_use]
    pub fn acts(&self) -> bool {
        self.hair > 0.0 || self.air > 0.0 || self.smagorinsky > 0.0
    }

    /// Coefficient c of unresolved eddies over the deformation |∇v| Δt, from the volume of a particle of air \[m³\] and
    /// the kernel radius h \[m\].
    #[must_use]
    pub fn eddies(&self, volume: f64, radius: f64) -> f64 {
        COEFFICIENT * (self.smagorinsky * volume.cbrt() / radius).powi(2)
    }

    /// Coefficients from kinematic viscosities where those are given.
    fn checked(mut self, reader: &Reader<'_>) -> Result<Self, SceneError> {
        if self.smagorinsky > 1.0 {
            let words = format!("expected at most 1, found {}", self.smagorinsky);
            return Err(reader.fault("smagorinsky", words));
        }
        for (name, kinematic, coefficient) in
            [("hair", "kinematic_hair", &mut self.hair), ("air", "kinematic_air", &mut self.air)]
        {
            let Some(nu) = reader.said::<f64>(kinematic) else { continue };
            if reader.has(name) {
                let words = format!(
                    "viscosity.{name} is given too: expected one of them; --set 'viscosity={{ {kinematic} = {nu} }}' replaces all"
                );
                return Err(reader.fault(kinematic, words));
            }
            let root = reader.root();
            let radius = if root.has("air") { root.read::<Air>("air")?.kernel_radius } else { Air::KERNEL_RADIUS };
            *coefficient = COEFFICIENT * nu * root.read::<Time>("time")?.step / (radius * radius);
        }
        Ok(self)
    }
}
