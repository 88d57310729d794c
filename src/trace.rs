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
use crate::radiometry::{Atmosphere, RadiometryError, SkyTable};
use crate::remarks;
use crate::scene::{Scene, SkyRadiance};
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

/// What a scene takes from files of the sky and of the atmosphere before the sensor.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Air {
    /// Radiance of the sky.
    pub sky_radiance: Option<SkyTable>,
    /// What lies between target and sensor.
    pub atmosphere: Option<Atmosphere>,
}

/// Reads a scene's files of sky and atmosphere, which have to hold all of the wavelengths; they are relative to the
/// scene file.
pub fn air(scene: &Scene, path: &Path, wavelengths_um: &[f64]) -> Result<Air, Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let ends = [wavelengths_um[0], wavelengths_um[wavelengths_um.len() - 1]];
    let read_sky = |radiance: &SkyRadiance| {
        let path = folder.join(radiance.file());
        let sky = SkyTable::read(&path)?;
        sky.covers(ends)?;
        let (key, problem) = match radiance {
            SkyRadiance::Isotropic(_) => ("by_zenith", "there is a column zenith_deg"),
            SkyRadiance::ByZenith(_) => ("isotropic", "there is no column zenith_deg"),
        };
        if sky.is_by_zenith() == (key == "isotropic") {
            return Ok(sky);
        }
        let problem = format!("{problem}: the scene's sky_radiance has to be {{{key:?}: ...}}");
        let hint = "docs/radiometry.md shows both kinds of file";
        Err(RadiometryError::File { path, problem, hint })
    };
    let sky_radiance = scene.sky_radiance.as_ref().map(read_sky).transpose()?;
    let read_atmosphere = |file| {
        let atmosphere = Atmosphere::read(&folder.join(file))?;
        atmosphere.covers(ends).map(|()| atmosphere)
    };
    let atmosphere = scene.atmosphere_file.as_ref().map(read_atmosphere).transpose()?;
    Ok(Air { sky_radiance, atmosphere })
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
        remarks: remarks::of_bed(tracer, longest_um, scene.seed),
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
