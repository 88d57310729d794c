//! The forward model: a soil's emissivity from traced beds.
//!
//! The fines of beds of full cover are taken away in steps. Between the steps the weight that paths
//! bring to the sky is interpolated over the cover. Beds that were dropped anew at other covers
//! correct it: what thinning in place changes is interpolated in straight lines between them. All of
//! this is a weighted sum of bounce tables. So spectra enter exactly, with exact derivatives.

mod weights;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::estimation::{Evaluated, Model, Parameter};
use super::kernel::{self, Smoothness};
use super::thinning::Thinned;
use crate::histogram::tally::CELLS;
use crate::histogram::{Histogram, Shares};
use crate::spectrum::{Spectrum, SpectrumError, kirchhoff};
use crate::table::TableMaterial;
use crate::table::materials::reflectances;
use weights::Weights;

/// Cells of a view.
const ALL_CELLS: usize = (CELLS * CELLS) as usize;

/// Length over which errors of facet spectra are correlated, um: about the width of their features.
const SPECTRA_LENGTH_UM: f64 = 0.2;

/// Standard error of a facet's emissivity where its spectrum does not state one: that of measured
/// powders, two samples of which differ as much.
const SPECTRA_ERROR: f64 = 0.01;

/// The standard error of a spectrum's facets, or a usual one where it is not known.
pub(super) fn known_error(spectrum: &Spectrum, um: f64) -> Result<f64, SpectrumError> {
    let known = spectrum.error(um)?;
    Ok(if spectrum.has_error() { known } else { known.max(SPECTRA_ERROR) })
}

/// Where the second component is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum On {
    /// On a share of the fines' facets
    Fines,
    /// On a share of the grains' facets
    Grains,
    /// On a share of all facets
    #[default]
    All,
}

impl On {
    /// All places.
    pub const ALL: [Self; 3] = [Self::Fines, Self::Grains, Self::All];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fines => "fines",
            Self::Grains => "grains",
            Self::All => "all",
        }
    }
}

/// The second component.
#[derive(Debug, Clone, PartialEq)]
pub struct Second {
    /// Its emissivity by band; `None` for a spectrally flat one, whose level is a parameter.
    pub emissivity: Option<Vec<f64>>,
    /// Where it is.
    pub on: On,
}

/// What a material of the beds is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Facets of fines.
    Fines,
    /// Facets of the grains' bodies.
    Grains,
    /// Anything else.
    Other,
}

/// A bed of full cover, thinned.
#[derive(Debug, Clone)]
pub struct FullBed {
    /// The steps, by ascending cover.
    pub steps: Vec<Thinned>,
    /// Steps with fewer large fines, by ascending cover.
    pub fewer_large: Vec<(Thinned, LargeShare)>,
}

/// Shares of the large ones among fines, by number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargeShare {
    /// In this step.
    pub here: f64,
    /// In the others.
    pub usual: f64,
}

/// Places of the parameters.
pub const COVER: usize = 0;
/// Share of the second component.
pub const SECOND: usize = 1;
/// Emissivity of a spectrally flat second component.
pub const LEVEL: usize = 2;
/// Share of the large fines.
pub const LARGE: usize = 3;
/// Share of the grains' facets that have the spectrum of finer grains.
pub const MEDIUM: usize = 4;

/// The forward model.
pub struct Soil {
    um: Vec<f64>,
    parameters: Vec<Parameter>,
    second: Second,
    roles_of_materials: Vec<Role>,
    /// The role of each symbol of the tables.
    roles: Vec<Role>,
    /// By band, the reflectance of each symbol without the second component.
    reflectances: Vec<Vec<f64>>,
    /// By band, the reflectance of facets of finer grains; none where it is not known.
    medium: Option<Vec<f64>>,
    /// By band, the standard error of the facets' emissivity: of fines, of grains.
    errors: Vec<[f64; 2]>,
    full: Vec<FullBed>,
    fresh: Vec<Thinned>,
    /// The histograms of all steps of all full beds, of the mixes, then of the fresh ones.
    shares: Shares,
}

impl Soil {
    /// The model of beds with these materials, at wavelengths in um.
    ///
    /// # Errors
    /// A spectrum does not hold a wavelength.
    pub fn new(
        um: &[f64],
        parameters: Vec<Parameter>,
        second: Second,
        (materials, roles): (&[TableMaterial], &[Role]),
        medium: Option<&Spectrum>,
        full: Vec<FullBed>,
        fresh: Vec<Thinned>,
    ) -> Result<Self, SpectrumError> {
        let histograms: Vec<&Histogram> = all(&full, &fresh).map(|of| &of.histogram).collect();
        let kept = histograms[0].kept;
        let spectra: Vec<&Spectrum> = materials.iter().map(|m| &m.spectrum).collect();
        let error = |role: Role, um: f64| -> Result<f64, SpectrumError> {
            let place = roles.iter().position(|of| *of == role);
            place.map_or(Ok(0.0), |i| known_error(spectra[i], um))
        };
        let errors = um.iter().map(|&um| Ok([error(Role::Fines, um)?, error(Role::Grains, um)?]));
        let reflectance = |spectrum: &Spectrum| -> Result<Vec<f64>, SpectrumError> {
            um.iter().map(|&um| Ok(kirchhoff(spectrum.emissivity(um)?))).collect()
        };
        let symbols = roles.iter().flat_map(|&role| vec![role; kept.of_material()]);
        let symbols: Vec<Role> = symbols.collect();
        let reflectances = reflectances(&spectra, kept, um)?;
        let first = first_alike(&symbols, &reflectances);
        let shares = Shares::of_kinds(&histograms, &|symbol| first[usize::from(symbol)]);
        Ok(Self {
            um: um.to_vec(),
            parameters,
            second,
            roles_of_materials: roles.to_vec(),
            roles: symbols,
            reflectances,
            medium: medium.map(reflectance).transpose()?,
            errors: errors.collect::<Result<_, SpectrumError>>()?,
            shares,
            full,
            fresh,
        })
    }

    /// The least and the greatest cover of the beds.
    pub fn covers(full: &[FullBed]) -> [f64; 2] {
        let ends = |of: fn(&[Thinned]) -> Option<&Thinned>, pick: fn(f64, f64) -> f64| {
            full.iter().filter_map(|bed| Some(of(&bed.steps)?.cover)).reduce(pick)
        };
        let least = ends(<[Thinned]>::first, f64::max).unwrap_or(0.0);
        [least, ends(<[Thinned]>::last, f64::min).unwrap_or(1.0)]
    }

    /// Wavelengths, um.
    pub fn um(&self) -> &[f64] {
        &self.um
    }

    /// The role of each material.
    pub fn roles_of_materials(&self) -> &[Role] {
        &self.roles_of_materials
    }

    /// The covers of the steps of each bed of full cover.
    pub fn thinned_covers(&self) -> Vec<Vec<f64>> {
        self.full.iter().map(|bed| bed.steps.iter().map(|step| step.cover).collect()).collect()
    }

    /// The covers of the beds that were dropped anew.
    pub fn fresh_covers(&self) -> Vec<f64> {
        self.fresh.iter().map(|fresh| fresh.cover).collect()
    }

    /// The emissivity of each fresh bed less that of the thinned ones at its cover, near 9 um.
    pub fn fresh_less_thinned(&self, x: &[f64]) -> Vec<f64> {
        let off = |band: &usize| (self.um[*band] - 9.0).abs();
        let nearest = (0..self.um.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        let Some(rho) = nearest.map(|band| self.mixed(band, x)) else { return Vec::new() };
        let number = all(&self.full, &self.fresh).count();
        let of = |(i, fresh): (usize, &Thinned)| {
            let mut weights = Weights::none(number);
            self.add_thinned(&mut weights, fresh.cover, [1.0, 0.0], false);
            weights.value[number - self.fresh.len() + i] -= 1.0;
            let mixture = self.shares.mixture(&weights.value);
            self.shares.value(&mixture, &rho)
        };
        self.fresh.iter().enumerate().map(of).collect()
    }

    /// The share of the second component on facets of a role.
    fn share_on(&self, role: Role, share: f64) -> f64 {
        match (self.second.on, role) {
            (_, Role::Other) | (On::Fines, Role::Grains) | (On::Grains, Role::Fines) => 0.0,
            _ => share,
        }
    }

    /// The reflectance of the second component in a band.
    fn second(&self, band: usize, x: &[f64]) -> f64 {
        kirchhoff(self.second.emissivity.as_ref().map_or(x[LEVEL], |of| of[band]))
    }

    /// What the facets of finer grains reflect more than those of a symbol.
    fn medium(&self, band: usize, rho: f64, role: Role) -> f64 {
        match &self.medium {
            Some(medium) if role == Role::Grains => medium[band] - rho,
            _ => 0.0,
        }
    }

    /// The reflectance of each symbol without the second component.
    fn pure(&self, band: usize, x: &[f64]) -> Vec<f64> {
        let all = self.reflectances[band].iter().zip(&self.roles);
        all.map(|(&rho, &role)| rho + x[MEDIUM] * self.medium(band, rho, role)).collect()
    }

    /// The reflectance of each symbol with the second component.
    fn mixed(&self, band: usize, x: &[f64]) -> Vec<f64> {
        let second = self.second(band, x);
        let of = |(rho, role): (f64, &Role)| {
            let share = self.share_on(*role, x[SECOND]);
            (1.0 - share) * rho + share * second
        };
        self.pure(band, x).into_iter().zip(&self.roles).map(of).collect()
    }
}

/// For each symbol the first one of the same role and the same reflectance in all bands.
fn first_alike(roles: &[Role], reflectances: &[Vec<f64>]) -> Vec<u16> {
    let alike = |a: usize, b: usize| {
        roles[a] == roles[b] && reflectances.iter().all(|band| band[a] == band[b])
    };
    let first = |of: usize| (0..of).find(|&other| alike(other, of)).unwrap_or(of) as u16;
    (0..roles.len()).map(first).collect()
}

/// All traced beds, in the order of the histograms.
fn all<'a>(full: &'a [FullBed], fresh: &'a [Thinned]) -> impl Iterator<Item = &'a Thinned> {
    let fewer = |bed: &'a FullBed| bed.fewer_large.iter().map(|(step, _)| step);
    full.iter().flat_map(move |bed| bed.steps.iter().chain(fewer(bed))).chain(fresh)
}

impl Model for Soil {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn evaluate(&self, x: &[f64]) -> Evaluated {
        let weights = self.weights(x[COVER], x[LARGE]);
        let mixtures = [weights.value, weights.by_cover, weights.by_large]
            .map(|weights| self.shares.mixture(&weights));
        let mixtures = mixtures.each_ref().map(Vec::as_slice);
        let of = |band: usize| {
            let rho = self.mixed(band, x);
            let second = self.second(band, x);
            let pure = self.pure(band, x);
            let by_share: Vec<f64> = (pure.iter().zip(&self.roles))
                .map(|(pure, role)| self.share_on(*role, 1.0) * (second - pure))
                .collect();
            let by_medium: Vec<f64> = (self.reflectances[band].iter().zip(&self.roles))
                .map(|(&rho, &role)| {
                    (1.0 - self.share_on(role, x[SECOND])) * self.medium(band, rho, role)
                })
                .collect();
            // A level of emissivity lowers the reflectance.
            let by_level: Vec<f64> =
                self.roles.iter().map(|role| -self.share_on(*role, x[SECOND])).collect();
            let sum = self.shares.weight(&mixtures, &rho, &[&by_share, &by_level, &by_medium]);
            let level = if self.second.emissivity.is_none() { -sum.slopes[1] } else { 0.0 };
            let [share, medium] = [-sum.slopes[0], -sum.slopes[2]];
            (1.0 - sum.values[0], [-sum.values[1], share, level, -sum.values[2], medium])
        };
        let bands: Vec<(f64, [f64; 5])> = (0..self.um.len()).into_par_iter().map(of).collect();
        Evaluated {
            bands: bands.iter().map(|(value, _)| *value).collect(),
            slopes: (0..5).map(|i| bands.iter().map(|(_, slopes)| slopes[i]).collect()).collect(),
        }
    }

    fn bands(&self, x: &[f64]) -> Vec<f64> {
        let mixture = self.shares.mixture(&self.weights(x[COVER], x[LARGE]).value);
        let of = |band: usize| 1.0 - self.shares.value(&mixture, &self.mixed(band, x));
        (0..self.um.len()).map(of).collect()
    }

    /// Spread of the beds and errors of the facets' spectra. What was seen may be as small as one
    /// bed, with a chance of its own.
    fn covariance(&self, x: &[f64]) -> DMatrix<f64> {
        self.spread(x) * (1.0 + self.full.len() as f64) + self.of_spectra(x)
    }
}

impl Soil {
    /// The covariance by the spread of the beds, from the cells of their views.
    pub fn spread(&self, x: &[f64]) -> DMatrix<f64> {
        let weights = self.weights(x[COVER], x[LARGE]).value;
        let n = self.um.len();
        let rho: Vec<Vec<f64>> = (0..n).map(|band| self.mixed(band, x)).collect();
        let mut sum = DMatrix::zeros(n, n);
        let histograms: Vec<&Thinned> = all(&self.full, &self.fresh).collect();
        let mut first = 0;
        let of_full = self.full.iter().map(|bed| bed.steps.len() + bed.fewer_large.len());
        for count in of_full.chain(self.fresh.iter().map(|_| 1)) {
            let of_bed: Vec<(f64, &Histogram)> = (first..first + count)
                .filter(|&i| weights[i] != 0.0)
                .filter_map(|i| Some((weights[i], histograms[i].cells.as_ref()?)))
                .collect();
            if !of_bed.is_empty() {
                sum += kernel::of_mean(&cells(&of_bed, &rho));
            }
            first += count;
        }
        sum
    }

    /// The covariance by the errors of the facets' spectra.
    fn of_spectra(&self, x: &[f64]) -> DMatrix<f64> {
        let weights = self.weights(x[COVER], x[LARGE]).value;
        let mixture = self.shares.mixture(&weights);
        let n = self.um.len();
        let mut sum = DMatrix::zeros(n, n);
        for (i, role) in [Role::Fines, Role::Grains].into_iter().enumerate() {
            let own = 1.0 - self.share_on(role, x[SECOND]);
            let direction: Vec<f64> =
                self.roles.iter().map(|of| if *of == role { own } else { 0.0 }).collect();
            let of = |band: usize| {
                let rho = self.mixed(band, x);
                self.shares.weight(&[&mixture], &rho, &[&direction]).slopes[0]
                    * self.errors[band][i]
            };
            let off: Vec<f64> = (0..n).into_par_iter().map(of).collect();
            sum += kernel::covariance(&self.um, &off, SPECTRA_LENGTH_UM, Smoothness::Rough);
        }
        sum
    }
}

/// For each cell of a view its curve: the sum of histograms with these weights.
fn cells(of_bed: &[(f64, &Histogram)], rho: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let of_band = |rho: &Vec<f64>| {
        let mut sum = [0.0; ALL_CELLS];
        for (weight, histogram) in of_bed {
            let cells = histogram.weight_of_groups::<ALL_CELLS>(rho);
            sum.iter_mut().zip(cells).for_each(|(sum, cell)| *sum += weight * cell);
        }
        sum
    };
    let bands: Vec<[f64; ALL_CELLS]> = rho.par_iter().map(of_band).collect();
    (0..ALL_CELLS).map(|cell| bands.iter().map(|band| band[cell]).collect()).collect()
}
