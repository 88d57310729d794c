//! Progress on the terminal: a bar with the time left, plain lines elsewhere, all on standard
//! error.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::interrupt;
use crate::support::monitor::Monitor;

/// A text for the terminal. Names come from files of others: what would move the cursor, or change
/// the order of the letters, is shown by its number, as JSON writes it.
pub fn escaped(text: &str) -> Cow<'_, str> {
    let is_harmful = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\t'))
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}')
            || matches!(c, '\u{2066}'..='\u{2069}')
    };
    if !text.contains(is_harmful) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::new();
    for c in text.chars() {
        if is_harmful(c) {
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// Writes a line to standard error. A result must not be lost because nobody can be told of it: that
/// it cannot be written is no error.
pub fn tell(text: &str) {
    if !text.is_empty() {
        let _ = std::io::stderr().write_all(format!("{}\n", escaped(text)).as_bytes());
    }
}

/// A message of one line, whatever names are in it.
pub fn one_line(text: &str) -> String {
    text.replace('\n', "\\n")
}

/// The user at the terminal, who may press Ctrl-C.
#[derive(Default)]
pub struct Terminal {
    bar: Mutex<Option<ProgressBar>>,
}

impl Terminal {
    fn bar(&self) -> Option<ProgressBar> {
        self.bar.lock().unwrap_or_else(PoisonError::into_inner).clone()
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
        let bar = ProgressBar::new(0).with_prefix(escaped(step).into_owned());
        bar.set_style(style.expect("the template is well-formed"));
        bar.enable_steady_tick(Duration::from_millis(100));
        *self.bar.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar);
    }

    fn at(&self, done: u64, total: u64, what: &str) {
        if let Some(bar) = self.bar() {
            bar.set_length(total);
            bar.set_position(done);
            bar.set_message(escaped(what).into_owned());
        }
    }

    fn say(&self, text: &str) {
        match self.bar() {
            Some(bar) => bar.suspend(|| tell(text)),
            None => tell(text),
        }
    }

    fn end(&self, step: &str, seconds: f64, note: &str) {
        if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).take() {
            bar.finish_and_clear();
        }
        tell(&format!("{step:10} {seconds:6.2} s  {note}"));
    }

    fn is_cancelled(&self) -> bool {
        interrupt::requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_steer_the_terminal() {
        let name = "a\u{1b}]0;title\u{7}\rb\u{9b}2J\u{202e}c\u{7f}";
        assert_eq!(escaped(name), "a\\u001b]0;title\\u0007\\u000db\\u009b2J\\u202ec\\u007f");
        let plain = "sand 8 \u{b5}m\n\tB\u{f6}den \u{571f}";
        assert!(matches!(escaped(plain), Cow::Borrowed(text) if text == plain));
        // In JSON the number stands for the letter.
        let json = serde_json::to_string(name).expect("JSON");
        let read: String = serde_json::from_str(&escaped(&json)).expect("JSON still");
        assert_eq!(read, name);
    }
}
