//! `soilsig export`: a placed scene for other programs.

use std::path::PathBuf;

use super::arguments::{Bands, Changes, ending};
use super::{Context, Outcome, usage};
use crate::geometry::ingest::Sources;
use crate::products::export::{self, To};
use crate::support::lock::Lock;
use crate::support::output;

/// Writes a placed scene as a DIRSIG bundle or for Mitsuba 3, and names what is lost
#[derive(clap::Args)]
pub struct Args {
    /// Scene file with placed geometry
    scene: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Folder to write into
    folder: PathBuf,
    /// Program to write for
    #[arg(long, value_enum)]
    to: To,
    /// Three wavelengths that Mitsuba renders as red, green and blue, um
    #[arg(long, value_name = "UM,UM,UM", value_delimiter = ',', default_value = "8.5,9,11")]
    at: Vec<f64>,
    #[command(flatten)]
    bands: Bands,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    if args.at.len() != 3 {
        return Err(usage("--at takes three wavelengths, as in 8.5,9,11"));
    }
    let scene = args.changes.read(&args.scene)?;
    let _lock = Lock::of(&args.folder)?;
    // The names of written files depend on the scene: none of its own files may be in their place.
    let endings: &[&str] = match args.to {
        To::Dirsig => &["odb", "mat", "obj", "ems"],
        To::Mitsuba => &["xml", "ply"],
    };
    let mut read: Vec<PathBuf> = Sources::read(&scene)?.files().keys().cloned().collect();
    read.extend(scene.files());
    for file in read.iter().filter(|file| endings.contains(&&*ending(file))) {
        output::keeps([file], [args.folder.join(file.file_name().unwrap_or_default())])?;
    }
    let wavelengths_um = match args.to {
        To::Dirsig => args.bands.grid()?.wavelengths_um(),
        To::Mitsuba => args.at.clone(),
    };
    let lost = export::export(&scene, args.to, &wavelengths_um, &args.folder)?;
    context.print(&format!("scene in {}\n", args.folder.display()))?;
    context.print_list("not carried over", &lost)?;
    Ok(None)
}
