//! Fresnel reflection at a smooth face, from vacuum into an absorbing medium.

use num_complex::Complex64;

use crate::support::math;

/// Reflectance for unpolarised light of a medium with a complex dielectric function, at a cosine of
/// the angle of incidence from 0 (grazing) to 1 (normal).
pub fn unpolarised_reflectance(dielectric: Complex64, cosine: f64) -> f64 {
    // The component of the wave vector across the face within the medium, in units of the vacuum's.
    let inside = math::sqrt(dielectric - (1.0 - cosine * cosine));
    let across = (cosine - inside) / (cosine + inside);
    let within = (dielectric * cosine - inside) / (dielectric * cosine + inside);
    f64::midpoint(across.norm_sqr(), within.norm_sqr())
}

/// Reflectance at normal incidence of a medium with a complex refractive index n + ik.
pub fn normal_reflectance(index: Complex64) -> f64 {
    ((index - 1.0) / (index + 1.0)).norm_sqr()
}

/// The mean over a hemisphere, each direction by its cosine: the integral of 2 mu f(mu) over mu
/// from 0 to 1, by midpoints. A constant is returned to rounding; a Fresnel reflectance to 1e-4 or
/// better.
pub fn hemispherical_mean(of_cosine: impl Fn(f64) -> f64) -> f64 {
    const POINTS: u32 = 256;
    let step = f64::from(POINTS).recip();
    (0..POINTS)
        .map(|i| (f64::from(i) + 0.5) * step)
        .map(|cosine| 2.0 * cosine * of_cosine(cosine) * step)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_normal_incidence_it_is_the_closed_form() {
        for (n, k) in [(1.5, 0.0), (0.4, 2.5), (3.0, 0.2)] {
            let index = Complex64::new(n, k);
            let closed = ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
            assert!((normal_reflectance(index) - closed).abs() < 1e-15);
            assert!((unpolarised_reflectance(index * index, 1.0) - closed).abs() < 1e-15);
        }
    }

    #[test]
    fn glass_at_45_degrees_at_its_brewster_angle_and_grazing() {
        let glass = Complex64::new(2.25, 0.0);
        let at = |deg: f64| unpolarised_reflectance(glass, deg.to_radians().cos());
        // Snell: sin t = sin 45 / 1.5; rs = -sin(i - t) / sin(i + t), rp = tan(i - t) / tan(i + t).
        let (i, t) = (45_f64.to_radians(), (45_f64.to_radians().sin() / 1.5).asin());
        let (rs, rp) = ((i - t).sin() / (i + t).sin(), (i - t).tan() / (i + t).tan());
        assert!((at(45.0) - f64::midpoint(rs * rs, rp * rp)).abs() < 1e-15);
        // At tan i = n nothing is reflected within the plane: half of ((n^2 - 1) / (n^2 + 1))^2 is
        // left.
        let brewster = 0.5 * (1.25_f64 / 3.25).powi(2);
        assert!((at(1.5_f64.atan().to_degrees()) - brewster).abs() < 1e-15);
        assert!((at(90.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn beyond_the_critical_angle_all_is_reflected_and_nowhere_more() {
        let rarer = Complex64::new(0.25, 0.0);
        for i in 0..=100 {
            let cosine = f64::from(i) / 100.0;
            let r = unpolarised_reflectance(rarer, cosine);
            // sin i > n = 0.5.
            let is_total = cosine * cosine < 0.75;
            assert!(if is_total { (r - 1.0).abs() < 1e-14 } else { r < 1.0 }, "{cosine}: {r}");
        }
    }

    #[test]
    fn the_hemispherical_mean_is_that_of_the_literature() {
        assert!((hemispherical_mean(|_| 0.3) - 0.3).abs() < 1e-14);
        assert!((hemispherical_mean(|cosine| cosine) - 2.0 / 3.0).abs() < 1e-5);
        // Diffuse external reflectance for n = 1.5: 0.0918 (Walsh 1926; Duntley 1942).
        let glass = hemispherical_mean(|c| unpolarised_reflectance(Complex64::new(2.25, 0.0), c));
        assert!((glass - 0.0918).abs() < 1e-4, "{glass}");
    }
}
