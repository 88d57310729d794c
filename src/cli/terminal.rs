//! Progress on the terminal: a bar with the time left, plain lines elsewhere, all on standard
//! error.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt;
use crate::support::monitor::Monitor;

/// The user at the terminal, who may press Ctrl-C.
#[derive(Default)]
pub struct Terminal {
    bar: Mutex<Option<ProgressBar>>,
}

impl Terminal {
    fn bar(&self) -> Option<ProgressBar> {
        self.bar.lock().expect("no panic holds it").clone()
    }
}

impl Monitor for Terminal {
    fn begin(&self, step: &str) {
        if !std::io::stderr().is_terminal() {
            return;
        }
        let style = ProgressStyle::with_template(
            "{spinner} {prefix:10} {bar:32} {percent:>3} %  {elapsed} (left {eta})  {msg}",
        );
        let bar = ProgressBar::new(0).with_prefix(step.to_owned());
        bar.set_style(style.expect("the template is well-formed"));
        bar.enable_steady_tick(Duration::from_millis(100));
        *self.bar.lock().expect("no panic holds it") = Some(bar);
    }

    fn at(&self, done: u64, total: u64, what: &str) {
        if let Some(bar) = self.bar() {
            bar.set_length(total);
            bar.set_position(done);
            bar.set_message(what.to_owned());
        }
    }

    fn say(&self, text: &str) {
        match self.bar() {
            Some(bar) => bar.suspend(|| eprintln!("{text}")),
            None => eprintln!("{text}"),
        }
    }

    fn end(&self, step: &str, seconds: f64, note: &str) {
        if let Some(bar) = self.bar.lock().expect("no panic holds it").take() {
            bar.finish_and_clear();
        }
        eprintln!("{step:10} {seconds:6.2} s  {note}");
    }

    fn is_cancelled(&self) -> bool {
        interrupt::requested()
    }
}
