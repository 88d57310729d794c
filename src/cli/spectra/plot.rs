//! `soilsig spectra plot`.

use std::path::PathBuf;

use super::{Input, wavelengths};
use crate::cli::Context;
use crate::cli::arguments::{ChartFile, spectrum_source};
use crate::draw::plot::{self, Chart, Curve};
use crate::scene::SpectrumSource;
use crate::spectrum::Spectrum;
use crate::spectrum::features::Windows;
use crate::spectrum::format::{self, Format};
use crate::support::error::Error;

/// A chart of one spectrum or several
#[derive(clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    input: Input,
    /// Chart to write: a .svg, .pdf or .png file
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Leave out title, caption and marks, for a paper
    #[arg(long)]
    bare_figure: bool,
}

pub(super) fn run(Args { input, out, bare_figure }: &Args, context: &Context) -> Result<(), Error> {
    let file = ChartFile::new(out)?;
    let Drawn { curves, mut caption, credit } =
        drawn(&input.spectra, &input.read(0.0)?, input.range)?;
    caption.extend(credit);
    let title = "Emissivity".into();
    let hatched_um = Vec::new();
    let chart = Chart { title, caption, curves, hatched_um, bare: *bare_figure };
    file.write(&plot::emissivity_svg(&chart)?)?;
    context.print(&format!("chart in {}\n", out.display()))
}

/// Spectra as a chart shows them.
pub(in crate::cli) struct Drawn {
    pub curves: Vec<Curve>,
    /// A line for each.
    pub caption: Vec<String>,
    /// The credit that a spectral library asks for.
    pub credit: Option<String>,
}

/// The curves of spectra, and their captions. `given` are their words on the command line.
pub(in crate::cli) fn drawn(
    given: &[String],
    spectra: &[Spectrum],
    range_um: Option<(f64, f64)>,
) -> Result<Drawn, Error> {
    let mut drawn = Drawn { curves: Vec::new(), caption: Vec::new(), credit: None };
    for spectrum in spectra {
        let wavelength_um = wavelengths(spectrum, range_um)?;
        let emissivity = format::sampled(spectrum, &wavelength_um)?;
        let half_width = vec![0.0; emissivity.len()];
        let label = spectrum.name().into();
        let of_rays = Vec::new();
        let windows = Windows::of([spectrum]).clone();
        let curve = Curve { label, wavelength_um, emissivity, half_width, of_rays, windows };
        drawn.curves.push(curve);
        drawn.caption.push(match spectrum {
            Spectrum::Fresnel(..) => format!("{spectrum}: hemispherical emissivity of one facet."),
            _ => format!("{spectrum}."),
        });
    }
    let of_library = |text: &String| match spectrum_source(text) {
        Ok(SpectrumSource::File(path)) => Format::of(&path).is_ok_and(|of| of == Format::Ecostress),
        _ => false,
    };
    drawn.credit = given.iter().any(of_library).then(|| format::ECOSTRESS_CREDIT.into());
    Ok(drawn)
}
