//! A simulation that goes on with another scene.

use std::borrow::Cow;

use windswept_scene::{AsChecked, CheckedScene, InitialState, Scene, is_fixed};

use super::{Origin, Simulation, without_hair};
use crate::error::{Error, GpuError};

impl Simulation {
    /// Goes on with another scene from the next step on. The state stays as it is, and so do roots, pins, bodies and a
    /// force that were set; a wind that was set is part of [`Self::scene`], and stays in a scene that was made from it.
    /// The arrays that follow from the scene are those of a new simulation of it, so that a simulation that has not
    /// stepped yet has the same bits as a new one. A caller's own groom stays in the place of `[hair]`, and keeps the
    /// air that it began in. Strands that sleep wake.
    ///
    /// Gravity, wind, gusts, inflow, force fields, bands, viscosity, friction, damping, stiffness, radius and density
    /// of fibres, keyframes of hair and bodies, camera and picture may differ; numbers and shapes of things, and
    /// solvers, may not. The buffers on the device are made anew: [`Self::buffers`] are others afterwards, and both
    /// exist for a moment.
    ///
    /// The update is kept as a change of the scene, which [`Self::recorded`] has. Changes that the simulation's own
    /// scene still has to make stay; those of the other scene are not looked at.
    ///
    /// # Errors
    /// [`Error::Scene`] for a scene with faults, and with the key of a value that a simulation keeps, such as
    /// `hair.strands`; [`Error::Gpu`] where the new buffers do not fit the adapter. The simulation is as it was before.
    pub fn update(&mut self, scene: &impl AsChecked) -> Result<(), Error> {
        let mut scene = scene.as_checked()?;
        if self.own_hair && self.scene.hair.is_empty() {
            scene = Cow::Owned(without_hair(&scene));
        }
        if scene.scene().changes != self.given.scene().changes {
            let changes = self.given.scene().changes.clone();
            scene = Cow::Owned(Scene { changes, ..scene.scene().clone() }.check()?);
        }
        let changed = self.scene.scene().changed(scene.scene());
        if let Some(key) = changed.iter().find(|key| is_fixed(key)) {
            let words = "expected the value that the simulation began with: start another simulation to change it";
            return Err(Error::Scene(self.scene.scene().fault(key, words)));
        }
        if changed.is_empty() {
            return Ok(());
        }
        let change = self.given.scene().change_to(scene.scene(), self.time());
        let next = self.with_scene(&scene, &changed)?;
        self.go_on_as(next, scene.into_owned());
        self.updates.push(change);
        Ok(())
    }

    /// Goes on as another simulation of the same state, to which this scene was given.
    pub(super) fn go_on_as(&mut self, mut next: Self, given: CheckedScene) {
        next.given = given;
        (next.callback, next.trace) = (self.callback.take(), self.trace.take());
        (next.began, next.updates) = (self.began.clone(), std::mem::take(&mut self.updates));
        *self = next;
    }

    /// The simulation with another scene.
    pub(super) fn with_scene(&self, scene: &CheckedScene, changed: &[String]) -> Result<Self, Error> {
        let gpu = self.gpu();
        let initial = if self.own_hair { self.initial.clone() } else { InitialState::new(scene)? };
        if self.last.step == 0 && !self.was_set && !self.own_hair {
            return Self::started(gpu, scene, initial, Origin::Validated, || false);
        }
        let (air, origin) = (self.initial.air.clone(), self.initial.origin);
        let mut initial = InitialState { air, origin, ..initial };
        let (hair, rest) = (&mut initial.hair, &self.initial.hair);
        hair.positions.clone_from(&rest.positions);
        hair.orientations.clone_from(&rest.orientations);
        // Hair of a file was given as it hung in the weight of the start.
        hair.rest_rotation.clone_from(&rest.rest_rotation);
        for (own, ends) in hair.ends.iter_mut().zip(&rest.ends) {
            own.tip_rest_rotation = ends.tip_rest_rotation;
        }
        let winds = ["air.wind", "air.gust", "air.ramp"];
        let blows_anew = changed.iter().any(|key| winds.iter().any(|wind| key.starts_with(wind)));
        let mut next = Self::build(gpu, scene, initial, Origin::Validated)?;
        let moves_anew = |body: &usize| changed.iter().any(|key| key.starts_with(&format!("body.{body}.motion")));
        for (body, driven) in self.bodies_set.iter().filter(|(body, _)| !moves_anew(body)) {
            next.drive_body(*body, driven.clone())?;
        }
        next.plan_force(self.plan.conditions.pushes.runs)?;
        // Pins are fixed in a scene, and those that a caller has set go on.
        next.engine.expect_pins(self.engine.sizes().pins);
        let kept = self.engine.state().lasting();
        for array in next.engine.state().lasting() {
            let winds = array.name() == next.engine.state().wind_table.name() && blows_anew;
            let Some(before) = kept.iter().find(|before| before.name() == array.name()).filter(|_| !winds) else {
                continue;
            };
            if before.len() == array.len() {
                next.engine.write_bytes(&array, &self.engine.read_bytes(before)?)?;
            }
        }
        if self.plan.recovers_strands() {
            next.plan.recover_strands();
        }
        let is_seen = |key: &String| ["camera", "picture", "title"].iter().any(|table| key.starts_with(table));
        if !changed.iter().all(is_seen) {
            next.engine.rouse()?;
        }
        next.keep(self)?;
        if let Some(wind) = self.wind_set.filter(|_| !blows_anew) {
            next.plan_wind(wind)?;
            next.raise_speed(self.scene.turbulence.speed)?;
        }
        next.record_again()?;
        next.poses.bring(&next.engine, next.last.step)?;
        Ok(next)
    }

    /// Takes over how far the simulation is, and what its report has.
    fn keep(&mut self, before: &Self) -> Result<(), GpuError> {
        self.last = self.engine.status()?;
        self.root_frames.clone_from(&before.root_frames);
        (self.first_substep, self.steps, self.batches) = (before.first_substep, before.steps, before.batches);
        (self.setup_ms, self.first_step_ms) = (before.setup_ms, before.first_step_ms);
        self.step_ms.clone_from(&before.step_ms);
        (self.recovered, self.wind_at_start) = (before.recovered, before.wind_at_start);
        self.resets.clone_from(&before.resets);
        (self.was_set, self.own_hair, self.loads_after) = (before.was_set, before.own_hair, self.last.step);
        Ok(())
    }
}
