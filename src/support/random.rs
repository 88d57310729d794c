//! Random numbers that depend only on a seed and a path's number. Any thread, on any machine, may
//! trace any path with the same result.
//!
//! Paths use two low-discrepancy sequences ("nets"), which cover the space of paths more evenly
//! than independent numbers. The error of one net cannot be seen from its own points. The nets are
//! scrambled independently, so the error follows from the differences between them; [`group_of`]
//! says which paths are compared. Everything else uses independent numbers.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::sobol::{Even, SEQUENCE};

/// Nets that share the paths of a trace.
pub const NETS: u64 = 2;

/// Parts of the view in which the two nets are compared. The cells of a part are spread over all
/// of the view.
const TWINS: u16 = 16;

/// Groups of paths that are counted separately: those of one net that begin in one part of the
/// view. Groups 2 n and 2 n + 1 are twins: the same part, the two nets.
pub const GROUPS: usize = TWINS as usize * NETS as usize;

/// Cells along each side of a view. Each [`LOT`] of paths has one path of each net in every cell.
pub(crate) const CELLS_OF_VIEW: u16 = 16;

/// Paths that fill the cells of a view once.
pub(crate) const LOT: u64 = CELLS_OF_VIEW as u64 * CELLS_OF_VIEW as u64 * NETS;

/// The group of a path. `place` is where it begins, 0 to 1 from the left and from below, in a view
/// with `cells` cells along each side.
///
/// Each block of 4 x 4 cells has every group of a net once, and so has each row and column of 16.
/// So all groups see the same of any view.
pub(crate) fn group_of(net: u16, place: [f64; 2], cells: u16) -> u16 {
    let [x, y] = place.map(|at| (at * f64::from(cells)) as u16);
    let (within, turn) = (x % 4 + 4 * (y % 4), 4 * (x / 4) + y / 4);
    (within + turn) % TWINS * NETS as u16 + net
}

/// What the numbers are for. Different purposes never share numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// The paths of the result.
    Result = 0,
    /// Pilot paths, which tell how many paths are needed.
    Pilot = 1,
    /// Seeds of packings.
    Packing = 2,
    /// The visible share of each prototype.
    Coverage = 3,
    /// The paths of an image's pixels.
    Image = 4,
    /// Pilot paths of an image, which tell how many paths a pixel needs.
    ImagePilot = 5,
    /// Noise of the sensor.
    SensorNoise = 6,
    /// The order in which fines are taken away.
    Thinning = 7,
    /// Draws from a posterior.
    Posterior = 8,
    /// Points of a study.
    Study = 9,
}

/// The source of a path's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// A low-discrepancy sequence.
    Even,
    /// Independent numbers, for comparison with the sequence.
    Independent,
}

/// Paths that share one scrambling of each net. A pixel has at most so many; the paths of pixel n
/// begin at number n times this.
pub(crate) const STRETCH: u64 = SEQUENCE * NETS;

/// The points of all paths of one seed and purpose: for each net a Sobol' sequence with hash-based
/// Owen scrambling (Burley, J. Comput. Graph. Tech. 9(4), 2020).
#[derive(Debug, Clone)]
pub struct Points {
    source: Source,
    sampler: Sampler,
}

/// The coordinates of one path: two for its start and two for each bounce.
#[derive(Debug, Clone)]
pub enum Point {
    /// Coordinates from a sequence.
    Even(Even),
    /// Independent numbers.
    Independent(Box<Stream>),
}

impl Points {
    /// The points of a seed.
    pub fn new(seed: u64, purpose: Purpose, sampler: Sampler) -> Self {
        Self { source: Source::new(seed, purpose), sampler }
    }

    /// The scrambling of each net in one stretch of paths.
    fn scramblings(&self, stretch: u64) -> [u32; NETS as usize] {
        let mut rng = self.source.stream(stretch).0;
        std::array::from_fn(|_| rng.next_u32())
    }

    /// The points of the paths `first..end`, each with its net.
    pub fn of(&self, first: u64, end: u64) -> impl Iterator<Item = (u16, Point)> {
        let mut stretch = u64::MAX;
        let mut scramblings = [0; NETS as usize];
        (first..end).map(move |number| {
            let net = (number % NETS) as u16;
            if self.sampler == Sampler::Independent {
                return (net, Point::Independent(Box::new(self.source.stream(number))));
            }
            let index = number / NETS;
            if index / SEQUENCE != stretch {
                stretch = index / SEQUENCE;
                scramblings = self.scramblings(stretch);
            }
            let index = (index % SEQUENCE) as u32;
            let scrambling = scramblings[usize::from(net)];
            (net, Point::Even(Even { index, scrambling, set: 0, held: None }))
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

/// Generators of independent numbers for one seed and purpose.
#[derive(Debug, Clone)]
pub struct Source(ChaCha8Rng);

/// Independent numbers of one item: a path, a packing.
#[derive(Debug, Clone)]
pub struct Stream(ChaCha8Rng);

impl Source {
    /// The generators of a seed.
    pub fn new(seed: u64, purpose: Purpose) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&(purpose as u64).to_le_bytes());
        Self(ChaCha8Rng::from_seed(key))
    }

    /// The numbers of one item.
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

/// The seed of one of several packings, or of its rays. The first keeps the seed itself. The others
/// get their own, below 2^53 so that any JSON reader keeps them exactly.
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
            let (net, mut point) = Points::new(seed, purpose, Sampler::Even)
                .of(number, number + 1)
                .next()
                .expect("one");
            (net, (0..300).flat_map(|_| point.pair()).collect::<Vec<f64>>())
        };
        let number = SEQUENCE * NETS + 7;
        let (net, first) = of(1, Purpose::Result, number);
        assert_eq!(net, 1);
        let among =
            Points::new(1, Purpose::Result, Sampler::Even).of(number - 9, number + 9).nth(9);
        let (_, mut among) = among.expect("it is among them");
        assert_eq!(first[..2], among.pair());
        for other in [
            of(2, Purpose::Result, number),
            of(1, Purpose::Pilot, number),
            of(1, Purpose::Result, number + 1),
            of(1, Purpose::Result, number + NETS),
            of(1, Purpose::Result, number - NETS * SEQUENCE),
        ] {
            assert_ne!(first, other.1);
        }
        let [deep, shallow] = [&first[512..600], &first[..88]];
        assert_ne!(deep, shallow, "each set of dimensions is scrambled anew");
    }

    /// Points of one net, from any multiple of their number on.
    fn points(net: u16, first: u64, number: u64) -> Vec<[f64; 4]> {
        Points::new(3, Purpose::Result, Sampler::Even)
            .of(NETS * first, NETS * (first + number))
            .filter(|(of, _)| *of == net)
            .map(|(_, mut point)| {
                let ([a, b], [c, d]) = (point.pair(), point.pair());
                [a, b, c, d]
            })
            .collect()
    }

    /// Take 2^n points of a net, beginning at a multiple of 2^n. Each strip of width 2^-n along a
    /// coordinate holds one. So does each rectangle of that area in the first two coordinates.
    #[test]
    fn points_of_a_net_are_evenly_spread() {
        let bits = 17;
        for first in [0, 3 << bits] {
            let points = points(1, first, 1 << bits);
            for (axis, shape) in
                (0..4).map(|axis| (axis, bits)).chain((0..bits).map(|shape| (4, shape)))
            {
                let mut held = vec![0_u8; 1 << bits];
                for point in &points {
                    let strip = |at: f64, bits: u32| (at * f64::from(1 << bits)) as usize;
                    let place = if axis < 4 {
                        strip(point[axis], bits)
                    } else {
                        strip(point[0], shape) << (bits - shape) | strip(point[1], bits - shape)
                    };
                    held[place] += 1;
                }
                assert!(held.iter().all(|&count| count == 1), "{axis} {shape}");
            }
        }
    }

    #[test]
    fn a_lot_has_as_many_paths_in_each_group() {
        for (lot, cells) in [(LOT, CELLS_OF_VIEW), (LOT / 16, 4)] {
            let mut held = [0; GROUPS];
            for first in [0, 5 * lot] {
                let points = Points::new(4, Purpose::Pilot, Sampler::Even);
                for (net, mut point) in points.of(first, first + lot) {
                    held[usize::from(group_of(net, point.pair(), cells))] += 1;
                }
            }
            assert!(held.iter().all(|&count| count == 2 * lot / GROUPS as u64));
        }
    }

    /// Otherwise groups would differ where the view shows furrows.
    #[test]
    fn every_row_and_column_has_all_groups() {
        for fixed in 0..16 {
            for along in [0, 1] {
                let groups: std::collections::BTreeSet<u16> = (0..16)
                    .map(|i| {
                        let mut place = [(f64::from(fixed) + 0.5) / 16.0; 2];
                        place[along] = (f64::from(i) + 0.5) / 16.0;
                        group_of(0, place, 16)
                    })
                    .collect();
                assert_eq!(groups.len(), GROUPS / 2, "{fixed} {along}");
            }
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
        let values: Vec<f64> = (0..n).flat_map(|path| source.stream(path).pair()).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let var = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        assert!((mean - 0.5).abs() < 0.003, "{mean}");
        assert!((var - 1.0 / 12.0).abs() < 0.001, "{var}");
    }
}
