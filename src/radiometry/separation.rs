//! Temperature-emissivity separation: a target's temperature from its radiance alone.
//!
//! Each method gives the temperature; Eq. 2 then gives the emissivity.

use serde::{Deserialize, Serialize};

use super::{
    Assumed, Measured, RadiometryError, Temperature, brightness_temperature_k, emissivity, planck,
    planck_derivative,
};

use crate::support::math;

/// A method of temperature-emissivity separation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Method {
    /// Normalised emissivities, then the least emissivity from the contrast (Gillespie et al. 1998)
    Nem,
    /// The temperature that leaves least of the sky's lines in the emissivity (ISSTES)
    Smoothness,
    /// The brightness temperature at 7.36 um, where the emissivity of quartz is nearly 1
    Christiansen,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 3] = [Self::Nem, Self::Smoothness, Self::Christiansen];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nem => "nem",
            Self::Smoothness => "smoothness",
            Self::Christiansen => "christiansen",
        }
    }
}

/// The largest emissivity, with which NEM begins.
const NEM_EMISSIVITY: f64 = 0.99;
/// Range of the bands for the contrast, um: that of the instrument of the regression.
const MMD_UM: [f64; 2] = [8.0, 12.0];
/// Root mean square error of the largest emissivity over the shipped spectra of quartz and the
/// settled patch (.0006 to .049). Over the data of the regression it is .015 (Gillespie et al.,
/// ATBD 2.4, 1999).
const NEM_ERROR: f64 = 0.035;
/// Range in which the emissivity of quartz is nearly 1, um.
const CHRISTIANSEN_UM: [f64; 2] = [7.33, 7.39];
/// Emissivity of quartz soils there, with its standard error: 21 measured soils of the ECOSTRESS
/// library have .9835 +- .0072.
const CHRISTIANSEN_SOIL: [f64; 2] = [0.984, 0.008];
/// The same of powders of quartz alone: measured ones have .997 to 1.000 at 7.344 to 7.354 um.
const CHRISTIANSEN_QUARTZ: [f64; 2] = [0.997, 0.003];
/// Width over which brightness temperatures and contrasts are averaged, um. Without it the largest
/// of many noisy bands would be the noisiest; features of minerals are wider than this.
const WINDOW_UM: f64 = 0.1;
/// Range of the search for smoothness, relative to the highest brightness temperature, K.
const SEARCH_K: [f64; 2] = [-2.0, 40.0];
/// Smoothness needs lines in the sky. With temperature the roughness of the emissivity must change
/// at least this many times faster than the emissivity itself.
const LEAST_SIGNAL: f64 = 3.0;

/// Finds the temperature of a target from its radiance in bands of ascending wavelength.
///
/// The error includes the noise, the error of the method and the error of the sky.
///
/// # Errors
/// Bands from which the method cannot find the temperature, with the reason.
pub fn separate(
    method: Method,
    bands: &[Measured],
    assumed: Assumed,
) -> Result<Temperature, RadiometryError> {
    let of = |bands: &[Measured]| match method {
        Method::Nem => nem(bands, assumed),
        Method::Smoothness => smoothness(bands, assumed),
        Method::Christiansen => christiansen(bands, assumed),
    };
    let found = of(bands)?;
    if assumed.downwelling_error == 0.0 {
        return Ok(found);
    }
    let brighter = |b: &Measured| Measured {
        l_downwelling: b.l_downwelling * (1.0 + assumed.downwelling_error),
        ..*b
    };
    let moved = of(&bands.iter().map(brighter).collect::<Vec<_>>())?;
    Ok(Temperature { error_k: math::hypot(found.error_k, moved.k - found.k), ..found })
}

fn refused(method: Method, problem: impl Into<String>) -> RadiometryError {
    RadiometryError::Separation { method: method.name(), problem: problem.into() }
}

/// Temperature of a band from its emissivity, with the two parts of its standard error, K.
struct Band {
    k: f64,
    /// Standard error from the noise.
    noise_k: f64,
    /// Standard error from the emissivity, common to all bands.
    common_k: f64,
}

impl Band {
    fn of(b: &Measured, emissivity: f64, emissivity_error: f64) -> Option<Self> {
        let l_emitted = b.l_target - (1.0 - emissivity) * b.l_downwelling;
        let k = brightness_temperature_k(b.wavelength_um, l_emitted / emissivity)?;
        let slope = emissivity * planck_derivative(b.wavelength_um, k);
        let by_emissivity = (planck(b.wavelength_um, k) - b.l_downwelling) * emissivity_error;
        Some(Self { k, noise_k: b.l_target_error / slope, common_k: by_emissivity.abs() / slope })
    }

    /// The mean over bands, at least one.
    fn mean(bands: &[Self]) -> Temperature {
        let n = bands.len() as f64;
        let sum = |of: fn(&Self) -> f64| bands.iter().map(of).sum::<f64>();
        let noise_k = sum(|band| band.noise_k.powi(2)).sqrt() / n;
        Temperature {
            k: sum(|band| band.k) / n,
            error_k: math::hypot(noise_k, sum(|band| band.common_k) / n),
        }
    }
}

/// Means over a window of [`WINDOW_UM`] around each band.
fn smoothed(bands: &[Measured], values: &[f64]) -> Vec<f64> {
    let um = |i: usize| bands[i].wavelength_um;
    let half = WINDOW_UM / 2.0 + 1e-9;
    let (mut from, mut to) = (0, 0);
    (0..bands.len())
        .map(|i| {
            while um(i) - um(from) > half {
                from += 1;
            }
            while to < bands.len() && um(to) - um(i) <= half {
                to += 1;
            }
            values[from..to].iter().sum::<f64>() / (to - from) as f64
        })
        .collect()
}

/// The bands that amplify errors little at the highest brightness temperature, and that
/// temperature, K.
fn usable(
    method: Method,
    bands: &[Measured],
    assumed: Assumed,
) -> Result<(Vec<Measured>, f64), RadiometryError> {
    let seen: Vec<Measured> =
        bands.iter().copied().filter(|b| b.brightness_temperature().is_some()).collect();
    let brightness: Vec<f64> =
        seen.iter().filter_map(|b| b.brightness_temperature().map(|t| t.k)).collect();
    let warmest = smoothed(&seen, &brightness).into_iter().fold(0.0, f64::max);
    let tells = |b: &Measured| b.amplification(warmest) <= assumed.amplification_limit;
    let usable: Vec<Measured> = seen.into_iter().filter(tells).collect();
    if usable.len() < 3 {
        let limit = assumed.amplification_limit;
        let problem = format!("fewer than three bands amplify errors no more than {limit} times");
        return Err(refused(method, problem));
    }
    Ok((usable, warmest))
}

fn greatest(values: &[f64]) -> usize {
    let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
    (0..values.len()).max_by(by_value).expect("there are bands")
}

/// NEM: the blackest band has an emissivity of .99. MMD: the resulting contrast gives the least
/// emissivity, e_min = .994 - .687 MMD^.737, and with it the temperature.
fn nem(bands: &[Measured], assumed: Assumed) -> Result<Temperature, RadiometryError> {
    let (usable, _) = usable(Method::Nem, bands, assumed)?;
    let within: Vec<Measured> =
        usable.into_iter().filter(|b| (MMD_UM[0]..=MMD_UM[1]).contains(&b.wavelength_um)).collect();
    if within.len() < 3 {
        let problem = "fewer than three bands within 8 to 12 um can be used";
        return Err(refused(Method::Nem, problem));
    }
    // Under this assumption all bands but the blackest look too cold: the warmest is right.
    let assuming = |e: f64| -> Option<Vec<f64>> {
        within.iter().map(|b| Band::of(b, e, 0.0).map(|band| band.k)).collect()
    };
    let too_faint = || refused(Method::Nem, "a band is fainter than the sky that it reflects");
    let normal = smoothed(&within, &assuming(NEM_EMISSIVITY).ok_or_else(too_faint)?);
    let nem_k = normal[greatest(&normal)];
    let e: Vec<f64> = within
        .iter()
        .map(|b| emissivity(b.l_target, planck(b.wavelength_um, nem_k), b.l_downwelling))
        .collect();
    let e = smoothed(&within, &e);
    let mean = e.iter().sum::<f64>() / e.len() as f64;
    let least = e.iter().copied().fold(f64::INFINITY, f64::min);
    if !(least > 0.0 && mean > 0.0) {
        return Err(too_faint());
    }
    let blackest = greatest(&e);
    let least_by_contrast = 0.994 - 0.687 * math::pow((e[blackest] - least) / mean, 0.737);
    let of_blackest = (e[blackest] / least * least_by_contrast).min(1.0);
    let about: Vec<Band> = within
        .iter()
        .zip(&e)
        .filter(|(b, _)| {
            (b.wavelength_um - within[blackest].wavelength_um).abs() <= WINDOW_UM / 2.0 + 1e-9
        })
        .filter_map(|(b, e_band)| Band::of(b, of_blackest * e_band / e[blackest], NEM_ERROR))
        .collect();
    if about.is_empty() { Err(too_faint()) } else { Ok(Band::mean(&about)) }
}

fn christiansen(bands: &[Measured], assumed: Assumed) -> Result<Temperature, RadiometryError> {
    let [from, to] = CHRISTIANSEN_UM;
    let there: Vec<&Measured> =
        bands.iter().filter(|b| (from..=to).contains(&b.wavelength_um)).collect();
    if there.is_empty() {
        let problem = format!(
            "there is no band within {from} to {to} um, where the emissivity of quartz is nearly 1"
        );
        return Err(refused(Method::Christiansen, problem));
    }
    let [emissivity, error] =
        if assumed.pure_quartz { CHRISTIANSEN_QUARTZ } else { CHRISTIANSEN_SOIL };
    let black: Vec<Band> = there
        .iter()
        .filter_map(|b| Band::of(b, emissivity, error))
        .filter(|t| there.iter().all(|b| b.amplification(t.k) <= assumed.amplification_limit))
        .collect();
    if black.len() < there.len() {
        let problem = format!("the sky is as bright as the target within {from} to {to} um");
        return Err(refused(Method::Christiansen, problem));
    }
    Ok(Band::mean(&black))
}

/// Second differences of the emissivity at a temperature, in units of their noise, so that noise
/// alone favours no temperature. The sky's lines make them large at a wrong temperature.
fn roughness(bands: &[Measured], temperature_k: f64) -> Vec<f64> {
    let all_known = bands.iter().all(|b| b.l_target_error > 0.0);
    let of: Vec<(f64, f64)> = bands
        .iter()
        .map(|b| {
            let l = planck(b.wavelength_um, temperature_k);
            let error = if all_known { b.l_target_error } else { 1.0 };
            (emissivity(b.l_target, l, b.l_downwelling), error / (l - b.l_downwelling))
        })
        .collect();
    of.windows(3)
        .map(|w| {
            let [(e0, s0), (e1, s1), (e2, s2)] = [w[0], w[1], w[2]];
            (2.0 * e1 - e0 - e2) / (4.0 * s1 * s1 + s0 * s0 + s2 * s2).sqrt()
        })
        .collect()
}

fn smoothness(bands: &[Measured], assumed: Assumed) -> Result<Temperature, RadiometryError> {
    let method = Method::Smoothness;
    let (usable, warmest_k) = usable(method, bands, assumed)?;
    let squares = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
    let cost = |k: f64| squares(&roughness(&usable, k));
    let no_signal = || {
        refused(
            method,
            "the sky has no lines from which the temperature follows, or the noise hides them",
        )
    };
    // A coarse search for the minimum, then a search by thirds.
    let step = 0.5;
    let steps = ((SEARCH_K[1] - SEARCH_K[0]) / step) as usize;
    let k_at = |i: usize| warmest_k + SEARCH_K[0] + step * i as f64;
    let costs: Vec<f64> = (0..=steps).map(|i| cost(k_at(i))).collect();
    let least = (0..=steps).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).expect("some");
    if least == 0 || least == steps {
        return Err(no_signal());
    }
    let (mut from, mut to) = (k_at(least - 1), k_at(least + 1));
    // 40 thirds leave 1e-7 K of the two steps.
    for _ in 0..40 {
        let third = (to - from) / 3.0;
        if cost(from + third) < cost(to - third) { to -= third } else { from += third }
    }
    let k = f64::midpoint(from, to);
    let rough = roughness(&usable, k);
    let dk = 1e-2;
    let slope: Vec<f64> = roughness(&usable, k + dk)
        .iter()
        .zip(roughness(&usable, k - dk))
        .map(|(above, below)| (above - below) / (2.0 * dk))
        .collect();
    // Relative change of the emissivity with temperature, dB/dT / (B - L_d), K-1.
    let by_scale = |b: &Measured| {
        let l = planck(b.wavelength_um, k) - b.l_downwelling;
        planck_derivative(b.wavelength_um, k) / l.abs()
    };
    let scale = usable.iter().map(by_scale).sum::<f64>() / usable.len() as f64;
    let [rough, slope] = [squares(&rough), squares(&slope)];
    if slope.sqrt() < LEAST_SIGNAL * scale * rough.sqrt() {
        return Err(no_signal());
    }
    // The remaining roughness counts as noise. Neighbouring second differences are correlated,
    // which raises the variance by a factor of at most 8/3.
    let variance = 8.0 / 3.0 * rough / (usable.len() - 3).max(1) as f64 / slope;
    Ok(Temperature { k, error_k: variance.sqrt() })
}
