//! Functions whose last digits do not depend on the processor.
//!
//! The system's own choose between instruction sets while the program runs, and round differently
//! with each. These are compiled once. Square roots, sums and products are exact to the last digit
//! everywhere.

use num_complex::Complex64;

pub use libm::{acos, atan2, cbrt, cos, exp, expm1, hypot, log, log1p, log10, pow, powf, tan};

/// Sine and cosine.
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// The square root with a real part of 0 or more.
pub fn sqrt(z: Complex64) -> Complex64 {
    let half = |x: f64| (x / 2.0).sqrt();
    let length = hypot(z.re, z.im);
    if length == 0.0 {
        Complex64::new(0.0, z.im)
    } else if z.re >= 0.0 {
        let re = half(length + z.re);
        Complex64::new(re, z.im / (2.0 * re))
    } else {
        let im = half(length - z.re).copysign(z.im);
        Complex64::new(z.im / (2.0 * im), im)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_of_a_root_is_the_number() {
        for re in [-2.5, -1e-9, 0.0, 1e-9, 1.0, 40.0] {
            for im in [-3.0, -1e-12, 0.0, 1e-12, 0.5, 7.0] {
                let z = Complex64::new(re, im);
                let root = sqrt(z);
                assert!(root.re >= 0.0, "{z}");
                assert!((root * root - z).norm() <= 4.0 * f64::EPSILON * z.norm(), "{z}");
                assert!((root - z.sqrt()).norm() <= 4.0 * f64::EPSILON * root.norm(), "{z}");
            }
        }
    }
}
