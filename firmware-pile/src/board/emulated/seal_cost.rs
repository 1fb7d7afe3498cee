//! What it costs the ARM core to seal and to open a frame, whole: encoding, MAC, CRC and COBS, and back.
//!
//! The log says it at every start; under `-icount shift=0` an instruction takes one nanosecond, 0.168 of
//! a cycle, and the number is the same in every run. The same frames without a seal say what of it the
//! MAC costs.

use cortex_m::peripheral::SYST;
use firmware_common::emulated::elapsed_cycles;
use protocol::{
    Availability, BootEpoch, CommandHead, CommandId, Deframer, DeviceId, DurationMs, EnergyJ, Epoch,
    Fraction, Frame, Grant, Hello, Key, LeaseId, LeaseRef, Message, PileId, PileRow, PileTable, Recipient,
    RobotId, Session, Sessions, SiteMillis, TagId, Trust, limits,
};

const PILE: DeviceId = DeviceId::Pile(PileId(1));

/// Instructions.
struct Cost {
    seal: u32,
    open: u32,
}

/// Logs what a [`Grant`] and the largest frame cost, with a seal and without.
pub fn log() {
    let key = Key::new([7; 32]);
    let trust = |peer| Trust::Keys { site: Some(key), peers: [Session::new(peer, key)] };
    let mut coordinator = Sessions::new(DeviceId::Coordinator, BootEpoch(1), trust(PILE));
    let mut pile = Sessions::new(PILE, BootEpoch(1), trust(DeviceId::Coordinator));
    let mut plain = Sessions::insecure(DeviceId::Coordinator, BootEpoch(1));
    // The coordinator has to know the pile's start before it can say anything else.
    let hello = Message::Hello(Hello::new(Epoch(0)));
    measure(&mut pile, &mut coordinator, Recipient::Device(DeviceId::Coordinator), &hello);

    for (name, message) in [("grant", grant()), ("largest", table())] {
        let to = Recipient::Device(PILE);
        let sealed = measure(&mut coordinator, &mut pile, to, &message);
        let mut listener = Sessions::insecure(PILE, BootEpoch(1));
        let bare = measure(&mut plain, &mut listener, to, &message);
        if let (Some(sealed), Some(bare)) = (sealed, bare) {
            defmt::info!(
                "cost of a frame: {=str} seal {} open {} without a seal {} {}",
                name,
                sealed.seal,
                sealed.open,
                bare.seal,
                bare.open
            );
        }
    }
}

/// Seals a message on one side and opens it on the other.
fn measure<A: AsMut<[Session]>, B: AsMut<[Session]>>(
    from: &mut Sessions<A>,
    at: &mut Sessions<B>,
    to: Recipient,
    message: &Message,
) -> Option<Cost> {
    let (seal, bytes) = priced(|| from.seal(to, message));
    let bytes = bytes.ok()?;
    let mut deframer = Deframer::new();
    let (open, frame) = priced(|| {
        let mut opened: Option<Frame> = None;
        deframer.feed(&bytes, |found| opened = found.and_then(|packet| at.open(packet)).ok());
        opened
    });
    // What was measured is what is done: the message has arrived.
    (frame?.message == *message).then_some(Cost { seal, open })
}

/// The result of `work`, and its instructions.
fn priced<T>(work: impl FnOnce() -> T) -> (u32, T) {
    let start = SYST::get_current();
    let done = work();
    (elapsed_cycles(start).saturating_mul(1_000) / 168, done)
}

fn grant() -> Message {
    Message::Grant(Grant {
        head: CommandHead { id: CommandId(u32::MAX), valid_until: SiteMillis::MAX },
        lease: LeaseRef { epoch: Epoch(u32::MAX), lease: LeaseId(u32::MAX), robot: RobotId(u16::MAX) },
        tag: TagId([0xFF; 12]),
        expiry: SiteMillis::MAX,
        energy: EnergyJ::MAX,
    })
}

/// A full part of the pile table, which is the largest message.
fn table() -> Message {
    let row = PileRow {
        pile: PileId(u16::MAX),
        boot: BootEpoch(u32::MAX),
        version: u32::MAX,
        stamp: Some(SiteMillis::MAX),
        availability: Availability::Fault,
        remaining: Fraction::MAX,
        planned: DurationMs::MAX,
    };
    Message::PileTable(PileTable { rows: core::iter::repeat_n(row, limits::ROWS_PER_TABLE).collect() })
}
