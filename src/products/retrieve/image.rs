//! Emissivity from an image of measured radiance, pixel by pixel.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{Known, NO_ERROR, is_outside, masked};
use crate::products::cube::Cube;
use crate::radiometry::{Measured, Retrieved, Temperature};
use crate::support::envi::{self, Contents, Kind};
use crate::support::error::Error;
use crate::support::linear::span;
use crate::support::monitor::Monitor;

/// No soil has an emissivity below it in all bands.
const LEAST_LIKELY: f64 = 0.05;

/// Results of an image. Unknown numbers are NaN.
#[derive(Debug, Clone)]
pub struct Image {
    /// Emissivity.
    pub emissivity: Cube,
    /// Standard error of the emissivity.
    pub standard_error: Cube,
    /// Brightness temperature, K.
    pub brightness_temperature_k: Cube,
    /// The target's temperature and its standard error in every pixel, K.
    pub temperature_k: Vec<[f32; 2]>,
    /// Masked bands, pixels without a result and warnings, as sentences.
    pub statement: String,
}

/// The standard error of an image's radiance.
#[derive(Debug, Clone, PartialEq)]
pub enum RadianceError {
    /// It is not known, and left out.
    Unknown,
    /// The same everywhere, W m-2 sr-1 um-1.
    One(f64),
    /// An image of standard errors.
    Cube(Cube),
}

/// The target's temperature in a pixel, or why it is unknown.
type Found = Result<Temperature, String>;

/// Retrieves from an image of radiance. Bands and pixels without radiance stay NaN.
///
/// # Errors
/// Sky or atmosphere do not hold the wavelengths; the user stops the work.
pub fn image(
    cube: &Cube,
    error: &RadianceError,
    known: &Known,
    monitor: &dyn Monitor,
) -> Result<Image, Error> {
    let mut order: Vec<usize> = (0..cube.wavelengths_um.len()).collect();
    order.sort_by(|&a, &b| cube.wavelengths_um[a].total_cmp(&cube.wavelengths_um[b]));
    let um: Vec<f64> = order.iter().map(|&band| cube.wavelengths_um[band]).collect();
    let around = known.around(&um, None)?;
    // Emissivity, its standard error and the brightness temperature by band.
    let pixel = |at: usize| -> Result<(Found, Vec<[f32; 3]>), Error> {
        monitor.check()?;
        let (line, sample) = (at / cube.samples, at % cube.samples);
        let l = cube.spectrum(line, sample);
        let l_error = match error {
            RadianceError::Unknown => vec![0.0; um.len()],
            RadianceError::One(error) => vec![*error as f32; um.len()],
            RadianceError::Cube(errors) => errors.spectrum(line, sample),
        };
        let seen = (0..um.len()).filter(|&i| l[order[i]].is_finite());
        let measured: Vec<Measured> = seen
            .clone()
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
        let mut bands = vec![[f32::NAN; 3]; um.len()];
        for (i, m) in seen.zip(&measured) {
            let retrieved =
                temperature.as_ref().ok().and_then(|&t| known.retrieve(m, t).emissivity);
            let [e, e_error] = retrieved.unwrap_or([f64::NAN; 2]);
            let brightness_k = m.brightness_temperature().map_or(f64::NAN, |t| t.k);
            bands[order[i]] = [e, e_error, brightness_k].map(|value| value as f32);
        }
        Ok((temperature, bands))
    };
    let (found, spectra): (Vec<Found>, Vec<Vec<[f32; 3]>>) = (0..cube.lines * cube.samples)
        .into_par_iter()
        .map(pixel)
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .unzip();
    let [emissivity, standard_error, brightness_temperature_k] = [0, 1, 2].map(|part| {
        let mut filled = Cube::new(cube.lines, cube.samples, cube.wavelengths_um.clone());
        filled.is_bad.clone_from(&cube.is_bad);
        for (at, spectrum) in spectra.iter().enumerate() {
            let spectrum: Vec<f32> = spectrum.iter().map(|values| values[part]).collect();
            filled.set_spectrum(at / cube.samples, at % cube.samples, &spectrum);
        }
        filled
    });
    let in_kelvin =
        |found: &Found| found.as_ref().map_or([f32::NAN; 2], |t| [t.k as f32, t.error_k as f32]);
    let mut statement = left_out(cube, &order, &um);
    statement += &told(&found, &spectra, cube, &order, known);
    if *error == RadianceError::Unknown {
        statement += NO_ERROR;
    }
    Ok(Image {
        emissivity,
        standard_error,
        brightness_temperature_k,
        temperature_k: found.iter().map(in_kelvin).collect(),
        statement,
    })
}

/// Whether any pixel has radiance in a band.
fn is_seen(cube: &Cube, band: usize) -> bool {
    let pixels = cube.lines * cube.samples;
    cube.data[band * pixels..][..pixels].iter().any(|l| l.is_finite())
}

/// Bands that cannot have a result, and why. `order` has the bands by wavelength `um`.
fn left_out(cube: &Cube, order: &[usize], um: &[f64]) -> String {
    let runs = |is: &dyn Fn(usize) -> bool| {
        let bands: Vec<(bool, f64)> = order.iter().zip(um).map(|(&b, &um)| (is(b), um)).collect();
        let runs = bands.chunk_by(|a, b| a.0 == b.0).filter(|run| run[0].0);
        runs.map(|run| span([run[0].1, run[run.len() - 1].1])).collect::<Vec<_>>().join(", ")
    };
    let mut text = String::new();
    let bad = runs(&|band| cube.is_bad[band]);
    if !bad.is_empty() {
        let _ =
            writeln!(text, "{bad} um is left out: the header's list of bad bands (bbl) says so");
    }
    let empty = runs(&|band| !cube.is_bad[band] && !is_seen(cube, band));
    if !empty.is_empty() {
        let _ = writeln!(text, "{empty} um is left out: no pixel has a radiance there");
    }
    text
}

/// Masked bands, pixels without a result and warnings. `order` has the bands by wavelength.
fn told(
    found: &[Found],
    spectra: &[Vec<[f32; 3]>],
    cube: &Cube,
    order: &[usize],
    known: &Known,
) -> String {
    let mut text = String::new();
    let mut reasons: BTreeMap<&String, usize> = BTreeMap::new();
    for reason in found.iter().filter_map(|found| found.as_ref().err()) {
        *reasons.entry(reason).or_default() += 1;
    }
    for (reason, number) in reasons {
        let _ = writeln!(text, "{number} of {} pixels have no emissivity: {reason}", found.len());
    }
    let told: Vec<&Vec<[f32; 3]>> =
        spectra.iter().zip(found).filter(|(_, found)| found.is_ok()).map(|(s, _)| s).collect();
    if told.is_empty() {
        return text;
    }
    let somewhere: Vec<Retrieved> = order
        .iter()
        .filter(|&&band| is_seen(cube, band))
        .map(|&band| {
            let wavelength_um = cube.wavelengths_um[band];
            let values = told.iter().map(|spectrum| spectrum[band]);
            let emissivity = values.map(|[e, error, _]| [e, error].map(f64::from));
            let emissivity = emissivity.into_iter().find(|[e, _]| e.is_finite());
            Retrieved { wavelength_um, amplification: f64::NAN, emissivity }
        })
        .collect();
    let known_values: Vec<[f64; 2]> = told
        .iter()
        .flat_map(|spectrum| spectrum.iter().map(|[e, error, _]| [*e, *error].map(f64::from)))
        .filter(|[e, _]| e.is_finite())
        .collect();
    let bands = somewhere.iter().filter(|band| band.emissivity.is_some()).count();
    let missing = bands * told.len() - known_values.len();
    if bands < somewhere.len() || missing == 0 {
        text += &masked(&somewhere, known);
    }
    if missing > 0 {
        let share = 100.0 * missing as f64 / (bands * told.len()) as f64;
        let _ = writeln!(
            text,
            "of the other bands {share:.2} % of the values are masked or have no radiance"
        );
    }
    let outside = known_values.iter().filter(|value| is_outside(value)).count();
    if !known_values.is_empty() && known_values.iter().all(|[e, _]| e.abs() < LEAST_LIKELY) {
        let _ = writeln!(
            text,
            "warning: no emissivity is above {LEAST_LIKELY}: the radiance may be in another unit \
             than W m-2 sr-1 um-1"
        );
    }
    if outside > 0 {
        let share = 100.0 * outside as f64 / known_values.len() as f64;
        let _ = writeln!(
            text,
            "warning: {share:.2} % of the emissivities are outside 0 to 1 by over three standard \
             errors: temperature, sky or radiance are wrong"
        );
    }
    text
}

/// The files of standard error, brightness temperature and target's temperature.
fn beside(path: &Path) -> [PathBuf; 3] {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    ["standard_error", "brightness_temperature", "temperature"]
        .map(|what| path.with_file_name(format!("{stem}_{what}.img")))
}

impl Image {
    /// The image of standard errors beside an image of radiance, by the name that soilsig gives it;
    /// `None` if it is not there.
    pub fn errors_beside(radiance: &Path) -> Option<PathBuf> {
        let [data, _] = Cube::files(radiance);
        let [errors, ..] = beside(&data);
        errors.is_file().then_some(errors)
    }

    /// The files that [`Image::write`] writes.
    pub fn files(path: &Path) -> Vec<PathBuf> {
        let images = [path.to_owned()].into_iter().chain(beside(path));
        images.flat_map(|image| [image.with_extension("hdr"), image]).collect()
    }

    /// Writes four ENVI images: the emissivity to `path`; beside it the standard error, the
    /// brightness temperature and the target's temperature, with longer names.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let [standard_error, brightness, temperature] = beside(path);
        self.emissivity.write(path, "emissivity")?;
        self.standard_error.write(&standard_error, "standard error of the emissivity")?;
        self.brightness_temperature_k.write(&brightness, "brightness temperature, K")?;
        let bands = [0, 1].map(|part| self.temperature_k.iter().map(move |t| t[part]));
        let data: Vec<u8> = bands.into_iter().flatten().flat_map(f32::to_le_bytes).collect();
        let contents = Contents {
            kind: Kind::Image,
            quantity: "temperature of the target, K",
            size: [self.emissivity.samples, self.emissivity.lines, 2],
            names: &["temperature".into(), "standard error".into()],
            wavelengths_um: &[],
            widths_um: &[],
            is_bad: &[],
        };
        Ok(envi::write(&temperature, &contents, &data)?)
    }
}
