//! Random numbers that depend on nothing but a seed and a path's number: any thread may trace any
//! path, and the result is the same.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// What the numbers are for: different purposes never share any.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// The paths of the result.
    Result = 0,
    /// The paths that only tell how many are needed.
    Pilot = 1,
    /// Seeds of packings.
    Packing = 2,
    /// What of each prototype is seen.
    Coverage = 3,
}

/// The generators of all paths of one seed and purpose.
#[derive(Debug, Clone)]
pub struct Source(ChaCha8Rng);

/// The random numbers of one path.
#[derive(Debug)]
pub struct Stream(ChaCha8Rng);

impl Source {
    /// The generators of a seed.
    pub fn new(seed: u64, purpose: Purpose) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        Self(ChaCha8Rng::from_seed(key))
    }

    /// The numbers of the path of that number.
    pub fn path(&self, number: u64) -> Stream {
        let mut rng = self.0.clone();
        rng.set_stream(number);
        Stream(rng)
    }
}

impl Stream {
    /// Two uniform numbers in [0, 1), of 32 bits each.
    pub fn pair(&mut self) -> [f64; 2] {
        let bits = self.0.next_u64();
        [bits >> 32, bits & 0xffff_ffff].map(|half| half as f64 / 4_294_967_296.0)
    }
}

/// The seed of one of several packings, or of its rays: the first has the seed itself, the others have
/// seeds of their own, below 2^53 so that any JSON reader keeps them.
pub fn seed_of(seed: u64, packing: usize) -> u64 {
    if packing == 0 {
        return seed;
    }
    let mut rng = Source::new(seed, Purpose::Packing).path(packing as u64).0;
    rng.next_u64() >> 11
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_purposes_have_numbers_of_their_own() {
        let of = |seed, purpose, path| Source::new(seed, purpose).path(path).pair();
        let first = of(1, Purpose::Result, 0);
        assert_eq!(first, of(1, Purpose::Result, 0));
        for other in
            [of(2, Purpose::Result, 0), of(1, Purpose::Pilot, 0), of(1, Purpose::Result, 1)]
        {
            assert_ne!(first, other);
        }
    }

    #[test]
    fn every_packing_has_a_seed_of_its_own() {
        let mut seeds: Vec<u64> =
            (1..4).flat_map(|seed| (0..100).map(move |i| seed_of(seed, i))).collect();
        assert_eq!((seeds[0], seeds[100]), (1, 2), "the first keeps its seed");
        assert!(seeds.iter().all(|&seed| seed < 1 << 53));
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 300);
    }

    #[test]
    fn numbers_are_uniform_in_mean_and_spread() {
        let n = 100_000;
        let source = Source::new(7, Purpose::Result);
        let values: Vec<f64> = (0..n).flat_map(|path| source.path(path).pair()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        assert!((mean - 0.5).abs() < 0.003, "{mean}");
        assert!((var - 1.0 / 12.0).abs() < 0.001, "{var}");
    }
}
