//! `soilsig spectra check`.

use std::fmt::Write as _;

use super::Input;
use super::show::describe;
use crate::cli::Context;
use crate::cli::arguments::spectrum_source;
use crate::scene::SpectrumSource;
use crate::spectrum::Spectrum;
use crate::spectrum::format::Format;
use crate::support::error::Error;

pub(super) fn run(input: &Input, context: &Context) -> Result<(), Error> {
    for given in &input.spectra {
        let spectra = input.read_one(given, 0.0)?;
        let mut text = String::new();
        if let SpectrumSource::File(path) = spectrum_source(given)? {
            let _ = writeln!(text, "{given}: {}", Format::of(&path)?.name());
        }
        for spectrum in &spectra {
            text += &describe(spectrum);
            if let Spectrum::Tabulated(points) = spectrum
                && let Some((error, um)) = points.sampling_error(points.range_um())
            {
                let _ = writeln!(
                    text,
                    "  error of interpolation: about {error:.1e}, largest near {um} um"
                );
            }
        }
        context.print(&text)?;
    }
    Ok(())
}
