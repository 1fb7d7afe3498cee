//! What is to happen when: a timing wheel of a slot a millisecond, and a map for what lies farther off.
//!
//! What is due at one instant happens in the order in which it was put down: something far off was put
//! down earlier than anything near for the same instant, and so comes first.

use std::collections::BTreeMap;

use protocol::Millis;

/// Milliseconds that the wheel covers.
const SLOTS: usize = 4096;
const WORD: usize = u64::BITS as usize;
/// No place.
const NONE: u32 = u32::MAX;

/// A queue of things to happen.
#[derive(Debug)]
pub struct Agenda<T> {
    now: u64,
    /// What is due in each millisecond that the wheel covers.
    wheel: Vec<Line>,
    /// Which of them is anything due in.
    used: [u64; SLOTS / WORD],
    far: BTreeMap<u64, Line>,
    /// All that is put down, each with what comes after it in its line.
    places: Vec<(Option<T>, u32)>,
    /// The first free place; they form a line too.
    free: u32,
}

/// The first and the last place of what is due at one instant.
#[derive(Clone, Copy, Debug)]
struct Line {
    first: u32,
    last: u32,
}

impl Line {
    const EMPTY: Self = Self { first: NONE, last: NONE };
}

impl<T> Default for Agenda<T> {
    fn default() -> Self {
        Self {
            now: 0,
            wheel: vec![Line::EMPTY; SLOTS],
            used: [0; SLOTS / WORD],
            far: BTreeMap::new(),
            places: Vec::new(),
            free: NONE,
        }
    }
}

impl<T> Agenda<T> {
    /// Puts `what` down for `at`; what should have happened already happens next.
    pub fn put(&mut self, at: Millis, what: T) {
        let at = at.0.max(self.now);
        let place = self.place(what);
        if at - self.now < SLOTS as u64 {
            let slot = at as usize % SLOTS;
            self.used[slot / WORD] |= 1 << (slot % WORD);
            append(&mut self.places, &mut self.wheel[slot], Line { first: place, last: place });
        } else {
            let line = self.far.entry(at).or_insert(Line::EMPTY);
            append(&mut self.places, line, Line { first: place, last: place });
        }
    }

    /// What happens next, and when.
    pub fn take(&mut self) -> Option<(Millis, T)> {
        loop {
            let slot = self.now as usize % SLOTS;
            let line = &mut self.wheel[slot];
            if line.first != NONE {
                let (what, next) = &mut self.places[line.first as usize];
                let first = std::mem::replace(&mut line.first, *next);
                *next = std::mem::replace(&mut self.free, first);
                return what.take().map(|what| (Millis(self.now), what));
            }
            self.used[slot / WORD] &= !(1 << (slot % WORD));
            let near = self.next_used();
            let far = self.far.keys().next().copied();
            self.now = [near, far].into_iter().flatten().min()?;
            self.draw_near();
        }
    }

    fn place(&mut self, what: T) -> u32 {
        if self.free == NONE {
            self.places.push((Some(what), NONE));
            // As many do not fit into memory.
            return (self.places.len() - 1) as u32;
        }
        let place = self.free;
        let (empty, next) = &mut self.places[place as usize];
        *empty = Some(what);
        self.free = std::mem::replace(next, NONE);
        place
    }

    /// The next instant in which anything is due, as far as the wheel goes.
    fn next_used(&self) -> Option<u64> {
        let first = self.now as usize % SLOTS;
        let words = SLOTS / WORD;
        (0..=words).find_map(|ahead| {
            let index = (first / WORD + ahead) % words;
            // Of the first word the part from here on, at the end of the round the part before.
            let mask = match ahead {
                0 => !0 << (first % WORD),
                _ if ahead == words => !(!0 << (first % WORD)),
                _ => !0,
            };
            let bits = self.used[index] & mask;
            let slot = index * WORD + bits.trailing_zeros() as usize;
            (bits != 0).then(|| self.now + ((slot + SLOTS - first) % SLOTS) as u64)
        })
    }

    /// Moves what is due within the wheel's span there, before anything newer gets there.
    fn draw_near(&mut self) {
        while let Some(entry) = self.far.first_entry()
            && *entry.key() - self.now < SLOTS as u64
        {
            let (at, mut line) = entry.remove_entry();
            let slot = at as usize % SLOTS;
            self.used[slot / WORD] |= 1 << (slot % WORD);
            append(&mut self.places, &mut line, self.wheel[slot]);
            self.wheel[slot] = line;
        }
    }
}

fn append<T>(places: &mut [(Option<T>, u32)], line: &mut Line, other: Line) {
    if line.first == NONE {
        *line = other;
    } else if other.first != NONE {
        places[line.last as usize].1 = other.first;
        line.last = other.last;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn everything_happens_when_it_is_due_and_in_the_order_it_was_put_down(
            first in prop::collection::vec(0_u64..20_000, 1..60),
            later in prop::collection::vec(0_u64..20_000, 0..200),
        ) {
            let mut agenda = Agenda::default();
            let mut number = 0;
            let mut expected: Vec<(u64, usize)> = Vec::new();
            let mut put = |agenda: &mut Agenda<usize>, at: u64, expected: &mut Vec<(u64, usize)>| {
                agenda.put(Millis(at), number);
                expected.push((at, number));
                number += 1;
            };
            first.iter().for_each(|&at| put(&mut agenda, at, &mut expected));
            let mut later = later.into_iter();
            let mut happened = Vec::new();
            // More is put down while things happen.
            while let Some((now, what)) = agenda.take() {
                happened.push((now.0, what));
                if let Some(ahead) = later.next() {
                    put(&mut agenda, now.0 + ahead, &mut expected);
                }
            }
            expected.sort_unstable();
            prop_assert_eq!(happened, expected);
        }
    }

    #[test]
    fn what_is_late_happens_at_once() {
        let mut agenda = Agenda::default();
        agenda.put(Millis(10_000), 'a');
        assert_eq!(agenda.take(), Some((Millis(10_000), 'a')));
        agenda.put(Millis(3), 'b');
        assert_eq!(agenda.take(), Some((Millis(10_000), 'b')));
        assert_eq!(agenda.take(), None);
    }
}
