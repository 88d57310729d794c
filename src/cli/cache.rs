//! `soilsig cache`: what the cache holds, and how it is emptied.

use std::collections::BTreeMap;

use super::{Context, Outcome};
use crate::support::resources::size;

/// Shows the cache of earlier results, or clears it
///
/// It keeps to a limit by itself: results that were not used for longest go first. The variable
/// SOILSIG_CACHE_SIZE sets the limit, as in 50G; SOILSIG_CACHE names the folder.
#[derive(clap::Args)]
pub struct Args {
    /// Remove all results, or those of one stage: drop, trace, picture, thin
    #[arg(long, value_name = "STAGE", num_args = 0..=1, default_missing_value = "all")]
    clear: Option<String>,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let cache = &context.cache;
    if let Some(stage) = &args.clear {
        let (number, bytes) = cache.clear(Some(&**stage).filter(|stage| *stage != "all"))?;
        context.print(&format!("{number} results removed, {}\n", size(bytes)))?;
        return Ok(None);
    }
    let mut stages: BTreeMap<String, (usize, u64)> = BTreeMap::new();
    for entry in cache.entries()? {
        let (number, bytes) = stages.entry(entry.stage).or_default();
        *number += 1;
        *bytes += entry.bytes;
    }
    let all: u64 = stages.values().map(|(_, bytes)| bytes).sum();
    let (root, limit) = (cache.root().display(), size(cache.limit()));
    let mut text = format!("{} of at most {limit} in {root}\n", size(all));
    for (stage, (number, bytes)) in stages {
        text += &format!("  {stage:<10}{number:>8} results {:>10}\n", size(bytes));
    }
    context.print(&text)?;
    Ok(None)
}
