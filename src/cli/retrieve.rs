//! `soilsig retrieve`: measured radiance into emissivity.

use std::path::{Path, PathBuf};

use super::arguments::{Assumptions, ending, kelvin, sky};
use super::{Context, Outcome, usage};
use crate::products::cube::Cube;
use crate::products::retrieve::{self, Known, RadianceError, Target};
use crate::radiometry::{Assumed, Atmosphere, Method, Temperature};
use crate::report::terminal;
use crate::support::error::Error;
use crate::support::output;

/// Retrieves emissivity and brightness temperature from measured radiance, by Eq. 2
///
/// The temperature of the target is given, or found from the radiance itself.
#[derive(clap::Args)]
pub struct Args {
    /// Radiance: a CSV file (wavelength_um, radiance_w_m2_sr_um), a signature.csv, or an ENVI image
    /// (.img or .hdr)
    radiance: PathBuf,
    /// Emissivity to write: a CSV file (standard output without it); for an image an .img file
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Temperature of the target, K
    #[arg(long, value_name = "K", value_parser = kelvin, required_unless_present = "method")]
    temperature: Option<f64>,
    /// Find the temperature from the radiance
    #[arg(long, value_enum, conflicts_with_all = ["temperature", "temperature_error"])]
    method: Option<Method>,
    /// The target is a powder of quartz alone, not a soil: `christiansen` then takes a higher emissivity
    #[arg(long, requires = "method")]
    pure_quartz: bool,
    /// The sky: its temperature, K, or a CSV file of its radiance. Without it the sky of the CSV
    /// file, else cold and black
    #[arg(long, value_name = "K|FILE")]
    sky: Option<String>,
    /// Atmosphere between target and sensor: a CSV file
    #[arg(long, value_name = "FILE")]
    atmosphere: Option<PathBuf>,
    /// Standard error of the radiance, W m-2 sr-1 um-1, or an image of it [default: the file's own,
    /// or the image beside it]
    #[arg(long, value_name = "L|FILE")]
    radiance_error: Option<String>,
    #[command(flatten)]
    assumptions: Assumptions,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let error_k = args.assumptions.temperature_error;
    let target = match (args.temperature, args.method) {
        (_, Some(method)) => Target::By(method),
        (Some(k), None) => Target::Given(Temperature { k, error_k }),
        (None, None) => unreachable!("clap asks for one of both"),
    };
    let sky = sky(args.sky.as_deref())?;
    let atmosphere = args.atmosphere.as_deref().map(Atmosphere::read).transpose()?;
    let assumed = Assumed { pure_quartz: args.pure_quartz, ..args.assumptions.assumed() };
    let known = Known { sky, atmosphere, target, assumed };
    let words = args.sky.iter().chain(&args.radiance_error).map(Path::new);
    let files = words.chain([args.radiance.as_path()]).chain(args.atmosphere.as_deref());
    let read: Vec<PathBuf> =
        files.flat_map(|file| Cube::files(file).into_iter().chain([file.to_owned()])).collect();
    if ending(&args.radiance) == "csv" {
        of_spectrum(args, &known, read, context)?;
    } else {
        of_image(args, &known, read, context)?;
    }
    Ok(None)
}

/// The radiance error, if it is a number.
fn one_error(text: &str) -> Result<Option<f64>, Error> {
    let Ok(error) = text.parse::<f64>() else { return Ok(None) };
    if !(error >= 0.0 && error.is_finite()) {
        return Err(usage(&format!("--radiance-error {text} is not a number, 0 or more")));
    }
    Ok(Some(error))
}

fn of_spectrum(
    args: &Args,
    known: &Known,
    read: Vec<PathBuf>,
    context: &Context,
) -> Result<(), Error> {
    let error = args.radiance_error.as_deref().map(|text| {
        let of_image = || usage(&format!("--radiance-error {text}: for a CSV file give a number"));
        one_error(text)?.ok_or_else(of_image)
    });
    let error = error.transpose()?;
    output::keeps(read, &args.out)?;
    let spectrum = retrieve::spectrum(&args.radiance, error, known)?;
    let answer = terminal::retrieved(&spectrum.retrieved);
    match &args.out {
        Some(path) => {
            output::bytes(path, spectrum.csv_text().as_bytes())?;
            context.print(&format!("{answer}\nresult in {}\n", path.display()))?;
        }
        // The numbers themselves are the answer.
        None => context.print(&spectrum.csv_text())?,
    }
    context.monitor.say(spectrum.in_words(known).trim_end());
    Ok(())
}

fn of_image(
    args: &Args,
    known: &Known,
    read: Vec<PathBuf>,
    context: &Context,
) -> Result<(), Error> {
    let Some(out) = &args.out else {
        return Err(usage("an image needs --out FILE.img"));
    };
    if ending(out) != "img" {
        return Err(usage(&format!(
            "{}: images are written as .img, with their .hdr beside",
            out.display()
        )));
    }
    let beside = retrieve::Image::errors_beside(&args.radiance);
    let beside = beside.filter(|_| args.radiance_error.is_none());
    let of_errors = beside.iter().flat_map(|errors| Cube::files(errors));
    output::keeps(read.into_iter().chain(of_errors), retrieve::Image::files(out))?;
    let cube = Cube::read_radiance(&args.radiance)?;
    let given = args.radiance_error.as_deref();
    let given = match given {
        Some(text) => Some((text, one_error(text)?)),
        None => None,
    };
    let beside = beside.as_ref().map(|path| path.display().to_string());
    let error = match given.or(beside.as_deref().map(|path| (path, None))) {
        None => RadianceError::Unknown,
        Some((_, Some(error))) => RadianceError::One(error),
        Some((text, None)) => {
            let errors = Cube::read_radiance(Path::new(text))?;
            let shape = |cube: &Cube| (cube.lines, cube.samples, cube.wavelengths_um.clone());
            if shape(&errors) != shape(&cube) {
                let of = args.radiance.display();
                return Err(usage(&format!("{text} does not have the pixels and bands of {of}")));
            }
            RadianceError::Cube(errors)
        }
    };
    let image = retrieve::image(&cube, &error, known, context.monitor)?;
    image.write(out)?;
    let (lines, samples, bands) = (cube.lines, cube.samples, cube.wavelengths_um.len());
    context.print(&format!("emissivity of {samples} x {lines} pixels in {bands} bands\n"))?;
    context.print(&format!("result in {}\n", out.display()))?;
    if let Some(beside) = beside {
        context.monitor.say(&format!("the standard error of the radiance is that of {beside}"));
    }
    context.monitor.say(image.statement.trim_end());
    Ok(())
}
