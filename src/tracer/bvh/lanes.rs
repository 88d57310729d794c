//! Eight floats at once: with AVX2 where the machine has it, else as arrays.
//!
//! The two round differently (`mul_sub` is fused or not). No result depends on it: single precision
//! only culls candidates, with room for either.

#![allow(unsafe_code)]

use std::array::from_fn;

/// Eight floats.
pub trait Lanes: Copy {
    fn splat(x: f32) -> Self;
    fn load(x: &[f32; 8]) -> Self;
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    /// self * factor - other.
    fn mul_sub(self, factor: Self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn abs(self) -> Self;
    /// The greater if one of the two is not negative, else any negative number. Faster than `max`.
    fn greater(self, other: Self) -> Self;
    /// The lesser if neither is negative, else any negative number. Faster than `min`.
    fn lesser(self, other: Self) -> Self;
    /// Bit i is set where lane i is at most that of the other.
    fn at_most(self, other: Self) -> u32;
    /// The number of lanes that are at most those of the other. They are written to the front of
    /// `sorted`, the greatest first, with their entries of `with` beside them. None of these lanes
    /// may be negative, and their last three bits are lost.
    fn sort_at_most(self, other: Self, with: &[u32; 8], sorted: Sorted) -> usize;
}

/// Where sorted lanes and their entries are written.
pub type Sorted<'a> = (&'a mut [f32; 8], &'a mut [u32; 8]);

/// Work that can be done with lanes of either kind.
pub trait Work {
    type Output;

    /// Must be inlined, to have the CPU features of its caller.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Does the work with the best lanes that the machine has.
#[inline]
pub fn with_best<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2,fma")]
        fn with_avx2<W: Work>(work: W) -> W::Output {
            work.run::<Avx2>()
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: the machine has both.
            return unsafe { with_avx2(work) };
        }
    }
    work.run::<Portable>()
}

/// Operations on two registers. No closures: they would not be inlined with the CPU features.
macro_rules! lanewise {
    ($($name:ident($a:ident, $b:ident) => $of:expr;)*) => {$(
        #[inline(always)]
        fn $name(self, other: Self) -> Self {
            let ($a, $b) = (self.0, other.0);
            Self($of)
        }
    )*};
}

/// For any machine.
#[derive(Clone, Copy)]
pub struct Portable([f32; 8]);

impl Lanes for Portable {
    lanewise! {
        add(a, b) => from_fn(|i| a[i] + b[i]);
        sub(a, b) => from_fn(|i| a[i] - b[i]);
        mul(a, b) => from_fn(|i| a[i] * b[i]);
        min(a, b) => from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] });
        max(a, b) => from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] });
        greater(a, b) => from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] });
        lesser(a, b) => from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] });
    }
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }
    #[inline(always)]
    fn load(x: &[f32; 8]) -> Self {
        Self(*x)
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, other: Self) -> Self {
        self.mul(factor).sub(other)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        (0..8).map(|i| u32::from(self.0[i] <= other.0[i]) << i).sum()
    }
    #[inline(always)]
    fn sort_at_most(self, other: Self, with: &[u32; 8], (near, beside): Sorted) -> usize {
        let mut count = 0;
        for i in (0..8).filter(|&i| self.0[i] <= other.0[i]) {
            let mut place = count;
            while place > 0 && near[place - 1] < self.0[i] {
                (near[place], beside[place]) = (near[place - 1], beside[place - 1]);
                place -= 1;
            }
            (near[place], beside[place]) = (self.0[i], with[i]);
            count += 1;
        }
        count
    }
}

#[cfg(target_arch = "x86_64")]
use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{
        __m256, __m256i, _CMP_LE_OQ, _mm256_add_ps, _mm256_and_si256, _mm256_andnot_ps,
        _mm256_blend_epi32, _mm256_castps_si256, _mm256_castsi256_ps, _mm256_cmp_ps,
        _mm256_cmpgt_epi32, _mm256_fmsub_ps, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_max_epi32,
        _mm256_max_ps, _mm256_min_epi32, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
        _mm256_or_si256, _mm256_permutevar8x32_epi32, _mm256_set1_epi32, _mm256_set1_ps,
        _mm256_setr_epi32, _mm256_shuffle_epi32, _mm256_storeu_si256, _mm256_sub_ps,
    };

    /// One register.
    ///
    /// SAFETY of all below: only `with_avx2` uses it, and has the features. Loads and stores are of
    /// whole arrays.
    #[derive(Clone, Copy)]
    pub struct Avx2(__m256);

    /// The greater of each pair, or in the lanes of the mask the lesser.
    #[inline(always)]
    fn exchange<const LESSER: i32>(v: __m256i, other: __m256i) -> __m256i {
        unsafe {
            _mm256_blend_epi32::<LESSER>(_mm256_max_epi32(v, other), _mm256_min_epi32(v, other))
        }
    }

    /// An operation on the bits as integers.
    macro_rules! by_bits {
        ($of:ident($a:ident, $b:ident)) => {
            unsafe { _mm256_castsi256_ps($of(_mm256_castps_si256($a), _mm256_castps_si256($b))) }
        };
    }

    impl super::Lanes for Avx2 {
        lanewise! {
            add(a, b) => unsafe { _mm256_add_ps(a, b) };
            sub(a, b) => unsafe { _mm256_sub_ps(a, b) };
            mul(a, b) => unsafe { _mm256_mul_ps(a, b) };
            min(a, b) => unsafe { _mm256_min_ps(a, b) };
            max(a, b) => unsafe { _mm256_max_ps(a, b) };
            greater(a, b) => by_bits!(_mm256_max_epi32(a, b));
            lesser(a, b) => by_bits!(_mm256_min_epi32(a, b));
        }
        #[inline(always)]
        fn splat(x: f32) -> Self {
            Self(unsafe { _mm256_set1_ps(x) })
        }
        #[inline(always)]
        fn load(x: &[f32; 8]) -> Self {
            Self(unsafe { _mm256_loadu_ps(x.as_ptr()) })
        }
        #[inline(always)]
        fn mul_sub(self, factor: Self, other: Self) -> Self {
            Self(unsafe { _mm256_fmsub_ps(self.0, factor.0, other.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }
        #[inline(always)]
        fn at_most(self, other: Self) -> u32 {
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
        }
        #[inline(always)]
        fn sort_at_most(
            self,
            other: Self,
            with: &[u32; 8],
            (near, beside): super::Sorted,
        ) -> usize {
            // The bits of floats that are not negative sort as integers do.
            unsafe {
                let near_bits = _mm256_castps_si256(self.0);
                let beyond = _mm256_cmpgt_epi32(near_bits, _mm256_castps_si256(other.0));
                let left_out = _mm256_movemask_ps(_mm256_castsi256_ps(beyond)).count_ones();
                let numbered = _mm256_or_si256(
                    _mm256_and_si256(near_bits, _mm256_set1_epi32(!7)),
                    _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
                );
                // Those left out are negative, and so the last.
                let v = _mm256_or_si256(numbered, beyond);
                // Batcher's bitonic network.
                let v = exchange::<0b1010_1010>(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v));
                let v = exchange::<0b1100_1100>(v, _mm256_shuffle_epi32::<0b00_01_10_11>(v));
                let v = exchange::<0b1010_1010>(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v));
                let turned =
                    _mm256_permutevar8x32_epi32(v, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
                let v = exchange::<0b1111_0000>(v, turned);
                let v = exchange::<0b1100_1100>(v, _mm256_shuffle_epi32::<0b01_00_11_10>(v));
                let v = exchange::<0b1010_1010>(v, _mm256_shuffle_epi32::<0b10_11_00_01>(v));
                _mm256_storeu_si256(near.as_mut_ptr().cast(), v);
                // Of an index only the last three bits count.
                let with = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(with.as_ptr().cast()), v);
                _mm256_storeu_si256(beside.as_mut_ptr().cast(), with);
                8 - left_out as usize
            }
        }
    }
}
