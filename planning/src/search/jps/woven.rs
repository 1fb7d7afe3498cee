//! Bitmaps of the same lines side by side, and how to look along them.
//!
//! A jump asks of the same cells where it ends and what is there, so the answers share a cache line.

use super::lines::Lines;

/// Some bitmaps, by number, word by word.
#[derive(Clone, Debug)]
pub(super) struct Woven<const BITMAPS: usize> {
    /// Words a line, of each bitmap.
    words: usize,
    bits: Vec<[u64; BITMAPS]>,
}

impl<const BITMAPS: usize> Woven<BITMAPS> {
    pub(super) fn of(bitmaps: [&Lines; BITMAPS]) -> Self {
        let words = bitmaps.map(Lines::words);
        let bits = (0..words[0].len()).map(|index| words.map(|words| words[index]));
        Self { words: bitmaps[0].line(0).len(), bits: bits.collect() }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.bits.as_slice())
    }

    #[inline]
    pub(super) fn bit(&self, of: usize, line: usize, at: usize) -> bool {
        self.bits[line * self.words + at / 64][of] >> (at % 64) & 1 != 0
    }

    /// The first bit that is set from `at` on; there must be one.
    #[inline]
    pub(super) fn next(&self, of: usize, line: usize, at: usize) -> usize {
        let line = line * self.words;
        let mut index = at / 64;
        let mut word = self.bits[line + index][of] & (u64::MAX << (at % 64));
        while word == 0 {
            index += 1;
            word = self.bits[line + index][of];
        }
        index * 64 + word.trailing_zeros() as usize
    }

    /// The last bit that is set up to `at`; there must be one.
    #[inline]
    pub(super) fn previous(&self, of: usize, line: usize, at: usize) -> usize {
        let line = line * self.words;
        let mut index = at / 64;
        let mut word = self.bits[line + index][of] & (u64::MAX >> (63 - at % 64));
        while word == 0 {
            index -= 1;
            word = self.bits[line + index][of];
        }
        index * 64 + 63 - word.leading_zeros() as usize
    }

    /// The bits that are set from `first` to `last`, by rising places.
    #[inline]
    pub(super) fn for_each(
        &self,
        of: usize,
        line: usize,
        first: usize,
        last: usize,
        mut found: impl FnMut(usize),
    ) {
        let line = line * self.words;
        let mut first_mask = u64::MAX << (first % 64);
        for index in first / 64..=last / 64 {
            let mut word = self.bits[line + index][of] & first_mask;
            if index == last / 64 {
                word &= u64::MAX >> (63 - last % 64);
            }
            while word != 0 {
                found(index * 64 + word.trailing_zeros() as usize);
                word &= word - 1;
            }
            first_mask = u64::MAX;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{super::lines::tests::lines, *};

    proptest! {
        #[test]
        fn what_is_set_is_found(lines in lines(), line in any::<prop::sample::Index>(), ends in any::<[prop::sample::Index; 2]>()) {
            let line = line.index(lines.count());
            let empty = Lines::new(lines.count(), lines.length());
            let woven = Woven::of([&empty, &lines, &empty]);
            let mut ends = ends.map(|end| end.index(lines.length()));
            ends.sort_unstable();
            let [first, last] = ends;
            let set: Vec<_> = (first..=last).filter(|&at| woven.bit(1, line, at)).collect();
            let mut found = Vec::new();
            woven.for_each(1, line, first, last, |at| found.push(at));
            prop_assert_eq!(found, set.clone());
            if let (Some(&next), Some(&previous)) = (set.first(), set.last()) {
                prop_assert_eq!((woven.next(1, line, first), woven.previous(1, line, last)), (next, previous));
            }
        }
    }
}
