//! Ctrl-C, SIGTERM and SIGHUP as one flag that long work looks at.
//!
//! The handler only sets the flag. The work stops at its next safe point, so that temporary files
//! are removed and Blender is ended.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::support::error::Status;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler; call once, at the start of the program. A second signal ends the program
/// at once.
pub fn install() {
    // An error means that a handler is installed already.
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
