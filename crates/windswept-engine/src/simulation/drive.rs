//! Roots, mean wind and state, as a caller sets them between steps.

use std::collections::HashSet;

use glam::{DQuat, DVec3};
use windswept_scene::{
    CheckedAir, Solver,
    limits::{FASTEST_WIND, LARGEST, SMALLEST},
};
use windswept_shaders::common::{rod::Pin, validity::FAST};

use super::Simulation;
use crate::{
    error::{Error, GpuError, RunError},
    setup::Setup,
    step::Plan,
    upload::{rods, winds},
};

impl Simulation {
    /// Says where the root of each strand goes: `positions` in the world \[m\], one per strand, and the ghost frames
    /// that clamp them; without frames the roots keep theirs. The roots arrive at the end of the next step of Δt, and
    /// stay; in the frame of `air.follows`, if there is one. A root that jumps farther than its strand is long takes
    /// the strand along in its shape, at rest. Free roots are not affected.
    ///
    /// # Errors
    /// [`RunError::Input`] when there is not one of each per strand, when one is beyond 1e18 or a frame has no length,
    /// and when `hair.motion` moves the roots; [`RunError::Gpu`].
    pub fn set_roots(&mut self, positions: &[DVec3], frames: Option<&[DQuat]>) -> Result<(), RunError> {
        let input = |what: String| Err(RunError::Input(what));
        let strands = self.initial.hair.len();
        if self.scene.hair.iter().any(|hair| !hair.motion.keyframes.is_empty()) {
            return input(
                "roots: hair.motion moves them, or the body that they are on: expected hair without".to_owned(),
            );
        }
        if positions.len() != strands {
            return input(format!("positions: expected {strands} rows, one per strand, found {}", positions.len()));
        }
        checked("positions", Some(positions), strands)?;
        if let Some(frames) = frames {
            if frames.len() != strands {
                return input(format!("frames: expected {strands} rows, one per strand, found {}", frames.len()));
            }
            if let Some(s) = frames.iter().position(|q| !is_rotation(q)) {
                return input(format!("frames: that of strand {s} is not a rotation"));
            }
            self.root_frames = frames.iter().map(|q| q.normalize()).collect();
        }
        let origin = self.origin_after_step();
        let rows = positions.iter().zip(&self.root_frames);
        let targets: Vec<_> = rows.map(|(x, frame)| rods::root(*x - origin, *frame)).collect();
        self.was_set = true;
        Ok(self.engine.write(&self.engine.state().root_targets, &targets)?)
    }

    /// Pins points of hair to places in the world \[m\], in place of all pins set before: `points` are rows of
    /// [`Frame`](crate::Frame)'s hair, and each goes to its place within the next step of Δt and stays until it is
    /// pinned elsewhere or released. A pin is a stiff spring, which gives by less than 0.1 mm while a head turns; the
    /// last on a strand, and a tip that the scene holds, go exactly. Points that the scene holds, and are not pinned
    /// elsewhere, are where the scene has them.
    ///
    /// # Errors
    /// [`RunError::Input`] when there is not one place per point, a place is beyond 1e18 m, a point does not exist, is
    /// given twice or is a root that is held, when `rods.solver` is `gauss-seidel`, and when `hair.motion` moves a held
    /// tip; [`RunError::Gpu`].
    pub fn set_pins(&mut self, points: &[usize], places: &[DVec3]) -> Result<(), RunError> {
        let input = |what: String| Err(RunError::Input(what));
        let (hair, scene) = (&self.initial.hair, &self.scene);
        if scene.rods.solver == Solver::GaussSeidel {
            return input("points: rods.solver is gauss-seidel, which knows no pins: expected direct".to_owned());
        }
        checked("places", Some(places), points.len())?;
        let (mut pins, origin) = (rods::pins(&self.given, &self.initial), self.origin_after_step());
        let mut given = HashSet::new();
        for (row, (&point, place)) in points.iter().zip(places).enumerate() {
            if point >= pins.len() {
                return input(format!("points: expected at most {}, found {point} in row {row}", pins.len() - 1));
            }
            if !given.insert(point) {
                return input(format!("points: {point} is given twice, in row {row} for the second time"));
            }
            let held = hair.inverse_mass[point] == 0.0;
            if held && self.is_root(point) {
                return input(format!("points: {point} in row {row} is a root that is held: set_roots moves it"));
            }
            if held && scene.hair.iter().any(|hair| !hair.motion.keyframes.is_empty()) {
                return input(format!(
                    "points: the scene's hair.motion moves point {point} in row {row}, a tip that is held"
                ));
            }
            pins[point] = rods::pin(*place - origin);
        }
        self.was_set = true;
        self.plan_pins(&pins)?;
        Ok(self.engine.write(&self.engine.state().pins, &pins)?)
    }

    /// Lets the step look for pins, where there are any, or not.
    pub(super) fn plan_pins(&mut self, pins: &[Pin]) -> Result<(), GpuError> {
        let (before, now) = (self.engine.sizes().pins, rods::held(pins));
        self.engine.expect_pins(now);
        if (before > 0) == (now > 0) {
            return Ok(());
        }
        self.record_again().inspect_err(|_| self.engine.expect_pins(before))
    }

    fn is_root(&self, point: usize) -> bool {
        self.initial.hair.point_offsets.contains(&(point as u32))
    }

    /// Sets the mean wind from the next step on \[m/s\], in place of the scene's wind, ramp and gusts. All air takes
    /// the change in that step. A wind that turns round enters from the other side. `turbulence.speed`, where the scene
    /// leaves it to the largest wind, rises to one that is set. Where the wind is faster than the air's pressure keeps
    /// up with, [`Self::warnings`] says so.
    ///
    /// # Errors
    /// [`RunError::Input`] when it is faster than [`FASTEST_WIND`], or the scene has no `[air]`; [`RunError::Gpu`].
    pub fn set_wind(&mut self, wind: DVec3) -> Result<(), RunError> {
        if !is_wind(&wind) {
            let words = format!("wind: expected at most {FASTEST_WIND:e} m/s, found {:?}", wind.to_array());
            return Err(RunError::Input(words));
        }
        // A wind that passes through zero need not be zero at the end of any step.
        let wind = DVec3::select(wind.abs().cmplt(DVec3::splat(SMALLEST)), DVec3::ZERO, wind);
        if self.scene.air.is_none() {
            return Err(RunError::Input("wind: the scene has no air".to_owned()));
        }
        self.plan_wind(wind)?;
        Ok(self.turn_wind()?)
    }

    /// Lets the scene's wind blow from the end of the next substep on, after the one that blows now.
    pub(super) fn turn_wind(&self) -> Result<(), GpuError> {
        let step = f64::from(self.engine.seconds_of_step());
        let before = (f64::from(self.last.step) * step) as f32;
        let time = (f64::from(self.last.step) + 1.0) * step;
        let table = &self.engine.state().wind_table;
        let entries = winds::turned(&self.scene, self.last.wind, before, time, table.len() as usize);
        self.engine.write(table, &entries)
    }

    /// Gives scene and plan this wind \[m/s\] in place of the scene's own.
    pub(super) fn plan_wind(&mut self, wind: DVec3) -> Result<(), Error> {
        self.scene = self.scene.assuming(|scene, values| {
            if let (Some(written), Some(air)) = (&mut scene.air, &mut values.air) {
                (written.wind, written.ramp, written.gust) = (Some(wind.to_array()), 0.0, Vec::new());
                (air.wind, air.ramp, air.gust) = (wind.to_array(), 0.0, Vec::new());
            }
            values.feel_frame();
        });
        (self.wind_set, self.was_set) = (Some(wind), true);
        let blows = self.scene.air.as_ref().is_some_and(|air| !air.is_still());
        if self.plan.set_wind(blows) {
            self.record_again()?;
        }
        self.raise_speed(self.largest_wind())
    }

    /// Largest speed of the scene's wind, which in the frame of a body is that which the body feels \[m/s\].
    pub(super) fn largest_wind(&self) -> f64 {
        self.scene.air.as_ref().map_or(0.0, CheckedAir::largest_wind)
    }

    /// Raises the speed of the law of turbulence \[m/s\], where the scene leaves it to the largest wind.
    pub(super) fn raise_speed(&mut self, speed: f64) -> Result<(), Error> {
        let turbulence = &self.scene.turbulence;
        if self.given.scene().turbulence.speed.is_some() || turbulence.bands.is_empty() || speed <= turbulence.speed {
            return Ok(());
        }
        self.scene = self.scene.assuming(|_, values| values.turbulence.speed = speed);
        let setup = Setup::new(&self.scene, &self.initial);
        self.engine.write(&self.engine.state().band, &setup.bands.tasks)?;
        if Plan::new(&setup).conditions.turbulence.runs && !self.plan.conditions.turbulence.runs {
            // The passes of turbulence need buffers of their own.
            let next = self.with_scene(&self.scene, &[])?;
            self.go_on_as(next, self.given.clone());
        }
        Ok(())
    }

    /// Puts hair somewhere else: positions \[m\] and velocities \[m/s\] of points, orientations of segments. An array
    /// that is not given stays. Strands go on as if they had come there with these velocities. Held points keep their
    /// places.
    ///
    /// # Errors
    /// [`RunError::Input`] when an array has not a row for each, when a position is beyond 1e18 m or a velocity beyond
    /// [`FAST`] m/s, or an orientation is no rotation; [`RunError::Gpu`].
    pub fn set_hair(
        &mut self,
        positions: Option<&[DVec3]>,
        velocities: Option<&[DVec3]>,
        orientations: Option<&[DQuat]>,
    ) -> Result<(), RunError> {
        let s = self.engine.state().clone();
        let mut hair = self.initial.hair.clone();
        let points = hair.positions.len();
        checked("positions", positions, points)?;
        checked_speeds(velocities, points)?;
        let [now, speeds, frames] = self.engine.read_vec4([&s.position, &s.velocity, &s.orientation])?;
        let spins = self.engine.read(&s.segment_history)?;
        let vector = |v: &[f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
        let (origin, moves) = (self.origin(), self.frame_velocity());
        for i in 0..points {
            let held = hair.inverse_mass[i] == 0.0;
            hair.positions[i] = match positions {
                Some(positions) if !held => positions[i],
                _ => vector(&now[i]) + origin,
            };
            hair.velocities[i] = velocities.map_or_else(|| vector(&speeds[i]), |v| v[i] - moves);
        }
        for (spin, now) in hair.angular_velocities.iter_mut().zip(&spins) {
            *spin = DVec3::from_array(now.angular_velocity.map(f64::from));
        }
        for (frame, now) in hair.orientations.iter_mut().zip(&frames) {
            *frame = DQuat::from_array(now.map(f64::from));
        }
        if let Some(given) = orientations {
            let segments = hair.orientations.len();
            if given.len() != segments {
                let words = format!("orientations: expected {segments} rows, one per segment, found {}", given.len());
                return Err(RunError::Input(words));
            }
            if let Some(k) = given.iter().position(|q| !is_rotation(q)) {
                return Err(RunError::Input(format!("orientations: that of segment {k} is not a rotation")));
            }
            hair.orientations = given.iter().map(|q| q.normalize()).collect();
        }
        self.engine.write_hair(&hair, origin)?;
        self.engine.wake()?;
        self.was_set = true;
        if self.last.step == 0 {
            // Before the first step this is the hair that the run starts from.
            self.initial.hair = hair;
        }
        Ok(())
    }

    /// Puts air somewhere else: positions \[m\], which are wrapped into the box, and velocities \[m/s\], by stable id.
    /// An array that is not given stays. Pressure starts anew, whatever is given.
    ///
    /// # Errors
    /// As [`Self::set_hair`].
    pub fn set_air(&mut self, positions: Option<&[DVec3]>, velocities: Option<&[DVec3]>) -> Result<(), RunError> {
        let air = &self.initial.air;
        checked("positions", positions, air.positions.len())?;
        checked_speeds(velocities, air.positions.len())?;
        let (origin, moves) = (self.origin(), self.frame_velocity());
        let into_box = |x: &DVec3| (*x - origin).rem_euclid(air.size);
        let local: Option<Vec<DVec3>> = positions.map(|positions| positions.iter().map(into_box).collect());
        let velocities: Option<Vec<DVec3>> = velocities.map(|all| all.iter().map(|v| *v - moves).collect());
        self.engine.write_air(local.as_deref(), velocities.as_deref(), air.volume)?;
        self.was_set = true;
        if self.last.step == 0 {
            // Before the first step this is the air that the run starts from.
            let (min, start) = (self.initial.air.min, &mut self.initial.air);
            if let Some(local) = local {
                start.positions = local.into_iter().map(|x| x + min).collect();
            }
            if let Some(velocities) = velocities {
                start.velocities = velocities;
            }
        }
        Ok(())
    }
}

pub(super) fn checked(name: &str, rows: Option<&[DVec3]>, expected: usize) -> Result<(), RunError> {
    let Some(rows) = rows else { return Ok(()) };
    if rows.len() != expected {
        return Err(RunError::Input(format!("{name}: expected {expected} rows, found {}", rows.len())));
    }
    match rows.iter().position(|x| !held(x)) {
        Some(i) => Err(RunError::Input(format!("{} in row {i}", beyond(name, &rows[i])))),
        None => Ok(()),
    }
}

/// Velocities \[m/s\] that a step can begin with.
fn checked_speeds(rows: Option<&[DVec3]>, expected: usize) -> Result<(), RunError> {
    checked("velocities", rows, expected)?;
    match rows.into_iter().flatten().enumerate().find(|(_, v)| v.length() > f64::from(FAST)) {
        Some((row, v)) => {
            let words = format!("velocities: expected at most {FAST:e} m/s, found {:?} in row {row}", v.to_array());
            Err(RunError::Input(words))
        }
        None => Ok(()),
    }
}

/// Whether frames can turn by this.
pub(super) fn is_rotation(q: &DQuat) -> bool {
    (1e-6..=LARGEST).contains(&q.length())
}

/// Whether air can be so fast \[m/s\].
pub(super) fn is_wind(wind: &DVec3) -> bool {
    wind.length() <= FASTEST_WIND
}

/// Whether a vector is one of finite numbers whose squares are finite in `f32`.
pub(super) fn held(x: &DVec3) -> bool {
    x.to_array().iter().all(|x| x.abs() <= LARGEST)
}

fn beyond(name: &str, x: &DVec3) -> String {
    format!("{name}: expected finite numbers of at most {LARGEST:e}, found {:?}", x.to_array())
}
