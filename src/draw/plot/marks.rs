//! The features of a mineral, marked on its curve.

use super::curve::Curve;
use super::emissivity::{MARK_SIZE, Plot};
use super::label::{self, Area};
use super::legend::Pen;
use super::svg::{Anchor, Point, Svg, text_width};
use crate::spectrum::features::features;
use crate::support::math;

impl Plot {
    /// Circles at the extrema, on request with their wavelengths.
    pub(super) fn mark_features(&mut self, curve: &Curve, pen: &Pen, name_them: bool) {
        let found = features(&curve.wavelength_um, &curve.emissivity, &curve.windows);
        let circle = format!("fill='#ffffff' stroke='{}' stroke-width='1.3'", pen.colour);
        for extremum in found.extrema() {
            let at = self.place(extremum.wavelength_um, extremum.emissivity);
            self.page.svg.circle(at, 2.6, &circle);
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
            // Without a free place the circle has no wavelength.
            if let Some(area) = label::place(at, size, above, &self.page.area, &points, &taken) {
                draw_mark(&mut self.page.svg, at, &area, &text);
                taken.push(area);
            }
        }
    }
}

/// A label in its place, with a line to its point if they are apart.
fn draw_mark(svg: &mut Svg, point: Point, area: &Area, text: &str) {
    let (x, y) = area.nearest(point);
    let (dx, dy) = (x - point.0, y - point.1);
    let distance = math::hypot(dx, dy);
    if distance > 9.0 {
        let at = |d: f64| (point.0 + dx * d / distance, point.1 + dy * d / distance);
        svg.line(&[at(4.0), at(distance - 1.5)], "stroke='#7a7a7a' stroke-width='0.7'");
    }
    let baseline = (0.5 * (area.left + area.right), area.bottom - 0.18 * MARK_SIZE);
    svg.text(baseline, Anchor::Middle, MARK_SIZE, text);
}
