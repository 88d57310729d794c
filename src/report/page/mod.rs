//! A result as a page: one file with its numbers, charts and controls, opened without a server.
//!
//! The page evaluates the bounce table by itself, so that other spectra show at once. Its numbers
//! are those of `signature.csv` and `budget.csv`.

mod data;

use serde::Serialize;
use serde_json::Value;

use super::limit::Cost;
use super::{Reached, Report, details, limit, terminal, warnings};
use crate::spectrum::sensors::{self, Sensor};
use crate::table::Table;
use data::{Choice, RunData};

/// The page never grows beyond this, bytes.
const MOST_BYTES: usize = 2_000_000;

/// Bands of a sensor that the page offers.
const MOST_BANDS: usize = 16;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 7] = [
    include_str!("model.js"),
    include_str!("read.js"),
    include_str!("chart.js"),
    include_str!("words.js"),
    include_str!("whatif.js"),
    include_str!("compare.js"),
    include_str!("main.js"),
];

/// A picture of a run, as PNG.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The file.
    pub png: Vec<u8>,
    /// What it shows.
    pub text: String,
}

/// Everything that a page shows of a scene's result.
pub struct Run<'a> {
    /// Its name among others.
    pub name: String,
    /// The scene's description, or its name.
    pub heading: String,
    /// The bounce tables, one for each bed.
    pub tables: &'a [Table],
    /// The result.
    pub report: &'a Report,
    /// What it cost, if that was measured.
    pub cost: Option<Cost>,
    /// Files of the bounce tables, as a command names them.
    pub table_files: String,
    /// Pictures, the most important one first.
    pub pictures: Vec<Picture>,
    /// The light on the first three materials of the sensor's view, as PNG.
    pub light: Option<Vec<u8>>,
    /// Files written, relative to the page, with their meanings.
    pub files: Vec<(String, &'static str)>,
    /// Command, versions, seeds, files and stages.
    pub record: Option<Value>,
    /// The run's own page, relative to one that compares several.
    pub link: Option<String>,
}

#[derive(Serialize)]
struct Page<'a> {
    title: &'a str,
    answer: String,
    version: &'static str,
    /// Names of the windows that all runs have.
    windows: Vec<String>,
    runs: Vec<RunData>,
    spectra: Vec<Choice>,
    sensors: Vec<SensorData>,
}

#[derive(Serialize)]
struct SensorData {
    name: String,
    bands: Vec<BandData>,
}

#[derive(Serialize)]
struct BandData {
    name: String,
    range: [f64; 2],
}

/// The page of one run, or of several compared.
///
/// # Panics
/// Without a run.
pub fn html(title: &str, runs: &[Run]) -> String {
    let alone = runs.len() == 1;
    let data: Vec<RunData> = runs.iter().map(|run| RunData::new(run, alone)).collect();
    let um = data[0].um.clone();
    let mut page = Page {
        title,
        answer: if alone { data[0].answer.clone() } else { compared(runs) },
        version: env!("CARGO_PKG_VERSION"),
        windows: runs[0].report.reached.windows.iter().map(data::span).collect(),
        runs: data,
        spectra: if alone { Choice::all(&um) } else { Vec::new() },
        sensors: if alone { sensors() } else { Vec::new() },
    };
    let mut html = written(&page);
    // What is left out first is what other files show as well.
    let leave_out: [fn(&mut RunData); 3] =
        [|run| run.pictures.truncate(1), RunData::leave_out_table, |run| run.pictures.clear()];
    for leave_out in leave_out {
        if html.len() > MOST_BYTES {
            page.runs.iter_mut().for_each(leave_out);
            html = written(&page);
        }
    }
    html
}

fn written(page: &Page) -> String {
    // No text ends the element that holds the data.
    let data = serde_json::to_string(page).expect("plain data").replace('<', "\\u003c");
    let escaped = page.title.replace('&', "&amp;").replace('<', "&lt;");
    let parts = [
        ("{title}", escaped),
        ("{style}", STYLE.to_owned()),
        ("{script}", SCRIPTS.concat()),
        ("{data}", data),
    ];
    let mut rest = PAGE;
    let mut html = String::new();
    while let Some((at, (mark, text))) = next(rest, &parts) {
        html += &rest[..at];
        html += text;
        rest = &rest[at + mark.len()..];
    }
    html + rest
}

/// The first of some marks in a text, with its place.
fn next<'a>(text: &str, parts: &'a [(&str, String)]) -> Option<(usize, (&'a str, &'a str))> {
    let places = parts.iter().filter_map(|(mark, by)| Some((text.find(mark)?, (*mark, &**by))));
    places.min_by_key(|(at, _)| *at)
}

/// What several runs are, in one sentence.
fn compared(runs: &[Run]) -> String {
    let names: Vec<&str> = runs.iter().map(|run| &*run.name).collect();
    format!("{} results compared: {}.", runs.len(), names.join(", "))
}

/// The known sensors of few bands.
fn sensors() -> Vec<SensorData> {
    let known = sensors::names().map(|name| Sensor::find(name).expect("it is known"));
    let few = known.into_iter().filter(|sensor| sensor.bands.len() <= MOST_BANDS);
    few.map(|sensor| SensorData {
        name: sensor.name,
        bands: sensor
            .bands
            .into_iter()
            .map(|band| BandData { name: band.name, range: band.response.span_um() })
            .collect(),
    })
    .collect()
}

/// The answer as a sentence.
fn answer(r: &Reached) -> String {
    let windows = r.windows.iter().map(|w| (w.emissivity, w.half_width_95, terminal::span(w)));
    sentence(&format!("{}, {}.", terminal::answer(windows), terminal::beds(r)))
}

/// What would narrow the uncertainty.
fn limit_of(r: &Reached, cost: Option<Cost>) -> Option<String> {
    limit::line(r, cost).map(|line| sentence(&line) + ".")
}

fn notes_of(r: &Reached) -> Vec<String> {
    let soil = r.soil.as_ref().map(|soil| sentence(&soil.line()) + ".");
    soil.into_iter().chain(terminal::facets(r).map(sentence)).collect()
}

fn warnings_of(r: &Reached) -> Vec<String> {
    warnings::lines(r).iter().map(|line| sentence(line)).collect()
}

fn details_of(r: &Reached) -> Vec<String> {
    details::lines(r).iter().map(|line| sentence(line)).collect()
}

/// A line of a terminal as one of a page: with a capital, and with the signs of print.
fn sentence(line: &str) -> String {
    let mut letters = line.chars();
    let first = letters.next().map_or(String::new(), |letter| letter.to_uppercase().to_string());
    typeset(&(first + letters.as_str()))
}

/// Signs of print in place of those of a terminal.
fn typeset(text: &str) -> String {
    text.replace("+-", "±").replace(" um", " µm")
}
