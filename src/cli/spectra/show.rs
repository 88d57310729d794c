//! `soilsig spectra show`.

use std::fmt::Write as _;

use super::{Input, wavelengths};
use crate::cli::Context;
use crate::spectrum::features::{Windows, features};
use crate::spectrum::{Spectrum, format};
use crate::support::error::Error;

pub(super) fn run(input: &Input, context: &Context) -> Result<(), Error> {
    let mut text = String::new();
    for spectrum in input.read(0.0)? {
        text += &describe(&spectrum);
        let um = wavelengths(&spectrum, input.range)?;
        let emissivity = format::sampled(&spectrum, &um)?;
        let found = features(&um, &emissivity, Windows::of([&spectrum]));
        let mineral = found.mineral.as_deref().unwrap_or_default();
        for (what, mean) in [
            ("mean over 8-9.5 um", found.mean_8_to_9p5_um),
            ("mean over 10-12 um", found.mean_10_to_12_um),
        ] {
            if let Some(mean) = mean {
                let _ = writeln!(text, "  {what}: {mean:.4}");
            }
        }
        for extremum in found.extrema() {
            let _ = writeln!(
                text,
                "  extremum of {mineral}: {:.4} at {:.3} um",
                extremum.emissivity, extremum.wavelength_um
            );
        }
    }
    context.print(&text)
}

/// What a spectrum is and its range, in one line.
pub(super) fn summary(spectrum: &Spectrum) -> String {
    match spectrum {
        Spectrum::Constant(value) => format!("{value} at every wavelength"),
        Spectrum::Builtin(_, form) => {
            let p = &form.parameters;
            format!(
                "{}; {} numbers fitted, RMS {} ({} on a sample not fitted), {}-{} um",
                p.title,
                p.fitted.len(),
                p.rms,
                p.rms_other_sample,
                p.range_um[0],
                p.range_um[1]
            )
        }
        Spectrum::Refractive(_, crystal) => format!(
            "{}; facets that let light through, nothing fitted, {}-{} um",
            crystal.title, crystal.range_um[0], crystal.range_um[1]
        ),
        Spectrum::Fresnel(_, crystal) => format!(
            "{}; specular facets, nothing fitted, {}-{} um",
            crystal.title, crystal.range_um[0], crystal.range_um[1]
        ),
        Spectrum::Tabulated(points) => {
            let [from, to] = points.range_um();
            format!("{} points, {from}-{to} um", points.wavelength_um.len())
        }
        Spectrum::Inverted(powder, _) => {
            format!("facets of a bed with this spectrum: {}", summary(powder))
        }
        Spectrum::Mix(_) => "patches side by side, mixed by area".into(),
    }
}

/// A spectrum's name, source and warnings.
pub(super) fn describe(spectrum: &Spectrum) -> String {
    let mut text = format!("{}\n  {}\n", spectrum.name(), summary(spectrum));
    match spectrum {
        Spectrum::Builtin(_, form) => {
            let _ = writeln!(text, "  source: {}", form.parameters.citation);
        }
        Spectrum::Fresnel(_, crystal) | Spectrum::Refractive(_, crystal) => {
            let _ = writeln!(text, "  source: {}", crystal.citation);
            text += "  the numbers below are the hemispherical emissivity of one facet\n";
        }
        Spectrum::Tabulated(points) => {
            let _ = writeln!(text, "  file: {}", points.file);
            for [from, to] in &points.gaps_um {
                let _ = writeln!(text, "  no values between {from} and {to} um");
            }
            for warning in &points.warnings {
                let _ = writeln!(text, "  warning: {warning}");
            }
        }
        Spectrum::Inverted(_, pure_bed) => {
            let _ = writeln!(
                text,
                "  pure bed: {}, standard error {:.4}",
                pure_bed.title, pure_bed.standard_error
            );
        }
        Spectrum::Mix(mix) => {
            for (share, spectrum) in mix.components() {
                let _ = writeln!(text, "  {share} {}: {}", spectrum.name(), summary(spectrum));
            }
        }
        Spectrum::Constant(_) => {}
    }
    text
}
