//! What speaks against a result that can still be given: cause and remedy, for the record and in words.
//!
//! Whatever makes a result wrong by more than its interval says is refused or stands here. `soilsig stress` drives each
//! of them from where it is harmless to where it is not (docs/stability.md).

use crate::radiometry::Lit;
use crate::signature::Band;
use crate::spectrum::Spectrum;
use crate::table::Table;
use crate::table::warning::Warning;

/// What speaks against the signature of packings of one recipe, their beds included; `floor_effect` is what a black and a
/// white floor differ by. Of each kind the first.
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
        if let Spectrum::Tabulated(points) = &material.spectrum
            && let Some((error, at_um)) = points.sampling_error(span)
            && error > tolerance
        {
            let spectrum = points.file.clone();
            warnings.push(Warning::Undersampled { spectrum, error, at_um });
        }
    }
    warnings.extend(
        grazing_bins(table, bands)
            .filter(|(_, error)| *error > tolerance)
            .map(|(zenith_deg, error)| Warning::GrazingBins { zenith_deg, error }),
    );
    warnings.extend(
        zenith_bins(table, bands)
            .filter(|(_, error)| *error > tolerance)
            .map(|(zenith_deg, error)| Warning::ZenithBins { zenith_deg, error }),
    );
    let mut kinds = Vec::new();
    warnings.retain(|warning| {
        let kind = std::mem::discriminant(warning);
        let is_new = !kinds.contains(&kind);
        kinds.push(kind);
        is_new
    });
    warnings
}

/// The view's zenith angle, and half of what the sky's radiance changes by from its bin to the next where mirrors show it,
/// in the worst band.
fn zenith_bins(table: &Table, bands: &[Band]) -> Option<(f64, f64)> {
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
    let error = lit.iter().map(change).filter(|error| error.is_finite()).max_by(f64::total_cmp)?;
    Some((table.view.zenith_deg, error))
}

/// The view's zenith angle, and half of what the reflectance of any facet by angle changes by within the bin of its
/// cosine, in the worst band.
fn grazing_bins(table: &Table, bands: &[Band]) -> Option<(f64, f64)> {
    let cosines = f64::from(table.histogram.kept.cosines);
    let bin = (table.view.zenith_deg.to_radians().cos() * cosines).floor().min(cosines - 1.0);
    let change = |spectrum: &Spectrum, um: f64| {
        let at = |edge: f64| spectrum.reflectance_at(um, edge / cosines).unwrap_or(0.0);
        (at(bin) - at(bin + 1.0)).abs() / 2.0
    };
    let angular = table.materials.iter().map(|m| &m.spectrum).filter(|s| s.is_angular());
    angular
        .flat_map(|spectrum| bands.iter().map(move |b| (spectrum, b.wavelength_um)))
        .map(|(spectrum, um)| change(spectrum, um))
        .max_by(f64::total_cmp)
        .map(|error| (table.view.zenith_deg, error))
}
