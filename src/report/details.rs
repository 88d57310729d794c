//! Everything else that a result says of itself, for `--verbose`.

use std::collections::BTreeMap;

use super::{Reached, duration};
use crate::histogram::kept::Kept;
use crate::signature::plan::{Beds, Plan};
use crate::spectrum::FacetSource;
use crate::spectrum::features::{Extremum, Features};
use crate::table::cover::Cover;
use crate::table::field::FieldSummary;

/// The further lines of a result.
pub(super) fn lines(r: &Reached) -> Vec<String> {
    let tolerance = r.tolerance;
    let mut lines = vec![format!(
        "widest band: within {:.4} at {} um ({tolerance} asked), {} paths",
        r.half_width, r.widest_at_um, r.paths
    )];
    lines.extend(r.plan.map(|of| format!("plan: {}", plan(&of, tolerance))));
    lines.push(match r.spread {
        None => "that interval is the noise of the rays; packings differ by more".into(),
        Some(spread) => format!(
            "{} packings with a standard deviation of {spread:.4}; share of the rays in the \
             variance: {:.0} %",
            r.packings,
            100.0 * r.rays_share
        ),
    });
    if r.trapped_half_width > tolerance / 10.0 {
        lines.push(format!(
            "{:.2} % of the paths were given up; they leave {:.5} of the half-width open",
            100.0 * r.trapped,
            r.trapped_half_width
        ));
    }
    lines.extend(budget(r));
    lines.push(format!("recorded per path: {}", recorded(r.kept)));
    lines.extend(facets(&r.facets));
    lines.extend(r.field.as_ref().map(field).into_iter().flatten());
    let seen = r.seen_first.iter().map(|(name, share)| format!("{name} {:.1} %", 100.0 * share));
    lines.push(format!("seen from above: {}", list(seen)));
    lines.extend(silhouettes(&r.coverage));
    lines.extend(features(&r.features));
    if let Some(d) = r.features.reststrahlen {
        let error = r.features_half_width.and_then(|e| e.reststrahlen_contrast);
        let error = error.map_or(String::new(), |error| format!(" +- {error:.4}"));
        let [short, peak, long] = [d.short_trough, d.peak, d.long_trough]
            .map(|at| format!("{:.3} at {} um", at.emissivity, at.wavelength_um));
        lines.push(format!(
            "reststrahlen of {}: troughs {short} and {long}, peak {peak}, contrast {:.3}{error}",
            r.features.mineral.as_deref().unwrap_or_default(),
            d.contrast
        ));
    }
    lines.extend(r.floor_effect.map(|effect| {
        format!("largest change of a band between a black and a white floor: {effect:.4}")
    }));
    lines.extend(r.retrieval.lines());
    lines
}

/// The Christiansen maximum and single troughs, in words of the mineral.
fn features(found: &Features) -> Option<String> {
    let mineral = found.mineral.as_deref()?;
    let at = |of: &Extremum| format!("{:.3} at {} um", of.emissivity, of.wavelength_um);
    let troughs = list(found.troughs.iter().map(at));
    let parts = [
        found.christiansen.map(|of| format!("Christiansen maximum {}", at(&of))),
        (!troughs.is_empty()).then(|| format!("troughs {troughs}")),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| format!("{mineral}: {}", parts.join("; ")))
}

fn list(items: impl Iterator<Item = String>) -> String {
    items.collect::<Vec<_>>().join(", ")
}

/// How many beds a tolerance takes, and why.
pub fn plan(plan: &Plan, tolerance: f64) -> String {
    let Plan { by, at_um, total, bounds, spread, spread_of_change, wanted, next } = plan;
    let mut parts = vec![format!("{} within {total:.4} at {at_um} um", beds(by))];
    parts.extend(spread.map(|spread| format!("they differ by {spread:.4}")));
    parts.extend(spread_of_change.map(|of| format!("touching fines change that by {of:.4}")));
    parts.extend((*bounds > 0.0).then(|| format!("bounds {bounds:.4}")));
    parts.push(match wanted {
        _ if next == by && *total <= tolerance => format!("+-{tolerance} is reached"),
        _ if next == by && *bounds >= tolerance => {
            format!("+-{tolerance} cannot be reached by more beds")
        }
        _ if next == by => format!("+-{tolerance} takes more than are dropped"),
        Some(wanted) if wanted == next => format!("+-{tolerance} takes {}", beds(next)),
        Some(wanted) => {
            format!("+-{tolerance} takes some {}; next {}", beds(wanted), beds(next))
        }
        None => format!("+-{tolerance} takes more: next {}", beds(next)),
    });
    parts.join("; ")
}

/// The beds that a plan begins with, and how long they take by what is known of other machines.
pub fn first_beds(first: &Beds, tolerance: f64, seconds: f64) -> String {
    let time = duration(seconds);
    format!("plan: {} tell how many beds +-{tolerance} takes, in roughly {time}", beds(first))
}

fn beds(of: &Beds) -> String {
    let drops = if of.drops == 1 { "one bed".into() } else { format!("{} beds", of.drops) };
    match of.pairs {
        0 => drops,
        pairs => format!("{drops} ({pairs} also until fines touch)"),
    }
}

/// The budget of the band with the widest total.
fn budget(r: &Reached) -> [String; 2] {
    let share = &r.budget;
    let part = |name: &str, part: Option<f64>| part.map(|part| format!("{name} {part:.4}"));
    let rim = share.rim.map(|rim| match rim {
        0.0 => "no significant rim effect".into(),
        rim => format!("rim {rim:.4}"),
    });
    let included = [
        part("rays", Some(share.rays)),
        part("packings", share.packings),
        rim,
        part("floor", Some(share.floor)),
        part("given-up paths", Some(share.given_up)),
        part("hulls that keep fines apart up to", share.apart),
    ];
    let unknown = match &r.spectra_unknown[..] {
        [] => String::new(),
        names => format!(" as far as known (not for {})", names.join(", ")),
    };
    let not_included = [
        part("facets of grains up to", share.facets),
        part("spectra", Some(share.spectra)).map(|spectra| spectra + &unknown),
        part("interpolation between bands", Some(share.spectral_step)),
    ];
    [
        format!(
            "widest total: within {:.4} at {} um: {}",
            share.total,
            share.wavelength_um,
            list(included.into_iter().flatten())
        ),
        format!("not included: {}", list(not_included.into_iter().flatten())),
    ]
}

/// The source of the facets' reflectance, a line for each spectrum.
fn facets(facets: &BTreeMap<String, FacetSource>) -> Vec<String> {
    let mut groups: Vec<(&FacetSource, Vec<&str>)> = Vec::new();
    for (name, source) in facets {
        match groups.iter_mut().find(|(of, _)| *of == source) {
            Some((_, names)) => names.push(name),
            None => groups.push((source, vec![name])),
        }
    }
    let line = |(of, names): &(&FacetSource, Vec<&str>)| {
        format!("facets of {}: {}, {}: {}", names.join(", "), of.mode, of.spectrum, of.means)
    };
    groups.iter().map(line).collect()
}

/// What is recorded of each path, and why less would not do.
fn recorded(kept: Kept) -> String {
    if kept.nodes > 0 {
        let nodes = kept.nodes;
        return format!("its weight at {nodes} wavelengths, hits on the floor (facets refract)");
    }
    let mut parts = vec![match (kept.order, kept.cosines) {
        (true, _) if kept.layers > 0 => {
            "hits in their order, with depth and sun (the temperature depends on them)"
        }
        (true, _) => "hits in their order (materials differ in temperature)",
        (false, 1) => "hits on each material",
        (false, _) => "hits",
    }];
    if kept.cosines > 1 {
        parts.push("the cosine of each hit (a reflectance depends on it)");
    }
    if kept.zeniths > 1 {
        parts.push("the zenith angle of its escape (the sky depends on it)");
    }
    parts.join(", ")
}

/// The field, and whether it is needed.
fn field(field: &FieldSummary) -> Vec<String> {
    let [x, y] = field.patches;
    let [width, length] = field.size_um.map(|um| um / 1000.0);
    let mut lines = vec![format!(
        "field of {x} x {y} patches, {width:.4} x {length:.4} mm: {} particles, {} in each patch",
        field.particles, field.particles_of_patch
    )];
    for (sides, of, same, differs) in field.alone.iter().flat_map(|alone| {
        [
            (
                "periodic",
                alone.periodic,
                "the field is not needed",
                "the field is needed, or the patch is too small",
            ),
            (
                "mirror",
                alone.mirror,
                "the seams of the field do not show",
                "the seams of the field cut grains, mirrors do not; a larger patch has fewer seams",
            ),
        ]
    }) {
        lines.push(format!(
            "the patch alone within {sides} sides differs by {:.4} +- {:.4} at {} um: {}",
            of.difference,
            of.half_width,
            of.at_um,
            if of.same { same } else { differs }
        ));
    }
    lines
}

/// The least and the largest share of each material in the silhouettes of dusty grains.
fn silhouettes(coverage: &BTreeMap<String, Cover>) -> Option<String> {
    let mut range: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    let dusty = coverage.values().filter(|cover| cover.silhouette.len() > 1);
    for (material, &share) in dusty.flat_map(|cover| &cover.silhouette) {
        let (least, most) = range.entry(material).or_insert((share, share));
        (*least, *most) = (least.min(share), most.max(share));
    }
    let ranges = range
        .into_iter()
        .map(|(name, (least, most))| format!("{name} {:.0}-{:.0} %", 100.0 * least, 100.0 * most));
    let ranges = list(ranges);
    (!ranges.is_empty()).then(|| format!("silhouettes of dusty grains, all sides: {ranges}"))
}
