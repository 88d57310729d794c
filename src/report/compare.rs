//! Two results compared, band by band, by their errors.

use std::path::{Path, PathBuf};

use statrs::distribution::{ContinuousCDF, Normal};

use super::Report;
use crate::radiometry::Columns;
use crate::signature::budget::Budget;
use crate::signature::evaluate;
use crate::spectrum::Spectrum;
use crate::spectrum::format::{self, Format, Reading};
use crate::support::csv::{Csv, decimals};
use crate::support::error::Error;
use crate::support::file_error::FileError;
use crate::support::linear::{ends, interpolate};
use crate::support::math;
use crate::table::Table;

/// An emissivity curve of any origin.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The file or folder.
    pub name: String,
    /// Wavelengths, um, ascending.
    pub wavelength_um: Vec<f64>,
    /// Emissivities.
    pub emissivity: Vec<f64>,
    /// Total half-widths at 95 %; `None` where the file does not tell errors.
    pub half_width_95: Option<Vec<f64>>,
}

impl Curve {
    /// Of a result.
    pub fn of(report: &Report) -> Self {
        Self {
            name: "signature".into(),
            wavelength_um: report.bands.iter().map(|band| band.wavelength_um).collect(),
            emissivity: report.bands.iter().map(|band| band.emissivity.mean).collect(),
            half_width_95: Some(report.budget.bands.iter().map(|share| share.total).collect()),
        }
    }

    /// Reads a run (its folder or `run.json`), a bounce table (.json), a signature (.csv), or a
    /// spectrum of any format.
    ///
    /// # Errors
    /// A file that cannot be read or is none of these.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let is_record = path.file_name().is_some_and(|name| name == "run.json");
        let folder =
            if is_record { path.parent() } else { Some(path).filter(|path| path.is_dir()) };
        if let Some(folder) = folder {
            let file = folder.join("signature.csv");
            if !file.is_file() {
                let error = FileError::wrong(folder, "there is no signature.csv in this folder");
                let error = error.with_hint("name the folder of one scene's result");
                return Err(error.into());
            }
            return Ok(Self { name: path.display().to_string(), ..Self::of_signature(&file)? });
        }
        match path.extension().unwrap_or_default().to_string_lossy().to_lowercase().as_str() {
            "json" => Self::of_table(path),
            "csv" if Format::of(path)? == Format::Csv && is_signature(path)? => {
                Self::of_signature(path)
            }
            _ => Self::of_spectrum(path),
        }
    }

    fn of_table(path: &Path) -> Result<Self, Error> {
        let table = [Table::read(path)?];
        let um = table[0].stop.asked.grid.wavelengths_um();
        let bands = evaluate(&table, &um)?;
        let budget = Budget::new(&table, &bands)?;
        Ok(Self {
            name: path.display().to_string(),
            wavelength_um: um,
            emissivity: bands.iter().map(|band| band.emissivity.mean).collect(),
            half_width_95: Some(budget.bands.iter().map(|share| share.total).collect()),
        })
    }

    fn of_signature(path: &Path) -> Result<Self, Error> {
        let columns = Columns::read(path)?;
        let (wavelength_um, rows) = columns.ascending_um()?;
        let sorted =
            |values: Vec<f64>| -> Vec<f64> { rows.iter().map(|&row| values[row]).collect() };
        let mut half_width_95 = None;
        for heading in ["emissivity_total_half_width_95", "emissivity_half_width_95"] {
            if half_width_95.is_none() {
                half_width_95 = columns.column(heading)?.map(sorted);
            }
        }
        Ok(Self {
            name: path.display().to_string(),
            emissivity: sorted(columns.needed("emissivity")?),
            wavelength_um,
            half_width_95,
        })
    }

    fn of_spectrum(path: &Path) -> Result<Self, Error> {
        let points = format::read_one(path, &Reading::default())?;
        let wavelength_um = points.wavelength_um.clone();
        let emissivity = format::sampled(&Spectrum::Tabulated(points), &wavelength_um)?;
        let name = path.display().to_string();
        Ok(Self { name, wavelength_um, emissivity, half_width_95: None })
    }
}

/// Whether a CSV file has the columns of a signature.
fn is_signature(path: &Path) -> Result<bool, Error> {
    let text = crate::support::text::read(path)?;
    let heading = text.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
    let has = |wanted: &str| heading.split(',').any(|name| name.trim() == wanted);
    Ok(has("wavelength_um") && has("emissivity"))
}

/// The difference of two curves in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandDifference {
    /// The band, um.
    pub wavelength_um: f64,
    /// Both emissivities.
    pub emissivity: [f64; 2],
    /// The second less the first.
    pub difference: f64,
    /// Half-width of the difference at 95 %; `None` where no error is known.
    pub half_width_95: Option<f64>,
    /// The difference in standard errors.
    pub z: Option<f64>,
}

/// The difference of two curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// At the bands of the first that the second covers.
    pub bands: Vec<BandDifference>,
    /// Mean of the differences.
    pub bias: f64,
    /// Root of the mean of their squares.
    pub rms: f64,
}

/// Half of the last decimal that files show.
const ROUNDING: f64 = 5e-8;

impl Difference {
    /// Of two curves; between the points of the second lie straight lines.
    ///
    /// # Errors
    /// They have no band in common.
    pub fn new(a: &Curve, b: &Curve) -> Result<Self, FileError> {
        let [from, to] = ends(&b.wavelength_um);
        let at = |values: &[f64], um: f64| interpolate(&b.wavelength_um, values, um);
        let held = |i: &usize| (from - 1e-9..=to + 1e-9).contains(&a.wavelength_um[*i]);
        let band = |i: usize| {
            let um = a.wavelength_um[i];
            let emissivity = [a.emissivity[i], at(&b.emissivity, um)];
            let widths = [
                a.half_width_95.as_ref().map(|widths| widths[i]),
                b.half_width_95.as_ref().map(|widths| at(widths, um)),
            ];
            let known = widths.iter().any(Option::is_some);
            let width =
                widths.iter().flatten().fold(0.0_f64, |sum, width| math::hypot(sum, *width));
            let difference = emissivity[1] - emissivity[0];
            let z = known.then(|| match difference.abs() {
                // What rounding in files makes is no difference.
                d if d <= 2.0 * ROUNDING => 0.0,
                _ => 1.96 * difference / width,
            });
            let half_width_95 = known.then_some(width);
            BandDifference { wavelength_um: um, emissivity, difference, half_width_95, z }
        };
        let bands: Vec<BandDifference> =
            (0..a.wavelength_um.len()).filter(held).map(band).collect();
        if bands.is_empty() {
            let [first, last] = ends(&a.wavelength_um);
            let problem =
                format!("it holds {from}-{to} um, and {} {first}-{last} um: no band of it", a.name);
            return Err(FileError::wrong(&PathBuf::from(&b.name), problem));
        }
        let mean =
            |of: fn(&BandDifference) -> f64| bands.iter().map(of).sum::<f64>() / bands.len() as f64;
        let bias = mean(|band| band.difference);
        let rms = mean(|band| band.difference.powi(2)).sqrt();
        Ok(Self { bands, bias, rms })
    }

    /// The band of the largest difference.
    pub fn worst(&self) -> BandDifference {
        let size = |band: &&BandDifference| band.difference.abs();
        *self.bands.iter().max_by(|a, b| size(a).total_cmp(&size(b))).expect("there is a band")
    }

    /// The band that pulls the curves apart most, in standard errors.
    pub fn farthest(&self) -> Option<BandDifference> {
        let z = |band: &BandDifference| band.z.map(f64::abs);
        let known = self.bands.iter().filter(|band| band.z.is_some());
        known.max_by(|a, b| z(a).partial_cmp(&z(b)).expect("no z is NaN")).copied()
    }

    /// The z that one of all bands passes by chance in one comparison of twenty (Sidak).
    pub fn limit(&self) -> f64 {
        let level = math::pow(0.95, 1.0 / self.bands.len() as f64);
        Normal::standard().inverse_cdf(f64::midpoint(1.0, level))
    }

    /// Whether the curves differ by more than their errors, or by anything where these are unknown.
    pub fn differs(&self) -> bool {
        match self.farthest() {
            Some(band) => band.z.is_some_and(|z| z.abs() > self.limit()),
            None => self.worst().difference.abs() > 2.0 * ROUNDING,
        }
    }

    /// Root mean square, bias and worst band in one line.
    pub fn in_short(&self) -> String {
        let BandDifference { wavelength_um, difference, .. } = self.worst();
        format!(
            "RMS {:.4}, bias {:+.4}, worst band {difference:+.4} at {wavelength_um} um",
            self.rms, self.bias
        )
    }

    /// The answer, in lines.
    pub fn in_words(&self, [a, b]: [&str; 2]) -> String {
        let number = self.bands.len();
        if self.bands.iter().all(|band| band.difference.abs() <= ROUNDING) {
            return format!("{a} and {b} are the same in {number} bands\nthey agree\n");
        }
        let mut text = format!("{b} less {a}, {number} bands: {}\n", self.in_short());
        if let Some(band) = self.farthest() {
            let within = self.bands.iter().filter(|band| band.z.is_some_and(|z| z.abs() <= 1.96));
            text += &format!(
                "{} of {number} bands agree within the 95 % errors of both; {} um pulls them apart \
                 most: z {:+.1}, beyond chance above {:.1}\n",
                within.count(),
                band.wavelength_um,
                band.z.unwrap_or(0.0),
                self.limit()
            );
        } else {
            text += "errors are not known\n";
        }
        text + if self.differs() { "they differ\n" } else { "they agree\n" }
    }

    /// Every band as CSV.
    pub fn csv_text(&self) -> String {
        let headings =
            ["wavelength_um", "emissivity_a", "emissivity_b", "difference", "half_width_95", "z"];
        let mut csv = Csv::new(&headings);
        for band in &self.bands {
            let [a, b] = band.emissivity;
            let numbers = [Some(a), Some(b), Some(band.difference), band.half_width_95, band.z];
            let um = band.wavelength_um.to_string();
            csv.row([um].into_iter().chain(numbers.map(decimals)));
        }
        csv.text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(name: &str, um: &[f64], emissivity: &[f64], width: Option<f64>) -> Curve {
        Curve {
            name: name.into(),
            wavelength_um: um.into(),
            emissivity: emissivity.into(),
            half_width_95: width.map(|width| vec![width; um.len()]),
        }
    }

    #[test]
    fn differences_are_judged_by_the_errors_of_both() {
        let a = curve("a", &[8.0, 9.0, 10.0], &[0.8, 0.7, 0.9], Some(0.03));
        let b = curve("b", &[8.0, 10.0], &[0.8, 0.9], Some(0.04));
        let difference = Difference::new(&a, &b).expect("bands in common");
        let worst = difference.worst();
        assert_eq!(worst.wavelength_um, 9.0);
        assert!((worst.difference - 0.15).abs() < 1e-12);
        // 3, 4, 5: the half-width of the difference is .05.
        assert!((worst.half_width_95.expect("known") - 0.05).abs() < 1e-12);
        assert!((worst.z.expect("known") - 1.96 * 3.0).abs() < 1e-9);
        assert!((difference.bias - 0.05).abs() < 1e-12);
        assert!((difference.rms - 0.15 / 3_f64.sqrt()).abs() < 1e-12);
        // Sidak's level for three bands: 2.388 standard errors.
        assert!((difference.limit() - 2.388).abs() < 1e-3, "{}", difference.limit());
        assert!(difference.differs());
        let wide = curve("b", &[8.0, 10.0], &[0.8, 0.9], Some(0.2));
        assert!(!Difference::new(&a, &wide).expect("bands").differs());
    }

    #[test]
    fn without_errors_only_equal_curves_agree() {
        let a = curve("a", &[8.0, 9.0], &[0.8, 0.7], None);
        let near = curve("b", &[8.0, 9.0], &[0.8, 0.7 + 9e-8], None);
        assert!(!Difference::new(&a, &near).expect("bands").differs());
        let off = curve("b", &[8.0, 9.0], &[0.8, 0.701], None);
        let difference = Difference::new(&a, &off).expect("bands");
        assert!(difference.differs() && difference.farthest().is_none());
        // Errors of 0 make any difference one beyond chance.
        let exact = curve("a", &[8.0, 9.0], &[0.8, 0.7], Some(0.0));
        assert!(Difference::new(&exact, &off).expect("bands").differs());
        assert!(!Difference::new(&exact, &near).expect("bands").differs());
        let elsewhere = curve("c", &[12.0, 13.0], &[0.8, 0.7], None);
        let error = Difference::new(&a, &elsewhere).expect_err("no band in common");
        assert_eq!(error.to_string(), "c: it holds 12-13 um, and a 8-9 um: no band of it");
    }
}
