//! From measured radiance to brightness temperature and emissivity, with errors and masked bands.

use serde::{Deserialize, Serialize};

use super::{
    amplification, brightness_temperature_k, emissivity, emissivity_error, planck,
    planck_derivative,
};
use crate::support::linear::span;

/// Measured radiance that leaves the target in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Radiance that leaves the target, corrected for the atmosphere.
    pub l_target: f64,
    /// Its standard error.
    pub l_target_error: f64,
    /// Radiance of the sky, as of an isotropic one.
    pub l_downwelling: f64,
    /// Transmittance of the atmosphere; 1 without one.
    pub transmittance: f64,
}

impl Measured {
    /// From the radiance at a sensor and its standard error. `path` is the transmittance and the
    /// path radiance of the atmosphere.
    pub fn at_sensor(
        wavelength_um: f64,
        [l, l_error]: [f64; 2],
        l_downwelling: f64,
        path: Option<(f64, f64)>,
    ) -> Self {
        let (transmittance, l_path) = path.unwrap_or((1.0, 0.0));
        Self {
            wavelength_um,
            l_target: (l - l_path) / transmittance,
            l_target_error: l_error / transmittance,
            l_downwelling,
            transmittance,
        }
    }

    /// Temperature of a black body of that radiance, with its standard error; `None` if the
    /// radiance is not above 0.
    pub fn brightness_temperature(&self) -> Option<Temperature> {
        let k = brightness_temperature_k(self.wavelength_um, self.l_target)?;
        Some(Temperature {
            k,
            error_k: self.l_target_error / planck_derivative(self.wavelength_um, k),
        })
    }

    /// Factor by which Eq. 2 amplifies a relative error of the radiance at the sensor, for a target
    /// of that temperature.
    pub fn amplification(&self, temperature_k: f64) -> f64 {
        let f = amplification(planck(self.wavelength_um, temperature_k), self.l_downwelling);
        // No radiance of the target reaches the sensor.
        if self.transmittance > 0.0 { f / self.transmittance } else { f64::INFINITY }
    }
}

/// A temperature and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Temperature {
    /// Temperature, K.
    pub k: f64,
    /// Standard error, K.
    pub error_k: f64,
}

/// Assumptions of a retrieval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumed {
    /// Relative standard error of the sky's radiance.
    pub downwelling_error: f64,
    /// Amplification above which a band is masked.
    pub amplification_limit: f64,
    /// Whether the target is a powder of quartz alone, not a soil.
    pub pure_quartz: bool,
}

impl Assumed {
    /// The limit at which an error of 1 % in radiance (0.5 K) becomes 0.1 in emissivity. That is a
    /// third of the difference between fine and coarse quartz powders from 8 to 9.5 um.
    pub const AMPLIFICATION_LIMIT: f64 = 10.0;

    /// An exactly known sky over a soil.
    pub const EXACT: Self = Self {
        downwelling_error: 0.0,
        amplification_limit: Self::AMPLIFICATION_LIMIT,
        pure_quartz: false,
    };
}

/// The result of a retrieval in one band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Retrieved {
    /// Wavelength, um.
    pub wavelength_um: f64,
    /// Factor by which Eq. 2 amplifies a relative error.
    pub amplification: f64,
    /// Emissivity by Eq. 2 and its standard error; `None` if the band is masked.
    pub emissivity: Option<[f64; 2]>,
}

impl Retrieved {
    /// Eq. 2 with the errors of radiance, sky and temperature. The band is masked if the
    /// amplification is above the limit.
    pub fn new(measured: &Measured, temperature: Temperature, assumed: Assumed) -> Self {
        let Measured { wavelength_um, l_target, l_downwelling, .. } = *measured;
        let amplification = measured.amplification(temperature.k);
        let l_blackbody = planck(wavelength_um, temperature.k);
        let emissivity = (amplification <= assumed.amplification_limit).then(|| {
            let emissivity = emissivity(l_target, l_blackbody, l_downwelling);
            let errors = [
                measured.l_target_error,
                planck_derivative(wavelength_um, temperature.k) * temperature.error_k,
                assumed.downwelling_error * l_downwelling,
            ];
            [emissivity, emissivity_error(emissivity, l_blackbody, l_downwelling, errors)]
        });
        Self { wavelength_um, amplification, emissivity }
    }
}

/// Runs of masked bands: the first and last wavelength of each, um.
pub fn masked_um(bands: &[Retrieved]) -> Vec<[f64; 2]> {
    let runs = bands.chunk_by(|a, b| a.emissivity.is_none() == b.emissivity.is_none());
    runs.filter(|run| run[0].emissivity.is_none())
        .map(|run| [run[0].wavelength_um, run[run.len() - 1].wavelength_um])
        .collect()
}

/// A sentence that names the masked bands; `None` if there are none.
pub fn masked_in_words(masked_um: &[[f64; 2]], limit: f64) -> Option<String> {
    let runs: Vec<String> = masked_um.iter().map(|&run| span(run)).collect();
    (!runs.is_empty()).then(|| {
        format!(
            "Eq. 2 gives no emissivity at {} um: it amplifies errors more than {limit} times there",
            runs.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::l_target;
    use super::*;

    fn measured(um: f64, kelvin: f64, emissivity: f64, l_downwelling: f64) -> Measured {
        let l = l_target(emissivity * planck(um, kelvin), (1.0 - emissivity) * l_downwelling);
        Measured::at_sensor(um, [l, 0.0], l_downwelling, None)
    }

    const AT_300_K: Temperature = Temperature { k: 300.0, error_k: 0.0 };

    #[test]
    fn bands_that_amplify_beyond_the_limit_are_masked_and_named() {
        // At 290 K the sky amplifies 5.34 to 7.64 times between 8 and 12 um; at 300 K without end.
        let bands = |sky_k: f64, limit: f64| -> Vec<Retrieved> {
            let assumed = Assumed { amplification_limit: limit, ..Assumed::EXACT };
            [8.0, 9.0, 10.0, 11.0, 12.0]
                .iter()
                .map(|&um| {
                    Retrieved::new(&measured(um, 300.0, 0.6, planck(um, sky_k)), AT_300_K, assumed)
                })
                .collect()
        };
        let known: Vec<bool> = bands(290.0, 6.0).iter().map(|b| b.emissivity.is_some()).collect();
        assert_eq!(known, [true, true, false, false, false]);
        let masked = masked_um(&bands(290.0, 6.0));
        assert_eq!(masked, [[10.0, 12.0]]);
        let words = masked_in_words(&masked, 6.0).expect("some are masked");
        assert!(words.contains("10-12 um") && words.contains("6 times"), "{words}");
        assert!(masked_um(&bands(270.0, 10.0)).is_empty());
        assert!(bands(300.0, 1e300).iter().all(|b| b.emissivity.is_none()));
        assert_eq!(masked_in_words(&[], 10.0), None);
    }

    #[test]
    fn an_atmosphere_is_undone_and_counts_against_the_limit() {
        let l_d = planck(9.0, 270.0);
        let at_target = measured(9.0, 300.0, 0.6, l_d).l_target;
        let seen = |tau: f64| {
            let at_sensor = super::super::at_sensor(at_target, tau, 1.5);
            let measured = Measured::at_sensor(9.0, [at_sensor, 0.01], l_d, Some((tau, 1.5)));
            Retrieved::new(&measured, AT_300_K, Assumed::EXACT)
        };
        let [e, error] = seen(0.5).emissivity.expect("not masked");
        assert!((e - 0.6).abs() < 1e-12);
        assert!((error - 0.02 / (planck(9.0, 300.0) - l_d)).abs() < 1e-12);
        // 2.232 times without, over 10 with a fifth of the light.
        assert!(seen(0.2).emissivity.is_none() && seen(0.0).emissivity.is_none());
    }

    #[test]
    fn the_temperature_s_error_is_in_the_emissivity_s() {
        let l_d = planck(9.0, 270.0);
        let warm = Temperature { k: 301.0, error_k: 1.0 };
        let of = |t| Retrieved::new(&measured(9.0, 300.0, 0.6, l_d), t, Assumed::EXACT);
        let [e, error] = of(warm).emissivity.expect("not masked");
        // Exact for a sky of 270 K and a kelvin too much; the error is that to first order.
        assert!(
            (e - 0.576_888).abs() < 1e-6 && (error / (0.6 - e) - 1.0).abs() < 0.05,
            "{e} {error}"
        );
        let blurred = Assumed { downwelling_error: 0.1, ..Assumed::EXACT };
        let [_, error] = Retrieved::new(&measured(9.0, 300.0, 0.6, l_d), AT_300_K, blurred)
            .emissivity
            .expect("not masked");
        assert!((error - 0.4 * 0.1 * l_d / (planck(9.0, 300.0) - l_d)).abs() < 1e-12);
    }
}
