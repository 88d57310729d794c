//! `soilsig doctor`: which Blender is found, and whether it will do.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::PathBuf;
use std::thread;

use serde_json::{Value, json};

use crate::blender::{Attempt, Blender, Outcome, Search};
use crate::support::cache::Cache;
use crate::support::error::{Error, Failure};
use crate::support::monitor::Monitor;

/// Says what is found on this machine and whether it will do.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The Blender to examine: a blender, or a Python that can import bpy
    #[arg(long, value_name = "PATH")]
    blender: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

/// Looks for a Blender afresh and prints what came of it.
///
/// # Errors
/// What is wrong, when no Blender will do.
pub fn run(args: &Args, cache: &Cache, monitor: &dyn Monitor) -> Result<(), Error> {
    let search = Search { afresh: true, ..Search::new(args.blender.as_deref(), cache.root()) };
    let attempts = search.attempts(monitor);
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let text = if args.json {
        format!("{:#}\n", in_json(&attempts, cores))
    } else {
        in_words(&attempts, cores)
    };
    // Whoever closes the pipe has read enough.
    let _ = io::stdout().write_all(text.as_bytes());
    Search::conclude(attempts)?;
    Ok(())
}

fn in_words(attempts: &[Attempt], cores: usize) -> String {
    let mut text = format!("soilsig {}, {cores} cores\n", env!("CARGO_PKG_VERSION"));
    text += "Blender is looked for in this order:\n";
    let mut found = None;
    for Attempt { place, path, outcome } in attempts {
        let at = path.as_deref().map(|path| path.display().to_string()).unwrap_or_default();
        let what = match outcome {
            Outcome::Nothing => "-".into(),
            Outcome::NoBpy => format!("{at}: a Python without bpy"),
            Outcome::Failed(error) => error.to_string(),
            Outcome::Found(blender) => {
                found = Some(blender);
                let Blender { version, python, numpy, .. } = blender;
                format!("{at}: Blender {version}, Python {python}, numpy {numpy}")
            }
        };
        let _ = writeln!(text, "  {place:<20}{what}");
    }
    let verdict = match found {
        None => "No Blender will do.".into(),
        Some(blender) => match blender.warning() {
            None => "This Blender will do.".into(),
            Some(warning) => format!("This Blender may do: {warning}."),
        },
    };
    text + &verdict + "\n"
}

fn in_json(attempts: &[Attempt], cores: usize) -> Value {
    let mut found = None;
    let mut searched = Vec::new();
    for Attempt { place, path, outcome } in attempts {
        let (problem, hint) = match outcome {
            Outcome::Nothing => (None, None),
            Outcome::NoBpy => (Some("a Python without bpy".into()), None),
            Outcome::Failed(error) => (Some(error.to_string()), error.hint()),
            Outcome::Found(blender) => {
                found = Some(blender);
                (None, None)
            }
        };
        searched.push(json!({"place": place, "path": path, "problem": problem, "hint": hint}));
    }
    json!({
        "soilsig": env!("CARGO_PKG_VERSION"),
        "cores": cores,
        "searched": searched,
        "blender": found,
        "warning": found.and_then(Blender::warning),
        "will_do": found.is_some(),
    })
}
