//! Scales, and ticks at round numbers.

/// A linear scale from values to places on the page.
pub(super) struct Axis {
    low: f64,
    high: f64,
    step: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// `low` < `high` are put at `from` and `to`, with `most_ticks` ticks at most.
    pub(super) fn new((low, high): (f64, f64), (from, to): (f64, f64), most_ticks: f64) -> Self {
        Self { low, high, step: round_step(high - low, most_ticks), from, to }
    }

    /// The place of a value.
    pub(super) fn place(&self, value: f64) -> f64 {
        self.from + (self.to - self.from) * (value - self.low) / (self.high - self.low)
    }

    /// Values with a label.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let digits = (-self.step.log10() - 1e-9).ceil().max(0.0) as usize;
        self.multiples(self.step).map(|v| (v, format!("{v:.digits$}"))).collect()
    }

    /// Values between the ticks, in round parts of their step, with the ticks among them.
    pub(super) fn small_ticks(&self) -> impl Iterator<Item = f64> {
        let mantissa = self.step / 10f64.powf(self.step.log10().floor());
        let parts = if (1.5..3.0).contains(&mantissa) { 4.0 } else { 5.0 };
        self.multiples(self.step / parts)
    }

    fn multiples(&self, step: f64) -> impl Iterator<Item = f64> {
        // A value that is a multiple but for rounding counts as one.
        let first = (self.low / step - 1e-6).ceil() as i64;
        let last = (self.high / step + 1e-6).floor() as i64;
        // Adding zero turns -0 into 0.
        (first..=last).map(move |i| i as f64 * step + 0.0)
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that divides `span` into `most` parts or less.
pub(super) fn round_step(span: f64, most: f64) -> f64 {
    let least = span / most;
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|&step| step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        let axis = Axis::new((low, high), (0.0, 100.0), 8.0);
        axis.ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(labels(7.5, 14.0), ["8", "9", "10", "11", "12", "13", "14"]);
        assert_eq!(labels(0.35, 1.0), ["0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1.0"]);
        assert_eq!(labels(8.6, 8.6003)[..2], ["8.60000", "8.60005"]);
        assert_eq!(labels(-0.2, 0.2)[2], "-0.10");
        assert_eq!(labels(-0.2, 0.2)[4], "0.00");
    }

    #[test]
    fn ends_are_put_at_the_ends() {
        let axis = Axis::new((2.0, 4.0), (100.0, 20.0), 8.0);
        assert!((axis.place(2.0) - 100.0).abs() < 1e-12);
        assert!((axis.place(4.0) - 20.0).abs() < 1e-12);
        assert!((axis.place(3.0) - 60.0).abs() < 1e-12);
    }

    #[test]
    fn small_ticks_divide_the_step() {
        let axis = Axis::new((0.0, 1.0), (0.0, 1.0), 5.0);
        let small: Vec<f64> = axis.small_ticks().collect();
        assert_eq!(small.len(), 21);
        assert!((small[1] - 0.05).abs() < 1e-12);
    }
}
