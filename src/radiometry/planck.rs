//! Planck's law, its slope in temperature, and its inverse.

use crate::support::math;

/// Planck constant, J s (CODATA 2019, exact).
const H: f64 = 6.626_070_15e-34;
/// Speed of light, m/s (exact).
const C: f64 = 299_792_458.0;
/// Boltzmann constant, J/K (exact).
const K_B: f64 = 1.380_649e-23;

/// First radiation constant of spectral radiance, 2 h c^2, for wavelengths in um: W m-2 sr-1 um4.
const C_1L: f64 = 2.0 * H * C * C * 1e24;
/// Second radiation constant, h c / k, um K.
const C_2: f64 = H * C / K_B * 1e6;

/// Spectral radiance of a black body, W m-2 sr-1 um-1: wavelength in um and temperature in K, both
/// above 0. It underflows to 0 at short wavelengths (300 K: below 0.07 um).
pub fn planck(wavelength_um: f64, temperature_k: f64) -> f64 {
    C_1L / wavelength_um.powi(5) / math::expm1(C_2 / (wavelength_um * temperature_k))
}

/// Derivative of [`planck`] with respect to temperature, W m-2 sr-1 um-1 K-1.
pub fn planck_derivative(wavelength_um: f64, temperature_k: f64) -> f64 {
    let x = C_2 / (wavelength_um * temperature_k);
    planck(wavelength_um, temperature_k) * x / temperature_k / -math::expm1(-x)
}

/// Radiances below this share of 2 h c^2 / wavelength^5 have no brightness temperature: their own
/// derivative is too small for a number.
const FAINTEST: f64 = 1e-300;

/// The temperature of a black body of this radiance, K: the inverse of [`planck`]. `None` for a
/// radiance that is not finite and above 0, or too faint for any body above some 20 K at 1 um.
pub fn brightness_temperature_k(wavelength_um: f64, l: f64) -> Option<f64> {
    let most = C_1L / wavelength_um.powi(5);
    (l > FAINTEST * most && l.is_finite()).then(|| C_2 / (wavelength_um * math::log1p(most / l)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// W m-2 sr-1 um-1, by mpmath 1.3.0 with 50 digits, here rounded to 13, from the exact
    /// constants of CODATA 2019:
    ///
    /// ```python
    /// from mpmath import mp, mpf, expm1
    /// mp.dps = 50
    /// h, c, k = mpf("6.62607015e-34"), mpf(299792458), mpf("1.380649e-23")
    /// B = lambda um, T: 2*h*c**2 / (um*mpf("1e-6"))**5 / expm1(h*c/(um*mpf("1e-6")*k*T)) * mpf("1e-6")
    /// # and its slope: diff(lambda T: B(um, T), T)
    /// ```
    const EXACT: [(f64, f64, f64, f64); 15] = [
        (3.0, 100.0, 7.275_997_441_685e-16, 3.489_512_293_291e-16),
        (3.0, 300.0, 5.591_285_479_538e-2, 2.979_486_363_397e-3),
        (3.0, 1000.0, 4.083_964_333_362e3, 1.974_957_620_387e1),
        (5.0, 200.0, 2.150_547_643_563e-2, 1.547_079_984_704e-3),
        (7.36, 300.0, 8.170_182_120_534, 1.777_246_969_051e-1),
        (8.0, 300.0, 9.078_357_422_885, 1.818_660_311_452e-1),
        (9.0, 300.0, 9.830_065_990_658, 1.754_592_466_421e-1),
        (10.0, 300.0, 9.924_033_330_071, 1.599_715_672_513e-1),
        (11.0, 300.0, 9.573_180_197_161, 1.409_289_539_388e-1),
        (12.0, 300.0, 8.961_372_305_529, 1.216_185_776_320e-1),
        (14.0, 250.0, 3.691_242_306_139, 6.170_738_397_148e-2),
        (8.5, 1000.0, 6.053_902_569_928e2, 1.255_837_901_923),
        (20.0, 100.0, 2.797_947_165_758e-2, 2.014_323_934_188e-3),
        (20.0, 300.0, 3.721_738_304_924, 3.272_326_185_157e-2),
        (20.0, 1000.0, 3.534_077_027_847e1, 4.956_378_367_221e-2),
    ];

    #[test]
    fn planck_and_its_slope_are_exact_from_100_to_1000_k_and_3_to_20_um() {
        for (um, kelvin, l, slope) in EXACT {
            assert!((planck(um, kelvin) / l - 1.0).abs() < 1e-12, "{um} um, {kelvin} K");
            let ratio = planck_derivative(um, kelvin) / slope;
            assert!((ratio - 1.0).abs() < 1e-12, "slope, {um} um, {kelvin} K");
        }
    }

    #[test]
    fn the_brightness_temperature_inverts_planck() {
        for um in (0..=170).map(|i| 3.0 + 0.1 * f64::from(i)) {
            for kelvin in (0..=900).map(|i| 100.0 + f64::from(i)) {
                let back = brightness_temperature_k(um, planck(um, kelvin)).expect("it is above 0");
                assert!((back / kelvin - 1.0).abs() < 1e-12, "{um} um, {kelvin} K: {back}");
            }
        }
    }

    #[test]
    fn the_ends_are_stable() {
        // Wien's end: too faint for a number, and no NaN.
        assert_eq!(planck(0.01, 1.0), 0.0);
        assert_eq!(planck_derivative(0.01, 1.0), 0.0);
        // The Rayleigh-Jeans end: 2 c k T / lambda^4 to first order in x / 2.
        let (um, kelvin) = (1e4, 1e4);
        let x = C_2 / (um * kelvin);
        let rayleigh_jeans = C_1L / C_2 * kelvin / um.powi(4) * (1.0 - x / 2.0);
        assert!((planck(um, kelvin) / rayleigh_jeans - 1.0).abs() < x * x);
        let back = brightness_temperature_k(um, planck(um, kelvin)).expect("it is above 0");
        assert!((back / kelvin - 1.0).abs() < 1e-12);
        for no_radiance in [0.0, -1.0, 1e-320, f64::NAN, f64::INFINITY] {
            assert_eq!(brightness_temperature_k(9.0, no_radiance), None);
        }
    }
}
