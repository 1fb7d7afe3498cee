//! `chargehand pile` as a person starts it, against the real pile core with a modelled charger,
//! behind a TCP socket.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::{
    io::{self, BufRead as _, BufReader, Read as _, Write as _},
    net::{SocketAddr, TcpListener, TcpStream},
    path::Path,
    process::{Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

use firmware_pile::{
    ChargingPile, Input, Parameters, TagRead,
    faults::FaultSet,
    plant::{Battery, Plant},
};
use host_coordinator::keys::Keys;
use protocol::{
    BootEpoch, Deframer, DeviceId, FaultCode, Frame, FrameError, Key, Millis, PileId, Session, Sessions,
    TagId, Trust,
};
use serde_json::Value;

const PILE: PileId = PileId(3);
const TAG: TagId = TagId(*b"robot no. 03");

type Pile = Sessions<Vec<Session>>;

fn sessions(trust: Trust<Vec<Session>>) -> Pile {
    Sessions::new(DeviceId::Pile(PILE), BootEpoch(5), trust)
}

/// As a pile that was provisioned with these keys.
fn provisioned(device: Key, site: Key) -> Pile {
    let peers = [DeviceId::Coordinator, DeviceId::Service].map(|peer| Session::new(peer, device));
    sessions(Trust::Keys { site: Some(site), peers: peers.into() })
}

/// A pile in real time behind a socket that takes one caller after the other. `broken` is done to its
/// charger at the start, and it begins with these faults latched.
fn pile(mut sessions: Pile, latched: FaultSet, broken: impl Fn(&mut Plant)) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    listener.set_nonblocking(true).unwrap();
    let mut plant = Plant::new();
    plant.battery = Some(Battery::new(1.0e6, 0.5e6));
    broken(&mut plant);
    thread::spawn(move || {
        let mut pile = ChargingPile::new(Parameters { latched, ..Parameters::new(PILE, 500.0) });
        let mut line: Option<(TcpStream, Deframer)> = None;
        let start = Instant::now();
        for tick in 1.. {
            let now = Millis(tick * 10);
            thread::sleep((start + Duration::from_millis(now.0)).saturating_duration_since(Instant::now()));
            if let Ok((stream, _)) = listener.accept() {
                stream.set_nonblocking(true).unwrap();
                stream.set_nodelay(true).unwrap();
                line = Some((stream, Deframer::new()));
            }
            let heard = heard(&mut line, &mut sessions);
            let mut inputs: Vec<_> = heard
                .iter()
                .map(|found| match found {
                    Ok(frame) => Input::Frame(frame),
                    Err(error) => Input::Discarded(*error),
                })
                .collect();
            if tick % 20 == 0 {
                inputs.push(Input::Tag(TagRead { tag: TAG, rssi_dbm: -50 }));
            }
            inputs.push(Input::Sensors(plant.sense(now)));
            for input in inputs {
                let outputs = pile.step(now, input);
                plant.command(outputs.power);
                for outgoing in outputs.messages {
                    // Who was not heard yet is told nothing but Hello.
                    let Ok(bytes) = sessions.seal(outgoing.to.into(), &outgoing.message) else { continue };
                    if let Some((stream, _)) = &mut line {
                        // A caller that hung up misses it.
                        let _ = stream.write_all(&bytes);
                    }
                }
            }
        }
    });
    address
}

fn heard(line: &mut Option<(TcpStream, Deframer)>, sessions: &mut Pile) -> Vec<Result<Frame, FrameError>> {
    let mut frames = Vec::new();
    let mut buffer = [0; 1024];
    while let Some((stream, deframer)) = line {
        match stream.read(&mut buffer) {
            Ok(length @ 1..) => deframer.feed(&buffer[..length], |found| {
                frames.push(found.and_then(|packet| sessions.open(packet)));
            }),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
            Ok(0) | Err(_) => *line = None,
        }
    }
    frames
}

/// A site's folder with keys of three piles, and the keys of [`PILE`] and the site.
fn site() -> (tempfile::TempDir, Key, Key) {
    let folder = tempfile::tempdir().unwrap();
    let keys = Keys::change(&folder.path().join("keys.toml"), |keys| {
        keys.make(DeviceId::Pile(PileId(1)))?;
        keys.make(DeviceId::Pile(PileId(9)))?;
        Ok((keys.make(DeviceId::Pile(PILE))?, keys.make_site()?))
    });
    let (device, site) = keys.unwrap();
    (folder, device, site)
}

fn chargehand(address: SocketAddr, site: Option<&Path>, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chargehand"));
    command.args(["pile", "--addr", &address.to_string()]).args(arguments).stdin(Stdio::null());
    match site {
        Some(site) => command.arg("--site").arg(site),
        None => command.arg("--insecure"),
    };
    command
}

fn json(mut command: Command) -> Value {
    let output = command.arg("--json").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document on standard output")
}

fn text(mut command: Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refusal(mut command: Command) -> (i32, String) {
    let Output { status, stdout, stderr } = command.output().unwrap();
    assert!(stdout.is_empty());
    (status.code().unwrap(), String::from_utf8(stderr).unwrap())
}

#[test]
fn a_pile_with_keys_is_asked_everything_in_one_second_after_another() {
    let (folder, device, site) = site();
    let address = pile(provisioned(device, site), FaultSet::EMPTY, |_| {});
    let ask = |what| json(chargehand(address, Some(folder.path()), &[what]));
    let status = ask("status");
    assert_eq!(status["pile"], 3);
    // Before and after its reader has seen the robot that stands there.
    let availability = status["state"]["availability"].as_str();
    assert!(matches!(availability, Some("free" | "done")), "{status}");
    let volts = status["readings"]["voltage_v"].as_f64().unwrap();
    assert!((20.0..30.0).contains(&volts), "{status}");
    assert_eq!(status["readings"]["contactor_closed"], false);
    assert_eq!(status["parameters"]["power_w"], 500.0);
    assert_eq!(ask("faults")["faults"], Value::Array(Vec::new()));
    assert_eq!(ask("table")["table"][0]["pile"], 3);
    let passes = ask("passes");
    assert_eq!(passes["passes"][0]["tag"], TAG.to_string(), "{passes}");
    assert_eq!(passes["passes"][0]["period"], Value::Null, "nobody told it the time");
    let told = text(chargehand(address, Some(folder.path()), &["status"]));
    assert!(told.contains("pile            3, ") && told.contains(" V\n"), "{told}");
    assert!(!told.contains('\x1b'), "colours are for terminals");
}

#[test]
fn a_latched_fault_is_explained_and_cleared_and_one_whose_cause_is_there_is_refused() {
    let latched = FaultSet::of(&[FaultCode::OverTemperature, FaultCode::OverCurrent]);
    let address = pile(sessions(Trust::Insecure), latched, |plant| plant.ambient_c = 100.0);
    let told = text(chargehand(address, None, &["faults"]));
    let clear = format!("chargehand pile --addr {address} --insecure clear-fault over_current");
    assert!(told.contains(&clear) && told.contains("dirt and wear on the contacts"), "{told}");

    let cleared = json(chargehand(address, None, &["clear-fault", "over-current"]));
    assert_eq!(cleared["cleared"], "over_current");
    let left: Vec<_> = cleared["faults"].as_array().unwrap().iter().map(|fault| &fault["code"]).collect();
    assert_eq!(left, ["over_temperature"]);
    // At once after it: another command, not a repeat.
    let (code, error) = refusal(chargehand(address, None, &["clear-fault", "over_temperature"]));
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("pile 3 refuses to clear over_temperature: its cause is still there"), "{error}");
}

#[test]
fn a_pile_and_keys_that_do_not_fit_are_told_apart() {
    let (folder, device, site_key) = site();
    let with = Some(folder.path());
    let other = Key::new([7; 32]);
    let secure = pile(provisioned(device, site_key), FaultSet::EMPTY, |_| {});
    let foreign = pile(provisioned(other, other), FaultSet::EMPTY, |_| {});
    let insecure = pile(sessions(Trust::Insecure), FaultSet::EMPTY, |_| {});
    let cases = [
        (secure, None, "believes only who has its key: name its site with --site DIR"),
        (insecure, with, "speak with it with --insecure"),
        (foreign, with, "do not fit together"),
    ];
    for (address, site, expected) in cases {
        let (code, error) = refusal(chargehand(address, site, &["status"]));
        assert_eq!(code, 1);
        assert!(error.contains(expected), "{error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    }
    let (code, error) = refusal(chargehand(secure, with, &["clear-fault", "nonsense"]));
    assert!(code == 2 && error.contains("contactor_welded"), "{error}");
}

#[test]
fn watch_tells_a_line_for_each_look_until_ctrl_c() {
    let address = pile(sessions(Trust::Insecure), FaultSet::EMPTY, |_| {});
    let mut watch = chargehand(address, None, &["watch", "--json"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(watch.stdout.take().unwrap()).lines();
    for _ in 0..3 {
        let look: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
        assert!(look["readings"]["temperature_c"].is_number() && look["faults"].is_array(), "{look}");
    }
    let sent = Command::new("kill").args(["-INT", &watch.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert!(watch.wait().unwrap().success());
}
