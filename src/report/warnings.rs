//! Warnings about a result that can still be given, each with cause and remedy.
//!
//! Whatever makes a result wrong by more than its interval says is refused or warned of here.
//! `soilsig stress` drives each from harmless to wrong (docs: stability).

use super::{Reached, ToleranceOf};
use crate::radiometry::Lit;
use crate::scene::SoilShares;
use crate::signature::Band;
use crate::spectrum::{Mode, Spectrum};
use crate::support::math;
use crate::table::warning::Warning;
use crate::table::{StopReason, Table};

/// Share of paths inside a solid from which a warning is given. Where dust is seated flush, some
/// 1e-4 are lost in the crevices by rounding; more means overlap.
const INSIDE_NOTABLE: f64 = 1e-3;

/// Everything that a result warns of.
pub(super) fn lines(r: &Reached) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    if !r.tolerance_reached {
        let remedy = if r.trapped_half_width >= r.tolerance / 2.0 {
            "paths that were given up leave too much open, and more paths do not help, since \
             reflectances are near 1"
                .into()
        } else if let (ToleranceOf::Interval | ToleranceOf::Total, Some(wanted)) =
            (r.tolerance_of, r.packings_wanted)
        {
            format!("by their spread it takes {wanted} packings")
        } else if r.packings > 1 && r.tolerance_of != ToleranceOf::Rays {
            "by their spread it takes too many packings".into()
        } else {
            match r.ended_by {
                StopReason::MaxSeconds => "raise --max-seconds",
                StopReason::Paths => "ask for more --paths",
                _ => "raise --max-paths",
            }
            .into()
        };
        lines.push(format!(
            "the tolerance was not reached: within {:.4} at {} um, {} asked; {remedy}",
            r.half_width, r.widest_at_um, r.tolerance
        ));
    }
    if !r.not_valid_um.is_empty() {
        let range = |[from, to]: &[f64; 2]| {
            if from == to { format!("{from}") } else { format!("{from}-{to}") }
        };
        let at = r.not_valid_um.iter().map(range).collect::<Vec<_>>().join(", ");
        let is_used = |mode| r.facets.values().any(|facets| facets.mode == mode);
        if is_used(Mode::Fresnel) {
            lines.push(format!(
                "fresnel facets do not hold at {at} um: grains let over 1 % of the light through, \
                 or measure below ten wavelengths"
            ));
        }
        if is_used(Mode::Refractive) {
            lines.push(format!(
                "rays do not hold at {at} um: it takes wave optics, since grains measure below ten \
                 wavelengths and their faces reflect much, or grains measure below half of one"
            ));
        }
    }
    for (share, least, what) in [
        (r.missed, 0.0, "of the sensor's rays meet nothing and are left out"),
        (r.escaped_downward, 0.0, "of the paths leave past the target's lower side: add a floor"),
        (r.inside, INSIDE_NOTABLE, "of the paths came to be inside a solid: solids overlap"),
    ] {
        if share > least {
            lines.push(format!("{:.2} % {what}", 100.0 * share));
        }
    }
    for (name, source) in &r.facets {
        lines.extend(source.warnings.iter().map(|why| format!("{name}: {why}")));
    }
    lines.extend(r.refused.iter().cloned());
    lines.extend(r.soil.as_ref().and_then(SoilShares::porosity_warning));
    lines.extend(r.warnings.iter().map(ToString::to_string));
    lines
}

/// The warnings about a signature and its beds, the first of each kind. `floor_effect` is the
/// difference between a black and a white floor.
pub fn of_result(
    packings: &[Table],
    bands: &[Band],
    tolerance: f64,
    floor_effect: Option<f64>,
) -> Vec<Warning> {
    let table = &packings[0];
    let mut warnings: Vec<Warning> = packings.iter().flat_map(|t| t.warnings.clone()).collect();
    warnings.extend(
        floor_effect.filter(|effect| *effect > tolerance).map(|effect| Warning::Floor { effect }),
    );
    let span = [bands[0].wavelength_um, bands[bands.len() - 1].wavelength_um];
    for material in &table.materials {
        let components = match &material.spectrum {
            Spectrum::Mix(mix) => mix.components().iter().map(|(s, of)| (*s, of)).collect(),
            spectrum => vec![(1.0, spectrum)],
        };
        for (share, spectrum) in components {
            if let Spectrum::Tabulated(points) = spectrum
                && let Some((error, at_um)) = points.sampling_error(span)
                && share * error > tolerance
            {
                let (spectrum, error) = (points.file.clone(), share * error);
                warnings.push(Warning::Undersampled { spectrum, error, at_um });
            }
        }
    }
    let zenith_deg = table.view.zenith_deg;
    let notable = |error: Option<f64>| error.filter(|error| *error > tolerance);
    let grazing = notable(grazing_bins(table, bands));
    warnings.extend(grazing.map(|error| Warning::GrazingBins { zenith_deg, error }));
    let zenith = notable(zenith_bins(table, bands));
    warnings.extend(zenith.map(|error| Warning::ZenithBins { zenith_deg, error }));
    let mut kinds = Vec::new();
    warnings.retain(|warning| {
        let kind = std::mem::discriminant(warning);
        let is_new = !kinds.contains(&kind);
        kinds.push(kind);
        is_new
    });
    warnings
}

/// Half the change of the sky's radiance from the view's bin to the next where mirrors show it, as
/// a share of a black body's, in the worst band.
fn zenith_bins(table: &Table, bands: &[Band]) -> Option<f64> {
    let specular = table.materials.iter().map(|m| m.specular).fold(0.0, f64::max);
    let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let lit = if specular > 0.0 { table.lit(&um).ok()? } else { Vec::new() };
    let change = |lit: &Lit| {
        let last = lit.l_sky.len() - 1;
        let bin = (table.view.zenith_deg / 90.0 * lit.l_sky.len() as f64) as usize;
        let at = |bin: usize| lit.l_sky[bin.min(last)];
        let most = (at(bin) - at(bin + 1)).abs().max((at(bin) - at(bin.saturating_sub(1))).abs());
        specular * most / 2.0 / lit.l_blackbody
    };
    lit.iter().map(change).filter(|error| error.is_finite()).max_by(f64::total_cmp)
}

/// Half the change of any angular reflectance within the bin of the view's cosine, in the worst
/// band.
fn grazing_bins(table: &Table, bands: &[Band]) -> Option<f64> {
    // Paths that were traced apart at each wavelength have no bins.
    if table.nodes.is_some() {
        return None;
    }
    let cosines = f64::from(table.histogram.kept.cosines);
    let bin = (math::cos(table.view.zenith_deg.to_radians()) * cosines).floor().min(cosines - 1.0);
    let change = |spectrum: &Spectrum, um: f64| {
        let at = |edge: f64| spectrum.reflectance_at(um, edge / cosines).unwrap_or(0.0);
        (at(bin) - at(bin + 1.0)).abs() / 2.0
    };
    let angular = table.materials.iter().map(|m| &m.spectrum).filter(|s| s.is_angular());
    angular
        .flat_map(|spectrum| bands.iter().map(move |b| (spectrum, b.wavelength_um)))
        .map(|(spectrum, um)| change(spectrum, um))
        .max_by(f64::total_cmp)
}
