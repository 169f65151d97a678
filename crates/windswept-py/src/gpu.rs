//! One device per adapter and process, shared by all simulations and single passes on it.

use std::{
    collections::HashMap,
    sync::{Mutex, PoisonError},
};

use pyo3::prelude::*;
use windswept::{AdapterChoice, Gpu};

use crate::{errors::gpu_error, without_gil};

/// Devices by process and by what was asked for. A forked process must not use its parent's.
type Devices = HashMap<(u32, String), Gpu>;
static DEVICES: Mutex<Option<Devices>> = Mutex::new(None);

/// The device of an adapter: `software`, part of a name, or without either `WGPU_ADAPTER_NAME` or the best.
pub(crate) fn device(py: Python<'_>, adapter: Option<&str>) -> PyResult<Gpu> {
    device_of(py, &AdapterChoice::from_flag(adapter))
}

/// The device of the adapter that is chosen.
pub(crate) fn device_of(py: Python<'_>, choice: &AdapterChoice) -> PyResult<Gpu> {
    let made = without_gil(py, || {
        let mut devices = DEVICES.lock().unwrap_or_else(PoisonError::into_inner);
        let devices = devices.get_or_insert_default();
        let key = (std::process::id(), choice.to_string());
        if let Some(gpu) = devices.get(&key) {
            return Ok(gpu.clone());
        }
        let gpu = Gpu::new(choice)?;
        // A choice in other words may name an adapter whose device is there.
        let mut ours = devices.iter().filter(|((process, _), _)| *process == key.0).map(|(_, known)| known);
        let gpu = ours.find(|known| known.info() == gpu.info()).cloned().unwrap_or(gpu);
        devices.insert(key, gpu.clone());
        Ok(gpu)
    })?;
    made.map_err(|error| gpu_error(&error))
}

/// A lost device is not handed out again.
pub(crate) fn forget() {
    *DEVICES.lock().unwrap_or_else(PoisonError::into_inner) = None;
}
