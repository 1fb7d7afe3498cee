//! Of a version that nobody here speaks, a `Hello` is understood and nothing else.

use proptest::prelude::*;
use protocol::{
    FrameError, Message,
    version::{self, Range, negotiate},
};

use crate::{
    bytes::{body, frame, header, read},
    strategies::message,
};

/// A version that this code does not speak.
fn foreign() -> impl Strategy<Value = u8> {
    any::<u8>().prop_filter("spoken", |&version| !version::OURS.contains(version))
}

/// A header's kind that names no device, or no seal.
fn unknown_kind() -> impl Strategy<Value = u8> {
    any::<u8>().prop_filter("known", |kind| kind & 0xC0 == 0xC0 || kind & 0x3F > 5)
}

proptest! {
    #[test]
    fn of_an_unknown_version_only_a_hello_is_understood(
        version in foreign(), message in message(), added in prop::collection::vec(any::<u8>(), 0..8),
    ) {
        let found = read(&frame(&header(version), &[body(&message), added].concat()));
        if matches!(message, Message::Hello(_)) {
            // Whatever that version has added behind.
            let frame = found[0].clone().unwrap();
            prop_assert_eq!((frame.header.version, frame.message), (version, message));
        } else {
            prop_assert_eq!(found, [Err(FrameError::Version { version })]);
        }
    }

    #[test]
    fn whatever_is_unknown_in_an_unknown_version_the_error_names_the_version(
        version in foreign(), kind in unknown_kind(), body in prop::collection::vec(any::<u8>(), 0..64),
    ) {
        let mut header = header(version);
        let no_hello = [&[1], &body[..]].concat();
        prop_assert_eq!(read(&frame(&header, &no_hello)), [Err(FrameError::Version { version })]);
        header[1] = kind;
        prop_assert_eq!(read(&frame(&header, &body)), [Err(FrameError::Version { version })]);
    }

    #[test]
    fn an_unknown_kind_of_device_is_an_error(kind in unknown_kind(), message in message()) {
        let mut header = header(version::CURRENT);
        header[1] = kind;
        prop_assert_eq!(read(&frame(&header, &body(&message))), [Err(FrameError::DeviceKind { kind })]);
    }

    #[test]
    fn two_sides_agree_on_the_newest_version_that_both_speak(a: (u8, u8), b: (u8, u8)) {
        let (a, b) = (Range { min: a.0, current: a.1 }, Range { min: b.0, current: b.1 });
        let newest = (0..=u8::MAX).rev().find(|&version| a.contains(version) && b.contains(version));
        prop_assert_eq!(negotiate(a, b).ok(), newest);
        prop_assert_eq!(negotiate(b, a).ok(), newest);
    }
}
