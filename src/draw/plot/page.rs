//! A page with one chart: title, legend, axes and caption below each other.

use super::axis::Axis;
use super::label::Area;
use super::legend::Legend;
use super::svg::{Anchor, Svg, wrapped};

// Lengths in SVG units (CSS pixels, 96 an inch).
const WIDTH: f64 = 726.0;
pub(crate) const LEFT: f64 = 72.0;
pub(crate) const RIGHT: f64 = 706.0;
const TOP: f64 = 12.0;
const TITLE: (f64, f64) = (16.0, 21.0);
const CAPTION: (f64, f64) = (10.5, 15.0);
const NAME_SIZE: f64 = 14.0;
const TICK_SIZE: f64 = 12.5;

/// What stands around the axes, and their height.
pub(crate) struct Layout<'a> {
    pub title: &'a str,
    /// Labels of the curves.
    pub labels: Vec<&'a str>,
    /// The curves that have error bands: the legend shows them.
    pub bands: Vec<bool>,
    pub plot_height: f64,
    /// Room between legend and axes.
    pub above: f64,
    pub caption: &'a [String],
}

/// A page that is drawn.
pub(crate) struct Page {
    pub svg: Svg,
    /// What is within the axes.
    pub area: Area,
}

impl Page {
    /// A page with title, legend and caption.
    pub(crate) fn new(layout: Layout) -> Self {
        let lines = |text: &str, size: f64| wrapped(text, size, RIGHT - LEFT);
        let title = lines(layout.title, TITLE.0);
        let caption: Vec<String> =
            layout.caption.iter().flat_map(|text| lines(text, CAPTION.0)).collect();
        let legend = Legend::new(layout.labels.into_iter(), (LEFT, RIGHT));
        let legend_top = TOP + TITLE.1 * title.len() as f64 + 4.0;
        let top = legend_top + legend.height() + layout.above;
        let bottom = top + layout.plot_height;
        let caption_top = bottom + 64.0;
        let height = caption_top + CAPTION.1 * caption.len() as f64;
        let mut svg = Svg::new(WIDTH, height, layout.title);
        svg.lines((LEFT, TOP + 16.0), Anchor::Start, TITLE, &title, "");
        legend.draw(&mut svg, legend_top, |curve| layout.bands.get(curve) == Some(&true));
        svg.lines((LEFT, caption_top), Anchor::Start, CAPTION, &caption, "fill='#555555'");
        Self { svg, area: Area { left: LEFT, top, right: RIGHT, bottom } }
    }

    /// Draws grid, ticks, frame and names of the axes.
    pub(crate) fn axes(&mut self, x: &Axis, y: &Axis, names: [&str; 2]) {
        let (svg, Area { left, top, right, bottom }) = (&mut self.svg, self.area);
        let grid = "stroke='#d9dcdf' stroke-width='0.6'";
        let ink = "stroke='#1a1a1a' stroke-width='0.9'";
        for (value, label) in x.ticks() {
            let x = x.place(value);
            svg.line(&[(x, bottom), (x, bottom + if label.is_some() { 6.0 } else { 3.0 })], ink);
            if let Some(label) = label {
                svg.line(&[(x, top), (x, bottom)], grid);
                svg.text((x, bottom + 20.0), Anchor::Middle, TICK_SIZE, &label);
            }
        }
        for (value, label) in y.ticks() {
            let y = y.place(value);
            svg.line(&[(left - if label.is_some() { 6.0 } else { 3.0 }, y), (left, y)], ink);
            if let Some(label) = label {
                svg.line(&[(left, y), (right, y)], grid);
                svg.text((left - 9.0, y + 4.3), Anchor::End, TICK_SIZE, &label);
            }
        }
        let frame = format!("fill='none' {ink}");
        svg.rectangle((left, top), (right - left, bottom - top), &frame);
        let middle = (f64::midpoint(left, right), f64::midpoint(top, bottom));
        svg.text((middle.0, bottom + 41.0), Anchor::Middle, NAME_SIZE, names[0]);
        svg.upright_text((18.0, middle.1), NAME_SIZE, names[1]);
    }
}
