//! `soilsig soil`: what a soil becomes, before Blender starts.

use std::path::PathBuf;

use super::arguments::{Changes, utf8_path};
use super::{Context, Outcome};
use crate::report::terminal;
use crate::scene::{Scene, SceneError, SoilShares};
use crate::support::file_error::FileError;

/// Shows the grains and the tray that a soil by shares becomes, without Blender
#[derive(clap::Args)]
pub struct Args {
    /// Scene file that states a soil
    #[arg(value_parser = utf8_path())]
    scene: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Print the scene with the packing in place of the soil, which is a scene file too
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let scene = Scene::read(&args.scene)?.changed(&args.changes.set)?;
    let Some(soil) = scene.soil_shares() else {
        let problem = "it states no soil: a packing has counts already";
        return Err(SceneError::from(FileError::wrong_at(&args.scene, "geometry", problem)).into());
    };
    if args.json {
        context.print_json(&scene)?;
    } else {
        context.print(&table(&soil))?;
    }
    Ok(None)
}

/// A row for each size class, and a line for the dust of each component.
fn table(soil: &SoilShares) -> String {
    let of = if soil.by_volume { "volume" } else { "mass" };
    let [x, y] = soil.tray_um;
    let mut text = format!(
        "{} grains in a tray of {x} x {y} um, seen but for a rim of {} um\n",
        soil.grains, soil.crop_um
    );
    let names = soil.components.iter().flat_map(|c| c.sizes.iter().map(|class| class.name.len()));
    let width = names.max().unwrap_or(0).clamp("class".len(), terminal::WIDEST_NAME);
    text += &format!("{:width$}  diameter_um  grains  {of} %  asked\n", "class");
    for component in &soil.components {
        for class in &component.sizes {
            text += &format!(
                "{:width$}  {:11.1}  {:6}  {:6.1}  {:5.1}\n",
                class.name,
                class.diameter_um,
                class.grains,
                100.0 * component.attained * class.attained,
                100.0 * component.asked * class.asked,
            );
        }
    }
    for component in &soil.components {
        for dust in &component.dust {
            text += &format!("{}: {}\n", component.name, dust.words());
        }
    }
    text + &soil.line() + "\n"
}
