//! Axes: scales with ticks at round values.

use crate::support::math;

/// A linear or logarithmic scale from values to places on the page.
pub(crate) struct Axis {
    is_log: bool,
    /// Ends of the axis; powers of ten if it is logarithmic.
    low: f64,
    high: f64,
    from: f64,
    to: f64,
    most_ticks: f64,
}

/// A value, and its label unless the tick is a small one.
pub(crate) type Tick = (f64, Option<String>);

impl Axis {
    /// Puts `low` < `high` at `from` and `to`, with at most so many labels.
    pub(crate) fn linear((low, high): (f64, f64), (from, to): (f64, f64), most_ticks: f64) -> Self {
        Self { is_log: false, low, high, from, to, most_ticks }
    }

    /// Puts 10^`low` < 10^`high` at `from` and `to`. Values beyond are put at the ends.
    pub(crate) fn log((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        Self { is_log: true, low, high, from, to, most_ticks: 6.0 }
    }

    /// The place of a value.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let at = if self.is_log {
            // The logarithm of what is not above 0 is below every number, or NaN.
            math::log10(value).max(self.low).min(self.high)
        } else {
            value
        };
        self.from + (self.to - self.from) * (at - self.low) / (self.high - self.low)
    }

    /// Ticks with and without labels.
    pub(crate) fn ticks(&self) -> Vec<Tick> {
        // A multiple of a step counts as inside in spite of rounding.
        let inside = |step: f64| {
            (self.low / step - 1e-6).ceil() as i64..=(self.high / step + 1e-6).floor() as i64
        };
        if !self.is_log {
            let step = round_step(self.high - self.low, self.most_ticks);
            let mantissa = step / math::pow(10.0, math::log10(step).floor());
            let parts = if (1.5..3.0).contains(&mantissa) { 4 } else { 5 };
            let digits = (-math::log10(step) - 1e-9).ceil().max(0.0) as usize;
            let small = step / parts as f64;
            let tick = |i: i64| {
                let value = i as f64 * small;
                (value, (i % parts == 0).then(|| format!("{value:.digits$}")))
            };
            return inside(small).map(tick).collect();
        }
        let powers = inside(1.0);
        let every = (powers.end() - powers.start()) / self.most_ticks as i64 + 1;
        // Fewer than three powers would not tell a scale.
        let labelled: &[i64] = if powers.clone().count() < 3 { &[1, 2, 5] } else { &[1] };
        let tick = |power: i64, digit: i64| {
            let label = labelled.contains(&digit) && power.rem_euclid(every) == 0;
            let value = digit as f64 * 10f64.powi(power as i32);
            (value, label.then(|| label_of(digit, power as i32)))
        };
        let ends = self.low - 1e-6..=self.high + 1e-6;
        (powers.start() - 1..=*powers.end())
            .flat_map(|power| (1..10).map(move |digit| tick(power, digit)))
            .filter(|(value, label)| {
                ends.contains(&math::log10(*value)) && (every == 1 || label.is_some())
            })
            .collect()
    }

    /// The ticks with labels.
    pub(crate) fn labels(&self) -> impl Iterator<Item = (f64, String)> {
        self.ticks().into_iter().filter_map(|(value, label)| Some((value, label?)))
    }
}

/// The least and the greatest of some values.
pub(crate) fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |ends, v| {
        let (low, high) = ends.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

/// The ends of an axis about some values, at round numbers for about so many labels.
pub(crate) fn around(values: impl Iterator<Item = f64>, labels: f64) -> (f64, f64) {
    let Some((low, high)) = ends(values) else { return (0.0, 1.0) };
    let high = high.max(low + 1e-6);
    let step = 0.5 * round_step(high - low, labels);
    ((low / step).floor() * step, (high / step).ceil() * step)
}

/// A digit times a power of ten.
fn label_of(digit: i64, power: i32) -> String {
    match power {
        0..=3 => (digit * 10_i64.pow(power as u32)).to_string(),
        -3..=-1 => {
            format!("{:.*}", power.unsigned_abs() as usize, digit as f64 * 10f64.powi(power))
        }
        _ => format!("{digit}e{power}"),
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that divides `span` into at most `most` parts.
pub(crate) fn round_step(span: f64, most: f64) -> f64 {
    let least = span / most;
    let ten = math::pow(10.0, math::log10(least).floor());
    let round = [1.0, 2.0, 5.0].map(|times| times * ten).into_iter();
    round.into_iter().find(|&step| step >= least * (1.0 - 1e-9)).unwrap_or(10.0 * ten)
}

/// The greatest of 1, 2 and 5 times a power of ten that is not above a number.
pub(crate) fn round_below(most: f64) -> f64 {
    let ten = math::pow(10.0, math::log10(most).floor());
    [5.0, 2.0].map(|times| times * ten).into_iter().find(|&round| round <= most).unwrap_or(ten)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().filter_map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let linear = |low, high| labels(&Axis::linear((low, high), (0.0, 100.0), 8.0));
        assert_eq!(linear(7.5, 14.0), ["8", "9", "10", "11", "12", "13", "14"]);
        assert_eq!(linear(0.35, 1.0), ["0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1.0"]);
        assert_eq!(linear(8.6, 8.6003)[..2], ["8.60000", "8.60005"]);
        assert_eq!(linear(-0.2, 0.2)[2..5], ["-0.10", "-0.05", "0.00"]);
        let log = |low, high| labels(&Axis::log((low, high), (0.0, 100.0)));
        assert_eq!(log(-5.0, 0.0), ["1e-5", "1e-4", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(log(-1.2, 11.0), ["1", "1000", "1e6", "1e9"]);
        assert_eq!(log(-2.4, -0.9), ["0.005", "0.01", "0.02", "0.05", "0.1"]);
    }

    #[test]
    fn ends_are_put_at_the_ends() {
        let linear = Axis::linear((2.0, 4.0), (100.0, 20.0), 8.0);
        for (value, place) in [(2.0, 100.0), (4.0, 20.0), (3.0, 60.0)] {
            assert!((linear.place(value) - place).abs() < 1e-12);
        }
        let log = Axis::log((-2.0, 2.0), (100.0, 20.0));
        for (value, place) in [(0.01, 100.0), (100.0, 20.0), (1.0, 60.0), (0.0, 100.0)] {
            assert!((log.place(value) - place).abs() < 1e-12);
        }
    }

    #[test]
    fn small_ticks_divide_the_step() {
        let linear = Axis::linear((0.0, 1.0), (0.0, 1.0), 5.0).ticks();
        assert!(linear.len() == 21 && (linear[1].0 - 0.05).abs() < 1e-12);
        let log = Axis::log((0.0, 1.0), (0.0, 1.0)).ticks();
        assert!(log.len() == 10 && (log[1].0 - 2.0).abs() < 1e-12);
    }

    #[test]
    fn bars_are_round_and_at_least_two_fifths_of_their_room() {
        let round = [1.0, 4.9, 30.0, 99.0, 700.0].map(round_below);
        assert_eq!(round, [1.0, 2.0, 20.0, 50.0, 500.0]);
        for most in [0.9, 4.0, 79.9, 80.0, 3100.0, 12_345.0] {
            assert!((0.4 * most..=most).contains(&round_below(most)), "{most}");
        }
    }
}
