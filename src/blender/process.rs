//! A child process with its own process group, a clean environment and a time limit.

use std::env;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::LazyLock;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;

use super::BlenderError;
use crate::support::monitor::Monitor;

/// The interval at which the time limit, the user's interrupt and the child's end are checked.
const POLL: Duration = Duration::from_millis(20);
/// The time for a process to end when asked, and for its pipe to close after its end.
const GRACE: Duration = Duration::from_secs(1);

/// How a process ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// It exited with this code.
    Exited(i32),
    /// A signal ended it that was not ours.
    Crashed(Signal),
    /// It was stopped at its time limit.
    TimedOut,
    /// It was stopped because the user interrupted.
    Interrupted,
}

impl Ending {
    /// The exit code of a program that ended by itself.
    ///
    /// # Errors
    /// A crash, the time limit, an interrupt.
    pub(super) fn exit_code(
        self,
        path: &Path,
        limit: Duration,
        log: Option<&Path>,
    ) -> Result<i32, BlenderError> {
        let (path, log) = (path.to_owned(), log.map(PathBuf::from));
        match self {
            Self::Exited(code) => Ok(code),
            Self::Crashed(signal) => Err(BlenderError::Crash { path, signal, log }),
            Self::TimedOut => Err(BlenderError::Timeout { path, limit, log }),
            Self::Interrupted => Err(BlenderError::Interrupted),
        }
    }
}

impl From<ExitStatus> for Ending {
    /// A shell that starts Blender reports a signal as the exit code 128 + the signal.
    fn from(status: ExitStatus) -> Self {
        let code = status.code().unwrap_or_default();
        let number = status.signal().unwrap_or(code - 128);
        Signal::try_from(number).map_or(Self::Exited(code), Self::Crashed)
    }
}

/// A command whose process the system kills when this process dies.
///
/// Only the child can ask for this (`PR_SET_PDEATHSIG`). util-linux's `setpriv` asks, then becomes a
/// shell, which becomes the program if this process still lives: it may have died before it was
/// asked. Without `setpriv` the program is started directly.
pub(super) fn tied_to_this_process(program: impl AsRef<OsStr>) -> Command {
    const SETPRIV: [&str; 4] = ["/usr/bin/setpriv", "--pdeathsig", "KILL", "--"];
    const SHELL: [&str; 3] = ["/bin/sh", "-c", "[ \"$PPID\" = \"$0\" ] && exec \"$@\""];
    static WORKS: LazyLock<bool> = LazyLock::new(|| {
        let mut trial = Command::new(SETPRIV[0]);
        trial.args(&SETPRIV[1..]).args(SHELL).arg(std::process::id().to_string()).arg("true");
        trial.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        trial.status().is_ok_and(|status| status.success())
    });
    if *WORKS {
        let mut command = Command::new(SETPRIV[0]);
        command.args(&SETPRIV[1..]).args(SHELL).arg(std::process::id().to_string()).arg(program);
        command
    } else {
        Command::new(program)
    }
}

/// Keeps only the environment variables that a Blender may need to start.
///
/// Debian's Blender takes its Python's prefix from the first `python3` on PATH and obeys `PYTHON*`:
/// a pyenv or an active virtual environment would hide its numpy. `scratch` becomes Blender's
/// temporary folder, so that no files remain if Blender is killed.
pub(super) fn clean_environment(command: &mut Command, scratch: &Path) {
    const KEPT: [&str; 4] = ["HOME", "LD_LIBRARY_PATH", "OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"];
    command.env_clear();
    command.envs(KEPT.iter().filter_map(|name| Some((name, env::var_os(name)?))));
    command.env("PATH", "/usr/bin:/bin").env("LC_ALL", "C.UTF-8").env("TMPDIR", scratch);
    // The order of Python's sets must be the same in every run.
    command.env("PYTHONHASHSEED", "0").env("PYTHONUNBUFFERED", "1");
}

/// Runs a command to its end or its limit. Passes the lines of its stdout to `on_line` and writes
/// its stderr to `errors`.
pub(super) fn supervise(
    mut command: Command,
    errors: &File,
    limit: Duration,
    monitor: &dyn Monitor,
    on_line: &mut dyn FnMut(&[u8]),
) -> io::Result<Ending> {
    // A limit beyond what a clock can tell is none.
    let deadline = Instant::now().checked_add(limit);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(errors.try_clone()?);
    let mut group = Group(command.process_group(0).spawn()?);
    let lines = lines_of(group.0.stdout.take().expect("stdout is piped"));
    let mut is_open = true;
    let mut ended: Option<(Ending, Instant)> = None;
    loop {
        match lines.recv_timeout(POLL) {
            Ok(line) => on_line(&line),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => is_open = false,
        }
        if ended.is_none() {
            ended = group.0.try_wait()?.map(|status| (status.into(), Instant::now()));
        }
        match ended {
            Some((ending, _)) if !is_open => return Ok(ending),
            // A child of it still holds its stdout: dropping the group ends that child.
            Some((ending, since)) if since.elapsed() > GRACE => return Ok(ending),
            None if monitor.is_cancelled() => return Ok(Ending::Interrupted),
            None if deadline.is_some_and(|deadline| Instant::now() > deadline) => {
                return Ok(Ending::TimedOut);
            }
            None if !is_open => thread::sleep(POLL),
            Some(_) | None => {}
        }
    }
}

/// The lines of a pipe. A thread reads them until the pipe or the receiver closes.
fn lines_of(pipe: impl io::Read + Send + 'static) -> mpsc::Receiver<Vec<u8>> {
    let (sender, receiver) = mpsc::sync_channel(1024);
    thread::spawn(move || {
        let mut reader = BufReader::new(pipe);
        let mut line = Vec::new();
        while reader.read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
            if sender.send(std::mem::take(&mut line)).is_err() {
                break;
            }
        }
    });
    receiver
}

/// A child and all processes that it started. Dropping this value ends them.
struct Group(Child);

impl Drop for Group {
    fn drop(&mut self) {
        let id = Pid::from_raw(self.0.id().cast_signed());
        // The group may have ended already.
        let _ = killpg(id, Signal::SIGTERM);
        let asked = Instant::now();
        while matches!(self.0.try_wait(), Ok(None)) && asked.elapsed() < GRACE {
            thread::sleep(POLL);
        }
        let _ = killpg(id, Signal::SIGKILL);
        let _ = self.0.wait();
    }
}
