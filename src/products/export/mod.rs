//! Scenes written for other programs, and read from them.

mod dirsig;
mod mitsuba;
mod odb;

use std::path::Path;

use crate::geometry::{Bed, Mesh, ingest};
use crate::scene::{Scene, Sides};
use crate::support::error::Error;
use crate::table::TableMaterial;
use crate::table::resolved;

pub use odb::import;

/// Half the width of the square that stands for an endless floor, um. Its horizon is less than 1e-3
/// degrees too low.
const FLOOR_UM: f64 = 1e7;

/// A program that scenes are written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum To {
    /// Meshes, instances, materials and their spectra: .obj, .odb, .mat and .ems.
    Dirsig,
    /// scene.xml and its meshes: the reflection of a sky of radiance 1 in three bands.
    Mitsuba,
}

/// A scene that is exported.
struct Exported<'a> {
    scene: &'a Scene,
    bed: Bed,
    materials: Vec<TableMaterial>,
}

/// Writes a placed scene into a folder, for another program. `wavelengths_um` are those of the
/// spectra; for Mitsuba they are the three bands of the picture. Returns what was not carried over,
/// as sentences.
///
/// # Errors
/// A mesh or a spectrum cannot be used, or the folder cannot be written.
pub fn export(
    scene: &Scene,
    to: To,
    wavelengths_um: &[f64],
    out: &Path,
) -> Result<Vec<String>, Error> {
    let bed = ingest::load(scene)?;
    let materials = resolved(scene)?;
    let exported = Exported { scene, bed, materials };
    match to {
        To::Dirsig => dirsig::write(&exported, wavelengths_um, out)?,
        To::Mitsuba => mitsuba::write(&exported, wavelengths_um, out)?,
    }
    Ok(exported.lost(to))
}

impl Exported<'_> {
    /// What the other program has no equivalent of.
    fn lost(&self, to: To) -> Vec<String> {
        let mut lost = Vec::new();
        let sides = match self.bed.domain.sides {
            Sides::Open => None,
            Sides::Mirror => Some("mirrors"),
            Sides::Periodic => Some("periodic"),
            Sides::Field { .. } => Some("those of a field"),
        };
        if let Some(sides) = sides {
            lost.push(format!("the bed's sides are {sides}: they are written as open sides"));
        }
        if self.bed.domain.floor.is_some() {
            let width_m = 2.0 * FLOOR_UM / 1e6;
            lost.push(format!("the floor is endless: it is written as a square of {width_m} m"));
        }
        for material in self.materials.iter().filter(|m| m.spectrum.is_angular()) {
            lost.push(format!(
                "the reflectance of {:?} depends on the angle: it is written as a mirror of its \
                 hemispherical reflectance",
                material.name
            ));
        }
        if to == To::Dirsig && self.scene.temperature_k.layers().is_some() {
            lost.push(
                "layers of temperature are not written: materials have that of the first".into(),
            );
        }
        lost.extend(match to {
            To::Dirsig => [
                "platform, sensor, sky, atmosphere and seed are not written".to_owned(),
                "DIRSIG follows MAX_BOUNCES bounces, soilsig all that matter".into(),
            ],
            To::Mitsuba => [
                "temperatures, sky and the sensor's bands and noise are not written: the picture \
                 is the reflection of a sky of radiance 1, which is 1 less the emissivity"
                    .into(),
                "three bands are written, as red, green and blue".into(),
            ],
        });
        if self.scene.sensor.is_some() {
            lost.push("the sensor's optics are not written: the view is the whole domain".into());
        }
        lost
    }
}

/// The triangles of a mesh by material, without materials that it does not have.
fn parts(mesh: &Mesh, materials: usize) -> Vec<(usize, Vec<[u32; 3]>)> {
    let mut parts = vec![Vec::new(); materials];
    for (&triangle, &material) in mesh.triangles.iter().zip(&mesh.materials) {
        parts[usize::from(material)].push(triangle);
    }
    parts.into_iter().enumerate().filter(|(_, triangles)| !triangles.is_empty()).collect()
}

/// A placement as a 4 x 4 matrix, row by row, with the last column in units of `unit_um`.
fn matrix(to_scene: &glam::DAffine3, unit_um: f64) -> [f64; 16] {
    let m = to_scene.matrix3.transpose().to_cols_array();
    let t = to_scene.translation / unit_um;
    [m[0], m[1], m[2], t.x, m[3], m[4], m[5], t.y, m[6], m[7], m[8], t.z, 0.0, 0.0, 0.0, 1.0]
}
