//! `soilsig import`: a scene of DIRSIG's files.

use std::path::{Path, PathBuf};

use super::{Context, Outcome};
use crate::products::export;
use crate::support::output;

/// Writes a scene file from DIRSIG's object database and material list, and names what is left out
#[derive(clap::Args)]
pub struct Args {
    /// Object database, .odb
    odb: PathBuf,
    /// Material list [default: the .mat beside the .odb]
    #[arg(long, value_name = "FILE")]
    mat: Option<PathBuf>,
    /// Scene file to write
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let mat = args.mat.clone().unwrap_or_else(|| args.odb.with_extension("mat"));
    output::keeps([&args.odb, &mat], [&args.out])?;
    output::may_write(&args.out)?;
    let folder = args.out.parent().unwrap_or(Path::new(""));
    let (scene, left_out) = export::import(&args.odb, &mat, folder)?;
    let text = serde_json::to_string_pretty(&scene).expect("plain data");
    output::bytes(&args.out, (text + "\n").as_bytes())?;
    context.print(&format!("scene in {}\n", args.out.display()))?;
    context.print_list("left out", &left_out)?;
    Ok(None)
}
