//! Pages of runs: of one that ends, of earlier ones, of several compared.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::RUN;
use super::record::{Record, RecordError};
use crate::report::Report;
use crate::report::page::{self, Picture, Run};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::table::Table;

/// The page of a result.
pub const PAGE: &str = "report.html";
/// The sensor's view.
pub(super) const PATCH: &str = "patch.png";
/// The light on each material of the view, with which the page colours it.
pub(super) const LIGHT: &str = "patch_light.png";
/// The drop.
pub(super) const DROP: &str = "drop.png";

/// A scene's result.
pub struct Told {
    /// The scene's name.
    pub scene: String,
    /// The bounce tables of its beds.
    pub tables: Vec<Table>,
    /// The result.
    pub report: Report,
}

/// What files of a result are; others have no words.
const MEANINGS: [(&str, &str); 11] = [
    ("signature.csv", "emissivity and radiance by band"),
    ("signature.nc", "the same as NetCDF, with the budget"),
    ("budget.csv", "every part of the uncertainty by band"),
    ("signature.svg", "the chart"),
    ("table.json", "the bounce table, for soilsig signature"),
    (PATCH, "the bed as the sensor sees it"),
    (DROP, "the drop"),
    (LIGHT, "light on the first three materials of the view"),
    ("scene.json", "the bed, for soilsig trace and image"),
    ("scene.blend", "the bed in Blender"),
    ("drop.json", "what the drop measured"),
];

/// The page of one scene's result, whose files lie in a folder `below` another.
pub(super) fn of_folder<'a>(
    record: &Record,
    out: &Path,
    below: &str,
    heading: &str,
    told: &'a Told,
) -> Run<'a> {
    let folder = out.join(below);
    let read = |file: &str| fs::read(folder.join(file)).ok();
    let pictures = [
        (PATCH, "The bed as the sensor sees it, each facet in the colour of its material."),
        (DROP, "The drop, from the release to the rest."),
    ];
    let pictures = pictures.into_iter().filter(|(file, _)| has(record, below, file));
    let picture =
        |(file, text): (&str, &str)| Some(Picture { png: read(file)?, text: text.into() });
    let files = files(record, below);
    let meaning = |file: &str| MEANINGS.iter().find(|(known, _)| *known == file);
    let several = told.tables.len() > 1;
    Run {
        name: told.scene.clone(),
        heading: heading.to_owned(),
        tables: &told.tables,
        report: &told.report,
        cost: record.cost(&told.scene),
        table_files: if several { "packings/*/table.json" } else { "table.json" }.into(),
        pictures: pictures.filter_map(picture).collect(),
        light: read(LIGHT).filter(|_| has(record, below, LIGHT)),
        files: files
            .iter()
            .map(|file| (file.clone(), meaning(file).map_or("", |(_, meaning)| *meaning)))
            .collect(),
        record: Some(shown(record, below)),
        link: None,
    }
}

/// All scenes of a run, each with a link to its own page.
pub(super) fn side_by_side<'a>(record: &Record, out: &Path, results: &'a [Told]) -> Vec<Run<'a>> {
    let run = |told: &'a Told| {
        let run = of_folder(record, out, &told.scene, &told.scene, told);
        Run { link: Some(format!("{}/{PAGE}", told.scene)), ..run }
    };
    results.iter().map(run).collect()
}

/// The pages of earlier runs as one: of a single scene its own, of several a comparison.
///
/// # Errors
/// A folder without the record of a run, or a file of it that cannot be used.
pub fn of_runs(folders: &[&Path]) -> Result<String, Error> {
    let mut all = Vec::new();
    for folder in folders {
        let record = Record::read(&folder.join(RUN))?;
        let several = record.reached.len() > 1;
        for (scene, reached) in &record.reached {
            let below = if several { scene.clone() } else { String::new() };
            let tables = files(&record, &below);
            let is_table = |file: &&String| {
                **file == "table.json"
                    || file.starts_with("packings/") && file.ends_with("/table.json")
            };
            let paths: Vec<_> =
                tables.iter().filter(is_table).map(|file| folder.join(&below).join(file)).collect();
            if paths.is_empty() {
                let problem = "the record names no bounce table";
                let error = FileError::wrong(&folder.join(RUN), problem);
                return Err(RecordError::from(error).into());
            }
            let tables = Table::read_packings(&paths)?;
            let um = record.options.grid.wavelengths_um();
            let tolerance = (reached.tolerance, reached.tolerance_of);
            let mut report = Report::new(&tables, &um, tolerance, reached.plan)?;
            report.reached.soil.clone_from(&reached.soil);
            report.reached.refused.clone_from(&reached.refused);
            all.push((
                *folder,
                record.clone(),
                below,
                Told { scene: scene.clone(), tables, report },
            ));
        }
    }
    let alone = all.len() == 1;
    let mut runs = Vec::new();
    for (folder, record, below, told) in &all {
        let run = of_folder(record, folder, below, &told.scene, told);
        let name = folder.join(below).display().to_string();
        let name = name.trim_end_matches('/').to_owned();
        let link = std::path::absolute(folder.join(below).join(PAGE)).ok();
        let link = link.map(|page| format!("file://{}", page.display()));
        let run = if alone { run } else { Run { name, link, ..run } };
        runs.push(run);
    }
    let title = if alone { runs[0].name.clone() } else { "Results compared".into() };
    Ok(page::html(&title, &runs))
}

/// Files written below a folder, by their paths there.
fn files(record: &Record, below: &str) -> Vec<String> {
    let strip = |file: &String| match below {
        "" => Some(file.clone()),
        _ => file.strip_prefix(below)?.strip_prefix('/').map(str::to_owned),
    };
    record.outputs.keys().filter_map(strip).collect()
}

fn has(record: &Record, below: &str, file: &str) -> bool {
    files(record, below).iter().any(|written| written == file)
}

/// The parts of a record that a page shows.
fn shown(record: &Record, below: &str) -> Value {
    let outputs: serde_json::Map<String, Value> = record
        .outputs
        .iter()
        .filter(|(file, _)| file.starts_with(below))
        .map(|(file, output)| (file.clone(), json!(output.sha256)))
        .collect();
    json!({
        "command": record.command,
        "versions": record.versions,
        "seeds": record.seeds,
        "inputs": record.inputs,
        "outputs": outputs,
        "stages": record.stages,
    })
}
