//! The computed sizes are exact, and the printed ones are the computed ones.

use protocol::{
    BootEpoch, Deframer, DeviceId, DurationMs, Frame, Header, Millis, RobotId, Sequence, SiteMillis, limits,
    version,
};

use crate::{bytes, largest};

const PAGES: [&str; 2] = [include_str!("../../src/lib.rs"), include_str!("../../../docs/protocol.md")];

#[test]
fn the_largest_value_of_every_message_has_exactly_the_computed_size() {
    for (message, name, max_size) in largest::messages() {
        assert_eq!(bytes::body(&message).len(), 1 + max_size, "{name}, with its ordinal");
    }
}

#[test]
fn the_largest_message_fits_a_frame_whatever_its_header() {
    let header = Header {
        version: version::CURRENT,
        sender: DeviceId::Robot(RobotId(u16::MAX)),
        boot: BootEpoch(u32::MAX),
        sequence: Sequence(u32::MAX),
    };
    for (message, name, _) in largest::messages() {
        let frame = Frame { header, message };
        let encoded = frame.encode().unwrap();
        assert_eq!(bytes::read(&encoded), [Ok(frame)], "{name}");
    }
}

#[test]
fn no_packet_is_longer_than_a_frame_after_cobs() {
    // Packets without zeros grow the most.
    let longest = (0..=limits::PACKET).map(|length| bytes::wire(&vec![0xFF; length]).len()).max();
    assert_eq!(longest, Some(limits::FRAME));
}

#[test]
fn the_docs_print_the_computed_sizes() {
    let sizes = largest::messages().map(|(_, name, max_size)| (format!("`{name}`"), 1 + max_size));
    let parts = [
        ("header", limits::HEADER),
        ("largest body", limits::BODY),
        ("MAC", limits::MAC),
        ("check", limits::CHECK),
        ("largest packet", limits::PACKET),
        ("largest frame", limits::FRAME),
    ]
    .map(|(part, size)| (part.to_owned(), size));
    for (name, size) in sizes.into_iter().chain(parts) {
        let line = format!("| {name} | {size} |");
        for page in PAGES {
            assert!(page.contains(&line), "a page lacks the line: {line}");
        }
    }
}

#[test]
fn the_book_prints_the_intervals_and_ranges() {
    let book = PAGES[1];
    for (name, interval) in [
        ("REPEAT_INTERVAL", limits::REPEAT_INTERVAL),
        ("STATE_INTERVAL", limits::STATE_INTERVAL),
        ("SILENCE", limits::SILENCE),
    ] {
        assert!(book.contains(&format!("| `{name}` | {interval} |")), "{name}");
    }
    for (name, max) in [
        ("device time", Millis::MAX.0),
        ("site time", SiteMillis::MAX.0),
        ("duration", DurationMs::MAX.0.into()),
    ] {
        let line = book.lines().find(|line| line.starts_with(&format!("| {name} |"))).unwrap();
        assert!(line.contains(&format!("0 to {max} ms")), "{line}");
    }
}

#[test]
fn a_deframer_is_one_frame_and_a_few_bytes() {
    assert!(size_of::<Deframer>() <= limits::ENCODED + 4 * size_of::<usize>());
}
