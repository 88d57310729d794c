//! The same for every pixel of an image.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{Known, is_outside};
use crate::products::cube::{Cube, ImageHeader};
use crate::radiometry::{Measured, Retrieved, Temperature, masked_in_words, masked_um};
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;

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
pub fn image(
    cube: &Cube,
    error: &ImageError,
    known: &Known,
    monitor: &dyn Monitor,
) -> Result<Image, Error> {
    let mut order: Vec<usize> = (0..cube.wavelengths_um.len()).collect();
    order.sort_by(|&a, &b| cube.wavelengths_um[a].total_cmp(&cube.wavelengths_um[b]));
    let um: Vec<f64> = order.iter().map(|&band| cube.wavelengths_um[band]).collect();
    let around = known.around(&um, None)?;
    let pixels: Vec<Pixel> = (0..cube.lines * cube.samples)
        .into_par_iter()
        .map(|at| {
            monitor.check()?;
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
            let temperature = if measured.is_empty() {
                Err("there is no radiance".to_owned())
            } else {
                known.temperature(&measured).map_err(|error| error.to_string())
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

/// Where what belongs to an image of emissivity goes: its standard error, the brightness temperature, the target's.
fn beside(path: &Path) -> [PathBuf; 3] {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    ["standard_error", "brightness_temperature", "temperature"]
        .map(|what| path.with_file_name(format!("{stem}_{what}.img")))
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
    /// The files that [`Image::write`] writes.
    pub fn files(path: &Path) -> Vec<PathBuf> {
        let images = [path.to_owned()].into_iter().chain(beside(path));
        images.flat_map(|image| [image.with_extension("hdr"), image]).collect()
    }

    /// Writes the emissivity to `path` and, with names that go on from its, the standard error, the brightness
    /// temperature and the target's temperature: each an ENVI image.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let [standard_error, brightness, of_temperature] = beside(path);
        self.emissivity.write(path, "emissivity")?;
        self.standard_error.write(&standard_error, "standard error of the emissivity")?;
        self.brightness_temperature_k.write(&brightness, "brightness temperature, K")?;
        let path = of_temperature;
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
