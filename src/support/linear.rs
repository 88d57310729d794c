//! Straight lines between sorted points, and the range that the points hold.

/// Ends of ranges may differ by so much, um: sums of steps are rounded.
const ROUNDING_UM: f64 = 1e-6;

/// Wavelengths outside are more likely in another unit, um.
pub(crate) const LIKELY_UM: [f64; 2] = [0.1, 1000.0];

/// Files are written with so many digits that a number may be outside its range by this share of
/// the range.
const ROUNDING: f64 = 1e-6;

/// The number; the nearer end of its range, if only rounding took it out.
pub fn rounded_within(value: f64, [from, to]: [f64; 2]) -> f64 {
    let margin = ROUNDING * (to - from);
    if value < from - margin || value > to + margin { value } else { value.clamp(from, to) }
}

/// A file or a spectrum does not hold the wavelengths needed.
#[derive(Debug, thiserror::Error)]
#[error("{of} holds {} um, but {} um is needed", span(*held_um), span(*needed_um))]
pub struct OutOfRange {
    /// What was asked for them: a file or a spectrum.
    pub of: String,
    /// Least and greatest wavelength needed, um.
    pub needed_um: [f64; 2],
    /// Least and greatest wavelength held, um.
    pub held_um: [f64; 2],
}

impl OutOfRange {
    /// An error unless one range lies within the other, um.
    pub fn check(
        of: impl FnOnce() -> String,
        needed_um: [f64; 2],
        held_um: [f64; 2],
    ) -> Result<(), Self> {
        if held_um[0] <= needed_um[0] + ROUNDING_UM && needed_um[1] <= held_um[1] + ROUNDING_UM {
            return Ok(());
        }
        Err(Self { of: of(), needed_um, held_um })
    }

    /// What the user can do about it.
    pub fn hint(&self) -> String {
        let [from, to] = self.held_um;
        if from < LIKELY_UM[0] || to > LIKELY_UM[1] {
            return "if the unit of its wavelengths is another, write it into the heading, as in \
                    wavelength_nm, or say it: `soilsig spectra convert FILE --unit nm --out \
                    FILE.csv`"
                .into();
        }
        format!("ask for a range within it: --range {}", span(self.held_um))
    }
}

/// A range as text; one number if both ends are equal.
pub fn span([from, to]: [f64; 2]) -> String {
    if from == to { from.to_string() } else { format!("{from}-{to}") }
}

/// The first and the last of sorted numbers, at least one.
pub fn ends(x: &[f64]) -> [f64; 2] {
    [x[0], x[x.len() - 1]]
}

/// A place between two neighbouring points.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    below: usize,
    above: usize,
    share: f64,
}

/// Finds a place among points, at least one, whose `x` ascends. Beyond the ends it is the end.
pub fn locate<T>(points: &[T], x: impl Fn(&T) -> f64, at: f64) -> Place {
    let above = points.partition_point(|point| x(point) < at).min(points.len() - 1);
    let below = above.saturating_sub(1);
    let share = if above == 0 {
        0.0
    } else {
        let (x0, x1) = (x(&points[below]), x(&points[above]));
        ((at - x0) / (x1 - x0)).min(1.0)
    };
    Place { below, above, share }
}

impl Place {
    /// The value there, from the values at the points: exact at the points.
    pub fn value(self, y: impl Fn(usize) -> f64) -> f64 {
        let (y0, y1) = (y(self.below), y(self.above));
        if self.share == 1.0 { y1 } else { y0 + self.share * (y1 - y0) }
    }
}

/// The value at a place, on the straight line between its neighbours; `x` ascends.
pub fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    locate(x, |x| *x, at).value(|i| y[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_rounding_took_out_of_a_range_is_taken_back() {
        for (value, taken) in [(1.000_000_1, 1.0), (-1e-9, 0.0), (0.3, 0.3), (1.01, 1.01)] {
            assert_eq!(rounded_within(value, [0.0, 1.0]), taken);
        }
        assert!(rounded_within(f64::NAN, [0.0, 1.0]).is_nan());
        let check = |held_um| OutOfRange::check(String::new, [8.0, 12.0], held_um);
        assert!(check([8.000_000_000_1, 11.999_999_999_999_915]).is_ok());
        assert!(check([8.0, 11.999]).is_err() && check([8.001, 12.0]).is_err());
        assert!(OutOfRange::check(String::new, [f64::NAN; 2], [8.0, 12.0]).is_err());
    }

    #[test]
    fn values_are_exact_at_points_linear_between_them_and_constant_beyond() {
        let (x, y) = ([8.0, 8.1, 10.0], [0.3, 0.1, 0.7]);
        for (x_at, y_at) in x.iter().zip(y) {
            assert_eq!(interpolate(&x, &y, *x_at), y_at);
        }
        assert!((interpolate(&x, &y, 9.05) - 0.4).abs() < 1e-15);
        assert_eq!([7.0, 11.0].map(|at| interpolate(&x, &y, at)), [0.3, 0.7]);
        assert_eq!(interpolate(&[8.0], &[0.3], 9.0), 0.3);
    }
}
