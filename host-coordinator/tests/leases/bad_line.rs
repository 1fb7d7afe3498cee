//! A network that loses, damages, repeats, delays and reorders frames, and counts what it did.

use std::collections::BTreeMap;
use std::fmt;

use protocol::{BootEpoch, Deframer, DeviceId, Frame, FrameError, Sequence, Session, Sessions};

use crate::random::Random;

/// What goes wrong on the way, each in a thousandth of the frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trouble {
    /// Frames lost.
    pub lost: u64,
    /// Frames with some bits changed, cut short, or with noise in them.
    pub damaged: u64,
    /// Frames delivered twice.
    pub repeated: u64,
    /// Frames that others overtake, by up to 3 s.
    pub late: u64,
    /// The longest delay of a frame, in milliseconds.
    pub delay_ms: u64,
}

/// What became of the frames.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Figures {
    pub sent: u64,
    pub lost: u64,
    pub damaged: u64,
    pub repeated: u64,
    pub late: u64,
    /// Arrived behind one that was sent later by the same sender to the same receiver.
    pub overtaken: u64,
    pub accepted: u64,
    /// By the reason's name.
    pub refused: BTreeMap<String, u64>,
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { sent, lost, damaged, repeated, late, overtaken, accepted, refused } = self;
        write!(
            f,
            "{sent} frames sent: {lost} lost, {damaged} damaged, {repeated} repeated, {late} late; \
             {overtaken} overtaken; {accepted} accepted, refused {refused:?}"
        )
    }
}

/// Frames under way between two devices.
type Route = (DeviceId, DeviceId);

/// All lines of a site.
#[derive(Default)]
pub struct BadLine {
    pub figures: Figures,
    posted: u64,
    /// By arrival, then in order.
    wire: BTreeMap<(u64, u64), (Route, Vec<u8>)>,
    /// What has begun at a receiver, from each sender.
    deframers: BTreeMap<Route, Deframer>,
    newest: BTreeMap<Route, u64>,
    /// The last frame that was believed, since the receiver's start.
    believed: BTreeMap<Route, (BootEpoch, Sequence)>,
}

impl BadLine {
    pub fn post(&mut self, now: u64, trouble: Trouble, random: &mut Random, route: Route, bytes: &[u8]) {
        self.figures.sent += 1;
        if random.chance(trouble.lost) {
            self.figures.lost += 1;
            return;
        }
        let repeated = random.chance(trouble.repeated);
        self.figures.repeated += u64::from(repeated);
        for _ in 0..1 + u64::from(repeated) {
            let mut delay = 1 + random.below(trouble.delay_ms + 1);
            if random.chance(trouble.late) {
                self.figures.late += 1;
                delay += random.below(3_000);
            }
            let mut bytes = bytes.to_vec();
            if random.chance(trouble.damaged) {
                self.figures.damaged += 1;
                damage(random, &mut bytes);
            }
            self.posted += 1;
            self.wire.insert((now + delay, self.posted), (route, bytes));
        }
    }

    /// The next frame that has arrived: from whom, to whom, its bytes.
    pub fn arrived(&mut self, now: u64) -> Option<(Route, Vec<u8>)> {
        let entry = self.wire.first_entry().filter(|entry| entry.key().0 <= now)?;
        let ((_, number), (route, bytes)) = entry.remove_entry();
        let newest = self.newest.entry(route).or_default();
        self.figures.overtaken += u64::from(number < *newest);
        *newest = number.max(*newest);
        Some((route, bytes))
    }

    /// What a receiver finds in bytes, with what has come before them on the same line.
    pub fn open<Peers: AsMut<[Session]>>(
        &mut self,
        route: Route,
        sessions: &mut Sessions<Peers>,
        bytes: &[u8],
    ) -> Vec<Result<Frame, FrameError>> {
        let mut found = Vec::new();
        self.deframers
            .entry(route)
            .or_default()
            .feed(bytes, |packet| found.push(packet.and_then(|packet| sessions.open(packet))));
        for result in &found {
            match result {
                Ok(Frame { header, message }) => {
                    self.figures.accepted += 1;
                    let name = (header.boot, header.sequence);
                    let last = self.believed.insert(route, name);
                    assert!(
                        last < Some(name),
                        "{route:?}: {message:?} is believed again, or behind a later one"
                    );
                }
                Err(error) => {
                    let name = format!("{error:?}");
                    let name =
                        name.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned();
                    *self.figures.refused.entry(name).or_default() += 1;
                }
            }
        }
        found
    }

    /// A device has restarted: what has begun to arrive there is forgotten.
    pub fn forget(&mut self, receiver: DeviceId) {
        self.deframers.retain(|(_, to), _| *to != receiver);
        self.believed.retain(|(_, to), _| *to != receiver);
    }
}

fn damage(random: &mut Random, bytes: &mut Vec<u8>) {
    let at = random.below(bytes.len() as u64) as usize;
    match random.below(4) {
        0 => bytes.truncate(at),
        1 => {
            let noise: Vec<u8> = (0..1 + random.below(8)).map(|_| random.next() as u8).collect();
            bytes.splice(at..at, noise);
        }
        _ => {
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len() as u64) as usize;
                bytes[at] ^= 1 << random.below(8);
            }
        }
    }
}
