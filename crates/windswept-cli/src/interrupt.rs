//! Ctrl-C: the first ends the run between two steps, or between two substeps of a long one; a second, half a second
//! later or more, ends the process at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, sleep};
use std::time::{Duration, Instant};

use signal_hook::SigId;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::failure::{Failure, INTERRUPTED};

/// Time after the first signal in which others count as the same: `timeout` sends one to the program and one to its
/// group.
const SAME: Duration = Duration::from_millis(500);

/// Time between two looks for the first signal.
const LOOK: Duration = Duration::from_millis(50);

/// Time that a step which goes on as Ctrl-C comes has to end by itself.
const PATIENCE: Duration = Duration::from_secs(1);

/// Listens for Ctrl-C and a polite kill until it is dropped.
pub(crate) struct Interrupt {
    asked: Arc<AtomicBool>,
    handlers: Vec<SigId>,
}

impl Interrupt {
    /// Begins to listen.
    ///
    /// # Errors
    /// [`Failure::Run`] if the system takes no handler or gives no thread.
    pub(crate) fn listen() -> Result<Self, Failure> {
        Self::begin().map_err(|e| Failure::Run(format!("Ctrl-C cannot be listened to: {e}")))
    }

    fn begin() -> io::Result<Self> {
        let mut interrupt = Self { asked: Arc::default(), handlers: Vec::new() };
        let insisting = Arc::default();
        for signal in [SIGINT, SIGTERM] {
            let exit = flag::register_conditional_shutdown(signal, INTERRUPTED.into(), Arc::clone(&insisting))?;
            interrupt.handlers.push(exit);
            interrupt.handlers.push(flag::register(signal, interrupt.asked.clone())?);
        }
        // A handler may not look at the clock, so a thread does.
        let asked = Arc::downgrade(&interrupt.asked);
        Builder::new().spawn(move || {
            while let Some(asked) = asked.upgrade() {
                if asked.load(Ordering::Relaxed) {
                    sleep(SAME);
                    insisting.store(true, Ordering::Relaxed);
                    return;
                }
                drop(asked);
                sleep(LOOK);
            }
        })?;
        Ok(interrupt)
    }

    pub(crate) fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// A function for polling during a step, which says whether the step is to end between two of its substeps.
    pub(crate) fn urges(&self) -> impl FnMut() -> bool + '_ {
        let mut since = None;
        move || self.asked() && since.get_or_insert_with(Instant::now).elapsed() >= PATIENCE
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        for handler in self.handlers.drain(..) {
            signal_hook::low_level::unregister(handler);
        }
    }
}
