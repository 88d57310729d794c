//! How much beds differ, estimated from the cells of the views of one or a few of them.

use crate::histogram::tally::CELLS;
use crate::histogram::{Estimate, Histogram, Mean};
use crate::signature::Levels;
use crate::signature::levels::MANY;
use crate::support::statistics::quantile_of;
use crate::table::Table;

const SIDE: usize = CELLS as usize;

/// A number for each cell of a bed's view, row by row.
pub(super) type Cells = [f64; SIDE * SIDE];

/// What the cells of beds' views say of a mean over all cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfCells {
    beds: usize,
    /// Standard deviation of a bed's mean, from the spread between its cells.
    pub(super) spread: f64,
    /// How much the inner cells differ from all: the part beyond one standard error, of many beds
    /// beyond the 95 % interval.
    pub(super) rim: f64,
}

impl OfCells {
    /// From the cells of each bed.
    pub(super) fn new(beds: &[Cells]) -> Self {
        let mut variance = 0.0;
        let mut differences = Vec::new();
        for cells in beds {
            let mean = cells.iter().sum::<f64>() / cells.len() as f64;
            let squares: f64 = cells.iter().map(|cell| (cell - mean).powi(2)).sum();
            variance += squares / (cells.len() - 1) as f64 / beds.len() as f64;
            let is_inner =
                |i: &usize| [i % SIDE, i / SIDE].iter().all(|x| (1..SIDE - 1).contains(x));
            let inner: Vec<f64> = (0..cells.len()).filter(is_inner).map(|i| cells[i]).collect();
            differences.push(inner.iter().sum::<f64>() / inner.len() as f64 - mean);
        }
        // A quarter of the cells are inner: a difference has (1/4 + 1/12) (3/4)^2 of their
        // variance.
        let standard_error = 0.75 * (variance / 3.0).sqrt();
        // Of many beds the rest is what their own interval holds.
        let chance = if beds.len() < MANY { 1.0 } else { quantile(beds.len()) };
        let of_bed = |&mean: &f64| Mean { mean, standard_error, trapped: 0.0 };
        let rim = Estimate::of(&differences.iter().map(of_bed).collect::<Vec<_>>());
        Self {
            beds: beds.len(),
            spread: (variance / (SIDE * SIDE) as f64).sqrt(),
            rim: (rim.mean.abs() - chance * rim.standard_error).max(0.0),
        }
    }

    /// From the weight of each cell in a band.
    pub(super) fn of_weights(beds: &[&Histogram], reflectance: &[f64]) -> Self {
        let cells = beds.iter().map(|cells| cells.weight_of_groups(reflectance));
        Self::new(&cells.collect::<Vec<Cells>>())
    }

    /// Half-width of the 95 % interval of the mean over all cells; `None` of many beds, whose own
    /// spread says more.
    pub(super) fn half_width(&self) -> Option<f64> {
        let half_width = quantile(self.beds) * self.spread / (self.beds as f64).sqrt();
        (self.beds < MANY).then_some(half_width)
    }
}

/// Quantile for the cells of so many beds.
fn quantile(beds: usize) -> f64 {
    quantile_of((beds * (SIDE * SIDE - 1)) as f64)
}

/// The cells of each drop; `None` where a target does not fill the view.
pub(super) fn of_tables<'a>(
    packings: &'a [Table],
    levels: &'a Levels,
) -> Option<Vec<&'a Histogram>> {
    levels.first(packings).map(|table| table.cells.as_ref()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(of: impl Fn(usize, usize) -> f64) -> Cells {
        std::array::from_fn(|i| of(i % SIDE, i / SIDE))
    }

    fn middle(inner: f64, outer: f64) -> Cells {
        let is_inner = |x: usize| (1..3).contains(&x);
        cells(|x, y| if is_inner(x) && is_inner(y) { inner } else { outer })
    }

    /// Four cells of 0.5 within twelve of 0.25: their mean is 0.3125, their variance 0.0125.
    #[test]
    fn the_rim_is_the_difference_of_the_inner_cells_beyond_chance() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} and {b}");
        let bed = middle(0.5, 0.25);
        let one = OfCells::new(&[bed]);
        // Student's t: 15 degrees of freedom, of three beds 45.
        close(one.half_width().expect("one bed"), 2.131_45 * (0.0125_f64 / 16.0).sqrt());
        let by_chance = 0.75 * (0.0125_f64 / 3.0).sqrt();
        close(one.rim, 0.1875 - by_chance);

        let three = OfCells::new(&[bed; 3]);
        close(three.spread, one.spread);
        close(three.half_width().expect("few beds"), 2.014_103 * (0.0125_f64 / 48.0).sqrt());
        close(three.rim, 0.1875 - by_chance / 3.0_f64.sqrt());

        // Of many beds the rim is what their interval leaves, 75 degrees of freedom.
        let many = OfCells::new(&[bed; 5]);
        assert_eq!(many.half_width(), None);
        close(many.rim, 0.1875 - 1.992_102 * by_chance / 5.0_f64.sqrt());
    }

    /// The inner cells of a chequerboard have the mean of all.
    #[test]
    fn cells_that_differ_without_a_rim_have_none() {
        let board = OfCells::new(&[cells(|x, y| if (x + y) % 2 == 0 { 0.5 } else { 0.25 })]);
        assert!(board.half_width().expect("one bed") > 0.06);
        assert_eq!(board.rim, 0.0);
        // Rims of opposite sign cancel.
        assert_eq!(OfCells::new(&[middle(0.5, 0.25), middle(0.25, 0.5)]).rim, 0.0);
    }
}
