//! A fit: what was measured and fitted, the residual below, and the posterior of the parameters.

use super::PlotError;
use super::axis::{Axis, around};
use super::curve::Curve;
use super::label::Area;
use super::legend::Pen;
use super::page::{Layout, Page};
use super::svg::{Anchor, Point, Svg, wrapped};

/// A fit of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct FitChart {
    /// Title.
    pub title: String,
    /// Small lines under the axes.
    pub caption: Vec<String>,
    /// Name of the quantity.
    pub quantity: String,
    /// Measured with its errors, then fits.
    pub curves: Vec<Curve>,
    /// Measured less the first fit.
    pub residual: Vec<f64>,
    /// Half-widths within which 95 % of the residuals are expected.
    pub expected: Vec<f64>,
}

const FIT_HEIGHT: f64 = 300.0;
const GAP: f64 = 40.0;
const RESIDUAL_HEIGHT: f64 = 120.0;

/// Draws a fit as SVG. The same chart gives the same bytes.
///
/// # Errors
/// There is no curve, or one has no points.
pub fn fit_svg(chart: &FitChart) -> Result<String, PlotError> {
    let measured = chart.curves.first().filter(|c| !c.wavelength_um.is_empty());
    let um = &measured.ok_or(PlotError::Empty)?.wavelength_um;
    let mut page = Page::new(Layout {
        title: &chart.title,
        labels: chart.curves.iter().map(|c| c.label.as_str()).collect(),
        bands: chart.curves.iter().map(Curve::has_band).collect(),
        plot_height: FIT_HEIGHT + GAP + RESIDUAL_HEIGHT,
        above: 14.0,
        caption: &chart.caption,
    });
    let whole = page.area;
    let x = Axis::linear((um[0], um[um.len() - 1]), (whole.left, whole.right), 8.0);
    let ends = chart.curves.iter().flat_map(Curve::with_band);
    let upper = Area { bottom: whole.top + FIT_HEIGHT, ..whole };
    let y = Axis::linear(around(ends, 8.0), (upper.bottom, upper.top), 8.0);
    page.area = upper;
    page.axes(&x, &y, ["", &chart.quantity]);
    for (curve, pen) in chart.curves.iter().zip((0..).map(Pen::of)) {
        let at = |um: f64, e: f64| (x.place(um), y.place(e));
        let side = |sign: f64| -> Vec<Point> {
            let of = curve.emissivity.iter().zip(&curve.half_width).map(|(e, h)| e + sign * h);
            curve.wavelength_um.iter().zip(of).map(|(&um, e)| at(um, e)).collect()
        };
        if curve.half_width.iter().any(|&h| h > 0.0) {
            page.svg.band(side(1.0), side(-1.0), &pen.band());
        }
        page.svg.line(&side(0.0), &pen.line());
    }
    let lower = Area { top: upper.bottom + GAP, ..whole };
    let widest = chart.residual.iter().chain(&chart.expected).map(|r| r.abs());
    let y = Axis::linear(around(widest.flat_map(|r| [-r, r]), 8.0), (lower.bottom, lower.top), 4.0);
    page.area = lower;
    page.axes(&x, &y, ["Wavelength (µm)", "Residual"]);
    let points = |values: &[f64], sign: f64| -> Vec<Point> {
        um.iter().zip(values).map(|(&um, v)| (x.place(um), y.place(sign * v))).collect()
    };
    let [upper, lower] = [1.0, -1.0].map(|sign| points(&chart.expected, sign));
    page.svg.band(upper, lower, "fill='#777777' fill-opacity='0.2'");
    page.svg.line(&points(&vec![0.0; um.len()], 1.0), "stroke='#777777' stroke-width='0.8'");
    page.svg.line(&points(&chart.residual, 1.0), &Pen::of(0).line());
    Ok(page.svg.finish())
}

/// A parameter of a posterior.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Its name, with its unit.
    pub name: String,
    /// Draws from its posterior.
    pub draws: Vec<f64>,
    /// Its value in the best fit.
    pub best: f64,
}

const CELL: f64 = 160.0;
/// Between cells of a corner plot, so that the labels of neighbours stay apart.
const APART: f64 = 24.0;
const EDGE: (f64, f64) = (64.0, 40.0);
/// Height of a line of the title.
const LINE: f64 = 20.0;
/// Labels of an axis, about.
const TICKS: f64 = 5.0;
const BINS: usize = 24;
/// Points of a cloud.
const POINTS: usize = 700;

/// Draws the posterior of each parameter and of each pair: a corner plot.
pub fn posterior_svg(title: &str, parameters: &[Drawn]) -> String {
    let n = parameters.len();
    let size = CELL * n as f64;
    let lines = wrapped(title, 15.0, size);
    let first = EDGE.1 + LINE * (lines.len() - 1) as f64;
    let mut svg = Svg::new(EDGE.0 + size + 20.0, first + size + 52.0, title);
    svg.lines((EDGE.0, 24.0), Anchor::Start, (15.0, LINE), &lines, "");
    let ranges: Vec<(f64, f64)> = parameters.iter().map(Drawn::range).collect();
    for row in 0..n {
        for column in 0..=row {
            let left = EDGE.0 + CELL * column as f64;
            let top = first + CELL * row as f64;
            let (right, bottom) = (left + CELL - APART, top + CELL - APART);
            let x = Axis::linear(ranges[column], (left, right), TICKS);
            let frame = "fill='none' stroke='#1a1a1a' stroke-width='0.9'";
            if row == column {
                histogram(&mut svg, &parameters[row], &x, (top, bottom));
            } else {
                let y = Axis::linear(ranges[row], (bottom, top), TICKS);
                cloud(&mut svg, [&parameters[column], &parameters[row]], [&x, &y]);
                if column == 0 {
                    ticks(&mut svg, &y, |at| ((left - 4.0, at + 4.0), Anchor::End));
                    let middle = (16.0, f64::midpoint(top, bottom));
                    svg.upright_text(middle, 12.0, &parameters[row].name);
                }
            }
            svg.rectangle((left, top), (right - left, bottom - top), frame);
            if row + 1 == n {
                ticks(&mut svg, &x, |at| ((at, bottom + 15.0), Anchor::Middle));
                let middle = (f64::midpoint(left, right), bottom + 34.0);
                svg.text(middle, Anchor::Middle, 12.0, &parameters[column].name);
            }
        }
    }
    svg.finish()
}

impl Drawn {
    fn range(&self) -> (f64, f64) {
        around(self.draws.iter().copied().chain([self.best]), 8.0)
    }
}

/// Labels of an axis; `at` gives the label's place and its anchor.
fn ticks(svg: &mut Svg, axis: &Axis, at: impl Fn(f64) -> (Point, Anchor)) {
    for (value, label) in axis.labels() {
        let (place, anchor) = at(axis.place(value));
        svg.text(place, anchor, 10.5, &label);
    }
}

fn histogram(svg: &mut Svg, of: &Drawn, x: &Axis, (top, bottom): (f64, f64)) {
    let (low, high) = of.range();
    let mut counts = [0_u32; BINS];
    for value in &of.draws {
        let bin = ((value - low) / (high - low) * BINS as f64) as usize;
        counts[bin.min(BINS - 1)] += 1;
    }
    let most = f64::from(*counts.iter().max().unwrap_or(&1)).max(1.0);
    for (bin, count) in counts.iter().enumerate() {
        let ends = [bin, bin + 1].map(|i| x.place(low + (high - low) * i as f64 / BINS as f64));
        let height = 0.92 * (bottom - top) * f64::from(*count) / most;
        let size = (ends[1] - ends[0], height);
        svg.rectangle((ends[0], bottom - height), size, "fill='#0072b2' fill-opacity='0.6'");
    }
    let best = x.place(of.best);
    svg.line(&[(best, top), (best, bottom)], "stroke='#d55e00' stroke-width='1.2'");
}

fn cloud(svg: &mut Svg, of: [&Drawn; 2], axes: [&Axis; 2]) {
    let every = (of[0].draws.len() / POINTS).max(1);
    let place = |a: f64, b: f64| (axes[0].place(a), axes[1].place(b));
    for (a, b) in of[0].draws.iter().zip(&of[1].draws).step_by(every) {
        svg.circle(place(*a, *b), 1.1, "fill='#0072b2' fill-opacity='0.35'");
    }
    let best = place(of[0].best, of[1].best);
    svg.circle(best, 3.0, "fill='none' stroke='#d55e00' stroke-width='1.4'");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(label: &str, level: f64) -> Curve {
        Curve {
            label: label.into(),
            wavelength_um: vec![8.0, 9.0, 10.0],
            emissivity: vec![level, level - 0.1, level],
            half_width: vec![0.01; 3],
            of_rays: Vec::new(),
            windows: crate::spectrum::features::Windows::default(),
        }
    }

    #[test]
    fn a_fit_has_its_curves_bands_and_residual() {
        let chart = FitChart {
            title: "sand".into(),
            caption: vec!["posterior".into()],
            quantity: "Emissivity".into(),
            curves: vec![curve("measured", 0.9), curve("fit", 0.91)],
            residual: vec![-0.01, 0.02, 0.0],
            expected: vec![0.02; 3],
        };
        let svg = fit_svg(&chart).expect("drawn");
        assert_eq!(svg.matches("<polygon").count(), 3);
        assert!(svg.contains("Residual") && svg.contains("posterior") && !svg.contains("NaN"));
        let none = FitChart { curves: vec![], ..chart };
        assert!(matches!(fit_svg(&none), Err(PlotError::Empty)));
    }

    #[test]
    fn a_posterior_has_a_panel_for_each_parameter_and_pair() {
        let of = |name: &str, scale: f64| Drawn {
            name: name.into(),
            draws: (0..50).map(|i| scale * f64::from(i)).collect(),
            best: scale * 20.0,
        };
        let svg = posterior_svg("sand", &[of("cover", 0.01), of("flat", 0.002), of("level", 0.0)]);
        // Three histograms of 24 bars, six frames and the page.
        assert_eq!(svg.matches("<rect").count(), 3 * BINS + 6 + 1);
        assert_eq!(svg.matches("<circle").count(), 3 * 51);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
}
