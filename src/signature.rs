//! Emissivity and radiance of a traced bed, band by band (Eq. 1 to 3).

use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::histogram::{Mean, Radiance};
use crate::interrupt;
use crate::output::{self, OutputError};
use crate::packings::Estimate;
use crate::radiometry::{self, Assumed, Lit, Measured, Retrieved, Temperature};
use crate::spectrum::{Spectrum, SpectrumError, kirchhoff};
use crate::table::Table;
use crate::tally::Kept;

/// Wavelengths at which a signature is evaluated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "GridFields")]
pub struct Grid {
    from_um: f64,
    to_um: f64,
    step_um: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GridFields {
    from_um: f64,
    to_um: f64,
    step_um: f64,
}

impl TryFrom<GridFields> for Grid {
    type Error = String;
    fn try_from(grid: GridFields) -> Result<Self, String> {
        Self::new(grid.from_um, grid.to_um, grid.step_um)
    }
}

impl Grid {
    /// The paper's: 7.5 to 14 um in steps of 10 nm, 651 bands.
    pub const PAPER: Self = Self { from_um: 7.5, to_um: 14.0, step_um: 0.01 };

    /// A grid from one wavelength to another, both in it if the step divides them; um. Refused with
    /// the reason if it is empty or finer than a picometre.
    pub fn new(from_um: f64, to_um: f64, step_um: f64) -> Result<Self, String> {
        let all_finite = [from_um, to_um, step_um].iter().all(|x| x.is_finite());
        if !all_finite || from_um < 0.01 || to_um < from_um || to_um > 1e4 {
            Err(format!("{from_um}-{to_um} um is not a range of wavelengths within 0.01-10000 um"))
        } else if step_um < 1e-6 {
            Err(format!("a step of {step_um} um is below a picometre"))
        } else if (to_um - from_um) / step_um > 1e5 {
            Err(format!("a step of {step_um} um makes over 100000 bands"))
        } else {
            Ok(Self { from_um, to_um, step_um })
        }
    }

    /// The ends of the range that was asked for, um.
    pub const fn range_um(&self) -> (f64, f64) {
        (self.from_um, self.to_um)
    }

    /// The step between bands, um.
    pub const fn step_um(&self) -> f64 {
        self.step_um
    }

    /// The wavelengths, um, in whole picometres, so that 7.5 + 1.13 is 8.63 to the last digit.
    pub fn wavelengths_um(&self) -> Vec<f64> {
        let [from, to, step] =
            [self.from_um, self.to_um, self.step_um].map(|um| (um * 1e6).round() as u64);
        (from..=to).step_by(step as usize).map(|pm| pm as f64 / 1e6).collect()
    }
}

/// One band of a signature. Radiance is in W m-2 sr-1 um-1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Band {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Whether the models of all facets hold: not where `fresnel` facets bound grains that let light through.
    pub valid: bool,
    /// Emissivity of the bed towards the sensor, with its errors: a property of the bed, whatever its
    /// temperatures.
    pub emissivity: Estimate,
    /// Radiance emitted.
    pub l_emitted: Estimate,
    /// Radiance reflected from the sky.
    pub l_reflected: Estimate,
    /// Radiance that leaves the target: their sum (Eq. 1).
    pub l_target: Estimate,
    /// Radiance of a black body at the scene's temperature.
    pub l_blackbody: f64,
    /// Radiance of the sky; of one that depends on the zenith angle what a horizontal Lambertian mirror would return.
    pub l_downwelling: f64,
    /// Transmittance and path radiance between target and sensor, if there is an atmosphere.
    pub path: Option<(f64, f64)>,
}

/// Places within a bin of cosines at which a reflectance is taken.
const WITHIN_BIN: u16 = 4;

/// The reflectance of each symbol, by material and within it by cosine, at each wavelength.
pub fn reflectances(
    spectra: &[&Spectrum],
    kept: Kept,
    wavelengths_um: &[f64],
) -> Result<Vec<Vec<f64>>, SpectrumError> {
    if let (Some(&first), Some(&last)) = (wavelengths_um.first(), wavelengths_um.last()) {
        spectra.iter().try_for_each(|spectrum| spectrum.covers([first, last]))?;
    }
    let of = |spectrum: &Spectrum, um: f64, bin: u16| -> Result<f64, SpectrumError> {
        let places = f64::from(kept.cosines) * f64::from(WITHIN_BIN);
        let mut sum = 0.0;
        for place in 0..WITHIN_BIN {
            let cosine = (f64::from(bin * WITHIN_BIN + place) + 0.5) / places;
            sum += spectrum.reflectance_at(um, cosine)?;
        }
        Ok(sum / f64::from(WITHIN_BIN))
    };
    wavelengths_um
        .iter()
        .map(|&um| {
            let mut all = Vec::with_capacity(kept.symbols(spectra.len()));
            for spectrum in spectra {
                if spectrum.is_angular() && kept.cosines > 1 {
                    for bin in 0..kept.cosines {
                        all.push(of(spectrum, um, bin)?);
                    }
                } else {
                    let reflectance = kirchhoff(spectrum.emissivity(um)?);
                    all.resize(all.len() + usize::from(kept.cosines), reflectance);
                }
            }
            Ok(all)
        })
        .collect()
}

/// Evaluates the tables of a recipe's packings with the spectra and temperatures of the first.
///
/// # Errors
/// A spectrum that does not cover a wavelength.
///
/// # Panics
/// Without a table.
pub fn evaluate(packings: &[Table], wavelengths_um: &[f64]) -> Result<Vec<Band>, Error> {
    let lit = packings[0].lit(wavelengths_um)?;
    lit.par_iter()
        .map(|lit| {
            if interrupt::requested() {
                return Err(Error::Interrupted);
            }
            Ok(band(packings, lit))
        })
        .collect()
}

fn band(packings: &[Table], lit: &Lit) -> Band {
    let seen: Vec<(Mean, Radiance)> = packings.iter().map(|p| lit.seen(&p.histogram)).collect();
    let of = |part: fn(&(Mean, Radiance)) -> Mean| {
        Estimate::of(&seen.iter().map(part).collect::<Vec<_>>())
    };
    Band {
        wavelength_um: lit.wavelength_um,
        valid: packings[0].materials.iter().all(|m| m.is_valid(lit.wavelength_um)),
        emissivity: of(|(emissivity, _)| *emissivity),
        l_emitted: of(|(_, radiance)| radiance.l_emitted),
        l_reflected: of(|(_, radiance)| radiance.l_reflected),
        l_target: of(|(_, radiance)| radiance.l_target),
        l_blackbody: lit.l_blackbody,
        l_downwelling: lit.l_downwelling,
        path: lit.path,
    }
}

impl Band {
    /// The radiance as a sensor would measure it, without any error of its own, compensated for the atmosphere.
    pub fn measured(&self) -> Measured {
        let Estimate { mean, standard_error, .. } = self.l_sensor();
        let l = [mean, standard_error];
        Measured::at_sensor(self.wavelength_um, l, self.l_downwelling, self.path)
    }

    /// Radiance that reaches the sensor.
    pub fn l_sensor(&self) -> Estimate {
        self.path.map_or(self.l_target, |(transmittance, l_path)| Estimate {
            mean: radiometry::at_sensor(self.l_target.mean, transmittance, l_path),
            standard_error: transmittance * self.l_target.standard_error,
            half_width: transmittance * self.l_target.half_width,
            rays_standard_error: transmittance * self.l_target.rays_standard_error,
            spread: self.l_target.spread.map(|spread| transmittance * spread),
            trapped: transmittance * self.l_target.trapped,
        })
    }

    /// Emissivity by Eq. 3, of the radiance that leaves the target under a cold black sky, and its standard error for
    /// that of the temperature, K.
    pub fn emissivity_eq3(&self, temperature: Temperature) -> [f64; 2] {
        let l_blackbody = radiometry::planck(self.wavelength_um, temperature.k);
        let emissivity = radiometry::emissivity(self.l_emitted.mean, l_blackbody, 0.0);
        let slope = radiometry::planck_derivative(self.wavelength_um, temperature.k);
        let errors = [self.l_emitted.standard_error, slope * temperature.error_k, 0.0];
        [emissivity, radiometry::emissivity_error(emissivity, l_blackbody, 0.0, errors)]
    }
}

/// What Eq. 2 gives of each band for a target that is taken to have one temperature.
pub fn retrieve(bands: &[Band], temperature: Temperature, assumed: Assumed) -> Vec<Retrieved> {
    bands.iter().map(|band| Retrieved::new(&band.measured(), temperature, assumed)).collect()
}

/// Where the models of facets do not hold: from the first to the last of bands on end, um.
pub fn not_valid_um(bands: &[Band]) -> Vec<[f64; 2]> {
    let runs = bands.chunk_by(|a, b| a.valid == b.valid).filter(|run| !run[0].valid);
    runs.map(|run| [run[0].wavelength_um, run[run.len() - 1].wavelength_um]).collect()
}

/// Headings of a signature's CSV file.
pub const COLUMNS: [&str; 24] = [
    "wavelength_um",
    "emissivity",
    "emissivity_standard_error",
    "emissivity_half_width_95",
    "emissivity_standard_error_rays",
    "emissivity_sd_packings",
    "l_emitted_w_m2_sr_um",
    "l_reflected_w_m2_sr_um",
    "l_target_w_m2_sr_um",
    "l_emitted_standard_error_w_m2_sr_um",
    "l_reflected_standard_error_w_m2_sr_um",
    "l_target_standard_error_w_m2_sr_um",
    "l_blackbody_w_m2_sr_um",
    "l_downwelling_w_m2_sr_um",
    "l_sensor_w_m2_sr_um",
    "l_sensor_standard_error_w_m2_sr_um",
    "brightness_temperature_k",
    "brightness_temperature_standard_error_k",
    "amplification",
    "emissivity_eq2",
    "emissivity_eq2_standard_error",
    "emissivity_eq3",
    "emissivity_eq3_standard_error",
    "valid",
];

/// A signature as CSV, with what Eq. 2 and 3 give of it for a target of that temperature. What is not known, and bands
/// that are masked, have empty fields.
pub fn csv_text(bands: &[Band], temperature: Temperature, assumed: Assumed) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    for (b, retrieved) in bands.iter().zip(retrieve(bands, temperature, assumed)) {
        let e = b.emissivity;
        let both = |of: Estimate| [Some(of.mean), Some(of.standard_error)];
        let [sensor, sensor_error] = b.path.map_or([None; 2], |_| both(b.l_sensor()));
        let brightness = b.measured().brightness_temperature();
        let eq3 = b.emissivity_eq3(temperature);
        let _ = write!(text, "{}", b.wavelength_um);
        for value in [
            Some(e.mean),
            Some(e.standard_error),
            Some(e.half_width),
            Some(e.rays_standard_error),
            // Of a single packing the spread is not known.
            e.spread,
            Some(b.l_emitted.mean),
            Some(b.l_reflected.mean),
            Some(b.l_target.mean),
            Some(b.l_emitted.standard_error),
            Some(b.l_reflected.standard_error),
            Some(b.l_target.standard_error),
            Some(b.l_blackbody),
            Some(b.l_downwelling),
            sensor,
            sensor_error,
            brightness.map(|t| t.k),
            brightness.map(|t| t.error_k),
            Some(retrieved.amplification),
            retrieved.emissivity.map(|[e, _]| e),
            retrieved.emissivity.map(|[_, error]| error),
            Some(eq3[0]),
            Some(eq3[1]),
        ] {
            let _ = match value {
                Some(value) => write!(text, ",{value:.7}"),
                None => write!(text, ","),
            };
        }
        let _ = writeln!(text, ",{}", u8::from(b.valid));
    }
    text
}

/// Writes a signature as [CSV](csv_text).
pub fn write_csv(
    bands: &[Band],
    temperature: Temperature,
    assumed: Assumed,
    path: &Path,
) -> Result<(), OutputError> {
    output::bytes(path, csv_text(bands, temperature, assumed).as_bytes())
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
    fn grids_that_make_no_sense_are_refused() {
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
