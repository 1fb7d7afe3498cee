//! A bitmap cut into lines of cells, along rows, columns or slants, and how to turn one into another.

/// One bit a cell, every line starting a word. Its lines run one way; the last bit of each is in a word
/// of its own line, and what is beyond is 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Lines {
    /// Cells a line.
    length: usize,
    /// Words a line: enough for one cell more than there are.
    words: usize,
    bits: Vec<u64>,
}

impl Lines {
    pub(super) fn new(lines: usize, length: usize) -> Self {
        let words = length / 64 + 1;
        Self { length, words, bits: vec![0; lines * words] }
    }

    pub(super) const fn count(&self) -> usize {
        self.bits.len() / self.words
    }

    pub(super) const fn length(&self) -> usize {
        self.length
    }

    /// What is set in either.
    pub(super) fn joined(&self, other: &Self) -> Self {
        let bits = self.bits.iter().zip(&other.bits).map(|(one, other)| one | other).collect();
        Self { bits, ..*self }
    }

    /// What is not set, and whatever in the bits beyond the ends.
    pub(super) fn inverted(mut self) -> Self {
        self.bits.iter_mut().for_each(|word| *word = !*word);
        self
    }

    pub(super) fn words(&self) -> &[u64] {
        &self.bits
    }

    pub(super) fn line(&self, line: usize) -> &[u64] {
        &self.bits[line * self.words..(line + 1) * self.words]
    }

    pub(super) fn line_mut(&mut self, line: usize) -> &mut [u64] {
        &mut self.bits[line * self.words..(line + 1) * self.words]
    }

    #[cfg(test)]
    pub(super) fn bit(&self, line: usize, at: usize) -> bool {
        self.line(line)[at / 64] >> (at % 64) & 1 != 0
    }

    /// The lines crossing these: cell `x` of line `y` becomes cell `y` of line `x - y * slant`, counted
    /// around. Slant 0 makes columns of rows, 1 and -1 the two kinds of diagonals, 2 and -2 those of knight's
    /// moves. A line that leaves at one side goes on at the other.
    pub(super) fn crossing(&self, slant: isize) -> Self {
        let mut crossing = Self::new(self.length, self.count());
        for block in 0..self.count().div_ceil(64) {
            for first in (0..self.length).step_by(64) {
                let mut square = [0; 64];
                for (y, word) in (block * 64..self.count()).zip(&mut square) {
                    let x = (first as isize + slant * y as isize).rem_euclid(self.length as isize);
                    *word = self.around(y, x as usize);
                }
                transpose(&mut square);
                for (line, word) in (first..self.length).zip(square) {
                    crossing.bits[line * crossing.words + block] = word;
                }
            }
        }
        crossing
    }

    /// The inverse of [`Self::crossing`].
    pub(super) fn uncrossed(&self, slant: isize) -> Self {
        let sheared = self.crossing(0);
        let mut uncrossed = Self::new(self.length, self.count());
        let length = uncrossed.length;
        for y in 0..self.length {
            for (index, word) in uncrossed.line_mut(y).iter_mut().enumerate() {
                let first = index * 64;
                let at = (first as isize - slant * y as isize).rem_euclid(length as isize);
                let kept = length.saturating_sub(first).min(64) as u32;
                // What is beyond the end is the start again.
                *word = sheared.around(y, at as usize) & u64::MAX.checked_shr(64 - kept).unwrap_or(0);
            }
        }
        uncrossed
    }

    /// Every line moved up by one place.
    pub(super) fn later(&self) -> Self {
        let mut later = Self::new(self.count(), self.length);
        (0..self.count()).for_each(|line| shift_up(self.line(line), later.line_mut(line)));
        later
    }

    /// 64 cells of a line from `at` on, and from its start again after its end.
    fn around(&self, line: usize, at: usize) -> u64 {
        let line = self.line(line);
        let low = line[at / 64] >> (at % 64);
        let high = line.get(at / 64 + 1).map_or(0, |high| high << 1 << (63 - at % 64));
        let mut window = low | high;
        let mut filled = self.length - at;
        while filled < 64 {
            window |= line[0] << filled;
            filled += self.length;
        }
        window
    }
}

/// Moves a line up by one place.
pub(super) fn shift_up(line: &[u64], to: &mut [u64]) {
    let mut carry = 0;
    for (to, from) in to.iter_mut().zip(line.iter().copied().chain([0])) {
        *to = from << 1 | carry;
        carry = from >> 63;
    }
}

/// Mirrors a square of 64 x 64 bits at its diagonal, by halves, quarters and so on.
fn transpose(square: &mut [u64; 64]) {
    let mut half = 32;
    let mut mask = u64::MAX >> 32;
    while half > 0 {
        let mut row = 0;
        while row < 64 {
            let swap = (square[row] >> half ^ square[row + half]) & mask;
            square[row + half] ^= swap;
            square[row] ^= swap << half;
            row = (row + half + 1) & !half;
        }
        half /= 2;
        mask ^= mask << half;
    }
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;

    use super::*;

    prop_compose! {
        pub(in super::super) fn lines()(count in 1usize..140, length in 1usize..140)(
            count in Just(count), length in Just(length),
            set in prop::collection::vec((0..count, 0..length), 1..60),
        ) -> Lines {
            let mut lines = Lines::new(count, length);
            set.iter().for_each(|&(line, at)| lines.line_mut(line)[at / 64] |= 1 << (at % 64));
            lines
        }
    }

    proptest! {
        #[test]
        fn crossing_lines_hold_the_same_cells(lines in lines(), slant in -2isize..3) {
            let crossing = lines.crossing(slant);
            prop_assert_eq!((crossing.count(), crossing.length), (lines.length, lines.count()));
            for (y, x) in (0..lines.count()).flat_map(|y| (0..lines.length).map(move |x| (y, x))) {
                let line = (x as isize - slant * y as isize).rem_euclid(lines.length as isize);
                prop_assert_eq!(crossing.bit(line as usize, y), lines.bit(y, x));
            }
            prop_assert_eq!(crossing.uncrossed(slant), lines);
        }
    }
}
