//! Optical constants of a uniaxial crystal.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::fresnel::{hemispherical_mean, unpolarised_reflectance};

use crate::support::math;

/// One damped harmonic oscillator of a dielectric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oscillator {
    /// Resonance wavenumber, cm-1.
    pub v0_per_cm: f64,
    /// Strength, dimensionless.
    pub strength: f64,
    /// Damping as a fraction of the resonance wavenumber.
    pub damping: f64,
}

/// One pair of modes in the four-parameter form of a dielectric function.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Factor {
    /// Wavenumber of the transverse optical mode, cm-1.
    pub to_per_cm: f64,
    /// Its damping, cm-1.
    pub to_damping_per_cm: f64,
    /// Wavenumber of the longitudinal optical mode, cm-1.
    pub lo_per_cm: f64,
    /// Its damping, cm-1.
    pub lo_damping_per_cm: f64,
}

/// The dielectric function along one axis of a crystal, at v = 1e4 / wavelength in cm-1:
///
/// eps = eps_inf prod (LO^2 - v^2 - i gLO v) / (TO^2 - v^2 - i gTO v) + sum S v0^2 / (v0^2 - v^2 -
/// i g v0 v)
///
/// Published sets of constants have either factors or oscillators.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Dielectric constant far above the resonances.
    pub eps_inf: f64,
    /// The factors of the product.
    #[serde(default)]
    pub factors: Vec<Factor>,
    /// The terms of the sum.
    #[serde(default)]
    pub oscillators: Vec<Oscillator>,
}

impl Axis {
    /// The complex dielectric function at a wavelength in um.
    pub fn dielectric(&self, wavelength_um: f64) -> Complex64 {
        let v = 1e4 / wavelength_um;
        let resonance =
            |v0: f64, damping_per_cm: f64| Complex64::new(v0 * v0 - v * v, -damping_per_cm * v);
        let product: Complex64 = self
            .factors
            .iter()
            .map(|f| {
                resonance(f.lo_per_cm, f.lo_damping_per_cm)
                    / resonance(f.to_per_cm, f.to_damping_per_cm)
            })
            .product();
        let sum: Complex64 = self
            .oscillators
            .iter()
            .map(|o| {
                o.strength * o.v0_per_cm * o.v0_per_cm
                    / resonance(o.v0_per_cm, o.damping * o.v0_per_cm)
            })
            .sum();
        self.eps_inf * product + sum
    }

    /// The complex refractive index n + ik at a wavelength in um.
    pub fn index(&self, wavelength_um: f64) -> Complex64 {
        math::sqrt(self.dielectric(wavelength_um))
    }
}

/// Optical constants of a uniaxial crystal, from a file in spectra/.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UniaxialCrystal {
    /// The crystal and the kind of constants.
    pub title: String,
    /// Their source.
    pub citation: String,
    /// Range of wavelengths in which they hold, um.
    pub range_um: [f64; 2],
    /// For an electric field across the optic axis.
    pub ordinary: Axis,
    /// For an electric field along the optic axis.
    pub extraordinary: Axis,
}

impl UniaxialCrystal {
    /// Reflectance of a smooth face for unpolarised light at a cosine of the angle of incidence,
    /// 0 to 1, with randomly oriented crystal axes: (2 Ro + Re) / 3.
    pub fn reflectance(&self, wavelength_um: f64, cosine: f64) -> f64 {
        self.mean(wavelength_um, |eps| unpolarised_reflectance(eps, cosine))
    }

    /// The same for light from the whole hemisphere.
    pub fn hemispherical_reflectance(&self, wavelength_um: f64) -> f64 {
        self.mean(wavelength_um, |eps| {
            hemispherical_mean(|cosine| unpolarised_reflectance(eps, cosine))
        })
    }

    /// Transmittance of a path within the crystal, um, with randomly oriented axes.
    pub fn transmittance(&self, wavelength_um: f64, path_um: f64) -> f64 {
        self.mean(wavelength_um, |eps| {
            math::exp(-4.0 * PI * math::sqrt(eps).im * path_um / wavelength_um)
        })
    }

    fn mean(&self, wavelength_um: f64, of: impl Fn(Complex64) -> f64) -> f64 {
        let [o, e] = [&self.ordinary, &self.extraordinary].map(|a| of(a.dielectric(wavelength_um)));
        (2.0 * o + e) / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::crystal;

    fn normal(axis: &Axis, um: f64) -> f64 {
        unpolarised_reflectance(axis.dielectric(um), 1.0)
    }

    #[test]
    fn the_oscillators_of_quartz_have_their_known_christiansen_points_and_maxima() {
        let quartz = crystal("quartz_spitzer_kleinman").expect("shipped");
        for (axis, christiansen_um, maxima_um) in [
            (&quartz.ordinary, 7.355, &[8.475, 8.985, 12.495][..]),
            (&quartz.extraordinary, 7.350, &[12.805][..]),
        ] {
            let [below, above] =
                [-0.003, 0.003].map(|by| axis.index(christiansen_um + by).re - 1.0);
            assert!(below * above < 0.0, "n - 1 changes its sign");
            for &um in maxima_um {
                assert!(normal(axis, um) > normal(axis, um - 0.01), "{um}");
                assert!(normal(axis, um) > normal(axis, um + 0.01), "{um}");
            }
        }
        let dip = |um| normal(&quartz.ordinary, um);
        assert!(dip(8.615) < dip(8.6) && dip(8.615) < dip(8.63));
    }

    #[test]
    fn a_four_parameter_factor_is_one_at_no_splitting_and_follows_lyddane_sachs_teller() {
        let factor = Factor {
            to_per_cm: 1065.0,
            to_damping_per_cm: 7.0,
            lo_per_cm: 1226.0,
            lo_damping_per_cm: 7.0,
        };
        let none = Factor { lo_per_cm: 1065.0, ..factor };
        let axis = |factors| Axis { eps_inf: 2.0, factors, oscillators: vec![] };
        assert!((axis(vec![none]).dielectric(9.0) - 2.0).norm() < 1e-14);
        let still = axis(vec![factor]).dielectric(1e7).re;
        assert!((still - 2.0 * (1226.0_f64 / 1065.0).powi(2)).abs() < 1e-9);
    }

    #[test]
    fn the_constants_recovered_from_the_tables_of_zeidler_posch_and_mutschke_return_their_rows() {
        // Astron. Astrophys. 553, A81 (2013), natural quartz at 300 K: wavenumber in cm-1, n, k.
        // Those of 1333 and 910 are among the rows that the parameters were recovered from, the
        // others are not.
        let quartz = crystal("quartz_zeidler").expect("shipped");
        for (axis, rows) in [
            (
                &quartz.ordinary,
                [
                    (1333.0, 0.9732, 0.0186),
                    (1226.0, 0.1986, 0.2056),
                    (1162.0, 0.4078, 1.3848),
                    (1156.0, 0.3451, 1.062),
                    (1087.0, 0.345, 3.6185),
                    (793.0, 3.2099, 1.3172),
                ],
            ),
            (
                &quartz.extraordinary,
                [
                    (1333.0, 0.9321, 0.0248),
                    (1239.0, 0.256, 0.2261),
                    (1162.0, 0.1394, 1.408),
                    (1156.0, 0.1486, 1.5125),
                    (1087.0, 1.3143, 4.5093),
                    (910.0, 2.027, 0.0164),
                ],
            ),
        ] {
            for (wavenumber, n, k) in rows {
                let index = axis.index(1e4 / wavenumber);
                assert!(
                    (index - Complex64::new(n, k)).norm() < 3e-4,
                    "{wavenumber}: {index}, table {n} {k}"
                );
            }
        }
    }

    #[test]
    fn the_sets_of_quartz_agree_where_no_resonance_is_near_and_conserve_energy() {
        let [a, b, c] = ["quartz", "quartz_zeidler", "quartz_spitzer_kleinman"]
            .map(|name| crystal(name).expect("shipped"));
        for um in [10.0, 10.5, 11.0, 11.5] {
            let [a, b, c] = [a, b, c].map(|set| set.reflectance(um, 1.0));
            assert!((a - b).abs() < 0.015 && (a - c).abs() < 0.015, "{um}: {a} {b} {c}");
        }
        for quartz in [a, b, c] {
            for um in (700..=1400).map(|i| f64::from(i) / 100.0) {
                for axis in [&quartz.ordinary, &quartz.extraordinary] {
                    assert!(axis.dielectric(um).im > 0.0, "gain at {um} um");
                }
                let of = |cosine| quartz.reflectance(um, cosine);
                assert!(
                    (0..=64).map(|i| of(f64::from(i) / 64.0)).all(|r| (0.0..=1.0).contains(&r))
                );
                assert!((of(0.0) - 1.0).abs() < 1e-12);
            }
        }
    }
}
