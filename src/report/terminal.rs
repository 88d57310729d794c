//! A result in words, for the terminal.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::histogram::tally::Kept;
use crate::radiometry::masked_in_words;
use crate::report::{Reached, Retrieval};
use crate::signature::budget::Share;
use crate::signature::depth::Depth;
use crate::signature::plan::Plan;
use crate::spectrum::FacetSource;
use crate::table::StopReason;
use crate::table::cover::Cover;
use crate::table::field::FieldSummary;

/// Share of paths inside a solid from which the user is told. Where dust is seated flush some 1e-4 are
/// lost in the crevices, to rounding; more tells of overlap.
const INSIDE_NOTABLE: f64 = 1e-3;

/// How many packings a tolerance takes.
pub fn plan(plan: &Plan, tolerance: f64) -> String {
    let Plan { pilot, spread, at_um, apart, touching, wanted, packings, depth: fewer } = plan;
    let kind = if *touching && *apart == 0.0 { "packings whose fines touch" } else { "packings" };
    let mut text =
        format!("{pilot} {kind} differ by {spread:.4} (standard deviation at {at_um} um)");
    if *apart > 0.0 {
        let _ = write!(text, "; hulls keep their fines apart, which may make {apart:.4}");
    }
    if *touching && *apart > 0.0 {
        let _ = write!(text, ": for +-{tolerance} fines have to touch");
        return text;
    }
    let _ = write!(text, ": {wanted} for +-{tolerance} at 95 %");
    if let Some(fewer) = fewer {
        let _ = write!(text, "; {}", depth(fewer));
    }
    if packings < wanted {
        let _ = write!(text, " (of which {packings} are dropped)");
    }
    text
}

/// How many grains are enough.
pub fn depth(depth: &Depth) -> String {
    let Depth { of, grains, change, at_um } = depth;
    let below = of - grains;
    format!(
        "{of} grains -> {grains}: the lowest {below} change no more than {change:.4} ({at_um} um)"
    )
}

/// What was reached for a scene.
pub fn reached(r: &Reached) -> String {
    let mut text = format!(
        "each band's emissivity within {:.4} (95 %; widest at {} um; {} asked), {} paths\n",
        r.half_width, r.widest_at_um, r.tolerance, r.paths
    );
    if let Some(of) = &r.plan {
        let _ = writeln!(text, "  planned: {}", plan(of, r.tolerance));
    }
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
    text += &budget(&r.budget, &r.spectra_unknown);
    let _ = writeln!(text, "  of each path is kept: {}", kept(r.kept));
    text += &facets_words(&r.facets);
    if let Some(field) = &r.field {
        text += &field_words(field);
    }
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
    text += &retrieval(&r.retrieval);
    warnings(&mut text, r);
    text
}

/// Where the uncertainty comes from.
fn budget(share: &Share, spectra_unknown: &[String]) -> String {
    let mut parts = vec![format!("rays {:.4}", share.rays)];
    parts.extend(share.packings.map(|packings| format!("packings {packings:.4}")));
    parts.extend(share.rim.map(|rim| match rim {
        0.0 => "no rim beyond chance".into(),
        rim => format!("rim {rim:.4}"),
    }));
    parts.push(format!("floor {:.4}", share.floor));
    parts.push(format!("paths given up {:.4}", share.given_up));
    let apart = share
        .apart
        .map_or(String::new(), |apart| format!("hulls that keep fines apart up to {apart:.4}, "));
    let facets = share.facets.map_or(String::new(), |facets| {
        format!("facets of grains up to {facets:.4} (not measured on these beds), ")
    });
    let recipe = if share.packings.is_some() { "of the recipe" } else { "of this geometry" };
    let unknown = match spectra_unknown {
        [] => String::new(),
        names => format!(" (those of {} come without an error)", names.join(", ")),
    };
    format!(
        "  in all, {recipe}: within {:.4} at {} um: {}\n  beside that: {apart}{facets}spectra {:.4}{unknown}, straight lines \
         between bands {:.4}\n",
        share.total,
        share.wavelength_um,
        parts.join(", "),
        share.spectra,
        share.spectral_step,
    )
}

/// What can be had back from the radiance: what Eq. 2 does not tell, and what it gets wrong.
pub fn retrieval(of: &Retrieval) -> String {
    let mut text = String::new();
    if let Some(masked) = masked_in_words(&of.masked_um, of.amplification_limit) {
        let _ = writeln!(text, "  {masked}");
    }
    if !of.eq_2_not_exact.is_empty() {
        let reasons = of.eq_2_not_exact.join(" and ");
        let _ = match of.eq_2_difference {
            Some(d) => writeln!(
                text,
                "  Eq. 2 is not exact here, since {reasons}: it differs from the emissivity by up to {d:.4}"
            ),
            None => writeln!(text, "  Eq. 2 is not exact here, since {reasons}"),
        };
    }
    text
}

/// Where facets have their reflectance from, a line for each spectrum.
fn facets_words(facets: &BTreeMap<String, FacetSource>) -> String {
    let mut text = String::new();
    let mut told: Vec<&FacetSource> = Vec::new();
    for of in facets.values() {
        if told.contains(&of) {
            continue;
        }
        told.push(of);
        let alike = facets.iter().filter(|(_, other)| *other == of);
        let names: Vec<&str> = alike.map(|(name, _)| name.as_str()).collect();
        let _ = writeln!(
            text,
            "  facets of {}: {}, {}: {}",
            names.join(", "),
            of.mode,
            of.spectrum,
            of.means
        );
        for warning in &of.warnings {
            let _ = writeln!(text, "  warning: {}: {warning}", names.join(", "));
        }
    }
    text
}

/// What of a path is kept, and why no less would do.
fn kept(kept: Kept) -> String {
    let mut parts = vec![match (kept.order, kept.cosines) {
        (true, _) => "its hits in their order (materials differ in temperature)",
        (false, 1) => "how often it hit each material",
        (false, _) => "its hits",
    }];
    if kept.cosines > 1 {
        parts.push("the cosine of each hit (a reflectance depends on it)");
    }
    if kept.zeniths > 1 {
        parts.push("the zenith angle at which it left (the sky depends on it)");
    }
    parts.join(", ")
}

/// The field, and whether it is needed.
fn field_words(field: &FieldSummary) -> String {
    let [x, y] = field.patches;
    let [width, length] = field.size_um.map(|um| um / 1000.0);
    let mut text = format!(
        "  field of {x} x {y} patches, {width:.4} x {length:.4} mm: {} particles, {} in each patch\n",
        field.particles, field.particles_of_patch
    );
    if let Some(alone) = field.alone {
        for (sides, of, same, else_) in [
            (
                "periodic",
                alone.periodic,
                "the field is not needed",
                "the field is needed, or the patch is too small",
            ),
            (
                "mirror",
                alone.mirror,
                "its seams do not show",
                "the field's seams cut grains, which mirrors do not; a larger patch has less of that",
            ),
        ] {
            let verdict = if of.same { same } else { else_ };
            let _ = writeln!(
                text,
                "  its patch alone within {sides} sides differs by {:.4} +- {:.4} at {} um: {verdict}",
                of.difference, of.half_width, of.at_um
            );
        }
    }
    text
}

/// What is not as it should be, and what to do about it.
fn warnings(text: &mut String, r: &Reached) {
    if r.trapped_half_width > r.tolerance / 10.0 {
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
            match r.ended_by {
                StopReason::MaxSeconds => "raise --max-seconds",
                StopReason::Paths => "ask for more --paths",
                _ => "raise --max-paths",
            }
            .into()
        };
        let _ = writeln!(text, "  warning: the tolerance was not reached: {remedy}");
    }
    if !r.not_valid_um.is_empty() {
        let ranges: Vec<String> = r
            .not_valid_um
            .iter()
            .map(|[from, to]| if from == to { format!("{from}") } else { format!("{from}-{to}") })
            .collect();
        let _ = writeln!(
            text,
            "  warning: fresnel facets do not hold at {} um: grains let over 1 % of the light through, or measure below \
             ten wavelengths",
            ranges.join(", ")
        );
    }
    for (share, what) in [
        (r.missed, "of the sensor's rays meet nothing and are left out"),
        (r.escaped_downward, "of the paths leave past the target's lower side: give it a floor"),
    ] {
        if share > 0.0 {
            let _ = writeln!(text, "  warning: {:.2} % {what}", 100.0 * share);
        }
    }
    for warning in &r.warnings {
        let _ = writeln!(text, "  warning: {warning}");
    }
    if r.inside > INSIDE_NOTABLE {
        let _ = writeln!(
            text,
            "  warning: {:.2} % of the paths came to be inside a solid: solids overlap",
            100.0 * r.inside
        );
    }
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
