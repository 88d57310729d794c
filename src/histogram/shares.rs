//! What several histograms together give for reflectances, with exact derivatives.

use std::collections::BTreeMap;

use super::{Histogram, totals};

/// The share of the paths of each of several histograms in each state, of all groups together.
///
/// The mean weight that paths bring to the sky is G(rho), the sum over states of their share times
/// the product of the reflectances of their hits: the joint generating function of the hits. A path
/// that was given up counts half of what it may still bring, as in every signature.
#[derive(Debug, Clone, PartialEq)]
pub struct Shares {
    /// Powers of reflectances: each symbol and its number of hits.
    powers: Vec<(u16, u16)>,
    /// Of all states one after the other, the places of their powers.
    of_states: Vec<u32>,
    /// Where each state ends among these.
    ends: Vec<u32>,
    /// By histogram, then by state.
    shares: Vec<Vec<f64>>,
}

/// What a weighted sum of histograms gives in a band.
#[derive(Debug, Clone, PartialEq)]
pub struct Summed {
    /// The sum with each set of weights.
    pub values: Vec<f64>,
    /// The derivative of the first along each direction.
    pub slopes: Vec<f64>,
}

/// The least reflectance that a derivative is divided by: it is exact for states with one hit.
const LEAST: f64 = 1e-12;

impl Shares {
    /// Of histograms that record the same of each path. Paths that escape at different zenith angles
    /// count alike.
    ///
    /// # Panics
    /// Without a histogram.
    pub fn of(histograms: &[&Histogram]) -> Self {
        Self::of_kinds(histograms, &|symbol| symbol)
    }

    /// The same where some symbols always have the same reflectance, and the same derivatives:
    /// `kind` names one for all of them. So there are fewer states.
    ///
    /// # Panics
    /// Without a histogram.
    pub fn of_kinds(histograms: &[&Histogram], kind: &dyn Fn(u16) -> u16) -> Self {
        let lists = histograms[0].kept.lists();
        let mut numbers: BTreeMap<Vec<(u16, u16)>, usize> = BTreeMap::new();
        let mut shares: Vec<Vec<f64>> = vec![Vec::new(); histograms.len()];
        for (of, shares) in histograms.iter().zip(&mut shares) {
            let all = of.paths() * of.parts as f64;
            let states = [(&of.escaped, 1.0, true), (&of.given_up, 0.5, false)];
            let states = states.into_iter().flat_map(|(states, part, escaped)| {
                totals(states).map(move |(state, count)| {
                    (if escaped { of.kept.split(state).0 } else { &**state }, part, count)
                })
            });
            for (state, part, count) in states {
                let next = numbers.len();
                let number = *numbers.entry(hits(state, lists, kind)).or_insert(next);
                if shares.len() <= number {
                    shares.resize(number + 1, 0.0);
                }
                shares[number] += part * count as f64 / all;
            }
        }
        let mut states: Vec<&[(u16, u16)]> = vec![&[]; numbers.len()];
        for (state, &number) in &numbers {
            states[number] = state;
        }
        for shares in &mut shares {
            shares.resize(states.len(), 0.0);
        }
        let mut places: BTreeMap<(u16, u16), u32> = BTreeMap::new();
        let (mut of_states, mut ends) = (Vec::new(), Vec::new());
        for state in states {
            for &power in state {
                let next = places.len() as u32;
                of_states.push(*places.entry(power).or_insert(next));
            }
            ends.push(of_states.len() as u32);
        }
        let mut powers = vec![(0, 0); places.len()];
        for (power, place) in places {
            powers[place as usize] = power;
        }
        Self { powers, of_states, ends, shares }
    }

    /// The share of each state in a sum of the histograms with these weights.
    pub fn mixture(&self, weights: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.ends.len()];
        for (shares, weight) in self.shares.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            for (sum, share) in sum.iter_mut().zip(shares) {
                *sum += weight * share;
            }
        }
        sum
    }

    /// The weight that a mixture brings to the sky for a reflectance of each symbol.
    pub fn value(&self, mixture: &[f64], reflectance: &[f64]) -> f64 {
        let powers = self.powers_of(reflectance);
        let mut from = 0;
        let of = |(&share, &end): (&f64, &u32)| {
            let state = &self.of_states[from..end as usize];
            from = end as usize;
            if share == 0.0 {
                return 0.0;
            }
            state.iter().fold(share, |weight, &place| weight * powers[place as usize])
        };
        mixture.iter().zip(&self.ends).map(of).sum()
    }

    fn powers_of(&self, reflectance: &[f64]) -> Vec<f64> {
        let at = |&(symbol, n): &(u16, u16)| reflectance[usize::from(symbol)].powi(n.into());
        self.powers.iter().map(at).collect()
    }

    /// The weights that mixtures bring to the sky for a reflectance of each symbol, and the
    /// derivative of the first along directions: derivatives of the reflectances in a parameter.
    pub fn weight(
        &self,
        mixtures: &[&[f64]],
        reflectance: &[f64],
        directions: &[&[f64]],
    ) -> Summed {
        let safe: Vec<f64> = reflectance.iter().map(|rho| rho.max(LEAST)).collect();
        let relative: Vec<Vec<f64>> = directions
            .iter()
            .map(|of| of.iter().zip(&safe).map(|(d, rho)| d / rho).collect())
            .collect();
        let powers = self.powers_of(&safe);
        let mut values = vec![0.0; mixtures.len()];
        let mut slopes = vec![0.0; directions.len()];
        let mut from = 0;
        for (number, &end) in self.ends.iter().enumerate() {
            let state = &self.of_states[from..end as usize];
            from = end as usize;
            if mixtures.iter().all(|mixture| mixture[number] == 0.0) {
                continue;
            }
            let weight = state.iter().fold(1.0, |weight, &place| weight * powers[place as usize]);
            for (value, mixture) in values.iter_mut().zip(mixtures) {
                *value += mixture[number] * weight;
            }
            let weight = mixtures[0][number] * weight;
            for (slope, relative) in slopes.iter_mut().zip(&relative) {
                let of_power = |&place: &u32| {
                    let (symbol, n) = self.powers[place as usize];
                    f64::from(n) * relative[usize::from(symbol)]
                };
                *slope += weight * state.iter().map(of_power).sum::<f64>();
            }
        }
        Summed { values, slopes }
    }
}

/// The symbols of a state, each with its number of hits.
fn hits(state: &[u16], lists: bool, kind: &dyn Fn(u16) -> u16) -> Vec<(u16, u16)> {
    let mut hits: BTreeMap<u16, u16> = BTreeMap::new();
    for (symbol, &of) in (0..).zip(state) {
        let (symbol, n) = if lists { (of, 1) } else { (symbol, of) };
        if n > 0 {
            *hits.entry(kind(symbol)).or_default() += n;
        }
    }
    hits.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::histogram::kept::{Kept, PARTS};

    type States<'a> = &'a [(&'a [u16], i64)];

    fn histogram(kept: Kept, escaped: States, given_up: States) -> Histogram {
        let of = |states: States| {
            states.iter().map(|(state, n)| ((*state).into(), vec![(0, *n)])).collect()
        };
        let (escaped, given_up) = (of(escaped), of(given_up));
        Histogram { kept, parts: PARTS, escaped, given_up, rouletted: vec![(1, 5)] }
    }

    const COUNTS: Kept = Kept::PLAIN;
    const LISTS: Kept = Kept { cosines: 2, ..Kept::PLAIN };

    /// Two beds each of counts and of lists, with numbers of symbols.
    fn beds() -> [([Histogram; 2], usize); 2] {
        let a = histogram(COUNTS, &[(&[1, 0], 30), (&[2, 3], 20), (&[0, 70], 5)], &[(&[9, 1], 4)]);
        let b = histogram(COUNTS, &[(&[1, 0], 10), (&[2, 4], 25)], &[]);
        let c = histogram(LISTS, &[(&[0], 30), (&[1, 1, 3], 20), (&[0, 2, 3, 3], 9)], &[]);
        let d = histogram(LISTS, &[(&[0], 30), (&[0, 2, 2], 9)], &[(&[2, 2], 4)]);
        [([a, b], 2), ([c, d], 4)]
    }

    /// The value is that of the histograms, the derivative that of central differences.
    #[test]
    fn sums_and_their_derivatives_are_those_of_the_histograms() {
        for ([a, b], n) in beds() {
            let rho = &[0.7, 0.4, 0.55, 0.9][..n];
            let direction = &[0.3, -0.2, 0.11, 0.05][..n];
            let shares = Shares::of(&[&a, &b]);
            let mixtures = [shares.mixture(&[0.3, 0.7]), shares.mixture(&[-1.0, 0.0])];
            let mixtures = [&mixtures[0][..], &mixtures[1][..]];
            let found = shares.weight(&mixtures, rho, &[direction]);
            let [a, b] = [&a, &b].map(|of| of.weight(rho).mean);
            assert!((found.values[0] - 0.3 * a - 0.7 * b).abs() < 1e-14, "{found:?}");
            assert!((found.values[1] + a).abs() < 1e-14, "{found:?}");
            let moved = |step: f64| {
                let rho: Vec<f64> = rho.iter().zip(direction).map(|(r, d)| r + step * d).collect();
                shares.value(mixtures[0], &rho)
            };
            assert!((moved(0.0) - found.values[0]).abs() < 1e-14, "{found:?}");
            let differences = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((found.slopes[0] - differences).abs() < 1e-8, "{found:?} {differences}");
        }
    }

    /// Symbols in pairs that reflect alike.
    #[test]
    fn symbols_that_reflect_alike_are_one() {
        for ([a, b], n) in beds() {
            let rho = &[0.7, 0.7, 0.55, 0.55][..n];
            let direction = &[0.3, 0.3, 0.11, 0.11][..n];
            let [all, pairs] =
                [Shares::of(&[&a, &b]), Shares::of_kinds(&[&a, &b], &|symbol| symbol - symbol % 2)];
            assert!(pairs.powers.len() < all.powers.len());
            let [all, pairs] = [all, pairs].map(|of| {
                let mixture = of.mixture(&[0.3, 0.7]);
                of.weight(&[&mixture], rho, &[direction])
            });
            assert!((all.values[0] - pairs.values[0]).abs() < 1e-14, "{all:?} {pairs:?}");
            assert!((all.slopes[0] - pairs.slopes[0]).abs() < 1e-14, "{all:?} {pairs:?}");
        }
    }

    #[test]
    fn a_black_facet_has_a_derivative() {
        let of = histogram(COUNTS, &[(&[1, 1], 40), (&[0, 2], 5)], &[]);
        let shares = Shares::of(&[&of]);
        let mixture = shares.mixture(&[1.0]);
        let found = shares.weight(&[&mixture], &[0.0, 0.5], &[&[1.0, 0.0]]);
        assert!((found.values[0] - 0.025).abs() < 1e-9, "{found:?}");
        assert!((found.slopes[0] - 0.4).abs() < 1e-9, "{found:?}");
    }
}
