//! What a result says of itself: numbers for the record, a chart, words.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;

use crate::error::Error;
use crate::features::features;
use crate::output;
use crate::plot::{self, Chart, Curve};
use crate::record::{Reached, Record};
use crate::signature::{Band, reflectances};
use crate::spectrum::Spectrum;
use crate::table::Table;

/// Pixels of a PNG in one unit of the chart.
pub const PIXELS_PER_UNIT: f32 = 2.0;

/// Share of paths inside a solid from which the user is told. Where dust is seated flush some 1e-4 are
/// lost in the crevices, to rounding; more tells of overlap.
const INSIDE_NOTABLE: f64 = 1e-3;

/// The numbers of a traced scene.
pub fn reached(table: &Table, bands: &[Band]) -> Reached {
    let paths = table.paths as f64;
    let share = |count: u64| count as f64 / paths;
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let emissivity: Vec<f64> = bands.iter().map(|band| band.emissivity).collect();
    Reached {
        half_width: table.stop.half_width,
        widest_at_um: table.stop.widest_at_um,
        trapped_half_width: table.stop.trapped,
        tolerance: table.stop.tolerance,
        tolerance_reached: table.stop.reached,
        paths: table.paths,
        seen_first: table
            .materials
            .iter()
            .map(|m| (m.name.clone(), m.first_hits as f64 / table.met() as f64))
            .collect(),
        missed: share(table.missed),
        escaped_downward: share(table.escaped_downward),
        trapped: share(table.trapped.iter().map(|(_, count)| count).sum()),
        inside: share(table.inside.values().sum()),
        floor_effect: floor_effect(table, bands),
        features: features(&wavelengths, &emissivity),
    }
}

/// Most that any band changes between a black and a white floor: what is left of the tray in the
/// result. `None` where there is no floor, or where something else is made of its material.
fn floor_effect(table: &Table, bands: &[Band]) -> Option<f64> {
    let floor = table.floor?;
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let spectra: Vec<&Spectrum> = table.materials.iter().map(|m| &m.spectrum).collect();
    let reflectances = reflectances(&spectra, &wavelengths).ok()?;
    let effect = reflectances.into_par_iter().map(|mut reflectance| {
        let [black, white] = [0.0, 1.0].map(|rho| {
            reflectance[floor] = rho;
            table.weight(&reflectance).mean
        });
        white - black
    });
    Some(effect.reduce(|| 0.0, f64::max))
}

/// The chart of one scene's signature or of several.
pub fn chart(
    title: &str,
    signatures: &[(&Table, &[Band])],
    versions: &BTreeMap<String, String>,
) -> Chart {
    let curves = signatures.iter().map(|(table, bands)| Curve::of(&table.scene, bands)).collect();
    let (table, _) = signatures[0];
    let paths = signatures.iter().map(|(table, _)| table.paths);
    let (least, most) = (paths.clone().min().unwrap_or(0), paths.max().unwrap_or(0));
    let paths = if least == most { format!("{least}") } else { format!("{least}-{most}") };
    let mut caption = vec![format!(
        "Traced, Lambertian facets, {} K, view {}° from nadir, {paths} paths. The bands are the noise \
         of the rays on one packing; packings differ by more.",
        table.temperature_k, table.view.zenith_deg,
    )];
    let mut spectra: Vec<String> = Vec::new();
    for material in &table.materials {
        let text = material.spectrum.to_string();
        if !spectra.contains(&text) {
            spectra.push(text);
        }
    }
    caption.push(format!("Facets: {}.", spectra.join("; ")));
    let versions: Vec<String> = [("soilsig", "soilsig"), ("blender", "Blender")]
        .iter()
        .filter_map(|(key, name)| Some(format!("{name} {}", versions.get(*key)?)))
        .collect();
    caption.push(format!("{}, seed {}", versions.join(", "), table.seed));
    Chart { title: title.to_owned(), caption, curves, mark_features: true }
}

/// Writes a chart as `STEM.svg` and `STEM.png`.
pub fn draw(chart: &Chart, stem: &Path) -> Result<(), Error> {
    let svg = plot::emissivity_svg(chart)?;
    output::bytes(&stem.with_extension("svg"), svg.as_bytes())?;
    let png = plot::png(&svg, PIXELS_PER_UNIT)?;
    output::bytes(&stem.with_extension("png"), &png)?;
    Ok(())
}

/// What the interval does not hold.
pub const ONE_PACKING: &str = "The interval is the noise of the rays on this one packing; the spread \
    between packings is larger and is not part of it.\n";

/// A record in words, for the terminal.
pub fn words(record: &Record, out: &Path) -> String {
    let mut text = String::new();
    for (name, reached) in &record.reached {
        let _ = write!(text, "{name}: {}", reached_words(reached));
    }
    text.push_str(ONE_PACKING);
    let seconds: f64 = record.stages.iter().map(|stage| stage.seconds).sum();
    let _ = writeln!(text, "Result in {} ({seconds:.1} s)", out.display());
    text
}

/// What a trace reached, in words.
pub fn reached_words(r: &Reached) -> String {
    let mut text = format!(
        "each band's emissivity within {:.4} (95 %; widest at {} um; {} asked), {} paths\n",
        r.half_width, r.widest_at_um, r.tolerance, r.paths
    );
    let seen: Vec<String> =
        r.seen_first.iter().map(|(name, share)| format!("{name} {:.1} %", 100.0 * share)).collect();
    let _ = writeln!(text, "  seen from above: {}", seen.join(", "));
    if let Some(d) = r.features.reststrahlen {
        let _ = writeln!(
            text,
            "  reststrahlen: troughs {:.3} at {} um and {:.3} at {} um, peak {:.3} at {} um, contrast {:.3}",
            d.short_trough.emissivity,
            d.short_trough.wavelength_um,
            d.long_trough.emissivity,
            d.long_trough.wavelength_um,
            d.peak.emissivity,
            d.peak.wavelength_um,
            d.contrast
        );
    }
    if let Some(effect) = r.floor_effect {
        let _ = writeln!(
            text,
            "  between a black and a white floor no band changes by more than {effect:.4}"
        );
    }
    if r.trapped_half_width > r.tolerance / 100.0 {
        let _ = writeln!(
            text,
            "  {:.2} % of the paths were given up; they leave {:.5} of the half-width open",
            100.0 * r.trapped,
            r.trapped_half_width
        );
    }
    if !r.tolerance_reached {
        let remedy = if r.trapped_half_width < r.tolerance / 2.0 {
            "raise --max-paths"
        } else {
            "paths that were given up leave too much open, and more paths do not help: reflectances are near 1"
        };
        let _ = writeln!(text, "  warning: the tolerance was not reached: {remedy}");
    }
    for (share, what) in [
        (r.missed, "of the sensor's rays meet nothing and are left out"),
        (r.escaped_downward, "of the paths leave past the target's lower side: give it a floor"),
    ] {
        if share > 0.0 {
            let _ = writeln!(text, "  warning: {:.2} % {what}", 100.0 * share);
        }
    }
    if r.inside > INSIDE_NOTABLE {
        let _ = writeln!(
            text,
            "  warning: {:.2} % of the paths came to be inside a solid: solids overlap",
            100.0 * r.inside
        );
    }
    text
}
