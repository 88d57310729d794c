//! The command line, called from Python: progress and Ctrl-C reach Python's own thread.

use std::ffi::OsString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use soilsig::Monitor;
use soilsig::Status;
use soilsig::cli::{self, Answer};

use crate::failure::raised;

/// Time after which Python is asked whether the user wants to stop.
const PATIENCE: Duration = Duration::from_millis(50);

/// What the work tells.
enum Told {
    Begin(String),
    At(u64, u64, String),
    Say(String),
    End(String, f64, String),
}

/// The monitor of work on another thread than Python's.
struct Listener {
    told: Sender<Told>,
    is_cancelled: Arc<AtomicBool>,
}

impl Listener {
    fn tell(&self, told: Told) {
        // Nobody listens any more after a second Ctrl-C.
        let _ = self.told.send(told);
    }
}

impl Monitor for Listener {
    fn begin(&self, step: &str) {
        self.tell(Told::Begin(step.into()));
    }

    fn at(&self, done: u64, total: u64, what: &str) {
        self.tell(Told::At(done, total, what.into()));
    }

    fn say(&self, text: &str) {
        self.tell(Told::Say(text.into()));
    }

    fn end(&self, step: &str, seconds: f64, note: &str) {
        self.tell(Told::End(step.into(), seconds, note.into()));
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

/// Runs a command line, its own name first. `listener` has the methods `begin`, `at`, `say` and
/// `end`, and hears of the work. Returns what the command printed, its exit status and, unless that
/// is 0, what it means.
#[pyfunction]
pub fn call(
    py: Python<'_>,
    args: Vec<OsString>,
    listener: &Bound<'_, PyAny>,
) -> PyResult<(String, u8, Option<&'static str>)> {
    let (told, heard) = mpsc::channel();
    let heard = Mutex::new(heard);
    let is_cancelled = Arc::new(AtomicBool::new(false));
    let monitor = Listener { told, is_cancelled: Arc::clone(&is_cancelled) };
    let work = thread::Builder::new()
        .name("soilsig".into())
        .spawn(move || cli::call(&args, &monitor))
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let mut stopped: Option<PyErr> = None;
    loop {
        let next = py.detach(|| {
            let heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
            // Only the last place of many is worth telling.
            heard.recv_timeout(PATIENCE).map(|first| newest(first, || heard.try_recv().ok()))
        });
        let heard = match next {
            Ok(heard) => heard,
            Err(RecvTimeoutError::Timeout) => Vec::new(),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        let passed = heard.into_iter().try_for_each(|told| pass_on(listener, told));
        if let Err(error) = passed.and_then(|()| py.check_signals()) {
            if is_cancelled.swap(true, Ordering::Relaxed) {
                // Who asks twice does not want to wait.
                return Err(error);
            }
            stopped = Some(error);
        }
    }
    let answer = py.detach(|| work.join());
    if let Some(error) = stopped {
        return Err(error);
    }
    match answer {
        Ok(Ok(Answer { text, status })) => {
            let meaning = Status::ALL.iter().find(|(of, _)| Some(*of) == status);
            let status = status.map_or(0, |status| status as u8);
            Ok((text, status, meaning.map(|(_, meaning)| *meaning)))
        }
        Ok(Err(error)) => Err(raised(error)),
        Err(_) => Err(PyRuntimeError::new_err("soilsig broke a promise of its own: see above")),
    }
}

/// All that was told by now, without places that others have replaced.
fn newest(first: Told, mut next: impl FnMut() -> Option<Told>) -> Vec<Told> {
    let mut all = vec![first];
    while let Some(told) = next() {
        if let (Some(Told::At(..)), Told::At(..)) = (all.last(), &told) {
            all.pop();
        }
        all.push(told);
    }
    all
}

fn pass_on(listener: &Bound<'_, PyAny>, told: Told) -> PyResult<()> {
    match told {
        Told::Begin(step) => listener.call_method1("begin", (step,)),
        Told::At(done, total, what) => listener.call_method1("at", (done, total, what)),
        Told::Say(text) => listener.call_method1("say", (text,)),
        Told::End(step, seconds, note) => listener.call_method1("end", (step, seconds, note)),
    }
    .map(drop)
}

/// Runs the program `soilsig` on a command line, its own name first; returns its exit status.
#[pyfunction]
pub fn program(py: Python<'_>, args: Vec<OsString>) -> u8 {
    py.detach(|| cli::run(args))
}
