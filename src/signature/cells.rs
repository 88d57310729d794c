//! What beds differ by, told from the cells of the view of one or a few of them.

use crate::histogram::tally::CELLS;
use crate::histogram::{Estimate, Histogram, Mean};
use crate::support::statistics::quantile_95;
use crate::table::Table;

const CELLS_ALL: usize = (CELLS * CELLS) as usize;

/// What the cells of beds' views say.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfCells {
    beds: usize,
    /// Standard deviation of a bed's mean, by the spread between its cells.
    pub(super) spread: f64,
    pub(super) rim: f64,
}

impl OfCells {
    pub(super) fn new(beds: &[&Histogram], reflectance: &[f64]) -> Self {
        let of_beds: Vec<[f64; CELLS_ALL]> =
            beds.iter().map(|cells| cells.weight_of_groups(reflectance)).collect();
        let n = of_beds.len() as f64;
        let mut variance = 0.0;
        let mut differences = Vec::new();
        for cells in &of_beds {
            let mean = cells.iter().sum::<f64>() / cells.len() as f64;
            let squares: f64 = cells.iter().map(|cell| (cell - mean).powi(2)).sum();
            variance += squares / (cells.len() - 1) as f64 / n;
            let side = usize::from(CELLS);
            let is_inner =
                |i: &usize| [i % side, i / side].iter().all(|x| (1..side - 1).contains(x));
            let inner: Vec<f64> = (0..cells.len()).filter(is_inner).map(|i| cells[i]).collect();
            differences.push(inner.iter().sum::<f64>() / inner.len() as f64 - mean);
        }
        let rim = Estimate::of(
            &differences
                .iter()
                .map(|&mean| Mean {
                    mean,
                    // Inner cells are a quarter of all: by them and the others, 1/4 + 1/12 of a cell's variance, times 3/4.
                    standard_error: 0.75 * (variance / 3.0).sqrt(),
                    trapped: 0.0,
                })
                .collect::<Vec<_>>(),
        );
        Self {
            beds: beds.len(),
            spread: (variance / CELLS_ALL as f64).sqrt(),
            rim: (rim.mean.abs() - rim.standard_error).max(0.0),
        }
    }

    /// Of the 95 % interval of the mean over all cells.
    pub(super) fn half_width(&self) -> f64 {
        let freedom = self.beds * (CELLS_ALL - 1);
        quantile_95(freedom + 1) * self.spread / (self.beds as f64).sqrt()
    }
}

/// Standard deviation that packings may have, by that between the cells within each of a few of them; `None` where the
/// target does not fill the view.
pub fn spread_by_cells(packings: &[Table], reflectance: &[f64]) -> Option<f64> {
    let cells: Option<Vec<_>> = packings.iter().map(|table| table.cells.as_ref()).collect();
    Some(OfCells::new(&cells?, reflectance).spread)
}
