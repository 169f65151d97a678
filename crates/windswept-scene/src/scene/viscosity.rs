//! `[viscosity]`: XSPH.

use crate::{
    declare::{table, words},
    error::SceneError,
    keys::{
        Fallback::{Absent, Method, Value},
        Kind::{Choice, NonNegative},
    },
    reader::Reader,
    scene::{Air, Time},
};

table! {
    /// `[viscosity]`: c of eqs. 7 and 8 for the step as written (`time.step`).
    #[derive(Debug, Clone, PartialEq)]
    pub struct Viscosity, checked by Viscosity::checked {
        /// Coefficient c of hair, per step as written. With interaction.model two-way it acts between strands; with particles
        /// it also acts between the points of one strand.
        hair: f64 = NonNegative, "", Value(1.4);
        /// Coefficient c of air, per step as written.
        air: f64 = NonNegative, "", Value(0.014);
        /// Form of the exchange: with or without the symmetric limiter.
        form: ViscosityForm = Choice(ViscosityForm::WORDS), "", Method(ViscosityForm::Limited, ViscosityForm::Published);
    }
    without a field {
        /// Kinematic viscosity ν of hair instead of hair: c = 22 ν Δt/h².
        kinematic_hair: f64 = NonNegative, "m²/s", Absent("from viscosity.hair");
        /// Kinematic viscosity ν of air instead of air: c = 22 ν Δt/h².
        kinematic_air: f64 = NonNegative, "m²/s", Absent("from viscosity.air");
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
    /// Coefficients from kinematic viscosities where those are given.
    fn checked(mut self, reader: &Reader<'_>) -> Result<Self, SceneError> {
        for (name, kinematic, coefficient) in
            [("hair", "kinematic_hair", &mut self.hair), ("air", "kinematic_air", &mut self.air)]
        {
            let Some(nu) = reader.said::<f64>(kinematic) else { continue };
            if reader.has(name) {
                let words = format!("viscosity.{name} is given too: expected one of them");
                return Err(reader.fault(kinematic, words));
            }
            let root = reader.root();
            let radius = if root.has("air") { root.read::<Air>("air")?.kernel_radius } else { Air::KERNEL_RADIUS };
            *coefficient = 22.0 * nu * root.read::<Time>("time")?.step / (radius * radius);
        }
        Ok(self)
    }
}
