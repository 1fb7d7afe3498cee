//! Lines of cells that are scanned for where they stop, 64 cells at once.

/// Lines of bits, 1 where a scan stops, with a margin of ones all around.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    words: usize,
    bits: Vec<u64>,
}

impl Lines {
    pub(super) fn stopped(length: usize, lines: usize) -> Self {
        let words = (length + 2) / 64 + 1;
        Self { words, bits: vec![u64::MAX; words * (lines + 2)] }
    }

    /// The word with the bit of place `at` of `line`, and the bit's number. Places and lines go from
    /// -1, the margin.
    const fn place(&self, at: i32, line: i32) -> (usize, u32) {
        let bit = (at + 1) as usize;
        ((line + 1) as usize * self.words + bit / 64, (bit % 64) as u32)
    }

    pub(super) fn set(&mut self, at: i32, line: i32, stop: bool) {
        let (word, bit) = self.place(at, line);
        let mask = 1 << bit;
        self.bits[word] = if stop { self.bits[word] | mask } else { self.bits[word] & !mask };
    }

    pub(super) fn stops(&self, at: i32, line: i32) -> bool {
        let (word, bit) = self.place(at, line);
        self.bits[word] >> bit & 1 != 0
    }

    /// How far after `at` the next stop is; more than `limit` if it is farther than that.
    pub(super) fn after(&self, at: i32, line: i32, limit: i32) -> i32 {
        let (mut word, bit) = self.place(at + 1, line);
        let mut bits = self.bits[word] >> bit;
        let mut passed = 1;
        let mut width = 64 - bit as i32;
        while bits == 0 {
            passed += width;
            if passed > limit {
                return passed;
            }
            word += 1;
            width = 64;
            bits = self.bits[word];
        }
        passed + bits.trailing_zeros() as i32
    }

    /// The same before `at`.
    pub(super) fn before(&self, at: i32, line: i32, limit: i32) -> i32 {
        let (mut word, bit) = self.place(at - 1, line);
        let mut bits = self.bits[word] << (63 - bit);
        let mut passed = 1;
        let mut width = bit as i32 + 1;
        while bits == 0 {
            passed += width;
            if passed > limit {
                return passed;
            }
            word -= 1;
            width = 64;
            bits = self.bits[word];
        }
        passed + bits.leading_zeros() as i32
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.bits.as_slice())
    }
}
