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
