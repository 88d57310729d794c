//! Random numbers that depend on nothing but a seed and a path's number: any thread, and any machine, may
//! trace any path, and the result is the same.
//!
//! Paths take theirs from a low-discrepancy sequence, which covers the space of paths more evenly than
//! independent numbers do. Its error cannot be told from its own points, so they come in
//! [`REPLICATES`] that are scrambled independently of each other: the spread between the replicates' means
//! is the error. All else takes independent numbers.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Independent scramblings among which the paths of a trace are dealt out.
///
/// Fewer hold longer sequences, which are more even, but know less of their spread: 8 make intervals of the same width, and
/// 32 make them 5 % wider.
pub const REPLICATES: usize = 16;

/// Points of a sequence, of which [`sobol_burley`] makes no more; beyond it a replicate goes on with another
/// scrambling.
const SEQUENCE: u64 = 1 << 16;

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
    /// The paths of an image's pixels.
    Image = 4,
    /// The paths that only tell how many a pixel needs.
    ImagePilot = 5,
    /// Noise of the sensor.
    SensorNoise = 6,
}

/// Where paths take their numbers from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// A low-discrepancy sequence.
    Even,
    /// Independent numbers: what the sequence is compared with.
    Independent,
}

/// Paths that share one scrambling of each replicate: a pixel has no more, and the paths of pixel n are numbered
/// from n times as many on.
pub(crate) const STRETCH: u64 = SEQUENCE * REPLICATES as u64;

/// The points of all paths of one seed and purpose: Sobol' sequences with Owen's scrambling by hashes
/// (Burley, J. Comput. Graph. Tech. 9(4), 2020), one for each replicate.
#[derive(Debug, Clone)]
pub struct Points {
    source: Source,
    sampler: Sampler,
}

/// The coordinates of one path's point, two for its start and two for each bounce.
#[derive(Debug)]
pub enum Point {
    /// Of a sequence.
    Even(Even),
    /// Of independent numbers.
    Independent(Box<Stream>),
}

/// A place in a scrambled sequence.
#[derive(Debug)]
pub struct Even {
    index: u32,
    scrambling: u32,
    set: u32,
    /// The second pair of a set of four.
    held: Option<[f32; 2]>,
}

impl Points {
    /// The points of a seed.
    pub fn new(seed: u64, purpose: Purpose, sampler: Sampler) -> Self {
        Self { source: Source::new(seed, purpose), sampler }
    }

    /// The scrambling of each replicate for the paths whose numbers are in that stretch of the sequence.
    fn scramblings(&self, stretch: u64) -> [u32; REPLICATES] {
        let mut rng = self.source.stream(stretch).0;
        std::array::from_fn(|_| rng.next_u32())
    }

    /// The points of the paths `first..end`, with the replicate that each belongs to.
    pub fn of(&self, first: u64, end: u64) -> impl Iterator<Item = (usize, Point)> {
        let mut stretch = u64::MAX;
        let mut scramblings = [0; REPLICATES];
        (first..end).map(move |number| {
            let replicate = (number % REPLICATES as u64) as usize;
            if self.sampler == Sampler::Independent {
                return (replicate, Point::Independent(Box::new(self.source.stream(number))));
            }
            let index = number / REPLICATES as u64;
            if index / SEQUENCE != stretch {
                stretch = index / SEQUENCE;
                scramblings = self.scramblings(stretch);
            }
            let index = (index % SEQUENCE) as u32;
            let scrambling = scramblings[replicate];
            (replicate, Point::Even(Even { index, scrambling, set: 0, held: None }))
        })
    }
}

impl Point {
    /// The next two coordinates, in [0, 1).
    pub fn pair(&mut self) -> [f64; 2] {
        match self {
            Self::Even(even) => even.pair(),
            Self::Independent(stream) => stream.pair(),
        }
    }
}

impl Even {
    /// Of 24 bits each.
    fn pair(&mut self) -> [f64; 2] {
        let pair = self.held.take().unwrap_or_else(|| {
            // More dimensions than the sequence has are those of another one.
            let (round, set) = (
                self.set / sobol_burley::NUM_DIMENSION_SETS_4D,
                self.set % sobol_burley::NUM_DIMENSION_SETS_4D,
            );
            let [a, b, c, d] =
                sobol_burley::sample_4d(self.index, set, self.scrambling.wrapping_add(round));
            self.set += 1;
            self.held = Some([c, d]);
            [a, b]
        });
        pair.map(f64::from)
    }
}

/// Generators of independent numbers of one seed and purpose.
#[derive(Debug, Clone)]
pub struct Source(ChaCha8Rng);

/// Independent numbers of one of a purpose's things.
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

    /// The numbers of the thing of that number.
    pub fn stream(&self, number: u64) -> Stream {
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
    let mut rng = Source::new(seed, Purpose::Packing).stream(packing as u64).0;
    rng.next_u64() >> 11
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_purposes_have_numbers_of_their_own() {
        let of = |seed, purpose, path| Source::new(seed, purpose).stream(path).pair();
        let first = of(1, Purpose::Result, 0);
        assert_eq!(first, of(1, Purpose::Result, 0));
        for other in
            [of(2, Purpose::Result, 0), of(1, Purpose::Pilot, 0), of(1, Purpose::Result, 1)]
        {
            assert_ne!(first, other);
        }
    }

    #[test]
    fn points_of_a_path_depend_on_seed_purpose_and_number_alone() {
        let of = |seed, purpose, number: u64| {
            let (replicate, mut point) = Points::new(seed, purpose, Sampler::Even)
                .of(number, number + 1)
                .next()
                .expect("one");
            (replicate, (0..300).flat_map(|_| point.pair()).collect::<Vec<f64>>())
        };
        let number = 70_000 * REPLICATES as u64 + 5;
        let (replicate, first) = of(1, Purpose::Result, number);
        assert_eq!(replicate, 5);
        let among =
            Points::new(1, Purpose::Result, Sampler::Even).of(number - 9, number + 9).nth(9);
        let (_, mut among) = among.expect("it is among them");
        assert_eq!(first[..2], among.pair());
        for other in [
            of(2, Purpose::Result, number),
            of(1, Purpose::Pilot, number),
            of(1, Purpose::Result, number + 1),
            of(1, Purpose::Result, number + REPLICATES as u64),
            of(1, Purpose::Result, number - (REPLICATES as u64) * SEQUENCE),
        ] {
            assert_ne!(first, other.1);
        }
        let [deep, shallow] = [&first[512..600], &first[..88]];
        assert_ne!(deep, shallow, "dimensions beyond the sequence's are others");
    }

    /// Of one replicate's first 2^n points each strip of width 2^-n holds one, along either coordinate.
    #[test]
    fn points_of_a_replicate_are_evenly_spread() {
        let paths = 256 * REPLICATES as u64;
        let mut held = [[0; 256]; 4];
        for (replicate, mut point) in Points::new(3, Purpose::Result, Sampler::Even).of(0, paths) {
            if replicate == 7 {
                let all = [point.pair(), point.pair()].concat();
                for (strips, x) in held.iter_mut().zip(all) {
                    strips[(x * 256.0) as usize] += 1;
                }
            }
        }
        assert!(held.iter().flatten().all(|&count| count == 1));
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
        let values: Vec<f64> = (0..n).flat_map(|path| source.stream(path).pair()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        assert!((mean - 0.5).abs() < 0.003, "{mean}");
        assert!((var - 1.0 / 12.0).abs() < 0.001, "{var}");
    }
}
