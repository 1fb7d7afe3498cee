//! What an attacker can do who sees every frame, keeps it, and decides when it arrives, where and how
//! often: delay and lose, and nothing else.
//!
//! Two devices say Hello and say things, each of which carries a number of its own. Either may
//! restart at any moment. The attacker delivers any frame that was ever sent to either of them, with a
//! bit flipped or not.

use proptest::{prelude::*, sample::Index};
use protocol::{
    Ack, BootEpoch, CommandId, Deframer, DeviceId, Epoch, Frame, FrameBytes, FrameError, Hello, Key, Message,
    Millis, Nack, PileId, Recipient, Reference, SealError, Session, Sessions, TimeRequest, Trust,
};

const IDS: [DeviceId; 2] = [DeviceId::Coordinator, DeviceId::Pile(PileId(7))];

fn key(fill: u8) -> Key {
    Key::new([fill; 32])
}

fn hello() -> Message {
    Message::Hello(Hello { min: 1, current: 1, software: [0, 1, 2], epoch: Epoch(300) })
}

fn numbered(number: u64) -> Message {
    Message::TimeRequest(TimeRequest { asked_at: Millis(number) })
}

/// A device as an attacker sees it.
struct Device {
    own: usize,
    sessions: Sessions<[Session; 1]>,
    boot: BootEpoch,
    /// Numbers of what it has believed, over all its starts.
    believed: Vec<u64>,
    /// The frames that it has believed in this start.
    frames: Vec<Frame>,
}

impl Device {
    fn new(own: usize) -> Self {
        let boot = BootEpoch(1);
        Self { own, sessions: sessions(own, boot), boot, believed: Vec::new(), frames: Vec::new() }
    }

    fn restart(&mut self) {
        self.boot.0 += 1;
        self.sessions = sessions(self.own, self.boot);
        self.frames.clear();
    }

    fn seal(&mut self, message: &Message) -> Result<FrameBytes, SealError> {
        self.sessions.seal(Recipient::Device(IDS[1 - self.own]), message)
    }

    fn hear(&mut self, bytes: &[u8]) -> Vec<Result<Frame, FrameError>> {
        let mut found = Vec::new();
        // However the damage has hit the delimiters.
        Deframer::new().feed(&[&[0], bytes, &[0]].concat(), |result| {
            found.push(result.and_then(|packet| self.sessions.open(packet)));
        });
        for frame in found.iter().flatten() {
            if let Message::TimeRequest(request) = frame.message {
                self.believed.push(request.asked_at.0);
            }
            self.frames.push(frame.clone());
        }
        found
    }
}

fn sessions(own: usize, boot: BootEpoch) -> Sessions<[Session; 1]> {
    let peers = [Session::new(IDS[1 - own], key(1))];
    Sessions::new(IDS[own], boot, Trust::Keys { site: Some(key(2)), peers })
}

/// What happens, to one of the two devices.
#[derive(Clone, Debug)]
enum Event {
    SaysHello,
    Speaks,
    /// A frame, any that was ever sent by anyone, arrives.
    Hears(Index),
    /// The newest frame arrives: without this few conversations would get anywhere.
    HearsNewest,
    /// A frame arrives with a bit flipped.
    HearsFlipped(Index, Index),
    Restarts,
}

fn event() -> impl Strategy<Value = (usize, Event)> {
    let event = prop_oneof![
        2 => Just(Event::SaysHello),
        4 => Just(Event::Speaks),
        4 => any::<Index>().prop_map(Event::Hears),
        4 => Just(Event::HearsNewest),
        2 => any::<(Index, Index)>().prop_map(|(frame, bit)| Event::HearsFlipped(frame, bit)),
        1 => Just(Event::Restarts),
    ];
    (0..2_usize, event)
}

/// Both devices, and everything that was ever sent.
struct World {
    devices: [Device; 2],
    sent: Vec<FrameBytes>,
    number: u64,
}

impl World {
    fn new() -> Self {
        Self { devices: [0, 1].map(Device::new), sent: Vec::new(), number: 0 }
    }

    fn happens(&mut self, who: usize, event: &Event) {
        let device = &mut self.devices[who];
        match event {
            Event::SaysHello => self.sent.push(device.seal(&hello()).unwrap()),
            Event::Speaks => {
                // The devices' numbers are told apart by their last bit.
                self.number += 1;
                // Who has not heard the other yet says nothing.
                self.sent.extend(device.seal(&numbered(2 * self.number + who as u64)).ok());
            }
            Event::Hears(frame) if !self.sent.is_empty() => {
                drop(device.hear(frame.get::<FrameBytes>(&self.sent)))
            }
            Event::HearsNewest => drop(self.sent.last().map(|frame| device.hear(frame))),
            Event::HearsFlipped(frame, bit) if !self.sent.is_empty() => {
                let mut bytes = frame.get::<FrameBytes>(&self.sent).clone();
                // Its delimiters are none of its content.
                let bit = 8 + bit.index(8 * (bytes.len() - 2));
                bytes[bit / 8] ^= 1 << (bit % 8);
                let found = device.hear(&bytes);
                assert!(found.iter().all(Result::is_err), "bit {bit} of {bytes:?}: {found:?}");
            }
            Event::Restarts => device.restart(),
            Event::Hears(_) | Event::HearsFlipped(..) => {}
        }
    }

    /// Each says something and hears all the other says, and answers by a Hello what does not
    /// authenticate.
    fn exchange(&mut self) {
        for who in 0..2 {
            self.number += 1;
            let number = 2 * self.number + who as u64;
            let said = match self.devices[who].seal(&numbered(number)) {
                Err(SealError::Unheard { .. }) => self.devices[who].seal(&hello()),
                sealed => sealed,
            };
            let found = self.devices[1 - who].hear(&said.unwrap());
            if matches!(found[..], [Err(FrameError::Unauthentic { .. })]) {
                let answer = self.devices[1 - who].seal(&hello()).unwrap();
                self.devices[who].hear(&answer);
            }
        }
    }
}

proptest! {
    #[test]
    fn nothing_is_believed_twice_nor_late_nor_from_oneself_whoever_restarts(
        events in prop::collection::vec(event(), 0..200),
    ) {
        let mut world = World::new();
        for (who, event) in &events {
            world.happens(*who, event);
        }
        for device in &world.devices {
            // In the order in which it was said, and so never twice.
            prop_assert!(device.believed.is_sorted_by(|a, b| a < b), "{:?}", device.believed);
            prop_assert!(device.believed.iter().all(|number| number % 2 == 1 - device.own as u64));
            let order: Vec<_> = device.frames.iter().map(|frame| (frame.header.boot, frame.header.sequence)).collect();
            prop_assert!(order.is_sorted_by(|a, b| a < b), "{order:?}");
        }
    }

    #[test]
    fn whatever_has_happened_both_soon_hear_each_other_again(
        events in prop::collection::vec(event(), 0..100),
    ) {
        let mut world = World::new();
        for (who, event) in &events {
            world.happens(*who, event);
        }
        world.exchange();
        world.exchange();
        let before = world.devices.each_ref().map(|device| device.believed.len());
        world.exchange();
        let after = world.devices.each_ref().map(|device| device.believed.len());
        prop_assert_eq!(after, before.map(|count| count + 1));
    }

    #[test]
    fn who_has_another_key_is_not_believed(message in crate::strategies::message(), site: bool) {
        let peers = [Session::new(IDS[0], key(3))];
        let mut forger = Sessions::new(IDS[1], BootEpoch(9), Trust::Keys { site: Some(key(3)), peers });
        let mut receiver = Device::new(0);
        // The attacker knows which start it is.
        let heard = forger_hears(&mut forger);
        prop_assert!(heard);
        let to = if site { Recipient::Piles } else { Recipient::Device(IDS[0]) };
        let bytes = forger.seal(to, &message).unwrap();
        prop_assert_eq!(receiver.hear(&bytes), [Err(FrameError::Unauthentic { sender: IDS[1] })]);
    }

    #[test]
    fn without_a_seal_nothing_is_believed_but_provisioning(frame in crate::strategies::frame()) {
        let sender = frame.header.sender;
        let mut receiver = Device::new(0);
        let found = receiver.hear(&frame.encode().unwrap());
        if let (DeviceId::Service, Message::Provision(_)) = (sender, &frame.message) {
            // It makes keys where there are none.
            prop_assert_eq!(found, [Ok(frame)]);
        } else {
            prop_assert_eq!(found, [Err(FrameError::Unsealed { sender })]);
        }
    }

    #[test]
    fn under_the_site_s_seal_only_gossip_and_claims_are_believed(message in crate::strategies::message()) {
        let mut sender = Device::new(1);
        let bytes = sender.sessions.seal(Recipient::Piles, &message).unwrap();
        let mut receiver = Device::new(0);
        let found = receiver.hear(&bytes);
        match message {
            Message::PileTable(_)
            | Message::ClaimPile(_)
            | Message::Ack(Ack { of: Reference::Claim(_) })
            | Message::Nack(Nack { of: Reference::Claim(_), .. }) => {
                prop_assert_eq!(&found[0].as_ref().unwrap().message, &message);
                // Its rows say how old they are.
                prop_assert_eq!(receiver.hear(&bytes), found);
            }
            _ => prop_assert_eq!(found, [Err(FrameError::NotGossip { sender: IDS[1] })]),
        }
    }
}

/// Lets a sender with the wrong key believe that it has a session with the receiver's first start.
fn forger_hears(forger: &mut Sessions<[Session; 1]>) -> bool {
    let peers = [Session::new(IDS[1], key(3))];
    let mut accomplice = Sessions::new(IDS[0], BootEpoch(1), Trust::Keys { site: None, peers });
    let hello = accomplice.seal(Recipient::Device(IDS[1]), &hello()).unwrap();
    let mut heard = false;
    Deframer::new().feed(&hello, |result| heard |= forger.open(result.unwrap()).is_ok());
    heard
}

#[test]
fn every_bit_of_a_sealed_frame_is_checked() {
    // The CRC is made good again after each flip: only the MAC is left to notice.
    let mut sender = Device::new(1);
    let hello_of_receiver = Device::new(0).seal(&hello()).unwrap();
    sender.hear(&hello_of_receiver);
    let sealed = sender.seal(&numbered(5)).unwrap();
    let mut packet = sealed[1..sealed.len() - 1].to_vec();
    let length = cobs::decode_in_place(&mut packet).unwrap();
    let content = &packet[..length - 4];
    assert!(Device::new(0).hear(&sealed)[0].is_ok());
    for bit in 0..8 * content.len() {
        let mut flipped = content.to_vec();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let found = Device::new(0).hear(&crate::bytes::frame(&flipped, &[]));
        assert!(matches!(found[..], [Err(error)] if error != FrameError::Crc), "bit {bit}: {found:?}");
    }
}

#[test]
fn nothing_but_hello_is_said_to_who_was_not_heard() {
    let mut device = Device::new(0);
    assert_eq!(device.seal(&numbered(1)), Err(SealError::Unheard { peer: IDS[1] }));
    assert!(device.seal(&hello()).is_ok());
}

#[test]
fn only_an_answer_to_provisioning_goes_out_without_a_seal() {
    let mut device = Device::new(1);
    let of = Reference::Command(CommandId(5));
    assert!(device.sessions.seal(Recipient::Provisioner, &Message::Ack(Ack { of })).is_ok());
    assert!(device.sessions.seal(Recipient::Provisioner, &hello()).is_err());
}

#[test]
fn a_frame_for_another_device_with_the_same_key_is_not_believed() {
    // A pile has one key for the coordinator and whoever else reads the keys.
    let mut pile = Device::new(1);
    let told = pile.seal(&hello()).unwrap();
    let peers = [Session::new(IDS[1], key(1))];
    let mut other = Sessions::new(DeviceId::Pile(PileId(8)), BootEpoch(1), Trust::Keys { site: None, peers });
    let mut found = Vec::new();
    Deframer::new().feed(&told, |result| found.push(result.and_then(|packet| other.open(packet))));
    assert_eq!(found, [Err(FrameError::Unauthentic { sender: IDS[1] })]);
}

#[test]
fn who_runs_without_keys_says_that_a_frame_is_sealed() {
    let told = Device::new(1).seal(&hello()).unwrap();
    assert_eq!(crate::bytes::read(&told), [Err(FrameError::Sealed { sender: IDS[1] })]);
}

#[test]
fn a_key_is_never_shown() {
    let shown = format!("{:?} {:?}", Key::new([0xA5; 32]), Device::new(0).sessions);
    for secret in ["A5", "a5", "165", "[1, 1"] {
        assert!(!shown.contains(secret), "{shown}");
    }
}
