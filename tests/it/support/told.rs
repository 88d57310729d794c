//! What was said, as text for snapshots.

use std::env;
use std::fmt::Display;

/// An error of the library with its hint, as a line of a snapshot.
pub fn message(error: &impl Display, hint: Option<impl Display>) -> String {
    let hint = hint.map_or(String::new(), |hint| format!("\n  hint: {hint}"));
    without_places(&format!("{error}{hint}\n"))
}

/// What a command said, with its exit status and without the times of its stages.
pub fn told(args: &[&str], status: i32, said: &str) -> String {
    let is_stage = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        words.windows(2).any(|pair| pair[1] == "s" && pair[0].parse::<f64>().is_ok())
    };
    let lines =
        said.lines().filter(|line| !line.starts_with(char::is_alphabetic) || !is_stage(line));
    let said: String = lines.flat_map(|line| [line, "\n"]).collect();
    without_places(&format!("$ soilsig {}\n{said}[exit status {status}]\n\n", args.join(" ")))
}

/// The text without the places of this machine and this run.
pub fn without_places(text: &str) -> String {
    let temporary = env::temp_dir().join(".tmp").display().to_string();
    let mut parts = text.split(&temporary);
    let first = parts.next().expect("the text before").to_owned();
    // tempfile's names end in six letters.
    let rest = parts.map(|part| format!("[here]{}", &part[6..]));
    rest.fold(first, |text, part| text + &part).replace(env!("CARGO_MANIFEST_DIR"), "[soilsig]")
}

/// The text with `#` in place of each number that has a fraction: what depends on the paths traced.
pub fn without_fractions(text: &str) -> String {
    replace_numbers(text, |number| number.contains('.'))
}

/// The text with `#` in place of each number: what depends on the Blender.
pub fn without_numbers(text: &str) -> String {
    replace_numbers(text, |_| true)
}

fn replace_numbers(text: &str, is_of_chance: impl Fn(&str) -> bool) -> String {
    let (mut left, mut found) = (text, String::new());
    while let Some(at) = left.find(|c: char| c.is_ascii_digit()) {
        let (before, number) = left.split_at(at);
        let end = number.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(number.len());
        let whole = number[..end].trim_end_matches('.');
        found += before;
        found += if is_of_chance(whole) { "#" } else { whole };
        left = &number[whole.len()..];
    }
    found + left
}
