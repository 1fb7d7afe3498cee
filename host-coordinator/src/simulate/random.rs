//! A small reproducible source of chance for the simulated site.
//!
//! Runs of the demo with one seed must be alike on every machine and in every release, which
//! general-purpose random crates do not promise.

/// SplitMix64 (Steele, Lea, Flood 2014): a counter through a mixing function.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A source that depends on nothing but `seed` and `stream`, so that every robot has its own.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut mixed = Self(seed);
        let offset = mixed.bits();
        let mut random = Self(offset ^ stream.wrapping_mul(0xD129_0D3A_F8A6_2D4B));
        random.bits();
        random
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        bits ^ (bits >> 31)
    }

    /// A number from `low` up to, not including, `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        // 53 bits fill the mantissa of an f64.
        let unit = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        low + unit * (high - low)
    }

    /// One of `items`; `None` if there are none.
    pub fn choose<'a, T>(&mut self, items: &'a [T]) -> Option<&'a T> {
        let index = self.between(0.0, items.len() as f64) as usize;
        items.get(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_and_stream_give_the_same_numbers_and_others_do_not() {
        let draw = |seed, stream| {
            let mut random = Random::new(seed, stream);
            [random.bits(), random.bits(), random.bits()]
        };
        assert_eq!(draw(1, 2), draw(1, 2));
        assert_ne!(draw(1, 2), draw(2, 2));
        assert_ne!(draw(1, 2), draw(1, 3));
    }

    #[test]
    fn numbers_stay_between_their_bounds_and_fill_them() {
        let mut random = Random::new(7, 0);
        let drawn: Vec<f64> = (0..10_000).map(|_| random.between(-1.0, 3.0)).collect();
        assert!(drawn.iter().all(|number| (-1.0..3.0).contains(number)));
        assert!(drawn.iter().any(|&number| number < -0.9) && drawn.iter().any(|&number| number > 2.9));
        assert_eq!(random.choose::<u8>(&[]), None);
    }
}
