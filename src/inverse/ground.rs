//! What does not depend on a model of facets: the beds, the bands and the priors. Models are made of
//! it and fitted.

use std::path::Path;

use nalgebra::DMatrix;

use super::beds::{self, Settled, Traced};
use super::estimation::{Estimation, Evaluated, Fitting, Model, Observed, Parameter};
use super::facets::{self, FacetModel};
use super::linear::Linear;
use super::measured::Seen;
use super::radiance::{self, Radiance};
use super::result::Fit;
use super::soil::{self, MEDIUM, On, Role, Second, Soil};
use super::{InverseError, Options, summary};
use crate::histogram::kept::Kept;
use crate::spectrum::Spectrum;
use crate::support::error::Error;
use crate::table::TableMaterial;
use crate::table::materials::reflectances;

/// The names of a soil's parameters, in their order.
const NAMES: [&str; 5] = ["cover", "second", "level", "large_fines", "medium_grains"];

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
        of(NAMES[4], 0.0, 0.0, [0.0, 1.0]),
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
pub fn known(priors: &[(String, f64, f64)], seen: &Seen) -> Result<(), Error> {
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

/// Least bands of a fit beyond its parameters.
const LEAST_MORE: usize = 2;

/// An error if the bands are too few for the parameters that are fitted.
pub fn enough(options: &Options) -> Result<(), Error> {
    let Options { spectrum, seen, second, priors, .. } = options;
    let mut fitted = vec![NAMES[0], NAMES[1]];
    fitted.extend(second.is_none().then_some(NAMES[2]));
    if let Seen::Radiance { .. } = seen {
        fitted.extend(radiance::NAMES);
    }
    for (name, _, sd) in priors {
        fitted.retain(|fitted| fitted != name);
        fitted.extend((*sd > 0.0).then_some(name.as_str()));
    }
    let (bands, parameters) = (seen.um().len(), fitted.len());
    let least = parameters + LEAST_MORE;
    if bands >= least {
        return Ok(());
    }
    Err(InverseError::Bands { spectrum: spectrum.clone(), bands, parameters, least }.into())
}

/// The beds and all that does not depend on the facet model.
pub struct Ground<'a> {
    /// What is matched.
    pub options: &'a Options<'a>,
    /// The beds.
    pub settled: Vec<Settled>,
    /// Their materials as the scene has them.
    pub materials: Vec<TableMaterial>,
    /// Wavelengths of the bands, um.
    pub um: Vec<f64>,
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
            let kept = Kept::PLAIN;
            bands.extend(reflectances(&spectra, kept, &self.um)?);
        }
        let traced = beds::trace(&self.settled, &materials, &bands, seed, cache, monitor)?;
        Ok((traced, materials))
    }

    /// The forward model with facets of a kind, and the second component at a place.
    pub fn soil(&self, facets: FacetModel, on: On) -> Result<Soil, Error> {
        let (traced, materials) = self.traced(facets)?;
        let second = self.second(on)?;
        let is_flat = second.emissivity.is_none();
        let mut parameters = soil_parameters(beds::covers(&traced), traced.large_share, is_flat);
        replace(&mut parameters, &self.options.priors)?;
        let Traced { full, fresh, roles, .. } = traced;
        let grains = roles.iter().position(|of| *of == Role::Grains).expect("beds have grains");
        let medium = facets.medium(&materials[grains].spectrum)?;
        if medium.is_none() {
            let name = NAMES[MEDIUM];
            if facets == self.options.facets && self.options.priors.iter().any(|p| p.0 == name) {
                let scene = self.options.scene.file.clone();
                let problem = format!(
                    "{name} needs grains of the shipped coarse quartz, with library or inverted \
                     facets"
                );
                return Err(InverseError::Bed { scene, problem }.into());
            }
            // A model without them compares the rest.
            (parameters[MEDIUM].prior, parameters[MEDIUM].prior_standard_deviation) = (0.0, 0.0);
        }
        let materials = (&materials[..], &roles[..]);
        Ok(Soil::new(&self.um, parameters, second, materials, medium.as_ref(), full, fresh)?)
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
    pub fn linear(&self, roles: &[Role], with_flat: bool) -> Result<Linear, Error> {
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
    pub fn fit(&self, soil: &dyn Model, name: &str, like: Like) -> Result<Fitted, Error> {
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

    /// The fits of every other band; none of radiance.
    pub fn halves(&self, soil: &Soil, like: Like) -> Vec<Fit> {
        let Options { seen, seed, error, .. } = self.options;
        let Seen::Emissivity { bands, errors, .. } = seen else { return Vec::new() };
        let of = |(first, name): (usize, &str)| {
            let half = Half { model: soil, first };
            let errors = errors.clone().unwrap_or_else(|| vec![*error; bands.len()]);
            let observed =
                Observed { um: half.of(&self.um), bands: half.of(bands), errors: half.of(&errors) };
            fitted(&half, observed, *seed, name, like).fit
        };
        [(0, "even bands"), (1, "odd bands")].map(of).to_vec()
    }
}

/// What a fit is like.
#[derive(Clone, Copy)]
pub struct Like<'a> {
    /// The facets, of a traced model.
    pub facets: Option<FacetModel>,
    /// Parameters near which it starts; `None` of the answer itself.
    pub near: Option<&'a [f64]>,
}

/// A fit with its data.
pub struct Fitted {
    /// The report.
    pub fit: Fit,
    /// The bands.
    pub observed: Observed,
    /// The estimation.
    pub estimation: Estimation,
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

    fn bands(&self, x: &[f64]) -> Vec<f64> {
        self.of(&self.model.bands(x))
    }

    fn covariance(&self, x: &[f64]) -> DMatrix<f64> {
        let whole = self.model.covariance(x);
        let places: Vec<usize> = (self.first..whole.nrows()).step_by(2).collect();
        whole.select_rows(&places).select_columns(&places)
    }
}
