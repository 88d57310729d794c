//! Ctrl-C, SIGTERM and SIGHUP as one flag that long work looks at.
//!
//! Nothing is torn down in the handler: the work stops at its next safe point, so that temporary files are dropped and
//! Blender is ended on the ordinary way out.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::support::error::Status;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler; call once, at the start of the program. A second signal ends the program at once.
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
