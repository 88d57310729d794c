//! What a histogram says for given reflectances and radiances, of a bed and of a pixel alike.
//!
//! A path that hits facets of reflectance rho_1, rho_2, ... brings the weight W = rho_1 rho_2 ...
//! to the sky. What it does not bring there the facets emit.

use rayon::prelude::*;

use super::kept::Kept;
use super::mean::standard_error;
use super::{Histogram, Mean, Sums};
use crate::support::random::GROUPS;

/// Bands that are evaluated side by side, as the inner loop.
pub(crate) const LANES: usize = 16;

/// Powers of a reflectance that are computed beforehand.
const POWERS: usize = 64;

/// Radiance that reaches the sensor, W m-2 sr-1 um-1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radiance {
    /// What facets emit, also by way of other facets.
    pub l_emitted: Mean,
    /// What they reflect of the sky.
    pub l_reflected: Mean,
    /// All that leaves the target: their sum (Eq. 1).
    pub l_target: Mean,
}

/// What there is to reflect and to emit, in one band. Radiances are in W m-2 sr-1 um-1.
#[derive(Debug, Clone, Copy)]
pub struct Sources<'a> {
    /// Reflectance of each symbol.
    pub reflectance: &'a [f64],
    /// Radiance of a black body at the temperature of each material, layer by layer.
    pub l_blackbody: &'a [f64],
    /// Radiance of the sky in each zenith bin.
    pub l_sky: &'a [f64],
}

impl Sources<'_> {
    /// The brightest of all facets and the sky.
    pub(crate) fn brightest(&self) -> f64 {
        range(self.l_blackbody)[1].max(range(self.l_sky)[1])
    }
}

/// The least and the greatest of some radiances.
fn range(l: &[f64]) -> [f64; 2] {
    l.iter().fold([f64::INFINITY, 0.0], |[least, greatest], &l| [least.min(l), greatest.max(l)])
}

/// What a histogram gives in one band, as sums over each group.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    /// The weight that reaches the sky: 1 less the emissivity.
    pub weight: Sums,
    l_emitted: Sums,
    l_reflected: Sums,
    /// All that leaves the target (Eq. 1).
    pub l_target: Sums,
}

/// `N` bands made ready for evaluating histograms.
pub(crate) struct Evaluator<const N: usize> {
    product: Product<N>,
    light: Light<N>,
}

impl<const N: usize> Evaluator<N> {
    /// For histograms that record `kept`.
    pub(crate) fn new(kept: Kept, bands: [Sources; N]) -> Self {
        let light = Light::new(kept, bands);
        Self { product: Product::new(kept, bands.map(|band| band.reflectance)), light }
    }

    /// Evaluates a histogram whose paths that met the target are `met`, by group.
    ///
    /// # Panics
    /// If materials differ in radiance and the histogram does not record the order of hits.
    pub(crate) fn evaluate(&self, histogram: &Histogram, met: &[f64; GROUPS]) -> [Seen; N] {
        let Light { l_blackbody, l_sky, same_temperature, open, .. } = &self.light;
        let weights = histogram.weights_of(&self.product);
        // With one temperature and one sky radiance all radiances are linear in the weight.
        let radiances = (!same_temperature || l_sky.len() > 1)
            .then(|| histogram.radiances_of(&self.product, &self.light));
        std::array::from_fn(|lane| {
            let weight = weights[lane];
            let [mut l_emitted, mut l_reflected, mut l_target] = [Sums::ZERO; 3];
            if let Some([emitted, reflected]) = &radiances {
                (l_emitted, l_reflected) = (emitted[lane], reflected[lane]);
            } else {
                l_emitted.add(&weight, -l_blackbody[0][lane], l_blackbody[0][lane], met);
                l_reflected.add(&weight, l_sky[0][lane], 0.0, met);
            }
            l_target.add(&l_emitted, 1.0, 0.0, met);
            l_target.add(&l_reflected, 1.0, 0.0, met);
            let sums = [&mut l_emitted, &mut l_reflected, &mut l_target];
            for (sums, open) in sums.into_iter().zip(open) {
                sums.open = 2.0 * weight.open * open[lane];
            }
            Seen { weight, l_emitted, l_reflected, l_target }
        })
    }
}

/// The radiance of facets and sky in `N` bands.
struct Light<const N: usize> {
    cosines: usize,
    /// Of each material, layer by layer.
    l_blackbody: Vec<[f64; N]>,
    /// Of each zenith bin.
    l_sky: Vec<[f64; N]>,
    same_temperature: bool,
    /// The unknown rest of a path given up is taken to be half facets and half sky, each at the
    /// middle of its range: the radiances of these halves,
    rest: [[f64; N]; 2],
    /// and how far from the truth they and their sum are at most.
    open: [[f64; N]; 3],
}

impl<const N: usize> Light<N> {
    fn new(kept: Kept, bands: [Sources; N]) -> Self {
        let l_blackbody = transposed(bands.map(|band| band.l_blackbody));
        let l_sky = transposed(bands.map(|band| band.l_sky));
        let same_temperature = l_blackbody.iter().all(|l| *l == l_blackbody[0]);
        assert!(same_temperature || kept.order, "the order of hits is needed: temperatures differ");
        let ranges = bands.map(|band| [range(band.l_blackbody), range(band.l_sky)]);
        let half = |[least, greatest]: [f64; 2]| f64::midpoint(least, greatest) / 2.0;
        let rest = [0, 1].map(|of| ranges.map(|range| half(range[of])));
        let open = [0, 1, 2].map(|of| {
            std::array::from_fn(|lane| {
                let [facets, sky] = ranges[lane];
                let both = [facets[0].min(sky[0]), facets[1].max(sky[1])];
                let [facets_rest, sky_rest] = [rest[0][lane], rest[1][lane]];
                match of {
                    0 => facets[1] - facets_rest,
                    1 => sky[1] - sky_rest,
                    _ => (both[1] - facets_rest - sky_rest).max(facets_rest + sky_rest - both[0]),
                }
            })
        });
        let cosines = kept.cosines.into();
        Self { cosines, l_blackbody, l_sky, same_temperature, rest, open }
    }

    /// What the hits of a path of that weight emit.
    fn emitted(&self, hits: &[u16], weight: [f64; N], product: &Product<N>) -> [f64; N] {
        if self.same_temperature {
            return std::array::from_fn(|lane| (1.0 - weight[lane]) * self.l_blackbody[0][lane]);
        }
        let (mut sum, mut weight) = ([0.0; N], [1.0; N]);
        for &symbol in hits {
            let rho = &product.reflectance[usize::from(symbol)];
            let l_blackbody = &self.l_blackbody[usize::from(symbol) / self.cosines];
            for lane in 0..N {
                sum[lane] += weight[lane] * (1.0 - rho[lane]) * l_blackbody[lane];
                weight[lane] *= rho[lane];
            }
        }
        sum
    }
}

/// The product of the reflectances of a path's hits, in `N` bands.
struct Product<const N: usize> {
    kept: Kept,
    /// Of each symbol.
    reflectance: Vec<[f64; N]>,
    /// By symbol and number of hits, where states count hits: states are many, powers few.
    powers: Vec<Vec<[f64; N]>>,
}

impl<const N: usize> Product<N> {
    fn new(kept: Kept, bands: [&[f64]; N]) -> Self {
        let reflectance = transposed(bands);
        let powers = |rho: &[f64; N]| {
            let next = |power: &[f64; N]| Some(times(*power, rho));
            std::iter::successors(Some([1.0; N]), next).take(POWERS).collect()
        };
        let powers =
            if kept.lists() { Vec::new() } else { reflectance.iter().map(powers).collect() };
        Self { kept, reflectance, powers }
    }

    #[inline]
    fn of(&self, hits: &[u16]) -> [f64; N] {
        if self.kept.lists() {
            let factors = hits.iter().map(|&symbol| &self.reflectance[usize::from(symbol)]);
            return factors.fold([1.0; N], times);
        }
        let mut product = [1.0; N];
        for (material, &n) in hits.iter().enumerate().filter(|(_, n)| **n > 0) {
            product = match self.powers[material].get(usize::from(n)) {
                Some(power) => times(product, power),
                None => times(product, &self.reflectance[material].map(|rho| rho.powi(n.into()))),
            };
        }
        product
    }
}

fn times<const N: usize>(a: [f64; N], b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|lane| a[lane] * b[lane])
}

/// One array for each entry of the bands.
fn transposed<const N: usize>(bands: [&[f64]; N]) -> Vec<[f64; N]> {
    (0..bands[0].len()).map(|entry| bands.map(|band| band[entry])).collect()
}

/// Sums over the paths of each group, in `N` bands.
struct Accumulator<const N: usize> {
    value: [[f64; N]; GROUPS],
    open: [f64; N],
}

impl<const N: usize> Accumulator<N> {
    const ZERO: Self = Self { value: [[0.0; N]; GROUPS], open: [0.0; N] };

    #[inline]
    fn add(&mut self, counts: &[(u16, i64)], value: [f64; N]) {
        for &(group, count) in counts {
            for (sum, value) in self.value[usize::from(group)].iter_mut().zip(value) {
                *sum += count as f64 * value;
            }
        }
    }

    fn leave_open(&mut self, counts: &[(u16, i64)], value: [f64; N]) {
        for (open, value) in self.open.iter_mut().zip(value) {
            *open += counts.iter().map(|&(_, count)| count as f64 * value).sum::<f64>();
        }
    }

    fn sums(&self) -> [Sums; N] {
        std::array::from_fn(|lane| Sums {
            value: self.value.map(|of| of[lane]),
            open: self.open[lane],
        })
    }
}

impl Histogram {
    /// The mean weight that paths bring to the sky, for a reflectance of each symbol.
    ///
    /// It is the directional-hemispherical reflectance of the bed: 1 less its emissivity
    /// (Kirchhoff).
    pub fn weight(&self, reflectance: &[f64]) -> Mean {
        self.weights(reflectance).mean(&self.met(), 1.0)
    }

    /// The mean weight of each of the first `N` groups or cells; of one without paths that of all.
    pub fn weight_of_groups<const N: usize>(&self, reflectance: &[f64]) -> [f64; N] {
        let (sums, met) = (self.weights(reflectance), self.met());
        let mean = sums.value.iter().sum::<f64>() / met.iter().sum::<f64>();
        std::array::from_fn(|i| if met[i] > 0.0 { sums.value[i] / met[i] } else { mean })
    }

    /// How much less weight the paths of `other` bring to the sky. Both took the same points: the
    /// error is that of the difference.
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

    /// [`Histogram::weight`] in several bands, each given as one reflectance for each symbol.
    pub fn weight_in(&self, bands: &[Vec<f64>]) -> Vec<Mean> {
        let met = self.met();
        let means = |lanes: &[Vec<f64>]| -> Vec<Mean> {
            let of = |lane: usize| lanes.get(lane).unwrap_or(&lanes[0]).as_slice();
            let product = Product::<LANES>::new(self.kept, std::array::from_fn(of));
            let sums = self.weights_of(&product);
            sums.iter().take(lanes.len()).map(|sums| sums.mean(&met, 1.0)).collect()
        };
        bands.par_chunks(LANES).flat_map_iter(means).collect()
    }

    /// The mean weight that paths bring to the sky and the radiance that leaves the target.
    ///
    /// # Panics
    /// If materials differ in radiance and the histogram does not record the order of hits.
    pub fn seen(&self, sources: Sources) -> (Mean, Radiance) {
        let met = self.met();
        let [seen] = Evaluator::new(self.kept, [sources]).evaluate(self, &met);
        let radiance = Radiance {
            l_emitted: seen.l_emitted.mean(&met, range(sources.l_blackbody)[1]),
            l_reflected: seen.l_reflected.mean(&met, range(sources.l_sky)[1]),
            l_target: seen.l_target.mean(&met, sources.brightest()),
        };
        (seen.weight.mean(&met, 1.0), radiance)
    }

    fn weights(&self, reflectance: &[f64]) -> Sums {
        let [sums] = self.weights_of(&Product::new(self.kept, [reflectance]));
        sums
    }

    fn weights_of<const N: usize>(&self, product: &Product<N>) -> [Sums; N] {
        let mut sums = Accumulator::ZERO;
        for (state, counts) in &self.escaped {
            let (hits, _) = self.kept.split(state);
            sums.add(counts, product.of(hits));
        }
        for (state, counts) in &self.given_up {
            let half = product.of(state).map(|weight| weight / 2.0);
            sums.add(counts, half);
            sums.leave_open(counts, half);
        }
        sums.sums()
    }

    /// What is emitted and what is reflected.
    fn radiances_of<const N: usize>(
        &self,
        product: &Product<N>,
        light: &Light<N>,
    ) -> [[Sums; N]; 2] {
        let [mut emitted, mut reflected] = [const { Accumulator::<N>::ZERO }; 2];
        for (state, counts) in &self.escaped {
            let (hits, bin) = self.kept.split(state);
            let weight = product.of(hits);
            emitted.add(counts, light.emitted(hits, weight, product));
            reflected.add(counts, times(weight, &light.l_sky[bin]));
        }
        for (state, counts) in &self.given_up {
            let weight = product.of(state);
            let [facets, sky] = light.rest.map(|rest| times(weight, &rest));
            let own = light.emitted(state, weight, product);
            emitted.add(counts, std::array::from_fn(|lane| own[lane] + facets[lane]));
            reflected.add(counts, sky);
        }
        // Facets emit all that never reaches the sky. Only paths of one temperature are rouletted.
        emitted.add(&self.rouletted, light.l_blackbody[0]);
        [emitted, reflected].map(|sums| sums.sums())
    }
}
