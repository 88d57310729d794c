//! How long work tells what it is at, and hears that it is to stop.

use std::time::Instant;

use super::error::{Failure, Status};

/// The work was asked to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted; nothing half-written was left")]
pub struct Interrupted;

impl Failure for Interrupted {
    fn status(&self) -> Status {
        Status::Interrupted
    }
}

/// Whoever watches long work. Every method may be called from any thread.
pub trait Monitor: Sync {
    /// A step of the work begins.
    fn begin(&self, _step: &str) {}

    /// So much is done, of so much, of what is named.
    fn at(&self, _done: u64, _total: u64, _what: &str) {}

    /// What a user is to see whatever else is shown: a warning, a plan.
    fn say(&self, _text: &str) {}

    /// A step has ended after so many seconds.
    fn end(&self, _step: &str, _seconds: f64, _note: &str) {}

    /// Whether the work is to stop. It does so at the next safe point and leaves nothing half-written.
    fn is_cancelled(&self) -> bool {
        false
    }
}

impl dyn Monitor + '_ {
    /// An error if the work is to stop.
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.is_cancelled() { Err(Interrupted) } else { Ok(()) }
    }
}

/// Watches nothing and stops nothing.
#[derive(Debug, Clone, Copy)]
pub struct Unwatched;

impl Monitor for Unwatched {}

/// One step of the work, from its beginning to [`Step::done`].
pub struct Step<'a> {
    /// Whoever watches it.
    pub monitor: &'a dyn Monitor,
    name: String,
    started: Instant,
}

impl<'a> Step<'a> {
    /// Starts a step.
    pub fn new(monitor: &'a dyn Monitor, name: &str) -> Self {
        monitor.begin(name);
        Self { monitor, name: name.to_owned(), started: Instant::now() }
    }

    /// Ends the step; returns how many seconds it took.
    pub fn done(self, note: &str) -> f64 {
        let seconds = self.started.elapsed().as_secs_f64();
        self.monitor.end(&self.name, seconds, note);
        seconds
    }
}

/// Says nothing, and stops when the other is asked to.
pub struct Silently<'a>(pub &'a dyn Monitor);

impl Monitor for Silently<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}
