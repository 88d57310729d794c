//! Emissivity curves as charts take them.

use super::PlotError;
use crate::signature::Band;

/// One emissivity curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub label: String,
    /// Wavelengths, micrometres, ascending.
    pub wavelength_um: Vec<f64>,
    /// Emissivities, 0 to 1.
    pub emissivity: Vec<f64>,
    /// Half-widths of the 95 % confidence intervals of the emissivities; 0 for none.
    pub half_width: Vec<f64>,
}

impl Curve {
    /// The curve of a signature.
    pub fn of(label: &str, bands: &[Band]) -> Self {
        Self {
            label: label.to_owned(),
            wavelength_um: bands.iter().map(|band| band.wavelength_um).collect(),
            emissivity: bands.iter().map(|band| band.emissivity.mean).collect(),
            half_width: bands.iter().map(|band| band.emissivity.half_width).collect(),
        }
    }

    /// Whether the curve can be drawn.
    pub(super) fn check(&self) -> Result<(), PlotError> {
        let Curve { label, wavelength_um, emissivity, half_width } = self;
        if wavelength_um.len() != emissivity.len() || wavelength_um.len() != half_width.len() {
            return Err(PlotError::Lengths {
                curve: label.clone(),
                wavelengths: wavelength_um.len(),
                emissivities: emissivity.len(),
                half_widths: half_width.len(),
            });
        }
        // Written so that NaN fails every test.
        let rule =
            |quantity, values: &[f64], expected, good: &dyn Fn(usize, f64) -> bool| match values
                .iter()
                .enumerate()
                .find(|&(i, &value)| !good(i, value))
            {
                None => Ok(()),
                Some((i, &value)) => Err(PlotError::Value {
                    curve: label.clone(),
                    point: i + 1,
                    quantity,
                    value,
                    expected,
                }),
            };
        rule("wavelength", wavelength_um, "above 0 and above the one before it", &|i, value| {
            value.is_finite() && value > if i == 0 { 0.0 } else { wavelength_um[i - 1] }
        })?;
        // Rounding may carry an emissivity of 1 a little further.
        rule("emissivity", emissivity, "from 0 to 1", &|_, value| {
            (-1e-9..=1.0 + 1e-9).contains(&value)
        })?;
        rule("half-width", half_width, "0 or more", &|_, value| value.is_finite() && value >= 0.0)
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
        };
        curve.check().unwrap();
        change(&mut curve);
        curve.check().unwrap_err().to_string()
    }

    #[test]
    fn what_cannot_be_drawn_is_an_error_that_names_the_place() {
        assert_eq!(
            message(|c| c.emissivity[1] = f64::NAN),
            "curve 'bare', point 2: the emissivity is NaN, and must be from 0 to 1"
        );
        assert!(message(|c| c.emissivity[0] = 1.2).contains("point 1: the emissivity is 1.2"));
        assert!(message(|c| c.wavelength_um[2] = 8.5).contains("point 3: the wavelength is 8.5"));
        assert!(message(|c| c.wavelength_um[0] = f64::INFINITY).contains("wavelength is inf"));
        assert!(message(|c| c.half_width[2] = -0.1).contains("the half-width is -0.1"));
        assert!(message(|c| c.half_width.clear()).contains("0 half-widths"));
    }
}
