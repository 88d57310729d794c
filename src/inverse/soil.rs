//! The forward model: a soil's emissivity from traced beds.
//!
//! The fines of beds of full cover are taken away in steps. Between the steps the weight that paths
//! bring to the sky is interpolated over the cover. Beds that were dropped anew at other covers
//! correct it: what thinning in place changes is interpolated in straight lines between them. All of
//! this is a weighted sum of bounce tables. So spectra enter exactly, with exact derivatives.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::estimation::{Evaluated, Model, Parameter};
use super::kernel;
use super::thinning::Thinned;
use crate::histogram::tally::CELLS;
use crate::histogram::{Histogram, Shares};
use crate::spectrum::{Spectrum, SpectrumError, kirchhoff};
use crate::support::hermite;
use crate::table::TableMaterial;
use crate::table::materials::reflectances;

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

/// Covers that differ by less are taken as one where beds were dropped anew.
const ALIKE: f64 = 0.12;

/// Places of the parameters.
pub const COVER: usize = 0;
/// Share of the second component.
pub const SECOND: usize = 1;
/// Emissivity of a spectrally flat second component.
pub const LEVEL: usize = 2;
/// Share of the large fines.
pub const LARGE: usize = 3;

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
    /// By band, the standard error of the facets' emissivity: of fines, of grains.
    errors: Vec<[f64; 2]>,
    full: Vec<FullBed>,
    fresh: Vec<Thinned>,
    /// The histograms of all steps of all full beds, of the mixes, then of the fresh ones.
    shares: Shares,
}

/// Weights of the histograms in a sum, and their derivatives in the cover and in the large fines.
struct Weights {
    value: Vec<f64>,
    by_cover: Vec<f64>,
    by_large: Vec<f64>,
}

impl Weights {
    fn none(number: usize) -> Self {
        let none = vec![0.0; number];
        Self { value: none.clone(), by_cover: none.clone(), by_large: none }
    }
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
        let symbols = roles.iter().flat_map(|&role| vec![role; kept.of_material()]);
        Ok(Self {
            um: um.to_vec(),
            parameters,
            second,
            roles_of_materials: roles.to_vec(),
            roles: symbols.collect(),
            reflectances: reflectances(&spectra, kept, um)?,
            errors: errors.collect::<Result<_, SpectrumError>>()?,
            shares: Shares::of(&histograms),
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
            self.shares.weight(&[&mixture], &rho, &[]).values[0]
        };
        self.fresh.iter().enumerate().map(of).collect()
    }

    /// The weights of the histograms for a cover and a share of large fines.
    fn weights(&self, cover: f64, large: f64) -> Weights {
        let number = all(&self.full, &self.fresh).count();
        let mut of = Weights::none(number);
        self.add_thinned(&mut of, cover, [1.0, 0.0], true);
        self.add_large(&mut of, cover, large);
        let groups = self.groups();
        // The places of what is dropped anew; there is nothing to correct at full cover.
        let mut places: Vec<f64> = groups.iter().map(|(cover, _)| *cover).collect();
        places.push(Self::covers(&self.full)[1]);
        let first = number - self.fresh.len();
        for (i, (_, beds)) in groups.iter().enumerate() {
            let (share, slope) = hat(&places, i, cover);
            if (share, slope) == (0.0, 0.0) {
                continue;
            }
            let each = 1.0 / beds.len() as f64;
            for &bed in beds {
                // The correction there: fresh less thinned.
                let at = self.fresh[bed].cover;
                self.add_thinned(&mut of, at, [-share * each, -slope * each], false);
                of.value[first + bed] += share * each;
                of.by_cover[first + bed] += slope * each;
            }
        }
        of
    }

    /// Adds the thinned beds at a cover, times a factor that may itself have a slope in the cover.
    fn add_thinned(&self, to: &mut Weights, cover: f64, [factor, slope]: [f64; 2], moves: bool) {
        let beds = self.full.len() as f64;
        let mut first = 0;
        for bed in &self.full {
            let covers: Vec<f64> = bed.steps.iter().map(|step| step.cover).collect();
            let (value, by_cover) = hermite::weights(&covers, cover);
            for (i, (value, by_cover)) in value.iter().zip(&by_cover).enumerate() {
                let moved = if moves { factor * by_cover } else { 0.0 };
                to.value[first + i] += factor * value / beds;
                to.by_cover[first + i] += (slope * value + moved) / beds;
            }
            first += covers.len() + bed.fewer_large.len();
        }
    }

    /// Adds the effect of the share of large fines: linear in it, interpolated over the cover.
    fn add_large(&self, to: &mut Weights, cover: f64, large: f64) {
        let beds = self.full.len() as f64;
        let mut first = 0;
        for bed in &self.full {
            let others: Vec<f64> = bed.fewer_large.iter().map(|(step, _)| step.cover).collect();
            let covers: Vec<f64> = bed.steps.iter().map(|step| step.cover).collect();
            let own = first + covers.len();
            first = own + others.len();
            if others.is_empty() {
                continue;
            }
            let (value, by_cover) = hermite::weights(&others, cover);
            for (i, (step, LargeShare { here, usual })) in bed.fewer_large.iter().enumerate() {
                let per_share = 1.0 / ((usual - here) * beds);
                let (of, more) = (value[i] * per_share, large - usual);
                let by_cover = by_cover[i] * per_share;
                let mut add = |place: usize, sign: f64| {
                    to.value[place] += sign * of * more;
                    to.by_cover[place] += sign * by_cover * more;
                    to.by_large[place] += sign * of;
                };
                add(own + i, -1.0);
                // The same cover with the usual share.
                let (same, _) = hermite::weights(&covers, step.cover);
                same.iter().enumerate().for_each(|(i, w)| add(own - covers.len() + i, *w));
            }
        }
    }

    /// The fresh beds in groups of nearly one cover: their mean cover and their numbers. Beds that
    /// differ by chance at nearly the same cover would make a false slope between them; for the same
    /// reason those near full cover are left out.
    fn groups(&self) -> Vec<(f64, Vec<usize>)> {
        let top = Self::covers(&self.full)[1];
        let cover = |bed: usize| self.fresh[bed].cover;
        let mut order: Vec<usize> =
            (0..self.fresh.len()).filter(|&bed| cover(bed) <= top - ALIKE).collect();
        order.sort_by(|&a, &b| cover(a).total_cmp(&cover(b)));
        let of = |beds: &[usize]| {
            let sum: f64 = beds.iter().map(|&bed| cover(bed)).sum();
            (sum / beds.len() as f64, beds.to_vec())
        };
        order.chunk_by(|&a, &b| cover(b) - cover(a) < ALIKE).map(of).collect()
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

    /// The reflectance of each symbol with the second component.
    fn mixed(&self, band: usize, x: &[f64]) -> Vec<f64> {
        let second = self.second(band, x);
        let of = |(rho, role): (&f64, &Role)| {
            let share = self.share_on(*role, x[SECOND]);
            (1.0 - share) * rho + share * second
        };
        self.reflectances[band].iter().zip(&self.roles).map(of).collect()
    }
}

/// All traced beds, in the order of the histograms.
fn all<'a>(full: &'a [FullBed], fresh: &'a [Thinned]) -> impl Iterator<Item = &'a Thinned> {
    let fewer = |bed: &'a FullBed| bed.fewer_large.iter().map(|(step, _)| step);
    full.iter().flat_map(move |bed| bed.steps.iter().chain(fewer(bed))).chain(fresh)
}

/// The value and the slope of the curve of straight lines that is 1 at one place and 0 at all
/// others; constant beyond the ends.
fn hat(places: &[f64], number: usize, at: f64) -> (f64, f64) {
    let here = places[number];
    if at <= here {
        return match number.checked_sub(1).map(|before| places[before]) {
            None => (1.0, 0.0),
            Some(before) if at <= before => (0.0, 0.0),
            Some(before) => ((at - before) / (here - before), 1.0 / (here - before)),
        };
    }
    match places.get(number + 1) {
        None => (1.0, 0.0),
        Some(after) if at >= *after => (0.0, 0.0),
        Some(after) => ((after - at) / (after - here), -1.0 / (after - here)),
    }
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
            let pure = &self.reflectances[band];
            let by_share: Vec<f64> = (pure.iter().zip(&self.roles))
                .map(|(pure, role)| self.share_on(*role, 1.0) * (second - pure))
                .collect();
            // A level of emissivity lowers the reflectance.
            let by_level: Vec<f64> =
                self.roles.iter().map(|role| -self.share_on(*role, x[SECOND])).collect();
            let sum = self.shares.weight(&mixtures, &rho, &[&by_share, &by_level]);
            let level = if self.second.emissivity.is_none() { -sum.slopes[1] } else { 0.0 };
            (1.0 - sum.values[0], [-sum.values[1], -sum.slopes[0], level, -sum.values[2]])
        };
        let bands: Vec<(f64, [f64; 4])> = (0..self.um.len()).into_par_iter().map(of).collect();
        Evaluated {
            bands: bands.iter().map(|(value, _)| *value).collect(),
            slopes: (0..4).map(|i| bands.iter().map(|(_, slopes)| slopes[i]).collect()).collect(),
        }
    }

    /// Spread of the beds and errors of the facets' spectra.
    fn covariance(&self, x: &[f64]) -> DMatrix<f64> {
        self.spread(x) + self.of_spectra(x)
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
            sum += kernel::covariance(&self.um, &off, SPECTRA_LENGTH_UM);
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
