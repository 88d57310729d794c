//! `soilsig spectra`: lists, shows, plots, converts and checks spectra.

mod check;
mod convert;
mod list;
mod plot;
mod show;

use std::path::PathBuf;

use super::arguments::{range, spectrum, spectrum_source};
use super::{Context, Outcome, usage};
use crate::scene::{Grid, SpectrumSource};
use crate::spectrum::format::{self, Reading, Unit};
use crate::spectrum::{Quantity, Spectrum};
use crate::support::error::Error;

pub(super) use plot::drawn;

/// Lists, shows, plots, converts and checks spectra
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    /// The shipped spectra
    List,
    /// A spectrum's source, range and features
    Show(Input),
    Plot(plot::Args),
    Convert(convert::Args),
    /// Reads files as a scene would; prints their content and warnings
    Check(Input),
}

/// Spectra, and how their files are read.
#[derive(clap::Args)]
struct Input {
    /// A shipped spectrum's name, fresnel:CONSTANTS, inverted: before a powder's,
    /// mix:SHARE*SPECTRUM+SHARE*SPECTRUM, or a file: ECOSTRESS, ASTER or USGS text, JCAMP-DX, ENVI
    /// .sli, DIRSIG .ems, columns of text
    #[arg(required = true, value_name = "SPECTRUM")]
    spectra: Vec<String>,
    /// Only the spectrum of this name, of a file that holds several
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Meaning of the values, where the file does not say
    #[arg(long, value_name = "QUANTITY")]
    quantity: Option<Quantity>,
    /// Unit of the wavelengths, where the file does not say
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    /// The file of wavelengths that belongs to USGS text
    #[arg(long, value_name = "FILE")]
    wavelengths: Option<PathBuf>,
    /// Only these wavelengths, um
    #[arg(long, value_name = "FROM-TO", value_parser = range)]
    range: Option<(f64, f64)>,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    match &args.command {
        Command::List => list::run(context)?,
        Command::Show(input) => show::run(input, context)?,
        Command::Plot(args) => plot::run(args, context)?,
        Command::Convert(args) => convert::run(args, context)?,
        Command::Check(input) => check::run(input, context)?,
    }
    Ok(None)
}

impl Input {
    /// Reads all, with a margin around the range, um.
    fn read(&self, margin_um: f64) -> Result<Vec<Spectrum>, Error> {
        let each = self.spectra.iter().map(|text| self.read_one(text, margin_um));
        Ok(each.collect::<Result<Vec<_>, _>>()?.concat())
    }

    fn read_one(&self, text: &str, margin_um: f64) -> Result<Vec<Spectrum>, Error> {
        let SpectrumSource::File(path) = spectrum_source(text)? else {
            return Ok(vec![spectrum(text)?]);
        };
        let reading = Reading {
            quantity: self.quantity,
            unit: self.unit,
            wavelengths: self.wavelengths.clone(),
            range_um: self.range.map(|(from, to)| [from - margin_um, to + margin_um]),
            is_response: false,
        };
        let mut spectra = format::read(&path, &reading)?;
        if let Some(name) = &self.name {
            let names: Vec<String> = spectra.iter().filter_map(|s| s.name.clone()).collect();
            spectra.retain(|spectrum| spectrum.name.as_deref() == Some(name));
            if spectra.is_empty() {
                return Err(usage(&format!(
                    "{text} has no spectrum {name:?}; it has {}",
                    names.join(", ")
                )));
            }
        }
        Ok(spectra.into_iter().map(Spectrum::Tabulated).collect())
    }
}

/// A file's own wavelengths within a range, else every 10 nm of it.
fn wavelengths(spectrum: &Spectrum, range: Option<(f64, f64)>) -> Result<Vec<f64>, Error> {
    if let (Spectrum::Tabulated(points), None) = (spectrum, range) {
        return Ok(points.wavelength_um.clone());
    }
    let (from, to) =
        range.unwrap_or_else(|| spectrum.range_um().map_or(Grid::PAPER.range_um(), Into::into));
    if let Spectrum::Tabulated(points) = spectrum {
        let within = |um: &f64| (from..=to).contains(um);
        let inside: Vec<f64> = points.wavelength_um.iter().copied().filter(within).collect();
        if !inside.is_empty() {
            return Ok(inside);
        }
    }
    spectrum.covers([from, to])?;
    let grid = Grid::new(from, to, 0.01).map_err(|problem| usage(&problem))?;
    Ok(grid.wavelengths_um())
}
