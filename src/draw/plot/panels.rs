//! Small charts of one kind beside each other: the same axes, one legend.

use super::axis::{Axis, around, ends};
use super::legend::{Legend, Pen};
use super::svg::{Anchor, Point, Svg, shortened, wrapped};

/// A page of small charts.
#[derive(Debug, Clone, PartialEq)]
pub struct SmallCharts {
    /// The heading.
    pub title: String,
    /// What stands below.
    pub caption: Vec<String>,
    /// What the colours are, for the legend; none for a single colour.
    pub labels: Vec<String>,
    /// Rows of charts. Those with the same name of y have the same y.
    pub rows: Vec<Vec<SmallChart>>,
}

/// One of them.
#[derive(Debug, Clone, PartialEq)]
pub struct SmallChart {
    /// What stands above it.
    pub title: String,
    /// Names of both axes.
    pub names: [String; 2],
    /// Whether x is logarithmic.
    pub log: bool,
    /// Words of x = 0, 1, 2, ..., in place of numbers.
    pub words: Vec<String>,
    /// The curves.
    pub series: Vec<Series>,
}

/// Points of one colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Number of its colour, that of its label.
    pub colour: usize,
    /// x, y, and the half-width of y.
    pub points: Vec<[f64; 3]>,
    /// How they are drawn.
    pub drawn: Drawing,
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drawing {
    /// With bars of their half-widths.
    Bars,
    /// The same, joined by lines.
    JoinedBars,
    /// A line within the band of the half-widths.
    Curve,
}

const EDGE: f64 = 66.0;
const GAP: f64 = 16.0;
const RIGHT: f64 = 16.0;
const WIDTH: f64 = 1040.0;
const HEIGHT: f64 = 200.0;
const MOST_WIDTH: f64 = 460.0;
const BELOW: f64 = 50.0;
const TICK: f64 = 11.0;

/// Draws the page.
pub fn small_charts_svg(of: &SmallCharts) -> String {
    let columns = of.rows.iter().map(Vec::len).max().unwrap_or(1).max(1) as f64;
    let width = ((WIDTH - EDGE - RIGHT - GAP * (columns - 1.0)) / columns).min(MOST_WIDTH);
    let right = EDGE + (width + GAP) * columns - GAP;
    let title = wrapped(&of.title, 16.0, right - EDGE);
    let caption: Vec<String> =
        of.caption.iter().flat_map(|text| wrapped(text, TICK, right - EDGE)).collect();
    let legend = Legend::new(of.labels.iter().map(String::as_str), (EDGE, right));
    let top = 16.0 + 21.0 * title.len() as f64 + legend.height();
    let row_height = 26.0 + HEIGHT + BELOW;
    let bottom = top + row_height * of.rows.len() as f64;
    let height = bottom + 16.0 * caption.len() as f64 + 8.0;
    let mut svg = Svg::new(right + RIGHT, height, &of.title);
    svg.lines((EDGE, 26.0), Anchor::Start, (16.0, 21.0), &title, "");
    legend.draw(&mut svg, 14.0 + 21.0 * title.len() as f64, |_| false);
    for (r, row) in of.rows.iter().enumerate() {
        let is_alike = |c: &&SmallChart| row.first().is_some_and(|f| f.names[1] == c.names[1]);
        let alike = of.rows.iter().flatten().filter(is_alike);
        let ys = alike.flat_map(|c| &c.series).flat_map(|s| &s.points);
        let y_ends = around(ys.flat_map(|[_, y, h]| [y - h, y + h]), 5.0);
        let upper = top + row_height * r as f64 + 26.0;
        for (c, chart) in row.iter().enumerate() {
            let left = EDGE + (width + GAP) * c as f64;
            let area = [left, upper, left + width, upper + HEIGHT];
            draw(&mut svg, chart, area, y_ends, c == 0);
        }
    }
    svg.lines((EDGE, bottom + 10.0), Anchor::Start, (TICK, 16.0), &caption, "fill='#555555'");
    svg.finish()
}

fn draw(svg: &mut Svg, chart: &SmallChart, area: [f64; 4], y_ends: (f64, f64), is_first: bool) {
    let [left, top, right, bottom] = area;
    let ink = "stroke='#1a1a1a' stroke-width='0.9'";
    let grid = "stroke='#d9dcdf' stroke-width='0.6'";
    let y = Axis::linear(y_ends, (bottom, top), 5.0);
    for (value, label) in y.labels() {
        let at = y.place(value);
        svg.line(&[(left, at), (right, at)], grid);
        if is_first {
            svg.text((left - 7.0, at + 4.0), Anchor::End, TICK, &label);
        }
    }
    let x = x_axis(chart, (left, right));
    let ticks: Vec<(f64, String)> = if chart.words.is_empty() {
        x.labels().collect()
    } else {
        let room = (right - left) / chart.words.len() as f64 - 4.0;
        let word = |(i, word): (usize, &String)| (i as f64, shortened(word, TICK, room));
        chart.words.iter().enumerate().map(word).collect()
    };
    for (value, label) in ticks {
        let at = x.place(value);
        svg.line(&[(at, top), (at, bottom)], grid);
        svg.text((at, bottom + 15.0), Anchor::Middle, TICK, &label);
    }
    let middle = (chart.series.len() as f64 - 1.0) / 2.0;
    for (i, series) in chart.series.iter().enumerate() {
        // Bars of several colours stand beside each other.
        let aside = if series.drawn == Drawing::Curve { 0.0 } else { 4.0 * (i as f64 - middle) };
        draw_series(svg, series, aside, &x, &y);
    }
    svg.rectangle((left, top), (right - left, bottom - top), &format!("fill='none' {ink}"));
    let title = shortened(&chart.title, 12.5, right - left);
    svg.text((left, top - 7.0), Anchor::Start, 12.5, &title);
    let middle = (f64::midpoint(left, right), bottom + 33.0);
    svg.text(middle, Anchor::Middle, 12.5, &shortened(&chart.names[0], 12.5, right - left));
    if is_first {
        svg.upright_text((18.0, f64::midpoint(top, bottom)), 12.5, &chart.names[1]);
    }
}

fn draw_series(svg: &mut Svg, series: &Series, aside: f64, x: &Axis, y: &Axis) {
    let pen = Pen::of(series.colour);
    let at = |[vx, vy, h]: &[f64; 3], sign: f64| -> Point {
        (x.place(*vx) + aside, y.place(vy + sign * h))
    };
    let line: Vec<Point> = series.points.iter().map(|point| at(point, 0.0)).collect();
    if series.drawn == Drawing::Curve {
        let side = |sign: f64| series.points.iter().map(|point| at(point, sign)).collect();
        svg.band(side(1.0), side(-1.0), &pen.band());
        svg.line(&line, &pen.line());
        return;
    }
    if series.drawn == Drawing::JoinedBars && line.len() > 1 {
        svg.line(&line, &pen.line());
    }
    let style = format!("stroke='{}' stroke-width='1.1'", pen.colour);
    for point in &series.points {
        svg.line(&[at(point, -1.0), at(point, 1.0)], &style);
        svg.circle(at(point, 0.0), 2.4, &format!("fill='{}'", pen.colour));
    }
}

/// The axis that holds the points of all series, with a margin.
fn x_axis(chart: &SmallChart, range: (f64, f64)) -> Axis {
    if !chart.words.is_empty() {
        return Axis::linear((-0.5, chart.words.len() as f64 - 0.5), range, 8.0);
    }
    let values = chart.series.iter().flat_map(|s| &s.points).map(|[x, ..]| *x);
    let Some((low, high)) = ends(values) else { return Axis::linear((0.0, 1.0), range, 5.0) };
    if chart.log && low > 0.0 {
        use crate::support::math::log10;
        let (low, high) = (log10(low), log10(high));
        let room = 0.04 * (high - low).max(0.5);
        return Axis::log((low - room, high + room), range);
    }
    let is_curve = chart.series.iter().all(|series| series.drawn == Drawing::Curve);
    let room = if is_curve { 0.0 } else { 0.04 * (high - low) };
    let room = if high > low { room } else { 0.5_f64.max(0.1 * high.abs()) };
    Axis::linear((low - room, high + room), range, 5.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_has_its_mark_and_every_chart_its_frame() {
        let series = |colour, drawn| Series {
            colour,
            points: vec![[0.1, 0.8, 0.01], [1.0, 0.9, 0.02], [10.0, 0.85, 0.0]],
            drawn,
        };
        let chart = |words: &[&str], drawn| SmallChart {
            title: "8 to 9.5 um".into(),
            names: ["cover".into(), "Emissivity".into()],
            log: words.is_empty(),
            words: words.iter().map(|word| (*word).to_owned()).collect(),
            series: vec![series(0, drawn), series(1, drawn)],
        };
        let of = SmallCharts {
            title: "Sand".into(),
            caption: vec!["Bars: 95 %.".into()],
            labels: vec!["fine".into(), "coarse".into()],
            rows: vec![
                vec![chart(&[], Drawing::JoinedBars), chart(&["a", "b", "c"], Drawing::Bars)],
                vec![chart(&[], Drawing::Curve)],
            ],
        };
        let svg = small_charts_svg(&of);
        assert_eq!(svg.matches("<circle").count(), 12);
        assert_eq!(svg.matches("<polygon").count(), 2);
        // Three frames and the page.
        assert_eq!(svg.matches("<rect").count(), 4);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        let empty = SmallCharts {
            rows: vec![vec![SmallChart { series: vec![], ..chart(&[], Drawing::Bars) }]],
            ..of
        };
        assert!(!small_charts_svg(&empty).contains("NaN"));
    }
}
