//! One script run in Blender, from start to a result that can be trusted.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use super::process::{self, Ending};
use super::{Blender, BlenderError, Event, Kind, Trouble, scripts};
use crate::support::monitor::Monitor;
use crate::support::output::{self, OutputError};

/// A script to be run.
#[derive(Clone)]
pub struct Job<'a> {
    /// The script's name in `blender_scripts/`, such as `drop.py`.
    pub script: &'a str,
    /// Its arguments, less `--out`.
    pub args: Vec<OsString>,
    /// The folder that it writes into, passed as `--out`.
    pub out: &'a Path,
    /// Where all goes that Blender says; written while it runs, kept whatever comes.
    pub log: &'a Path,
    /// When to end it.
    pub time_limit: Duration,
    /// Whoever may end it before.
    pub monitor: &'a dyn Monitor,
}

/// A job that was done: exit status 0, a last word `done`, and every file there.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished {
    /// Files written, relative to the job's folder.
    pub files: Vec<String>,
    /// What the script warned of.
    pub warnings: Vec<String>,
    /// Wall time, s.
    pub wall_s: f64,
}

impl Blender {
    /// Runs a job to its end; every event is passed on as it comes.
    ///
    /// # Errors
    /// Anything but a full success. What the job may have written is not to be used then.
    pub fn run(
        &self,
        job: &Job,
        on_event: &mut dyn FnMut(&Event),
    ) -> Result<Finished, BlenderError> {
        let started = Instant::now();
        let scratch = Scratch::new()?;
        let mut command = scratch.command(self.kind, &self.path, job.script);
        command.args(&job.args).arg("--out").arg(job.out);

        let mut warnings = Vec::new();
        let mut last_word = None;
        let ending = run_logged(command, job.log, job.time_limit, job.monitor, &mut |event| {
            on_event(&event);
            match event {
                Event::Warning { message } => warnings.push(message),
                Event::Error { .. } | Event::Done { .. } => last_word = Some(event),
                Event::Probe { .. } | Event::Progress { .. } => {}
            }
        })?
        .map_err(|source| does_not_start(&self.path, &source))?;

        let files = self.judge(job, ending, last_word)?;
        Ok(Finished { files, warnings, wall_s: started.elapsed().as_secs_f64() })
    }

    /// Tells a success from everything else, by how Blender ended and the script's last word.
    fn judge(
        &self,
        job: &Job,
        ending: Ending,
        last_word: Option<Event>,
    ) -> Result<Vec<String>, BlenderError> {
        let path = self.path.clone();
        let log = job.log.to_owned();
        let message = match (ending, last_word) {
            (Ending::Interrupted, _) => return Err(BlenderError::Interrupted),
            (Ending::TimedOut, _) => {
                return Err(BlenderError::Timeout { path, limit: job.time_limit, log: Some(log) });
            }
            (_, Some(Event::Error { kind, message, hint })) => {
                return Err(self.error_event(kind, message, hint, log));
            }
            (Ending::Crashed(signal), _) => {
                return Err(BlenderError::Crash { path, signal, log: Some(log) });
            }
            (Ending::Exited(0), Some(Event::Done { files })) => {
                match files.iter().find(|file| !is_written(&job.out.join(file))) {
                    None => return Ok(files),
                    Some(file) => {
                        format!("{} announced {file}, which is missing or empty", job.script)
                    }
                }
            }
            (Ending::Exited(0), _) => format!("{} ended before it was done", job.script),
            (Ending::Exited(code), _) => match last_words(job.log) {
                Some(words) => format!("{} failed: {words}", job.script),
                None => format!("{} failed without a word (exit status {code})", job.script),
            },
        };
        Err(BlenderError::Script { message, remedy: None, log })
    }

    /// The error that a script reported itself.
    fn error_event(
        &self,
        kind: Trouble,
        message: String,
        remedy: Option<String>,
        log: PathBuf,
    ) -> BlenderError {
        let path = self.path.clone();
        match kind {
            Trouble::Numpy => BlenderError::NumpyMissing { kind: self.kind, path },
            Trouble::Version => BlenderError::Unsupported { path, version: self.version },
            Trouble::NotSettled
            | Trouble::Escaped
            | Trouble::Overlap
            | Trouble::Sunk
            | Trouble::Floating
            | Trouble::Nan => BlenderError::Refused { message, remedy, log },
            Trouble::Scene | Trouble::Internal => BlenderError::Script { message, remedy, log },
        }
    }
}

fn is_written(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() > 0)
}

/// The temporary folder of one start of Blender: the scripts, and Blender's own scratch files.
pub(super) struct Scratch(tempfile::TempDir);

impl Scratch {
    pub(super) fn new() -> Result<Self, OutputError> {
        let folder = tempfile::Builder::new().prefix("soilsig-").tempdir();
        let at = |source| OutputError { path: std::env::temp_dir(), source };
        let scratch = Self(folder.map_err(at)?);
        scripts::unpack(&scratch.scripts())?;
        Ok(scratch)
    }

    fn scripts(&self) -> PathBuf {
        self.0.path().join("scripts")
    }

    /// Where to log what nobody will want to read afterwards.
    pub(super) fn log(&self) -> PathBuf {
        self.0.path().join("blender.log")
    }

    /// The command that runs a script; the script's own arguments follow.
    pub(super) fn command(&self, kind: Kind, path: &Path, script: &str) -> Command {
        let mut command = process::tied_to_this_process(path);
        if kind == Kind::Executable {
            command.args(["--background", "--factory-startup", "-noaudio"]);
            // Named after the script it would not hold: a script that raises would exit with 0.
            command.args(["--python-exit-code", "13", "--python"]);
        }
        command.arg(self.scripts().join(script)).arg("--");
        process::clean_environment(&mut command, self.0.path());
        command
    }

    /// The command that opens a window with the user's own preferences and runs a script; the script's own
    /// arguments follow.
    pub(super) fn window(&self, path: &Path, more: &[OsString], script: &str) -> Command {
        let mut command = process::tied_to_this_process(path);
        command.args(more).args(["--python-exit-code", "13", "--python"]);
        command.arg(self.scripts().join(script)).arg("--");
        process::clean_environment(&mut command, self.0.path());
        // What is saved on its own is to outlive the window.
        command.env_remove("TMPDIR");
        command.envs(DISPLAY.iter().filter_map(|name| Some((name, std::env::var_os(name)?))));
        command
    }
}

/// Where a window finds its display.
const DISPLAY: [&str; 6] = [
    "DISPLAY",
    "WAYLAND_DISPLAY",
    "XAUTHORITY",
    "XDG_RUNTIME_DIR",
    "XDG_SESSION_TYPE",
    "LIBGL_ALWAYS_SOFTWARE",
];

/// Supervises a command, its events split off and all else in a log. The outer error is that of
/// the log, the inner one that of the start.
pub(super) fn run_logged(
    command: Command,
    log: &Path,
    limit: Duration,
    monitor: &dyn Monitor,
    on_event: &mut dyn FnMut(Event),
) -> Result<io::Result<Ending>, OutputError> {
    let at = |source| OutputError { path: log.to_owned(), source };
    if let Some(folder) = log.parent() {
        output::folder(folder)?;
    }
    // Written in its place, not renamed into it: it is there to be read while Blender runs.
    let mut file = File::create(log).map_err(at)?;
    let mut written = writeln!(file, "{command:?}");
    let ending = process::supervise(command, &file, limit, monitor, &mut |line| {
        let (event, text) = Event::split(line);
        if written.is_ok() {
            written = (&file).write_all(&text);
        }
        if let Some(event) = event {
            on_event(event);
        }
    });
    written.map_err(at)?;
    Ok(ending)
}

/// The error of a program that the system would not start.
pub(super) fn does_not_start(path: &Path, source: &io::Error) -> BlenderError {
    BlenderError::Unusable { path: path.to_owned(), reason: format!("it does not start: {source}") }
}

/// The end of the last Python traceback in a log, or else its last line.
pub(super) fn last_words(log: &Path) -> Option<String> {
    let text = fs::read(log).ok()?;
    let text = String::from_utf8_lossy(&text);
    // The first line is the command, written by us.
    let lines: Vec<&str> = text.lines().skip(1).filter(|line| !line.trim().is_empty()).collect();
    let raised = lines.iter().rposition(|line| line.contains("Traceback (most recent call last)"));
    raised
        .and_then(|at| lines[at + 1..].iter().find(|line| !line.starts_with(' ')))
        .or(lines.last())
        .map(|line| line.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::last_words;

    #[test]
    fn the_last_words_are_the_end_of_the_last_traceback() {
        let folder = tempfile::tempdir().unwrap();
        let words = |log: &str| {
            let path = folder.path().join("log");
            fs::write(&path, log).unwrap();
            last_words(&path)
        };
        let log = "command\nError: Python: Traceback (most recent call last):\n  File \"a\"\n\
            KeyError: 1\n\nDuring handling ...\n\nTraceback (most recent call last):\n  File \"a\"\n\
            ValueError: no\n\nError: script failed, file: 'a', exiting.\n";
        assert_eq!(words(log).as_deref(), Some("ValueError: no"));
        assert_eq!(words("command\nsome\nwords\n\n").as_deref(), Some("words"));
        assert_eq!(words("command\n"), None);
    }
}
