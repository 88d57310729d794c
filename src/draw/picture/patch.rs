//! A bed as the sensor sees it, or from any side.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::camera::Camera;
use super::canvas::{Ground, scale_bar};
use super::grain::{legend, legend_width};
use super::render::{Lit, Rendered, SPACE, Style, colour, render};
use super::stage::Stage;
use super::{Look, tray};
use crate::geometry::Bed;
use crate::geometry::ingest;
use crate::scene::Scene;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;
use crate::tracer::footprint::Footprint;

/// Width of the sensor's view, pixels.
const WIDTH: usize = 640;

/// Draws the sensor's view as PNG with a scale bar and the names of the materials, each facet in
/// its material's colour. Another PNG, half as wide, gets the light on the first three materials as
/// red, green and blue: whoever knows the colours of the materials can colour the view from it.
///
/// # Errors
/// A file cannot be written, or the user stops the work.
pub fn sensor_view(
    scene: &Scene,
    bed: &Bed,
    [view, light]: [&Path; 2],
    monitor: &dyn Monitor,
) -> Result<(), Error> {
    let style = Style { rays: 2, sky: 5, ..Style::new(monitor) };
    let lit = lit(bed, WIDTH, &style)?;
    write(scene, lit.coloured(SPACE, colour), view)?;
    let canvas = lit.halved().coloured([0.0; 3], channel).canvas;
    Ok(output::bytes(light, &canvas.png(None))?)
}

/// Full light in the channel of one of the first three materials.
fn channel(material: usize) -> [f32; 3] {
    std::array::from_fn(|channel| if channel == material { 1.0 } else { 0.0 })
}

/// Draws the sensor's view of a bed or, with a look, the whole bed.
///
/// # Errors
/// A mesh cannot be read, the file cannot be written, or the user stops the work.
pub fn patch(
    scene: &Scene,
    look: Option<Look>,
    width_px: usize,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(), Error> {
    let mut bed = ingest::load(scene)?;
    let mut style = Style::new(monitor);
    let Some(look) = look else {
        return write(scene, lit(&bed, width_px, &style)?.coloured(SPACE, colour), path);
    };
    let to_eye = look.to_eye();
    if to_eye.z < 0.0 {
        style.zenith = to_eye;
    } else if let Some((z_um, material)) = bed.domain.floor {
        let (min, max) = Bed::bounds_um(&bed.meshes, &bed.placements);
        let (least, most) = (bed.domain.min_um.min(min), bed.domain.max_um.max(max));
        let walls = [least.truncate().extend(z_um), most.truncate().extend(max.z)];
        tray::add(&mut bed.meshes, &mut bed.placements, walls, material);
    }
    let stage = Stage::new(&bed.meshes, &bed.placements, None);
    write(scene, render(&stage, &framed(&bed, to_eye), look.width_px, &style)?, path)
}

/// A view of everything, with a margin.
pub(super) fn framed(bed: &Bed, to_eye: DVec3) -> Camera {
    let points = bed.placements.iter().flat_map(|placement| {
        let place = placement.to_scene;
        bed.meshes[placement.mesh]
            .vertices
            .iter()
            .map(move |v| place.transform_point3(v.as_dvec3()))
    });
    let camera = Camera::around(points, to_eye);
    let margin_um = 0.02 * DVec2::from(camera.size_um()).max_element();
    camera.widened(margin_um)
}

fn lit(bed: &Bed, width: usize, style: &Style) -> Result<Lit, Error> {
    let Footprint { corner, right, up } = Footprint::new(&bed.domain, bed.to_sensor);
    let camera = Camera { corner, right, up, to_eye: bed.to_sensor };
    let stage = Stage::of_sensor(bed);
    Lit::new(&stage, &stage, &camera, width, style)
}

fn write(scene: &Scene, rendered: Rendered, path: &Path) -> Result<(), Error> {
    let Rendered { mut canvas, pixel_um, shares } = rendered;
    let (width, bottom) = (canvas.width, canvas.height as f64 - 12.0);
    // Beside the scale bar, which takes at most a quarter.
    let fits = legend_width(scene, &shares) < 0.7 * width as f64;
    canvas.annotate(|svg| {
        scale_bar(svg, (12.0, bottom), width, pixel_um, Ground::Picture);
        if fits {
            legend(svg, (width as f64 - 20.0, bottom - 10.0), scene, &shares, Ground::Picture);
        }
    })?;
    Ok(output::bytes(path, &canvas.png(Some(pixel_um)))?)
}
