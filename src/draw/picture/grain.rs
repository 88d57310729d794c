//! One grain with its fines: the paper's Fig. 3(a).

use std::path::Path;

use glam::DVec3;

use super::canvas::{Canvas, Ground, TEXT, scale_bar};
use super::patch::framed;
use super::render::{Rendered, Style, colour, render};
use super::stage::Stage;
use super::{Look, PictureError};
use crate::draw::plot::svg::{Anchor, Svg, text_width};
use crate::geometry::ingest;
use crate::scene::{Material, Origin, Placed, Prototype, Scene, SceneGeometry};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::monitor::Monitor;
use crate::support::output;

/// Height of the line below the picture, pixels.
pub(super) const FOOT: usize = 36;

/// Draws a prototype of a placed scene: the named one, else the first.
///
/// # Errors
/// There is no such prototype, its mesh cannot be read, or the file cannot be written.
pub fn grain(
    scene: &Scene,
    prototype: Option<&str>,
    look: Look,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(), Error> {
    let placed = scene.placed()?;
    let wanted = |one: &&Prototype| prototype.is_none_or(|name| one.name == name);
    let chosen = placed.prototypes.iter().find(wanted).ok_or_else(|| {
        let names: Vec<&str> = placed.prototypes.iter().map(|one| one.name.as_str()).collect();
        let (wanted, known) = (prototype.unwrap_or_default(), names.join(", "));
        let problem = format!("there is no prototype {wanted:?}: it has {known}");
        PictureError::from(FileError::wrong(&scene.file, problem))
    })?;
    let placed = Placed {
        prototypes: vec![chosen.clone()],
        instances: None,
        domain: None,
        origin: Origin::Given,
        drop: None,
    };
    let alone = Scene { geometry: SceneGeometry::Placed(placed), ..scene.clone() };
    let bed = ingest::load(&alone)?;
    let to_eye = look.to_eye();
    // The sky is above and behind the eye, so that the visible sides are lit.
    let zenith = (DVec3::Z + to_eye).try_normalize().unwrap_or(to_eye);
    let style = Style { sky: 63, zenith, ..Style::new(monitor) };
    let stage = Stage::new(&bed.meshes, &bed.placements, None);
    let Rendered { canvas: picture, pixel_um, shares } =
        render(&stage, &framed(&bed, to_eye), look.width_px, &style)?;
    let (width, height) = (picture.width as f64, picture.height as f64);
    let mut canvas = Canvas::side_by_side(&[&picture], FOOT);
    canvas.annotate(|svg| {
        scale_bar(svg, (12.0, height - 4.0), picture.width, pixel_um, Ground::Paper);
        let line = height + 24.0;
        svg.text((12.0, line), Anchor::Start, TEXT, &chosen.name);
        legend(svg, (width - 12.0, line), scene, &shares, Ground::Paper);
    })?;
    Ok(output::bytes(path, &canvas.png(Some(pixel_um)))?)
}

/// Names and colours of the visible materials, up to the right end of a line.
pub(super) fn legend(
    svg: &mut Svg,
    (mut right, line): (f64, f64),
    scene: &Scene,
    shares: &[f64],
    ground: Ground,
) {
    let shown: Vec<(usize, &Material)> = visible(scene, shares).collect();
    let width: f64 = shown.iter().map(|(_, material)| entry_width(material)).sum();
    let ink = match ground {
        Ground::Paper => "",
        Ground::Picture => {
            let style = "rx='3' fill='#000000' fill-opacity='0.6'";
            svg.rectangle((right - width - 6.0, line - 20.0), (width + 14.0, 30.0), style);
            "fill='#ffffff'"
        }
    };
    for (number, material) in shown.into_iter().rev() {
        right -= text_width(&material.name, TEXT);
        svg.styled_text((right, line), Anchor::Start, TEXT, &material.name, ink);
        let [r, g, b] = colour(number).map(|level| (255.0 * level).round());
        let fill = format!("fill='rgb({r},{g},{b})' stroke='#555555' stroke-width='1'");
        svg.rectangle((right - 20.0, line - 12.0), (14.0, 14.0), &fill);
        right -= BETWEEN;
    }
}

/// Width of a legend, pixels.
pub(super) fn legend_width(scene: &Scene, shares: &[f64]) -> f64 {
    visible(scene, shares).map(|(_, material)| entry_width(material)).sum()
}

/// From the left end of a name to the end of the one before it, pixels.
const BETWEEN: f64 = 36.0;

fn entry_width(material: &Material) -> f64 {
    text_width(&material.name, TEXT) + BETWEEN
}

fn visible<'a>(scene: &'a Scene, shares: &'a [f64]) -> impl Iterator<Item = (usize, &'a Material)> {
    let materials = scene.materials.iter().enumerate();
    materials.filter(|(number, _)| shares.get(*number).is_some_and(|share| *share > 0.0))
}
