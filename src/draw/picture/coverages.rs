//! Beds side by side at one scale: the paper's Fig. 5.

use std::path::Path;

use glam::DVec3;

use super::Look;
use super::camera::{Camera, level};
use super::canvas::{Canvas, Ground, TEXT, scale_bar};
use super::grain::legend;
use super::patch::PAPER;
use super::render::{Rendered, Style, render};
use super::stage::Stage;
use crate::draw::plot::svg::{Anchor, shortened};
use crate::geometry::Bed;
use crate::geometry::ingest;
use crate::scene::Scene;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;

/// A view from the side still shows something of the top.
const MOST_FORESHORTENED: f64 = 0.2;
/// Size of what stands below a name, pixels.
const SMALL: f64 = 12.0;
/// Below the panels, pixels.
const FOOT: usize = 72;
/// Between panels, pixels.
const GAP: usize = 8;

/// Draws as much of the middle of each of several beds as the narrowest holds, at one scale.
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
    let style = Style { rays: 3, sky: 31, zenith: DVec3::Z, background: PAPER, monitor };
    let mut panels: Vec<Rendered> = Vec::new();
    for bed in &beds {
        let stage = Stage::new(&bed.meshes, &bed.placements, bed.domain.floor);
        panels.push(render(&stage, &middle(bed, look, side_um), width, &style)?);
    }
    let Canvas { width, height, .. } = panels[0].canvas;
    let pixel_um = panels[0].pixel_um;
    let total = panels.len() * (width + GAP) - GAP;
    let mut canvas = Canvas::new(total, height + FOOT, [255; 3]);
    let left = |i: usize| i * (width + GAP);
    for (i, panel) in panels.iter().enumerate() {
        canvas.paste((left(i), 0), &panel.canvas);
    }
    canvas.annotate(|svg| {
        let line = height as f64 + 20.0;
        for (i, (panel, scene)) in panels.iter().zip(scenes).enumerate() {
            let x = left(i) as f64 + 2.0;
            let name = shortened(&scene.name, TEXT, width as f64);
            svg.text((x, line), Anchor::Start, TEXT, &name);
            let seen = shortened(&seen(scene, &panel.shares), SMALL, width as f64);
            svg.styled_text((x, line + 18.0), Anchor::Start, SMALL, &seen, "fill='#555555'");
        }
        let corner = (10.0, height as f64 - 10.0);
        scale_bar(svg, corner, width as f64 * pixel_um, pixel_um, Ground::Picture);
        legend(svg, (total as f64 - 4.0, line + 42.0), &scenes[0], &panels[0].shares);
    })?;
    Ok(output::bytes(path, &canvas.png(pixel_um))?)
}

/// A level square about the middle of the bed, foreshortened.
fn middle(bed: &Bed, look: Look, side_um: f64) -> Camera {
    let to_eye = look.to_eye();
    let middle = (bed.domain.min_um + bed.domain.max_um) / 2.0;
    let (right, up) = level(to_eye);
    let right = side_um * right;
    let up = side_um * to_eye.z.max(MOST_FORESHORTENED) * up;
    Camera { corner: middle - (right + up) / 2.0, right, up, to_eye }
}

/// How much is seen of each material.
fn seen(scene: &Scene, shares: &[f64]) -> String {
    let seen = scene.materials.iter().zip(shares).filter(|(_, share)| **share >= 0.005);
    let seen = seen.map(|(m, share)| format!("{} {:.0} %", m.name, 100.0 * share));
    seen.collect::<Vec<_>>().join(", ")
}
