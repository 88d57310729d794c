//! From a placed scene to its bounce table.

use std::collections::BTreeMap;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::geometry::ingest;
use crate::histogram::Histogram;
use crate::radiometry::air::{Air, air};
use crate::scene::{Grid, Scene};
use crate::spectrum::Spectrum;
use crate::support::error::Error;
use crate::support::output;
use crate::table::cover::Cover;
use crate::table::field::{Alone, InField};
use crate::table::materials::{bands, materials};
use crate::table::{self, Ended, Stop, Table, TableError, TableMaterial, Target};
use crate::tracer::rules::Course;
use crate::tracer::until::{self, Traced, Watch};
use crate::tracer::{Tracer, coverage, doubts};

/// SHA-256 of a scene file and the meshes it names: what a table belongs to.
pub fn scene_sha256(scene: &Scene, path: &Path) -> Result<String, Error> {
    let mut sum = Sha256::new();
    sum.update(output::sha256(path)?);
    for file in ingest::files(scene, path)? {
        sum.update(output::sha256(&file)?);
    }
    Ok(output::hex(&sum.finalize()))
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

/// The table of a scene of which nothing is traced yet.
pub(crate) fn untraced(
    tracer: &Tracer,
    scene: &Scene,
    path: &Path,
    course: &Course,
    materials: Vec<TableMaterial>,
    air: Air,
    stop: Stop,
) -> Result<Table, Error> {
    let longest_um = stop.grid.range_um().1;
    Ok(Table {
        soilsig_table: table::FORMAT,
        scene: scene.name.clone(),
        scene_sha256: scene_sha256(scene, path)?,
        temperature_k: scene.temperature_k,
        sky_temperature_k: scene.sky_temperature_k.clone(),
        sky_radiance: air.sky_radiance,
        atmosphere: air.atmosphere,
        view: scene.view,
        seed: scene.seed,
        max_bounces: course.most_hits,
        materials,
        stop,
        floor: floor_alone(tracer),
        field: InField::of(tracer.bed()),
        numbers: [0, 0],
        paths: 0,
        missed: 0,
        escaped_downward: 0,
        hits: 0,
        inside: Vec::new(),
        coverage: coverage(tracer, scene),
        remarks: doubts::of_bed(tracer, longest_um, scene.seed),
        histogram: Histogram::empty(course.kept),
        cells: None,
    })
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
    traced(tracer, scene, path, materials(scene, path)?, grid, target, kept, progress)
}

/// The same with spectra that are known already.
pub fn trace_with(
    tracer: &Tracer,
    scene: &Scene,
    path: &Path,
    materials: Vec<TableMaterial>,
    grid: &Grid,
    target: Target,
) -> Result<Table, Error> {
    traced(tracer, scene, path, materials, grid, target, None, &|_, _| ())
}

#[expect(clippy::too_many_arguments, reason = "what a trace depends on")]
fn traced(
    tracer: &Tracer,
    scene: &Scene,
    path: &Path,
    mut materials: Vec<TableMaterial>,
    grid: &Grid,
    target: Target,
    kept: Option<&Path>,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Table, Error> {
    for (material, chord) in materials.iter_mut().zip(tracer.bed().mean_chords_um()) {
        material.mean_chord_um = chord;
    }
    let spectra: Vec<&Spectrum> = materials.iter().map(|m| &m.spectrum).collect();
    let wavelengths_um = grid.wavelengths_um();
    let course = Course::new(scene, &spectra);
    let bands = bands(&materials, course.kept, &wavelengths_um, path)?;
    let course = course.ending_below(target.least_weight, &bands);
    let names: Vec<&str> = tracer.bed().meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    let air = air(scene, path, &wavelengths_um)?;
    let empty =
        untraced(tracer, scene, path, &course, materials, air, Stop::new(&target, grid.clone()))?;
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
    let traced = until::trace(tracer, &course, scene.seed, &bands, target, earlier, &watch)?;
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
