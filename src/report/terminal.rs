//! The text of a result: the answer first.

use super::limit::{self, Cost};
use super::{Reached, details, warnings};
use crate::radiometry::Retrieved;
use crate::signature::Window;
use crate::spectrum::Mode;
use crate::spectrum::features::{RESTSTRAHLEN_WINDOW_UM, TRANSPARENCY_WINDOW_UM, window_mean};

/// The block of one scene: its emissivity with the total uncertainty, what limits it, warnings and,
/// if asked, all details. Names of several scenes are padded to one width.
pub fn block(
    name: &str,
    width: usize,
    r: &Reached,
    cost: Option<Cost>,
    with_details: bool,
) -> String {
    let beds = match r.packings {
        _ if !r.is_drawn() => "this geometry".to_owned(),
        1 => "one bed".to_owned(),
        beds => format!("{beds} beds"),
    };
    let windows = |w: &Window| (w.emissivity, w.half_width_95, span(w));
    let mut lines = vec![format!("{}, {beds}", answer(r.windows.iter().map(windows)))];
    lines.extend(limit::line(r, cost));
    lines.extend(facets(r).into_iter().map(Into::into));
    lines.extend(warnings::lines(r).into_iter().map(|warning| format!("warning: {warning}")));
    if with_details {
        lines.extend(details::lines(r));
    }
    let indent = format!("\n{:width$}   ", "");
    format!("{name:width$}   {}\n", lines.join(&indent))
}

/// The emissivity of some windows, each with its half-width and its wavelengths.
pub fn answer(windows: impl Iterator<Item = (f64, f64, String)>) -> String {
    let windows = windows.map(|(mean, half_width, span)| {
        let [mean, of] = [mean, half_width].map(|x| number(x, half_width));
        format!("{mean} +- {of} ({span})")
    });
    format!("emissivity {}, 95 %", windows.collect::<Vec<_>>().join(", "))
}

/// The same for retrieved emissivities: over the windows without masked bands, else over all bands
/// that are not masked. Their errors are taken as fully correlated.
pub fn retrieved(bands: &[Retrieved]) -> String {
    let um: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let column = |part: usize| -> Vec<f64> {
        bands.iter().map(|band| band.emissivity.map_or(f64::NAN, |of| of[part])).collect()
    };
    let columns = [column(0), column(1)];
    let over = |window| {
        let [mean, error] = columns.each_ref().map(|column| window_mean(&um, column, &window));
        let span = format!("{}-{} um", window.start(), window.end());
        Some((mean.filter(|mean| mean.is_finite())?, 1.96 * error?, span))
    };
    let mut found: Vec<_> =
        [RESTSTRAHLEN_WINDOW_UM, TRANSPARENCY_WINDOW_UM].into_iter().filter_map(over).collect();
    if found.is_empty() {
        let told: Vec<[f64; 2]> = bands.iter().filter_map(|band| band.emissivity).collect();
        if told.is_empty() {
            return "no emissivity: all bands are masked".into();
        }
        let mean = |part: usize| told.iter().map(|of| of[part]).sum::<f64>() / told.len() as f64;
        found.push((mean(0), 1.96 * mean(1), format!("{} of {} bands", told.len(), bands.len())));
    }
    answer(found.into_iter())
}

/// The wavelengths of a window.
pub(super) fn span(window: &Window) -> String {
    let Window { from_um, to_um, .. } = window;
    if from_um == to_um { format!("{from_um} um") } else { format!("{from_um}-{to_um} um") }
}

/// A number with as many decimals as its half-width gives a meaning to.
pub(super) fn number(x: f64, half_width: f64) -> String {
    let decimals = match half_width {
        h if !(5e-6..0.002).contains(&h) => 3,
        h if h >= 2e-4 => 4,
        _ => 5,
    };
    format!("{x:.decimals$}")
}

/// A line for each kind of facets that limits what a result means.
fn facets(r: &Reached) -> Vec<&'static str> {
    [
        (
            Mode::Library,
            "facets have library spectra: those of powders make the level too high where dust is \
             thick (docs: facets)",
        ),
        (Mode::Inverted, "facets are inverted from powder spectra by a pure bed (docs: facets)"),
        (
            Mode::Fresnel,
            "facets are mirrors by optical constants: valid for grains that let no light through \
             (docs: facets)",
        ),
    ]
    .into_iter()
    .filter(|(mode, _)| r.facets.values().any(|facets| facets.mode == *mode))
    .map(|(_, line)| line)
    .collect()
}
