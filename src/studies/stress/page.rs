//! The atlas on paper: a CSV file for each row, a page of charts, a table.

use std::fmt::Write as _;
use std::path::Path;

use super::{Point, Row, short};
use crate::draw::plot::{self, Mark, Panel};
use crate::support::csv::Csv;
use crate::support::error::Error;
use crate::support::output;

const HEADINGS: [&str; 7] =
    ["x", "error", "claimed_half_width", "broken", "refused", "status", "said"];

/// Writes `NAME.csv` for each row, `atlas.svg`, `atlas.png` and `atlas.md` into a folder.
pub fn write(rows: &[Row], folder: &Path) -> Result<(), Error> {
    output::folder(folder)?;
    for row in rows.iter().filter(|row| row.left_out.is_none()) {
        output::bytes(&output::within(folder, &format!("{}.csv", row.name))?, csv(row).as_bytes())?;
    }
    let panels: Vec<Panel> = rows.iter().map(panel).collect();
    let title = "What is swept, where it breaks, and where the tool says so";
    let svg = plot::atlas_svg(title, &panels);
    output::bytes(&output::within(folder, "atlas.svg")?, svg.as_bytes())?;
    output::bytes(&output::within(folder, "atlas.png")?, &plot::png(&svg, plot::PIXELS_PER_UNIT)?)?;
    output::bytes(&output::within(folder, "atlas.md")?, table(rows).as_bytes())?;
    Ok(())
}

fn csv(row: &Row) -> String {
    let mut csv = Csv::new(&HEADINGS);
    for p in &row.points {
        csv.row([
            p.x.to_string(),
            p.error.map_or(String::new(), |error| format!("{error:.3e}")),
            format!("{:.3e}", p.claimed),
            p.is_broken().to_string(),
            p.is_refused().to_string(),
            p.status.to_string(),
            p.said.clone().unwrap_or_default(),
        ]);
    }
    csv.text()
}

fn panel(row: &Row) -> Panel {
    let mark = |p: &Point| Mark {
        x: p.x,
        error: p.error,
        allowed: 2.0 * p.claimed,
        is_said: p.said.is_some(),
        is_broken: p.is_broken(),
    };
    Panel {
        title: row.title.clone(),
        swept: row.swept.clone(),
        log: row.log,
        marks: row.points.iter().map(mark).collect(),
        left_out: row.left_out.clone(),
    }
}

/// The rows as a table of Markdown.
fn table(rows: &[Row]) -> String {
    let mut text = "| what is swept | error of | it breaks | the tool says so | in these words \
                    | what it does |\n|---|---|---|---|---|---|\n"
        .to_owned();
    for row in rows {
        let Row { title, swept, error, does, .. } = row;
        let [breaks, says, words] = match &row.left_out {
            Some(reason) => [format!("left out: {reason}"), String::new(), String::new()],
            None => [breaks(row), row.range(|p| p.said.is_some()), words(row)],
        };
        let _ = writeln!(
            text,
            "| **{title}**: {swept} | {error} | {breaks} | {says} | {words} | {does} |"
        );
    }
    text
}

/// Where a row breaks or has no result.
fn breaks(row: &Row) -> String {
    let (broken, refused) = (row.range(Point::is_broken), row.range(Point::is_refused));
    match (broken.as_str(), refused.as_str()) {
        (_, "nowhere") => broken,
        ("nowhere", _) => format!("no result {refused}"),
        _ => format!("{broken}; no result {refused}"),
    }
}

/// The tool's words, cut to a length that a table holds.
fn words(row: &Row) -> String {
    const MOST: usize = 180;
    let Some(says) = row.says() else { return "-".into() };
    let cut: String = says.chars().take(MOST).collect();
    let dots = if cut.len() < says.len() { " ..." } else { "" };
    format!("\"{}{dots}\"", cut.trim_end())
}

/// A row for the terminal.
pub fn line(row: &Row) -> String {
    if let Some(reason) = &row.left_out {
        return format!("{:<24} left out: {reason}\n", row.name);
    }
    let worst = row.points.iter().filter_map(|p| p.error).fold(0.0, f64::max);
    let mut text = format!(
        "{:<24} broken {}, said {}, refused {}, largest error {}\n",
        row.name,
        row.range(Point::is_broken),
        row.range(|p| p.said.is_some()),
        row.range(Point::is_refused),
        short((worst * 1e5).round() / 1e5)
    );
    for Point { x, error, claimed, .. } in row.silent() {
        let (x, error) = (short(*x), error.unwrap_or(f64::NAN));
        let _ = writeln!(text, "  SILENT at {x}: error {error:.4}, claimed {claimed:.4}");
    }
    text
}
