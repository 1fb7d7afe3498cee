//! Frames are found in any stream, in any portions, with anything between them.

use proptest::{prelude::*, sample::Index};
use protocol::{
    Deframer, DeviceId, Frame, FrameError, Header, Packet, PileId, Recipient, Sequence, Sessions, limits,
};

use crate::{
    bytes::{self, read},
    strategies::{dirt, frame, noise, places},
};

/// The frames among what was found.
fn frames(found: Vec<Result<Frame, FrameError>>) -> Vec<Frame> {
    found.into_iter().flatten().collect()
}

proptest! {
    #[test]
    fn every_frame_comes_back_as_it_was(frame in frame()) {
        let encoded = frame.encode().unwrap();
        prop_assert!(encoded.len() <= limits::FRAME);
        prop_assert_eq!(read(&encoded), [Ok(frame)]);
    }

    #[test]
    fn any_split_of_the_stream_finds_the_same(
        stream in prop::collection::vec(prop_oneof![
            frame().prop_map(|frame| frame.encode().unwrap().to_vec()),
            noise(),
        ], 0..5),
        cuts in places(),
    ) {
        let stream = stream.concat();
        let mut cuts: Vec<usize> = cuts.iter().map(|cut| cut.index(stream.len() + 1)).collect();
        cuts.extend([0, stream.len()]);
        cuts.sort_unstable();

        let mut deframer = Deframer::new();
        let mut found = Vec::new();
        for portion in cuts.windows(2) {
            found.extend(bytes::feed(&mut deframer, &stream[portion[0]..portion[1]]));
        }
        prop_assert_eq!(found, read(&stream));
    }

    #[test]
    fn noise_before_between_and_after_frames_costs_none_of_them(
        sent in prop::collection::vec(frame(), 1..4),
        noise in prop::collection::vec(noise(), 5),
    ) {
        let mut stream = noise[0].clone();
        for (frame, noise) in sent.iter().zip(&noise[1..]) {
            stream.extend(frame.encode().unwrap());
            stream.extend(noise);
        }
        prop_assert_eq!(frames(read(&stream)), sent);
    }

    #[test]
    fn noise_inside_a_frame_costs_that_frame_only(
        hit in frame(), next in frame(), at: Index, noise in noise().prop_filter("no noise", |noise| !noise.is_empty()),
    ) {
        let mut stream = hit.encode().unwrap().to_vec();
        // Between its delimiters; a delimiter more at an end is no damage.
        let at = 2 + at.index(stream.len() - 3);
        stream.splice(at..at, noise);
        stream.extend(next.encode().unwrap());
        prop_assert_eq!(frames(read(&stream)), [next]);
    }

    #[test]
    fn a_frame_cut_short_anywhere_costs_that_frame_only(hit in frame(), next in frame(), at: Index) {
        let hit = hit.encode().unwrap();
        // Without its last delimiter alone it is whole: the next frame's delimiter ends it.
        let cut = &hit[..at.index(hit.len() - 1)];
        let stream = [cut, &next.encode().unwrap()].concat();
        prop_assert_eq!(frames(read(&stream)), [next.clone()]);

        let tail = &hit[1 + at.index(hit.len() - 1)..];
        // Without its first delimiter alone it is whole at the start of a stream.
        prop_assume!(tail.len() < hit.len() - 1);
        let stream = [tail, &next.encode().unwrap()].concat();
        prop_assert_eq!(frames(read(&stream)), [next]);
    }

    #[test]
    fn a_run_too_long_for_a_frame_is_one_error_and_its_tail_is_no_frame(
        dirt in dirt(), hidden in frame(), next in frame(),
    ) {
        // The tail of the run is a good frame, but for the delimiter before it.
        let run = [&vec![0xFF; limits::ENCODED + 1][..], &dirt, &hidden.encode().unwrap()[1..]].concat();
        let stream = [&run[..], &next.encode().unwrap()].concat();
        prop_assert_eq!(read(&stream), [Err(FrameError::Oversize), Ok(next)]);
    }

    #[test]
    fn no_bytes_panic_and_at_most_one_answer_comes_for_a_delimiter(noise in noise()) {
        let delimiters = noise.iter().filter(|&&byte| byte == 0).count();
        prop_assert!(read(&noise).len() <= delimiters);
    }

    #[test]
    fn no_bytes_between_delimiters_panic_even_if_they_hold_delimiters(mut noise in noise()) {
        let _ = Packet::decode(&mut noise);
    }

    #[test]
    fn no_body_panics(body in noise()) {
        let read = read(&bytes::frame(&bytes::header(1), &body));
        prop_assert_eq!(read.len(), 1);
    }

    #[test]
    fn a_sender_numbers_its_frames_from_zero(sent in prop::collection::vec(frame(), 1..4)) {
        let Header { sender, boot, .. } = sent[0].header;
        let mut sessions = Sessions::insecure(sender, boot);
        let to = Recipient::Device(DeviceId::Pile(PileId(7)));
        for (frame, number) in sent.into_iter().zip(0..) {
            let header = Header::new(sender, boot, Sequence(number));
            let bytes = sessions.seal(to, &frame.message).unwrap();
            prop_assert_eq!(read(&bytes), [Ok(Frame { header, ..frame })]);
        }
    }
}

#[test]
fn the_longest_run_that_can_be_a_frame_is_not_oversize() {
    let run = |length| [&vec![0x01; length][..], &[0]].concat();
    assert_eq!(read(&run(limits::ENCODED)), [Err(FrameError::Crc)]);
    assert_eq!(read(&run(limits::ENCODED + 1)), [Err(FrameError::Oversize)]);
}

#[test]
fn any_number_of_delimiters_is_silence() {
    assert_eq!(read(&[0; 1000]), []);
}
