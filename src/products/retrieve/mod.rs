//! Emissivity from measured radiance: a spectrum, or an image of them.

mod image;

use std::fmt::Write as _;
use std::path::Path;

use crate::histogram::tally::ZENITHS;
use crate::radiometry::{
    Assumed, Atmosphere, Columns, Measured, Method, Retrieved, SkyTable, Temperature,
    l_downwelling, masked_in_words, masked_um, planck, separate,
};
use crate::support::error::Error;

pub use image::{Image, ImageError, image};

/// The sky over a measured target.
#[derive(Debug, Clone, PartialEq)]
pub enum Sky {
    /// As the file of radiances has it; cold and black where it has none.
    OfFile,
    /// Grey, of this temperature, K.
    Grey(f64),
    /// From a file.
    Table(SkyTable),
}

/// How the target's temperature is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// It is given.
    Given(Temperature),
    /// From the radiance itself.
    By(Method),
}

/// What is known besides the radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// The sky.
    pub sky: Sky,
    /// The atmosphere before the sensor.
    pub atmosphere: Option<Atmosphere>,
    /// The target's temperature.
    pub target: Target,
    /// How well the sky is known, and when a band tells too little.
    pub assumed: Assumed,
}

/// A band's radiance of the sky, as an isotropic one would have it, and what lies before the sensor.
#[derive(Debug, Clone, Copy)]
struct Around {
    l_downwelling: f64,
    path: Option<(f64, f64)>,
}

impl Known {
    /// For each wavelength; `own` is the sky that the file of radiances has.
    fn around(&self, wavelengths_um: &[f64], own: Option<&[f64]>) -> Result<Vec<Around>, Error> {
        let of = |(i, &um): (usize, &f64)| {
            let l_downwelling = match &self.sky {
                Sky::OfFile => own.map_or(0.0, |l| l[i]),
                Sky::Grey(kelvin) => planck(um, *kelvin),
                Sky::Table(sky) => {
                    let bins = if sky.is_by_zenith() { ZENITHS } else { 1 };
                    let zenith = |bin| (f64::from(bin) + 0.5) / f64::from(bins) * 90.0;
                    let l: Result<Vec<f64>, _> =
                        (0..bins).map(|bin| sky.l_sky(um, zenith(bin))).collect();
                    l_downwelling(&l?)
                }
            };
            let path = self.atmosphere.as_ref().map(|a| a.at(um)).transpose()?;
            Ok(Around { l_downwelling, path })
        };
        wavelengths_um.iter().enumerate().map(of).collect()
    }

    fn temperature(&self, measured: &[Measured]) -> Result<Temperature, Error> {
        Ok(match self.target {
            Target::Given(temperature) => temperature,
            Target::By(method) => separate(method, measured, self.assumed)?,
        })
    }

    fn retrieve(&self, measured: &[Measured], temperature: Temperature) -> Vec<Retrieved> {
        measured.iter().map(|m| Retrieved::new(m, temperature, self.assumed)).collect()
    }
}

/// What was retrieved from one spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// The radiance, by ascending wavelength.
    pub measured: Vec<Measured>,
    /// The target's temperature.
    pub temperature: Temperature,
    /// The emissivity in each band.
    pub retrieved: Vec<Retrieved>,
}

/// Retrieves from a CSV file with the columns `wavelength_um` and `radiance_w_m2_sr_um`, or as soilsig names the
/// radiance: `l_target_...`, and `l_sensor_...` before an atmosphere. The standard error is in a column
/// `..._standard_error_w_m2_sr_um`, or the one given for all bands.
pub fn spectrum(path: &Path, error: Option<f64>, known: &Known) -> Result<Spectrum, Error> {
    let columns = Columns::read(path)?;
    let (um, rows) = columns.ascending_um()?;
    let ours = if known.atmosphere.is_some() { "l_sensor" } else { "l_target" };
    let mut stem = "radiance";
    if columns.radiance(stem)?.is_none() && columns.radiance(ours)?.is_some() {
        stem = ours;
    }
    let l = columns.measured_radiance(stem)?;
    let of_file = columns.radiance(&format!("{stem}_standard_error"))?;
    let l_error = |row: usize| error.or(of_file.as_ref().map(|e| e[row])).unwrap_or(0.0);
    let own = columns.radiance("l_downwelling")?;
    let own: Option<Vec<f64>> = own.map(|l| rows.iter().map(|&row| l[row]).collect());
    let around = known.around(&um, own.as_deref())?;
    let measured: Vec<Measured> = rows
        .iter()
        .zip(um.iter().zip(&around))
        .map(|(&row, (&um, a))| {
            Measured::at_sensor(um, [l[row], l_error(row)], a.l_downwelling, a.path)
        })
        .collect();
    let temperature = known.temperature(&measured)?;
    let retrieved = known.retrieve(&measured, temperature);
    Ok(Spectrum { measured, temperature, retrieved })
}

impl Spectrum {
    /// As CSV; masked bands have empty fields.
    pub fn csv_text(&self) -> String {
        let mut text = String::from(
            "wavelength_um,l_target_w_m2_sr_um,l_target_standard_error_w_m2_sr_um,\
             l_downwelling_w_m2_sr_um,l_blackbody_w_m2_sr_um,brightness_temperature_k,\
             brightness_temperature_standard_error_k,amplification,emissivity,emissivity_standard_error\n",
        );
        for (m, r) in self.measured.iter().zip(&self.retrieved) {
            let brightness = m.brightness_temperature();
            let _ = write!(text, "{}", m.wavelength_um);
            for value in [
                Some(m.l_target).filter(|l| l.is_finite()),
                Some(m.l_target_error).filter(|l| l.is_finite()),
                Some(m.l_downwelling),
                Some(planck(m.wavelength_um, self.temperature.k)),
                brightness.map(|t| t.k),
                brightness.map(|t| t.error_k),
                Some(r.amplification),
                r.emissivity.map(|[e, _]| e),
                r.emissivity.map(|[_, error]| error),
            ] {
                let _ = match value {
                    Some(value) => write!(text, ",{value:.7}"),
                    None => write!(text, ","),
                };
            }
            text.push('\n');
        }
        text
    }

    /// The temperature, what is masked and what cannot be.
    pub fn in_words(&self, known: &Known) -> String {
        let how = match known.target {
            Target::Given(_) => "as given".to_owned(),
            Target::By(method) => format!("by {}", method.name()),
        };
        let Temperature { k, error_k } = self.temperature;
        let mut text = format!("target at {k:.3} +- {error_k:.3} K, {how}\n");
        let limit = known.assumed.amplification_limit;
        let masked = masked_in_words(&masked_um(&self.retrieved), limit);
        text += &masked
            .unwrap_or(format!("no band is masked: none amplifies errors more than {limit} times"));
        text.push('\n');
        let outside = self.retrieved.iter().filter_map(|r| r.emissivity).filter(is_outside).count();
        if outside > 0 {
            let _ = writeln!(
                text,
                "warning: {outside} bands give an emissivity outside 0 to 1 by over three standard errors: \
                 temperature, sky or radiance are not what they are taken for"
            );
        }
        if let Some(elsewhere) = self.other_temperature(known) {
            let _ = writeln!(
                text,
                "at 7.36 um, where quartz is black, the target looks {:.2} +- {:.2} K warm: if it is quartz, the \
                 temperature given is wrong",
                elsewhere.k, elsewhere.error_k
            );
        }
        text
    }

    /// The target's temperature by its radiance where quartz is black, if it contradicts the one that was given (95 %).
    fn other_temperature(&self, known: &Known) -> Option<Temperature> {
        let Target::Given(given) = known.target else { return None };
        let found = separate(Method::Christiansen, &self.measured, known.assumed).ok()?;
        let apart = (found.k - given.k).abs();
        (apart > 2.0 * found.error_k.hypot(given.error_k)).then_some(found)
    }
}

/// Beyond what any emissivity can be, by more than noise makes and more than rounding in the file does.
fn is_outside([e, error]: &[f64; 2]) -> bool {
    let room = 3.0 * error + 1e-5;
    *e < -room || *e > 1.0 + room
}
