//! `soilsig signature`: a bounce table into emissivity and radiance.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::arguments::{Assumptions, Bands, ChartFile, ending, file_of, kelvin, spectrum};
use super::{Context, Outcome, spectra, usage};
use crate::draw::plot;
use crate::radiometry::{Atmosphere, SkyTable, Temperature};
use crate::report::compare::{self, Difference};
use crate::report::{self, Report, Retrieval, ToleranceOf, terminal};
use crate::signature;
use crate::signature::in_bands;
use crate::spectrum::sensors::Sensor;
use crate::support::error::Error;
use crate::support::output;
use crate::table::Table;

/// Evaluates bounce tables: emissivity and radiance in every band, without tracing again
#[derive(clap::Args)]
pub struct Args {
    /// Bounce table of `soilsig trace`, or those of several packings of one recipe
    #[arg(required = true, value_name = "TABLE")]
    tables: Vec<PathBuf>,
    /// File to write: .nc for NetCDF, else CSV; standard output without it
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Sensors whose bands to give in place of single wavelengths: aster, ecostress, landsat-tirs,
    /// modis, master, hytes, sebass (nominal bands), or CSV files of responses
    #[arg(long = "sensor", value_name = "SENSOR,...", value_delimiter = ',',
          conflicts_with_all = ["plot", "beside", "budget"])]
    sensors: Vec<String>,
    /// Chart to write as well: a .svg, .pdf or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Leave out title, caption and marks of the chart, for a paper
    #[arg(long, requires = "plot")]
    bare_figure: bool,
    /// A spectrum to compare the signature with, and to show beside it: a measured one's file, or a
    /// shipped one's name
    #[arg(long, value_name = "SPECTRUM")]
    beside: Vec<String>,
    /// CSV file to write the budget to: every part of the uncertainty in every band
    #[arg(long, value_name = "FILE")]
    budget: Option<PathBuf>,
    /// Another spectrum for a material: a shipped one's name, a file or a number, each after
    /// inverted: to invert it by a pure bed; fresnel:CONSTANTS; or a mix by area,
    /// mix:SHARE*SPECTRUM+SHARE*SPECTRUM
    #[arg(long = "spectrum", value_name = "MATERIAL=SPECTRUM")]
    spectra: Vec<String>,
    /// Another temperature of the scene, K
    #[arg(long, value_name = "K", value_parser = kelvin)]
    temperature: Option<f64>,
    /// Another sky: its temperature, K, or a CSV file of its radiance
    #[arg(long, value_name = "K|FILE")]
    sky: Option<String>,
    /// Another atmosphere between target and sensor: a CSV file
    #[arg(long, value_name = "FILE")]
    atmosphere: Option<PathBuf>,
    #[command(flatten)]
    assumptions: Assumptions,
    #[command(flatten)]
    bands: Bands,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let given = args.spectra.iter().filter_map(|given| given.split_once('=')).map(|(_, text)| text);
    let given = given.chain(args.beside.iter().map(String::as_str)).filter_map(file_of);
    let read = args.tables.iter().chain(&args.atmosphere).map(PathBuf::as_path).chain(given);
    let read = read.chain(args.sky.as_deref().map(Path::new));
    let read = read.chain(args.sensors.iter().map(Path::new));
    output::keeps(read, [&args.out, &args.plot, &args.budget].into_iter().flatten())?;
    let grid = args.bands.grid()?;
    let chart_file = args.plot.as_deref().map(ChartFile::new).transpose()?;
    let beside =
        args.beside.iter().map(|text| spectrum(text)).collect::<Result<Vec<_>, Error>>()?;
    let beside = spectra::drawn(&args.beside, &beside, Some(grid.range_um()))?;
    let mut tables = Table::read_packings(&args.tables)?;
    change(&mut tables[0], args)?;
    if !args.sensors.is_empty() {
        return of_sensors(args, &tables, context);
    }
    let temperature =
        Temperature { error_k: args.assumptions.temperature_error, ..tables[0].temperature() };
    let assumed = args.assumptions.assumed();
    let tolerance = tables[0].stop.asked.tolerance;
    let report =
        Report::new(&tables, &grid.wavelengths_um(), (tolerance, ToleranceOf::Interval), None)?;
    let bands = &report.bands;
    let result = match args.out.as_deref().map(ending).as_deref() {
        Some("nc") => {
            signature::netcdf::bytes(&tables[0], bands, &report.budget, temperature, assumed)
        }
        _ => signature::csv_text(bands, &report.budget, temperature, assumed).into_bytes(),
    };
    if let Some(path) = &args.out {
        output::bytes(path, &result)?;
        let scene = (&*tables[0].scene, &report.reached, None);
        context.print(&terminal::blocks(&[scene], context.verbose))?;
        context.print(&format!("result in {}\n", path.display()))?;
    } else {
        for warning in &report.reached.warnings {
            context.monitor.say(&format!("warning: {warning}"));
        }
        context.print(&String::from_utf8(result).expect("CSV is text"))?;
    }
    if let Some(path) = &args.budget {
        output::bytes(path, report.budget.csv_text().as_bytes())?;
    }
    for line in Retrieval::new(&tables[0], bands, assumed).lines() {
        context.monitor.say(&line);
    }
    for curve in &beside.curves {
        let measured = compare::Curve {
            name: curve.label.clone(),
            wavelength_um: curve.wavelength_um.clone(),
            emissivity: curve.emissivity.clone(),
            half_width_95: None,
        };
        let difference = Difference::new(&measured, &compare::Curve::of(&report))?;
        context.monitor.say(&format!("signature less {}: {}", curve.label, difference.in_short()));
    }
    if let Some(file) = chart_file {
        let versions = BTreeMap::from([("soilsig".into(), env!("CARGO_PKG_VERSION").into())]);
        let mut chart = report::chart(&tables[0].scene, &[(&tables, &report)], &versions);
        chart.curves.extend(beside.curves);
        chart.caption.extend(beside.caption);
        chart.caption.extend(beside.credit);
        chart.bare = args.bare_figure;
        file.write(&plot::emissivity_svg(&chart)?)?;
    }
    Ok(None)
}

/// Writes the bands of the sensors asked for, in their order, and says where these come from.
fn of_sensors(args: &Args, tables: &[Table], context: &Context) -> Outcome {
    let mut seen = Vec::new();
    for text in &args.sensors {
        let sensor = Sensor::find(text)?;
        context.monitor.say(&format!("{}: {}", sensor.name, sensor.source));
        seen.extend(in_bands::in_bands(tables, &sensor)?);
    }
    for warning in &tables[0].warnings {
        context.monitor.say(&format!("warning: {warning}"));
    }
    let missed = seen.iter().filter(|band| band.seen.is_none());
    let missed: Vec<String> = missed.map(|band| format!("{} {}", band.sensor, band.band)).collect();
    if !missed.is_empty() {
        context.monitor.say(&format!(
            "warning: left empty, since spectra do not hold them: {}",
            missed.join(", ")
        ));
    }
    if let Some(path) = &args.out {
        let result = match &*ending(path) {
            "nc" => signature::netcdf::bytes_in_bands(&tables[0], &seen),
            _ => in_bands::csv_text(&seen).into_bytes(),
        };
        output::bytes(path, &result)?;
        context.print(&terminal::in_bands(&seen))?;
        context.print(&format!("result in {}\n", path.display()))?;
    } else {
        context.print(&in_bands::csv_text(&seen))?;
    }
    Ok(None)
}

/// Gives a table other spectra, another temperature, sky and atmosphere.
fn change(table: &mut Table, args: &Args) -> Result<(), Error> {
    let mut named = Vec::new();
    for given in &args.spectra {
        let Some((name, text)) = given.split_once('=') else {
            return Err(usage(&format!("{given:?} is not MATERIAL=SPECTRUM")));
        };
        if named.contains(&name) {
            return Err(usage(&format!("material {name:?} is given two spectra")));
        }
        named.push(name);
        table.set_spectrum(name, spectrum(text)?)?;
    }
    if let Some(temperature_k) = args.temperature {
        table.set_temperature(temperature_k)?;
    }
    if let Some(sky) = &args.sky {
        set_sky(table, sky)?;
    }
    if let Some(path) = &args.atmosphere {
        table.atmosphere = Some(Atmosphere::read(path)?);
    }
    Ok(())
}

/// Gives a table another sky.
fn set_sky(table: &mut Table, text: &str) -> Result<(), Error> {
    if text.parse::<f64>().is_ok() {
        let sky = kelvin(text).map_err(|problem| usage(&format!("--sky {problem}")))?;
        return Ok(table.set_sky_temperature(sky)?);
    }
    Ok(table.set_sky(SkyTable::read(Path::new(text))?)?)
}
