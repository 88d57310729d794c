//! From an estimation to what is reported of it.

use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::Warning;
use super::discrepancy::root_mean_square;
use super::estimation::{Estimation, Fitting, Model, Observed};
use super::facets::FacetModel;
use super::result::{Autocorrelation, ChiSquare, Fit, Fitted, Match, OtherMinimum, Profile};
use super::soil::COVER;
use crate::support::math;

/// Correlations beyond this are warned of.
const CORRELATED: f64 = 0.95;
/// Degrees of freedom below which a parameter is not told by the bands.
const TOLD: f64 = 0.5;
/// Residuals beyond this speak against a fit.
const GOOD: f64 = 0.03;
/// Another minimum is warned of where its residuals are less than so many times as large.
const AS_GOOD: f64 = 1.5;
/// Effective draws below which the errors are uncertain themselves.
const DRAWN: f64 = 100.0;
/// Steps of a profile likelihood.
const PROFILE: usize = 25;
/// Distances of the autocorrelation, um.
const DISTANCES_UM: [f64; 7] = [0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2];

/// The report of a fit.
pub fn fit(
    model: &dyn Model,
    observed: &Observed,
    found: &Estimation,
    name: &str,
    facets: Option<FacetModel>,
) -> Fit {
    let residuals = residuals(observed, found);
    let n = model.parameters().len();
    let rows = |matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
        (0..n).map(|i| (0..n).map(|j| matrix[(i, j)]).collect()).collect()
    };
    let covariance = covariance(&found.draws);
    let degrees_of_freedom = found.averaging.trace();
    let freedom = observed.um.len() as f64 - degrees_of_freedom;
    let chi_square = |value: f64| ChiSquare { value, freedom, p: chance(value, freedom) };
    let parameter = |(place, parameter): (usize, &super::estimation::Parameter)| {
        let mut draws: Vec<f64> = found.draws.iter().map(|draw| draw[place]).collect();
        draws.sort_by(f64::total_cmp);
        let at = |share: f64| draws[((draws.len() - 1) as f64 * share).round() as usize];
        let interval_95 = [at(0.025), at(0.975)];
        Fitted {
            parameter: parameter.clone(),
            best: found.best[place],
            mean: draws.iter().sum::<f64>() / draws.len() as f64,
            standard_error: covariance[(place, place)].sqrt(),
            interval_95,
            degrees_of_freedom: found.averaging[(place, place)],
            at_bound: found.held[place],
            profile: None,
        }
    };
    Fit {
        model: name.to_owned(),
        facets,
        parameters: model.parameters().iter().enumerate().map(parameter).collect(),
        covariance: rows(&covariance),
        averaging_kernel: rows(&found.averaging),
        degrees_of_freedom,
        rms: root_mean_square(&residuals),
        discrepancy: found.discrepancy,
        known_errors: chi_square(found.chi_square[0]),
        with_discrepancy: chi_square(found.chi_square[1]),
        ln_evidence: found.evidence,
        autocorrelation: autocorrelation(&observed.um, &residuals),
        effective_draws: found.effective,
        other_minimum: found.other.as_ref().map(|other| other_minimum(model, observed, other)),
        converged: found.converged,
    }
}

fn other_minimum(model: &dyn Model, observed: &Observed, at: &[f64]) -> OtherMinimum {
    let fitted = model.bands(at);
    let off: Vec<f64> =
        observed.bands.iter().zip(fitted).map(|(seen, fitted)| seen - fitted).collect();
    OtherMinimum { parameters: at.to_vec(), rms: root_mean_square(&off) }
}

/// Adds the profile likelihoods of parameters whose interval comes near a bound.
pub fn add_profiles(fit: &mut Fit, fitting: &Fitting, found: &Estimation) {
    for (place, fitted) in fit.parameters.iter_mut().enumerate() {
        let ([low, high], [from, to]) = (fitted.parameter.bounds, fitted.interval_95);
        let room = 0.02 * (high - low);
        let is_free = fitted.parameter.prior_standard_deviation > 0.0;
        if is_free && (from < low + room || to > high - room) {
            fitted.profile = Some(profile(fitting, found, place, [from, to], [low, high]));
        }
    }
}

/// The profile likelihood about the interval of a parameter.
fn profile(
    fitting: &Fitting,
    found: &Estimation,
    place: usize,
    [from, to]: [f64; 2],
    [low, high]: [f64; 2],
) -> Profile {
    let room = 0.25 * (to - from);
    let (from, to) = ((from - room).max(low), (to + room).min(high));
    let step = (to - from) / (PROFILE - 1) as f64;
    let values: Vec<f64> = (0..PROFILE).map(|i| from + step * i as f64).collect();
    let ln_likelihood = fitting.profile(found, place, &values);
    Profile { values, ln_likelihood }
}

/// Measured less fitted.
pub fn residuals(observed: &Observed, found: &Estimation) -> Vec<f64> {
    let fitted = &found.evaluated.bands;
    observed.bands.iter().zip(fitted).map(|(seen, fitted)| seen - fitted).collect()
}

/// The probability of a chi-square as great or greater by chance.
fn chance(chi_square: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom.max(1.0)).map_or(1.0, |of| of.sf(chi_square))
}

/// The covariance of draws.
fn covariance(draws: &[Vec<f64>]) -> DMatrix<f64> {
    let (n, p) = (draws.len(), draws[0].len());
    let all = DMatrix::from_fn(n, p, |i, j| draws[i][j]);
    let mean = all.row_mean();
    let off = DMatrix::from_fn(n, p, |i, j| all[(i, j)] - mean[j]);
    off.tr_mul(&off) / n as f64
}

/// The correlation of pairs of residuals by their distance.
fn autocorrelation(um: &[f64], residuals: &[f64]) -> Vec<Autocorrelation> {
    let variance = root_mean_square(residuals).powi(2);
    let mut from = 0.0;
    let mut all = Vec::new();
    for to in DISTANCES_UM {
        let (mut sum, mut distances, mut pairs) = (0.0, 0.0, 0.0);
        for i in 0..um.len() {
            for j in i + 1..um.len() {
                let distance = um[j] - um[i];
                if distance > from && distance <= to {
                    sum += residuals[i] * residuals[j];
                    distances += distance;
                    pairs += 1.0;
                }
            }
        }
        if pairs > 0.0 && variance > 0.0 {
            let (distance_um, correlation) = (distances / pairs, sum / pairs / variance);
            all.push(Autocorrelation { distance_um, correlation });
        }
        from = to;
    }
    all
}

/// What to mind of a match.
pub fn warnings(result: &Match, observed: &Observed, found: &Estimation) -> Vec<Warning> {
    let answer = &result.answer;
    let mut warnings = Vec::new();
    if answer.rms > GOOD {
        let bands_um = runs_beyond(&observed.um, &residuals(observed, found), GOOD);
        warnings.push(Warning::NoGoodFit { rms: answer.rms, bands_um });
    }
    let free: Vec<usize> = (0..answer.parameters.len())
        .filter(|&i| answer.parameters[i].parameter.prior_standard_deviation > 0.0)
        .collect();
    let name = |place: usize| answer.parameters[place].parameter.name.clone();
    for (n, &i) in free.iter().enumerate() {
        for &j in &free[n + 1..] {
            let of = &answer.covariance;
            let correlation = of[i][j] / (of[i][i] * of[j][j]).sqrt();
            if correlation.abs() > CORRELATED {
                warnings.push(Warning::Correlated { one: name(i), other: name(j), correlation });
            }
        }
    }
    for &i in &free {
        let fitted = &answer.parameters[i];
        let degrees_of_freedom = fitted.degrees_of_freedom;
        if degrees_of_freedom < TOLD {
            warnings.push(Warning::NotTold { parameter: name(i), degrees_of_freedom });
        }
        if fitted.at_bound {
            warnings.push(Warning::AtBound { parameter: name(i), bound: fitted.best });
        }
    }
    let cover = |fit: &Fit| (fit.parameters[COVER].mean, fit.parameters[COVER].standard_error);
    let (ours, error) = cover(answer);
    for other in result.other_facets.iter().chain(&result.other_places) {
        let (theirs, their_error) = cover(other);
        if (ours - theirs).abs() > math::hypot(error, their_error) {
            let (model, cover) = (other.model.clone(), [theirs, their_error]);
            warnings.push(Warning::ModelsDiffer { model, cover });
        }
    }
    if let [even, odd] = &result.halves[..] {
        let covers = [cover(even).0, cover(odd).0];
        if (covers[0] - covers[1]).abs() > error {
            warnings.push(Warning::HalvesDiffer { covers });
        }
    }
    if answer.effective_draws < DRAWN {
        warnings.push(Warning::FewDraws { effective: answer.effective_draws });
    }
    // A minimum whose fit is much worse is no answer, and the errors hold one within the interval.
    let [low, high] = answer.parameters[COVER].interval_95;
    let is_other = |other: &&OtherMinimum| {
        other.rms < AS_GOOD * answer.rms && !(low..=high).contains(&other.parameters[COVER])
    };
    if let Some(other) = answer.other_minimum.as_ref().filter(is_other) {
        warnings.push(Warning::SeveralMinima { cover: other.parameters[COVER], rms: other.rms });
    }
    if let Some(linear) = result.linear.last().filter(|linear| linear.rms < answer.rms) {
        warnings.push(Warning::LinearIsBetter { rms: linear.rms });
    }
    warnings
}

/// Runs of bands whose residual is beyond a limit: the first and the last of each, um.
fn runs_beyond(um: &[f64], residuals: &[f64], limit: f64) -> Vec<[f64; 2]> {
    let places: Vec<usize> = (0..um.len()).filter(|&i| residuals[i].abs() > limit).collect();
    let runs = places.chunk_by(|a, b| b - a == 1);
    runs.map(|run| [um[run[0]], um[run[run.len() - 1]]].map(|um| (um * 100.0).round() / 100.0))
        .collect()
}
