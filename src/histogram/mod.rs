//! The joint histogram of what paths did, and what it says for given reflectances.
//!
//! A path that hits facets of reflectance rho_1, rho_2, ... before it reaches the sky carries W, their product,
//! to it. The histogram is all that any spectra need to know of a traced bed: it is evaluated
//! without tracing again.

pub mod estimate;
mod mean;
pub mod tally;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::histogram::tally::{ByCell, CELLS, Counts, Ended, Kept, PARTS, State, Tally};
use crate::support::random::GROUPS;
use mean::standard_error;

pub use estimate::Estimate;
pub use mean::Mean;
pub(crate) use mean::Sums;

/// A state and, for each group that has any, how many parts of its paths ended in it.
pub type Counted = (State, Vec<(u16, i64)>);

/// How many parts of the paths of each group ended in which state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Histogram {
    /// What the states tell.
    pub kept: Kept,
    /// Parts that make a path.
    pub parts: u64,
    /// States of those that reached the sky, in lexical order.
    pub escaped: Vec<Counted>,
    /// States of those that were given up, in lexical order.
    pub trapped: Vec<Counted>,
    /// Parts of paths that Russian roulette ended, less those that it added, by group: with them the others add up to
    /// the paths. They bring nothing to the sky.
    pub ended: Vec<(u16, i64)>,
}

/// Radiance that reaches the sensor, W m-2 sr-1 um-1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radiance {
    /// What facets emit, sent on by others or not.
    pub l_emitted: Mean,
    /// What they reflect of the sky.
    pub l_reflected: Mean,
    /// All that leaves the target: their sum (Eq. 1).
    pub l_target: Mean,
}

/// What there is to reflect and to emit, in one band.
#[derive(Debug, Clone, Copy)]
pub struct Sources<'a> {
    /// Reflectance of each symbol.
    pub reflectance: &'a [f64],
    /// Radiance of a black body at the temperature of each material.
    pub l_blackbody: &'a [f64],
    /// Radiance of the sky in each zenith bin.
    pub l_sky: &'a [f64],
}

impl Sources<'_> {
    /// Of facets and of the sky: the darkest, the brightest and half of what is midway.
    fn ends(&self) -> [(f64, f64, f64); 2] {
        [self.l_blackbody, self.l_sky].map(|l| {
            let ends = (
                l.iter().fold(f64::INFINITY, |a, &b| a.min(b)),
                l.iter().fold(0.0, |a: f64, &b| a.max(b)),
            );
            (ends.0, ends.1, f64::midpoint(ends.0, ends.1) / 2.0)
        })
    }

    /// The brightest of all facets and the sky.
    pub(crate) fn brightest(&self) -> f64 {
        let [facets, sky] = self.ends();
        facets.1.max(sky.1)
    }

    /// What a trapped path would still have brought for all of its weight, and how far from the truth that can be: as half
    /// from facets and half from the sky, at the middle of each.
    pub(crate) fn still_to_come(&self) -> (f64, f64) {
        let [facets, sky] = self.ends();
        let (darkest, brightest) = (facets.0.min(sky.0), facets.1.max(sky.1));
        let middle = facets.2 + sky.2;
        (middle, (brightest - middle).max(middle - darkest))
    }
}

/// Cells of the view are summed as groups are.
const _: () = assert!((CELLS * CELLS) as usize <= GROUPS);

/// Powers of a reflectance that are computed beforehand.
const POWERS: usize = 64;

impl Histogram {
    /// The histogram of a tally.
    pub fn of(tally: &Tally) -> Self {
        Self::grouped(tally.kept(), &tally.escaped, &tally.trapped, &tally.ended)
    }

    /// The same with the cells of the view in place of groups; `None` where the view has none.
    pub fn by_cell(tally: &Tally) -> Option<Self> {
        let ByCell { escaped, trapped, ended } = &tally.by_cell;
        let any = !escaped.is_empty() || !trapped.is_empty() || !ended.is_empty();
        any.then(|| Self::grouped(tally.kept(), escaped, trapped, ended))
    }

    fn grouped(kept: Kept, escaped: &Counts, trapped: &Counts, ended: &Ended) -> Self {
        let ended = ended.iter().map(|(&group, &parts)| (group, parts)).collect();
        Self { kept, parts: PARTS, escaped: grouped(escaped), trapped: grouped(trapped), ended }
    }

    /// Puts the counts back as they were before they were grouped.
    pub(crate) fn ungroup(&self, escaped: &mut Counts, trapped: &mut Counts, ended: &mut Ended) {
        ended.extend(self.ended.iter().copied());
        for (into, from) in [(escaped, &self.escaped), (trapped, &self.trapped)] {
            for (state, counts) in from {
                for &(group, count) in counts {
                    let key = state.iter().copied().chain([group]).collect();
                    into.insert(key, count);
                }
            }
        }
    }

    /// A histogram of no path.
    pub fn empty(kept: Kept) -> Self {
        let none = Vec::new;
        Self { kept, parts: PARTS, escaped: none(), trapped: none(), ended: Vec::new() }
    }

    /// As JSON of an object one level deep in another, one state a line.
    pub(crate) fn json(&self) -> String {
        let plain = "a histogram is plain data";
        let kept = serde_json::to_string(&self.kept).expect(plain);
        let ended = serde_json::to_string(&self.ended).expect(plain);
        let [escaped, trapped] = [&self.escaped, &self.trapped].map(|states| {
            let lines: Vec<String> = states
                .iter()
                .map(|state| format!("\n      {}", serde_json::to_string(state).expect(plain)))
                .collect();
            let end = if lines.is_empty() { "" } else { "\n    " };
            format!("[{}{end}]", lines.join(","))
        });
        format!(
            "{{\n    \"kept\": {kept},\n    \"parts\": {},\n    \"escaped\": {escaped},\n    \"trapped\": {trapped},\n    \"ended\": {ended}\n  }}",
            self.parts
        )
    }

    /// How many paths it holds.
    pub fn paths(&self) -> f64 {
        self.met_by_group().map(|(_, parts)| parts).sum::<i64>() as f64 / self.parts as f64
    }

    /// How many paths were given up, those in part by their share.
    pub fn given_up(&self) -> f64 {
        sum(&self.trapped) as f64 / self.parts as f64
    }

    /// Whether both count the same paths, in whatever groups.
    pub(crate) fn counts_as(&self, other: &Self) -> bool {
        let alike = |ours: &[Counted], theirs: &[Counted]| totals(ours).eq(totals(theirs));
        let ended = |of: &Self| of.ended.iter().map(|(_, parts)| parts).sum::<i64>();
        self.kept == other.kept
            && ended(self) == ended(other)
            && alike(&self.escaped, &other.escaped)
            && alike(&self.trapped, &other.trapped)
    }

    /// What makes a histogram that was read no histogram of so many materials and groups or cells.
    pub(crate) fn check(&self, materials: usize, groups: usize) -> Result<(), String> {
        let kept = self.kept;
        if self.parts != PARTS {
            return Err(format!("a path has {} parts, not {PARTS}", self.parts));
        }
        if kept.cosines == 0 || kept.zeniths == 0 {
            return Err("a number of bins is 0".into());
        }
        let symbols = kept.symbols(materials);
        let sound = |hits: &[u16]| {
            if kept.lists() {
                hits.iter().all(|&symbol| usize::from(symbol) < symbols)
            } else {
                hits.len() == materials
            }
        };
        if self.met_by_group().any(|(group, _)| usize::from(group) >= groups) {
            return Err(format!("a group or cell is not within 0 to {}", groups - 1));
        }
        let states = self.escaped.iter().chain(&self.trapped);
        if states.flat_map(|(_, counts)| counts).any(|(_, count)| *count < 0) {
            return Err("a count is below 0".into());
        }
        // A path may be given up before its first hit, and reaches no sky before it.
        let escaped = self.escaped.iter().all(|(state, _)| {
            let (hits, bin) = kept.split(state);
            !hits.is_empty() && sound(hits) && bin < kept.zeniths.into()
        });
        if !escaped || !self.trapped.iter().all(|(state, _)| sound(state)) {
            return Err("a state does not fit the materials and what is kept of a path".into());
        }
        if kept.order && !self.ended.is_empty() {
            return Err("paths that keep the order of hits are not ended by chance".into());
        }
        Ok(())
    }

    /// Parts of paths that met the target, by group.
    pub(crate) fn met(&self) -> [f64; GROUPS] {
        let mut met = [0.0; GROUPS];
        for (group, parts) in self.met_by_group() {
            met[usize::from(group)] += parts as f64;
        }
        met
    }

    /// All counts, by group or cell.
    fn met_by_group(&self) -> impl Iterator<Item = (u16, i64)> {
        let states = self.escaped.iter().chain(&self.trapped).flat_map(|(_, counts)| counts);
        states.chain(&self.ended).copied()
    }

    /// The mean weight that paths bring to the sky, for a reflectance of each symbol.
    ///
    /// The directional-hemispherical reflectance of the bed: 1 less its emissivity (Kirchhoff).
    pub fn weight(&self, reflectance: &[f64]) -> Mean {
        self.weights(reflectance).mean(&self.met(), 1.0)
    }

    /// The mean weight of each of the first `N` groups or cells; of one without paths that of all.
    pub fn weight_of_groups<const N: usize>(&self, reflectance: &[f64]) -> [f64; N] {
        let (sums, met) = (self.weights(reflectance), self.met());
        let mean = sums.value.iter().sum::<f64>() / met.iter().sum::<f64>();
        std::array::from_fn(|i| if met[i] > 0.0 { sums.value[i] / met[i] } else { mean })
    }

    /// How much less weight the paths of `other` bring to the sky, where both took the same points: its error is
    /// that of the difference.
    pub fn less_weight(&self, other: &Self, reflectance: &[f64]) -> Mean {
        let [ours, theirs] = [self, other].map(|of| (of.weights(reflectance), of.met()));
        let [of_ours, of_theirs] = [&ours, &theirs].map(|(sums, met)| sums.residuals(met));
        let residuals = std::array::from_fn(|g| of_ours[g] - of_theirs[g]);
        let [mean, other] = [ours, theirs].map(|(sums, met)| sums.mean(&met, 1.0));
        Mean {
            mean: mean.mean - other.mean,
            standard_error: standard_error(&residuals, &self.met(), 1.0),
            trapped: mean.trapped + other.trapped,
        }
    }

    /// The mean weight in each of some bands, given as one reflectance for each symbol: [`Histogram::weight`] of many at once.
    pub fn weight_in(&self, bands: &[Vec<f64>]) -> Vec<Mean> {
        const LANES: usize = 16;
        let met = self.met();
        let means = |lanes: &[Vec<f64>]| -> Vec<Mean> {
            let of = |lane: usize| lanes.get(lane).unwrap_or(&lanes[0]).as_slice();
            let sums = self.weights_of::<LANES>(std::array::from_fn(of));
            sums.iter().take(lanes.len()).map(|sums| sums.mean(&met, 1.0)).collect()
        };
        bands.par_chunks(LANES).flat_map_iter(means).collect()
    }

    fn weights(&self, reflectance: &[f64]) -> Sums {
        let [sums] = self.weights_of([reflectance]);
        sums
    }

    /// Of so many bands, which are the inner loop.
    fn weights_of<const LANES: usize>(&self, bands: [&[f64]; LANES]) -> [Sums; LANES] {
        let product = Product::new(self.kept, bands);
        let mut values = [[0.0; LANES]; GROUPS];
        let mut open = [0.0; LANES];
        let mut add = |counts: &[(u16, i64)], weight: [f64; LANES]| {
            for &(group, count) in counts {
                for (sum, weight) in values[usize::from(group)].iter_mut().zip(weight) {
                    *sum += count as f64 * weight;
                }
            }
        };
        for (state, counts) in &self.escaped {
            let (hits, _) = self.kept.split(state);
            add(counts, product.of(hits));
        }
        for (state, counts) in &self.trapped {
            let half = product.of(state).map(|weight| weight / 2.0);
            add(counts, half);
            for (open, half) in open.iter_mut().zip(half) {
                *open += counts.iter().map(|&(_, count)| count as f64 * half).sum::<f64>();
            }
        }
        std::array::from_fn(|lane| Sums { value: values.map(|of| of[lane]), open: open[lane] })
    }

    /// The radiance that reaches the sensor.
    ///
    /// # Panics
    /// If materials differ in radiance and the histogram does not keep the order of hits.
    pub fn radiance(&self, sources: Sources) -> Radiance {
        let Sources { reflectance, l_blackbody, l_sky } = sources;
        let product = Product::new(self.kept, [reflectance]);
        let alike = l_blackbody.iter().all(|l| *l == l_blackbody[0]);
        assert!(alike || self.kept.order, "materials differ in temperature: their order is needed");
        let cosines = usize::from(self.kept.cosines);
        // What the hits of a path emit, and the weight that is left for what comes after them.
        let emitted = |hits: &[u16]| {
            if alike {
                let [weight] = product.of(hits);
                return ((1.0 - weight) * l_blackbody[0], weight);
            }
            hits.iter().fold((0.0, 1.0), |(sum, weight), &symbol| {
                let rho = reflectance[usize::from(symbol)];
                let l_blackbody = l_blackbody[usize::from(symbol) / cosines];
                (sum + weight * (1.0 - rho) * l_blackbody, weight * rho)
            })
        };
        let [facets, sky] = sources.ends();
        let (middle, furthest) = sources.still_to_come();
        let brightest = sources.brightest();
        let [mut target, mut all_emitted, mut all_reflected] = [const { Sums::new() }; 3];
        for (state, counts) in &self.escaped {
            let (hits, bin) = self.kept.split(state);
            let (own, weight) = emitted(hits);
            let sky = weight * l_sky[bin];
            target.add(counts, own + sky, 0.0);
            all_emitted.add(counts, own, 0.0);
            all_reflected.add(counts, sky, 0.0);
        }
        for (state, counts) in &self.trapped {
            let (own, weight) = emitted(state);
            target.add(counts, own + weight * middle, weight * furthest);
            all_emitted.add(counts, own + weight * facets.2, weight * (facets.1 - facets.2));
            all_reflected.add(counts, weight * sky.2, weight * (sky.1 - sky.2));
        }
        // Of what never reaches the sky facets emit all; where paths may be ended they are of one temperature.
        target.add(&self.ended, l_blackbody[0], 0.0);
        all_emitted.add(&self.ended, l_blackbody[0], 0.0);
        let met = self.met();
        Radiance {
            l_emitted: all_emitted.mean(&met, facets.1),
            l_reflected: all_reflected.mean(&met, sky.1),
            l_target: target.mean(&met, brightest),
        }
    }
}

fn totals(counted: &[Counted]) -> impl Iterator<Item = (&State, i64)> {
    counted.iter().map(|(state, of)| (state, of.iter().map(|(_, count)| count).sum()))
}

fn sum(counted: &[Counted]) -> i64 {
    totals(counted).map(|(_, count)| count).sum()
}

fn grouped(counts: &Counts) -> Vec<Counted> {
    // By whole keys a state would be torn apart by those that it begins.
    let mut list: Vec<(&[u16], u16, i64)> = Vec::with_capacity(counts.len());
    for (key, &count) in counts {
        let (&group, state) = key.split_last().expect("a key ends with its group");
        list.push((state, group, count));
    }
    list.sort_unstable();
    let mut groups: Vec<Counted> = Vec::new();
    for (state, group, count) in list {
        match groups.last_mut() {
            Some((last, of)) if **last == *state => of.push((group, count)),
            _ => groups.push((state.into(), vec![(group, count)])),
        }
    }
    groups
}

/// The product of the reflectances of a path's hits, in so many bands.
struct Product<'a, const LANES: usize> {
    lists: bool,
    bands: [&'a [f64]; LANES],
    /// By symbol and number of hits: states are many, powers few.
    powers: Vec<Vec<[f64; LANES]>>,
}

impl<'a, const LANES: usize> Product<'a, LANES> {
    fn new(kept: Kept, bands: [&'a [f64]; LANES]) -> Self {
        let lists = kept.lists();
        let of = |symbol: usize| {
            let rho = bands.map(|band| band[symbol]);
            let next = |power: &[f64; LANES]| Some(std::array::from_fn(|i| power[i] * rho[i]));
            std::iter::successors(Some([1.0; LANES]), next).take(POWERS).collect()
        };
        let symbols = if lists { 0 } else { bands[0].len() };
        Self { lists, bands, powers: (0..symbols).map(of).collect() }
    }

    fn of(&self, hits: &[u16]) -> [f64; LANES] {
        let mut product = [1.0; LANES];
        let mut times = |factors: [f64; LANES]| {
            for (product, factor) in product.iter_mut().zip(factors) {
                *product *= factor;
            }
        };
        if self.lists {
            for &symbol in hits {
                times(self.bands.map(|band| band[usize::from(symbol)]));
            }
            return product;
        }
        for (material, &n) in hits.iter().enumerate().filter(|(_, n)| **n > 0) {
            let listed = self.powers[material].get(usize::from(n)).copied();
            times(listed.unwrap_or_else(|| self.bands.map(|band| band[material].powi(n.into()))));
        }
        product
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::statistics::{T_95, quantile_95};

    fn state(hits: &[u16]) -> State {
        hits.into()
    }

    #[test]
    fn a_path_may_be_given_up_before_its_first_hit_and_reach_no_sky_from_nowhere() {
        let kept = Kept { order: true, ..Kept::PLAIN };
        let nowhere = vec![(state(&[]), vec![(0, PARTS as i64)])];
        let of = |escaped: Vec<Counted>, trapped: Vec<Counted>| Histogram {
            kept,
            parts: PARTS,
            escaped,
            trapped,
            ended: Vec::new(),
        };
        let given_up = of(Vec::new(), nowhere.clone());
        assert_eq!(given_up.check(1, GROUPS), Ok(()));
        assert_eq!(given_up.weight(&[0.5]).mean, 0.5);
        assert!(of(nowhere, Vec::new()).check(1, GROUPS).is_err());
    }

    /// The keys [1, 2, 5] of a state and [1, 2] of a shorter one are neighbours.
    #[test]
    fn states_that_others_begin_with_are_counted_whole() {
        let keys: [&[u16]; 4] = [&[1, 1], &[1, 2, 5], &[1, 2], &[1, 3]];
        let counts = keys.iter().map(|key| (state(key), 5)).collect();
        let whole =
            vec![(state(&[1]), vec![(1, 5), (2, 5), (3, 5)]), (state(&[1, 2]), vec![(5, 5)])];
        assert_eq!(grouped(&counts), whole);
    }

    #[test]
    fn the_mean_and_its_error_are_those_of_twins() {
        // Twins of 2 and 6 paths in fifths; facets of rho .5 and .2.
        let histogram = Histogram {
            parts: PARTS,
            kept: Kept::PLAIN,
            escaped: vec![
                (state(&[0, 1]), vec![(0, 4), (1, 20)]),
                (state(&[1, 0]), vec![(0, 6), (1, 6)]),
            ],
            trapped: vec![(state(&[2, 0]), vec![(1, 4)])],
            ended: Vec::new(),
        };
        let weight = histogram.weight(&[0.5, 0.2]);
        let sums: [f64; 2] = [4.0 * 0.2 + 6.0 * 0.5, 20.0 * 0.2 + 6.0 * 0.5 + 4.0 * 0.125];
        let mean = (sums[0] + sums[1]) / 40.0;
        assert!((weight.mean - mean).abs() < 1e-15);
        let differ = (sums[0] - 10.0 * mean) - (sums[1] - 30.0 * mean);
        let unsure = quantile_95(2) / T_95;
        assert!((weight.standard_error - differ.abs() / 40.0 * unsure).abs() < 1e-14);
        assert!((weight.trapped - 4.0 * 0.125 / 40.0).abs() < 1e-15);
        assert_eq!((histogram.paths(), histogram.given_up()), (8.0, 0.8));
    }

    /// Each cell of the view of another brightness, as many paths in each: both nets find the same, and the mean is exact.
    #[test]
    fn what_differs_from_cell_to_cell_is_no_noise() {
        let counts = |n: i64| (0..GROUPS as u16).map(|g| (g, n * i64::from(1 + g / 2))).collect();
        let rest = (0..GROUPS as u16).map(|g| (g, 100 - i64::from(1 + g / 2))).collect();
        let histogram = Histogram {
            parts: PARTS,
            kept: Kept::PLAIN,
            escaped: vec![(state(&[1]), counts(1)), (state(&[2]), rest)],
            trapped: Vec::new(),
            ended: Vec::new(),
        };
        assert_eq!(histogram.weight(&[0.5]).standard_error, 0.0);
        let mut uneven = histogram.clone();
        uneven.escaped[0].1[6].1 += 1;
        uneven.escaped[1].1[6].1 -= 1;
        let expected = 0.25 / (100.0 * GROUPS as f64);
        assert!((uneven.weight(&[0.5]).standard_error - expected).abs() < 1e-15);
    }

    /// Two paths of one hit, and one that had two: its equal was ended, it stands for both.
    #[test]
    fn what_chance_ended_brings_nothing_and_counts_all_the_same() {
        let histogram = Histogram {
            parts: 1,
            kept: Kept::PLAIN,
            escaped: vec![(state(&[1]), vec![(0, 1), (1, 1)]), (state(&[2]), vec![(1, 2)])],
            trapped: Vec::new(),
            ended: vec![(0, 1), (1, -1)],
        };
        assert_eq!(histogram.paths(), 4.0);
        assert_eq!(histogram.weight(&[0.5]).mean, (2.0 * 0.5 + 2.0 * 0.25) / 4.0);
        let sources = Sources { reflectance: &[0.5], l_blackbody: &[8.0], l_sky: &[2.0] };
        let radiance = histogram.radiance(sources);
        // Of four paths two reflect a half and two a quarter, of which one never came back.
        assert_eq!(radiance.l_reflected.mean, 0.375 * 2.0);
        assert_eq!(radiance.l_emitted.mean, 0.625 * 8.0);
    }

    #[test]
    fn one_net_tells_nothing_of_the_spread() {
        let histogram = Histogram {
            parts: PARTS,
            kept: Kept::PLAIN,
            escaped: vec![(state(&[1]), vec![(3, 1000)])],
            trapped: Vec::new(),
            ended: Vec::new(),
        };
        assert_eq!(histogram.weight(&[0.5]).standard_error, 0.5);
    }

    /// Two paths by hand: over the first material into the sky's second bin; over the first, the second, and the first
    /// again into its first bin.
    #[test]
    fn radiance_is_emitted_and_reflected_in_the_order_of_hits() {
        let kept = Kept { order: true, cosines: 1, zeniths: 2 };
        let histogram = Histogram {
            kept,
            parts: PARTS,
            escaped: vec![(state(&[0, 1]), vec![(0, 1)]), (state(&[0, 1, 0, 0]), vec![(1, 1)])],
            trapped: Vec::new(),
            ended: Vec::new(),
        };
        let (rho, l, sky) = ([0.5, 0.2], [10.0, 20.0], [1.0, 3.0]);
        let sources = Sources { reflectance: &rho, l_blackbody: &l, l_sky: &sky };
        let radiance = histogram.radiance(sources);
        let first = [0.5 * 10.0, 0.5 * 3.0];
        let second =
            [0.5 * 10.0 + 0.5 * 0.8 * 20.0 + 0.5 * 0.2 * 0.5 * 10.0, 0.5 * 0.2 * 0.5 * 1.0];
        assert!((radiance.l_emitted.mean - f64::midpoint(first[0], second[0])).abs() < 1e-14);
        assert!((radiance.l_reflected.mean - f64::midpoint(first[1], second[1])).abs() < 1e-14);
        let sum = radiance.l_emitted.mean + radiance.l_reflected.mean;
        assert!((radiance.l_target.mean - sum).abs() < 1e-14);
    }

    #[test]
    fn what_trapped_paths_may_still_bring_is_in_the_mean_and_left_open() {
        let histogram = Histogram {
            kept: Kept { order: true, ..Kept::PLAIN },
            parts: PARTS,
            escaped: Vec::new(),
            trapped: vec![(state(&[0]), vec![(0, 1), (1, 1)])],
            ended: Vec::new(),
        };
        let sources = Sources { reflectance: &[0.5], l_blackbody: &[8.0], l_sky: &[12.0] };
        let radiance = histogram.radiance(sources);
        // Emitted for certain: 4; to come: .5 of 8, if all is facets, to .5 of 12, if all is sky.
        let both = |mean: Mean| (mean.mean, mean.trapped);
        assert_eq!(both(radiance.l_target), (4.0 + 5.0, 1.0));
        assert_eq!(both(radiance.l_emitted), (4.0 + 2.0, 2.0));
        assert_eq!(both(radiance.l_reflected), (3.0, 3.0));
    }
}
