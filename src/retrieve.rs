//! Emissivity from measured radiance: a spectrum, or an image of them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::cube::{Cube, ImageHeader};
use crate::error::Error;
use crate::interrupt;
use crate::output;
use crate::radiometry::{
    Assumed, Atmosphere, Columns, Measured, Method, Retrieved, SkyTable, Temperature,
    l_downwelling, masked_in_words, masked_um, planck, separate,
};
use crate::tally::ZENITHS;

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

/// What was retrieved from an image. Numbers that are not known are not numbers.
#[derive(Debug, Clone)]
pub struct Image {
    /// Emissivity.
    pub emissivity: Cube,
    /// Its standard error.
    pub standard_error: Cube,
    /// Brightness temperature, K.
    pub brightness_temperature_k: Cube,
    /// The target's temperature and its standard error, K, pixel by pixel.
    pub temperature_k: Vec<[f32; 2]>,
    /// What was masked, and what was refused, in words.
    pub statement: String,
}

/// The standard error of an image's radiance.
#[derive(Debug, Clone, PartialEq)]
pub enum ImageError {
    /// The same for all, W m-2 sr-1 um-1.
    One(f64),
    /// An image of its own.
    Cube(Cube),
}

/// One pixel.
struct Pixel {
    temperature: Result<Temperature, String>,
    brightness: Vec<Option<f64>>,
    retrieved: Vec<Retrieved>,
}

/// Retrieves from a cube of radiance. Bands and pixels without a number have none in the result.
pub fn image(cube: &Cube, error: &ImageError, known: &Known) -> Result<Image, Error> {
    let mut order: Vec<usize> = (0..cube.wavelengths_um.len()).collect();
    order.sort_by(|&a, &b| cube.wavelengths_um[a].total_cmp(&cube.wavelengths_um[b]));
    let um: Vec<f64> = order.iter().map(|&band| cube.wavelengths_um[band]).collect();
    let around = known.around(&um, None)?;
    let pixels: Vec<Pixel> = (0..cube.lines * cube.samples)
        .into_par_iter()
        .map(|at| {
            if interrupt::requested() {
                return Err(Error::Interrupted);
            }
            let (line, sample) = (at / cube.samples, at % cube.samples);
            let l_error = match error {
                ImageError::One(error) => vec![*error as f32; um.len()],
                ImageError::Cube(errors) => errors.spectrum(line, sample),
            };
            let l = cube.spectrum(line, sample);
            let measured: Vec<Measured> = (0..um.len())
                .filter(|&i| l[order[i]].is_finite())
                .map(|i| {
                    let measured = [l[order[i]], l_error[order[i]]].map(f64::from);
                    Measured::at_sensor(um[i], measured, around[i].l_downwelling, around[i].path)
                })
                .collect();
            let temperature = match measured.is_empty() {
                true => Err("pixels without radiance".to_owned()),
                false => known.temperature(&measured).map_err(|error| error.to_string()),
            };
            let retrieved =
                temperature.as_ref().map_or(Vec::new(), |&t| known.retrieve(&measured, t));
            let brightness =
                measured.iter().map(|m| m.brightness_temperature().map(|t| t.k)).collect();
            let mut pixel = Pixel { temperature, brightness, retrieved };
            pixel.spread(&um, &measured);
            Ok(pixel)
        })
        .collect::<Result<_, Error>>()?;
    let fill = |of: &dyn Fn(&Pixel, usize) -> Option<f64>| {
        let mut filled = Cube::new(cube.lines, cube.samples, cube.wavelengths_um.clone());
        for (at, pixel) in pixels.iter().enumerate() {
            for (i, &band) in order.iter().enumerate() {
                let place = filled.place(band, at / cube.samples, at % cube.samples);
                filled.data[place] = of(pixel, i).map_or(f32::NAN, |value| value as f32);
            }
        }
        filled
    };
    Ok(Image {
        emissivity: fill(&|pixel, i| Some(pixel.retrieved.get(i)?.emissivity?[0])),
        standard_error: fill(&|pixel, i| Some(pixel.retrieved.get(i)?.emissivity?[1])),
        brightness_temperature_k: fill(&|pixel, i| pixel.brightness[i]),
        temperature_k: pixels
            .iter()
            .map(|pixel| match &pixel.temperature {
                Ok(t) => [t.k as f32, t.error_k as f32],
                Err(_) => [f32::NAN; 2],
            })
            .collect(),
        statement: statement(&pixels, known),
    })
}

impl Pixel {
    /// Makes room for the bands in which nothing was measured.
    fn spread(&mut self, um: &[f64], measured: &[Measured]) {
        let place = |um: f64| measured.iter().position(|m| m.wavelength_um == um);
        let none = |um| Retrieved { wavelength_um: um, amplification: f64::NAN, emissivity: None };
        self.brightness = um.iter().map(|&um| self.brightness[place(um)?]).collect();
        if !self.retrieved.is_empty() {
            let of = |&um: &f64| place(um).map_or_else(|| none(um), |i| self.retrieved[i]);
            self.retrieved = um.iter().map(of).collect();
        }
    }
}

/// What of an image was masked and refused.
fn statement(pixels: &[Pixel], known: &Known) -> String {
    let mut text = String::new();
    let told: Vec<&Pixel> = pixels.iter().filter(|pixel| pixel.temperature.is_ok()).collect();
    let mut reasons: Vec<(&String, usize)> = Vec::new();
    for reason in pixels.iter().filter_map(|pixel| pixel.temperature.as_ref().err()) {
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, number)) => *number += 1,
            None => reasons.push((reason, 1)),
        }
    }
    for (reason, number) in reasons {
        let _ = writeln!(text, "{number} of {} pixels have no emissivity: {reason}", pixels.len());
    }
    let Some(first) = told.first() else { return text };
    let everywhere: Vec<Retrieved> = (0..first.retrieved.len())
        .map(|i| {
            let any = told.iter().find(|pixel| pixel.retrieved[i].emissivity.is_some());
            any.unwrap_or(first).retrieved[i]
        })
        .collect();
    let limit = known.assumed.amplification_limit;
    let masked = masked_in_words(&masked_um(&everywhere), limit);
    let all = masked.is_some();
    text += &masked.map_or(String::new(), |words| words + "\n");
    let bands = everywhere.iter().filter(|band| band.emissivity.is_some()).count();
    let empty = |pixel: &&Pixel| pixel.retrieved.iter().filter(|r| r.emissivity.is_none()).count();
    let elsewhere: usize = told.iter().map(|p| empty(p) - (everywhere.len() - bands)).sum();
    if elsewhere > 0 {
        let share = 100.0 * elsewhere as f64 / (bands * told.len()) as f64;
        let _ = writeln!(
            text,
            "of the other bands {share:.2} % are masked or without radiance, pixel by pixel"
        );
    } else if !all {
        let _ = writeln!(text, "no band is masked: none amplifies errors more than {limit} times");
    }
    let values = || told.iter().flat_map(|p| &p.retrieved).filter_map(|r| r.emissivity);
    let outside = values().filter(is_outside).count();
    if outside > 0 {
        let share = 100.0 * outside as f64 / values().count() as f64;
        let _ = writeln!(
            text,
            "warning: {share:.2} % of the emissivities are outside 0 to 1 by over three standard errors: \
             temperature, sky or radiance are not what they are taken for"
        );
    }
    text
}

impl Image {
    /// Writes the emissivity to `path` and, with names that go on from its, the standard error, the brightness
    /// temperature and the target's temperature: each an ENVI image.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let beside = |what: &str| -> PathBuf {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            path.with_file_name(format!("{stem}_{what}.img"))
        };
        self.emissivity.write(path, "emissivity")?;
        self.standard_error.write(&beside("standard_error"), "standard error of the emissivity")?;
        self.brightness_temperature_k
            .write(&beside("brightness_temperature"), "brightness temperature, K")?;
        let path = beside("temperature");
        let bands = [0, 1].map(|part| self.temperature_k.iter().map(move |t| t[part]));
        let data: Vec<u8> = bands.into_iter().flatten().flat_map(f32::to_le_bytes).collect();
        let header = ImageHeader {
            quantity: "temperature of the target, K",
            lines: self.emissivity.lines,
            samples: self.emissivity.samples,
            wavelengths_um: &[],
            band_names: &["temperature".into(), "standard error".into()],
        };
        output::bytes(&path, &data)?;
        Ok(output::bytes(&path.with_extension("hdr"), header.text().as_bytes())?)
    }
}
