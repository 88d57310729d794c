//! Emissivity against wavelength, with its error band and the features of quartz.

use std::ops::RangeInclusive;

use super::PlotError;
use super::axis::{Axis, round_step};
use super::curve::Curve;
use super::label::{self, Area};
use super::legend::{Legend, Pen};
use super::svg::{Anchor, Point, Svg, text_width, wrapped};
use crate::spectrum::features::{RESTSTRAHLEN_WINDOW_UM, TRANSPARENCY_WINDOW_UM, features};

/// A chart of one curve or several.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// Small lines under the axes: method, kind of noise, versions.
    pub caption: Vec<String>,
    /// The curves, in the order of the legend.
    pub curves: Vec<Curve>,
    /// Whether the features of quartz are marked: with their wavelengths on a single curve, with
    /// circles on several.
    pub mark_features: bool,
    /// Wavelengths that are hatched, from one to another, um: what is shown there is not to be trusted.
    pub hatched_um: Vec<[f64; 2]>,
}

// Lengths in SVG units (CSS pixels): a plot 7.5 inches wide at 96 a inch.
const WIDTH: f64 = 720.0;
const LEFT: f64 = 66.0;
const RIGHT: f64 = 700.0;
const PLOT_HEIGHT: f64 = 350.0;
const TITLE_SIZE: f64 = 16.0;
const AXIS_SIZE: f64 = 14.0;
const TICK_SIZE: f64 = 12.5;
const MARK_SIZE: f64 = 11.5;
const CAPTION_SIZE: f64 = 10.5;

/// Draws the chart as SVG; the same chart gives the same bytes.
///
/// # Errors
/// No curve or no point; columns of different length; numbers that are not finite, wavelengths
/// that do not ascend, emissivities outside 0 to 1.
pub fn emissivity_svg(chart: &Chart) -> Result<String, PlotError> {
    chart.curves.iter().try_for_each(Curve::check)?;
    let points = |of: fn(&Curve) -> &[f64]| chart.curves.iter().flat_map(of).copied();
    let wavelengths = span(points(|c| &c.wavelength_um)).ok_or(PlotError::Empty)?;

    let title = wrapped(&chart.title, TITLE_SIZE, RIGHT - LEFT);
    let caption: Vec<String> = key(chart)
        .iter()
        .chain(&chart.caption)
        .flat_map(|line| wrapped(line, CAPTION_SIZE, RIGHT - LEFT))
        .collect();
    let labels = chart.curves.iter().map(|c| c.label.as_str());
    let legend = Legend::new(labels, (LEFT, RIGHT));

    let title_top = 12.0;
    let legend_top = title_top + 21.0 * title.len() as f64 + 4.0;
    let top = legend_top + legend.height() + 26.0;
    let bottom = top + PLOT_HEIGHT;
    let caption_top = bottom + 54.0;
    let height = caption_top + 15.0 * caption.len() as f64 + 10.0;

    let plot = Plot {
        x: Axis::new(widened(wavelengths, 1e-3), (LEFT, RIGHT), 8.0),
        y: Axis::new(emissivity_range(chart), (bottom, top), 8.0),
        area: Area { left: LEFT, top, right: RIGHT, bottom },
    };
    let mut svg = Svg::new(WIDTH, height, &chart.title);
    for (i, line) in title.iter().enumerate() {
        svg.text((LEFT, title_top + 16.0 + 21.0 * i as f64), Anchor::Start, TITLE_SIZE, line);
    }
    legend.draw(&mut svg, legend_top, has_bands(chart));
    for (name, window_um) in
        [("Reststrahlen", RESTSTRAHLEN_WINDOW_UM), ("Transparency", TRANSPARENCY_WINDOW_UM)]
    {
        plot.draw_window(&mut svg, name, &window_um);
    }
    for &range_um in &chart.hatched_um {
        plot.draw_hatching(&mut svg, range_um);
    }
    plot.draw_axes(&mut svg);
    for (i, curve) in chart.curves.iter().enumerate() {
        plot.draw_band(&mut svg, curve, &Pen::of(i));
    }
    for (i, curve) in chart.curves.iter().enumerate() {
        plot.draw_curve(&mut svg, curve, &Pen::of(i));
    }
    if chart.mark_features {
        for (i, curve) in chart.curves.iter().enumerate() {
            plot.mark_features(&mut svg, curve, &Pen::of(i), chart.curves.len() == 1);
        }
    }
    for (i, line) in caption.iter().enumerate() {
        let at = (LEFT, caption_top + 10.0 + 15.0 * i as f64);
        svg.styled_text(at, Anchor::Start, CAPTION_SIZE, line, "fill='#555555'");
    }
    Ok(svg.finish())
}

fn has_bands(chart: &Chart) -> bool {
    chart.curves.iter().flat_map(|c| &c.half_width).any(|&h| h > 0.0)
}

/// What shading and circles mean, where there are any.
fn key(chart: &Chart) -> Option<String> {
    let has_extrema = |c: &Curve| features(&c.wavelength_um, &c.emissivity).extrema().count() > 0;
    let is_marked = chart.mark_features && chart.curves.iter().any(has_extrema);
    let bands = has_bands(chart).then_some("Shaded bands: 95 % confidence.");
    let circles = is_marked.then_some("Circles: extrema of quartz.");
    let parts: Vec<&str> = bands.into_iter().chain(circles).collect();
    (!parts.is_empty()).then(|| parts.join(" "))
}

fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |span, v| {
        let (low, high) = span.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

/// The span, made `least` wide if it is less.
fn widened((low, high): (f64, f64), least: f64) -> (f64, f64) {
    let more = (0.5 * (least - (high - low))).max(0.0);
    (low - more, high + more)
}

/// The ends of the emissivity axis: the data with some air, at round values, within 0 to 1.
fn emissivity_range(chart: &Chart) -> (f64, f64) {
    let ends = chart
        .curves
        .iter()
        .flat_map(|c| c.emissivity.iter().zip(&c.half_width).flat_map(|(e, h)| [e - h, e + h]));
    let (low, high) = widened(span(ends).unwrap_or((0.0, 1.0)), 0.02);
    let air = if chart.mark_features { 0.1 } else { 0.05 } * (high - low);
    let (low, high) = ((low - air).max(0.0), (high + air).min(1.0));
    let step = 0.5 * round_step(high - low, 8.0);
    ((low / step).floor() * step, ((high / step).ceil() * step).min(1.0))
}

/// The axes and what is drawn between them.
struct Plot {
    x: Axis,
    y: Axis,
    area: Area,
}

impl Plot {
    fn place(&self, wavelength_um: f64, emissivity: f64) -> Point {
        (self.x.place(wavelength_um), self.y.place(emissivity.clamp(0.0, 1.0)))
    }

    fn points(&self, curve: &Curve) -> Vec<Point> {
        curve.wavelength_um.iter().zip(&curve.emissivity).map(|(&w, &e)| self.place(w, e)).collect()
    }

    /// Shades a window and names it above the plot, in as many words as there is width for.
    fn draw_window(&self, svg: &mut Svg, name: &str, window_um: &RangeInclusive<f64>) {
        let Area { left, top, right, bottom } = self.area;
        let (start, end) = (*window_um.start(), *window_um.end());
        let [from, to] = [start, end].map(|w| self.x.place(w).clamp(left, right));
        if to - from < 1.0 {
            return;
        }
        svg.rectangle((from, top), (to - from, bottom - top), "fill='#f1f3f5'");
        let bracket = [(from, top - 4.0), (from, top - 8.0), (to, top - 8.0), (to, top - 4.0)];
        svg.line(&bracket, "stroke='#7a7a7a' stroke-width='0.8'");
        let short = format!("{start}–{end} µm");
        let names = [format!("{name}, {short}"), short];
        if let Some(text) = names.iter().find(|text| text_width(text, MARK_SIZE) < to - from) {
            let at = (0.5 * (from + to), top - 13.0);
            svg.styled_text(at, Anchor::Middle, MARK_SIZE, text, "fill='#555555'");
        }
    }

    /// Slanted lines over a range of wavelengths.
    fn draw_hatching(&self, svg: &mut Svg, range_um: [f64; 2]) {
        const DISTANCE: f64 = 7.0;
        let Area { left, top, right, bottom } = self.area;
        let [from, to] = range_um.map(|w| self.x.place(w).clamp(left, right));
        let (from, to) = widened((from, to), 1.0);
        let style = "stroke='#8a6d3b' stroke-width='0.7' stroke-opacity='0.55'";
        let height = bottom - top;
        // Each line rises by as much as it goes to the right; those of all ranges lie on one lattice.
        let mut foot = ((from - height) / DISTANCE).ceil() * DISTANCE;
        while foot < to {
            let [start, end] = [from.max(foot), to.min(foot + height)];
            if start < end {
                svg.line(&[(start, bottom - (start - foot)), (end, bottom - (end - foot))], style);
            }
            foot += DISTANCE;
        }
    }

    fn draw_axes(&self, svg: &mut Svg) {
        let Area { left, top, right, bottom } = self.area;
        let grid = "stroke='#d9dcdf' stroke-width='0.6'";
        let tick = "stroke='#1a1a1a' stroke-width='0.9'";
        for (value, label) in self.x.ticks() {
            let x = self.x.place(value);
            svg.line(&[(x, top), (x, bottom)], grid);
            svg.line(&[(x, bottom), (x, bottom + 6.0)], tick);
            svg.text((x, bottom + 20.0), Anchor::Middle, TICK_SIZE, &label);
        }
        for value in self.x.small_ticks() {
            let x = self.x.place(value);
            svg.line(&[(x, bottom), (x, bottom + 3.0)], tick);
        }
        for (value, label) in self.y.ticks() {
            let y = self.y.place(value);
            svg.line(&[(left, y), (right, y)], grid);
            svg.line(&[(left - 6.0, y), (left, y)], tick);
            svg.text((left - 9.0, y + 4.3), Anchor::End, TICK_SIZE, &label);
        }
        for value in self.y.small_ticks() {
            let y = self.y.place(value);
            svg.line(&[(left - 3.0, y), (left, y)], tick);
        }
        let frame = "fill='none' stroke='#1a1a1a' stroke-width='0.9'";
        svg.rectangle((left, top), (right - left, bottom - top), frame);
        let middle = (0.5 * (left + right), 0.5 * (top + bottom));
        svg.text((middle.0, bottom + 41.0), Anchor::Middle, AXIS_SIZE, "Wavelength (µm)");
        svg.upright_text((18.0, middle.1), AXIS_SIZE, "Emissivity");
    }

    fn draw_band(&self, svg: &mut Svg, curve: &Curve, pen: &Pen) {
        if curve.half_width.iter().all(|&h| h == 0.0) {
            return;
        }
        let side = |sign: f64| -> Vec<Point> {
            let ends = curve.emissivity.iter().zip(&curve.half_width).map(|(e, h)| e + sign * h);
            curve.wavelength_um.iter().zip(ends).map(|(&w, e)| self.place(w, e)).collect()
        };
        let (mut outline, lower) = (side(1.0), side(-1.0));
        if let ([high], [low]) = (&outline[..], &lower[..]) {
            // A band without length is an error bar.
            svg.line(&[*low, *high], &pen.line());
        } else {
            outline.extend(lower.into_iter().rev());
            svg.area(&outline, &pen.band());
        }
    }

    fn draw_curve(&self, svg: &mut Svg, curve: &Curve, pen: &Pen) {
        let points = self.points(curve);
        if let [point] = points[..] {
            svg.circle(point, 3.0, &format!("fill='{}'", pen.colour));
        } else {
            svg.line(&points, &pen.line());
        }
    }

    fn mark_features(&self, svg: &mut Svg, curve: &Curve, pen: &Pen, name_them: bool) {
        let found = features(&curve.wavelength_um, &curve.emissivity);
        let circle = format!("fill='#ffffff' stroke='{}' stroke-width='1.3'", pen.colour);
        for extremum in found.extrema() {
            svg.circle(self.place(extremum.wavelength_um, extremum.emissivity), 2.6, &circle);
        }
        if !name_them {
            return;
        }
        let points = self.points(curve);
        let mut taken = Vec::new();
        for extremum in found.extrema() {
            let is_christiansen = Some(extremum) == found.christiansen;
            let is_peak = [found.reststrahlen, found.doublet_12_um]
                .iter()
                .any(|doublet| doublet.is_some_and(|d| d.peak == extremum));
            let name = if is_christiansen { "Christiansen " } else { "" };
            let text = format!("{name}{:.2} µm", extremum.wavelength_um);
            let at = self.place(extremum.wavelength_um, extremum.emissivity);
            let size = (text_width(&text, MARK_SIZE), MARK_SIZE);
            let above = is_christiansen || is_peak;
            // On a plot too crowded for it, the circle stands without its wavelength.
            let Some(area) = label::place(at, size, above, &self.area, &points, &taken) else {
                continue;
            };
            draw_mark(svg, at, &area, &text);
            taken.push(area);
        }
    }
}

/// A label in its place, with a line to its point where the eye needs one.
fn draw_mark(svg: &mut Svg, point: Point, area: &Area, text: &str) {
    let (x, y) = area.nearest(point);
    let (dx, dy) = (x - point.0, y - point.1);
    let distance = dx.hypot(dy);
    if distance > 9.0 {
        let at = |d: f64| (point.0 + dx * d / distance, point.1 + dy * d / distance);
        svg.line(&[at(4.0), at(distance - 1.5)], "stroke='#7a7a7a' stroke-width='0.7'");
    }
    let baseline = (0.5 * (area.left + area.right), area.bottom - 0.18 * MARK_SIZE);
    svg.text(baseline, Anchor::Middle, MARK_SIZE, text);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(label: &str, wavelength_um: Vec<f64>, emissivity: impl Fn(f64) -> f64) -> Curve {
        Curve {
            label: label.to_owned(),
            emissivity: wavelength_um.iter().map(|&w| emissivity(w)).collect(),
            half_width: vec![0.005; wavelength_um.len()],
            wavelength_um,
        }
    }

    fn chart(curves: Vec<Curve>) -> Chart {
        let caption = vec!["ray noise only".to_owned()];
        Chart {
            title: "Quartz".to_owned(),
            caption,
            curves,
            mark_features: true,
            hatched_um: vec![],
        }
    }

    fn grid() -> Vec<f64> {
        (0..=670).map(|i| 7.3 + 0.01 * f64::from(i)).collect()
    }

    fn quartz(wavelength_um: f64) -> f64 {
        let bands = [(8.48, 0.1, 0.3), (8.97, 0.15, 0.4), (12.5, 0.06, 0.1), (12.8, 0.06, 0.08)];
        let gauss = |(centre, width, depth): (f64, f64, f64)| {
            depth * (-0.5 * ((wavelength_um - centre) / width).powi(2)).exp()
        };
        0.98 - bands.map(gauss).iter().sum::<f64>()
    }

    #[test]
    fn a_single_curve_carries_the_wavelengths_of_its_features() {
        let svg = emissivity_svg(&chart(vec![curve("bare", grid(), quartz)])).unwrap();
        for text in [
            "Wavelength (µm)",
            "Emissivity",
            "8.48 µm",
            "8.97 µm",
            "12.65 µm",
            "10–12 µm",
            "Shaded bands: 95 % confidence.",
            "ray noise only",
        ] {
            assert!(svg.contains(text), "{text} is missing");
        }
        assert_eq!(svg.matches("<circle").count(), 6);
        assert_eq!(svg.matches("<polygon").count(), 1);
    }

    #[test]
    fn several_curves_carry_circles_and_a_legend() {
        let curves: Vec<Curve> = (0..10)
            .map(|i| curve(&format!("cover <{i}>"), grid(), |w| quartz(w).powi(i + 1)))
            .collect();
        let svg = emissivity_svg(&chart(curves)).unwrap();
        assert!(!svg.contains("8.48 µm"));
        assert!((0..10).all(|i| svg.contains(&format!("cover &lt;{i}&gt;"))));
        assert_eq!(svg.matches("<circle").count(), 60);
        assert_eq!(svg.matches("<polygon").count(), 10);
    }

    #[test]
    fn odd_charts_are_drawn_inside_the_page() {
        let odd = [
            curve("one point", vec![9.0], |_| 0.6),
            curve("flat", vec![7.5, 14.0], |_| 0.95),
            curve("black", vec![7.5, 14.0], |_| 1.0),
            curve("the whole scale", vec![7.5, 10.0, 14.0], |w| f64::from(u8::from(w > 9.0))),
            curve("narrow", vec![8.6, 8.600_01], |_| 0.5),
            curve(&"long label ".repeat(50), grid(), quartz),
            curve("", grid(), quartz),
        ];
        for curve in odd {
            let name = curve.label.clone();
            let svg = emissivity_svg(&chart(vec![curve])).unwrap();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
            let places = svg.split("points='").skip(1).filter_map(|s| s.split('\'').next());
            for place in places.flat_map(|points| points.split(' ')) {
                let (x, _) = place.split_once(',').unwrap();
                assert!((LEFT - 6.0..=RIGHT).contains(&x.parse().unwrap()), "{name}: {place}");
            }
            super::super::png(&svg, 0.5).unwrap();
        }
    }

    #[test]
    fn the_axis_holds_the_data_within_0_to_1() {
        for (low, high) in [(0.4, 0.99), (0.95, 0.95), (1.0, 1.0), (0.0, 0.0), (0.0, 1.0)] {
            let sloping = curve("", vec![8.0, 9.0], |w| if w < 8.5 { low } else { high });
            let (bottom, top) = emissivity_range(&chart(vec![sloping]));
            assert!(0.0 <= bottom && bottom <= low && high <= top && top <= 1.0);
            assert!(top - bottom >= 0.01, "{bottom} to {top}");
        }
    }

    #[test]
    fn nothing_to_draw_is_an_error() {
        let no_points = curve("bare", vec![], |_| 0.9);
        for curves in [vec![], vec![no_points]] {
            assert!(matches!(emissivity_svg(&chart(curves)), Err(PlotError::Empty)));
        }
    }
}
