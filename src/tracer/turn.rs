//! How the patch is turned in a cell of a field.

use glam::DVec3;

/// One of the eight symmetries of a square, about the middle of the patch: x and y may be swapped,
/// and then each may be flipped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Turn {
    pub(super) swapped: bool,
    /// Of the field's axes.
    pub(super) flipped: [bool; 2],
}

impl Turn {
    /// The turn of a cell. In a patch that is not square x and y are not swapped.
    pub(super) fn drawn(seed: u64, cell: [i32; 2], square: bool) -> Self {
        let [x, y] = cell.map(|number| u64::from(number as u32));
        let bits = scrambled(scrambled(seed) ^ (x << 32 | y));
        let bit = |number: u64| bits >> number & 1 == 1;
        Self { swapped: square && bit(0), flipped: [bit(1), bit(2)] }
    }

    /// The axis of the field along an axis of the patch, or the other way round.
    pub(super) fn other(self, axis: usize) -> usize {
        if self.swapped { 1 - axis } else { axis }
    }

    /// A direction of the field in the patch.
    pub(super) fn to_patch(self, direction: DVec3) -> DVec3 {
        let mut turned = direction;
        for axis in 0..2 {
            let over = self.other(axis);
            turned[axis] = if self.flipped[over] { -direction[over] } else { direction[over] };
        }
        turned
    }
}

/// The output function of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): every bit of the result
/// depends on every bit given.
pub(super) fn scrambled(bits: u64) -> u64 {
    let mut z = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_turn_is_drawn_as_often_and_neighbours_turn_on_their_own() {
        for (square, turns) in [(true, 8), (false, 4)] {
            let mut drawn = std::collections::HashMap::new();
            let (mut alike, cells) = ([0, 0], 200);
            for x in 0..cells {
                for y in 0..cells {
                    let turn = Turn::drawn(7, [x, y], square);
                    let key = (turn.swapped, turn.flipped);
                    *drawn.entry(key).or_insert(0) += 1;
                    alike[0] += i32::from(turn == Turn::drawn(7, [x + 1, y], square));
                    alike[1] += i32::from(turn == Turn::drawn(7, [x, y + 1], square));
                }
            }
            assert_eq!(drawn.len(), turns as usize);
            let mean = f64::from(cells * cells / turns);
            for number in drawn.values().chain(&alike) {
                assert!(
                    (f64::from(*number) - mean).abs() < 5.0 * mean.sqrt(),
                    "{drawn:?} {alike:?}"
                );
            }
        }
        let row = |seed| (0..64).map(move |x| Turn::drawn(seed, [x, 0], true));
        assert!(row(1).ne(row(2)), "another seed, another field");
    }
}
