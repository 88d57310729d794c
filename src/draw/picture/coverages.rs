//! Beds side by side at one scale: the paper's Fig. 5.

use std::path::Path;

use super::Look;
use super::camera::{Camera, level};
use super::canvas::{Canvas, GAP, Ground, TEXT, scale_bar};
use super::grain::legend;
use super::render::{Rendered, Style, render};
use super::stage::Stage;
use crate::draw::plot::svg::{Anchor, shortened};
use crate::geometry::Bed;
use crate::geometry::ingest;
use crate::scene::Scene;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;

/// A view from the side still shows some of the top.
const MOST_FORESHORTENED: f64 = 0.2;
/// Size of the text below a name, pixels.
const SMALL: f64 = 12.0;
/// Below the panels, pixels.
const FOOT: usize = 72;

/// Draws the middle of several beds at one scale: of each as much as the narrowest bed has.
///
/// # Errors
/// A mesh cannot be read, or the file cannot be written.
pub fn coverages(
    scenes: &[Scene],
    look: Look,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(), Error> {
    let beds = scenes.iter().map(ingest::load).collect::<Result<Vec<_>, _>>()?;
    let side = |bed: &Bed| (bed.domain.max_um - bed.domain.min_um).truncate().min_element();
    let side_um = beds.iter().map(side).fold(f64::INFINITY, f64::min);
    let width = ((look.width_px + GAP) / beds.len()).saturating_sub(GAP).max(1);
    let panel = |bed: &Bed| {
        let stage = Stage::new(&bed.meshes, &bed.placements, bed.domain.floor);
        render(&stage, &middle(bed, look, side_um), width, &Style::new(monitor))
    };
    let panels: Vec<Rendered> = beds.iter().map(panel).collect::<Result<_, _>>()?;
    let Rendered { canvas: Canvas { width, height, .. }, pixel_um, ref shares } = panels[0];
    let pictures: Vec<&Canvas> = panels.iter().map(|panel| &panel.canvas).collect();
    let mut canvas = Canvas::side_by_side(&pictures, FOOT);
    let (right, line) = (canvas.width as f64 - 4.0, height as f64 + 20.0);
    canvas.annotate(|svg| {
        for (i, (panel, scene)) in panels.iter().zip(scenes).enumerate() {
            let x = (i * (width + GAP)) as f64 + 2.0;
            let name = shortened(&scene.name, TEXT, width as f64);
            svg.text((x, line), Anchor::Start, TEXT, &name);
            let seen = shortened(&seen(scene, &panel.shares), SMALL, width as f64);
            svg.styled_text((x, line + 18.0), Anchor::Start, SMALL, &seen, "fill='#555555'");
        }
        let corner = (10.0, height as f64 - 10.0);
        scale_bar(svg, corner, width, pixel_um, Ground::Picture);
        legend(svg, (right, line + 42.0), &scenes[0], shares, Ground::Paper);
    })?;
    Ok(output::bytes(path, &canvas.png(Some(pixel_um)))?)
}

/// A horizontal square about the middle of the bed.
fn middle(bed: &Bed, look: Look, side_um: f64) -> Camera {
    let to_eye = look.to_eye();
    let middle = (bed.domain.min_um + bed.domain.max_um) / 2.0;
    let (right, up) = level(to_eye);
    let right = side_um * right;
    let up = side_um * to_eye.z.max(MOST_FORESHORTENED) * up;
    Camera { corner: middle - (right + up) / 2.0, right, up, to_eye }
}

/// The share of each visible material.
fn seen(scene: &Scene, shares: &[f64]) -> String {
    let seen = scene.materials.iter().zip(shares).filter(|(_, share)| **share >= 0.005);
    let seen = seen.map(|(m, share)| format!("{} {:.0} %", m.name, 100.0 * share));
    seen.collect::<Vec<_>>().join(", ")
}
