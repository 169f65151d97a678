//! Air that light hair carries along.

use std::collections::BTreeMap;

use crate::{
    scene::{Model, SceneValues},
    strands::Strands,
    warnings::Warning,
};

/// Least mass that a point or a segment moves with where hair is in one fluid with air, of that of the air whose room
/// it takes. A strand's step is solved after the air's pressure, which takes a point for one that goes where it is
/// pushed. A rod holds it, and hair that is lighter than the air by orders is then pushed the more from step to step
/// (the added-mass instability of Causin, Gerbeau and Nobile 2005). Every run of the stress `masses` holds from 0.01
/// on.
const LIGHTEST: f64 = 0.1;

impl Strands {
    /// Lets hair that the model `particles` puts into one fluid with air move with at least a tenth of the mass of the
    /// air whose room it takes. The carried air has no weight, and no part in a force that a caller sets.
    /// Does nothing with any other model, nor to hair that carries it already. Returns a warning for each group of
    /// strands that carries more than before.
    ///
    /// [`InitialState::new`](crate::InitialState::new) and the engine, where it starts from a caller's arrays, do so.
    pub fn add_air_mass(&mut self, scene: &SceneValues) -> Vec<Warning> {
        let air = scene.air.as_ref().filter(|_| scene.interaction.model == Model::Particles);
        let Some(density) = air.map(|air| LIGHTEST * air.rest_density) else { return Vec::new() };
        let segments: Vec<_> = (0..self.len()).flat_map(|s| self.segments(s).zip(self.points(s))).collect();
        for (k, i) in segments {
            let volume = 0.5 * (self.volume[i] + self.volume[i + 1]);
            let most = 1.0 / (0.5 * density * volume * self.rest_length[k].powi(2));
            self.inverse_inertia[k] = self.inverse_inertia[k].min(most);
        }
        let mut light: BTreeMap<String, [usize; 2]> = BTreeMap::new();
        for s in 0..self.len() {
            let counted = light.entry(self.origin(s, scene)).or_default();
            for i in self.points(s) {
                let own = self.inverse_mass[i];
                let with_air = own.min(1.0 / (density * self.volume[i]));
                if with_air < own {
                    self.weight.resize(self.inverse_mass.len(), 1.0);
                    self.weight[i] *= with_air / own;
                    self.inverse_mass[i] = with_air;
                    counted[0] += 1;
                }
                counted[1] += 1;
            }
        }
        let warning = |(origin, [few, all]): (String, [usize; 2])| {
            let text = format!(
                "{few} of the {all} points are lighter than a tenth of the air whose room they take, and move with that mass: \
                 interaction.model = \"two-way\" takes hair of any mass as it is"
            );
            Warning::new("light_hair", &origin, text)
        };
        light.into_iter().filter(|(_, [few, _])| *few > 0).map(warning).collect()
    }
}
