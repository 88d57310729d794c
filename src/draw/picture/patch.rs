//! A bed: as the sensor sees it, or from any side.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::camera::Camera;
use super::canvas::{Ground, scale_bar};
use super::render::{Rendered, Style, render};
use super::stage::Stage;
use super::{Look, tray};
use crate::geometry::Bed;
use crate::geometry::ingest;
use crate::scene::Scene;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;
use crate::tracer::footprint::Footprint;

/// Pixels along the width of the sensor's view.
const WIDTH: usize = 640;
/// Where the sensor meets nothing.
const SPACE: [f32; 3] = [0.12, 0.15, 0.20];
/// Behind a bed in the open.
pub(super) const PAPER: [f32; 3] = [1.0; 3];

/// Draws what the sensor sees, each facet in its material's colour, as PNG with a scale bar.
pub fn sensor_view(bed: &Bed, path: &Path, monitor: &dyn Monitor) -> Result<(), Error> {
    let style = Style { rays: 2, sky: 5, zenith: DVec3::Z, background: SPACE, monitor };
    write(rendered(bed, WIDTH, &style)?, path)
}

/// Draws a bed as the sensor sees it or, if a look is given, all of it from there.
pub fn patch(
    scene: &Scene,
    look: Option<Look>,
    width_px: usize,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(), Error> {
    let mut bed = ingest::load(scene)?;
    let mut style = Style { rays: 3, sky: 31, zenith: DVec3::Z, background: SPACE, monitor };
    let Some(look) = look else { return write(rendered(&bed, width_px, &style)?, path) };
    let to_eye = look.to_eye();
    style.background = PAPER;
    if to_eye.z < 0.0 {
        style.zenith = to_eye;
    } else if let Some((z_um, material)) = bed.domain.floor {
        let (min, max) = Bed::bounds_um(&bed.meshes, &bed.placements);
        let (least, most) = (bed.domain.min_um.min(min), bed.domain.max_um.max(max));
        let walls = [least.truncate().extend(z_um), most.truncate().extend(max.z)];
        tray::add(&mut bed.meshes, &mut bed.placements, walls, material);
    }
    let camera = framed(&bed, to_eye);
    let stage = Stage::new(&bed.meshes, &bed.placements, None);
    write(render(&stage, &camera, look.width_px, &style)?, path)
}

/// A view of all that there is, with a margin.
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

/// The sensor's view.
fn rendered(bed: &Bed, width: usize, style: &Style) -> Result<Rendered, Error> {
    let Footprint { corner, right, up } = Footprint::new(&bed.domain, bed.to_sensor);
    let camera = Camera { corner, right, up, to_eye: bed.to_sensor };
    render(&Stage::of_sensor(bed), &camera, width, style)
}

fn write(rendered: Rendered, path: &Path) -> Result<(), Error> {
    let Rendered { mut canvas, pixel_um, .. } = rendered;
    let (width, height) = (canvas.width as f64, canvas.height as f64);
    canvas.annotate(|svg| {
        scale_bar(svg, (12.0, height - 12.0), width * pixel_um, pixel_um, Ground::Picture);
    })?;
    Ok(output::bytes(path, &canvas.png(pixel_um))?)
}
