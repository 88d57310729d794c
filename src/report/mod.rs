//! What a result says of itself: numbers for the record, a chart.

mod reached;
pub mod terminal;
pub mod warnings;

use std::collections::BTreeMap;
use std::path::Path;

use crate::draw::plot::{self, Chart, Curve};
use crate::histogram::tally::PARTS;
use crate::radiometry::{Assumed, Method, Retrieved, masked_um, separate};
use crate::signature::budget::Budget;
use crate::signature::{Band, evaluate, not_valid_um, retrieve};
use crate::spectrum::features::{Features, features};
use crate::support::error::Error;
use crate::support::output;
use crate::support::statistics::{half_width, wanted};
use crate::table::field::FieldSummary;
use crate::table::{Table, TableMaterial, cover};

pub use reached::{FeatureErrors, Reached, Retrieval, Separation};

/// The numbers of a scene's packings; the tolerance is that of the mean over them.
pub fn reached(packings: &[Table], bands: &[Band], budget: &Budget, tolerance: f64) -> Reached {
    let paths: u64 = packings.iter().map(|table| table.paths).sum();
    let met: u64 = packings.iter().map(Table::met).sum();
    let share =
        |count: &dyn Fn(&Table) -> f64| packings.iter().map(count).sum::<f64>() / paths as f64;
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let emissivity: Vec<f64> = bands.iter().map(|band| band.emissivity.mean).collect();
    let widest = bands
        .iter()
        .max_by(|a, b| a.emissivity.half_width.total_cmp(&b.emissivity.half_width))
        .expect("there is at least one band");
    let e = widest.emissivity;
    let floor_effect = budget.floor_effect;
    let rays_reached = packings.iter().all(|table| table.stop.reached.tolerance);
    Reached {
        packings: packings.len(),
        plan: None,
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
        facets: packings[0]
            .materials
            .iter()
            .map(|m| (m.name.clone(), m.spectrum.facets()))
            .collect(),
        not_valid_um: not_valid_um(bands),
        seen_first: packings[0]
            .materials
            .iter()
            .enumerate()
            .map(|(i, material)| {
                let hits: u64 = packings.iter().map(|table| table.materials[i].first_hits).sum();
                (material.name.clone(), hits as f64 / met as f64)
            })
            .collect(),
        coverage: cover::mean(&packings.iter().map(|t| &t.coverage).collect::<Vec<_>>()),
        missed: share(&|table| table.missed as f64),
        escaped_downward: share(&|table| table.escaped_downward as f64 / PARTS as f64),
        trapped: share(&|table| table.histogram.paths_given_up()),
        kept: packings[0].histogram.kept,
        ended_by: packings[0].stop.reached.reason,
        inside: share(&|table| table.inside.iter().map(|inside| inside.paths as f64).sum()),
        field: FieldSummary::mean(packings),
        budget: budget.widest(),
        spectra_unknown: budget.spectra_unknown.clone(),
        floor_effect,
        warnings: warnings::of_result(packings, bands, tolerance, floor_effect),
        retrieval: retrieval(&packings[0], bands, Assumed::EXACT),
        features: features(&wavelengths, &emissivity),
        features_half_width: feature_errors(packings, &wavelengths),
    }
}

/// What can be had back from the radiance of a scene, if its temperature is known and if it is not.
pub fn retrieval(table: &Table, bands: &[Band], assumed: Assumed) -> Retrieval {
    let known = retrieve(bands, table.temperature(), assumed);
    let differences = |retrieved: &[Retrieved]| -> Vec<f64> {
        let both = retrieved.iter().zip(bands);
        both.filter_map(|(r, b)| r.emissivity.map(|[e, _]| e - b.emissivity.mean)).collect()
    };
    let measured: Vec<_> = bands.iter().map(Band::measured).collect();
    let by = |method| match separate(method, &measured, assumed) {
        Err(error) => Separation::Refused(error.to_string()),
        Ok(temperature) => {
            let off = differences(&retrieve(bands, temperature, assumed));
            let squares: f64 = off.iter().map(|d| d * d).sum();
            Separation::Found {
                temperature_k: temperature.k,
                temperature_standard_error_k: temperature.error_k,
                emissivity_rms: (squares / off.len() as f64).sqrt(),
            }
        }
    };
    Retrieval {
        amplification_limit: assumed.amplification_limit,
        masked_um: masked_um(&known),
        eq_2_not_exact: table.eq_2_not_exact(),
        eq_2_difference: differences(&known).into_iter().map(f64::abs).reduce(f64::max),
        separation: Method::ALL.into_iter().map(|method| (method, by(method))).collect(),
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
            let curve: Vec<f64> = bands.iter().map(|band| band.emissivity.mean).collect();
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
        "Traced, {} facets, {} K, view {}° from nadir, {paths} paths. {interval}",
        facets(table),
        table.temperature_k,
        table.view.zenith_deg,
    )];
    let mut spectra: Vec<String> = Vec::new();
    for material in &table.materials {
        let text = material.spectrum.to_string();
        if !spectra.contains(&text) {
            spectra.push(text);
        }
    }
    caption.push(format!("Facets: {}.", spectra.join("; ")));
    let mut hatched_um: Vec<[f64; 2]> =
        signatures.iter().flat_map(|(_, bands)| not_valid_um(bands)).collect();
    hatched_um.sort_by(|a, b| a[0].total_cmp(&b[0]));
    hatched_um.dedup();
    if !hatched_um.is_empty() {
        caption.push(
            "Hatched: Fresnel facets do not hold there; grains let light through, or are small against the wavelength."
                .into(),
        );
    }
    let versions: Vec<String> = [("soilsig", "soilsig"), ("blender", "Blender")]
        .iter()
        .filter_map(|(key, name)| Some(format!("{name} {}", versions.get(*key)?)))
        .collect();
    caption.push(format!("{}, seed {}", versions.join(", "), table.seed));
    Chart { title: title.to_owned(), caption, curves, mark_features: true, hatched_um }
}

/// How the facets of a table's materials reflect.
fn facets(table: &Table) -> &'static str {
    let specular = |m: &TableMaterial| m.specular > 0.0 || m.spectrum.is_angular();
    match table.materials.iter().filter(|m| specular(m)).count() {
        0 => "Lambertian",
        n if n == table.materials.len() => "specular",
        _ => "Lambertian and specular",
    }
}

/// Writes a chart as `STEM.svg` and `STEM.png`.
pub fn draw(chart: &Chart, stem: &Path) -> Result<(), Error> {
    let svg = plot::emissivity_svg(chart)?;
    output::bytes(&stem.with_extension("svg"), svg.as_bytes())?;
    let png = plot::png(&svg, plot::PIXELS_PER_UNIT)?;
    output::bytes(&stem.with_extension("png"), &png)?;
    Ok(())
}
