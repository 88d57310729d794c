//! Refraction of a ray at a smooth face between vacuum and an absorbing medium.
//!
//! Within an absorbing medium the wave is inhomogeneous. Its ray is taken along the planes of equal
//! phase, as by an index that depends on the angle. Light that leaves has the reflectance of light
//! that would enter along the same way, so that a path and its reverse have the same weight.

use num_complex::Complex64;

use super::unpolarised_reflectance;
use crate::support::math;

/// What a face does with a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// The share that is reflected, for unpolarised light, 0 to 1.
    pub reflectance: f64,
    /// Cosine between the refracted ray and the normal, 0 to 1.
    pub cosine: f64,
}

/// A ray that meets a medium with a complex dielectric function from outside, at a cosine of the
/// angle of incidence above 0 and up to 1.
pub fn inward(dielectric: Complex64, cosine: f64) -> Crossing {
    let sine_squared = 1.0 - cosine * cosine;
    // The component of the wave vector across the face that has the planes of equal phase.
    let across = (dielectric - sine_squared).sqrt().re;
    Crossing {
        reflectance: unpolarised_reflectance(dielectric, cosine).min(1.0),
        cosine: across / (across * across + sine_squared).sqrt(),
    }
}

/// A ray that meets the face from within; `None` where it is reflected as a whole.
///
/// The outer angle is the one whose refracted ray is this ray. With u the square of its sine,
/// u / (u + Re(sqrt(eps - u))^2) is the square of the sine within, which gives u in closed form.
pub fn outward(dielectric: Complex64, cosine: f64) -> Option<Crossing> {
    let Complex64 { re, im } = dielectric;
    let u = (1.0 - cosine * cosine) / 2.0 * (re + math::hypot(re, im / cosine));
    (u < 1.0).then(|| {
        let cosine = (1.0 - u).sqrt();
        Crossing { reflectance: unpolarised_reflectance(dielectric, cosine).min(1.0), cosine }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clear_medium_refracts_by_snell_and_reflects_all_beyond_the_critical_angle() {
        for n in [1.5, 3.0, 0.5] {
            let eps = Complex64::new(n * n, 0.0);
            for degree in 1..90 {
                // No angle is a critical one, at which rounding decides.
                let (sine, cosine) = (f64::from(degree) - 0.3).to_radians().sin_cos();
                let refracted = inward(eps, cosine);
                if sine < n {
                    let within = (1.0 - (sine / n).powi(2)).sqrt();
                    assert!((refracted.cosine - within).abs() < 1e-12, "{n} at {degree}");
                } else {
                    assert!((refracted.reflectance - 1.0).abs() < 1e-12);
                }
                let left = outward(eps, cosine);
                assert_eq!(left.is_some(), n * sine < 1.0, "{n} at {degree}");
                if let Some(left) = left {
                    assert!((left.cosine - (1.0 - (n * sine).powi(2)).sqrt()).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn the_way_out_is_the_way_in_reversed_whatever_the_absorption() {
        for (n, k) in [(1.5, 0.0), (1.5, 0.2), (0.4, 0.01), (0.3, 2.0), (3.0, 1.0), (1.0, 1e-9)] {
            let index = Complex64::new(n, k);
            for i in 1..=100 {
                let cosine = f64::from(i) / 100.0;
                let into = inward(index * index, cosine);
                if into.reflectance > 1.0 - 1e-12 || into.cosine == 0.0 {
                    continue;
                }
                let out = outward(index * index, into.cosine).expect("it came in there");
                assert!((out.cosine - cosine).abs() < 1e-6, "{n} {k} {cosine}: {}", out.cosine);
                assert!((out.reflectance - into.reflectance).abs() < 1e-6, "{n} {k} {cosine}");
            }
        }
    }

    #[test]
    fn nothing_happens_where_the_index_is_one() {
        for i in 1..=10 {
            let cosine = f64::from(i) / 10.0;
            for crossing in [Some(inward(1.0.into(), cosine)), outward(1.0.into(), cosine)] {
                let Crossing { reflectance, cosine: beyond } = crossing.expect("it goes on");
                assert!(reflectance < 1e-20 && (beyond - cosine).abs() < 1e-12);
            }
        }
    }
}
