//! The text of a result: the answer first.

use super::limit::{self, Cost};
use super::{Reached, details, warnings};
use crate::radiometry::Retrieved;
use crate::scene::SoilShares;
use crate::signature::Window;
use crate::signature::in_bands::InBand;
use crate::spectrum::Mode;
use crate::spectrum::features::{RESTSTRAHLEN_WINDOW_UM, TRANSPARENCY_WINDOW_UM, window_mean};

/// Columns that a name may take before the others shift.
pub const WIDEST_NAME: usize = 60;

/// A scene's name, its numbers and, after a run of the pipeline, its cost.
pub type Scene<'a> = (&'a str, &'a Reached, Option<Cost>);

/// A block for each scene: its emissivity with the total uncertainty, what limits it, warnings and,
/// if asked, all details. What facets mean is said once.
pub fn blocks(scenes: &[Scene], with_details: bool) -> String {
    let width = scenes.iter().map(|(name, ..)| name.len()).max().unwrap_or(0).min(WIDEST_NAME);
    let mut notes = Vec::new();
    let block = |(name, r, cost): &Scene| {
        let beds = beds(r);
        let windows = r.windows.iter().map(|w| (w.emissivity, w.half_width_95, span(w)));
        let mut lines = vec![format!("{}, {beds}", answer(windows))];
        lines.extend(limit::line(r, *cost));
        for note in facets(r).filter(|note| !notes.contains(note)).collect::<Vec<_>>() {
            notes.push(note);
            lines.push(note.into());
        }
        lines.extend(r.soil.as_ref().map(SoilShares::line));
        lines.extend(warnings::lines(r).into_iter().map(|warning| format!("warning: {warning}")));
        if with_details {
            lines.extend(details::lines(r));
        }
        // A name of a stranger's scene is no line of its own.
        let name = name.replace('\n', " ");
        format!("{name:width$}   {}\n", lines.join(&format!("\n{:width$}   ", "")))
    };
    scenes.iter().map(block).collect::<Vec<_>>().concat()
}

/// What a result is the mean of.
pub(super) fn beds(r: &Reached) -> String {
    match r.packings {
        _ if !r.is_drawn() => "this geometry".to_owned(),
        1 => "one bed".to_owned(),
        beds => format!("{beds} beds"),
    }
}

/// The emissivity of some windows, each with its half-width and its wavelengths.
pub fn answer(windows: impl Iterator<Item = (f64, f64, String)>) -> String {
    let windows = windows.map(|(mean, half_width, span)| {
        let [mean, of] = [mean, half_width].map(|x| number(x, half_width));
        format!("{mean} +- {of} ({span})")
    });
    format!("emissivity {}, 95 %", windows.collect::<Vec<_>>().join(", "))
}

/// Bands of a sensor that a terminal shows.
const MOST_SHOWN: usize = 16;

/// A line for each band of sensors that have few.
pub fn in_bands(bands: &[InBand]) -> String {
    let of_sensor = bands.chunk_by(|a, b| a.sensor == b.sensor);
    let shown = of_sensor.filter(|bands| bands.len() <= MOST_SHOWN).flatten();
    let line = |band: &InBand| {
        let seen = band.seen?;
        let [mean, of] = seen.emissivity.map(|x| number(x, seen.emissivity[1]));
        let brightness = seen.brightness_temperature_k.map_or(String::new(), |[k, of]| {
            format!(", brightness temperature {k:.2} +- {of:.2} K")
        });
        let InBand { sensor, band, centre_um, .. } = band;
        Some(format!(
            "{sensor} {band} ({centre_um:.2} um): emissivity {mean} +- {of}{brightness}\n"
        ))
    };
    shown.filter_map(line).collect()
}

/// The emissivity as retrieved: over the windows without masked bands, else over all bands that are
/// not masked. Their errors are taken as fully correlated.
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
pub fn number(x: f64, half_width: f64) -> String {
    let decimals = match half_width {
        h if !(5e-6..0.002).contains(&h) => 3,
        h if h >= 2e-4 => 4,
        _ => 5,
    };
    format!("{x:.decimals$}")
}

/// A line for each kind of facets that limits the meaning of a result.
pub(super) fn facets(r: &Reached) -> impl Iterator<Item = &'static str> {
    let notes = [
        (
            Mode::Library,
            "facets by powders' spectra make the level too high where dust is thick (docs: facets)",
        ),
        (Mode::Inverted, "facets are inverted from powders' spectra by a pure bed (docs: facets)"),
        (
            Mode::Fresnel,
            "facets are mirrors: valid where grains let no light through (docs: facets)",
        ),
        (
            Mode::Refractive,
            "light passes through the grains, by rays: wave optics is left out (docs: refraction)",
        ),
        (Mode::Mix, "facets bear patches of several kinds, mixed by area (docs: facets)"),
    ];
    let is_used = |mode| r.facets.values().any(|facets| facets.mode == mode);
    notes.into_iter().filter(move |(mode, _)| is_used(*mode)).map(|(_, note)| note)
}
