//! A child process under control: own process group, clean environment, time limit.

use std::env;
use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::LazyLock;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;

use crate::support::monitor::Monitor;

/// How often the limit, the user's wish to stop and the child's end are looked at.
const POLL: Duration = Duration::from_millis(20);
/// How long a process may take to end when asked, and its pipe to close when it has ended.
const GRACE: Duration = Duration::from_secs(2);

/// How a process ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// By itself, with this code.
    Exited(i32),
    /// By a signal that was not ours.
    Crashed(Signal),
    /// It was ended at its time limit.
    TimedOut,
    /// It was ended because the user asked to stop.
    Interrupted,
}

impl From<ExitStatus> for Ending {
    /// A shell between us and Blender reports its death by a signal as 128 + the signal.
    fn from(status: ExitStatus) -> Self {
        let code = status.code().unwrap_or_default();
        let number = status.signal().unwrap_or(code - 128);
        Signal::try_from(number).map_or(Self::Exited(code), Self::Crashed)
    }
}

/// A command that the system kills should this process die without a chance to end it.
///
/// That is `prctl(PR_SET_PDEATHSIG)`, which only the child itself can call: util-linux's `setpriv`
/// does it and becomes the program. Where there is none the program is started plainly.
pub(super) fn tied_to_this_process(program: impl AsRef<OsStr>) -> Command {
    const SETPRIV: [&str; 4] = ["/usr/bin/setpriv", "--pdeathsig", "KILL", "--"];
    static WORKS: LazyLock<bool> = LazyLock::new(|| {
        let mut trial = Command::new(SETPRIV[0]);
        trial.args(&SETPRIV[1..]).arg("true").stdin(Stdio::null());
        trial.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|s| s.success())
    });
    if *WORKS {
        let mut command = Command::new(SETPRIV[0]);
        command.args(&SETPRIV[1..]).arg(program);
        command
    } else {
        Command::new(program)
    }
}

/// Leaves of the user's environment only what a Blender may need to start at all.
///
/// Debian's Blender takes its Python's prefix from the first `python3` on PATH and obeys `PYTHON*`:
/// a pyenv or an active virtual environment would hide its numpy. `scratch` becomes its temporary
/// folder, so that a Blender that is killed leaves nothing behind.
pub(super) fn clean_environment(command: &mut Command, scratch: &Path) {
    const KEPT: [&str; 4] = ["HOME", "LD_LIBRARY_PATH", "OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"];
    command.env_clear();
    command.envs(KEPT.iter().filter_map(|name| Some((name, env::var_os(name)?))));
    command.env("PATH", "/usr/bin:/bin").env("LC_ALL", "C.UTF-8").env("TMPDIR", scratch);
    // The order of Python's sets must not change from run to run.
    command.env("PYTHONHASHSEED", "0").env("PYTHONUNBUFFERED", "1");
}

/// Runs a command to its end or its limit: its stdout line by line to `on_line`, its stderr into
/// `errors`.
pub(super) fn supervise(
    mut command: Command,
    errors: &File,
    limit: Duration,
    monitor: &dyn Monitor,
    on_line: &mut dyn FnMut(&[u8]),
) -> io::Result<Ending> {
    let deadline = Instant::now() + limit;
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
            // Something that it started still holds its stdout: dropping the group ends that.
            Some((ending, since)) if since.elapsed() > GRACE => return Ok(ending),
            None if monitor.is_cancelled() => return Ok(Ending::Interrupted),
            None if Instant::now() > deadline => return Ok(Ending::TimedOut),
            None if !is_open => thread::sleep(POLL),
            Some(_) | None => {}
        }
    }
}

/// The lines of a pipe, read by a thread that ends with the pipe or with the receiver.
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

/// A child and all that it started; none of them outlives this value.
struct Group(Child);

impl Drop for Group {
    fn drop(&mut self) {
        let id = Pid::from_raw(self.0.id().cast_signed());
        // A group that is gone already is no error here.
        let _ = killpg(id, Signal::SIGTERM);
        let asked = Instant::now();
        while matches!(self.0.try_wait(), Ok(None)) && asked.elapsed() < GRACE {
            thread::sleep(POLL);
        }
        let _ = killpg(id, Signal::SIGKILL);
        let _ = self.0.wait();
    }
}
