//! Which tags stand in front of a reader.
//!
//! A UHF reader sees tags metres away. A tag stands there from its first read at
//! [`RssiBand::enter_dbm`] or above until it was not read at [`RssiBand::leave_dbm`] or above for
//! a while, so that a robot driving by in the aisle is not taken for one that docks and one lost
//! read is not taken for a departure. Where it must also have [dwelt](Presence::dwelling), a read that
//! a reflection from afar made possible is not taken for an arrival.

use heapless::Vec;
use protocol::{DurationMs, Millis, TagId};

/// Two signal strengths with a gap between them, against flutter at a field's edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RssiBand {
    /// A tag at least this strong has entered.
    pub enter_dbm: i8,
    /// A tag that has entered stays while it is at least this strong.
    pub leave_dbm: i8,
}

#[derive(Clone, Copy, Debug)]
struct Sighting {
    tag: TagId,
    first: Millis,
    last: Millis,
    /// It has been here long enough.
    entered: bool,
}

/// The tags within a band, at most `N` at a time: one more takes the place of the tag that was
/// read longest ago.
#[derive(Clone, Debug)]
pub struct Presence<const N: usize> {
    band: RssiBand,
    timeout: DurationMs,
    dwell: DurationMs,
    present: Vec<Sighting, N>,
}

impl<const N: usize> Presence<N> {
    /// Nobody is here. A tag is gone when it was not read for `timeout`.
    #[must_use]
    pub const fn new(band: RssiBand, timeout: DurationMs) -> Self {
        Self { band, timeout, dwell: DurationMs(0), present: Vec::new() }
    }

    /// A tag is here only once it was read again this long after its first read.
    #[must_use]
    pub const fn dwelling(mut self, dwell: DurationMs) -> Self {
        self.dwell = dwell;
        self
    }

    /// A tag was read. Answers whether it has just entered.
    pub fn read(&mut self, now: Millis, tag: TagId, rssi_dbm: i8) -> bool {
        self.forget_gone(now);
        if let Some(sighting) = self.present.iter_mut().find(|sighting| sighting.tag == tag) {
            if rssi_dbm < self.band.leave_dbm {
                return false;
            }
            sighting.last = now;
            let enters = !sighting.entered && now.since(sighting.first) >= self.dwell;
            sighting.entered |= enters;
            return enters;
        }
        if rssi_dbm < self.band.enter_dbm {
            return false;
        }
        if self.present.is_full() {
            let oldest = self.present.iter().enumerate().min_by_key(|(_, sighting)| sighting.last);
            if let Some((index, _)) = oldest {
                self.present.swap_remove(index);
            }
        }
        let entered = self.dwell == DurationMs(0);
        self.present.push(Sighting { tag, first: now, last: now, entered }).is_ok() && entered
    }

    /// Whether `tag` is here.
    #[must_use]
    pub fn contains(&self, now: Millis, tag: TagId) -> bool {
        self.tags(now).any(|present| present == tag)
    }

    /// All tags that are here.
    pub fn tags(&self, now: Millis) -> impl Iterator<Item = TagId> {
        let timeout = self.timeout;
        self.present
            .iter()
            .filter(move |sighting| sighting.entered && now.since(sighting.last) < timeout)
            .map(|sighting| sighting.tag)
    }

    fn forget_gone(&mut self, now: Millis) {
        self.present.retain(|sighting| now.since(sighting.last) < self.timeout);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: RssiBand = RssiBand { enter_dbm: -60, leave_dbm: -66 };

    fn tag(number: u8) -> TagId {
        TagId([number; 12])
    }

    fn presence() -> Presence<2> {
        Presence::new(BAND, DurationMs(2_000))
    }

    #[test]
    fn a_tag_enters_strong_and_stays_a_little_weaker() {
        let mut presence = presence();
        assert!(!presence.read(Millis(0), tag(1), -61));
        assert!(presence.read(Millis(100), tag(1), -60));
        assert!(!presence.read(Millis(2_000), tag(1), -66));
        assert!(presence.contains(Millis(3_999), tag(1)));
        assert!(!presence.contains(Millis(4_000), tag(1)));
    }

    #[test]
    fn a_tag_heard_only_from_afar_has_left() {
        let mut presence = presence();
        presence.read(Millis(0), tag(1), -50);
        (1..30).for_each(|tick| assert!(!presence.read(Millis(tick * 100), tag(1), -67)));
        assert!(!presence.contains(Millis(2_900), tag(1)));
    }

    #[test]
    fn a_tag_that_must_dwell_is_here_when_it_was_read_again_long_enough_after() {
        let mut presence = presence().dwelling(DurationMs(300));
        assert!(!presence.read(Millis(0), tag(1), -50));
        assert!(!presence.contains(Millis(0), tag(1)));
        assert!(!presence.read(Millis(299), tag(1), -66));
        assert!(!presence.read(Millis(300), tag(1), -67), "from afar");
        assert!(presence.read(Millis(301), tag(1), -66));
        assert!(presence.contains(Millis(301), tag(1)));
        assert!(!presence.read(Millis(302), tag(1), -50), "it is here already");
        // Gone, and back for a moment.
        assert!(!presence.read(Millis(5_000), tag(1), -50));
        assert!(!presence.contains(Millis(5_000), tag(1)));
    }

    #[test]
    fn one_tag_too_many_takes_the_place_of_the_one_read_longest_ago() {
        let mut presence = presence();
        presence.read(Millis(0), tag(1), -50);
        presence.read(Millis(1), tag(2), -50);
        presence.read(Millis(2), tag(1), -50);
        presence.read(Millis(3), tag(3), -50);
        let mut here: std::vec::Vec<_> = presence.tags(Millis(3)).collect();
        here.sort();
        assert_eq!(here, [tag(1), tag(3)]);
    }
}
