//! Progress of long work, and its cancellation.

use std::time::Instant;

use super::error::{Failure, Status};

/// The user asked the work to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted; no half-written file is left")]
pub struct Interrupted;

impl Failure for Interrupted {
    fn status(&self) -> Status {
        Status::Interrupted
    }
}

/// Receives progress and can cancel the work. Any thread may call every method.
pub trait Monitor: Sync {
    /// A step of the work begins.
    fn begin(&self, _step: &str) {}

    /// `done` of `total` units of `what` are done.
    fn at(&self, _done: u64, _total: u64, _what: &str) {}

    /// A text that the user must see: a warning, a plan.
    fn say(&self, _text: &str) {}

    /// A step has ended; it took `_seconds`.
    fn end(&self, _step: &str, _seconds: f64, _note: &str) {}

    /// Whether the work must stop. It stops at the next safe point and leaves no half-written file.
    fn is_cancelled(&self) -> bool {
        false
    }
}

impl dyn Monitor + '_ {
    /// An error if the work must stop.
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.is_cancelled() { Err(Interrupted) } else { Ok(()) }
    }
}

/// Shows nothing and never cancels.
#[derive(Debug, Clone, Copy)]
pub struct Unwatched;

impl Monitor for Unwatched {}

/// One step of the work, from its beginning to [`Step::done`].
pub struct Step<'a> {
    /// The monitor that it reports to.
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

    /// Ends the step; returns its duration, s.
    pub fn done(self, note: &str) -> f64 {
        let seconds = self.started.elapsed().as_secs_f64();
        self.monitor.end(&self.name, seconds, note);
        seconds
    }
}

/// Shows warnings and no progress; cancels when the inner monitor does.
pub struct Silently<'a>(pub &'a dyn Monitor);

impl Monitor for Silently<'_> {
    fn say(&self, text: &str) {
        self.0.say(text);
    }

    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}
