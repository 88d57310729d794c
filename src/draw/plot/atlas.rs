//! Small charts on one page: the error against a swept quantity, and where the program warns.

use super::axis::{self, Axis};
use super::svg::{Anchor, Point, Svg, text_width, wrapped};

/// One small chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// The quantity on the horizontal axis, with its unit.
    pub swept: String,
    /// Whether that axis is logarithmic. If so, 0 is put at its left end.
    pub log: bool,
    /// The points, ascending.
    pub marks: Vec<Mark>,
    /// Why there are no points, if there are none.
    pub left_out: Option<String>,
}

/// One point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// The swept quantity.
    pub x: f64,
    /// The error; `None` where there was no result.
    pub error: Option<f64>,
    /// The error that is allowed.
    pub allowed: f64,
    /// Whether the program warned.
    pub is_said: bool,
    /// Whether the error is more than is allowed.
    pub is_broken: bool,
}

const COLUMNS: usize = 4;
const CELL: (f64, f64) = (318.0, 262.0);
/// The frame within its cell: left, top, right, bottom.
const FRAME: (f64, f64, f64, f64) = (52.0, 68.0, 302.0, 204.0);
const HEAD: f64 = 74.0;
/// Ends of the vertical axis, powers of ten. Smaller errors lie on the lower end.
const POWERS: (f64, f64) = (-5.0, 0.0);
/// Height of points without a result above the frame.
const REFUSED: f64 = 8.0;
/// Points at the ends keep off the frame.
const MARGIN: f64 = 9.0;
const TICK_SIZE: f64 = 11.0;

const LINE: &str = "stroke='#0072b2' stroke-width='1.6'";
const ALLOWED: &str = "stroke='#777777' stroke-width='1.2' stroke-dasharray='4 3'";
const BROKEN: &str = "fill='#f6d5c5'";
const FRAMED: &str = "fill='none' stroke='#777777'";
const TICK: &str = "stroke='#777777'";

/// Draws the panels in rows of four.
pub fn atlas_svg(title: &str, panels: &[Panel]) -> String {
    let rows = panels.len().div_ceil(COLUMNS);
    let width = CELL.0 * COLUMNS as f64 + 12.0;
    let mut svg = Svg::new(width, HEAD + CELL.1 * rows as f64, title);
    svg.text((16.0, 26.0), Anchor::Start, 17.0, title);
    key(&mut svg);
    for (i, panel) in panels.iter().enumerate() {
        let at = ((i % COLUMNS) as f64 * CELL.0 + 6.0, HEAD + (i / COLUMNS) as f64 * CELL.1);
        draw(&mut svg, panel, at);
    }
    svg.finish()
}

/// What lines, dots, crosses and shading mean.
fn key(svg: &mut Svg) {
    type Sample = fn(&mut Svg, f64, f64);
    let entries: [(Sample, &str); 5] = [
        (
            |svg, x, y| {
                svg.line(&[(x, y), (x + 24.0, y)], LINE);
                dot(svg, (x + 12.0, y), false);
            },
            "error of the result (0 lies at the lower end)",
        ),
        (
            |svg, x, y| svg.line(&[(x, y), (x + 24.0, y)], ALLOWED),
            "allowed: twice the half-width of the result",
        ),
        (
            |svg, x, y| svg.rectangle((x, y - 7.0), (24.0, 14.0), BROKEN),
            "the error is larger than allowed",
        ),
        (|svg, x, y| dot(svg, (x + 12.0, y), true), "the program warns"),
        (|svg, x, y| cross(svg, (x + 12.0, y)), "the program refuses"),
    ];
    let (mut x, y) = (16.0, 50.0);
    for (sample, words) in entries {
        sample(svg, x, y);
        svg.text((x + 30.0, y + 4.0), Anchor::Start, 12.5, words);
        x += 46.0 + text_width(words, 12.5) * 0.92;
    }
}

fn dot(svg: &mut Svg, at: Point, is_said: bool) {
    let (fill, radius) = if is_said { ("#e69f00", 4.6) } else { ("#ffffff", 3.0) };
    svg.circle(at, radius, &format!("fill='{fill}' stroke='#0072b2' stroke-width='1.2'"));
}

fn cross(svg: &mut Svg, (x, y): Point) {
    for rise in [-4.0, 4.0] {
        let style = "stroke='#d55e00' stroke-width='2.2'";
        svg.line(&[(x - 4.0, y - rise), (x + 4.0, y + rise)], style);
    }
}

/// The horizontal axis of a panel, and its ticks.
fn across(panel: &Panel, places: (f64, f64)) -> (Axis, Vec<(f64, String)>) {
    let xs = || panel.marks.iter().map(|mark| mark.x);
    let ends = |xs: &mut dyn Iterator<Item = f64>| {
        let (low, high) = axis::ends(xs).unwrap_or_default();
        (low, high.max(low + 1e-12))
    };
    if !panel.log {
        let axis = Axis::linear(ends(&mut xs()), places, 6.0);
        let ticks = axis.labels().collect();
        return (axis, ticks);
    }
    let (low, high) = ends(&mut xs().filter(|x| *x > 0.0).map(crate::support::math::log10));
    if xs().all(|x| x > 0.0) {
        let axis = Axis::log((low, high), places);
        let ticks = axis.labels().collect();
        return (axis, ticks);
    }
    let axis = Axis::log((low - (0.12 * (high - low)).max(0.3), high), places);
    let mut ticks: Vec<_> = axis.labels().collect();
    ticks.retain(|(x, _)| axis.place(*x) > places.0 + 16.0);
    ticks.push((0.0, "0".into()));
    (axis, ticks)
}

fn draw(svg: &mut Svg, panel: &Panel, (left, top): Point) {
    let (x0, y0, x1, y1) = (left + FRAME.0, top + FRAME.1, left + FRAME.2, top + FRAME.3);
    let mut lines = |text: &str, size: f64, width: f64, at: Point, anchor, style| {
        let mut lines = wrapped(text, size, width);
        lines.truncate(6);
        svg.lines(at, anchor, (size, size + 3.0), &lines, style);
    };
    let bold = "font-weight='bold'";
    lines(&panel.title, 13.0, CELL.0 - 14.0, (left + 8.0, top + 16.0), Anchor::Start, bold);
    if let Some(reason) = &panel.left_out {
        let reason = format!("left out: {reason}");
        lines(&reason, 12.0, x1 - x0 - 20.0, (x0 + 10.0, y0 + 30.0), Anchor::Start, "");
        svg.rectangle((x0, y0), (x1 - x0, y1 - y0), FRAMED);
        return;
    }
    let middle = (f64::midpoint(x0, x1), y1 + 32.0);
    lines(&panel.swept, 11.5, CELL.0 - 24.0, middle, Anchor::Middle, "");
    let (x, ticks) = across(panel, (x0 + MARGIN, x1 - MARGIN));
    let y = Axis::log(POWERS, (y1, y0));
    shade(svg, panel, &x, (x0, x1), (y0, y1));
    svg.rectangle((x0, y0), (x1 - x0, y1 - y0), FRAMED);
    for (value, label) in y.labels() {
        let y = y.place(value);
        svg.line(&[(x0 - 4.0, y), (x0, y)], TICK);
        svg.text((x0 - 6.0, y + 4.0), Anchor::End, TICK_SIZE, &label);
    }
    for (value, label) in ticks {
        let x = x.place(value);
        svg.line(&[(x, y1), (x, y1 + 4.0)], TICK);
        svg.text((x, y1 + 16.0), Anchor::Middle, TICK_SIZE, &label);
    }
    svg.upright_text((left + 14.0, f64::midpoint(y0, y1)), 11.5, "error");
    let given = || panel.marks.iter().filter_map(|mark| Some((mark, mark.error?)));
    let line = |of: &dyn Fn(&Mark, f64) -> f64| -> Vec<Point> {
        given().map(|(mark, error)| (x.place(mark.x), y.place(of(mark, error)))).collect()
    };
    if given().any(|(mark, _)| mark.allowed > 0.0) {
        svg.line(&line(&|mark, _| mark.allowed), ALLOWED);
    }
    svg.line(&line(&|_, error| error), LINE);
    for (mark, error) in given() {
        dot(svg, (x.place(mark.x), y.place(error)), mark.is_said);
    }
    for mark in panel.marks.iter().filter(|mark| mark.error.is_none()) {
        cross(svg, (x.place(mark.x), y0 - REFUSED));
    }
}

/// Shades where the error is too large, half-way to the neighbours where it is not.
fn shade(
    svg: &mut Svg,
    panel: &Panel,
    axis: &Axis,
    (x0, x1): (f64, f64),
    (top, bottom): (f64, f64),
) {
    let places: Vec<f64> = panel.marks.iter().map(|mark| axis.place(mark.x)).collect();
    for (i, _) in panel.marks.iter().enumerate().filter(|(_, mark)| mark.is_broken) {
        let from = if i == 0 { x0 } else { f64::midpoint(places[i - 1], places[i]) };
        let to = places.get(i + 1).map_or(x1, |next| f64::midpoint(places[i], *next));
        svg.rectangle((from, top), (to - from, bottom - top), BROKEN);
    }
}
