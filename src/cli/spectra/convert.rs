//! `soilsig spectra convert`.

use std::path::PathBuf;

use super::{Input, wavelengths};
use crate::cli::arguments::{file_of, positive};
use crate::cli::{Context, usage};
use crate::scene::Grid;
use crate::spectrum::format;
use crate::spectrum::resample::{Response, resampling_error};
use crate::spectrum::{Spectrum, SpectrumError};
use crate::support::error::Error;
use crate::support::output;

/// Writes spectra in another format or on other wavelengths, and prints the error of that
#[derive(clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    input: Input,
    /// File to write: .csv (one spectrum), .sli with its .hdr, or .ems
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Distance between wavelengths, um; without it files keep their own, others have 0.01
    #[arg(long, value_name = "UM")]
    step: Option<f64>,
    /// Means over bands with a triangular slit of this full width at half maximum, um
    #[arg(long, value_name = "UM", requires = "step", value_parser = positive)]
    width: Option<f64>,
    /// Means over the bands of a sensor: response functions, two columns (um, response) each
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["step", "width"])]
    response: Vec<PathBuf>,
}

pub(super) fn run(args: &Args, context: &Context) -> Result<(), Error> {
    let files = args.input.spectra.iter().filter_map(|text| file_of(text));
    let files = files.chain(args.response.iter().map(PathBuf::as_path));
    let read = files.flat_map(format::files);
    output::keeps(read, [args.out.clone(), args.out.with_extension("hdr")])?;
    let spectra = args.input.read(args.width.unwrap_or(0.0))?;
    for spectrum in &spectra {
        if let Spectrum::Tabulated(points) = spectrum {
            for warning in &points.warnings {
                context.monitor.say(&format!("warning: {}: {warning}", points.file));
            }
        }
    }
    let (wavelength_um, curves) = if args.response.is_empty() {
        args.on_grid(&spectra, context)?
    } else {
        args.in_bands(&spectra, context)?
    };
    let names = spectra.iter().map(|spectrum| spectrum.name().to_owned());
    format::write(&args.out, &wavelength_um, &names.zip(curves).collect::<Vec<_>>())
}

impl Args {
    /// Values at wavelengths, or means over a slit.
    fn on_grid(
        &self,
        spectra: &[Spectrum],
        context: &Context,
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let um = match self.step {
            Some(step) => self.grid(spectra, step)?,
            None => wavelengths(&spectra[0], self.input.range)?,
        };
        let mut curves = Vec::new();
        for spectrum in spectra {
            if self.step.is_none()
                && let Spectrum::Tabulated(points) = spectrum
            {
                if wavelengths(spectrum, self.input.range)? != um {
                    return Err(usage(
                        "the spectra have different wavelengths: give common ones by --step",
                    ));
                }
                // No format that is written can mark missing values.
                let within = |gap: &&[f64; 2]| um[0] < gap[1] && gap[0] < um[um.len() - 1];
                if let Some(&gap_um) = points.gaps_um.iter().find(within) {
                    let needed_um = f64::midpoint(gap_um[0], gap_um[1]);
                    let of = points.file.clone();
                    return Err(SpectrumError::Gap { of, needed_um, gap_um }.into());
                }
            }
            let curve = match self.width {
                None => format::sampled(spectrum, &um)?,
                Some(width) => {
                    let slits = um.iter().map(|&um| Response::triangle(um, width));
                    band_means(spectrum, &um, &slits.collect::<Vec<_>>(), context)?
                }
            };
            if self.step.is_some() && um.len() > 1 {
                let error = resampling_error(spectrum, &um, &curve)?;
                context.monitor.say(&format!(
                    "{}: resampling error RMS {:.2e}, largest {:+.2e} at {} um",
                    spectrum.name(),
                    error.rms,
                    error.largest,
                    error.at_um
                ));
            }
            curves.push(curve);
        }
        Ok((um, curves))
    }

    /// The range, else what all spectra hold, less the reach of a slit at both ends.
    fn grid(&self, spectra: &[Spectrum], step: f64) -> Result<Vec<f64>, Error> {
        let margin = self.width.unwrap_or(0.0);
        let (from, to) = self.input.range.unwrap_or_else(|| {
            let ranges = spectra.iter().filter_map(Spectrum::range_um);
            let [from, to] = ranges
                .reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])])
                .map_or(Grid::PAPER.range_um().into(), |[from, to]| [from + margin, to - margin]);
            ((from / step).ceil() * step, to)
        });
        let grid = Grid::new(from, to, step).map_err(|problem| usage(&problem))?;
        Ok(grid.wavelengths_um())
    }

    /// Means over the bands of a sensor, at their centroids.
    fn in_bands(
        &self,
        spectra: &[Spectrum],
        context: &Context,
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
        let mut bands: Vec<Response> =
            self.response.iter().map(|path| Response::read(path)).collect::<Result<_, _>>()?;
        bands.sort_by(|a, b| a.centre_um().total_cmp(&b.centre_um()));
        let um: Vec<f64> = bands.iter().map(Response::centre_um).collect();
        let means = spectra.iter().map(|spectrum| band_means(spectrum, &um, &bands, context));
        let means = means.collect::<Result<_, _>>()?;
        Ok((um, means))
    }
}

/// Means over bands. Prints their largest difference from the values at the centres.
fn band_means(
    spectrum: &Spectrum,
    um: &[f64],
    bands: &[Response],
    context: &Context,
) -> Result<Vec<f64>, SpectrumError> {
    let means: Vec<f64> =
        bands.iter().map(|band| band.band_mean(spectrum)).collect::<Result<_, _>>()?;
    let points = format::sampled(spectrum, um)?;
    let differences = means.iter().zip(&points).map(|(mean, point)| mean - point);
    let largest = differences.zip(um).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    if let Some((difference, um)) = largest {
        context.monitor.say(&format!(
            "{}: a band's mean differs from the value at its centre by {difference:+.2e} at most, \
             at {um} um",
            spectrum.name()
        ));
    }
    Ok(means)
}
