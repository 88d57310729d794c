//! Eq. 1 to 3 of the paper (Carson & Salvaggio 2015, section 2), and the error of Eq. 2.

use crate::support::math;

/// Eq. 1: the radiance that leaves the target is its emitted plus its reflected radiance.
pub fn l_target(l_emitted: f64, l_reflected: f64) -> f64 {
    l_emitted + l_reflected
}

/// Eq. 2: the target's emissivity from its radiance. Under a cold black sky (`l_downwelling` = 0)
/// it is Eq. 3.
pub fn emissivity(l_target: f64, l_blackbody: f64, l_downwelling: f64) -> f64 {
    (l_target - l_downwelling) / (l_blackbody - l_downwelling)
}

/// Standard error of [`emissivity`] from the independent standard errors of its terms:
///
/// d eps = [dL - (1 - eps) dL_d - eps (dB/dT) dT] / (B - L_d).
///
/// `l_blackbody_error` is dB/dT times the error of the temperature.
pub fn emissivity_error(
    emissivity: f64,
    l_blackbody: f64,
    l_downwelling: f64,
    [l_target_error, l_blackbody_error, l_downwelling_error]: [f64; 3],
) -> f64 {
    let parts =
        [l_target_error, emissivity * l_blackbody_error, (1.0 - emissivity) * l_downwelling_error];
    let error = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    error / (l_blackbody - l_downwelling).abs()
}

/// Factor by which Eq. 2 amplifies a relative error: f = B / |B - L_d|. It is 1 without a sky and
/// infinite under a sky as bright as the target.
pub fn amplification(l_blackbody: f64, l_downwelling: f64) -> f64 {
    let f = l_blackbody / (l_blackbody - l_downwelling).abs();
    // Both radiances are 0.
    if f.is_nan() { f64::INFINITY } else { f }
}

/// Radiance at the sensor, through an atmosphere.
pub fn at_sensor(l_target: f64, transmittance: f64, l_path: f64) -> f64 {
    transmittance * l_target + l_path
}

/// Radiance of the isotropic sky with the same irradiance on a horizontal surface. `l_sky` is the
/// sky's radiance in bins of equal width of the zenith angle, from 0 to 90 degrees.
pub fn l_downwelling(l_sky: &[f64]) -> f64 {
    let edge = |i: usize| {
        math::sin_cos(std::f64::consts::FRAC_PI_2 * i as f64 / l_sky.len() as f64).0.powi(2)
    };
    l_sky.iter().enumerate().map(|(i, l)| l * (edge(i + 1) - edge(i))).sum()
}

#[cfg(test)]
mod tests {
    use super::super::planck::planck;
    use super::*;

    /// Sky in K and amplification at 8, 9, 10, 11 and 12 um, target at 300 K.
    const AMPLIFICATION: [(f64, [f64; 5]); 6] = [
        (100.0, [1.0000, 1.0000, 1.0001, 1.0002, 1.0003]),
        (200.0, [1.0524, 1.0745, 1.0992, 1.1258, 1.1539]),
        (240.0, [1.2870, 1.3568, 1.4281, 1.5001, 1.5720]),
        (270.0, [2.0537, 2.2320, 2.4091, 2.5840, 2.7559]),
        (290.0, [5.3438, 5.9334, 6.5146, 7.0852, 7.6433]),
        (299.0, [50.254, 56.342, 62.335, 68.210, 73.949]),
    ];

    #[test]
    fn amplification_grows_as_the_sky_nears_the_target() {
        for (sky_k, row) in AMPLIFICATION {
            for (um, value) in [8.0, 9.0, 10.0, 11.0, 12.0].into_iter().zip(row) {
                let f = amplification(planck(um, 300.0), planck(um, sky_k));
                assert!((f / value - 1.0).abs() < 5e-5, "{sky_k} K, {um} um: {f}");
            }
        }
        assert_eq!(amplification(planck(9.0, 300.0), planck(9.0, 300.0)), f64::INFINITY);
    }

    /// Each term alone, against differences of Eq. 2.
    #[test]
    fn the_error_of_eq_2_is_that_of_its_differences() {
        let (e, b, l_d) = (0.6, planck(9.0, 300.0), planck(9.0, 270.0));
        let l = l_target(e * b, (1.0 - e) * l_d);
        let d = 1e-6;
        for (errors, moved) in [
            ([d, 0.0, 0.0], emissivity(l + d, b, l_d)),
            ([0.0, d, 0.0], emissivity(l, b + d, l_d)),
            ([0.0, 0.0, d], emissivity(l, b, l_d + d)),
        ] {
            let error = emissivity_error(e, b, l_d, errors);
            assert!((error / (moved - e).abs() - 1.0).abs() < 1e-5, "{errors:?}");
        }
        let all = emissivity_error(e, b, l_d, [3.0 * d, 0.0, 10.0 * d]);
        assert!(
            (all - 5.0 * d / (b - l_d)).abs() < 1e-12,
            "the root of the squares of 3 and .4 x 10"
        );
    }

    #[test]
    fn eq_2_gives_its_exact_values_where_the_temperature_is_taken_one_kelvin_too_high() {
        for (sky, value) in [(Some(270.0), 0.576_888), (None, 0.589_420), (Some(290.0), 0.542_249)]
        {
            let l_d = sky.map_or(0.0, |sky_k| planck(9.0, sky_k));
            let l = l_target(0.6 * planck(9.0, 300.0), 0.4 * l_d);
            assert!((emissivity(l, planck(9.0, 301.0), l_d) - value).abs() < 1e-6);
        }
    }
}
