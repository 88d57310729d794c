//! A spectrum as points.

use std::fmt;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{SpectrumError, kirchhoff};
use crate::support::file_error::FileError;
use crate::support::linear::{LIKELY_UM, OutOfRange, ends, interpolate, rounded_within, span};

/// A spectrum as points, with straight lines between them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Tabulated {
    /// Name of the file that the points come from.
    pub file: String,
    /// The name of the spectrum in the file, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Wavelengths, um, ascending, at least two.
    pub wavelength_um: Vec<f64>,
    /// Emissivity at each, 0 to 1.
    pub emissivity: Vec<f64>,
    /// Gaps of deleted channels: the last wavelength before each and the first after it, um.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps_um: Vec<[f64; 2]>,
    /// Warnings about its values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<Warning>,
}

/// A warning about a spectrum that can still be used.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Warning {
    /// The reflectance was measured in one direction only.
    Bidirectional(String),
    /// The file does not say how the reflectance was measured.
    GeometryNotStated,
    /// The file's weights by angle are not used.
    AngularWeights,
    /// The step is 100 cm-1, as in DIRSIG's old files.
    Coarse,
    /// Wavelengths are outside 0.1 to 1000 um: perhaps the unit is another.
    UnlikelyWavelengths(String),
    /// It is the mean of so many curves.
    MeanOf(usize),
}

impl Warning {
    /// In a few words, for captions.
    pub fn in_short(&self) -> &'static str {
        match self {
            Self::Bidirectional(_) => "bidirectional: its level is not an emissivity",
            Self::GeometryNotStated => "perhaps not hemispherical",
            Self::AngularWeights => "weights by angle not used",
            Self::Coarse => "too coarse for quartz",
            Self::UnlikelyWavelengths(_) => "unlikely wavelengths",
            Self::MeanOf(_) => "mean of several curves",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bidirectional(said) => write!(
                f,
                "the file says {said:?}: emissivity is 1 - reflectance (Kirchhoff) only for light \
                 reflected into the whole hemisphere, so the level is not reliable"
            ),
            Self::GeometryNotStated => f.write_str(
                "the file does not say how the reflectance was measured: emissivity is \
                 1 - reflectance (Kirchhoff) only for light reflected into the whole hemisphere",
            ),
            Self::AngularWeights => f.write_str(
                "the file weights the emissivity by angle: the weights are not used, so it holds \
                 only near the nadir",
            ),
            Self::Coarse => f.write_str(
                "the points are 100 cm-1 apart (0.8 um at 9 um): too coarse for the bands of quartz, \
                 0.1 um wide",
            ),
            Self::UnlikelyWavelengths(range) => write!(
                f,
                "the wavelengths are {range} um: if the unit is another, write it into the \
                 heading or give `soilsig spectra convert` the option --unit"
            ),
            Self::MeanOf(curves) => write!(
                f,
                "the file holds {curves} curves: their mean is used; `soilsig spectra convert FILE \
                 --name NUMBER --out FILE.csv` writes one of them"
            ),
        }
    }
}

/// The quantity that a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Quantity {
    /// Emissivity, 0 to 1.
    Emissivity,
    /// The same in percent.
    EmissivityPercent,
    /// Hemispherical reflectance of an opaque sample, 0 to 1.
    Reflectance,
    /// The same in percent.
    ReflectancePercent,
}

impl Quantity {
    /// Whether it is in percent.
    pub(super) fn is_percent(self) -> bool {
        matches!(self, Self::EmissivityPercent | Self::ReflectancePercent)
    }

    /// Whether it is reflectance.
    pub(super) fn is_reflectance(self) -> bool {
        matches!(self, Self::Reflectance | Self::ReflectancePercent)
    }

    fn emissivity(self, value: f64) -> f64 {
        match self {
            Self::Emissivity => value,
            Self::EmissivityPercent => value / 100.0,
            Self::Reflectance => kirchhoff(value),
            Self::ReflectancePercent => kirchhoff(value / 100.0),
        }
    }
}

/// What to do about values that seem to be percent.
fn percent_hint(quantity: Quantity) -> &'static str {
    if quantity.is_reflectance() {
        "if the values are percent, say it: `soilsig spectra convert FILE --quantity \
         reflectance-percent --out FILE.csv`; else leave out bad values by --range FROM-TO"
    } else {
        "if the values are percent, say it: `soilsig spectra convert FILE --quantity \
         emissivity-percent --out FILE.csv`; else leave out bad values by --range FROM-TO"
    }
}

/// A row of a file, with its line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub line: u64,
    pub um: f64,
    /// `None` for a deleted channel.
    pub value: Option<f64>,
}

impl Tabulated {
    /// A spectrum from points of wavelength, um, and emissivity, in any order.
    ///
    /// # Errors
    /// Fewer than two points, an emissivity outside 0 to 1, a wavelength that is not above 0 or
    /// appears twice.
    pub fn new(name: &str, points: &[(f64, f64)]) -> Result<Self, SpectrumError> {
        let row = |(line, &(um, value)): (u64, &(f64, f64))| Row { line, um, value: Some(value) };
        let rows = (1..).zip(points).map(row).collect();
        Self::of_rows(Path::new(name), rows, Quantity::Emissivity, None)
    }

    /// Checks the rows of a file, in any order, and makes them a spectrum. With `range_um` only the
    /// rows that this range needs are used.
    pub(super) fn of_rows(
        path: &Path,
        mut rows: Vec<Row>,
        quantity: Quantity,
        range_um: Option<[f64; 2]>,
    ) -> Result<Self, SpectrumError> {
        let wrong = |line: u64, problem: String| {
            SpectrumError::from(FileError::wrong_in_line(path, line, problem))
        };
        if let Some(row) = rows.iter().find(|row| !(row.um.is_finite() && row.um > 0.0)) {
            return Err(wrong(row.line, format!("{} is not a valid wavelength in um", row.um)));
        }
        rows.sort_by(|a, b| a.um.total_cmp(&b.um));
        let held_um = rows.first().zip(rows.last()).map(|(first, last)| [first.um, last.um]);
        if let Some(([from, to], held_um)) = range_um.zip(held_um) {
            if to < held_um[0] || from > held_um[1] {
                let of = format!("the spectrum of {}", path.display());
                return Err(OutOfRange { of, needed_um: [from, to], held_um }.into());
            }
            // With the neighbours of its ends, for interpolation there.
            let before = |um: f64| rows.partition_point(|row| row.um < um);
            let up_to = |um: f64| rows.partition_point(|row| row.um <= um);
            // All points of the end itself: one that appears twice is told below.
            let first = before(from).min(up_to(from).saturating_sub(1));
            let end = rows.len().min(up_to(to).max(before(to) + 1));
            rows = rows.get(first..end).unwrap_or_default().to_vec();
        }
        if let Some(pair) = rows.windows(2).find(|pair| pair[0].um == pair[1].um) {
            return Err(wrong(pair[1].line, format!("{} um appears twice", pair[1].um)));
        }
        let mut spectrum = Self {
            file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            ..Self::default()
        };
        let mut is_after_deleted = false;
        for row in rows {
            let Some(value) = row.value else {
                is_after_deleted = true;
                continue;
            };
            let emissivity = rounded_within(quantity.emissivity(value), [0.0, 1.0]);
            if !(0.0..=1.0).contains(&emissivity) {
                let (what, bounds) = match quantity {
                    Quantity::Emissivity => ("an emissivity", "0 to 1"),
                    Quantity::EmissivityPercent => ("an emissivity", "0 to 100 percent"),
                    Quantity::Reflectance => ("a reflectance", "0 to 1"),
                    Quantity::ReflectancePercent => ("a reflectance", "0 to 100 percent"),
                };
                let problem = format!("{what} of {value} is not within {bounds}");
                let error = FileError::wrong_in_line(path, row.line, problem);
                // Most values above 1 are percent.
                return Err(match quantity {
                    Quantity::Emissivity | Quantity::Reflectance
                        if (1.0..=100.0).contains(&value) =>
                    {
                        error.with_hint(percent_hint(quantity))
                    }
                    _ => error,
                }
                .into());
            }
            if let (true, Some(&last)) = (is_after_deleted, spectrum.wavelength_um.last()) {
                spectrum.gaps_um.push([last, row.um]);
            }
            is_after_deleted = false;
            spectrum.wavelength_um.push(row.um);
            spectrum.emissivity.push(emissivity);
        }
        if spectrum.wavelength_um.len() < 2 {
            return Err(FileError::wrong(path, "a spectrum needs at least two points").into());
        }
        if let Some(held_um) =
            held_um.filter(|[from, to]| *to < LIKELY_UM[0] || *from > LIKELY_UM[1])
        {
            spectrum.warnings.push(Warning::UnlikelyWavelengths(span(held_um)));
        }
        Ok(spectrum)
    }

    /// The mean of several curves of a file, where all hold values.
    pub(super) fn mean(curves: &[Self]) -> Result<Self, SpectrumError> {
        let held = curves.iter().map(Self::range_um);
        let [from, to] = held.fold([0.0, f64::INFINITY], |[from, to], held| {
            [f64::max(from, held[0]), f64::min(to, held[1])]
        });
        let mut wavelength_um: Vec<f64> =
            curves.iter().flat_map(|curve| &curve.wavelength_um).copied().collect();
        wavelength_um.retain(|um| (from..=to).contains(um));
        wavelength_um.sort_by(f64::total_cmp);
        wavelength_um.dedup();
        let first = curves.first().cloned().unwrap_or_default();
        if wavelength_um.len() < 2 {
            let problem = "its curves have no two wavelengths in common";
            return Err(FileError::wrong(Path::new(&first.file), problem).into());
        }
        let at = |um: f64| {
            let values = curves.iter().map(|c| interpolate(&c.wavelength_um, &c.emissivity, um));
            (values.sum::<f64>() / curves.len() as f64).min(1.0)
        };
        let emissivity = wavelength_um.iter().map(|&um| at(um)).collect();
        let gaps_um = curves.iter().flat_map(|curve| &curve.gaps_um).copied().collect();
        let warnings = [first.warnings, vec![Warning::MeanOf(curves.len())]].concat();
        Ok(Self { file: first.file, name: None, wavelength_um, emissivity, gaps_um, warnings })
    }

    /// An estimate of the largest error of straight lines between the points within a range (um),
    /// and its wavelength, um. `None` if no point has two neighbours.
    ///
    /// The distance of a point from the line between its neighbours gives the curvature.
    pub fn sampling_error(&self, [from, to]: [f64; 2]) -> Option<(f64, f64)> {
        let bend = |i: usize| {
            let [x0, x, x1] = [i - 1, i, i + 1].map(|i| self.wavelength_um[i]);
            let [y0, y, y1] = [i - 1, i, i + 1].map(|i| self.emissivity[i]);
            let off = y - (y0 + (y1 - y0) * (x - x0) / (x1 - x0));
            // y'' = 2 off / (h0 h1), and a straight line over h misses by h^2 y'' / 8.
            let h = (x - x0).max(x1 - x);
            (off.abs() * h * h / (4.0 * (x - x0) * (x1 - x)), x)
        };
        (1..self.wavelength_um.len() - 1)
            .filter(|&i| self.wavelength_um[i + 1] > from && self.wavelength_um[i - 1] < to)
            .map(bend)
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Whether it is a valid spectrum: its file may be of another origin.
    pub(super) fn is_sound(&self) -> bool {
        self.wavelength_um.len() >= 2
            && self.wavelength_um.len() == self.emissivity.len()
            && self.wavelength_um.windows(2).all(|pair| pair[0] < pair[1])
            && self.emissivity.iter().all(|e| (0.0..=1.0).contains(e))
    }

    /// Least and greatest wavelength, um.
    pub fn range_um(&self) -> [f64; 2] {
        ends(&self.wavelength_um)
    }

    /// The gap that a wavelength falls into, if any.
    pub(super) fn gap_um(&self, um: f64) -> Option<[f64; 2]> {
        self.gaps_um.iter().copied().find(|&[from, to]| from < um && um < to)
    }
}
