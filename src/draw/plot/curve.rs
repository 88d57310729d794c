//! Emissivity curves of charts.

use super::PlotError;
use crate::signature::Band;
use crate::signature::budget::Budget;
use crate::spectrum::features::Windows;

/// One emissivity curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub label: String,
    /// Wavelengths, um, ascending.
    pub wavelength_um: Vec<f64>,
    /// Emissivities, 0 to 1.
    pub emissivity: Vec<f64>,
    /// Half-widths of the band about the curve, the total uncertainty at 95 %; 0 for none.
    pub half_width: Vec<f64>,
    /// Half-widths of a darker band within, that of the rays alone; empty for none.
    pub of_rays: Vec<f64>,
    /// Where its mineral has its features.
    pub windows: Windows,
}

impl Curve {
    /// The curve of a signature with its budget.
    pub fn of(label: &str, bands: &[Band], budget: &Budget, windows: &Windows) -> Self {
        Self {
            label: label.to_owned(),
            wavelength_um: bands.iter().map(|band| band.wavelength_um).collect(),
            emissivity: bands.iter().map(|band| band.emissivity.mean).collect(),
            half_width: budget.bands.iter().map(|share| share.total).collect(),
            of_rays: budget.bands.iter().map(|share| share.rays).collect(),
            windows: windows.clone(),
        }
    }

    /// Whether there is a band about it.
    pub(super) fn has_band(&self) -> bool {
        self.half_width.iter().any(|&half_width| half_width > 0.0)
    }

    /// Both ends of the band at each point.
    pub(super) fn with_band(&self) -> impl Iterator<Item = f64> {
        self.emissivity.iter().zip(&self.half_width).flat_map(|(e, h)| [e - h, e + h])
    }

    /// Checks that the curve can be drawn.
    pub(super) fn check(&self) -> Result<(), PlotError> {
        let Curve { label, wavelength_um, emissivity, half_width, of_rays, .. } = self;
        let wrong = |problem| Err(PlotError::Curve { label: label.clone(), problem });
        if [emissivity.len(), half_width.len()] != [wavelength_um.len(); 2] {
            return wrong(format!(
                "it has {} wavelengths, {} emissivities and {} half-widths",
                wavelength_um.len(),
                emissivity.len(),
                half_width.len()
            ));
        }
        if !of_rays.is_empty() && of_rays.len() != half_width.len() {
            return wrong(format!("it has {} half-widths of rays", of_rays.len()));
        }
        let mut before = 0.0;
        for (i, &um) in wavelength_um.iter().enumerate() {
            let (e, h) = (emissivity[i], half_width[i]);
            // NaN fails every test. Rounding may carry an emissivity of 1 a little further.
            let (what, value, rule) = if !(um > before && um.is_finite()) {
                ("wavelength", um, "above 0 and above the one before it")
            } else if !(-1e-9..=1.0 + 1e-9).contains(&e) {
                ("emissivity", e, "from 0 to 1")
            } else if !(h >= 0.0 && h.is_finite()) {
                ("half-width", h, "0 or more")
            } else {
                before = um;
                continue;
            };
            let point = i + 1;
            return wrong(format!("the {what} of point {point} is {value}, and must be {rule}"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(change: impl Fn(&mut Curve)) -> String {
        let mut curve = Curve {
            label: "bare".to_owned(),
            wavelength_um: vec![8.0, 9.0, 10.0],
            emissivity: vec![0.0, 0.9, 1.0],
            half_width: vec![0.0, 0.01, 0.0],
            of_rays: vec![],
            windows: Windows::default(),
        };
        curve.check().unwrap();
        change(&mut curve);
        curve.check().unwrap_err().to_string()
    }

    #[test]
    fn a_curve_that_cannot_be_drawn_is_an_error_that_names_the_point() {
        assert_eq!(
            message(|c| c.emissivity[1] = f64::NAN),
            "curve 'bare': the emissivity of point 2 is NaN, and must be from 0 to 1"
        );
        assert!(message(|c| c.emissivity[0] = 1.2).contains("emissivity of point 1 is 1.2"));
        assert!(message(|c| c.wavelength_um[2] = 8.5).contains("wavelength of point 3 is 8.5"));
        assert!(
            message(|c| c.wavelength_um[0] = f64::INFINITY)
                .contains("wavelength of point 1 is inf")
        );
        assert!(message(|c| c.half_width[2] = -0.1).contains("half-width of point 3 is -0.1"));
        assert!(message(|c| c.half_width.clear()).contains("0 half-widths"));
    }
}
