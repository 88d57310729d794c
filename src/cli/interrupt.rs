//! Ctrl-C, SIGTERM and SIGHUP as one flag that long work looks at.
//!
//! The handler only sets the flag. The work stops at its next safe point, so that temporary files
//! are removed and Blender is ended. Where there is none for some time, as in a read that waits for
//! the other end of a pipe, the program ends from here.

use std::sync::atomic::{AtomicBool, Ordering};

use std::thread;
use std::time::Duration;

use super::terminal::tell;
use crate::support::error::Status;
use crate::support::scratch;

/// Time for the work to stop by itself. Blender has half of it.
const PATIENCE: Duration = Duration::from_secs(2);

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Installs the handler; call once, at the start of the program. A second signal ends the program
/// at once.
pub fn install() {
    // An error means that a handler is installed already.
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            end();
        }
        thread::spawn(|| {
            thread::sleep(PATIENCE);
            end();
        });
    });
}

/// Ends the program. Files are renamed when they are whole, so only hidden ones are there to remove.
fn end() -> ! {
    scratch::remove_all_in_use();
    tell("error: interrupted; no half-written file is left");
    std::process::exit(Status::Interrupted as i32);
}

/// Whether the user asked to stop.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
