//! `soilsig signature`: a bounce table into emissivity and radiance.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{Assumptions, Bands, ChartFormat, file_of, print, spectra, spectrum_source, usage};
use crate::draw::plot;
use crate::radiometry::{Atmosphere, SkyTable, Temperature};
use crate::report::{self, terminal, warnings};
use crate::scene::Sky;
use crate::signature;
use crate::signature::budget::{Budget, Origin};
use crate::spectrum::Spectrum;
use crate::support::error::Error;
use crate::support::output;
use crate::table::Table;

/// Evaluates bounce tables: emissivity and radiance by band, without tracing again
#[derive(clap::Args)]
pub struct Args {
    /// Bounce table of `soilsig trace`, or those of several packings of one recipe
    #[arg(required = true, value_name = "TABLE")]
    tables: Vec<PathBuf>,
    /// CSV file to write; standard output without it
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Chart to write as well: a .svg or .png file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// A spectrum for the chart to show beside the signature: a measured one's file, or a shipped one's name
    #[arg(long, value_name = "SPECTRUM", requires = "plot")]
    beside: Vec<String>,
    /// CSV file to write where the uncertainty comes from, band by band
    #[arg(long, value_name = "FILE")]
    budget: Option<PathBuf>,
    /// Another spectrum for a material: a shipped one's name, a file or a number, each of them after inverted: if facets
    /// of a pure bed are to make it; or fresnel:CONSTANTS
    #[arg(long = "spectrum", value_name = "MATERIAL=SPECTRUM")]
    spectra: Vec<String>,
    /// Another temperature of the scene, K
    #[arg(long, value_name = "K")]
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

pub fn run(args: &Args) -> Result<(), Error> {
    let given = args.spectra.iter().filter_map(|given| given.split_once('=')).map(|(_, text)| text);
    let given = given.chain(args.beside.iter().map(String::as_str)).filter_map(file_of);
    let read = args.tables.iter().chain(&args.atmosphere).map(PathBuf::as_path).chain(given);
    let read = read.chain(args.sky.as_deref().map(Path::new));
    output::keeps(read, [&args.out, &args.plot, &args.budget].into_iter().flatten())?;
    let wavelengths_um = args.bands.grid().wavelengths_um();
    let format = args.plot.as_deref().map(ChartFormat::of);
    let resolve = |text: &String| Spectrum::resolve(&spectrum_source(text), Path::new(""));
    let beside = args.beside.iter().map(resolve).collect::<Result<Vec<_>, _>>()?;
    let beside = spectra::drawn(&args.beside, &beside, Some(args.bands.grid().range_um()))?;
    let mut tables = Table::read_packings(&args.tables)?;
    let table = &mut tables[0];
    for given in &args.spectra {
        let Some((name, text)) = given.split_once('=') else {
            usage(&format!("{given:?}: write MATERIAL=SPECTRUM"));
        };
        let twice = |other: &&String| other.split_once('=').is_some_and(|(other, _)| other == name);
        if args.spectra.iter().filter(twice).count() > 1 {
            usage(&format!("material {name:?} is given two spectra"));
        }
        let names: Vec<String> = table.materials.iter().map(|m| m.name.clone()).collect();
        let Some(material) = table.materials.iter_mut().find(|m| m.name == name) else {
            usage(&format!("the table has no material {name:?}, but {}", names.join(", ")));
        };
        let spectrum = Spectrum::resolve(&spectrum_source(text), Path::new(""))?;
        if spectrum.is_angular() != material.spectrum.is_angular() {
            usage(&format!(
                "{given:?}: the paths were traced with {}, which sends them on in other ways; trace the scene again",
                material.spectrum
            ));
        }
        material.spectrum = spectrum;
    }
    if let Some(temperature_k) = args.temperature {
        if !(1.0..=1e4).contains(&temperature_k) {
            usage(&format!("--temperature {temperature_k} K is not within 1 to 10000 K"));
        }
        table.temperature_k = temperature_k;
        if table.lacks_order() {
            usage(&format!(
                "at {temperature_k} K the scene differs in temperature from materials that have their own, and the \
                 paths were traced without the order of their hits; trace the scene again at that temperature"
            ));
        }
    }
    if let Some(sky) = &args.sky {
        set_sky(table, sky)?;
    }
    if let Some(path) = &args.atmosphere {
        table.atmosphere = Some(Atmosphere::read(path)?);
    }
    let temperature =
        Temperature { error_k: args.assumptions.temperature_error, ..table.temperature() };
    let assumed = args.assumptions.assumed();
    let bands = signature::evaluate(&tables, &wavelengths_um)?;
    for warning in warnings::of_result(&tables, &bands, tables[0].stop.asked.tolerance, None) {
        eprintln!("warning: {warning}");
    }
    match &args.out {
        Some(path) => signature::write_csv(&bands, temperature, assumed, path)?,
        None => print(&signature::csv_text(&bands, temperature, assumed))?,
    }
    if let Some(path) = &args.budget {
        let budget = Budget::new(&tables, &bands, Origin::of_tables(tables.len()))?;
        output::bytes(path, budget.csv_text().as_bytes())?;
    }
    eprint!("{}", terminal::retrieval(&report::retrieval(&tables[0], &bands, assumed)));
    if let (Some(path), Some(format)) = (&args.plot, format) {
        let versions = BTreeMap::from([("soilsig".into(), env!("CARGO_PKG_VERSION").into())]);
        let mut chart = report::chart(&tables[0].scene, &[(&tables, &bands)], &versions);
        chart.curves.extend(beside.curves);
        chart.caption.extend(beside.caption);
        chart.caption.extend(beside.credit);
        let svg = plot::emissivity_svg(&chart)?;
        format.write(&svg, path)?;
    }
    Ok(())
}

/// Gives a table another sky, if it kept of its paths what that needs.
fn set_sky(table: &mut Table, text: &str) -> Result<(), Error> {
    if let Ok(kelvin) = text.parse::<f64>() {
        let sky = Sky::Isotropic(kelvin);
        if let Some(problem) = sky.problem() {
            usage(&format!("--sky {problem}"));
        }
        (table.sky_temperature_k, table.sky_radiance) = (Some(sky), None);
        return Ok(());
    }
    let sky = SkyTable::read(Path::new(text))?;
    if sky.is_by_zenith() && table.histogram.kept.zeniths == 1 {
        usage(&format!(
            "{text} depends on the zenith angle, and the paths were traced without it; trace the scene again with \
             such a sky"
        ));
    }
    (table.sky_temperature_k, table.sky_radiance) = (None, Some(sky));
    Ok(())
}
