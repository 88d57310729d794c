//! Smooth interpolation between points: piecewise cubics with slopes of parabolas.
//!
//! The value is linear in the values at the points, so that derivatives of those carry over.

/// The weight of each point in the interpolated value, and in its derivative in `x`.
///
/// Between two points the curve is a cubic; its slope at a point is that of the parabola through it
/// and its neighbours. Value and derivative are continuous. Parabolas are reproduced exactly. Beyond
/// the ends it is the end.
///
/// # Panics
/// Without a point.
pub fn weights(x: &[f64], at: f64) -> (Vec<f64>, Vec<f64>) {
    let n = x.len();
    let (mut value, mut slope) = (vec![0.0; n], vec![0.0; n]);
    if n == 1 {
        value[0] = 1.0;
        return (value, slope);
    }
    let is_inside = (x[0]..=x[n - 1]).contains(&at);
    let at = at.clamp(x[0], x[n - 1]);
    let i = x.partition_point(|&x| x <= at).clamp(1, n - 1) - 1;
    let h = x[i + 1] - x[i];
    let t = (at - x[i]) / h;
    let (t2, t3) = (t * t, t * t * t);
    // Of the two values, then of the two slopes: weight and its derivative.
    let basis = [
        (2.0 * t3 - 3.0 * t2 + 1.0, (6.0 * t2 - 6.0 * t) / h),
        (-2.0 * t3 + 3.0 * t2, (6.0 * t - 6.0 * t2) / h),
        ((t3 - 2.0 * t2 + t) * h, 3.0 * t2 - 4.0 * t + 1.0),
        ((t3 - t2) * h, 3.0 * t2 - 2.0 * t),
    ];
    for (place, (v, d)) in [(i, basis[0]), (i + 1, basis[1])] {
        value[place] += v;
        slope[place] += d;
    }
    for (place, (v, d)) in [(i, basis[2]), (i + 1, basis[3])] {
        for (neighbour, of) in parabola(x, place) {
            value[neighbour] += v * of;
            slope[neighbour] += d * of;
        }
    }
    if !is_inside {
        slope.fill(0.0);
    }
    (value, slope)
}

/// The weights of the points in the slope of a parabola at a point.
fn parabola(x: &[f64], at: usize) -> Vec<(usize, f64)> {
    if x.len() == 2 {
        let h = x[1] - x[0];
        return vec![(0, -1.0 / h), (1, 1.0 / h)];
    }
    let first = at.saturating_sub(1).min(x.len() - 3);
    let p = [x[first], x[first + 1], x[first + 2]];
    // The derivative of each Lagrange polynomial at the point.
    let of = |i: usize| {
        let (a, b) = (p[(i + 1) % 3], p[(i + 2) % 3]);
        (2.0 * x[at] - a - b) / ((p[i] - a) * (p[i] - b))
    };
    (0..3).map(|i| (first + i, of(i))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 6] = [0.0, 0.1, 0.3, 0.35, 0.7, 0.9];

    fn value(of: impl Fn(f64) -> f64, at: f64) -> [f64; 2] {
        let (v, d) = weights(&X, at);
        [v, d].map(|w| w.iter().zip(X).map(|(w, x)| w * of(x)).sum())
    }

    #[test]
    fn parabolas_and_their_slopes_are_exact() {
        for i in 0..=90 {
            let at = f64::from(i) / 100.0;
            let [v, d] = value(|x| 1.0 - 2.0 * x + 3.0 * x * x, at);
            assert!((v - (1.0 - 2.0 * at + 3.0 * at * at)).abs() < 1e-12);
            assert!((d - (6.0 * at - 2.0)).abs() < 1e-10, "{at} {d}");
        }
    }

    #[test]
    fn the_derivative_is_that_of_differences_and_continuous_at_points() {
        let of = |x: f64| crate::support::math::sin_cos(5.0 * x).0;
        for at in [0.02, 0.2, 0.32, 0.5, 0.89] {
            let moved = (value(of, at + 1e-6)[0] - value(of, at - 1e-6)[0]) / 2e-6;
            assert!((value(of, at)[1] - moved).abs() < 1e-7, "{at}");
        }
        for at in &X[1..5] {
            let [before, after] = [-1e-9, 1e-9].map(|step| value(of, at + step)[1]);
            assert!((before - after).abs() < 1e-5, "{at}");
        }
    }

    #[test]
    fn beyond_the_ends_it_is_the_end() {
        assert_eq!(value(|x| x, 2.0), [0.9, 0.0]);
        assert_eq!(weights(&[0.4], 9.0), (vec![1.0], vec![0.0]));
    }
}
