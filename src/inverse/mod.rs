//! From a measured signature back to the soil: `soilsig match`.
//!
//! The paper ends with a loop done by hand: fines are removed step by step until the simulated
//! signature meets the measured one. Here a forward model is made of such steps, and its parameters
//! are estimated with their errors (docs/physics/match.md).

pub mod beds;
mod best;
mod error;
pub mod estimation;
pub mod facets;
pub mod files;
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
mod truncated;
mod warning;
pub mod words;

use std::path::{Path, PathBuf};
use std::time::Duration;

pub use error::InverseError;
pub use warning::Warning;

use beds::{Settled, Source, Traced};
use estimation::{Estimation, Evaluated, Fitting, Model, Observed, Parameter};
use facets::FacetModel;
use linear::Linear;
use measured::Seen;
use radiance::Radiance;
use result::{Beds, Fit, Match, Quantity, SecondComponent};
use soil::{COVER, LARGE, On, Role, Second, Soil};

use crate::scene::{Scene, SpectrumSource};
use crate::spectrum::Spectrum;
use crate::support::cache::Cache;
use crate::support::error::Error;
use crate::support::linear::ends;
use crate::support::monitor::{Monitor, Step};
use crate::support::output;
use crate::table::TableMaterial;
use crate::table::materials::reflectances;
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

/// The names of a soil's parameters, in their order.
pub const NAMES: [&str; 4] = ["cover", "second", "level", "large_fines"];

/// The default priors of a soil: wide for what is sought, narrow for what is known of natural soils.
///
/// The emissivity of 34 natural soils over 10-12 um is .957 to .980. A flat component has about
/// that.
fn soil_parameters(covers: [f64; 2], large_share: f64, is_flat: bool) -> Vec<Parameter> {
    let of = |name: &str, prior: f64, sd: f64, bounds: [f64; 2]| Parameter {
        name: name.into(),
        unit: String::new(),
        prior,
        prior_standard_deviation: sd,
        bounds,
    };
    let middle = f64::midpoint(covers[0], covers[1]);
    vec![
        of(NAMES[0], middle, 0.5, covers),
        of(NAMES[1], 0.3, 0.3, [0.0, 0.95]),
        of(NAMES[2], 0.95, if is_flat { 0.02 } else { 0.0 }, [0.8, 1.0]),
        of(NAMES[3], large_share, 0.0, [0.0, 0.6]),
    ]
}

/// Replaces the priors of these parameters; others belong to another model.
fn replace(parameters: &mut [Parameter], priors: &[(String, f64, f64)]) -> Result<(), Error> {
    for (name, mean, sd) in priors {
        let Some(parameter) = parameters.iter_mut().find(|p| p.name == *name) else { continue };
        let [low, high] = parameter.bounds;
        if !(low..=high).contains(mean) {
            return Err(InverseError::Prior { name: name.clone(), prior: *mean, low, high }.into());
        }
        (parameter.prior, parameter.prior_standard_deviation) = (*mean, *sd);
    }
    Ok(())
}

/// An error if a prior names no parameter.
fn known(priors: &[(String, f64, f64)], seen: &Seen) -> Result<(), Error> {
    let more: &[&str] = match seen {
        Seen::Emissivity { .. } => &[],
        Seen::Radiance { .. } => &radiance::NAMES,
    };
    let all = [&NAMES, more].concat();
    match priors.iter().find(|(name, ..)| !all.contains(&name.as_str())) {
        None => Ok(()),
        Some((name, ..)) => {
            let (name, known) = (name.clone(), all.join(", "));
            Err(InverseError::Parameter { name, known }.into())
        }
    }
}

/// The beds and all that does not depend on the facet model.
struct Ground<'a> {
    options: &'a Options<'a>,
    settled: Vec<Settled>,
    materials: Vec<TableMaterial>,
    um: Vec<f64>,
}

impl Ground<'_> {
    /// The beds, traced with the facets of a model, and their materials.
    fn traced(&self, facets: FacetModel) -> Result<(Traced, Vec<TableMaterial>), Error> {
        let Options { seed, cache, monitor, .. } = *self.options;
        let found = beds::found(&self.settled, seed)?;
        let is_grain = |number: usize| found.grains.contains(&(number as u16));
        let materials = facets.of(&self.materials, is_grain)?;
        // Library and inverted facets share their paths: the brighter decide how far these go.
        let alike = |facets: FacetModel| facets.of(&self.materials, is_grain);
        let mut all = vec![alike(facets)?];
        if facets != FacetModel::Fresnel {
            all = vec![alike(FacetModel::Library)?, alike(FacetModel::Inverted)?];
        }
        let mut bands = Vec::new();
        for materials in &all {
            let spectra: Vec<&Spectrum> = materials.iter().map(|m| &m.spectrum).collect();
            let kept = crate::histogram::tally::Kept::PLAIN;
            bands.extend(reflectances(&spectra, kept, &self.um)?);
        }
        let traced = beds::trace(&self.settled, &materials, &bands, seed, cache, monitor)?;
        Ok((traced, materials))
    }

    /// The forward model with facets of a kind, and the second component at a place.
    fn soil(&self, facets: FacetModel, on: On) -> Result<Soil, Error> {
        let (traced, materials) = self.traced(facets)?;
        let second = self.second(on)?;
        let is_flat = second.emissivity.is_none();
        let mut parameters = soil_parameters(beds::covers(&traced), traced.large_share, is_flat);
        replace(&mut parameters, &self.options.priors)?;
        let Traced { full, fresh, roles, .. } = traced;
        Ok(Soil::new(&self.um, parameters, second, (&materials, &roles), full, fresh)?)
    }

    fn second(&self, on: On) -> Result<Second, Error> {
        let emissivity = match &self.options.second {
            None => None,
            Some(source) => {
                let spectrum = Spectrum::resolve(source, Path::new(""))?;
                let of: Result<Vec<f64>, _> =
                    self.um.iter().map(|&um| spectrum.emissivity(um)).collect();
                Some(of?)
            }
        };
        Ok(Second { emissivity, on })
    }

    /// Linear mixing of the powders' spectra, with a flat component or without.
    fn linear(&self, roles: &[Role], with_flat: bool) -> Result<Linear, Error> {
        let spectrum = |role: Role| {
            let place = roles.iter().position(|of| *of == role).expect("beds have both");
            facets::powder(&self.materials[place].spectrum)
        };
        let of = |role: Role| -> Result<(Vec<f64>, Vec<f64>), Error> {
            let spectrum = spectrum(role);
            let mut all = (Vec::new(), Vec::new());
            for &um in &self.um {
                all.0.push(spectrum.emissivity(um)?);
                all.1.push(soil::known_error(&spectrum, um)?);
            }
            Ok(all)
        };
        let (fines, grains) = (of(Role::Fines)?, of(Role::Grains)?);
        let mut parameters = soil_parameters([0.0, 1.0], 0.0, true);
        parameters.truncate(3);
        parameters[0].name = "fines".into();
        parameters[1].name = "flat".into();
        // As a powder, not on facets, whose scattering makes it blacker.
        parameters[2].prior = 0.97;
        if !with_flat {
            for parameter in &mut parameters[1..] {
                parameter.prior_standard_deviation = 0.0;
            }
            parameters[1].prior = 0.0;
        }
        let um = self.um.clone();
        let (ends, errors) = ([fines.0, grains.0], [fines.1, grains.1]);
        Ok(Linear { um, ends, errors, parameters })
    }

    /// Fits a model of emissivity to what was seen, which may be radiance.
    fn fit(&self, soil: &dyn Model, name: &str, like: Like) -> Result<Fitted, Error> {
        let Options { seen, seed, priors, error, .. } = self.options;
        match seen {
            Seen::Emissivity { bands, errors, .. } => {
                let errors = errors.clone().unwrap_or_else(|| vec![*error; bands.len()]);
                let observed = Observed { um: self.um.clone(), bands: bands.clone(), errors };
                Ok(fitted(soil, observed, *seed, name, like))
            }
            Seen::Radiance { measured, first, downwelling_error } => {
                let (radiance, observed) =
                    Radiance::new(soil, measured, *first, *downwelling_error);
                let mut parameters = radiance.parameters().to_vec();
                replace(&mut parameters, priors)?;
                Ok(fitted(&radiance.with(parameters), observed, *seed, name, like))
            }
        }
    }
}

/// What a fit is like.
#[derive(Clone, Copy)]
struct Like<'a> {
    /// The facets, of a traced model.
    facets: Option<FacetModel>,
    /// Parameters near which it starts; `None` of the answer itself.
    near: Option<&'a [f64]>,
}

/// A fit with its data.
struct Fitted {
    fit: Fit,
    observed: Observed,
    estimation: Estimation,
}

fn fitted(
    model: &dyn Model,
    observed: Observed,
    seed: u64,
    name: &str,
    Like { facets, near }: Like,
) -> Fitted {
    let fitting = Fitting::new(model, &observed);
    let estimation = fitting.run(seed, near);
    let mut fit = summary::fit(model, &observed, &estimation, name, facets);
    if near.is_none() {
        summary::add_profiles(&mut fit, &fitting, &estimation);
    }
    Fitted { fit, observed, estimation }
}

/// A model in every other band.
struct Half<'a> {
    model: &'a dyn Model,
    first: usize,
}

impl Half<'_> {
    fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        all.iter().skip(self.first).step_by(2).cloned().collect()
    }
}

impl Model for Half<'_> {
    fn parameters(&self) -> &[Parameter] {
        self.model.parameters()
    }

    fn evaluate(&self, x: &[f64]) -> Evaluated {
        let whole = self.model.evaluate(x);
        let slopes = whole.slopes.iter().map(|slopes| self.of(slopes)).collect();
        Evaluated { bands: self.of(&whole.bands), slopes }
    }

    fn covariance(&self, x: &[f64]) -> nalgebra::DMatrix<f64> {
        let whole = self.model.covariance(x);
        let places: Vec<usize> = (self.first..whole.nrows()).step_by(2).collect();
        whole.select_rows(&places).select_columns(&places)
    }
}

/// Matches a measured spectrum and writes the result.
///
/// # Errors
/// A spectrum that does not hold the bands, a bed that cannot be made or thinned, too few bands, or
/// a prior that fits no parameter.
pub fn run(options: &Options) -> Result<Match, Error> {
    let Options { monitor, .. } = *options;
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
    known(&options.priors, &options.seen)?;
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
    let halves = halves(&ground, &soil, like(options.facets));
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

/// The fits of every other band.
fn halves(ground: &Ground, soil: &Soil, like: Like) -> Vec<Fit> {
    let Seen::Emissivity { bands, errors, .. } = &ground.options.seen else {
        return Vec::new();
    };
    let of = |(first, name): (usize, &str)| {
        let half = Half { model: soil, first };
        let errors = errors.clone().unwrap_or_else(|| vec![ground.options.error; bands.len()]);
        let observed =
            Observed { um: half.of(&ground.um), bands: half.of(bands), errors: half.of(&errors) };
        fitted(&half, observed, ground.options.seed, name, like).fit
    };
    [(0, "even bands"), (1, "odd bands")].map(of).to_vec()
}

/// What the model's beds are.
fn beds_of(soil: &Soil, estimation: &Estimation) -> Beds {
    let n = soil.um().len();
    let spread = soil.spread(&estimation.best[..=LARGE]);
    let mean = (0..n).map(|i| spread[(i, i)]).sum::<f64>() / n as f64;
    Beds {
        thinned: soil.thinned_covers(),
        fresh: soil.fresh_covers(),
        fresh_less_thinned: soil.fresh_less_thinned(&estimation.best[..=LARGE]),
        spread: mean.sqrt(),
    }
}
