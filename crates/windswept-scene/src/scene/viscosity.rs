//! `[viscosity]`: XSPH.

use crate::{
    declare::{table, words},
    faults::At,
    keys::{
        Fallback::{Derived, Method, Value},
        Kind::{Choice, NonNegative},
    },
    scene::{Air, FluidSolver, Model, Scene},
};

/// c = 22 ν Δt/h²: XSPH with the kernel Poly6, of fluid at rest density.
const COEFFICIENT: f64 = 22.0;

table! {
    /// `[viscosity]`: c of eqs. 7 and 8 for the step as written (`time.step`).
    #[derive(Debug, Clone, PartialEq)]
    pub struct Viscosity => CheckedViscosity, with defaults, checked by Viscosity::check {
        /// Coefficient c of hair, per step as written. With interaction.model two-way it acts between strands; with
        /// particles it also acts between the points of one strand.
        hair: f64 = NonNegative, "", Value(1.4) => value(|scene| scene.viscosity.of_kinematic(scene, scene.viscosity.kinematic_hair, 1.4));
        /// Coefficient c of air, per step as written.
        air: f64 = NonNegative, "", Value(0.014) => value(|scene| scene.viscosity.of_kinematic(scene, scene.viscosity.kinematic_air, 0.014));
        /// Constant C of the viscosity of eddies smaller than the spacing d of air, ν = (C d)² |∇v| (Smagorinsky 1963),
        /// on top of air's; 0 leaves it out. 0.34 is the usual 0.17 of a filter of two spacings. For fluid.solver
        /// divergence; at most 1.
        smagorinsky: f64 = NonNegative, "", Derived("0, or 0.34 with model particles and solver divergence") => value(|scene| {
            // Where hair is in air's own sums it makes eddies that are hardly larger than the spacing, which have a
            // limit of short steps only with this viscosity (`docs/decisions/air.md`).
            let in_sums = scene.model() == Model::Particles && scene.fluid_solver() == FluidSolver::Divergence;
            if in_sums { Viscosity::USUAL_CONSTANT } else { 0.0 }
        });
        /// Form of the exchange: with or without the symmetric limiter.
        form: ViscosityForm = Choice(ViscosityForm::WORDS), "", Method(ViscosityForm::Limited, ViscosityForm::Published) => method;
    }
    and before the check {
        /// Kinematic viscosity ν of hair instead of hair: c = 22 ν Δt/h².
        kinematic_hair: Option<f64> = NonNegative, "m²/s", Derived("from viscosity.hair");
        /// Kinematic viscosity ν of air instead of air: c = 22 ν Δt/h².
        kinematic_air: Option<f64> = NonNegative, "m²/s", Derived("from viscosity.air");
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

impl Viscosity {
    /// `smagorinsky` of a scene with `interaction.model` particles and `fluid.solver` divergence that does not say it.
    pub const USUAL_CONSTANT: f64 = 0.34;

    /// Coefficient c of a kinematic viscosity \[m²/s\], or `without` one.
    fn of_kinematic(&self, scene: &Scene, kinematic: Option<f64>, without: f64) -> f64 {
        let of_air = |air: &Air| air.kernel_radius.unwrap_or(Air::radius_at(air.spacing));
        let radius = scene.air.as_ref().map_or(Air::KERNEL_RADIUS, of_air);
        kinematic.map_or(without, |nu| COEFFICIENT * nu * scene.time.step / (radius * radius))
    }

    fn check(&self, checked: &mut CheckedViscosity, _: &Scene, at: &At<'_>) {
        if checked.smagorinsky > 1.0 {
            at.fault("smagorinsky", format!("expected at most 1, found {}", checked.smagorinsky));
        }
        for (name, kinematic, both) in [
            ("hair", "kinematic_hair", self.kinematic_hair.filter(|_| self.hair.is_some())),
            ("air", "kinematic_air", self.kinematic_air.filter(|_| self.air.is_some())),
        ] {
            if let Some(nu) = both {
                let words = format!(
                    "viscosity.{name} is given too: expected one of them; --set 'viscosity={{ {kinematic} = {nu} }}' replaces all"
                );
                at.fault(kinematic, words);
            }
        }
    }
}

impl CheckedViscosity {
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
}
