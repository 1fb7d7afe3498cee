//! `chargehand provision` over a real socket, with a board at its other end.
#![cfg(unix)]

use std::{
    fs,
    io::{Read as _, Write as _},
    net::{SocketAddr, TcpListener, TcpStream},
    os::unix::fs::PermissionsExt as _,
    path::Path,
    sync::{Arc, Mutex},
    thread,
};

use host_coordinator::keys::Keys;
use protocol::{
    Ack, BootEpoch, Deframer, DeviceId, Epoch, Frame, FrameError, Hello, Message, Nack, NackReason, PileId,
    Provision, Recipient, Reference, Session, Sessions, Trust,
};

use super::{Ran, chargehand, fig7_with, text};

/// A board, by the rules of the wire protocol.
#[derive(Default)]
struct Board {
    taken: Option<Provision>,
    boots: u32,
    button: bool,
    /// So many of its answers get lost.
    loses: u32,
}

impl Board {
    /// What it answers in its present start.
    fn hear(&mut self, found: Result<Frame, FrameError>) -> Vec<Vec<u8>> {
        let hello = Message::Hello(Hello::new(Epoch(0)));
        match found.map(|frame| frame.message) {
            Ok(Message::Provision(provision)) => {
                let of = Reference::Command(provision.command);
                let is_ours = self.taken.is_none_or(|taken| {
                    (taken.pile, taken.device_key, taken.site_key)
                        == (provision.pile, provision.device_key, provision.site_key)
                });
                let answer = if is_ours || self.button {
                    self.taken = Some(provision);
                    Message::Ack(Ack { of })
                } else {
                    Message::Nack(Nack { of, reason: NackReason::Provisioned })
                };
                let lost = self.loses > 0;
                self.loses = self.loses.saturating_sub(1);
                let answer = self.sessions().seal(Recipient::Provisioner, &answer).unwrap();
                if lost { Vec::new() } else { vec![answer.to_vec()] }
            }
            Ok(Message::Hello(_)) | Err(FrameError::Unsealed { .. }) => {
                vec![self.sessions().seal(Recipient::Device(DeviceId::Service), &hello).unwrap().to_vec()]
            }
            other => panic!("the tool said {other:?}"),
        }
    }

    /// Those of a new start: it restarts with every answer.
    fn sessions(&mut self) -> Sessions<Vec<Session>> {
        self.boots += 1;
        match &self.taken {
            None => Sessions::new(DeviceId::Factory, BootEpoch(self.boots), Trust::Insecure),
            Some(Provision { pile, device_key, site_key, boot_floor, .. }) => {
                let peers = vec![Session::new(DeviceId::Service, *device_key)];
                let trust = Trust::Keys { site: Some(*site_key), peers };
                Sessions::new(DeviceId::Pile(*pile), BootEpoch(boot_floor.0 + self.boots), trust)
            }
        }
    }
}

/// The board at a socket that takes one caller after the other.
fn serve(board: Board) -> (SocketAddr, Arc<Mutex<Board>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let board = Arc::new(Mutex::new(board));
    let served = Arc::clone(&board);
    thread::spawn(move || {
        while let Ok((stream, _)) = listener.accept() {
            converse(stream, &served);
        }
    });
    (address, board)
}

fn converse(mut stream: TcpStream, board: &Mutex<Board>) {
    let mut deframer = Deframer::new();
    let mut buffer = [0; 512];
    while let Ok(length @ 1..) = stream.read(&mut buffer) {
        let mut answers = Vec::new();
        deframer.feed(&buffer[..length], |found| {
            let mut board = board.lock().unwrap();
            let opened = found.and_then(|packet| board.sessions().open(packet));
            answers.extend(board.hear(opened));
        });
        for answer in answers {
            // A caller who has what it wants hangs up.
            let _ = stream.write_all(&answer);
        }
    }
}

fn provision(site: &Path, address: SocketAddr, id: &str) -> Ran {
    chargehand(&["provision", "--addr", &address.to_string(), "--id", id, "--site", text(site)])
}

#[test]
fn a_fresh_board_becomes_a_pile_with_the_key_that_the_site_keeps() {
    let site = fig7_with("site.toml", "", "");
    let file = site.path().join("keys.toml");
    fs::remove_file(&file).unwrap();
    let (address, board) = serve(Board::default());
    let said = provision(site.path(), address, "7").succeeds();
    assert!(said.contains("the board is pile 7 of \"LMPP Fig. 7\" now"), "{said}");

    let taken = board.lock().unwrap().taken.unwrap();
    let mut keys = Keys::load(&file).unwrap();
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    assert_eq!(Some(taken.device_key), keys.of(DeviceId::Pile(PileId(7))));
    assert_eq!(taken.site_key, keys.make_site().unwrap());
    assert_ne!(taken.device_key, taken.site_key);
    assert_eq!((taken.pile, taken.parameters.power.get()), (PileId(7), 500.0));
    assert!(taken.boot_floor.0 > 1_700_000_000, "a board that replaces another must be newer");
    for secret in fs::read_to_string(&file).unwrap().split('"').filter(|part| part.len() == 64) {
        assert!(!said.contains(secret), "{said}");
    }
}

#[test]
fn a_lost_answer_neither_bricks_a_board_nor_gives_it_another_key() {
    let site = fig7_with("site.toml", "", "");
    let (address, board) = serve(Board { loses: 2, ..Board::default() });
    provision(site.path(), address, "7").succeeds();
    let first = board.lock().unwrap().taken.unwrap();
    // The same again: the board has it, and says so.
    provision(site.path(), address, "7").succeeds();
    let again = board.lock().unwrap().taken.unwrap();
    assert_eq!((again.device_key, again.site_key), (first.device_key, first.site_key));
}

#[test]
fn a_board_with_an_identity_is_refused_unless_its_button_is_held() {
    let (ours, other) = (fig7_with("site.toml", "", ""), fig7_with("site.toml", "", ""));
    let (address, board) = serve(Board::default());
    provision(ours.path(), address, "7").succeeds();
    let before = board.lock().unwrap().taken;
    for (site, id) in [(&other, "7"), (&ours, "8")] {
        let error = provision(site.path(), address, id).fails();
        assert!(error.contains("pile 7 already") && error.contains("hold its button"), "{error}");
        assert_eq!(board.lock().unwrap().taken, before);
    }
    board.lock().unwrap().button = true;
    provision(other.path(), address, "8").succeeds();
    assert_eq!(board.lock().unwrap().taken.unwrap().pile, PileId(8));
}

#[test]
fn a_pile_that_the_site_has_not_is_refused_before_anything_is_made_or_sent() {
    let site = fig7_with("site.toml", "", "");
    let file = site.path().join("keys.toml");
    fs::remove_file(&file).unwrap();
    let (address, board) = serve(Board::default());
    let error = provision(site.path(), address, "99").fails();
    assert!(error.contains("pile 99 is not in") && error.contains("add it there first"), "{error}");
    assert!(!file.exists() && board.lock().unwrap().boots == 0);
}
