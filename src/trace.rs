//! From a placed scene to its bounce table.

use std::collections::BTreeMap;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::coverage::{self, Cover};
use crate::error::Error;
use crate::ingest;
use crate::output;
use crate::scene::Scene;
use crate::signature;
use crate::spectrum::Spectrum;
use crate::stop::{self, Target};
use crate::table::{self, Stop, Table, TableError, TableMaterial};
use crate::tracer::Tracer;

/// Hits after which a path is given up. At a reflectance of .9 its weight is below 2e-6 by then, and
/// what it still carries is part of the interval.
pub const MAX_BOUNCES: u16 = 128;

/// SHA-256 of a scene file and the meshes it names: what a table belongs to.
pub fn scene_sha256(scene: &Scene, path: &Path) -> Result<String, Error> {
    let mut sum = Sha256::new();
    sum.update(output::sha256(path)?);
    for file in ingest::files(scene, path)? {
        sum.update(output::sha256(&file)?);
    }
    Ok(output::hex(&sum.finalize()))
}

/// The materials of a scene with their spectra; files are relative to the scene file.
pub fn materials(scene: &Scene, path: &Path) -> Result<Vec<TableMaterial>, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    scene
        .materials
        .iter()
        .map(|material| {
            let spectrum = Spectrum::resolve(&material.spectrum, folder).map_err(|source| {
                let scene = path.to_owned();
                Error::Material { scene, material: material.name.clone(), source }
            })?;
            Ok(TableMaterial { name: material.name.clone(), spectrum, first_hits: 0 })
        })
        .collect()
}

/// The reflectance of each material in each band: what the stop rule looks at.
pub fn bands(
    materials: &[TableMaterial],
    wavelengths_um: &[f64],
    path: &Path,
) -> Result<Vec<Vec<f64>>, Error> {
    for material in materials {
        signature::reflectances(&[&material.spectrum], wavelengths_um).map_err(|source| {
            Error::Material { scene: path.to_owned(), material: material.name.clone(), source }
        })?;
    }
    let spectra: Vec<&Spectrum> = materials.iter().map(|m| &m.spectrum).collect();
    Ok(signature::reflectances(&spectra, wavelengths_um)?)
}

/// Reads the meshes of a placed scene and makes them ready for tracing.
pub fn tracer(scene: &Scene, path: &Path) -> Result<Tracer, Error> {
    ingest::files(scene, path)?;
    Ok(Tracer::new(ingest::load(scene, path)?, MAX_BOUNCES))
}

/// The floor's material, if nothing else is made of it.
fn floor_alone(tracer: &Tracer) -> Option<usize> {
    let (_, floor) = tracer.bed().domain.floor?;
    let shared = tracer.bed().meshes.iter().any(|mesh| mesh.materials.contains(&floor));
    (!shared).then_some(floor.into())
}

/// What is seen of each prototype of a bed.
pub fn coverage(tracer: &Tracer, scene: &Scene) -> BTreeMap<String, Cover> {
    let materials: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    coverage::measure(tracer, &materials, scene.seed)
}

/// Traces a scene until the widest of the bands at `wavelengths_um` has its half-width.
///
/// `progress` is told how many paths are done and how many are wanted.
pub fn trace(
    tracer: &Tracer,
    scene: &Scene,
    path: &Path,
    wavelengths_um: &[f64],
    target: Target,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Table, Error> {
    let materials = materials(scene, path)?;
    let bands = bands(&materials, wavelengths_um, path)?;
    let traced = stop::trace(tracer, scene.seed, &bands, target, progress)?;
    if traced.tally.paths == traced.tally.missed {
        return Err(TableError::Empty.into());
    }
    let mut table = Table {
        soilsig_table: table::FORMAT,
        scene: scene.name.clone(),
        scene_sha256: scene_sha256(scene, path)?,
        temperature_k: scene.temperature_k,
        sky_temperature_k: scene.sky_temperature_k,
        view: scene.view,
        seed: scene.seed,
        max_bounces: MAX_BOUNCES,
        materials,
        stop: Stop {
            tolerance: target.tolerance,
            half_width: traced.half_width,
            widest_at_um: wavelengths_um[traced.widest],
            reached: traced.reached,
            trapped: traced.trapped,
        },
        floor: floor_alone(tracer),
        paths: 0,
        missed: 0,
        escaped_downward: 0,
        hits: 0,
        inside: Vec::new(),
        coverage: coverage(tracer, scene),
        escaped: Vec::new(),
        trapped: Vec::new(),
    };
    let names: Vec<&str> = tracer.bed().meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    table.count(&traced.tally, &names);
    Ok(table)
}
