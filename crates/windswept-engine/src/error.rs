//! Errors, made where their cause is known.

use windswept_scene::SceneError;

/// No adapter, no device, or a device that refuses.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter matched.
    #[error("no adapter found: looked for {wanted} among {found}. {help}")]
    NoAdapter {
        /// Choice that was asked for.
        wanted: String,
        /// Adapters that there are.
        found: String,
        /// Advice on what to do about it.
        help: String,
    },
    /// The adapter gave no device.
    #[error("adapter {adapter} gave no device: {reason}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// The driver's words.
        reason: String,
    },
    /// A buffer would be larger than the adapter allows.
    #[error("{array} needs {bytes} bytes, the adapter binds at most {limit}; {}", remedy(array, *fits))]
    TooLarge {
        /// Name of the buffer.
        array: &'static str,
        /// Size that the buffer needs \[bytes\].
        bytes: u64,
        /// Size that the adapter allows \[bytes\].
        limit: u64,
        /// Number of particles that would fit, or of whatever else the buffer holds.
        fits: u64,
    },
    /// The grid of neighbours has too many cells.
    #[error("air.kernel_radius makes {cells} cells of air.box, of which at most {most} can be sorted")]
    TooManyCells {
        /// Number of cells.
        cells: u32,
        /// Largest number of cells that there may be.
        most: u32,
    },
    /// The grid of the band filter would be larger than the adapter allows.
    #[error(
        "the grid for turbulence.bands of {scale} m would have {nodes} nodes, of which at most {most} fit this \
        adapter; a scale of about {fits:.2e} m would fit"
    )]
    BandTooFine {
        /// Scale s of the finest band \[m\].
        scale: f64,
        /// Number of nodes of that band's grid.
        nodes: u64,
        /// Number of nodes that fit.
        most: u64,
        /// Scale that would fit \[m\].
        fits: f64,
    },
    /// A limit of the device is below what the engine needs.
    #[error("the device allows {limit} = {has}, {needs} are needed")]
    Limit {
        /// Name of the limit in wgpu.
        limit: &'static str,
        /// Value that the device has.
        has: u64,
        /// Value that the engine needs.
        needs: u64,
    },
    /// An array has no memory of its own, so that it holds nothing once its step is over.
    #[error("{array} shares its memory with other arrays of a step: expected an array that outlasts the step")]
    Shared {
        /// Name of the array.
        array: &'static str,
    },
    /// The driver rejected a call, or is out of memory.
    #[error("{doing}: {reason}")]
    Driver {
        /// Work that was being done.
        doing: String,
        /// The driver's words.
        reason: String,
    },
    /// The device is gone.
    #[error("the device was lost: {0}")]
    Lost(String),
}

/// Advice: how much would fit, and the keys of the scene that decide it.
fn remedy(array: &str, fits: u64) -> String {
    match array {
        "cell_count" | "cell_start" => {
            format!("about {fits} cells would fit: expected a larger air.kernel_radius or a smaller air.box")
        }
        "keyframes" => format!("about {fits} keyframes would fit: expected fewer"),
        "strands" | "strand_history" | "root_targets" | "rod_strands" => {
            format!("about {fits} strands would fit: expected fewer hair.strands")
        }
        "band" => format!("about {fits} dispatches would fit: expected smaller or fewer turbulence.bands"),
        "orientation" | "segments" | "segment_history" | "rod_segments" | "factors" => {
            format!("about {fits} segments would fit: expected fewer hair.points or hair.strands")
        }
        "contacts" | "contact_history" => {
            format!(
                "about {fits} contacts would fit, two for each hair point and body: expected fewer bodies, \
                hair.strands or hair.points"
            )
        }
        "point_history" | "pins" | "rod_points" | "points" | "inverse_mass" | "drag_impulse" | "tangential_spring"
        | "friction_points" => {
            format!("about {fits} hair points would fit: expected fewer hair.strands or hair.points")
        }
        _ => format!(
            "about {fits} particles would fit: expected a larger air.spacing, a smaller air.box or fewer \
            hair.strands"
        ),
    }
}

/// A run that cannot go on.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// An air particle became non-finite, or faster than 1e6 m/s.
    #[error(
        "step {step} (t = {} s): position or velocity of air particle {particle} is no finite number, or it is faster \
        than 1e6 m/s, at the end of the step (commit/check){}: the run ends; a smaller time.step may help",
        six_digits(*time), before(*position, *nearest)
    )]
    NonFiniteAir {
        /// Stable id of the first such particle.
        particle: u32,
        /// Where it was before the step \[m\].
        position: [f32; 3],
        /// The strand that was nearest then, by its nearest point, and how far that was \[m\]; `None` without hair.
        nearest: Option<(usize, f32)>,
        /// The step that failed; the state is that before it.
        step: u64,
        /// Time of that step \[s\].
        time: f64,
    },
    /// More strands than max(3, 1 %) became non-finite in one step.
    #[error(
        "step {step} (t = {} s): {count} strands have numbers that are not finite or that no strand can have, and at \
        most {limit} are put back to rest in a step; the first is point {point} of strand {strand}, found by {pass}: \
        the run ends; a smaller time.step or fewer hair.points may help",
        six_digits(*time)
    )]
    TooManyFailedStrands {
        /// Number of such strands.
        count: u32,
        /// Number of strands that are put back to rest in a step at most.
        limit: u32,
        /// First of the strands, from 0.
        strand: usize,
        /// First of its points that is not finite, from 0 at the root.
        point: usize,
        /// Pass that found it: `forcing/reset` as the step began, `rods/update` after the rods' solve, `commit/hold` at
        /// the end.
        pass: &'static str,
        /// The step that failed; the state is that before it.
        step: u64,
        /// Time of that step \[s\].
        time: f64,
    },
    /// The neighbour list cannot grow as far as the step needs.
    #[error(
        "step {step} needs a neighbour list of up to {needed} elements, the adapter allows {limit}: particles are \
        crowded or too many"
    )]
    TooManyNeighbours {
        /// Number of elements, of four words, that the step needs at most: of as many pages as there were, all as long
        /// as the longest.
        needed: u64,
        /// Number of elements that fit: four times what the adapter binds at once.
        limit: u64,
        /// The step that needs them.
        step: u64,
    },
    /// A root, wind, force or state that the caller gave cannot be used.
    #[error("{0}")]
    Input(String),
    /// The caller's function that says what pushes hair and air failed.
    #[error("the callback of the force: {0}")]
    Callback(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// A quantity of the state cannot be measured.
    #[error("measuring the state: {0}")]
    Measurement(String),
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Where an air particle was, and how far from hair.
fn before(position: [f32; 3], nearest: Option<(usize, f32)>) -> String {
    let [x, y, z] = position;
    let hair = nearest.map(|(strand, distance)| format!(", {distance:.4} m from strand {strand}"));
    format!("; before it the particle was at [{x:.4}, {y:.4}, {z:.4}] m{}", hair.unwrap_or_default())
}

/// A checkpoint that could not be written or read.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The operating system refused.
    #[error("{file}: cannot be {be}: {reason}")]
    File {
        /// The file.
        file: String,
        /// Participle of the operation that failed.
        be: &'static str,
        /// The system's words.
        reason: std::io::Error,
    },
    /// The file is no checkpoint, of another version, cut off or damaged.
    #[error("{file}: {problem}")]
    Content {
        /// The file.
        file: String,
        /// The fault, and its place.
        problem: String,
    },
    /// The text of the scene does not give the scene: it was made in code and cannot be written, or a file that it
    /// names is gone.
    #[error("the scene cannot be saved, as its text does not give it back: {0}")]
    Text(String),
    /// The saved state does not make a simulation, or does not fit the adapter.
    #[error("{file}: {error}")]
    Start {
        /// The file.
        file: String,
        /// Why not.
        error: Error,
    },
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// A simulation that could not be made.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The `stop` of [`Simulation::new_until`](crate::Simulation::new_until), which ended the time of settling.
    #[error("stopped while hair settles")]
    Stopped,
    /// The scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl From<Error> for RunError {
    fn from(error: Error) -> Self {
        match error {
            Error::Gpu(error) => Self::Gpu(error),
            error => Self::Input(error.to_string()),
        }
    }
}

/// `Debug` as the text of `Display`, which a `main` that returns the error prints.
macro_rules! debug_as_display {
    ($($error:ty),*) => {
        $(impl std::fmt::Debug for $error {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(self, f)
            }
        })*
    };
}

debug_as_display!(GpuError, RunError, CheckpointError, Error, crate::ops::OpsError);

/// A number to six digits, however small it is.
pub(crate) fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::{CheckpointError, Error, GpuError, RunError, six_digits};
    use crate::ops::OpsError;

    /// A `main` that returns an error prints it as it is meant to be read.
    #[test]
    fn debug_is_display() {
        let lost = || GpuError::Lost("it is gone".to_owned());
        let (run, ops) = (RunError::from(lost()), OpsError::from(lost()));
        let (start, checkpoint) = (Error::from(lost()), CheckpointError::from(lost()));
        let said = [format!("{:?}", lost()), format!("{run:?}"), format!("{ops:?}"), format!("{start:?}")];
        assert!(said.iter().all(|said| said == "the device was lost: it is gone"), "{said:?}");
        assert_eq!(format!("{checkpoint:?}"), checkpoint.to_string());
    }

    /// Times of steps that last a nanosecond are told apart, and none has the digits of its rounding.
    #[test]
    fn times_have_six_digits() {
        for (time, shown) in [(3e-9, "0.000000003"), (7.0 * 1.38e-3, "0.00966"), (1234.56789, "1234.57"), (0.0, "0")] {
            assert_eq!(six_digits(time).to_string(), shown);
        }
    }
}
