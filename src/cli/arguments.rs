//! Arguments that several subcommands share, and how their words are read.

use std::fmt::Display;
use std::ops::{Bound, RangeBounds};
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{StringValueParser, TypedValueParser};

use super::usage;
use crate::draw::plot;
use crate::pipeline::MOST_SECONDS;
use crate::products::retrieve;
use crate::radiometry::{Assumed, SkyTable};
use crate::scene::{
    Change, Component, Constants, ConstantsFile, Grid, Inverted, Scene, Sky, SpectrumSource,
};
use crate::spectrum::Spectrum;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::output;
use crate::support::scratch::Scratch;

/// The bands of a signature.
#[derive(Args)]
pub struct Bands {
    /// Wavelengths, um; the spectra must cover them
    #[arg(long, value_name = "FROM-TO", default_value = "7.5-14", value_parser = range)]
    range: (f64, f64),
    /// Distance between bands, um
    #[arg(long, value_name = "UM", default_value_t = 0.01)]
    step: f64,
}

impl Bands {
    pub fn grid(&self) -> Result<Grid, Error> {
        Grid::new(self.range.0, self.range.1, self.step).map_err(|problem| usage(&problem))
    }
}

/// Values that replace the scene's.
#[derive(Args)]
pub struct Changes {
    /// Another value of the scene, as in view.zenith_deg=35 or materials.fine.temperature_k=310;
    /// null takes a key away. May be given several times
    #[arg(long, value_name = "KEY=VALUE", value_parser = str::parse::<Change>)]
    pub set: Vec<Change>,
}

impl Changes {
    /// A scene with these values.
    pub fn of(&self, scene: Scene) -> Result<Scene, Error> {
        Ok(scene.changed(&self.set)?)
    }

    /// Reads a scene file, with these values.
    pub fn read(&self, path: &Path) -> Result<Scene, Error> {
        self.of(Scene::read(path)?)
    }
}

/// What a retrieval assumes.
#[derive(Args)]
pub struct Assumptions {
    /// Standard error of the target's temperature, K
    #[arg(long, value_name = "K", default_value_t = 0.0, value_parser = not_negative)]
    pub temperature_error: f64,
    /// Standard error of the sky's radiance, as a share of it
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = not_negative)]
    sky_error: f64,
    /// Mask bands in which Eq. 2 amplifies errors more than this: at 10 an error of 1 % in radiance
    /// is one of 0.1 in emissivity
    #[arg(long, value_name = "F", default_value_t = Assumed::AMPLIFICATION_LIMIT,
          value_parser = not_negative)]
    amplification_limit: f64,
}

impl Assumptions {
    pub fn assumed(&self) -> Assumed {
        Assumed {
            downwelling_error: self.sky_error,
            amplification_limit: self.amplification_limit,
            ..Assumed::EXACT
        }
    }
}

/// The sky over a measured target, from the words of `--sky`: a temperature or a file.
pub fn sky(words: Option<&str>) -> Result<retrieve::Sky, Error> {
    Ok(match words.map(|words| (words, kelvin(words))) {
        None => retrieve::Sky::OfFile,
        Some((_, Ok(kelvin))) => retrieve::Sky::Grey(kelvin),
        Some((words, Err(problem))) if words.parse::<f64>().is_ok() => {
            return Err(usage(&format!("--sky: {problem}")));
        }
        Some((words, Err(_))) => retrieve::Sky::Table(SkyTable::read(Path::new(words))?),
    })
}

/// How Blender is run.
#[derive(Args)]
pub struct InBlender {
    /// Blender to use: its executable, or a Python that can import bpy
    #[arg(long, value_name = "PATH", value_parser = utf8_path())]
    blender: Option<PathBuf>,
    /// Longest that Blender may take, seconds
    #[arg(long, value_name = "S", default_value_t = 600,
          value_parser = clap::value_parser!(u64).range(1..=MOST_SECONDS))]
    pub blender_timeout: u64,
    /// Do not use earlier results
    #[arg(long)]
    no_cache: bool,
}

impl InBlender {
    /// The Blender asked for. A path is made absolute, so that a record holds elsewhere; a name is
    /// looked up on PATH.
    pub fn blender(&self) -> Option<PathBuf> {
        self.blender.as_deref().map(named)
    }

    /// Does the work with the cache, or with an empty one of its own.
    pub fn run<T>(
        &self,
        cache: &Cache,
        work: impl FnOnce(&Cache) -> Result<T, Error>,
    ) -> Result<T, Error> {
        if !self.no_cache {
            return work(cache);
        }
        let folder = Scratch::temporary()?;
        work(&cache.other_results(folder.path().to_owned()))
    }
}

pub use crate::pipeline::TOLERANCE;

/// When a trace ends at the latest.
#[derive(Args)]
pub struct Enough {
    /// Most paths to trace; if they are too few the result is written and the exit status is 4
    #[arg(long, value_name = "N", default_value_t = 1 << 26,
          value_parser = clap::value_parser!(u64).range(2..))]
    pub max_paths: u64,
    /// Longest that a trace may take, seconds; if it is too short the result is written and the
    /// exit status is 4
    #[arg(long, value_name = "S", value_parser = positive)]
    pub max_seconds: Option<f64>,
}

/// Reads a number within a range, which the words name in a message.
pub fn number(
    text: &str,
    within: impl RangeBounds<f64>,
    words: impl Display,
) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && within.contains(&x) => Ok(x),
        _ => Err(format!("{text:?} is not {words}")),
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, 0.0.., "a number, 0 or more")
}

pub fn positive(text: &str) -> Result<f64, String> {
    number(text, (Bound::Excluded(0.0), Bound::Unbounded), "a number above 0")
}

pub fn tolerance(text: &str) -> Result<f64, String> {
    number(text, (Bound::Excluded(0.0), Bound::Excluded(1.0)), "a number above 0 and below 1")
}

/// A temperature, K.
pub fn kelvin(text: &str) -> Result<f64, String> {
    let kelvin = text.parse().map_err(|_| format!("{text:?} is not a number"))?;
    Sky::Isotropic(kelvin).problem().map_or(Ok(kelvin), Err)
}

pub fn range(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text.split_once('-').ok_or("write FROM-TO, as in 7.5-14")?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|e| format!("{text:?}: {e}"));
    let (from, to) = (number(from)?, number(to)?);
    if from > to {
        return Err(format!("write the shorter wavelength first: {to}-{from}"));
    }
    Ok((from, to))
}

/// A path that a record can hold: in UTF-8.
pub fn utf8_path() -> impl TypedValueParser<Value = PathBuf> {
    StringValueParser::new().map(PathBuf::from)
}

/// A program: its absolute path, or a name to look up on PATH.
pub fn named(program: &Path) -> PathBuf {
    if program.components().count() == 1 { program.to_owned() } else { absolute(program) }
}

/// A path that holds in any folder.
pub fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// The ending of a file's name, in lower case.
pub fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// A spectrum on the command line: a number, a shipped one's name, `fresnel:CONSTANTS`, `inverted:`
/// before a powder's, `mix:SHARE*SPECTRUM+SHARE*SPECTRUM`, else a file.
pub fn spectrum_source(text: &str) -> Result<SpectrumSource, Error> {
    Ok(if let Ok(value) = text.parse::<f64>() {
        if !(0.0..=1.0).contains(&value) {
            return Err(usage(&format!("an emissivity of {value} is not within 0 to 1")));
        }
        SpectrumSource::Constant(value)
    } else if let Some(constants) = text.strip_prefix("fresnel:") {
        SpectrumSource::Fresnel(constants_source(constants))
    } else if let Some(components) = text.strip_prefix("mix:") {
        let component = |text: &str| -> Result<Component, Error> {
            let parts =
                text.split_once('*').and_then(|(share, of)| Some((share.parse().ok()?, of)));
            let Some((share, of)) = parts else {
                return Err(usage(&format!("{text:?} is not SHARE*SPECTRUM")));
            };
            Ok(Component { share, spectrum: spectrum_source(of)? })
        };
        let components: Result<_, Error> = components.split('+').map(component).collect();
        let mix = SpectrumSource::Mix(components?);
        if let Some(problem) = mix.problem() {
            return Err(usage(&format!("{text:?}: {problem}")));
        }
        mix
    } else if let Some(powder) = text.strip_prefix("inverted:") {
        if ["inverted:", "fresnel:", "mix:"].iter().any(|other| powder.starts_with(other)) {
            return Err(usage(&format!(
                "{text:?} is not a spectrum: after inverted: name a powder's, by a shipped one's \
                 name, a file or a number"
            )));
        }
        let spectrum = Box::new(spectrum_source(powder)?);
        SpectrumSource::Inverted(Inverted { spectrum, pure_bed: Vec::new() })
    } else if Spectrum::builtin(text).is_ok() {
        SpectrumSource::Builtin(text.to_owned())
    } else {
        SpectrumSource::File(text.into())
    })
}

/// Optical constants on the command line: a shipped set's name, or a .json file.
fn constants_source(text: &str) -> Constants {
    if ending(Path::new(text)) == "json" {
        Constants::File(ConstantsFile { file: text.into() })
    } else {
        Constants::Shipped(text.to_owned())
    }
}

/// A spectrum on the command line, read.
pub fn spectrum(text: &str) -> Result<Spectrum, Error> {
    Ok(Spectrum::resolve(&spectrum_source(text)?, Path::new(""))?)
}

/// The file of a spectrum on the command line, if it has one.
pub fn file_of(text: &str) -> Option<&Path> {
    let path = Path::new(text.strip_prefix("inverted:").unwrap_or(text));
    path.exists().then_some(path)
}

/// The file of a chart, whose ending says how it is written.
pub struct ChartFile<'a> {
    path: &'a Path,
    kind: Kind,
}

/// The format of a chart.
enum Kind {
    Svg,
    Pdf,
    Png,
}

impl<'a> ChartFile<'a> {
    pub fn new(path: &'a Path) -> Result<Self, Error> {
        let kind = match &*ending(path) {
            "svg" => Kind::Svg,
            "pdf" => Kind::Pdf,
            "png" => Kind::Png,
            _ => {
                let path = path.display();
                return Err(usage(&format!("{path}: charts are written as .svg, .pdf or .png")));
            }
        };
        Ok(Self { path, kind })
    }

    pub fn write(&self, svg: &str) -> Result<(), Error> {
        Ok(match self.kind {
            Kind::Svg => output::bytes(self.path, svg.as_bytes()),
            Kind::Pdf => output::bytes(self.path, &plot::pdf(svg)?),
            Kind::Png => output::bytes(self.path, &plot::png(svg, plot::PIXELS_PER_UNIT)?),
        }?)
    }
}
