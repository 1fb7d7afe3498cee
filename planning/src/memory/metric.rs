//! How the distances of a move set are written down: as counts of moves that can be added, compared and
//! read back exactly.

use std::fmt::Debug;

use bytemuck::Pod;

use crate::{
    moves::{Length, MoveSet, Step},
    search::neighbours::Moves,
};

/// The distances of a move set.
pub(super) trait Metric: Copy + Debug {
    /// A distance as it is stored.
    type Distance: Pod + Eq + Debug + Send + Sync;
    /// Distances order by their keys.
    type Key: Ord + Copy;

    /// The move set.
    const MOVES: MoveSet;
    /// The distance from a target to itself.
    const HERE: Self::Distance;
    /// The distance where no way is known. It is longer than all others.
    const FAR: Self::Distance;
    /// No way is longer than this.
    const LIMIT: Self::Key;
    /// Bits that a move's number takes in a byte of the run table; the others count its repeats.
    const NUMBER_BITS: u32;

    fn key(distance: Self::Distance) -> Self::Key;

    /// The distance one move further.
    fn plus(distance: Self::Distance, number: usize) -> Self::Distance;

    /// The counts of moves.
    fn length(distance: Self::Distance) -> Length;

    /// The length in cells.
    fn cells(distance: Self::Distance) -> f64;

    /// The moves a search from a target has to try at a cell that was reached by `arrivals`, all of them
    /// equally short (none at the target itself), of those that are `allowed` there.
    fn successors(arrivals: Moves, allowed: Moves) -> Moves;
}

/// Straight moves of length 1 and diagonal ones of length sqrt 2.
///
/// A distance is one integer, [`STRAIGHT`] for each straight move and [`DIAGONAL`] for each diagonal one.
/// The two are a convergent of sqrt 2: below [`STRAIGHT`] moves of each kind no sum of one orders or
/// equals another but as the real lengths do, and the remainder by [`STRAIGHT`] tells the diagonal moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octile;

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

impl Metric for Octile {
    type Distance = u32;
    type Key = u32;

    const MOVES: MoveSet = MoveSet::Eight;
    const HERE: u32 = 0;
    const FAR: u32 = u32::MAX;
    /// 53,165 cells; one more move still fits.
    const LIMIT: u32 = u32::MAX - 1 - DIAGONAL;
    const NUMBER_BITS: u32 = 3;

    #[inline]
    fn key(distance: u32) -> u32 {
        distance
    }

    #[inline]
    fn plus(distance: u32, number: usize) -> u32 {
        distance.wrapping_add(if number < 4 { STRAIGHT } else { DIAGONAL })
    }

    #[inline]
    fn length(distance: u32) -> Length {
        let diagonal = (u64::from(distance % STRAIGHT) * INVERSE % u64::from(STRAIGHT)) as u32;
        Length { straight: (distance - diagonal * DIAGONAL) / STRAIGHT, diagonal, knight: 0 }
    }

    #[inline]
    fn cells(distance: u32) -> f64 {
        f64::from(distance) * (1.0 / STRAIGHT as f64)
    }

    /// Jump point search's pruning: of equally short ways the one whose diagonals come first is enough.
    #[inline]
    fn successors(arrivals: Moves, allowed: Moves) -> Moves {
        if arrivals == 0 {
            return allowed;
        }
        let mut successors = 0;
        let mut rest = arrivals;
        while rest != 0 {
            let arrival = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            successors |= SUCCESSORS[arrival & 7][(allowed & 255) as usize];
        }
        successors.into()
    }
}

/// For each arrival and each set of allowed moves the successors.
static SUCCESSORS: [[u8; 256]; 8] = {
    let steps = MoveSet::Eight.steps();
    let mut table = [[0; 256]; 8];
    let mut arrival = 0;
    while arrival < 8 {
        let mut allowed = 0;
        while allowed < 256 {
            table[arrival][allowed] = natural(steps[arrival], allowed as u8) & allowed as u8;
            allowed += 1;
        }
        arrival += 1;
    }
    table
};

/// The moves after `arrival` to cells that the cell before does not reach as well another way.
const fn natural((dx, dy): Step, allowed: u8) -> u8 {
    if dx != 0 && dy != 0 {
        return bit((dx, 0)) | bit((0, dy)) | bit((dx, dy));
    }
    let mut moves = bit((dx, dy));
    let mut side = -1;
    while side <= 1 {
        // Where the cell beside the cell before is free, that one leads to this side.
        let (x, y) = (dy * side, dx * side);
        if allowed & bit((x - dx, y - dy)) == 0 {
            moves |= bit((x, y)) | bit((x + dx, y + dy));
        }
        side += 2;
    }
    moves
}

const fn bit(step: Step) -> u8 {
    let steps = MoveSet::Eight.steps();
    let mut number = 0;
    while steps[number].0 != step.0 || steps[number].1 != step.1 {
        number += 1;
    }
    1 << number
}

/// Straight, diagonal and knight's moves of length sqrt 5, each counted by 21 bits of a distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knight;

const COUNT_BITS: u32 = 21;
const COUNT: u64 = (1 << COUNT_BITS) - 1;

impl Metric for Knight {
    type Distance = u64;
    /// As [`Length`] orders.
    type Key = (u64, u64);

    const MOVES: MoveSet = MoveSet::Sixteen;
    const HERE: u64 = 0;
    const FAR: u64 = u64::MAX;
    /// A million cells.
    const LIMIT: (u64, u64) = (1 << 52, 0);
    const NUMBER_BITS: u32 = 4;

    #[inline]
    fn key(distance: u64) -> (u64, u64) {
        (Self::length(distance).cost(), distance)
    }

    #[inline]
    fn plus(distance: u64, number: usize) -> u64 {
        let kind = u32::from(number >= 4) + u32::from(number >= 8);
        distance.wrapping_add(1 << (kind * COUNT_BITS))
    }

    #[inline]
    fn length(distance: u64) -> Length {
        let count = |kind: u32| (distance >> (kind * COUNT_BITS) & COUNT) as u32;
        Length { straight: count(0), diagonal: count(1), knight: count(2) }
    }

    #[inline]
    fn cells(distance: u64) -> f64 {
        Self::length(distance).units()
    }

    #[inline]
    fn successors(_: Moves, allowed: Moves) -> Moves {
        allowed
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
            one in (0u32..9000, 0u32..9000, 0u32..900), other in (0u32..9000, 0u32..9000, 0u32..900),
        ) {
            let length = |(straight, diagonal, knight)| Length { straight, diagonal, knight };
            for (one, other) in [(one, other), ((one.0, one.1, 0), (other.0, other.1, 0))] {
                let [a, b] = [one, other].map(|(s, d, k)| of::<Knight>([s, d, k]));
                prop_assert_eq!(Knight::length(a), length(one));
                prop_assert_eq!(Knight::key(a).0.cmp(&Knight::key(b).0), length(one).cost().cmp(&length(other).cost()));
            }
            let [one, other] = [one, other].map(|(s, d, _)| (s, d, 0));
            let [a, b] = [one, other].map(|(s, d, _)| of::<Octile>([s, d, 0]));
            prop_assert_eq!(Octile::length(a), length(one));
            prop_assert_eq!(a.cmp(&b), length(one).cmp(&length(other)));
            prop_assert!((Octile::cells(a) - length(one).units()).abs() < 1e-4);
        }
    }

    #[test]
    fn the_longest_distance_is_still_exact() {
        let diagonal = Octile::LIMIT / DIAGONAL;
        for diagonal in [0, 1, diagonal - 1, diagonal] {
            let straight = (Octile::LIMIT - diagonal * DIAGONAL) / STRAIGHT;
            let distance = straight * STRAIGHT + diagonal * DIAGONAL;
            assert_eq!(Octile::length(distance), Length { straight, diagonal, knight: 0 });
        }
    }
}
