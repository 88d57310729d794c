//! `soilsig doctor`: the Blender that is found, and whether it will do.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::thread;

use serde_json::{Value, json};

use super::Context;
use crate::blender::{Attempt, Blender, Outcome, Search};
use crate::support::error::Failure;

/// Looks for Blender and says whether it will do
#[derive(clap::Args)]
pub struct Args {
    /// The Blender to examine: its executable, or a Python that can import bpy
    #[arg(long, value_name = "PATH")]
    blender: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, context: &Context) -> super::Outcome {
    let root = context.cache.root();
    let search = Search { afresh: true, ..Search::new(args.blender.as_deref(), root) };
    let attempts = search.attempts(context.monitor);
    let cores = thread::available_parallelism().map_or(1, usize::from);
    if args.json {
        context.print_json(&in_json(&attempts, cores))?;
    } else {
        context.print(&in_words(&attempts, cores))?;
    }
    Search::conclude(attempts)?;
    Ok(None)
}

fn in_words(attempts: &[Attempt], cores: usize) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let mut text =
        format!("soilsig {version}, {cores} cores; Blender is looked for in this order:\n");
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
    let verdict = found.map_or("No Blender will do".to_owned(), |blender| {
        let what = format!("Blender {} at {}", blender.version, blender.path.display());
        blender.warning().map_or(format!("{what} will do"), |why| format!("{what} may do: {why}"))
    });
    verdict + "\n" + &text
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
