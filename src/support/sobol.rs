//! Sobol' points of four dimensions with Owen scrambling.

use sobol_burley::parts::{Int4, hash, hash_int4, owen_scramble_int4_rev, owen_scramble_rev};

/// Points of a sequence. Beyond them a net continues with another scrambling.
pub(super) const SEQUENCE: u64 = 1 << SEQUENCE_BITS;

const SEQUENCE_BITS: usize = 24;

/// A place in a scrambled sequence.
#[derive(Debug, Clone)]
pub struct Even {
    pub(super) index: u32,
    pub(super) scrambling: u32,
    pub(super) set: u32,
    /// The second pair of a set of four.
    pub(super) held: Option<[f32; 2]>,
}

impl Even {
    /// The next two coordinates, of 23 bits each.
    pub(super) fn pair(&mut self) -> [f64; 2] {
        let pair = self.held.take().unwrap_or_else(|| {
            // Each set of four dimensions is the same sequence, scrambled and shuffled anew.
            let scrambling = hash(self.scrambling.wrapping_add(self.set));
            let [a, b, c, d] = scrambled_sobol(self.index, scrambling);
            self.set += 1;
            self.held = Some([c, d]);
            [a, b]
        });
        pair.map(f64::from)
    }
}

/// A point of the four-dimensional Sobol' sequence, shuffled, each dimension Owen-scrambled. The
/// functions of [`sobol_burley`] do the same for only 2^16 points.
fn scrambled_sobol(index: u32, scrambling: u32) -> [f32; 4] {
    const SALTS: [u32; 4] = [0x68bc_21eb, 0x02e5_be93, 0x967a_889b, 0xb529_7a4d];
    let shuffled = owen_scramble_rev(index.reverse_bits(), hash(scrambling)).reverse_bits();
    let mut rest = shuffled % SEQUENCE as u32;
    let mut reversed = [0; 4];
    while rest != 0 {
        let bit = rest.trailing_zeros() as usize;
        for (sum, direction) in reversed.iter_mut().zip(DIRECTIONS[bit]) {
            *sum ^= direction;
        }
        rest &= rest - 1;
    }
    let scramblings = hash_int4(Int4::from(SALTS.map(|salt| scrambling ^ salt)));
    owen_scramble_int4_rev(reversed.into(), scramblings).reverse_bits().to_f32_norm()
}

/// Direction numbers of the first four dimensions, bits reversed. Primitive polynomials and first
/// numbers: Joe and Kuo, SIAM J. Sci. Comput. 30, 2635-2654 (2008). The first two dimensions are a
/// (0, 2)-sequence.
const DIRECTIONS: [[u32; 4]; SEQUENCE_BITS] = {
    // For each dimension the degree, the inner coefficients, and the first numbers.
    let polynomials: [(usize, u32, [u32; 3]); 3] =
        [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];
    let mut directions = [[0; 4]; SEQUENCE_BITS];
    let mut i = 0;
    while i < SEQUENCE_BITS {
        directions[i][0] = 1_u32 << i;
        let mut dimension = 1;
        while dimension < 4 {
            let (degree, inner, first) = polynomials[dimension - 1];
            directions[i][dimension] = if i < degree {
                (first[i] << (31 - i)).reverse_bits()
            } else {
                let before = directions[i - degree][dimension];
                let mut number = before ^ (before << degree);
                let mut k = 1;
                while k < degree {
                    if inner >> (degree - 1 - k) & 1 == 1 {
                        number ^= directions[i - k][dimension];
                    }
                    k += 1;
                }
                number
            };
            dimension += 1;
        }
        i += 1;
    }
    directions
};
