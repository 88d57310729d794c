//! A pixel's histogram into its spectrum: the sums of `histogram.rs` for all wavelengths at a time.
//!
//! A histogram holds a hundred states and is evaluated at hundreds of wavelengths for tens of thousands of pixels, so the
//! wavelengths are the inner loop.

use super::bands::Bands;
use crate::histogram::tally::Kept;
use crate::histogram::{Histogram, Mean, Sums};
use crate::radiometry::Lit;
use crate::support::random::GROUPS;

/// Powers of a reflectance that are computed beforehand.
const POWERS: usize = 24;

/// What an image's pixels are evaluated with.
pub(super) struct Evaluator<'a> {
    kept: Kept,
    lit: Vec<Lit>,
    bands: &'a Bands,
    /// Reflectance of each symbol, by wavelength.
    reflectance: Vec<Vec<f64>>,
    /// Of each material and number of hits, by wavelength; where states count hits.
    powers: Vec<Vec<Vec<f64>>>,
    /// Radiance of a black body for each symbol, by wavelength; none where the emissivity tells the radiance.
    l_blackbody: Option<Vec<Vec<f64>>>,
}

/// A pixel's spectra.
pub(super) struct Spectra {
    /// Emissivity in each band.
    pub emissivity: Vec<Mean>,
    /// Radiance at the sensor in each band.
    pub l_sensor: Vec<Mean>,
}

/// Sums over the paths of each group, by wavelength.
struct Rows {
    nodes: usize,
    sums: Vec<f64>,
    open: Vec<f64>,
}

impl Rows {
    fn new(nodes: usize) -> Self {
        Self { nodes, sums: vec![0.0; nodes * GROUPS], open: vec![0.0; nodes] }
    }

    fn add(&mut self, counts: &[(u16, i64)], values: &[f64]) {
        for &(group, count) in counts {
            let row = &mut self.sums[usize::from(group) * self.nodes..][..self.nodes];
            for (sum, value) in row.iter_mut().zip(values) {
                *sum += count as f64 * value;
            }
        }
    }

    fn leave_open(&mut self, counts: &[(u16, i64)], values: &[f64]) {
        let number: f64 = counts.iter().map(|&(_, count)| count as f64).sum();
        for (open, value) in self.open.iter_mut().zip(values) {
            *open += number * value;
        }
    }

    /// Other sums of the same paths: `factor` times these and `more` for each path.
    fn affine(&mut self, met: &[f64; GROUPS], of: impl Fn(usize) -> (f64, f64)) {
        for node in 0..self.nodes {
            let (factor, more) = of(node);
            for (group, met) in met.iter().enumerate() {
                let sum = &mut self.sums[group * self.nodes + node];
                *sum = factor * *sum + more * met;
            }
            self.open[node] *= factor.abs();
        }
    }

    fn in_bands(&self, bands: &Bands, met: &[f64; GROUPS], greatest: &[f64]) -> Vec<Mean> {
        let seen = |weights: &Vec<(usize, f64)>| {
            let of = |row: &[f64]| weights.iter().map(|&(node, w)| w * row[node]).sum();
            let value = std::array::from_fn(|r| of(&self.sums[r * self.nodes..][..self.nodes]));
            Sums { value, open: of(&self.open) }.mean(met, of(greatest))
        };
        bands.weights.iter().map(seen).collect()
    }
}

impl<'a> Evaluator<'a> {
    /// With what lights the nodes of the bands.
    pub(super) fn new(kept: Kept, lit: Vec<Lit>, bands: &'a Bands) -> Self {
        let symbols = lit[0].reflectance.len();
        let by_wavelength = |of: &dyn Fn(&Lit) -> f64| lit.iter().map(of).collect::<Vec<f64>>();
        let reflectance: Vec<Vec<f64>> =
            (0..symbols).map(|s| by_wavelength(&|lit| lit.reflectance[s])).collect();
        let powers = |rho: &Vec<f64>| {
            (0..POWERS as i32).map(|n| rho.iter().map(|rho| rho.powi(n)).collect()).collect()
        };
        let powers =
            if kept.lists() { Vec::new() } else { reflectance.iter().map(powers).collect() };
        let alike = |lit: &Lit| lit.l_blackbody_of.iter().all(|&l| l == lit.l_blackbody);
        let l_blackbody = (kept.zeniths > 1 || !lit.iter().all(alike)).then(|| {
            let of_material = |s: usize| s / usize::from(kept.cosines);
            (0..symbols).map(|s| by_wavelength(&|lit| lit.l_blackbody_of[of_material(s)])).collect()
        });
        Self { kept, lit, bands, reflectance, powers, l_blackbody }
    }

    /// The spectra of a pixel whose histogram is not empty.
    pub(super) fn spectra(&self, histogram: &Histogram) -> Spectra {
        let met = histogram.met();
        let mut weight_sums = Rows::new(self.lit.len());
        let mut l_sums = self.l_blackbody.as_ref().map(|_| Rows::new(self.lit.len()));
        let [mut weight, mut l, mut l_open] = [const { Vec::new() }; 3].map(|mut row: Vec<f64>| {
            row.resize(self.lit.len(), 0.0);
            row
        });
        for (state, counts) in &histogram.escaped {
            let (hits, bin) = self.kept.split(state);
            self.follow(hits, &mut weight, &mut l);
            weight_sums.add(counts, &weight);
            if let Some(sums) = &mut l_sums {
                for (node, lit) in self.lit.iter().enumerate() {
                    l[node] += weight[node] * lit.l_sky[bin];
                }
                sums.add(counts, &l);
            }
        }
        for (state, counts) in &histogram.trapped {
            self.follow(state, &mut weight, &mut l);
            for (node, weight) in weight.iter_mut().enumerate() {
                let (middle, furthest) = self.lit[node].sources().still_to_come();
                l[node] += *weight * middle;
                l_open[node] = *weight * furthest;
                *weight /= 2.0;
            }
            weight_sums.add(counts, &weight);
            weight_sums.leave_open(counts, &weight);
            if let Some(sums) = &mut l_sums {
                sums.add(counts, &l);
                sums.leave_open(counts, &l_open);
            }
        }
        // Of what never reaches the sky facets emit all; where paths may be ended they are of one temperature.
        if let (Some(sums), Some(l_blackbody)) = (&mut l_sums, &self.l_blackbody) {
            sums.add(&histogram.ended, &l_blackbody[0]);
        }
        let ones = vec![1.0; self.lit.len()];
        let weights = weight_sums.in_bands(self.bands, &met, &ones);
        let emissivity = weights.into_iter().map(|w| Mean { mean: 1.0 - w.mean, ..w }).collect();
        let brightest: Vec<f64> =
            self.lit.iter().map(|lit| lit.l_sensor(lit.sources().brightest())).collect();
        let mut l_sums = l_sums.unwrap_or_else(|| {
            // A path emits with all the weight that it does not bring to the sky.
            weight_sums.affine(&met, |node| {
                let lit = &self.lit[node];
                (lit.l_sky[0] - lit.l_blackbody, lit.l_blackbody)
            });
            weight_sums
        });
        l_sums.affine(&met, |node| {
            let lit = &self.lit[node];
            let l_path = lit.l_sensor(0.0);
            (lit.l_sensor(1.0) - l_path, l_path)
        });
        Spectra { emissivity, l_sensor: l_sums.in_bands(self.bands, &met, &brightest) }
    }

    /// The weight that is left after some hits, and what they emit, by wavelength.
    fn follow(&self, hits: &[u16], weight: &mut [f64], l: &mut [f64]) {
        weight.fill(1.0);
        l.fill(0.0);
        if !self.kept.lists() {
            for (material, &number) in hits.iter().enumerate().filter(|(_, n)| **n > 0) {
                let number = usize::from(number);
                if let Some(powers) = self.powers[material].get(number) {
                    weight.iter_mut().zip(powers).for_each(|(weight, power)| *weight *= power);
                } else {
                    let rho = self.reflectance[material].iter();
                    weight.iter_mut().zip(rho).for_each(|(w, rho)| *w *= rho.powi(number as i32));
                }
            }
            if let Some(l_blackbody) = &self.l_blackbody {
                // Without their order all hits have one temperature.
                for (node, l) in l.iter_mut().enumerate() {
                    *l = (1.0 - weight[node]) * l_blackbody[0][node];
                }
            }
            return;
        }
        for &symbol in hits {
            let rho = &self.reflectance[usize::from(symbol)];
            if let Some(l_blackbody) = &self.l_blackbody {
                let l_blackbody = &l_blackbody[usize::from(symbol)];
                for (node, l) in l.iter_mut().enumerate() {
                    *l += weight[node] * (1.0 - rho[node]) * l_blackbody[node];
                }
            }
            weight.iter_mut().zip(rho).for_each(|(weight, rho)| *weight *= rho);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::histogram::Counted;
    use crate::scene::Grid;

    fn lit(um: f64, cosines: u16, zeniths: u16, two_temperatures: bool) -> Lit {
        let symbols = 2 * cosines;
        Lit {
            wavelength_um: um,
            reflectance: (0..symbols).map(|s| 0.1 + 0.05 * um / (f64::from(s) + 1.0)).collect(),
            l_blackbody_of: vec![
                9.0 - um / 4.0,
                if two_temperatures { 5.0 } else { 9.0 - um / 4.0 },
            ],
            l_sky: (0..zeniths).map(|bin| 1.0 + 0.2 * f64::from(bin) + 0.1 * um).collect(),
            l_blackbody: 9.0 - um / 4.0,
            l_downwelling: 0.0,
            path: (two_temperatures).then_some((0.8, 0.5)),
        }
    }

    /// Each kind of histogram against the evaluation of a bed's, wavelength by wavelength.
    #[test]
    fn a_pixel_is_evaluated_as_a_bed_is() {
        let grid = Grid::new(8.0, 10.0, 0.5).expect("a grid");
        let bands = Bands::new(None, std::path::Path::new(""), &grid).expect("bands");
        let kinds = [
            (Kept::PLAIN, false),
            (Kept { zeniths: 3, ..Kept::PLAIN }, false),
            (Kept { order: true, ..Kept::PLAIN }, true),
            (Kept { cosines: 4, ..Kept::PLAIN }, false),
            (Kept { order: true, cosines: 4, zeniths: 3 }, true),
        ];
        for (kept, two_temperatures) in kinds {
            let state = |number: u16| -> Vec<u16> {
                if kept.lists() {
                    (0..=number % 5).map(|i| (i * number + number) % (2 * kept.cosines)).collect()
                } else {
                    vec![1 + number % 3, number % 2 * 30]
                }
            };
            let counts =
                |number: u16| vec![(number % 7, 3), (7 + number % 9, i64::from(number) + 1)];
            let escaped: Vec<Counted> = (0..30)
                .map(|number| {
                    let bin = (kept.zeniths > 1).then_some(number % 3);
                    (state(number).into_iter().chain(bin).collect(), counts(number))
                })
                .collect();
            let trapped: Vec<Counted> =
                (30..34).map(|number| (state(number).into(), counts(number))).collect();
            let ended = if kept.order { Vec::new() } else { vec![(3, -4), (9, 6)] };
            let histogram = Histogram { kept, parts: 5, escaped, trapped, ended };
            let lit: Vec<Lit> = bands
                .nodes_um
                .iter()
                .map(|&um| lit(um, kept.cosines, kept.zeniths, two_temperatures))
                .collect();
            let spectra = Evaluator::new(kept, lit.clone(), &bands).spectra(&histogram);
            for (band, lit) in lit.iter().enumerate() {
                let (emissivity, radiance) = lit.seen(&histogram);
                let transmittance = lit.l_sensor(1.0) - lit.l_sensor(0.0);
                let l_sensor = Mean {
                    mean: lit.l_sensor(radiance.l_target.mean),
                    standard_error: transmittance * radiance.l_target.standard_error,
                    trapped: transmittance * radiance.l_target.trapped,
                };
                for (ours, theirs) in
                    [(spectra.emissivity[band], emissivity), (spectra.l_sensor[band], l_sensor)]
                {
                    let pairs = [
                        (ours.mean, theirs.mean),
                        (ours.standard_error, theirs.standard_error),
                        (ours.trapped, theirs.trapped),
                    ];
                    for (a, b) in pairs {
                        assert!(
                            (a - b).abs() < 1e-12,
                            "{kept:?}, band {band}: {ours:?} {theirs:?}"
                        );
                    }
                }
            }
        }
    }
}
