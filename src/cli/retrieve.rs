//! `soilsig retrieve`: measured radiance into emissivity.

use std::path::{Path, PathBuf};

use super::{Assumptions, print, usage};
use crate::products::cube::Cube;
use crate::products::retrieve::{self, Known, RadianceError, Sky, Target};
use crate::radiometry::{Atmosphere, Method, SkyTable, Temperature};
use crate::scene;
use crate::support::error::Error;
use crate::support::monitor::Monitor;
use crate::support::output;

/// Retrieves emissivity and brightness temperature from measured radiance, by Eq. 2
///
/// The temperature of the target is given, or found from the radiance itself.
#[derive(clap::Args)]
pub struct Args {
    /// Radiance: a CSV file (wavelength_um, radiance_w_m2_sr_um), a signature.csv, or an ENVI image (.img or .hdr)
    radiance: PathBuf,
    /// Emissivity to write: a CSV file (standard output without it), of an image an .img file
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Temperature of the target, K
    #[arg(long, value_name = "K", value_parser = kelvin, required_unless_present = "method")]
    temperature: Option<f64>,
    /// Find the temperature from the radiance
    #[arg(long, value_enum, conflicts_with_all = ["temperature", "temperature_error"])]
    method: Option<Method>,
    /// The sky: its temperature, K, or a CSV file of its radiance; without it that of the CSV file, else cold and black
    #[arg(long, value_name = "K|FILE")]
    sky: Option<String>,
    /// Atmosphere between target and sensor: a CSV file
    #[arg(long, value_name = "FILE")]
    atmosphere: Option<PathBuf>,
    /// Standard error of the radiance, W m-2 sr-1 um-1, or an image of it
    #[arg(long, value_name = "L|FILE")]
    radiance_error: Option<String>,
    #[command(flatten)]
    assumptions: Assumptions,
}

fn kelvin(text: &str) -> Result<f64, String> {
    let kelvin = text.parse().map_err(|_| "it must be a number".to_owned())?;
    scene::Sky::Isotropic(kelvin).problem().map_or(Ok(kelvin), Err)
}

pub fn run(args: &Args, monitor: &dyn Monitor) -> Result<(), Error> {
    let error_k = args.assumptions.temperature_error;
    let target = match (args.temperature, args.method) {
        (_, Some(method)) => Target::By(method),
        (Some(k), None) => Target::Given(Temperature { k, error_k }),
        (None, None) => unreachable!("clap asks for one of both"),
    };
    let sky = match args.sky.as_deref().map(|text| (text, kelvin(text))) {
        None => Sky::OfFile,
        Some((_, Ok(kelvin))) => Sky::Grey(kelvin),
        Some((text, Err(problem))) if text.parse::<f64>().is_ok() => {
            usage(&format!("--sky: {problem}"))
        }
        Some((text, Err(_))) => Sky::Table(SkyTable::read(Path::new(text))?),
    };
    let atmosphere = args.atmosphere.as_deref().map(Atmosphere::read).transpose()?;
    let known = Known { sky, atmosphere, target, assumed: args.assumptions.assumed() };
    let error = args.radiance_error.as_deref().map(|text| (text, text.parse::<f64>()));
    let words = args.sky.iter().chain(&args.radiance_error).map(Path::new);
    let files = words.chain([args.radiance.as_path()]).chain(args.atmosphere.as_deref());
    let read: Vec<PathBuf> =
        files.flat_map(|file| Cube::files(file).into_iter().chain([file.to_owned()])).collect();
    let ending = args.radiance.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ending == "csv" {
        let error = match error {
            None => None,
            Some((_, Ok(error))) if error >= 0.0 && error.is_finite() => Some(error),
            Some((text, _)) => usage(&format!(
                "--radiance-error {text}: for a CSV file it must be a number, 0 or more"
            )),
        };
        output::keeps(read, &args.out)?;
        let spectrum = retrieve::spectrum(&args.radiance, error, &known)?;
        match &args.out {
            Some(path) => output::bytes(path, spectrum.csv_text().as_bytes())?,
            None => print(&spectrum.csv_text())?,
        }
        eprint!("{}", spectrum.in_words(&known));
        return Ok(());
    }
    let Some(out) = &args.out else { usage("an image needs --out FILE.img") };
    if out.extension().is_none_or(|ending| ending != "img") {
        usage(&format!("{}: images are written as .img, with their .hdr beside", out.display()));
    }
    output::keeps(read, retrieve::Image::files(out))?;
    let cube = Cube::read(&args.radiance)?;
    let error = match error {
        None => RadianceError::One(0.0),
        Some((_, Ok(error))) if error >= 0.0 && error.is_finite() => RadianceError::One(error),
        Some((text, Ok(_))) => usage(&format!("--radiance-error {text} is not 0 or more")),
        Some((text, Err(_))) => {
            let errors = Cube::read(Path::new(text))?;
            if (errors.lines, errors.samples, &errors.wavelengths_um)
                != (cube.lines, cube.samples, &cube.wavelengths_um)
            {
                usage(&format!(
                    "{text} is not of the pixels and bands of {}",
                    args.radiance.display()
                ));
            }
            RadianceError::Cube(errors)
        }
    };
    let image = retrieve::image(&cube, &error, &known, monitor)?;
    image.write(out)?;
    eprint!("{}", image.statement);
    Ok(())
}
