//! `soilsig export`: a placed scene for other programs.

use std::path::PathBuf;

use super::{Bands, print, usage};
use crate::geometry::ingest::Sources;
use crate::products::export::{self, To};
use crate::scene::Scene;
use crate::support::error::Error;
use crate::support::output;

/// Writes a placed scene as a DIRSIG bundle or for Mitsuba 3, and says what could not be carried over
#[derive(clap::Args)]
pub struct Args {
    /// Scene file with placed geometry
    scene: PathBuf,
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

pub fn run(args: &Args) -> Result<(), Error> {
    if args.at.len() != 3 {
        usage("--at takes three wavelengths, as in 8.5,9,11");
    }
    let scene = Scene::read(&args.scene)?;
    output::folder(&args.folder)?;
    // Names are given as meshes and materials come: none of what is read may be of their kind and in their place.
    let endings: &[&str] = match args.to {
        To::Dirsig => &["odb", "mat", "obj", "ems"],
        To::Mitsuba => &["xml", "ply"],
    };
    let mut read: Vec<PathBuf> = Sources::read(&scene)?.files().keys().cloned().collect();
    let spectra = scene.materials.clone();
    for mut material in spectra {
        read.extend(material.spectrum.file_mut().map(|file| scene.path_of(file)));
    }
    for file in &read {
        let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if endings.contains(&ending.as_str()) {
            output::keeps([file], [args.folder.join(file.file_name().unwrap_or_default())])?;
        }
    }
    let wavelengths_um = match args.to {
        To::Dirsig => args.bands.grid().wavelengths_um(),
        To::Mitsuba => args.at.clone(),
    };
    let lost = export::export(&scene, args.to, &wavelengths_um, &args.folder)?;
    let lost: Vec<String> = lost.iter().map(|sentence| format!("  {sentence}\n")).collect();
    print(&format!("{}: not carried over:\n{}", args.folder.display(), lost.concat()))
}
