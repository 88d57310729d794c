//! The results of a study: a row for each point, a row for each bed, the failures.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::SystemTime;

use rayon::prelude::*;
use serde_json::Value;

use super::bed::{self, Bed, FailedBed};
use super::points::Points;
use super::record::{self, Ended, SWEEP, Sweep};
use super::study::Study;
use super::{FILES, Options, charts, netcdf, page, place};
use crate::blender::{self, Blender};
use crate::draw::plot;
use crate::pipeline::TABLE;
use crate::pipeline::inputs;
use crate::pipeline::record::{Output, processor};
use crate::report::{Report, ToleranceOf};
use crate::signature::{self, Window};
use crate::spectrum::features::window_mean;
use crate::support::csv::{Csv, decimals};
use crate::support::error::Error;
use crate::support::{output, ro_crate};

/// The result of a point: the mean of its beds.
pub struct PointResult {
    /// Number of its finished beds.
    pub beds: usize,
    /// Paths of all of them.
    pub paths: u64,
    /// Mean emissivity over windows, with the total uncertainty.
    pub windows: Vec<Window>,
    /// Contrast of the reststrahlen doublet.
    pub contrast: Option<f64>,
    /// The widest half-width of a band, of rays and beds.
    pub half_width: f64,
    /// Whether that is within the tolerance.
    pub reached: bool,
    /// Emissivity in each band.
    pub emissivity: Vec<f64>,
    /// Its total half-width at 95 %.
    pub half_width_95: Vec<f64>,
    /// Of each bed of the point, in the order of the seeds, the emissivity in each band.
    pub of_beds: Vec<Option<Vec<f64>>>,
}

/// A bed's row.
struct BedRow {
    sha256: String,
    paths: u64,
}

/// All results of a study.
pub struct Results {
    /// Of each point; `None` where no bed is finished.
    pub points: Vec<Option<PointResult>>,
    /// Headings of the windows, such as `8_to_9.5_um`.
    pub windows: Vec<String>,
    /// Beds that failed: the number of the bed and why.
    pub failed: Vec<(usize, FailedBed)>,
}

/// A coordinate as text for a table.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}

/// The results of a part of a study: only what is finished by now.
pub(super) fn of_part(options: &Options, beds: &[Bed]) -> Ended {
    let failed = failures(options, beds);
    let is_there = |bed: &&Bed| options.out.join(bed::folder_of(&bed.id)).is_dir();
    Ended {
        record: None,
        answer: format!(
            "{} of {} beds are finished",
            beds.iter().filter(is_there).count(),
            beds.len()
        ),
        failed: failed.into_iter().map(|(_, failed)| failed.reason).collect(),
    }
}

fn failures(options: &Options, beds: &[Bed]) -> Vec<(usize, FailedBed)> {
    let of = |(i, bed): (usize, &Bed)| Some((i, bed::failure(options.out, &bed.id)?));
    beds.iter().enumerate().filter_map(of).collect()
}

/// Writes all files of a study whose beds are finished, the record last.
pub(super) fn write(
    options: &Options,
    study: &Study,
    points: &Points,
    beds: &[Bed],
    blender: Option<&Blender>,
    read: BTreeMap<PathBuf, String>,
    started: SystemTime,
) -> Result<Ended, Error> {
    let um = study.bands.wavelengths_um();
    let seeds = study.seeds.len();
    let of_points: Vec<_> = beds
        .par_chunks(seeds)
        .map(|beds| {
            options.monitor.check()?;
            point(options, study, &um, beds)
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let (of_points, rows): (Vec<_>, Vec<_>) = of_points.into_iter().unzip();
    let rows: Vec<Option<BedRow>> = rows.into_iter().flatten().collect();
    let windows = of_points.iter().flatten().next().map_or_else(Vec::new, |first| {
        first.windows.iter().map(|w| format!("{}_to_{}_um", w.from_um, w.to_um)).collect()
    });
    let results = Results { points: of_points, windows, failed: failures(options, beds) };
    let versions = versions(blender);
    let mut files: BTreeMap<&str, Vec<u8>> = BTreeMap::new();
    files.insert("results.csv", results_csv(study, points, &results).into());
    files.insert("beds.csv", beds_csv(study, points, beds, &results, &rows, &um).into());
    if !results.failed.is_empty() {
        files.insert("failures.csv", failures_csv(study, points, beds, &results.failed).into());
    }
    if let Some(bytes) = netcdf::bytes(study, points, &results, &um) {
        files.insert("results.nc", bytes);
    }
    let mut svgs = Vec::new();
    for (name, svg) in charts::of(study, points, &results, &um) {
        let png = plot::png(&svg, plot::PIXELS_PER_UNIT)?;
        let [as_svg, as_png]: [&str; 2] = match name {
            charts::CHART => ["chart.svg", "chart.png"],
            _ => ["spectra.svg", "spectra.png"],
        };
        files.insert(as_png, png);
        files.insert(as_svg, svg.clone().into());
        svgs.push(svg);
    }
    let above = results.points.iter().flatten().filter(|point| !point.reached).count();
    let mut sweep = Sweep {
        soilsig_sweep: record::FORMAT,
        command: options.command.to_vec(),
        study_file: options.study.to_owned(),
        study: study.clone(),
        blender_timeout_s: options.blender_timeout_s,
        versions,
        inputs: read.into_iter().map(|(file, sum)| (file.display().to_string(), sum)).collect(),
        outputs: BTreeMap::new(),
        points: points.len(),
        beds: rows.iter().flatten().count(),
        failed: results.failed.len(),
        above_tolerance: above,
    };
    files.insert("report.html", page::html(&sweep, points, &results, &svgs).into());
    output::keeps(sweep.inputs.keys(), FILES.iter().map(|file| place(options, file)))?;
    // The earlier record goes first: it does not hold for a mixture.
    output::remove(&place(options, SWEEP))?;
    for file in FILES {
        match files.get(file) {
            Some(bytes) => {
                output::bytes(&place(options, file), bytes)?;
                let sha256 = output::sha256_hex(&place(options, file))?;
                sweep.outputs.insert(file.into(), Output { sha256, reproducible: true });
            }
            None => output::remove(&place(options, file))?,
        }
    }
    let mut copies = Vec::new();
    for (from, copy) in inputs::places(sweep.inputs.keys()) {
        output::copy(from.as_ref(), &output::within(options.out, &copy)?)?;
        copies.push((copy, Some(sweep.inputs[from].clone())));
    }
    let outputs = sweep.outputs.iter().map(|(file, of)| (file.clone(), Some(of.sha256.clone())));
    let text = ro_crate::Run {
        name: &study.name,
        description: study.title().to_owned(),
        command: &sweep.command,
        started,
        versions: &sweep.versions,
        inputs: copies,
        outputs: outputs.chain([(SWEEP.to_owned(), None)]).collect(),
        folders: vec![("beds/", "bounce tables of all beds; beds.csv says which is which")],
    }
    .text();
    output::bytes(&place(options, ro_crate::FILE), text.as_bytes())?;
    let text = serde_json::to_string_pretty(&sweep).expect("plain data") + "\n";
    output::bytes(&place(options, SWEEP), text.as_bytes())?;
    let answer = page::answer(&sweep, &results);
    Ok(Ended {
        answer,
        failed: results.failed.into_iter().map(|(_, failed)| failed.reason).collect(),
        record: Some(sweep),
    })
}

fn versions(blender: Option<&Blender>) -> BTreeMap<String, String> {
    let mut versions = BTreeMap::from([
        ("soilsig".into(), env!("CARGO_PKG_VERSION").into()),
        ("processor".into(), processor()),
    ]);
    if let Some(blender) = blender {
        versions.extend([
            ("blender".into(), blender.version.to_string()),
            ("python".into(), blender.python.clone()),
            ("numpy".into(), blender.numpy.clone()),
            ("scripts".into(), blender::scripts_sha256()),
        ]);
    }
    versions
}

/// Evaluates the beds of a point.
fn point(
    options: &Options,
    study: &Study,
    um: &[f64],
    beds: &[Bed],
) -> Result<(Option<PointResult>, Vec<Option<BedRow>>), Error> {
    let mut tables = Vec::new();
    let mut rows = Vec::new();
    for bed in beds {
        let Some(table) = bed::table(options.out, &bed.id)? else {
            rows.push(None);
            continue;
        };
        let file = options.out.join(bed::folder_of(&bed.id)).join(TABLE);
        rows.push(Some(BedRow { sha256: output::sha256_hex(&file)?, paths: table.paths }));
        tables.push(table);
    }
    if tables.is_empty() {
        return Ok((None, rows));
    }
    let report = Report::new(&tables, um, (study.tolerance, ToleranceOf::Interval), None)?;
    let mut curves = signature::curves(&tables, um)?.into_iter();
    let reached = &report.reached;
    let result = PointResult {
        beds: tables.len(),
        paths: reached.paths,
        windows: reached.windows.clone(),
        contrast: reached.features.reststrahlen.map(|doublet| doublet.contrast),
        half_width: reached.half_width,
        reached: reached.status().is_none(),
        emissivity: report.bands.iter().map(|band| band.emissivity.mean).collect(),
        half_width_95: report.budget.bands.iter().map(|share| share.total).collect(),
        of_beds: rows.iter().map(|row| row.as_ref().and_then(|_| curves.next())).collect(),
    };
    Ok((Some(result), rows))
}

/// The names of the axes.
fn names(study: &Study) -> impl Iterator<Item = String> {
    study.axes.iter().map(|axis| axis.name.clone())
}

fn coordinates(points: &Points, point: usize) -> impl Iterator<Item = String> {
    points.coordinates(point).into_iter().map(|place| shown(&place.value))
}

fn csv(headings: impl Iterator<Item = String>) -> Csv {
    let headings: Vec<String> = headings.collect();
    Csv::new(&headings.iter().map(String::as_str).collect::<Vec<_>>())
}

/// A row for each point.
fn results_csv(study: &Study, points: &Points, results: &Results) -> String {
    let of_window = |window: &String| {
        ["emissivity", "half_width_95", "sd_beds"].map(|what| format!("{what}_{window}"))
    };
    let headings = ["point".to_owned()].into_iter().chain(names(study));
    let headings = headings
        .chain(["beds".to_owned()])
        .chain(results.windows.iter().flat_map(of_window))
        .chain(["contrast", "widest_half_width_95", "tolerance_reached", "paths"].map(Into::into));
    let mut csv = csv(headings);
    for (i, result) in results.points.iter().enumerate() {
        let mut row: Vec<String> = vec![(i + 1).to_string()];
        row.extend(coordinates(points, i));
        if let Some(of) = result {
            row.push(of.beds.to_string());
            for window in &of.windows {
                row.extend([
                    decimals(window.emissivity),
                    decimals(window.half_width_95),
                    decimals(window.packings_spread),
                ]);
            }
            row.extend([decimals(of.contrast), decimals(of.half_width)]);
            row.extend([u8::from(of.reached).to_string(), of.paths.to_string()]);
        } else {
            row.push("0".into());
            row.extend(std::iter::repeat_n(String::new(), 3 * results.windows.len() + 4));
        }
        csv.row(row);
    }
    csv.text()
}

/// A row for each finished bed.
fn beds_csv(
    study: &Study,
    points: &Points,
    beds: &[Bed],
    results: &Results,
    rows: &[Option<BedRow>],
    um: &[f64],
) -> String {
    let headings = ["point".to_owned()].into_iter().chain(names(study)).chain(["seed".into()]);
    let headings = headings
        .chain(results.windows.iter().map(|window| format!("emissivity_{window}")))
        .chain(["paths", "folder", "table_sha256"].map(Into::into));
    let mut csv = csv(headings);
    let seeds = study.seeds.len();
    for (i, (bed, row)) in beds.iter().zip(rows).enumerate() {
        let (Some(row), Some(result)) = (row, &results.points[bed.point]) else { continue };
        let mut fields: Vec<String> = vec![(bed.point + 1).to_string()];
        fields.extend(coordinates(points, bed.point));
        fields.push(bed.seed.to_string());
        let curve = result.of_beds[i % seeds].as_ref().expect("it is finished");
        for window in &result.windows {
            fields.push(decimals(window_mean(um, curve, &(window.from_um..=window.to_um))));
        }
        let folder = bed::folder_of(&bed.id).display().to_string();
        fields.extend([row.paths.to_string(), folder, row.sha256.clone()]);
        csv.row(fields);
    }
    csv.text()
}

/// A row for each bed that failed.
fn failures_csv(
    study: &Study,
    points: &Points,
    beds: &[Bed],
    failed: &[(usize, FailedBed)],
) -> String {
    let headings = ["point".to_owned()].into_iter().chain(names(study));
    let mut csv = csv(headings.chain(["seed", "status", "reason", "hint"].map(Into::into)));
    for (bed, failed) in failed {
        let Bed { point, seed, .. } = beds[*bed];
        let mut row: Vec<String> = vec![(point + 1).to_string()];
        row.extend(coordinates(points, point));
        row.extend([seed.to_string(), failed.status.to_string(), failed.reason.clone()]);
        row.push(failed.hint.clone().unwrap_or_default());
        csv.row(row);
    }
    csv.text()
}
