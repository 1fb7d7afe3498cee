//! The network: frames by value, with the rules of sealed sessions but without their bytes.
//!
//! A frame names the start of the receiver that it is for, as a seal does
//! ([`Sessions`](protocol::Sessions)): one for another start is not authentic, one that was taken before
//! is not taken again, and nothing but Hello is said to who was not heard yet. What is not here is the
//! arithmetic of seals and frames, which `protocol` tests.

use protocol::{BootEpoch, DeviceId, DurationMs, Frame, Header, Message, Millis, Sequence};

use super::{
    super::random::Random,
    faults::{Fault, Troubles},
};

/// What a frame takes without any fault, in milliseconds: from, to.
const USUAL_MS: (f64, f64) = (5.0, 20.0);
/// What a frame that is delayed takes on top.
const DELAYED_MS: (f64, f64) = (200.0, 5_000.0);
/// What a frame that does not keep its place in the queue takes on top.
const REORDERED_MS: (f64, f64) = (0.0, 300.0);
/// How much later the copy of a frame comes.
const COPIED_MS: (f64, f64) = (0.0, 3_000.0);

/// A place on the network, by its number in the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// The coordinator.
    Office,
    /// A pile.
    Pile(usize),
    /// A robot.
    Robot(usize),
}

/// A frame on its way.
#[derive(Clone, Debug)]
pub struct Letter {
    /// From where.
    pub from: Node,
    /// Where to.
    pub to: Node,
    /// When it was sent.
    pub sent: Millis,
    /// What it says.
    pub frame: Box<Frame>,
    /// The start of the receiver that it is sealed for; `None` for Hello, which is for any.
    for_boot: Option<BootEpoch>,
}

impl Letter {
    /// A frame under the site's key, which belongs to no session.
    #[must_use]
    pub fn of_site((from, to): (Node, Node), header: Header, sent: Millis, message: Message) -> Self {
        Self { from, to, sent, frame: Box::new(Frame { header, message }), for_boot: None }
    }
}

/// What becomes of a frame at its receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opened {
    /// It is new and to be believed.
    Taken,
    /// It was taken before, or a later one was.
    Stale,
    /// It was sealed for another start.
    Unauthentic,
}

/// One device's end of a conversation, in one start of that device.
#[derive(Clone, Copy, Debug, Default)]
pub struct Session {
    next: Sequence,
    heard: Option<(BootEpoch, Sequence)>,
}

impl Session {
    /// The next frame to the other end; `None` if that was not heard yet and this is not Hello.
    pub fn seal(
        &mut self,
        (from, to): (Node, Node),
        (sender, boot): (DeviceId, BootEpoch),
        sent: Millis,
        message: Message,
    ) -> Option<Letter> {
        let for_boot = match message {
            Message::Hello(_) => None,
            _ => Some(self.heard?.0),
        };
        let header = Header::new(sender, boot, self.next);
        self.next.0 = self.next.0.wrapping_add(1);
        Some(Letter { from, to, sent, frame: Box::new(Frame { header, message }), for_boot })
    }

    /// Whether a device in its start `own` believes a frame.
    pub fn open(&mut self, own: BootEpoch, letter: &Letter) -> Opened {
        if letter.for_boot.is_some_and(|boot| boot != own) {
            return Opened::Unauthentic;
        }
        let header = &letter.frame.header;
        let this = (header.boot, header.sequence);
        if self.heard.is_some_and(|heard| this <= heard) {
            return Opened::Stale;
        }
        self.heard = Some(this);
        Opened::Taken
    }
}

/// Letters on their way, by number.
#[derive(Debug, Default)]
pub struct Network {
    letters: Vec<Option<Letter>>,
    free: Vec<usize>,
    chance: Option<Random>,
    /// When the last letter arrives, to and from every device.
    queues: Vec<[Millis; 2]>,
    piles: usize,
}

impl Network {
    /// A network between so many devices and the coordinator.
    #[must_use]
    pub fn new(seed: u64, piles: usize, robots: usize) -> Self {
        Self {
            chance: Some(Random::new(seed, 0x2_0000)),
            queues: vec![[Millis(0); 2]; piles + robots],
            piles,
            ..Self::default()
        }
    }

    /// The number of a device among piles and robots.
    #[must_use]
    pub const fn device(&self, node: Node) -> Option<usize> {
        match node {
            Node::Office => None,
            Node::Pile(pile) => Some(pile),
            Node::Robot(robot) => Some(self.piles + robot),
        }
    }

    /// Takes a letter, and answers when it arrives and under which number, if it does, once or twice.
    pub fn post(
        &mut self,
        now: Millis,
        troubles: &mut Troubles,
        letter: Letter,
    ) -> [Option<(Millis, usize)>; 2] {
        if troubles.strikes(Fault::Loss) {
            return [None, None];
        }
        let mut arrives = self.arrival(now, &letter);
        if troubles.strikes(Fault::Delay) {
            arrives = later(arrives, troubles.chance(Fault::Delay), DELAYED_MS);
        }
        if troubles.strikes(Fault::Reorder) {
            arrives = later(arrives, troubles.chance(Fault::Reorder), REORDERED_MS);
        } else if let Some(last) = self.queue(&letter) {
            // Nothing overtakes what was sent before.
            arrives = arrives.max(*last);
            *last = arrives;
        }
        let copy = troubles.strikes(Fault::Duplicate).then(|| {
            let at = later(arrives, troubles.chance(Fault::Duplicate), COPIED_MS);
            (at, self.keep(letter.clone()))
        });
        [Some((arrives, self.keep(letter))), copy]
    }

    /// Takes a letter out that has arrived.
    pub fn take(&mut self, number: usize) -> Option<Letter> {
        let letter = self.letters.get_mut(number)?.take();
        self.free.push(number);
        letter
    }

    fn arrival(&mut self, now: Millis, letter: &Letter) -> Millis {
        let at = now.max(letter.sent);
        self.chance.as_mut().map_or(at, |chance| later(at, chance, USUAL_MS))
    }

    fn queue(&mut self, letter: &Letter) -> Option<&mut Millis> {
        let device = self.device(letter.from).or_else(|| self.device(letter.to))?;
        self.queues.get_mut(device)?.get_mut(usize::from(letter.to == Node::Office))
    }

    fn keep(&mut self, letter: Letter) -> usize {
        match self.free.pop() {
            Some(number) => {
                if let Some(place) = self.letters.get_mut(number) {
                    *place = Some(letter);
                }
                number
            }
            None => {
                self.letters.push(Some(letter));
                self.letters.len() - 1
            }
        }
    }
}

fn later(at: Millis, chance: &mut Random, (least_ms, most_ms): (f64, f64)) -> Millis {
    at.after(DurationMs(chance.between(least_ms, most_ms) as u32))
}

#[cfg(test)]
mod tests {
    use protocol::{Epoch, Hello, RobotId, TimeRequest};

    use super::{super::faults::Faults, *};

    const ROUTE: (Node, Node) = (Node::Robot(0), Node::Office);
    const ROBOT: (DeviceId, BootEpoch) = (DeviceId::Robot(RobotId(1)), BootEpoch(3));

    fn hello() -> Message {
        Message::Hello(Hello::new(Epoch(0)))
    }

    fn question() -> Message {
        Message::TimeRequest(TimeRequest { asked_at: Millis(0) })
    }

    #[test]
    fn a_session_says_nothing_but_hello_before_it_has_heard_and_takes_nothing_twice_or_for_another_start() {
        let (mut robot, mut office) = (Session::default(), Session::default());
        assert!(robot.seal(ROUTE, ROBOT, Millis(0), question()).is_none());
        let first = robot.seal(ROUTE, ROBOT, Millis(0), hello()).unwrap();
        assert_eq!(office.open(BootEpoch(9), &first), Opened::Taken);
        assert_eq!(office.open(BootEpoch(9), &first), Opened::Stale);
        let sender = (DeviceId::Coordinator, BootEpoch(9));
        let answer = office.seal((Node::Office, Node::Robot(0)), sender, Millis(1), hello()).unwrap();
        assert_eq!(robot.open(BootEpoch(3), &answer), Opened::Taken);
        let asked = robot.seal(ROUTE, ROBOT, Millis(2), question()).unwrap();
        assert_eq!(office.open(BootEpoch(10), &asked), Opened::Unauthentic);
        assert_eq!(office.open(BootEpoch(9), &asked), Opened::Taken);
    }

    #[test]
    fn frames_keep_their_order_unless_they_are_reordered_and_all_arrive_without_faults() {
        let arrivals = |faults: Faults| {
            let mut network = Network::new(7, 1, 1);
            let mut troubles = Troubles::new(7, faults, 0..u64::MAX);
            let mut session = Session::default();
            let mut times = Vec::new();
            for number in 0..500 {
                let letter = session.seal(ROUTE, ROBOT, Millis(number), hello()).unwrap();
                for (at, number) in network.post(Millis(number), &mut troubles, letter).into_iter().flatten()
                {
                    times.push((at, network.take(number).unwrap().frame.header.sequence));
                }
            }
            times
        };
        let good = arrivals(Faults::NONE);
        assert_eq!(good.len(), 500);
        assert!(good.is_sorted());
        assert!(!arrivals(Faults::NONE.with(Fault::Reorder)).is_sorted());
        let lossy = arrivals(Faults::NONE.with(Fault::Loss));
        assert!(lossy.is_sorted() && (450..500).contains(&lossy.len()), "{}", lossy.len());
        assert!(arrivals(Faults::NONE.with(Fault::Duplicate)).len() > 500);
    }
}
