//! Emissivity from measured radiance: of a spectrum, or of an image.

mod image;

use std::fmt::Write as _;
use std::path::Path;

use crate::histogram::kept::ZENITHS;
use crate::radiometry::{
    Assumed, Atmosphere, Columns, Measured, Method, Retrieved, SkyTable, Temperature,
    l_downwelling, masked_in_words, masked_um, planck, separate,
};
use crate::support::csv::{Csv, decimals, radiance};
use crate::support::error::Error;
use crate::support::math;

pub use image::{Image, RadianceError, image};

/// The sky over a measured target.
#[derive(Debug, Clone, PartialEq)]
pub enum Sky {
    /// The sky in the file of radiances; cold and black if the file has none.
    OfFile,
    /// A grey sky of this temperature, K.
    Grey(f64),
    /// From a file of its own.
    Table(SkyTable),
}

/// Where the target's temperature comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// It is given.
    Given(Temperature),
    /// It is found from the radiance.
    By(Method),
}

/// What a retrieval uses besides the radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// The sky.
    pub sky: Sky,
    /// The atmosphere between target and sensor.
    pub atmosphere: Option<Atmosphere>,
    /// The target's temperature.
    pub target: Target,
    /// The error of the sky's radiance, and the amplification that masks a band.
    pub assumed: Assumed,
}

/// The surroundings in one band.
#[derive(Debug, Clone, Copy)]
struct Around {
    /// Radiance of an isotropic sky with the same irradiance, W m-2 sr-1 um-1.
    l_downwelling: f64,
    /// Transmittance and path radiance of the atmosphere.
    path: Option<(f64, f64)>,
}

impl Known {
    /// The surroundings at each wavelength. `own` is the sky in the file of radiances.
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

    fn retrieve(&self, measured: &Measured, temperature: Temperature) -> Retrieved {
        Retrieved::new(measured, temperature, self.assumed)
    }
}

/// The masked bands in a sentence.
fn masked(bands: &[Retrieved], known: &Known) -> String {
    let limit = known.assumed.amplification_limit;
    masked_in_words(&masked_um(bands), limit)
        .unwrap_or(format!("no band is masked: none amplifies errors more than {limit} times"))
        + "\n"
}

/// Beyond what any emissivity can be, by more than noise and the rounding of files.
fn is_outside([e, error]: &[f64; 2]) -> bool {
    let margin = 3.0 * error + 1e-5;
    *e < -margin || *e > 1.0 + margin
}

/// The result of one spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// The radiance, by ascending wavelength.
    pub measured: Vec<Measured>,
    /// The target's temperature.
    pub temperature: Temperature,
    /// The emissivity in each band.
    pub retrieved: Vec<Retrieved>,
    /// Whether the radiance comes with a standard error.
    pub has_error: bool,
}

/// Retrieves from a CSV file with the columns `wavelength_um` and `radiance_w_m2_sr_um`. The
/// radiance may also be named as in soilsig's results: `l_target_...`, or `l_sensor_...` before an
/// atmosphere. Its standard error is `error`, else a column `..._standard_error_w_m2_sr_um`.
///
/// # Errors
/// A file or column is missing or wrong; sky or atmosphere do not hold the wavelengths; the method
/// finds no temperature.
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
    let has_error = error.is_some() || of_file.is_some();
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
    let retrieved = measured.iter().map(|m| known.retrieve(m, temperature)).collect();
    Ok(Spectrum { measured, temperature, retrieved, has_error })
}

/// Said of a radiance whose standard error is not known.
const NO_ERROR: &str = "the radiance comes without a standard error, so those of the emissivity \
     leave its noise out: give it by --radiance-error\n";

/// Headings of the CSV file.
const COLUMNS: [&str; 10] = [
    "wavelength_um",
    "l_target_w_m2_sr_um",
    "l_target_standard_error_w_m2_sr_um",
    "l_downwelling_w_m2_sr_um",
    "l_blackbody_w_m2_sr_um",
    "brightness_temperature_k",
    "brightness_temperature_standard_error_k",
    "amplification",
    "emissivity",
    "emissivity_standard_error",
];

impl Spectrum {
    /// The result as CSV. Fields of masked bands are empty.
    pub fn csv_text(&self) -> String {
        let mut csv = Csv::new(&COLUMNS);
        for (m, r) in self.measured.iter().zip(&self.retrieved) {
            let brightness = m.brightness_temperature();
            let l_blackbody = planck(m.wavelength_um, self.temperature.k);
            let radiances = [m.l_target, m.l_target_error, m.l_downwelling, l_blackbody]
                .map(|l| radiance(Some(l).filter(|l| l.is_finite()), l_blackbody));
            let numbers = [
                brightness.map(|t| t.k),
                brightness.map(|t| t.error_k),
                Some(r.amplification),
                r.emissivity.map(|[e, _]| e),
                r.emissivity.map(|[_, error]| error),
            ];
            let um = [m.wavelength_um.to_string()];
            csv.row(um.into_iter().chain(radiances).chain(numbers.map(decimals)));
        }
        csv.text()
    }

    /// The temperature, the masked bands and warnings, for the terminal.
    pub fn in_words(&self, known: &Known) -> String {
        let how = match known.target {
            Target::Given(_) => "as given".to_owned(),
            Target::By(method) => format!("by {}", method.name()),
        };
        let Temperature { k, error_k } = self.temperature;
        let mut text = format!("target at {k:.3} +- {error_k:.3} K, {how}\n");
        text += &masked(&self.retrieved, known);
        if !self.has_error {
            text += NO_ERROR;
        }
        let outside = self.retrieved.iter().filter_map(|r| r.emissivity).filter(is_outside).count();
        if outside > 0 {
            let _ = writeln!(
                text,
                "warning: {outside} bands give an emissivity outside 0 to 1 by over three standard \
                 errors: temperature, sky or radiance are wrong"
            );
        }
        if let Some(Temperature { k, error_k }) = self.other_temperature(known) {
            let _ = writeln!(
                text,
                "warning: at 7.36 um, where the emissivity of quartz is nearly 1, the target \
                 looks {k:.2} +- {error_k:.2} K warm: if it holds quartz, the given temperature is \
                 wrong"
            );
        }
        text
    }

    /// The temperature from the radiance where the emissivity of quartz is nearly 1, if it contradicts the given one
    /// (95 %).
    fn other_temperature(&self, known: &Known) -> Option<Temperature> {
        let Target::Given(given) = known.target else { return None };
        let found = separate(Method::Christiansen, &self.measured, known.assumed).ok()?;
        let apart = (found.k - given.k).abs();
        (apart > 2.0 * math::hypot(found.error_k, given.error_k)).then_some(found)
    }
}
