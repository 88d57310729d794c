//! Planck's law and the paper's Eq. 1 to 3 (Carson & Salvaggio 2015, section 2).
//!
//! Spectral radiance is in W m-2 sr-1 um-1 throughout.

/// Planck constant, J s (CODATA 2019, exact).
const H: f64 = 6.626_070_15e-34;
/// Speed of light, m/s (exact).
const C: f64 = 299_792_458.0;
/// Boltzmann constant, J/K (exact).
const K_B: f64 = 1.380_649e-23;

/// Spectral radiance of a black body, `l_blackbody`: wavelength in um and temperature in K, both
/// above 0.
pub fn planck(wavelength_um: f64, temperature_k: f64) -> f64 {
    let metres = wavelength_um * 1e-6;
    let x = H * C / (metres * K_B * temperature_k);
    2e-6 * H * C * C / metres.powi(5) / x.exp_m1()
}

/// Eq. 1: radiance that leaves the target is what it emits and what it reflects of the sky.
pub fn l_target(l_emitted: f64, l_reflected: f64) -> f64 {
    l_emitted + l_reflected
}

/// Eq. 2 and, under a cold black sky (`l_downwelling` = 0), Eq. 3: the target's emissivity from its radiance.
pub fn emissivity(l_target: f64, l_blackbody: f64, l_downwelling: f64) -> f64 {
    (l_target - l_downwelling) / (l_blackbody - l_downwelling)
}

/// How much Eq. 2 amplifies a relative error: f = B / |B - L_d|, 1 without a sky, infinite under one as bright as the
/// target.
pub fn amplification(l_blackbody: f64, l_downwelling: f64) -> f64 {
    l_blackbody / (l_blackbody - l_downwelling).abs()
}

/// Radiance of an isotropic sky that would light a horizontal surface as one does whose radiance depends on the
/// zenith angle, given in bins of equal width from 0 to 90 degrees.
pub fn l_downwelling(l_sky: &[f64]) -> f64 {
    let edge =
        |i: usize| (std::f64::consts::FRAC_PI_2 * i as f64 / l_sky.len() as f64).sin().powi(2);
    l_sky.iter().enumerate().map(|(i, l)| l * (edge(i + 1) - edge(i))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planck_gives_codata_values_at_300_k() {
        for (um, value) in [
            (8.0, 9.078_357),
            (9.0, 9.830_066),
            (10.0, 9.924_033),
            (11.0, 9.573_180),
            (12.0, 8.961_372),
        ] {
            assert!((planck(um, 300.0) - value).abs() < 1e-6, "{um} um");
        }
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
