//! Ctrl-C, SIGTERM and SIGHUP as one flag that long work looks at.
//!
//! Nothing is torn down in the handler: whoever does long work polls [`requested`], stops at the
//! next safe point and returns an error, so that temporary files are dropped and Blender is ended
//! on the ordinary way out.

use std::sync::atomic::{AtomicBool, Ordering};

use super::error::{Failure, Status};

/// The user asked to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted; nothing half-written was left")]
pub struct Interrupted;

impl Failure for Interrupted {
    fn status(&self) -> Status {
        Status::Interrupted
    }
}

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler; call once, at the start of the program. A second signal ends the program
/// at once.
pub fn install() {
    // An error means that a handler stands already: then there is nothing to do.
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(Status::Interrupted as i32);
        }
    });
}

/// Whether the user asked to stop.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
