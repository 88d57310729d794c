//! What a result says of itself: numbers for the record, a chart, words.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use rayon::prelude::*;

use crate::coverage::{self, Cover};
use crate::error::Error;
use crate::features::{Features, features};
use crate::output;
use crate::packings::{Estimate, half_width, wanted};
use crate::plot::{self, Chart, Curve};
use crate::record::{FeatureErrors, Reached, Record};
use crate::signature::{Band, evaluate, reflectances};
use crate::spectrum::Spectrum;
use crate::table::Table;

/// Pixels of a PNG in one unit of the chart.
pub const PIXELS_PER_UNIT: f32 = 2.0;

/// Share of paths inside a solid from which the user is told. Where dust is seated flush some 1e-4 are
/// lost in the crevices, to rounding; more tells of overlap.
const INSIDE_NOTABLE: f64 = 1e-3;

/// The numbers of a scene's packings; the tolerance is that of the mean over them.
pub fn reached(packings: &[Table], bands: &[Band], tolerance: f64) -> Reached {
    let paths: u64 = packings.iter().map(|table| table.paths).sum();
    let met: u64 = packings.iter().map(Table::met).sum();
    let share = |count: &dyn Fn(&Table) -> u64| {
        packings.iter().map(count).sum::<u64>() as f64 / paths as f64
    };
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let emissivity: Vec<f64> = bands.iter().map(|band| band.emissivity.emissivity).collect();
    let widest = bands
        .iter()
        .max_by(|a, b| a.emissivity.half_width.total_cmp(&b.emissivity.half_width))
        .expect("there is at least one band");
    let e = widest.emissivity;
    let rays_reached = packings.iter().all(|table| table.stop.reached);
    Reached {
        packings: packings.len(),
        half_width: e.half_width,
        widest_at_um: widest.wavelength_um,
        spread: e.spread,
        rays_share: if e.standard_error > 0.0 {
            (e.rays_standard_error / e.standard_error).powi(2)
        } else {
            1.0
        },
        trapped_half_width: e.trapped,
        packings_wanted: e.spread.and_then(|spread| wanted(spread, tolerance - e.trapped)),
        tolerance,
        tolerance_reached: e.half_width <= tolerance && (packings.len() > 1 || rays_reached),
        paths,
        seen_first: packings[0]
            .materials
            .iter()
            .enumerate()
            .map(|(i, material)| {
                let hits: u64 = packings.iter().map(|table| table.materials[i].first_hits).sum();
                (material.name.clone(), hits as f64 / met as f64)
            })
            .collect(),
        coverage: coverage::mean(&packings.iter().map(|t| &t.coverage).collect::<Vec<_>>()),
        missed: share(&|table| table.missed),
        escaped_downward: share(&|table| table.escaped_downward),
        trapped: share(&|table| table.trapped.iter().map(|(_, count)| count).sum()),
        inside: share(&|table| table.inside.iter().map(|inside| inside.paths).sum()),
        floor_effect: floor_effect(packings, bands),
        features: features(&wavelengths, &emissivity),
        features_half_width: feature_errors(packings, &wavelengths),
    }
}

/// Features of each packing alone, and how far they spread.
fn feature_errors(packings: &[Table], wavelengths_um: &[f64]) -> Option<FeatureErrors> {
    if packings.len() < 2 {
        return None;
    }
    let of_each: Vec<Features> = packings
        .iter()
        .map(|packing| {
            let bands = evaluate(std::slice::from_ref(packing), wavelengths_um).ok()?;
            let curve: Vec<f64> = bands.iter().map(|band| band.emissivity.emissivity).collect();
            Some(features(wavelengths_um, &curve))
        })
        .collect::<Option<_>>()?;
    let error = |of: &dyn Fn(&Features) -> Option<f64>| {
        half_width(&of_each.iter().map(of).collect::<Option<Vec<f64>>>()?)
    };
    Some(FeatureErrors {
        reststrahlen_contrast: error(&|f| f.reststrahlen.map(|doublet| doublet.contrast)),
        mean_8_to_9p5_um: error(&|f| f.mean_8_to_9p5_um),
        mean_10_to_12_um: error(&|f| f.mean_10_to_12_um),
    })
}

/// Most that any band changes between a black and a white floor: what is left of the tray in the
/// result. `None` where there is no floor, or where something else is made of its material.
fn floor_effect(packings: &[Table], bands: &[Band]) -> Option<f64> {
    let table = &packings[0];
    let floor = table.floor?;
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let spectra: Vec<&Spectrum> = table.materials.iter().map(|m| &m.spectrum).collect();
    let reflectances = reflectances(&spectra, &wavelengths).ok()?;
    let effect = reflectances.into_par_iter().map(|mut reflectance| {
        let [black, white] = [0.0, 1.0].map(|rho| {
            reflectance[floor] = rho;
            Estimate::new(packings, &reflectance).emissivity
        });
        black - white
    });
    Some(effect.reduce(|| 0.0, f64::max))
}

/// The chart of one scene's signature or of several.
pub fn chart(
    title: &str,
    signatures: &[(&[Table], &[Band])],
    versions: &BTreeMap<String, String>,
) -> Chart {
    let curves =
        signatures.iter().map(|(tables, bands)| Curve::of(&tables[0].scene, bands)).collect();
    let (packings, _) = signatures[0];
    let table = &packings[0];
    let paths = signatures.iter().map(|(tables, _)| tables.iter().map(|t| t.paths).sum::<u64>());
    let (least, most) = (paths.clone().min().unwrap_or(0), paths.max().unwrap_or(0));
    let paths = if least == most { format!("{least}") } else { format!("{least}-{most}") };
    let interval = match packings.len() {
        1 => "The bands are the noise of the rays on one packing; packings differ by more.".into(),
        n => format!("The bands are 95 % intervals over {n} packings."),
    };
    let mut caption = vec![format!(
        "Traced, Lambertian facets, {} K, view {}° from nadir, {paths} paths. {interval}",
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

/// A record in words, for the terminal.
pub fn words(record: &Record, out: &Path) -> String {
    let mut text = String::new();
    for (name, reached) in &record.reached {
        let _ = write!(text, "{name}: {}", reached_words(reached));
    }
    if let Some(advice) = advice(record) {
        let _ = writeln!(text, "{advice}");
    }
    let seconds: f64 = record.stages.iter().map(|stage| stage.seconds).sum();
    let _ = writeln!(text, "Result in {} ({seconds:.1} s)", out.display());
    text
}

/// What it would cost to narrow the interval of a single scene by a tenth, by packings and by rays, where
/// this run shows what both cost.
fn advice(record: &Record) -> Option<String> {
    let reached = record.reached.values().next().filter(|_| record.reached.len() == 1)?;
    let seconds = |name: &str| {
        let stage = record.stages.iter().find(|stage| stage.name == name)?;
        (!stage.cached).then_some(stage.seconds)
    };
    let (drop, trace) = (seconds("drop")?, seconds("trace")?);
    if reached.packings < 2 {
        return None;
    }
    // A tenth narrower is .81 of the variance, of which more rays can only take what is theirs.
    let by_packings = (1.0 / 0.81 - 1.0) * (drop + trace);
    let beyond = reached.rays_share - 0.19;
    let by_rays = (beyond > 0.0).then(|| trace * (reached.rays_share / beyond - 1.0));
    Some(match by_rays {
        None => format!(
            "A tenth narrower: {by_packings:.1} s of further packings; more rays alone cannot do it."
        ),
        Some(by_rays) => format!(
            "A tenth narrower: {by_packings:.1} s of further packings, or {by_rays:.1} s of further rays."
        ),
    })
}

/// What was reached, in words.
pub fn reached_words(r: &Reached) -> String {
    let mut text = format!(
        "each band's emissivity within {:.4} (95 %; widest at {} um; {} asked), {} paths\n",
        r.half_width, r.widest_at_um, r.tolerance, r.paths
    );
    let _ = match r.spread {
        None => writeln!(
            text,
            "  the interval is the noise of the rays on this one packing; packings differ by more: see --packings"
        ),
        Some(spread) => writeln!(
            text,
            "  {} packings with a standard deviation of {spread:.4}; of the variance {:.0} % are theirs, \
             {:.0} % the rays'",
            r.packings,
            100.0 * (1.0 - r.rays_share),
            100.0 * r.rays_share
        ),
    };
    let seen: Vec<String> =
        r.seen_first.iter().map(|(name, share)| format!("{name} {:.1} %", 100.0 * share)).collect();
    let _ = writeln!(text, "  seen from above: {}", seen.join(", "));
    if let Some(line) = coverage_words(&r.coverage) {
        let _ = writeln!(text, "  {line}");
    }
    if let Some(d) = r.features.reststrahlen {
        let _ = writeln!(
            text,
            "  reststrahlen: troughs {:.3} at {} um and {:.3} at {} um, peak {:.3} at {} um, contrast {:.3}{}",
            d.short_trough.emissivity,
            d.short_trough.wavelength_um,
            d.long_trough.emissivity,
            d.long_trough.wavelength_um,
            d.peak.emissivity,
            d.peak.wavelength_um,
            d.contrast,
            plus_minus(r.features_half_width.and_then(|e| e.reststrahlen_contrast))
        );
    }
    let means = [
        (
            "8-9.5 um",
            r.features.mean_8_to_9p5_um,
            r.features_half_width.and_then(|e| e.mean_8_to_9p5_um),
        ),
        (
            "10-12 um",
            r.features.mean_10_to_12_um,
            r.features_half_width.and_then(|e| e.mean_10_to_12_um),
        ),
    ];
    let means: Vec<String> = means
        .into_iter()
        .filter_map(|(window, mean, error)| {
            Some(format!("{:.4}{} over {window}", mean?, plus_minus(error)))
        })
        .collect();
    if !means.is_empty() {
        let _ = writeln!(text, "  mean emissivity: {}", means.join(", "));
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
        let remedy = if r.trapped_half_width >= r.tolerance / 2.0 {
            "paths that were given up leave too much open, and more paths do not help: reflectances are near 1"
                .into()
        } else if let Some(wanted) = r.packings_wanted {
            format!("by this spread it takes {wanted} packings")
        } else if r.packings > 1 {
            "by this spread it takes too many packings".into()
        } else {
            "raise --max-paths".into()
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

fn plus_minus(half_width: Option<f64>) -> String {
    half_width.map_or(String::new(), |half_width| format!(" +- {half_width:.4}"))
}

/// Silhouettes of more than one material, such as those of dusty grains: from the least share to the greatest.
fn coverage_words(coverage: &BTreeMap<String, Cover>) -> Option<String> {
    let mixed = || coverage.values().filter(|cover| cover.silhouette.len() > 1);
    let mut range: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for (material, &share) in mixed().flat_map(|cover| &cover.silhouette) {
        let (least, most) = range.entry(material).or_insert((share, share));
        (*least, *most) = (least.min(share), most.max(share));
    }
    let ranges: Vec<String> = range
        .into_iter()
        .map(|(name, (least, most))| format!("{name} {:.0}-{:.0} %", 100.0 * least, 100.0 * most))
        .collect();
    (!ranges.is_empty())
        .then(|| format!("silhouettes of dusty grains, all sides: {}", ranges.join(", ")))
}
