//! How the distances of a move set are written down: as counts of moves that can be added, compared and
//! read back exactly.

use std::fmt::Debug;

use bytemuck::Pod;

use crate::moves::{Length, MoveSet};

/// The distances of a move set.
///
/// A distance is one integer, a sum of its moves' costs, which orders as the real lengths do and tells how
/// many moves of each kind it is made of. It is signed, because processors compare signed numbers side by
/// side.
pub(crate) trait Metric: Copy + Debug {
    /// A distance as it is stored.
    type Distance: Pod + Ord + Debug + Send + Sync;

    /// The move set.
    const MOVES: MoveSet;
    /// The distance from a target to itself.
    const HERE: Self::Distance;
    /// The distance where no way is known. No way is as long; one move more still fits.
    const FAR: Self::Distance;
    /// Bits that a move's number takes in a byte of the run table; the others count its repeats.
    const NUMBER_BITS: u32;

    /// The distance one move further, where no way is known too.
    fn plus(distance: Self::Distance, number: usize) -> Self::Distance;

    /// The counts of moves.
    fn length(distance: Self::Distance) -> Length;

    /// The length in cells.
    fn cells(distance: Self::Distance) -> f64;
}

/// Straight moves of length 1 and diagonal ones of length sqrt 2.
///
/// [`STRAIGHT`] for each straight move and [`DIAGONAL`] for each diagonal one, a convergent of sqrt 2: below
/// [`STRAIGHT`] moves of each kind no sum of one orders or equals another but as the real lengths do, and the
/// remainder by [`STRAIGHT`] tells the diagonal moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Octile;

const STRAIGHT: u32 = 80_782;
const DIAGONAL: u32 = 114_243;
/// [`DIAGONAL`] times this is 1 modulo [`STRAIGHT`].
const INVERSE: u64 = inverse(DIAGONAL % STRAIGHT, STRAIGHT);

const fn inverse(of: u32, modulus: u32) -> u64 {
    let mut candidate = 1;
    while of as u64 * candidate % modulus as u64 != 1 {
        candidate += 1;
    }
    candidate
}

impl Octile {
    #[inline]
    const fn units(distance: i32) -> u32 {
        distance.wrapping_sub(Self::HERE) as u32
    }
}

impl Metric for Octile {
    type Distance = i32;

    const MOVES: MoveSet = MoveSet::Eight;
    const HERE: i32 = i32::MIN;
    /// 53,165 cells.
    const FAR: i32 = i32::MAX - DIAGONAL as i32;
    const NUMBER_BITS: u32 = 3;

    #[inline]
    fn plus(distance: i32, number: usize) -> i32 {
        distance.wrapping_add(if number < 4 { STRAIGHT } else { DIAGONAL } as i32)
    }

    #[inline]
    fn length(distance: i32) -> Length {
        let units = Self::units(distance);
        let diagonal = (u64::from(units % STRAIGHT) * INVERSE % u64::from(STRAIGHT)) as u32;
        Length { straight: (units - diagonal * DIAGONAL) / STRAIGHT, diagonal, knight: 0 }
    }

    #[inline]
    fn cells(distance: i32) -> f64 {
        f64::from(Self::units(distance)) * (1.0 / STRAIGHT as f64)
    }
}

/// Straight, diagonal and knight's moves of length sqrt 5.
///
/// The high 48 bits are the length's cost, by which lengths order; the low 16 count the diagonal moves. A
/// knight's move's cost is odd, so that the rest of the cost modulo a straight move's, a power of two, tells
/// the knight's moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Knight;

const DIAGONAL_BITS: u32 = 16;
const DIAGONAL_COST: u64 = Length::of((1, 1)).cost();
const KNIGHT_COST: u64 = Length::of((2, 1)).cost();
/// [`KNIGHT_COST`] times this is 1 modulo 2^32: Newton's iteration doubles the bits that are right.
const KNIGHT_INVERSE: u32 = {
    let of = KNIGHT_COST as u32;
    let mut inverse = of;
    let mut right = 3;
    while right < 32 {
        inverse = inverse.wrapping_mul(2u32.wrapping_sub(of.wrapping_mul(inverse)));
        right *= 2;
    }
    inverse
};

impl Metric for Knight {
    type Distance = i64;

    const MOVES: MoveSet = MoveSet::Sixteen;
    const HERE: i64 = i64::MIN;
    /// 65,533 cells.
    const FAR: i64 = i64::MAX - ((KNIGHT_COST as i64) << DIAGONAL_BITS);
    const NUMBER_BITS: u32 = 4;

    #[inline]
    fn plus(distance: i64, number: usize) -> i64 {
        let move_units = match number {
            0..4 => 1 << (32 + DIAGONAL_BITS),
            4..8 => (DIAGONAL_COST as i64) << DIAGONAL_BITS | 1,
            _ => (KNIGHT_COST as i64) << DIAGONAL_BITS,
        };
        distance.wrapping_add(move_units)
    }

    #[inline]
    fn length(distance: i64) -> Length {
        let units = distance.wrapping_sub(Self::HERE) as u64;
        let diagonal = (units & ((1 << DIAGONAL_BITS) - 1)) as u32;
        let rest = (units >> DIAGONAL_BITS) - u64::from(diagonal) * DIAGONAL_COST;
        let knight = (rest as u32).wrapping_mul(KNIGHT_INVERSE);
        let straight = ((rest - u64::from(knight) * KNIGHT_COST) >> 32) as u32;
        Length { straight, diagonal, knight }
    }

    #[inline]
    fn cells(distance: i64) -> f64 {
        Self::length(distance).units()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A distance of so many moves.
    fn of<M: Metric>(counts: [u32; 3]) -> M::Distance {
        let numbers =
            [0, 4, 8].into_iter().zip(counts).flat_map(|(number, count)| (0..count).map(move |_| number));
        numbers.fold(M::HERE, M::plus)
    }

    proptest! {
        #[test]
        fn distances_are_exact_counts_and_order_as_lengths(
            one in (0u32..9000, 0u32..9000, 0u32..9000), other in (0u32..9000, 0u32..9000, 0u32..9000),
        ) {
            let length = |(straight, diagonal, knight)| Length { straight, diagonal, knight };
            let [a, b] = [one, other].map(|(s, d, k)| of::<Knight>([s, d, k]));
            prop_assert_eq!(Knight::length(a), length(one));
            if length(one).cost() != length(other).cost() {
                prop_assert_eq!(a.cmp(&b), length(one).cmp(&length(other)));
            }
            let [one, other] = [one, other].map(|(s, d, _)| (s, d, 0));
            let [a, b] = [one, other].map(|(s, d, _)| of::<Octile>([s, d, 0]));
            prop_assert_eq!(Octile::length(a), length(one));
            prop_assert_eq!(a.cmp(&b), length(one).cmp(&length(other)));
            prop_assert!((Octile::cells(a) - length(one).units()).abs() < 1e-4);
        }
    }

    #[test]
    fn the_longest_distances_are_still_exact_and_nothing_is_farther_than_far() {
        longest::<Octile>([(80_782, 1), (114_243, 4)]);
        longest::<Knight>([(1 << 48, 1), (9_603_838_835 << 16, 8)]);
        longest::<Knight>([(1 << 48, 1), (6_074_001_000 << 16 | 1, 4)]);
    }

    /// Ways of nearly only straight moves up to nearly only the others.
    fn longest<M: Metric<Distance: Into<i128>>>([(straight, _), (other, number)]: [(i128, usize); 2]) {
        let room = M::FAR.into() - M::HERE.into() - 1;
        for others in [0, 1, 2, room / other - 1, room / other] {
            let straights = (room - others * other) / straight;
            let counts = [
                straights as u32,
                if number == 4 { others as u32 } else { 0 },
                if number == 8 { others as u32 } else { 0 },
            ];
            let distance = of::<M>(counts);
            assert!(distance < M::FAR);
            let [straight, diagonal, knight] = counts;
            assert_eq!(M::length(distance), Length { straight, diagonal, knight });
        }
        assert!((0..M::MOVES.steps().len()).all(|number| M::plus(M::FAR, number) > M::FAR));
    }
}
