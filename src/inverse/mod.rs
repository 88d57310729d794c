//! From a measured signature back to the soil: `soilsig match`.
//!
//! The paper ends with a loop done by hand: fines are removed step by step until the simulated
//! signature meets the measured one. Here a forward model is made of such steps, and its parameters
//! are estimated with their errors (docs/physics/match.md).

pub mod beds;
mod best;
pub mod discrepancy;
mod error;
pub mod estimation;
pub mod facets;
pub mod files;
mod ground;
mod importance;
pub mod kernel;
pub mod linear;
pub mod measured;
#[cfg(test)]
mod nist;
pub mod radiance;
pub mod result;
pub mod soil;
pub mod solver;
pub mod summary;
pub mod thinning;
mod warning;
pub mod words;

use std::path::{Path, PathBuf};
use std::time::Duration;

pub use error::InverseError;
pub use warning::Warning;

use beds::Source;
use estimation::{Estimation, Observed};
use facets::FacetModel;
use ground::{Fitted, Ground, Like};
use measured::Seen;
use result::{Beds, Match, Quantity, SecondComponent};
use soil::{COVER, MEDIUM, On, Soil};

use crate::scene::{Scene, SpectrumSource};
use crate::spectrum::Spectrum;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::linear::ends;
use crate::support::monitor::{Monitor, Step};
use crate::support::output;
use crate::table::resolved;

/// What is matched, and how.
pub struct Options<'a> {
    /// The measured spectrum.
    pub spectrum: PathBuf,
    /// The bands.
    pub seen: Seen,
    /// Standard error of the emissivity in each band, where the file has none.
    pub error: f64,
    /// The scene of full cover.
    pub scene: Scene,
    /// Whether it is the shipped one.
    pub is_shipped: bool,
    /// The facet model of the answer.
    pub facets: FacetModel,
    /// The other facet models to compare it with.
    pub others: Vec<FacetModel>,
    /// The second component; `None` for a spectrally flat one.
    pub second: Option<SpectrumSource>,
    /// Where it is.
    pub on: On,
    /// Priors that replace the defaults: name, mean, standard deviation.
    pub priors: Vec<(String, f64, f64)>,
    /// Beds of each cover.
    pub beds: usize,
    /// Random seed.
    pub seed: u64,
    /// Folder for the result.
    pub out: PathBuf,
    /// The command line, for the record of the best scene's run.
    pub command: Vec<String>,
    /// The Blender asked for.
    pub blender: Option<PathBuf>,
    /// Its time limit for each bed.
    pub time_limit: Duration,
    /// The cache.
    pub cache: &'a Cache,
    /// Told of progress.
    pub monitor: &'a dyn Monitor,
}

/// Matches a measured spectrum and writes the result.
///
/// # Errors
/// A spectrum that does not hold the bands, a bed that cannot be made or thinned, too few bands, or
/// a prior that fits no parameter.
pub fn run(options: &Options) -> Result<Match, Error> {
    let Options { monitor, .. } = *options;
    ground::known(&options.priors, &options.seen)?;
    ground::enough(options)?;
    let um = options.seen.um();
    let materials = resolved(&options.scene)?;
    // What is wrong with the spectra is known before Blender is started.
    for material in &materials {
        material.spectrum.covers([um[0], um[um.len() - 1]])?;
        if material.spectrum.is_refractive() {
            let scene = options.scene.file.clone();
            let problem =
                format!("{} lets light through: a match needs opaque facets", material.name);
            return Err(InverseError::Bed { scene, problem }.into());
        }
    }
    let source = Source::of(options);
    let settled = source.settle()?;
    let mut ground = Ground { options, settled, materials, um };
    let name = format!("traced, {} facets", options.facets.name());
    let mut soil = ground.soil(options.facets, options.on)?;
    let mut fitted = ground.fit(&soil, &name, Like { facets: Some(options.facets), near: None })?;
    let mut best = None;
    let mut drops = if source.is_recipe() { MOST_DROPS } else { 0 };
    while drops > 0 {
        // A bed dropped anew at the answer joins the model.
        drops -= 1;
        let cover = fitted.estimation.best[COVER];
        let (bed, found) = best::drop(options, &source, &fitted.estimation.best)?;
        ground.settled.push(bed);
        best = Some(found);
        soil = ground.soil(options.facets, options.on)?;
        fitted = ground.fit(&soil, &name, Like { facets: Some(options.facets), near: None })?;
        let error = fitted.fit.parameters[COVER].standard_error;
        if (fitted.estimation.best[COVER] - cover).abs() < 0.5 * error {
            break;
        }
    }
    let step = Step::new(monitor, "compare");
    let best_fit = fitted.estimation.best.clone();
    let like = |facets: FacetModel| Like { facets: Some(facets), near: Some(&best_fit) };
    let mut other_facets = Vec::new();
    for &facets in &options.others {
        let name = format!("traced, {} facets", facets.name());
        let soil = ground.soil(facets, options.on)?;
        other_facets.push(ground.fit(&soil, &name, like(facets))?.fit);
        monitor.check()?;
    }
    let mut other_places = Vec::new();
    for on in On::ALL.into_iter().filter(|on| *on != options.on) {
        let name = format!("second component on {}", on.name());
        let soil = ground.soil(options.facets, on)?;
        other_places.push(ground.fit(&soil, &name, like(options.facets))?.fit);
        monitor.check()?;
    }
    let mut linear = Vec::new();
    for (with_flat, name) in [(false, "linear"), (true, "linear with a flat component")] {
        let model = ground.linear(soil.roles_of_materials(), with_flat)?;
        linear.push(ground.fit(&model, name, Like { facets: None, near: Some(&[]) })?.fit);
    }
    let halves = ground.halves(&soil, like(options.facets));
    let Fitted { fit: answer, observed, estimation } = fitted;
    step.done(&format!("{} models", 1 + other_facets.len() + other_places.len() + linear.len()));
    let cover = soil.fresh_covers().last().copied();
    let compared = |best: best::Found| best.compared(cover.unwrap_or(0.0), &observed, &estimation);
    let best = best.map(compared).transpose()?;
    let mut result = Match {
        beds: beds_of(&soil, &estimation),
        answer,
        other_facets,
        other_places,
        linear,
        halves,
        best,
        ..written(options, &observed)?
    };
    result.warnings = summary::warnings(&result, &observed, &estimation);
    files::write(&result, &observed, &estimation, &options.out)?;
    Ok(result)
}

/// Beds that are dropped at the answer: once more where the first moved it.
const MOST_DROPS: usize = 2;

/// A result with what does not depend on the fits.
fn written(options: &Options, observed: &Observed) -> Result<Match, Error> {
    let Options { spectrum, second, seen, seed, on, .. } = options;
    let second = match second {
        None => "flat".to_owned(),
        Some(source) => Spectrum::resolve(source, Path::new(""))?.name().to_owned(),
    };
    Ok(Match {
        soilsig_match: result::FORMAT,
        soilsig: env!("CARGO_PKG_VERSION").into(),
        spectrum: spectrum.file_name().unwrap_or_default().to_string_lossy().into(),
        spectrum_sha256: output::sha256_hex(spectrum)?,
        observed: match seen {
            Seen::Emissivity { .. } => Quantity::Emissivity,
            Seen::Radiance { .. } => Quantity::Radiance,
        },
        bands: observed.um.len(),
        range_um: ends(&observed.um),
        seed: *seed,
        second: SecondComponent { spectrum: second, on: *on },
        ..Match::default()
    })
}

/// What the model's beds are.
fn beds_of(soil: &Soil, estimation: &Estimation) -> Beds {
    let n = soil.um().len();
    let spread = soil.spread(&estimation.best[..=MEDIUM]);
    let mean = (0..n).map(|i| spread[(i, i)]).sum::<f64>() / n as f64;
    Beds {
        thinned: soil.thinned_covers(),
        fresh: soil.fresh_covers(),
        fresh_less_thinned: soil.fresh_less_thinned(&estimation.best[..=MEDIUM]),
        spread: mean.sqrt(),
    }
}
