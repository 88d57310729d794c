//! Emissivity and radiance of a traced bed, band by band (Eq. 1 to 3).

use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::histogram::{Radiance, Sources};
use crate::interrupt;
use crate::output::{self, OutputError};
use crate::packings::Estimate;
use crate::radiance;
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

    /// The wavelengths, um, in whole picometres, so that 7.5 + 1.13 is 8.63 to the last digit.
    pub fn wavelengths_um(&self) -> Vec<f64> {
        let [from, to, step] =
            [self.from_um, self.to_um, self.step_um].map(|um| (um * 1e6).round() as u64);
        (from..=to).step_by(step as usize).map(|pm| pm as f64 / 1e6).collect()
    }
}

/// One band of a signature. Radiance is in W m-2 sr-1 um-1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Whether the models of all facets hold: not where `fresnel` facets bound grains that let light through.
    pub valid: bool,
    /// Emissivity of the bed towards the sensor, with its errors: a property of the bed, whatever its
    /// temperatures.
    pub emissivity: Estimate,
    /// Radiance emitted.
    pub l_emitted: f64,
    /// Radiance reflected from the sky.
    pub l_reflected: f64,
    /// Radiance that leaves the target (Eq. 1).
    pub l_target: f64,
    /// Its standard error.
    pub l_target_standard_error: f64,
    /// Radiance of a black body at the scene's temperature.
    pub l_blackbody: f64,
    /// Radiance of the sky; of one that depends on the zenith angle what a horizontal Lambertian mirror would return.
    pub l_downwelling: f64,
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
    let reflectances = packings[0].reflectances(wavelengths_um)?;
    wavelengths_um
        .par_iter()
        .zip(&reflectances)
        .map(|(&wavelength_um, reflectance)| {
            if interrupt::requested() {
                return Err(Error::Interrupted);
            }
            Ok(band(packings, wavelength_um, reflectance))
        })
        .collect()
}

fn band(packings: &[Table], wavelength_um: f64, reflectance: &[f64]) -> Band {
    let table = &packings[0];
    let kept = table.histogram.kept;
    let emissivity = Estimate::emissivity(packings, reflectance);
    let valid = table.materials.iter().all(|m| m.is_valid(wavelength_um));
    let planck = |temperature_k| radiance::planck(wavelength_um, temperature_k);
    let l_blackbody = planck(table.temperature_k);
    let sky = |zenith_deg| {
        table.sky_temperature_k.as_ref().map_or(0.0, |sky| planck(sky.temperature_k(zenith_deg)))
    };
    if kept.zeniths == 1 && !kept.order {
        return Band { valid, ..isothermal(wavelength_um, emissivity, l_blackbody, sky(0.0)) };
    }
    let zeniths = f64::from(kept.zeniths);
    let l_sky: Vec<f64> =
        (0..kept.zeniths).map(|bin| sky((f64::from(bin) + 0.5) / zeniths * 90.0)).collect();
    let own: Vec<f64> = table
        .materials
        .iter()
        .map(|m| planck(m.temperature_k.unwrap_or(table.temperature_k)))
        .collect();
    let sources = Sources { reflectance, l_blackbody: &own, l_sky: &l_sky };
    let all: Vec<Radiance> = packings.iter().map(|p| p.histogram.radiance(sources)).collect();
    let mean = |of: &dyn Fn(&Radiance) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    let l_target = Estimate::of(&all.iter().map(|radiance| radiance.l_target).collect::<Vec<_>>());
    Band {
        wavelength_um,
        valid,
        emissivity,
        l_emitted: mean(&|radiance| radiance.l_emitted),
        l_reflected: mean(&|radiance| radiance.l_reflected),
        l_target: l_target.mean,
        l_target_standard_error: l_target.standard_error,
        l_blackbody,
        l_downwelling: radiance::l_downwelling(&l_sky),
    }
}

/// A band of a scene of one temperature under an isotropic sky: a path emits with all the weight that it does not bring
/// to the sky, and reflects the sky with the rest.
fn isothermal(
    wavelength_um: f64,
    emissivity: Estimate,
    l_blackbody: f64,
    l_downwelling: f64,
) -> Band {
    let l_emitted = emissivity.mean * l_blackbody;
    let l_reflected = (1.0 - emissivity.mean) * l_downwelling;
    Band {
        wavelength_um,
        valid: true,
        emissivity,
        l_emitted,
        l_reflected,
        l_target: radiance::l_target(l_emitted, l_reflected),
        l_target_standard_error: emissivity.standard_error * (l_blackbody - l_downwelling).abs(),
        l_blackbody,
        l_downwelling,
    }
}

/// Where the models of facets do not hold: from the first to the last of bands on end, um.
pub fn not_valid_um(bands: &[Band]) -> Vec<[f64; 2]> {
    let runs = bands.chunk_by(|a, b| a.valid == b.valid).filter(|run| !run[0].valid);
    runs.map(|run| [run[0].wavelength_um, run[run.len() - 1].wavelength_um]).collect()
}

/// Headings of a signature's CSV file.
pub const COLUMNS: [&str; 13] = [
    "wavelength_um",
    "emissivity",
    "emissivity_standard_error",
    "emissivity_half_width_95",
    "emissivity_standard_error_rays",
    "emissivity_sd_packings",
    "l_emitted_w_m2_sr_um",
    "l_reflected_w_m2_sr_um",
    "l_target_w_m2_sr_um",
    "l_target_standard_error_w_m2_sr_um",
    "l_blackbody_w_m2_sr_um",
    "l_downwelling_w_m2_sr_um",
    "valid",
];

/// A signature as CSV.
pub fn csv_text(bands: &[Band]) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    for b in bands {
        let e = b.emissivity;
        let _ = write!(text, "{}", b.wavelength_um);
        for value in [e.mean, e.standard_error, e.half_width, e.rays_standard_error] {
            let _ = write!(text, ",{value:.7}");
        }
        // Of a single packing the spread is not known: the field stays empty.
        let _ = match e.spread {
            Some(spread) => write!(text, ",{spread:.7}"),
            None => write!(text, ","),
        };
        for radiance in [
            b.l_emitted,
            b.l_reflected,
            b.l_target,
            b.l_target_standard_error,
            b.l_blackbody,
            b.l_downwelling,
        ] {
            let _ = write!(text, ",{radiance:.7}");
        }
        let _ = writeln!(text, ",{}", u8::from(b.valid));
    }
    text
}

/// Writes a signature as CSV.
pub fn write_csv(bands: &[Band], path: &Path) -> Result<(), OutputError> {
    output::bytes(path, csv_text(bands).as_bytes())
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

    /// The best self-test of the chain: in an isothermal scene under an isotropic sky the geometry drops
    /// out of the retrieval.
    #[test]
    fn eq_2_and_eq_3_give_the_same_emissivity_under_any_sky() {
        let e = Estimate {
            mean: 0.763,
            standard_error: 1e-3,
            half_width: 2e-3,
            rays_standard_error: 1e-3,
            spread: None,
            trapped: 0.0,
        };
        for um in [7.5, 9.0, 14.0] {
            for sky_k in [None, Some(3.0), Some(270.0), Some(299.0), Some(320.0)] {
                let l_downwelling = sky_k.map_or(0.0, |sky_k| radiance::planck(um, sky_k));
                let b = isothermal(um, e, radiance::planck(um, 300.0), l_downwelling);
                let retrieved = radiance::emissivity(b.l_target, b.l_blackbody, b.l_downwelling);
                assert!((retrieved - 0.763).abs() < 1e-12, "{um} um, sky {sky_k:?}: {retrieved}");
            }
        }
    }
}
