//! The drop from the release to the rest: the paper's Fig. 4.

use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;

use super::camera::{Camera, corners};
use super::canvas::{Canvas, GAP, Ground, TEXT, scale_bar};
use super::frames::{Frame, Frames};
use super::grain::{FOOT, legend};
use super::render::{Lit, Rendered, Style};
use super::stage::Stage;
use super::{Look, tray};
use crate::draw::plot::svg::Anchor;
use crate::geometry::ingest::{self, affine};
use crate::geometry::{Bed, Mesh, Parts, Placement};
use crate::scene::{Instance, Placed, Scene, SceneGeometry};
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;

/// Least diameter of what throws a shadow in small pictures, pixels.
const LEAST_SHADOW: f64 = 3.0;

/// Draws a strip of moments of the drop, from the record beside the scene's file.
///
/// # Errors
/// The record or a mesh cannot be read, or the file cannot be written.
pub fn drop(
    scene: &Scene,
    panels: usize,
    look: Look,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(), Error> {
    strip(scene, None, panels, look, path, &Style::new(monitor))
}

/// Draws four small moments of a settled bed in the simplest light. Fines throw no shadows: they
/// are smaller than pixels.
///
/// # Errors
/// As [`drop`].
pub fn small_drop(
    scene: &Scene,
    settled: &Bed,
    path: &Path,
    monitor: &dyn Monitor,
) -> Result<(), Error> {
    let look = Look { zenith_deg: 72.0, azimuth_deg: -65.0, width_px: 720 };
    let style = Style { rays: 2, sky: 5, ..Style::new(monitor) };
    strip(scene, Some(settled), 4, look, path, &style)
}

fn strip(
    scene: &Scene,
    settled: Option<&Bed>,
    panels: usize,
    look: Look,
    path: &Path,
    style: &Style,
) -> Result<(), Error> {
    let placed = scene.placed()?;
    let names: Vec<&str> = placed.prototypes.iter().map(|p| p.name.as_str()).collect();
    let record = Frames::read(&scene.file.with_file_name("frames.json"), &names)?;
    let frames = record.chosen(panels);
    let (known, from) = match settled {
        Some(bed) if bed.placements.len() == record.prototypes.len() => {
            (bed.clone(), frames[panels - 1])
        }
        _ => (bed(scene, placed, &record, frames[0])?, frames[0]),
    };
    let moved = |frame: &&Frame| moved(&known, from, frame);
    let beds: Vec<Bed> = if known.placements.len() == record.prototypes.len() {
        frames.iter().map(moved).collect()
    } else {
        let read = |frame: &&Frame| bed(scene, placed, &record, frame);
        frames.par_iter().map(read).collect::<Result<_, _>>()?
    };
    let rest = Bed::bounds_um(&beds[panels - 1].meshes, &beds[panels - 1].placements).1;
    let start = Bed::bounds_um(&beds[0].meshes, &beds[0].placements).1;
    let [x, y] = record.tray_um;
    let to_eye = look.to_eye();
    let outer = [
        DVec3::new(-0.02 * x, -0.02 * y, -0.02 * x.max(y)),
        DVec3::new(1.02 * x, 1.02 * y, start.z.max(rest.z)),
    ];
    let camera = Camera::around(corners(outer).into_iter(), to_eye);
    let width = ((look.width_px + GAP) / panels).saturating_sub(GAP).max(1);
    let walls = [DVec3::ZERO, DVec3::new(x, y, 1.1 * rest.z)];
    let floor = placed.domain.as_ref().and_then(|domain| domain.floor.as_ref());
    let floor = floor.and_then(|floor| scene.material_index(&floor.material));
    let pixel_um = camera.size_um()[0] / width as f64;
    let coarse = |mesh| without_small(mesh, LEAST_SHADOW * pixel_um);
    let coarse: Vec<Mesh> = match settled {
        Some(_) => known.meshes.iter().map(coarse).collect(),
        None => known.meshes.clone(),
    };
    let panel = |mut bed: Bed| {
        let (mut shades, mut places) = (coarse.clone(), bed.placements.clone());
        if let Some(material) = floor {
            tray::add(&mut shades, &mut places, walls, material as u16);
            tray::add(&mut bed.meshes, &mut bed.placements, walls, material as u16);
        }
        let stage = Stage::new(&bed.meshes, &bed.placements, None);
        let shades = Stage::new(&shades, &places, None);
        let lit = Lit::new(&stage, &shades, &camera, width, style)?;
        Ok::<_, Error>(lit.coloured(style.background, style.colour))
    };
    let strip: Vec<Rendered> = beds.into_iter().map(panel).collect::<Result<_, _>>()?;
    let Rendered { canvas: Canvas { width, height, .. }, pixel_um, ref shares } = strip[0];
    let pictures: Vec<&Canvas> = strip.iter().map(|panel| &panel.canvas).collect();
    let mut canvas = Canvas::side_by_side(&pictures, 2 * FOOT);
    let (right, line) = (canvas.width as f64 - 8.0, height as f64);
    canvas.annotate(|svg| {
        for (i, frame) in frames.iter().enumerate() {
            let at = (i * (width + GAP)) as f64 + width as f64 / 2.0;
            let label = if i + 1 == panels { "at rest".into() } else { time(frame.time_s) };
            svg.text((at, line + 24.0), Anchor::Middle, TEXT, &label);
        }
        let bottom = line + 2.0 * FOOT as f64 - 8.0;
        scale_bar(svg, (8.0, bottom), width, pixel_um, Ground::Paper);
        legend(svg, (right, bottom - 4.0), scene, shares, Ground::Paper);
    })?;
    Ok(output::bytes(path, &canvas.png(Some(pixel_um)))?)
}

/// A mesh without its parts of smaller diameter, but for the largest.
fn without_small(mesh: &Mesh, least_um: f64) -> Mesh {
    let parts = Parts::of(mesh);
    let largest = parts.largest();
    mesh.with_parts(&parts, |part| {
        parts.diameters_um[part as usize] >= least_um || Some(part) == largest
    })
}

fn time(seconds: f64) -> String {
    if seconds == 0.0 { "0".into() } else { format!("{:.1} ms", 1e3 * seconds) }
}

/// The grains at another moment, each of one mesh: so the meshes are read once.
fn moved(known: &Bed, from: &Frame, to: &Frame) -> Bed {
    let transforms = from.transforms.iter().zip(&to.transforms);
    let place = |(placement, (from, to)): (&Placement, (&[f64; 12], &[f64; 12]))| Placement {
        mesh: placement.mesh,
        to_scene: affine(to) * affine(from).inverse() * placement.to_scene,
    };
    Bed {
        placements: known.placements.iter().zip(transforms).map(place).collect(),
        ..known.clone()
    }
}

/// The grains at one moment.
fn bed(scene: &Scene, placed: &Placed, record: &Frames, frame: &Frame) -> Result<Bed, Error> {
    let instances = record
        .prototypes
        .iter()
        .zip(&frame.transforms)
        .map(|(name, &transform)| Instance { prototype: name.clone(), transform });
    let moment = Placed { instances: Some(instances.collect()), domain: None, ..placed.clone() };
    let scene = Scene { geometry: SceneGeometry::Placed(moment), ..scene.clone() };
    Ok(ingest::load(&scene)?)
}
