//! Runs a script in Blender and checks its result.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use nix::fcntl::OFlag;
use nix::sys::statvfs::statvfs;

use super::process::{self, Ending};
use super::{Blender, BlenderError, Event, Kind, Trouble, scripts};
use crate::support::monitor::Monitor;
use crate::support::output::{self, OutputError};
use crate::support::scratch::{self, ScratchError};

/// A run of a script.
#[derive(Clone)]
pub struct Job<'a> {
    /// The script's name in `blender_scripts/`, such as `drop.py`.
    pub script: &'a str,
    /// Its arguments without `--out`.
    pub args: Vec<OsString>,
    /// The folder for its files, passed as `--out`.
    pub out: &'a Path,
    /// The file for Blender's output. It is written during the run and kept after a failure.
    pub log: &'a Path,
    /// The time limit.
    pub time_limit: Duration,
    /// Can stop the run.
    pub monitor: &'a dyn Monitor,
}

impl Blender {
    /// Runs a job to its end. Passes each event to `on_event` when it arrives. Returns the files
    /// that the script wrote, relative to the job's folder.
    ///
    /// # Errors
    /// Anything but a full success. Files that the job wrote are then not to be used.
    pub fn run(
        &self,
        job: &Job,
        on_event: &mut dyn FnMut(&Event),
    ) -> Result<Vec<String>, BlenderError> {
        let scratch = Scratch::new()?;
        let mut command = scratch.command(self.kind, &self.path, job.script);
        command.args(&job.args).arg("--out").arg(job.out);

        let mut last = None;
        let (log, limit) = (job.log, job.time_limit);
        let ending = run_logged(&self.path, command, log, limit, job.monitor, &mut |event| {
            on_event(&event);
            if matches!(event, Event::Error { .. } | Event::Done { .. }) {
                last = Some(event);
            }
        })?;
        self.files(job, ending, last)
    }

    /// The files of a successful job, by Blender's ending and the script's last event.
    fn files(
        &self,
        job: &Job,
        ending: Ending,
        last: Option<Event>,
    ) -> Result<Vec<String>, BlenderError> {
        let (path, log) = (self.path.clone(), job.log.to_owned());
        let is_missing = |file: &&String| {
            !fs::metadata(job.out.join(file)).is_ok_and(|file| file.is_file() && file.len() > 0)
        };
        let problem = match (ending, last) {
            (
                Ending::Exited(_) | Ending::Crashed(_),
                Some(Event::Error { kind, message, hint: remedy }),
            ) => {
                return Err(match kind {
                    Trouble::Numpy => BlenderError::NumpyMissing { kind: self.kind, path },
                    Trouble::Version => BlenderError::Unsupported { path, version: self.version },
                    Trouble::Refused => BlenderError::Refused { message, remedy, log },
                    Trouble::Other => of_disk(job, &message).unwrap_or(BlenderError::Script {
                        message,
                        remedy,
                        log,
                    }),
                });
            }
            (Ending::Exited(0), Some(Event::Done { files })) => match files.iter().find(is_missing)
            {
                None => return Ok(files),
                Some(file) => format!("reported the file {file}, which is missing or empty"),
            },
            (Ending::Exited(0), _) => "ended before it was done".into(),
            _ => {
                let code = ending.exit_code(&path, job.time_limit, Some(job.log))?;
                format!("failed with exit status {code}: {}", last_words(job.log))
            }
        };
        let message = format!("{} {problem}", job.script);
        Err(of_disk(job, &message).unwrap_or(BlenderError::Script { message, remedy: None, log }))
    }
}

/// The error of a script that could not write, by its words or by the state of the disk.
fn of_disk(job: &Job, message: &str) -> Option<BlenderError> {
    const WORDS: [&str; 3] =
        ["No space left on device", "Disk quota exceeded", "Read-only file system"];
    let is_full = |folder: &Path| {
        statvfs(folder).is_ok_and(|disk| {
            disk.blocks_available() == 0 || (disk.files() > 0 && disk.files_available() == 0)
        })
    };
    let folders = [job.out.to_owned(), std::env::temp_dir()];
    let full = folders.into_iter().find(|folder| is_full(folder));
    let folder = full.or_else(|| {
        WORDS.iter().any(|words| message.contains(words)).then(|| job.out.to_owned())
    })?;
    let (message, log) = (message.to_owned(), job.log.to_owned());
    Some(BlenderError::Disk { folder, message, log })
}

/// The temporary folder of one start of Blender, for the scripts and Blender's own temporary files.
pub(super) struct Scratch(scratch::Scratch);

impl Scratch {
    pub(super) fn new() -> Result<Self, ScratchError> {
        let scratch = Self(scratch::Scratch::temporary()?);
        scripts::unpack(&scratch.scripts()).map_err(ScratchError)?;
        Ok(scratch)
    }

    fn scripts(&self) -> PathBuf {
        self.0.path().join("scripts")
    }

    /// A log that is removed with the folder.
    pub(super) fn log(&self) -> PathBuf {
        self.0.path().join("blender.log")
    }

    /// The command that runs a script, without the script's own arguments.
    pub(super) fn command(&self, kind: Kind, path: &Path, script: &str) -> Command {
        let mut command = process::tied_to_this_process(path);
        if kind == Kind::Executable {
            command.args(["--background", "--factory-startup", "-noaudio"]);
        }
        self.add_script(&mut command, kind, script);
        // Newer Blenders keep files there, else in the user's home.
        command.env("BLENDER_USER_RESOURCES", self.0.path());
        command
    }

    /// Adds a script to a command and cleans the command's environment.
    pub(super) fn add_script(&self, command: &mut Command, kind: Kind, script: &str) {
        if kind == Kind::Executable {
            // The exit code must stand before the script: else an exception would exit with 0.
            command.args(["--python-exit-code", "13", "--python"]);
        }
        command.arg(self.scripts().join(script)).arg("--");
        process::clean_environment(command, self.0.path());
    }
}

/// Runs a program to its end or its limit. Its events go to `on_event`, its other output to a log.
pub(super) fn run_logged(
    path: &Path,
    command: Command,
    log: &Path,
    limit: Duration,
    monitor: &dyn Monitor,
    on_event: &mut dyn FnMut(Event),
) -> Result<Ending, BlenderError> {
    let at = |source| OutputError { path: log.to_owned(), source };
    if let Some(folder) = log.parent() {
        output::folder(folder)?;
    }
    // The log stands in its place from the start, so that it can be read while Blender runs.
    let mut options = File::options();
    options.write(true).create(true).truncate(true).custom_flags(OFlag::O_NOFOLLOW.bits());
    let mut file = options.open(log).map_err(at)?;
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
    ending.map_err(|source| does_not_start(path, &source))
}

/// The error of a program that the system cannot start.
pub(super) fn does_not_start(path: &Path, source: &io::Error) -> BlenderError {
    BlenderError::Unusable { path: path.to_owned(), reason: format!("it does not start: {source}") }
}

/// The end of the last Python traceback in a log, or else its last line, as a clause.
pub(super) fn last_words(log: &Path) -> String {
    let text = fs::read(log).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    // The first line is the command.
    let lines: Vec<&str> = text.lines().skip(1).filter(|line| !line.trim().is_empty()).collect();
    let raised = lines.iter().rposition(|line| line.contains("Traceback (most recent call last)"));
    raised
        .and_then(|at| lines[at + 1..].iter().find(|line| !line.starts_with(' ')))
        .or(lines.last())
        .map_or("it printed nothing".into(), |line| format!("it printed \"{}\"", line.trim()))
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
        assert_eq!(words(log), "it printed \"ValueError: no\"");
        assert_eq!(words("command\nsome\nwords\n\n"), "it printed \"words\"");
        assert_eq!(words("command\n"), "it printed nothing");
    }
}
