//! Numbers for things, and results that are worked out once.

use std::{collections::HashMap, hash::Hash};

/// Gives things numbers: the same for what is equal.
pub struct Interner<K, T> {
    numbers: HashMap<K, u32>,
    things: Vec<T>,
}

impl<K, T> Default for Interner<K, T> {
    fn default() -> Self {
        Self { numbers: HashMap::new(), things: Vec::new() }
    }
}

impl<K: Hash + Eq, T> Interner<K, T> {
    /// The number of the thing with this key, which is its canonical form.
    pub fn number(&mut self, key: K, thing: impl FnOnce() -> T) -> u32 {
        *self.numbers.entry(key).or_insert_with(|| {
            self.things.push(thing());
            self.things.len() as u32 - 1
        })
    }

    pub fn get(&self, number: u32) -> &T {
        &self.things[number as usize]
    }
}
