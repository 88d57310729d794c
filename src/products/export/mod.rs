//! Scenes for other programs, and from them.

mod dirsig;
mod mitsuba;
mod odb;

use std::path::Path;

use crate::geometry::{Bed, Mesh, ingest};
use crate::scene::{Scene, Sides};
use crate::support::error::Error;
use crate::table::TableMaterial;
use crate::table::resolved;

pub use odb::{DirsigError, import};

/// Half the width of the rectangle that stands for a floor without end, um: what it lacks is below 1e-3 degrees.
const FLOOR_UM: f64 = 1e7;

/// A program that scenes are written for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum To {
    /// Meshes, instances, materials and their spectra: .obj, .odb, .mat and .ems.
    Dirsig,
    /// scene.xml and its meshes: what three bands reflect of a sky of radiance 1.
    Mitsuba,
}

/// A scene as it is exported.
struct Exported<'a> {
    scene: &'a Scene,
    bed: Bed,
    materials: Vec<TableMaterial>,
}

/// Writes a placed scene for another program into a folder. `wavelengths_um` are all that the spectra are written at; of
/// Mitsuba the three bands of the picture. Returns what could not be carried over, a sentence each.
///
/// # Errors
/// A mesh or a spectrum that cannot be used, a folder that cannot be written.
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
    /// What the other program has no equal of.
    fn lost(&self, to: To) -> Vec<String> {
        let mut lost = Vec::new();
        let sides = self.bed.domain.sides;
        if sides != Sides::Open {
            lost.push(format!(
                "the bed's sides are {}, and open there: what goes on beyond them is left out",
                match sides {
                    Sides::Mirror => "mirrors",
                    Sides::Periodic => "periodic",
                    _ => "those of a field",
                }
            ));
        }
        if self.bed.domain.floor.is_some() {
            lost.push(format!(
                "the floor is a square of {} m, and has no end here",
                2.0 * FLOOR_UM / 1e6
            ));
        }
        for material in self.materials.iter().filter(|m| m.spectrum.is_angular()) {
            lost.push(format!(
                "{:?} is a mirror that reflects by angle, and there a mirror of its hemispherical reflectance at every angle",
                material.name
            ));
        }
        match to {
            To::Dirsig => lost.extend([
                "platform, sensor, sky, atmosphere and seed are not written".to_owned(),
                "DIRSIG follows as many bounces as its MAX_BOUNCES says, and soilsig follows all that matter".into(),
            ]),
            To::Mitsuba => lost.extend([
                "temperatures, sky and the sensor's bands and noise are not written: the picture is what each band \
                 reflects of a sky of radiance 1, and that is 1 less the emissivity"
                    .to_owned(),
                "three bands are written, as red, green and blue".into(),
            ]),
        }
        if self.scene.sensor.is_some() {
            lost.push("the sensor's optics are not written: the view is the whole domain".into());
        }
        lost
    }
}

/// The triangles of a mesh that are of each material, without those of none.
fn parts(mesh: &Mesh, materials: usize) -> Vec<(usize, Vec<[u32; 3]>)> {
    let mut parts = vec![Vec::new(); materials];
    for (&triangle, &material) in mesh.triangles.iter().zip(&mesh.materials) {
        parts[usize::from(material)].push(triangle);
    }
    parts.into_iter().enumerate().filter(|(_, triangles)| !triangles.is_empty()).collect()
}

/// A placement as the 16 numbers of a 4 x 4 matrix, row by row, with the last column in `unit_um`.
fn matrix(to_scene: &glam::DAffine3, unit_um: f64) -> [f64; 16] {
    let m = to_scene.matrix3.transpose().to_cols_array();
    let t = to_scene.translation / unit_um;
    [m[0], m[1], m[2], t.x, m[3], m[4], m[5], t.y, m[6], m[7], m[8], t.z, 0.0, 0.0, 0.0, 1.0]
}
