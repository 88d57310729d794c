//! The page of a study: one file, opened without a server.

use std::fmt::Write as _;
use std::path::Path;

use super::charts::listed;
use super::points::Points;
use super::record::Sweep;
use super::results::{Results, shown};
use crate::report::terminal;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;max-width:1080px;margin:2em auto;\
padding:0 1em;color:#1a1a1a;background:#fff}h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}\
svg{max-width:100%;height:auto}table{border-collapse:collapse;font-size:.85em}\
th,td{border-bottom:1px solid #d9dcdf;padding:.25em .7em;text-align:right}\
td.text,th.text{text-align:left}div.wide{overflow-x:auto}.failed{color:#a33}";

/// Rows of the table on the page; results.csv has all.
const MOST_ROWS: usize = 200;

/// The page of a study.
pub(super) fn html(sweep: &Sweep, points: &Points, results: &Results, svgs: &[String]) -> String {
    let study = &sweep.study;
    let title = escaped(study.title());
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{title}</title><style>{STYLE}</style></head><body>\n\
         <h1>{title}</h1>\n<p>{}</p>\n",
        escaped(&answer(sweep, results))
    );
    for svg in svgs {
        html += svg;
    }
    html += "<h2>Axes</h2>\n<div class=\"wide\"><table><tr><th class=\"text\">axis</th>\
             <th class=\"text\">key</th><th class=\"text\">values</th></tr>\n";
    for (axis, places) in study.axes.iter().zip(&points.axes) {
        let values = listed(places.iter().map(|place| place.value.clone()));
        let _ = writeln!(
            html,
            "<tr><td class=\"text\">{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td></tr>",
            axis.name,
            escaped(&axis.key.all().join(", ")),
            escaped(&values)
        );
    }
    html += "</table></div>\n<h2>Points</h2>\n";
    html += &table(sweep, points, results);
    if !results.failed.is_empty() {
        html += "<h2 class=\"failed\">Failures</h2>\n<ul>\n";
        for reason in reasons(results) {
            let _ = writeln!(html, "<li>{}</li>", escaped(&reason));
        }
        html += "</ul>\n<p>failures.csv lists the points.</p>\n";
    }
    html += "<h2>Files</h2>\n<ul>\n";
    for (file, meaning) in MEANINGS.iter().filter(|(file, _)| is_there(sweep, file)) {
        let _ = writeln!(html, "<li><a href=\"{file}\">{file}</a>: {meaning}</li>");
    }
    html += "</ul>\n<h2>Versions</h2>\n<ul>\n";
    // Not the processor: the page is the same on any.
    for (name, version) in sweep.versions.iter().filter(|(name, _)| *name != "processor") {
        let _ = writeln!(html, "<li>{}: {}</li>", escaped(name), escaped(version));
    }
    html + "</ul>\n</body></html>\n"
}

const MEANINGS: [(&str, &str); 6] = [
    ("results.csv", "a row for each point: emissivity by window, with total uncertainties"),
    ("results.nc", "emissivity by band over all axes, as NetCDF"),
    ("beds.csv", "a row for each bed: its point, seed, folder and emissivity"),
    ("failures.csv", "beds that failed, and why"),
    ("chart.svg", "the chart over the axes"),
    ("spectra.svg", "the chart of the spectra"),
];

fn is_there(sweep: &Sweep, file: &str) -> bool {
    file.starts_with("results")
        || file == "beds.csv"
        || sweep.outputs.contains_key(file)
        || (file == "failures.csv" && sweep.failed > 0)
        || Path::new(file).extension().is_some_and(|ending| ending == "svg")
}

/// The answer in a sentence or two.
pub(super) fn answer(sweep: &Sweep, results: &Results) -> String {
    let mut text = format!("{} points, {} beds", sweep.points, sweep.beds);
    if sweep.failed > 0 {
        let _ = write!(text, ", {} failed", sweep.failed);
    }
    for (w, window) in results.windows.iter().enumerate() {
        let all = results.points.iter().flatten().map(|point| &point.windows[w]);
        let [least, most] = [all.clone().min_by(by_emissivity), all.max_by(by_emissivity)];
        let (Some(least), Some(most)) = (least, most) else { continue };
        let number =
            |of: &crate::signature::Window| terminal::number(of.emissivity, of.half_width_95);
        let _ = write!(
            text,
            "; emissivity {} to {} ({})",
            number(least),
            number(most),
            window.replace('_', " ")
        );
    }
    if sweep.above_tolerance > 0 {
        let n = sweep.above_tolerance;
        let _ = write!(text, "; {n} points did not reach the tolerance {}", sweep.study.tolerance);
    }
    text + "."
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "iterators pass references")]
fn by_emissivity(
    a: &&crate::signature::Window,
    b: &&crate::signature::Window,
) -> std::cmp::Ordering {
    a.emissivity.total_cmp(&b.emissivity)
}

fn table(sweep: &Sweep, points: &Points, results: &Results) -> String {
    let mut html = "<div class=\"wide\"><table><tr><th>point</th>".to_owned();
    for axis in &sweep.study.axes {
        let _ = write!(html, "<th>{}</th>", axis.name);
    }
    html += "<th>beds</th>";
    for window in &results.windows {
        let _ = write!(html, "<th>emissivity {}</th>", window.replace('_', " "));
    }
    html += "</tr>\n";
    for (i, result) in results.points.iter().enumerate().take(MOST_ROWS) {
        let _ = write!(html, "<tr><td>{}</td>", i + 1);
        for place in points.coordinates(i) {
            let _ = write!(html, "<td>{}</td>", escaped(&shown(&place.value)));
        }
        let beds = result.as_ref().map_or(0, |result| result.beds);
        let _ = write!(html, "<td>{beds}</td>");
        for window in result.iter().flat_map(|result| &result.windows) {
            let number = |x| terminal::number(x, window.half_width_95);
            let (mean, width) = (number(window.emissivity), number(window.half_width_95));
            let _ = write!(html, "<td>{mean} ± {width}</td>");
        }
        html += "</tr>\n";
    }
    html += "</table></div>\n";
    if results.points.len() > MOST_ROWS {
        html += "<p>results.csv has the others.</p>\n";
    }
    html
}

/// Reasons of failures, each once with its number.
fn reasons(results: &Results) -> Vec<String> {
    let mut reasons: std::collections::BTreeMap<&str, usize> = std::collections::BTreeMap::new();
    for (_, failed) in &results.failed {
        *reasons.entry(&failed.reason).or_default() += 1;
    }
    reasons.into_iter().map(|(reason, n)| format!("{n} beds: {reason}")).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
