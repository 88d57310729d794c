//! The wavelengths at which a scene is evaluated.

use serde::{Deserialize, Serialize};

/// Wavelengths that may be asked for, um.
pub const WAVELENGTHS_UM: [f64; 2] = [0.01, 1e4];

/// Equally spaced wavelengths.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "GridFields")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Grid {
    from_um: f64,
    to_um: f64,
    step_um: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct GridFields {
    /// First wavelength, um.
    from_um: f64,
    /// Last wavelength, um, if the step divides the range.
    to_um: f64,
    /// Distance of the wavelengths, um.
    step_um: f64,
}

impl TryFrom<GridFields> for Grid {
    type Error = String;
    fn try_from(grid: GridFields) -> Result<Self, String> {
        Self::new(grid.from_um, grid.to_um, grid.step_um)
    }
}

impl Grid {
    /// The grid of the paper: 7.5 to 14 um in steps of 10 nm, 651 wavelengths.
    pub const PAPER: Self = Self { from_um: 7.5, to_um: 14.0, step_um: 0.01 };

    /// A grid from one wavelength to another, um. It ends at `to_um` if the step divides the range.
    ///
    /// # Errors
    /// The reason, as text, why these are no wavelengths: 0.01 to 10000 um, at most 100,001 of
    /// them, in steps of a picometre or more.
    pub fn new(from_um: f64, to_um: f64, step_um: f64) -> Result<Self, String> {
        let all_finite = [from_um, to_um, step_um].iter().all(|x| x.is_finite());
        if !all_finite || from_um < 0.01 || to_um < from_um || to_um > 1e4 {
            Err(format!(
                "{from_um}-{to_um} um is not a range of wavelengths within 0.01 to 10000 um"
            ))
        } else if step_um < 1e-6 {
            Err(format!("the step of {step_um} um is below a picometre"))
        } else if (to_um - from_um) / step_um > 1e5 {
            Err(format!("the step of {step_um} um makes more than 100000 bands"))
        } else {
            Ok(Self { from_um, to_um, step_um })
        }
    }

    /// The ends of the range, um.
    pub const fn range_um(&self) -> (f64, f64) {
        (self.from_um, self.to_um)
    }

    /// The step between bands, um.
    pub const fn step_um(&self) -> f64 {
        self.step_um
    }

    /// The wavelengths, um, rounded to picometres: 7.5 + 1.13 is exactly 8.63.
    pub fn wavelengths_um(&self) -> Vec<f64> {
        let [from, to, step] =
            [self.from_um, self.to_um, self.step_um].map(|um| (um * 1e6).round() as u64);
        (from..=to).step_by(step as usize).map(|pm| pm as f64 / 1e6).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_grid_has_651_bands_in_round_numbers() {
        let um = Grid::PAPER.wavelengths_um();
        assert_eq!(um.len(), 651);
        assert_eq!((um[0], um[113], um[650]), (7.5, 8.63, 14.0));
    }

    #[test]
    fn invalid_grids_are_refused() {
        for (from, to, step) in [
            (9.0, 8.0, 0.1),
            (8.0, 9.0, 0.0),
            (8.0, 9.0, -1.0),
            (f64::NAN, 9.0, 0.1),
            (-1.0, 9.0, 0.1),
            (8.0, 9.0, 1e-9),
        ] {
            assert!(Grid::new(from, to, step).is_err(), "{from} {to} {step}");
        }
    }
}
