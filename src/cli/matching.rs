//! `soilsig match`: from a measured signature back to the soil.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::arguments::{
    InBlender, absolute, kelvin, number, range, sky, spectrum_source, utf8_path,
};
use super::{Context, Outcome, usage};
use crate::inverse::facets::FacetModel;
use crate::inverse::measured::Seen;
use crate::inverse::soil::On;
use crate::inverse::{self, Options, Warning, words};
use crate::products::retrieve::{Known, Target};
use crate::radiometry::{Assumed, Atmosphere, Method, Temperature};
use crate::scene::{Scene, SpectrumSource, shipped};
use crate::support::error::{Error, Status};
use crate::support::output;

/// Finds the soil of a measured signature: its cover with fines, and a second component
///
/// Beds are dropped in Blender, fines are taken away from them step by step, and the parameters are
/// estimated with their errors.
#[derive(clap::Args)]
pub struct Args {
    /// Measured emissivity (two columns, or a format of the spectral libraries); with --sky,
    /// --atmosphere or --temperature, a CSV file of radiance
    spectrum: PathBuf,
    /// Folder for the result
    #[arg(long, short, value_name = "FOLDER", default_value = "out/match", value_parser = utf8_path())]
    out: PathBuf,
    /// Wavelengths that are fitted, um
    #[arg(long, value_name = "FROM-TO", default_value = "7.5-13.5", value_parser = range)]
    range: (f64, f64),
    /// Standard error of the measured emissivity; of radiance, W m-2 sr-1 um-1
    #[arg(long, value_name = "X", value_parser = error)]
    error: Option<f64>,
    /// Facets of the answer; the others are compared with it
    #[arg(long, value_enum, default_value = "inverted")]
    facets: FacetModel,
    /// The second component: `flat`, a shipped spectrum or a file
    #[arg(long, value_name = "SPECTRUM", default_value = "flat")]
    second: String,
    /// Where the second component is
    #[arg(long, value_enum, default_value = "all")]
    second_on: On,
    /// Prior of a parameter (cover, second, level, large_fines, medium_grains, temperature, offset),
    /// as NAME=MEAN+-SD; NAME=VALUE gives it
    #[arg(long, value_name = "NAME=MEAN+-SD", value_parser = prior)]
    prior: Vec<(String, f64, f64)>,
    /// Recipe of full cover, or a bed of dusty grains as it is [default: the shipped recipe]
    #[arg(long, value_name = "FILE", value_parser = utf8_path())]
    scene: Option<PathBuf>,
    /// Beds of each cover
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u16).range(1..=64))]
    beds: u16,
    /// Random seed of beds, fines, rays and draws
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// The sky over radiance: its temperature, K, or a CSV file
    #[arg(long, value_name = "K|FILE")]
    sky: Option<String>,
    /// Atmosphere between target and sensor: a CSV file
    #[arg(long, value_name = "FILE")]
    atmosphere: Option<PathBuf>,
    /// A first temperature of the target, K [default: by its Christiansen bands]
    #[arg(long, value_name = "K", value_parser = kelvin)]
    temperature: Option<f64>,
    /// Standard error of the sky's radiance, as a share of it
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    sky_error: f64,
    #[command(flatten)]
    in_blender: InBlender,
    /// Print match.json on standard output
    #[arg(long)]
    json: bool,
}

/// Standard error of a measured emissivity where none is given.
const ERROR: f64 = 0.005;

fn error(text: &str) -> Result<f64, String> {
    number(text, f64::MIN_POSITIVE.., "a number above 0")
}

fn share(text: &str) -> Result<f64, String> {
    number(text, 0.0..=1.0, "a number from 0 to 1")
}

fn prior(text: &str) -> Result<(String, f64, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=MEAN+-SD, as in cover=0.5+-0.2")?;
    let (mean, sd) = value.split_once("+-").unwrap_or((value, "0"));
    let mean = number(mean, .., "a number")?;
    Ok((name.to_owned(), mean, number(sd, 0.0.., "a number, 0 or more")?))
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let mut scene = match &args.scene {
        None => {
            Scene::parse(shipped::text("full").expect("it is shipped"), Path::new("full.json"))?
        }
        Some(path) => Scene::read(path)?,
    };
    scene.seed = args.seed;
    output::keeps([&args.spectrum], [args.out.join("match.json"), args.out.join("match.csv")])?;
    output::folder(&args.out)?;
    let seen = seen(args)?;
    let second = second(&args.second)?;
    let others = FacetModel::ALL.into_iter().filter(|facets| *facets != args.facets).collect();
    let result = args.in_blender.run(&context.cache, |cache| {
        inverse::run(&Options {
            spectrum: args.spectrum.clone(),
            seen,
            error: args.error.unwrap_or(ERROR),
            scene,
            is_shipped: args.scene.is_none(),
            facets: args.facets,
            others,
            second,
            on: args.second_on,
            priors: args.prior.clone(),
            beds: args.beds.into(),
            seed: args.seed,
            out: absolute(&args.out),
            command: context.command.clone(),
            blender: args.in_blender.blender(),
            time_limit: Duration::from_secs(args.in_blender.blender_timeout),
            cache,
            monitor: context.monitor,
        })
    })?;
    let no_fit = result.warnings.iter().any(|w| matches!(w, Warning::NoGoodFit { .. }));
    let status = no_fit.then_some(Status::NoGoodFit);
    if args.json {
        context.print_json(&result)?;
        return Ok(status);
    }
    if context.verbose {
        context.print(&words::page(&result))?;
    } else {
        context.print(&words::answer(&result))?;
        for warning in &result.warnings {
            context.print(&format!("warning: {warning}\n"))?;
        }
    }
    context
        .print(&format!("result in {} (match.txt, match.svg, match.json)\n", args.out.display()))?;
    Ok(status)
}

/// The second component; `None` for a spectrally flat one. Its file is found from any folder.
fn second(text: &str) -> Result<Option<SpectrumSource>, Error> {
    if text == "flat" {
        return Ok(None);
    }
    Ok(Some(match spectrum_source(text)? {
        SpectrumSource::File(path) => SpectrumSource::File(absolute(&path)),
        SpectrumSource::Fresnel(_)
        | SpectrumSource::Refractive(_)
        | SpectrumSource::Auto(_)
        | SpectrumSource::Mix(_) => {
            return Err(usage(&format!("--second {text}: give one Lambertian spectrum")));
        }
        other => other,
    }))
}

/// What was measured: radiance, if anything is said of its surroundings.
fn seen(args: &Args) -> Result<Seen, Error> {
    let range_um = [args.range.0, args.range.1];
    if args.sky.is_none() && args.atmosphere.is_none() && args.temperature.is_none() {
        return Seen::emissivity(&args.spectrum, range_um);
    }
    let sky = sky(args.sky.as_deref())?;
    let target = match args.temperature {
        Some(k) => Target::Given(Temperature { k, error_k: 0.0 }),
        None => Target::By(Method::Christiansen),
    };
    let known = Known {
        sky,
        atmosphere: args.atmosphere.as_deref().map(Atmosphere::read).transpose()?,
        target,
        assumed: Assumed { downwelling_error: args.sky_error, ..Assumed::EXACT },
    };
    Seen::radiance(&args.spectrum, args.error, &known, range_um)
}
