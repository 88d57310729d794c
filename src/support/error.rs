//! How a failure reaches the user: a message, a hint, an exit status.
//!
//! Every module has its own error type and implements [`Failure`] beside it. [`Error`] carries any
//! of them, so a new failure touches one file.

use std::fmt;

/// Exit statuses of the program, so that scripts can tell failures apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Status {
    /// A file could not be read or written.
    Files = 1,
    /// The command line is wrong (clap's own status).
    Usage = 2,
    /// A scene, spectrum, mesh or table is wrong.
    Input = 3,
    /// The limit on paths or time ended the trace before its tolerance; the result is written.
    ToleranceNotReached = 4,
    /// A replayed run gave other bytes, or two results differ beyond their errors.
    Differs = 5,
    /// No parameter makes the fit good; the result is written.
    NoGoodFit = 6,
    /// Some beds of a sweep failed; the results of the others are written.
    BedsFailed = 7,
    /// No Blender was found.
    BlenderMissing = 10,
    /// The Blender found has a version that soilsig cannot use.
    BlenderVersion = 11,
    /// Blender's Python has no numpy.
    BlenderNumpy = 12,
    /// A script failed inside Blender.
    BlenderScript = 13,
    /// Blender crashed.
    BlenderCrash = 14,
    /// Blender did not end within its time limit.
    BlenderTimeout = 15,
    /// The settled bed failed its checks.
    BlenderRefused = 16,
    /// Ctrl-C.
    Interrupted = 130,
}

impl Status {
    /// All of them, with their meanings.
    pub const ALL: [(Self, &str); 15] = [
        (Self::Files, "a file could not be read or written"),
        (Self::Usage, "the command line is wrong"),
        (Self::Input, "a scene, spectrum, mesh or table is wrong"),
        (Self::ToleranceNotReached, "the result is written, but its tolerance was not reached"),
        (
            Self::Differs,
            "a replayed run gave other bytes, or two results differ beyond their errors",
        ),
        (Self::NoGoodFit, "the result is written, but no parameter makes the fit good"),
        (Self::BedsFailed, "some beds of a sweep failed; the results of the others are written"),
        (Self::BlenderMissing, "no Blender was found"),
        (Self::BlenderVersion, "Blender has a version that soilsig cannot use"),
        (Self::BlenderNumpy, "Blender's Python has no numpy"),
        (Self::BlenderScript, "a script failed inside Blender"),
        (Self::BlenderCrash, "Blender crashed"),
        (Self::BlenderTimeout, "Blender did not end within its time limit"),
        (Self::BlenderRefused, "the bed that came out of the drop failed its checks"),
        (Self::Interrupted, "the user interrupted the program"),
    ];
}

/// A failure that the user sees. Its `Display` says what happened and where.
pub trait Failure: std::error::Error + Send + Sync + 'static {
    /// What the user can do about it.
    fn hint(&self) -> Option<String> {
        None
    }

    /// The program's exit status. Most failures are wrong input.
    fn status(&self) -> Status {
        Status::Input
    }
}

/// Any failure of the library.
pub struct Error(Box<dyn Failure>);

impl Error {
    /// What the user can do about it.
    pub fn hint(&self) -> Option<String> {
        self.0.hint()
    }

    /// The program's exit status.
    pub fn status(&self) -> Status {
        self.0.status()
    }

    /// The failure itself, if it is of this kind.
    ///
    /// # Errors
    /// This error, if it is of another kind.
    pub fn downcast<E: Failure>(self) -> Result<E, Self> {
        let failure: &(dyn std::error::Error + 'static) = &*self.0;
        if !failure.is::<E>() {
            return Err(self);
        }
        let failure: Box<dyn std::error::Error> = self.0;
        Ok(*failure.downcast().expect("it is of this kind"))
    }

    /// Whether the user asked to stop.
    pub fn is_interruption(&self) -> bool {
        self.status() == Status::Interrupted
    }
}

// As with `anyhow::Error`, this holds because `Error` itself is no `Failure`.
impl<E: Failure> From<E> for Error {
    fn from(failure: E) -> Self {
        Self(Box::new(failure))
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source()
    }
}
