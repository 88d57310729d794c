//! From a placed scene to its bounce table.

use std::collections::BTreeMap;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::course::{self, Course};
use crate::coverage::{self, Cover};
use crate::error::Error;
use crate::histogram::Histogram;
use crate::in_field::{Alone, InField};
use crate::ingest;
use crate::output;
use crate::scene::Scene;
use crate::signature::{self, Grid};
use crate::spectrum::Spectrum;
use crate::stop::{self, Target, Traced, Watch};
use crate::table::{self, Ended, Stop, Table, TableError, TableMaterial};
use crate::tally::Kept;
use crate::tracer::Tracer;

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
            Ok(TableMaterial {
                name: material.name.clone(),
                specular: course::specular(material, &spectrum),
                spectrum,
                temperature_k: material.temperature_k,
                mean_chord_um: None,
                first_hits: 0,
            })
        })
        .collect()
}

/// The reflectance of each symbol in each band: what the stop rule looks at.
pub fn bands(
    materials: &[TableMaterial],
    kept: Kept,
    wavelengths_um: &[f64],
    path: &Path,
) -> Result<Vec<Vec<f64>>, Error> {
    for material in materials {
        signature::reflectances(&[&material.spectrum], kept, wavelengths_um).map_err(|source| {
            Error::Material { scene: path.to_owned(), material: material.name.clone(), source }
        })?;
    }
    let spectra: Vec<&Spectrum> = materials.iter().map(|m| &m.spectrum).collect();
    Ok(signature::reflectances(&spectra, kept, wavelengths_um)?)
}

/// Reads the meshes of a placed scene and makes them ready for tracing.
pub fn tracer(scene: &Scene, path: &Path) -> Result<Tracer, Error> {
    ingest::files(scene, path)?;
    Ok(Tracer::new(ingest::load(scene, path)?))
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

/// Traces a scene until the widest of the bands of `grid` has its half-width.
///
/// Where a file for what is `kept` is given, an interrupted trace leaves there what it has, and one that finds
/// there what a trace of the same scene kept goes on from it.
pub fn trace(
    tracer: &Tracer,
    scene: &Scene,
    path: &Path,
    grid: &Grid,
    target: Target,
    kept: Option<&Path>,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Table, Error> {
    let mut materials = materials(scene, path)?;
    for (material, chord) in materials.iter_mut().zip(tracer.bed().mean_chords_um()) {
        material.mean_chord_um = chord;
    }
    let spectra: Vec<&Spectrum> = materials.iter().map(|m| &m.spectrum).collect();
    let wavelengths_um = grid.wavelengths_um();
    let course = Course::new(scene, &spectra);
    let bands = bands(&materials, course.kept, &wavelengths_um, path)?;
    let course = course.ending_below(target.least_weight(), &bands);
    let names: Vec<&str> = tracer.bed().meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    let empty = Table {
        soilsig_table: table::FORMAT,
        scene: scene.name.clone(),
        scene_sha256: scene_sha256(scene, path)?,
        temperature_k: scene.temperature_k,
        sky_temperature_k: scene.sky_temperature_k.clone(),
        view: scene.view,
        seed: scene.seed,
        max_bounces: course.most_hits,
        materials,
        stop: Stop::new(&target, grid.clone()),
        floor: floor_alone(tracer),
        field: InField::of(tracer.bed()),
        numbers: [0, 0],
        paths: 0,
        missed: 0,
        escaped_downward: 0,
        hits: 0,
        inside: Vec::new(),
        coverage: coverage(tracer, scene),
        histogram: Histogram { kept: course.kept, escaped: Vec::new(), trapped: Vec::new() },
    };
    let first = target.exactly.map_or(0, |part| part.first);
    let table_of = |traced: &Traced| {
        let mut table = empty.clone();
        table.count(&traced.tally, &names);
        table.numbers = [first, first + table.paths];
        table.stop.wanted = traced.wanted;
        table.stop.ended_by = traced.ended_by;
        if table.met() > 0 {
            table.judge()?;
        }
        Ok::<_, Error>(table)
    };
    // What was kept of a trace of other extent is another trace's.
    let fits = |table: &Table| {
        table.numbers[0] == first
            && target
                .exactly
                .is_none_or(|part| table.stop.wanted == part.of && table.numbers[1] <= part.end)
    };
    let earlier = kept
        .filter(|file| file.is_file())
        .and_then(|file| Table::read(file).ok())
        .filter(|table| table.is_part_of_same(&empty) && fits(table))
        .map(|table| Traced {
            tally: table.tally(&names),
            wanted: table.stop.wanted,
            ended_by: Ended::Interrupted,
        });
    let keep = |traced: &Traced| match kept {
        Some(file) if traced.tally.paths > traced.tally.missed => {
            Ok(table_of(traced)?.write(file)?)
        }
        _ => Ok(()),
    };
    let watch = Watch { progress, keep: &keep };
    let traced = stop::trace(tracer, &course, scene.seed, &bands, target, earlier, &watch)?;
    if traced.tally.paths == traced.tally.missed {
        return Err(TableError::Empty.into());
    }
    let mut table = table_of(&traced)?;
    if target.exactly.is_none()
        && let Some(field) = &empty.field
    {
        let alone = Alone::trace(tracer, &course, &table, &bands, target)?;
        table.field = Some(InField { alone: Some(alone), ..field.clone() });
    }
    Ok(table)
}
