//! What a result says of itself: numbers for the record, a chart, words.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use crate::error::Error;
use crate::features::features;
use crate::output;
use crate::plot::{self, Chart, Curve};
use crate::record::{Reached, Record};
use crate::scene::{Scene, SceneGeometry};
use crate::signature::{Band, reflectances};
use crate::spectrum::Spectrum;
use crate::table::Table;

/// Pixels of a PNG in one unit of the chart.
const PIXELS_PER_UNIT: f32 = 2.0;

/// Share of paths inside a solid from which the user is told. Where dust is seated flush some 1e-4 are
/// lost in the crevices, to rounding; more tells of overlap.
const INSIDE_NOTABLE: f64 = 1e-3;

/// The numbers of a traced scene.
pub fn reached(table: &Table, scene: &Scene, bands: &[Band]) -> Reached {
    let paths = table.paths as f64;
    let share = |count: u64| count as f64 / paths;
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let emissivity: Vec<f64> = bands.iter().map(|band| band.emissivity).collect();
    Reached {
        half_width: table.stop.half_width,
        widest_at_um: table.stop.widest_at_um,
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
        floor_effect: floor_effect(table, scene, bands),
        features: features(&wavelengths, &emissivity),
    }
}

/// Most that any band changes between a black and a white floor: what is left of the tray in the
/// result. `None` where there is no floor; an upper bound where grains share its material.
fn floor_effect(table: &Table, scene: &Scene, bands: &[Band]) -> Option<f64> {
    let SceneGeometry::Placed(placed) = &scene.geometry else { return None };
    let floor = scene.material_index(&placed.domain.as_ref()?.floor.as_ref()?.material)?;
    let wavelengths: Vec<f64> = bands.iter().map(|band| band.wavelength_um).collect();
    let spectra: Vec<&Spectrum> = table.materials.iter().map(|m| &m.spectrum).collect();
    let reflectances = reflectances(&spectra, &wavelengths).ok()?;
    // Every tenth band is enough to find the widest.
    let effect = reflectances.into_iter().step_by(10).map(|mut reflectance| {
        let [black, white] = [0.0, 1.0].map(|rho| {
            reflectance[floor] = rho;
            table.weight(&reflectance).mean
        });
        white - black
    });
    Some(effect.fold(0.0, f64::max))
}

/// The chart of one scene or of several.
pub fn chart(scenes: &[(&Scene, &Table, &[Band])], versions: &BTreeMap<String, String>) -> Chart {
    let curves: Vec<Curve> =
        scenes.iter().map(|(scene, _, bands)| Curve::of(&scene.name, bands)).collect();
    let (scene, table, _) = scenes[0];
    let title = match scenes {
        [_] => scene.description.clone().unwrap_or_else(|| scene.name.clone()),
        _ => "Emissivity of quartz soil by its cover with fines".into(),
    };
    let mut caption = vec![format!(
        "Traced, Lambertian facets, {} K, view {}° from nadir, {} paths. The bands are the noise of \
             the rays on one packing; packings differ by more.",
        scene.temperature_k,
        scene.view.zenith_deg,
        scenes.iter().map(|(_, table, _)| table.paths).max().unwrap_or(0)
    )];
    let mut spectra: Vec<String> = Vec::new();
    for material in &table.materials {
        let text = material.spectrum.to_string();
        if !spectra.contains(&text) {
            spectra.push(text);
        }
    }
    caption.push(format!("Facets: {}.", spectra.join("; ")));
    let versions: Vec<String> = ["soilsig", "blender"]
        .iter()
        .filter_map(|name| Some(format!("{name} {}", versions.get(*name)?)))
        .collect();
    caption.push(format!("{}, seed {}", versions.join(", "), scene.seed));
    Chart { title, caption, curves, mark_features: true }
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
        "emissivity within {:.4} (95 %, widest at {} um; {} asked), {} paths\n",
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
        let _ = writeln!(text, "  the floor's material changes no band by more than {effect:.4}");
    }
    if !r.tolerance_reached {
        let _ = writeln!(text, "  warning: the tolerance was not reached; raise --max-paths");
    }
    for (share, what) in [
        (r.missed, "of the sensor's rays meet nothing and are left out: narrow the domain"),
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
