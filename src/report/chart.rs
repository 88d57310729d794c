//! The chart of a result.

use std::collections::BTreeMap;

use super::Report;
use crate::draw::plot::{Chart, Curve};
use crate::signature::{Levels, not_valid_um};
use crate::table::{Table, TableMaterial, feature_windows};

/// The chart of one scene's signature or of several.
pub fn chart(
    title: &str,
    signatures: &[(&[Table], &Report)],
    versions: &BTreeMap<String, String>,
) -> Chart {
    let curve = |(tables, report): &(&[Table], &Report)| {
        Curve::of(&tables[0].scene, &report.bands, &report.budget, feature_windows(tables))
    };
    let curves = signatures.iter().map(curve).collect();
    let (packings, _) = signatures[0];
    let table = &packings[0];
    let paths = signatures.iter().map(|(tables, _)| tables.iter().map(|t| t.paths).sum::<u64>());
    let (least, most) = (paths.clone().min().unwrap_or(0), paths.max().unwrap_or(0));
    let paths = if least == most { format!("{least}") } else { format!("{least}-{most}") };
    let beds = match Levels::of(packings).drops() {
        1 => "one bed".into(),
        n => format!("{n} beds"),
    };
    let mut caption = vec![format!(
        "Traced, {} facets, {} K, view {}° from nadir, {beds}, {paths} paths.",
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
        signatures.iter().flat_map(|(_, report)| not_valid_um(&report.bands)).collect();
    hatched_um.sort_by(|a, b| a[0].total_cmp(&b[0]));
    hatched_um.dedup();
    if !hatched_um.is_empty() {
        let is_refractive = |table: &Table| table.nodes.is_some();
        caption.push(if signatures.iter().any(|(tables, _)| is_refractive(&tables[0])) {
            "Hatched: rays do not hold there; small grains that reflect much take wave optics."
                .into()
        } else {
            let why = "grains let light through, or are small against the wavelength";
            format!("Hatched: Fresnel facets do not hold there; {why}.")
        });
    }
    let versions: Vec<String> = [("soilsig", "soilsig"), ("blender", "Blender")]
        .iter()
        .filter_map(|(key, name)| Some(format!("{name} {}", versions.get(*key)?)))
        .collect();
    caption.push(format!("{}, seed {}", versions.join(", "), table.seed));
    Chart { title: title.to_owned(), caption, curves, hatched_um, bare: false }
}

/// How the facets of a table's materials reflect.
fn facets(table: &Table) -> &'static str {
    if table.nodes.is_some() {
        return "refractive";
    }
    let specular = |m: &TableMaterial| m.specular > 0.0 || m.spectrum.is_angular();
    match table.materials.iter().filter(|m| specular(m)).count() {
        0 => "Lambertian",
        n if n == table.materials.len() => "specular",
        _ => "Lambertian and specular",
    }
}
