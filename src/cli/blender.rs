//! `soilsig blender`: Blender's window for authoring grains.

use std::ffi::OsString;
use std::path::PathBuf;

use super::arguments::{absolute, utf8_path};
use super::{Context, Outcome};
use crate::blender;

/// Opens Blender's window to author grains over SEM images, or writes the add-on for its
/// preferences
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    what: What,
    /// Folder of your grains, where the window saves them
    #[arg(long, value_name = "FOLDER", requires = "gui")]
    grains: Option<PathBuf>,
    /// Blender to use: its executable
    #[arg(long, value_name = "PATH", value_parser = utf8_path())]
    blender: Option<PathBuf>,
    /// Arguments for Blender itself, such as a .blend file
    #[arg(last = true, requires = "gui")]
    more: Vec<OsString>,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct What {
    /// Open the window with the panel "Soilsig" in the sidebar of the 3-D view
    #[arg(long)]
    gui: bool,
    /// Write the add-on as a zip to install in Edit > Preferences: an extension from Blender 4.2 on
    #[arg(long, value_name = "FILE")]
    addon_zip: Option<PathBuf>,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    if let Some(path) = &args.what.addon_zip {
        blender::write_addon(path)?;
        context.print(&format!("add-on in {}\n", path.display()))?;
        return Ok(None);
    }
    let &Context { ref cache, monitor, .. } = context;
    let found =
        blender::find(args.blender.as_deref(), cache.blenders(), blender::PATIENCE, monitor)?;
    let grains = args.grains.as_deref().map(absolute);
    found.open_window(grains.as_deref(), &args.more, monitor)?;
    Ok(None)
}
