//! From a placed scene to its bounce table.

use std::collections::BTreeMap;
use std::path::Path;

use crate::geometry::ingest::Sources;
use crate::histogram::Histogram;
use crate::scene::{Grid, Origin, Scene, SceneGeometry};
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::table::cover::Cover;
use crate::table::field::{Alone, FieldSummary};
use crate::table::{self, Prepared, Stop, StopReason, Table, TableError, Target};
use crate::tracer::rules::{MOST_HITS, TracingRules};
use crate::tracer::until::{self, TracedPaths};
use crate::tracer::{Tracer, bed_warnings, coverage, light};

/// Reads the meshes of a placed scene and makes them ready for tracing.
pub fn tracer(scene: &Scene) -> Result<Tracer, Error> {
    Tracer::of(&Sources::read(scene)?)
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
pub(crate) fn untraced(tracer: &Tracer, prepared: &Prepared, stop: Stop) -> Result<Table, Error> {
    let scene = &prepared.scene;
    let mut materials = prepared.materials.to_vec();
    for (material, chord) in materials.iter_mut().zip(tracer.bed().mean_chords_um()) {
        material.mean_chord_um = chord;
    }
    let (origin, drop) = match &scene.geometry {
        SceneGeometry::Placed(placed) => (placed.origin, placed.drop),
        SceneGeometry::Packing(_) => (Origin::Given, None),
    };
    let longest_um = stop.asked.grid.range_um().1;
    Ok(Table {
        soilsig_table: table::FORMAT,
        scene: scene.name.clone(),
        scene_sha256: match tracer.scene_sha256() {
            Some(sum) => sum.to_owned(),
            None => Sources::read(scene)?.sha256()?,
        },
        temperature_k: scene.temperature_k.kelvin(),
        layers: scene.temperature_k.layers().cloned(),
        sky_temperature_k: scene.sky_temperature_k.clone(),
        sky_radiance: prepared.air.sky_radiance.clone(),
        atmosphere: prepared.air.atmosphere.clone(),
        view: scene.view,
        seed: scene.seed,
        max_bounces: MOST_HITS,
        materials,
        stop,
        floor: floor_alone(tracer),
        origin,
        drop,
        field: FieldSummary::of(tracer.bed()),
        numbers: [0, 0],
        paths: 0,
        missed: 0,
        escaped_downward: 0,
        hits: 0,
        inside: Vec::new(),
        coverage: coverage(tracer, scene),
        warnings: bed_warnings::of_bed(tracer, origin, longest_um, scene.seed),
        nodes: prepared.nodes.clone(),
        histogram: Histogram::empty(prepared.kept),
        cells: None,
    })
}

/// What a trace is asked for.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The bands that are to reach the tolerance: those that the scene was prepared for.
    pub grid: &'a Grid,
    /// What to reach, and what at most to spend.
    pub target: Target,
    /// File in which an interrupted trace leaves its paths. A trace of the same scene goes on from
    /// it.
    pub partial: Option<&'a Path>,
    /// What the monitor is told is traced.
    pub what: &'a str,
}

impl<'a> Request<'a> {
    /// Traces until the target is reached.
    pub fn new(grid: &'a Grid, target: Target) -> Self {
        Self { grid, target, partial: None, what: "paths" }
    }
}

/// Traces a scene until the widest half-width of its bands is within the tolerance.
///
/// # Errors
/// The monitor stopped it, or no path met anything.
pub fn trace(
    tracer: &Tracer,
    prepared: &Prepared,
    request: Request,
    monitor: &dyn Monitor,
) -> Result<Table, Error> {
    let Request { grid, target, partial, what } = request;
    // What is left out is a small part of the tolerance, as with paths that are given up.
    let prepared = &*prepared.decided(&tracer.bed().mean_chords_um(), target.least_weight)?;
    let bands = &prepared.reflectances;
    if prepared.nodes.is_some() {
        light::check(tracer.bed(), &prepared.materials)?;
    }
    let rules = TracingRules::new(prepared).ending_below(target.least_weight, bands);
    let names: Vec<&str> = tracer.bed().meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    let empty = untraced(tracer, prepared, Stop::new(&target, grid.clone()))?;
    let first = target.exactly.map_or(0, |part| part.first);
    let table_of = |traced: &TracedPaths| {
        let mut table = empty.clone();
        table.count(&traced.tally, &names);
        table.numbers = [first, first + table.paths];
        (table.stop.reached.wanted, table.stop.reached.reason) = (traced.wanted, traced.reason);
        if table.met() > 0 {
            table.judge()?;
        }
        Ok::<_, Error>(table)
    };
    // A file of other paths belongs to another trace.
    let fits = |table: &Table| {
        table.numbers[0] == first
            && target
                .exactly
                .is_none_or(|p| table.stop.reached.wanted == p.of && table.numbers[1] <= p.end)
    };
    let earlier = partial
        .filter(|file| file.is_file())
        .and_then(|file| Table::read(file).ok())
        .filter(|table| table.differs_from(&empty).is_empty() && fits(table))
        .map(|table| TracedPaths {
            tally: table.tally(&names),
            wanted: table.stop.reached.wanted,
            reason: StopReason::Interrupted,
        });
    let save = |traced: &TracedPaths| match partial {
        Some(file) if traced.tally.paths > traced.tally.missed => {
            Ok(table_of(traced)?.write(file)?)
        }
        _ => Ok(()),
    };
    // The patch of a field is traced twice more, by as many paths.
    let shares = if target.exactly.is_none() && empty.field.is_some() { 3.0 } else { 1.0 };
    let target = Target { max_seconds: target.max_seconds.map(|s| s / shares), ..target };
    let request = until::Request {
        what,
        resume: earlier.as_ref(),
        save: &save,
        ..until::Request::new(&rules, prepared.scene.seed, bands, target, monitor)
    };
    let traced = until::trace(tracer, &request)?;
    if traced.tally.paths == traced.tally.missed {
        return Err(TableError::Empty.into());
    }
    let mut table = table_of(&traced)?;
    if target.exactly.is_none()
        && let Some(field) = &empty.field
    {
        let alone = Alone::trace(tracer, &table, &request)?;
        table.field = Some(FieldSummary { alone: Some(alone), ..field.clone() });
    }
    Ok(table)
}
