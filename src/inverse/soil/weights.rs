//! The weight of each traced bed in a soil, over the cover and the share of large fines.

use super::{LargeShare, Soil, all};
use crate::support::hermite;

/// Covers that differ by less are taken as one where beds were dropped anew.
const ALIKE: f64 = 0.12;

/// Weights of the histograms in a sum, and their derivatives in the cover and in the large fines.
pub struct Weights {
    /// By histogram.
    pub value: Vec<f64>,
    /// Derivative in the cover.
    pub by_cover: Vec<f64>,
    /// Derivative in the share of large fines.
    pub by_large: Vec<f64>,
}

impl Weights {
    /// No bed.
    pub fn none(number: usize) -> Self {
        let none = vec![0.0; number];
        Self { value: none.clone(), by_cover: none.clone(), by_large: none }
    }
}

impl Soil {
    /// The weights of the histograms for a cover and a share of large fines.
    pub(super) fn weights(&self, cover: f64, large: f64) -> Weights {
        let number = all(&self.full, &self.fresh).count();
        let mut of = Weights::none(number);
        self.add_thinned(&mut of, cover, [1.0, 0.0], true);
        self.add_large(&mut of, cover, large);
        let groups = self.groups();
        // The places of what is dropped anew; there is nothing to correct at full cover.
        let mut places: Vec<f64> = groups.iter().map(|(cover, _)| *cover).collect();
        places.push(Self::covers(&self.full)[1]);
        let first = number - self.fresh.len();
        for (i, (_, beds)) in groups.iter().enumerate() {
            let (share, slope) = hat(&places, i, cover);
            if (share, slope) == (0.0, 0.0) {
                continue;
            }
            let each = 1.0 / beds.len() as f64;
            for &bed in beds {
                // The correction there: fresh less thinned.
                let at = self.fresh[bed].cover;
                self.add_thinned(&mut of, at, [-share * each, -slope * each], false);
                of.value[first + bed] += share * each;
                of.by_cover[first + bed] += slope * each;
            }
        }
        of
    }

    /// Adds the thinned beds at a cover, times a factor that may itself have a slope in the cover.
    pub(super) fn add_thinned(
        &self,
        to: &mut Weights,
        cover: f64,
        [factor, slope]: [f64; 2],
        moves: bool,
    ) {
        let beds = self.full.len() as f64;
        let mut first = 0;
        for bed in &self.full {
            let covers: Vec<f64> = bed.steps.iter().map(|step| step.cover).collect();
            let (value, by_cover) = hermite::weights(&covers, cover);
            for (i, (value, by_cover)) in value.iter().zip(&by_cover).enumerate() {
                let moved = if moves { factor * by_cover } else { 0.0 };
                to.value[first + i] += factor * value / beds;
                to.by_cover[first + i] += (slope * value + moved) / beds;
            }
            first += covers.len() + bed.fewer_large.len();
        }
    }

    /// Adds the effect of the share of large fines: linear in it, interpolated over the cover.
    fn add_large(&self, to: &mut Weights, cover: f64, large: f64) {
        let beds = self.full.len() as f64;
        let mut first = 0;
        for bed in &self.full {
            let others: Vec<f64> = bed.fewer_large.iter().map(|(step, _)| step.cover).collect();
            let covers: Vec<f64> = bed.steps.iter().map(|step| step.cover).collect();
            let own = first + covers.len();
            first = own + others.len();
            if others.is_empty() {
                continue;
            }
            let (value, by_cover) = hermite::weights(&others, cover);
            for (i, (step, LargeShare { here, usual })) in bed.fewer_large.iter().enumerate() {
                let per_share = 1.0 / ((usual - here) * beds);
                let (of, more) = (value[i] * per_share, large - usual);
                let by_cover = by_cover[i] * per_share;
                let mut add = |place: usize, sign: f64| {
                    to.value[place] += sign * of * more;
                    to.by_cover[place] += sign * by_cover * more;
                    to.by_large[place] += sign * of;
                };
                add(own + i, -1.0);
                // The same cover with the usual share.
                let (same, _) = hermite::weights(&covers, step.cover);
                same.iter().enumerate().for_each(|(i, w)| add(own - covers.len() + i, *w));
            }
        }
    }

    /// The fresh beds in groups of nearly one cover: their mean cover and their numbers. Beds that
    /// differ by chance at nearly the same cover would make a false slope between them; for the same
    /// reason those near full cover are left out.
    fn groups(&self) -> Vec<(f64, Vec<usize>)> {
        let top = Self::covers(&self.full)[1];
        let cover = |bed: usize| self.fresh[bed].cover;
        let mut order: Vec<usize> =
            (0..self.fresh.len()).filter(|&bed| cover(bed) <= top - ALIKE).collect();
        order.sort_by(|&a, &b| cover(a).total_cmp(&cover(b)));
        let of = |beds: &[usize]| {
            let sum: f64 = beds.iter().map(|&bed| cover(bed)).sum();
            (sum / beds.len() as f64, beds.to_vec())
        };
        order.chunk_by(|&a, &b| cover(b) - cover(a) < ALIKE).map(of).collect()
    }
}

/// The value and the slope of the curve of straight lines that is 1 at one place and 0 at all
/// others; constant beyond the ends.
fn hat(places: &[f64], number: usize, at: f64) -> (f64, f64) {
    let here = places[number];
    if at <= here {
        return match number.checked_sub(1).map(|before| places[before]) {
            None => (1.0, 0.0),
            Some(before) if at <= before => (0.0, 0.0),
            Some(before) => ((at - before) / (here - before), 1.0 / (here - before)),
        };
    }
    match places.get(number + 1) {
        None => (1.0, 0.0),
        Some(after) if at >= *after => (0.0, 0.0),
        Some(after) => ((after - at) / (after - here), -1.0 / (after - here)),
    }
}
