//! The atlas on paper: a CSV file for each row, one page of charts, one table.

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
        output::bytes(&folder.join(format!("{}.csv", row.name)), csv(row).as_bytes())?;
    }
    let panels: Vec<Panel> = rows.iter().map(panel).collect();
    let svg =
        plot::atlas_svg("What is swept, where it breaks, and where the tool says so", &panels);
    output::bytes(&folder.join("atlas.svg"), svg.as_bytes())?;
    output::bytes(&folder.join("atlas.png"), &plot::png(&svg, plot::PIXELS_PER_UNIT)?)?;
    output::bytes(&folder.join("atlas.md"), table(rows).as_bytes())?;
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
        title: row.title.to_owned(),
        swept: row.swept.name.to_owned(),
        log: row.swept.log,
        marks: row.points.iter().map(mark).collect(),
        left_out: row.left_out.clone(),
    }
}

/// The rows as a table of Markdown.
fn table(rows: &[Row]) -> String {
    let mut text = "| what is swept | error of what | it breaks | the tool says so | in these words | and does |\n\
                    |---|---|---|---|---|---|\n"
        .to_owned();
    for row in rows {
        let swept = format!("**{}**: {}", row.title, row.swept.name);
        if let Some(reason) = &row.left_out {
            let _ = writeln!(text, "| {swept} | {} | left out: {reason} | | | |", row.error);
            continue;
        }
        let says = row.says().map_or("-".into(), |words| format!("\"{}\"", cut(words)));
        let breaks = match (row.range(Point::is_broken), row.range(Point::is_refused)) {
            (nowhere, refused) if nowhere == "nowhere" && refused != "nowhere" => {
                format!("no result {refused}")
            }
            (broken, refused) if refused == "nowhere" => broken,
            (broken, refused) => format!("{broken}; no result {refused}"),
        };
        let _ = writeln!(
            text,
            "| {swept} | {} | {breaks} | {} | {says} | {} |",
            row.error,
            row.range(|p| p.said.is_some()),
            row.does
        );
    }
    text
}

fn cut(words: &str) -> String {
    const MOST: usize = 180;
    if words.chars().count() <= MOST {
        return words.to_owned();
    }
    words.chars().take(MOST).collect::<String>().trim_end().to_owned() + " ..."
}

/// A row in a line, for the terminal.
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
    for point in row.silent() {
        let _ = writeln!(
            text,
            "  SILENT at {}: error {:.4}, claimed {:.4}",
            short(point.x),
            point.error.unwrap_or(f64::NAN),
            point.claimed
        );
    }
    text
}
