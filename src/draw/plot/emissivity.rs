//! Emissivity against wavelength, with error bands and the features of the mineral.

use std::collections::BTreeSet;

use super::PlotError;
use super::axis::{Axis, ends, round_step};
use super::curve::Curve;
use super::label::Area;
use super::legend::Pen;
use super::page::{Layout, Page};
use super::svg::{Anchor, Point, text_width};
use crate::spectrum::features::features;

/// A chart of one curve or several. The features of each curve's mineral are marked: with their
/// wavelengths on a single curve, with circles on several.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Small lines under the axes: method, kind of noise, versions.
    pub caption: Vec<String>,
    /// The curves, in the order of the legend.
    pub curves: Vec<Curve>,
    /// Ranges of wavelengths that are hatched because the result is not valid there, um.
    pub hatched_um: Vec<[f64; 2]>,
    /// Whether title, caption and marks are left out, as papers want it.
    pub bare: bool,
}

const PLOT_HEIGHT: f64 = 350.0;
pub(super) const MARK_SIZE: f64 = 11.5;

/// Draws the chart as SVG. The same chart gives the same bytes.
///
/// # Errors
/// No curve or no point; columns of different length; numbers that are not finite, wavelengths
/// that do not ascend, emissivities outside 0 to 1.
pub fn emissivity_svg(chart: &Chart) -> Result<String, PlotError> {
    chart.curves.iter().try_for_each(Curve::check)?;
    let wavelengths = ends(chart.curves.iter().flat_map(|c| &c.wavelength_um).copied());
    let wavelengths = wavelengths.ok_or(PlotError::Empty)?;
    let bands: Vec<bool> = chart.curves.iter().map(Curve::has_band).collect();
    let found = |c: &Curve| features(&c.wavelength_um, &c.emissivity, &c.windows);
    let with_extrema = chart.curves.iter().map(found).filter(|f| f.extrema().next().is_some());
    let minerals: BTreeSet<String> = with_extrema.filter_map(|found| found.mineral).collect();
    let circles = (!minerals.is_empty())
        .then(|| format!("Circles: extrema of {}.", Vec::from_iter(minerals).join(", ")));
    let rays = chart.curves.iter().any(|curve| !curve.of_rays.is_empty());
    let key = [
        bands.contains(&true).then_some(if rays {
            "Shaded bands: total uncertainty at 95 %; darker: the rays' own."
        } else {
            "Shaded bands: uncertainty at 95 %."
        }),
        circles.as_deref(),
    ];
    let key: Vec<&str> = key.into_iter().flatten().collect();
    let bare = chart.bare;
    let captions = [key.join(" ")].into_iter().chain(chart.caption.clone());
    let caption: Vec<String> = captions.filter(|_| !bare).collect();
    let page = Page::new(Layout {
        title: if bare { "" } else { &chart.title },
        labels: chart.curves.iter().map(|c| c.label.as_str()).collect(),
        bands,
        plot_height: PLOT_HEIGHT,
        above: if bare { 4.0 } else { 26.0 },
        caption: &caption,
    });
    let Area { left, top, right, bottom } = page.area;
    let mut plot = Plot {
        x: Axis::linear(widened(wavelengths, 1e-3), (left, right), 8.0),
        y: Axis::linear(emissivity_range(chart), (bottom, top), 8.0),
        page,
    };
    if !bare {
        let shaded = chart.curves.iter().flat_map(|curve| &curve.windows.shaded_um);
        let mut drawn = Vec::new();
        for of in shaded {
            if !drawn.contains(&of) {
                plot.draw_window(of.0, *of.1);
                drawn.push(of);
            }
        }
    }
    for &range_um in &chart.hatched_um {
        plot.draw_hatching(range_um);
    }
    plot.page.axes(&plot.x, &plot.y, ["Wavelength (µm)", "Emissivity"]);
    let pens: Vec<Pen> = (0..chart.curves.len()).map(Pen::of).collect();
    let curves = || chart.curves.iter().zip(&pens);
    curves().for_each(|(curve, pen)| plot.draw_band(curve, &curve.half_width, pen));
    curves().for_each(|(curve, pen)| plot.draw_band(curve, &curve.of_rays, pen));
    curves().for_each(|(curve, pen)| plot.draw_curve(curve, pen));
    if !bare {
        curves().for_each(|(curve, pen)| plot.mark_features(curve, pen, pens.len() == 1));
    }
    Ok(plot.page.svg.finish())
}

/// The span, made at least `least` wide.
fn widened((low, high): (f64, f64), least: f64) -> (f64, f64) {
    let more = (0.5 * (least - (high - low))).max(0.0);
    (low - more, high + more)
}

/// The ends of the emissivity axis: the data with a margin, at round values, within 0 to 1.
fn emissivity_range(chart: &Chart) -> (f64, f64) {
    let values = chart.curves.iter().flat_map(Curve::with_band);
    let (low, high) = widened(ends(values).unwrap_or((0.0, 1.0)), 0.02);
    let margin = 0.1 * (high - low);
    let (low, high) = ((low - margin).max(0.0), (high + margin).min(1.0));
    let step = 0.5 * round_step(high - low, 8.0);
    ((low / step).floor() * step, ((high / step).ceil() * step).min(1.0))
}

/// The chart's page and scales.
pub(super) struct Plot {
    pub page: Page,
    x: Axis,
    y: Axis,
}

impl Plot {
    pub(super) fn place(&self, wavelength_um: f64, emissivity: f64) -> Point {
        (self.x.place(wavelength_um), self.y.place(emissivity.clamp(0.0, 1.0)))
    }

    pub(super) fn points(&self, curve: &Curve) -> Vec<Point> {
        curve.wavelength_um.iter().zip(&curve.emissivity).map(|(&w, &e)| self.place(w, e)).collect()
    }

    /// Shades a window and names it above the plot, with as many words as fit.
    fn draw_window(&mut self, name: &str, [start, end]: [f64; 2]) {
        let Area { left, top, right, bottom } = self.page.area;
        let [from, to] = [start, end].map(|w| self.x.place(w).clamp(left, right));
        if to - from < 1.0 {
            return;
        }
        let svg = &mut self.page.svg;
        svg.rectangle((from, top), (to - from, bottom - top), "fill='#f1f3f5'");
        let bracket = [(from, top - 4.0), (from, top - 8.0), (to, top - 8.0), (to, top - 4.0)];
        svg.line(&bracket, "stroke='#7a7a7a' stroke-width='0.8'");
        let short = format!("{start}–{end} µm");
        let names = [format!("{name}, {short}"), short];
        if let Some(text) = names.iter().find(|text| text_width(text, MARK_SIZE) < to - from) {
            let at = (f64::midpoint(from, to), top - 13.0);
            svg.styled_text(at, Anchor::Middle, MARK_SIZE, text, "fill='#555555'");
        }
    }

    /// Slanted lines over a range of wavelengths.
    fn draw_hatching(&mut self, range_um: [f64; 2]) {
        const DISTANCE: f64 = 7.0;
        let Area { left, top, right, bottom } = self.page.area;
        let [from, to] = range_um.map(|w| self.x.place(w).clamp(left, right));
        let (from, to) = widened((from, to), 1.0);
        let style = "stroke='#8a6d3b' stroke-width='0.7' stroke-opacity='0.55'";
        let height = bottom - top;
        // Lines rise at 45 degrees. Those of all ranges lie on one lattice.
        let mut foot = ((from - height) / DISTANCE).ceil() * DISTANCE;
        while foot < to {
            let [start, end] = [from.max(foot), to.min(foot + height)];
            if start < end {
                let line = [start, end].map(|x| (x, bottom - (x - foot)));
                self.page.svg.line(&line, style);
            }
            foot += DISTANCE;
        }
    }

    fn draw_band(&mut self, curve: &Curve, half_width: &[f64], pen: &Pen) {
        if half_width.iter().all(|&h| h == 0.0) {
            return;
        }
        let side = |sign: f64| -> Vec<Point> {
            let ends = curve.emissivity.iter().zip(half_width).map(|(e, h)| e + sign * h);
            curve.wavelength_um.iter().zip(ends).map(|(&w, e)| self.place(w, e)).collect()
        };
        let (upper, lower) = (side(1.0), side(-1.0));
        if upper.len() == 1 {
            // The band of a single point is an error bar.
            self.page.svg.line(&[lower[0], upper[0]], &pen.line());
        } else {
            self.page.svg.band(upper, lower, &pen.band());
        }
    }

    fn draw_curve(&mut self, curve: &Curve, pen: &Pen) {
        let points = self.points(curve);
        if let [point] = points[..] {
            self.page.svg.circle(point, 3.0, &format!("fill='{}'", pen.colour));
        } else {
            self.page.svg.line(&points, &pen.line());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::plot::page::{LEFT, RIGHT};
    use crate::spectrum::features::Windows;

    fn curve(label: &str, wavelength_um: Vec<f64>, emissivity: impl Fn(f64) -> f64) -> Curve {
        Curve {
            label: label.to_owned(),
            emissivity: wavelength_um.iter().map(|&w| emissivity(w)).collect(),
            half_width: vec![0.005; wavelength_um.len()],
            of_rays: vec![],
            windows: Windows::quartz().clone(),
            wavelength_um,
        }
    }

    fn chart(curves: Vec<Curve>) -> Chart {
        let caption = vec!["ray noise only".to_owned()];
        Chart { title: "Quartz".to_owned(), caption, curves, hatched_um: vec![], bare: false }
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
            "Shaded bands: uncertainty at 95 %.",
            "ray noise only",
        ] {
            assert!(svg.contains(text), "{text} is missing");
        }
        assert_eq!(svg.matches("<circle").count(), 6);
        assert_eq!(svg.matches("<polygon").count(), 1);
    }

    #[test]
    fn the_rays_own_band_lies_within_the_total_and_a_bare_figure_has_no_words_around_it() {
        let mut one = curve("bare", grid(), quartz);
        one.of_rays = vec![0.001; one.half_width.len()];
        let full = chart(vec![one]);
        let svg = emissivity_svg(&full).unwrap();
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert!(svg.contains("darker: the rays' own."));
        let svg = emissivity_svg(&Chart { bare: true, ..full }).unwrap();
        assert_eq!(svg.matches("<polygon").count(), 2);
        assert!(svg.contains("Emissivity") && svg.contains(">bare<"));
        for word in ["<circle", "Quartz", "ray noise", "Reststrahlen", "Shaded"] {
            assert!(!svg.contains(word), "{word}");
        }
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
            crate::draw::plot::png(&svg, 0.5).unwrap();
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
