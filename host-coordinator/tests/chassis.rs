//! `chargehand chassis` as a person starts it, against the real chassis core on a model of its
//! robot, behind a TCP socket or a serial port.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::{
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::{SocketAddr, TcpListener},
    path::Path,
    process::{Child, Command, Output, Stdio},
    sync::mpsc::Receiver,
    thread,
};

use host_coordinator::chassis::recording::Speeds;
use proptest::prelude::*;
use protocol::{
    BootEpoch, ChassisMode, Deframer, DeviceId, Epoch, Hello, Message, PileId, Recipient, Sessions,
    StopReason,
};
use serde_json::Value;

#[path = "chassis/robot.rs"]
mod robot;

use robot::{ROBOT, Told, at_socket};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chargehand"));
    command.arg("chassis").args(arguments).stdin(Stdio::null());
    command
}

fn at(address: SocketAddr, arguments: &[&str]) -> Command {
    let mut command = command(&["--addr", &address.to_string()]);
    command.args(arguments);
    command
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document on standard output")
}

fn refusal(mut command: Command) -> String {
    let output = command.output().unwrap();
    assert!(!output.status.success());
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_drive_reaches_its_speed_stops_and_is_plotted_from_its_recording() {
    let (address, _told) = at_socket();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("step.mcap");
    let recording = ["--record", file.to_str().unwrap()];
    let drive =
        at(address, &["drive", "--vx", "0.5", "--for", "1s", "--json"]).args(recording).output().unwrap();
    let report = json(&drive);
    assert_eq!(
        (&report["robot"], &report["mode"], &report["stop"]),
        (&7.into(), &"Braked".into(), &"Commanded".into())
    );
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&report["reached"]["vx"]) - 0.5).abs() < 0.02, "{report}");
    // The ramp of 1 m/s² takes off at the start what it adds at the end: 0.5 m/s for 1 s.
    assert!((number(&report["moved"]["x_m"]) - 0.5).abs() < 0.08, "{report}");
    assert!(number(&report["moved"]["y_m"]).abs() < 0.02, "{report}");
    assert!(number(&report["done"]) >= 10.0, "{report}");

    let speeds = Speeds::read(&std::fs::read(&file).unwrap()).unwrap();
    let fastest = |samples: &[host_coordinator::chassis::recording::Sample]| {
        samples.iter().map(|sample| sample.twist.vx.get()).fold(0.0, f32::max)
    };
    for samples in [&speeds.commanded, &speeds.ramped, &speeds.measured] {
        assert!((fastest(samples) - 0.5).abs() < 0.02);
        assert!(
            samples.windows(2).all(|pair| pair[0].at_s < pair[1].at_s),
            "the chassis' clock has no jitter"
        );
    }
    let picture = folder.path().join("step.png");
    let plot = json(&command(&["plot", file.to_str().unwrap(), "--json"]).output().unwrap());
    assert_eq!(plot["samples"], speeds.measured.len());
    assert_eq!(size_of_png(&picture), (1_200, 1_080));
    if let Ok(keep) = std::env::var("CHASSIS_PLOT") {
        std::fs::copy(&picture, keep).unwrap();
    }
}

fn size_of_png(file: &Path) -> (u32, u32) {
    let reader = png::Decoder::new(BufReader::new(std::fs::File::open(file).unwrap())).read_info().unwrap();
    reader.info().size()
}

#[test]
fn what_the_chassis_refuses_is_refused_with_its_reason() {
    let (address, told) = at_socket();
    let error = refusal(at(address, &["drive", "--vx", "5", "--for", "1s"]));
    assert!(error.contains("robot 7 refuses") && error.contains("vx is beyond its limit"), "{error}");
    assert!(told.try_iter().all(|told| told.mode == ChassisMode::Braked));
    // Beyond the wire's own range, and no number: refused here.
    for vx in ["11", "NaN", "fast"] {
        assert!(refusal(at(address, &["drive", "--vx", vx])).contains("--vx"));
    }
}

/// Starts to drive forward at 0.5 m/s and waits until the chassis does.
fn driving(mut command: Command, told: &Receiver<Told>) -> Child {
    let driver = command.args(["drive", "--vx", "0.5", "--json"]).stdout(Stdio::piped()).spawn().unwrap();
    let moving = told.iter().find(|told| told.forward_mps > 0.49).unwrap();
    assert_eq!((moving.mode, moving.stop), (ChassisMode::Driving, None));
    driver
}

/// The ticks until the chassis is braked, and why it is.
fn braked(told: &Receiver<Told>) -> (Vec<Told>, Option<StopReason>) {
    let mut ticks = Vec::new();
    for told in told.iter().take(300) {
        let (mode, stop) = (told.mode, told.stop);
        ticks.push(told);
        if mode == ChassisMode::Braked {
            return (ticks, stop);
        }
    }
    panic!("it does not stop within 3 s");
}

#[cfg(unix)]
fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

#[test]
fn a_driver_that_dies_mid_drive_leaves_a_chassis_that_stops() {
    let (address, told) = at_socket();
    let mut driver = driving(at(address, &[]), &told);
    driver.kill().unwrap();
    driver.wait().unwrap();
    assert_eq!(braked(&told).1, Some(StopReason::LinkSilent));
    assert!(told.iter().nth(100).unwrap().forward_mps.abs() < 0.01);
}

#[test]
#[cfg(unix)]
fn ctrl_c_ramps_a_drive_to_a_stop_and_reports_it() {
    let (address, told) = at_socket();
    let driver = driving(at(address, &[]), &told);
    interrupt(&driver);
    let (ticks, stop) = braked(&told);
    assert_eq!(stop, Some(StopReason::Commanded));
    // 0.5 m/s at 1 m/s².
    let ramped = ticks.iter().filter(|told| told.mode == ChassisMode::Stopping).count();
    assert!((45..=55).contains(&ramped), "{ramped} ticks");
    let report = json(&driver.wait_with_output().unwrap());
    assert_eq!((&report["mode"], &report["stop"]), (&"Braked".into(), &"Commanded".into()));
    assert!((report["reached"]["vx"].as_f64().unwrap() - 0.5).abs() < 0.02, "{report}");
}

#[test]
fn an_emergency_stop_brakes_a_moving_chassis_and_holds_it_until_it_is_released() {
    let (address, told) = at_socket();
    let mut driver = driving(at(address, &[]), &told);
    // The line is the newest caller's.
    let report = json(&at(address, &["stop", "--emergency", "--json"]).output().unwrap());
    assert_eq!((&report["mode"], &report["stop"]), (&"Braked".into(), &"Emergency".into()));
    assert!(told.iter().take(100).any(|told| told.stop == Some(StopReason::Emergency)));
    assert!(!driver.wait().unwrap().success(), "its line is gone");

    let stands = |told: &Told| told.forward_mps.abs() < 0.001;
    assert!(told.iter().take(100).any(|told| stands(&told)), "it stands within 1 s");
    let drive = ["drive", "--vx", "0.1", "--for", "0.2s"];
    let error = refusal(at(address, &drive));
    assert!(error.contains("held stopped because of an emergency stop"), "{error}");
    assert_eq!(json(&at(address, &["release", "--json"]).output().unwrap())["done"], 1);
    assert!(at(address, &drive).output().unwrap().status.success());
}

#[test]
#[cfg(unix)]
fn a_chassis_at_a_serial_port_is_driven_and_stopped_as_one_in_the_network() {
    let (port, _cable, told) = robot::at_port();
    let at_port = |arguments: &[&str]| {
        let mut command = command(&["--port", port.to_str().unwrap()]);
        command.args(arguments);
        command
    };
    let driver = driving(at_port(&[]), &told);
    interrupt(&driver);
    let report = json(&driver.wait_with_output().unwrap());
    assert_eq!(
        (&report["robot"], &report["mode"], &report["stop"]),
        (&7.into(), &"Braked".into(), &"Commanded".into())
    );
    assert!(report["moved"]["x_m"].as_f64().unwrap() > 0.2, "{report}");
    let report = json(&at_port(&["stop", "--emergency", "--json"]).output().unwrap());
    assert_eq!(report["stop"], "Emergency");
}

#[test]
fn a_chassis_that_hangs_up_mid_drive_is_told_with_what_it_does_now() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let hang_up = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(&hello(DeviceId::Chassis(ROBOT), 1)).unwrap();
        let mut sessions = Sessions::insecure(DeviceId::Chassis(ROBOT), BootEpoch(1));
        let mut deframer = Deframer::new();
        let mut buffer = [0; 512];
        let mut drives = 0;
        while drives < 2 {
            let length = stream.read(&mut buffer).unwrap();
            deframer.feed(&buffer[..length], |found| {
                let frame = sessions.open(found.unwrap()).unwrap();
                drives += usize::from(matches!(frame.message, Message::Drive(_)));
            });
        }
    });
    let error = refusal(at(address, &["drive", "--vx", "0.5"]));
    assert!(error.contains("lost") && error.contains("by itself within 200 ms"), "{error}");
    hang_up.join().unwrap();
}

fn hello(sender: DeviceId, version: u8) -> Vec<u8> {
    let hello = Hello { min: version, current: version, software: [0; 3], epoch: Epoch(0) };
    let computer = Recipient::Device(DeviceId::Robot(ROBOT));
    let mut sessions = Sessions::insecure(sender, BootEpoch(1));
    sessions.seal(computer, &Message::Hello(hello)).unwrap().to_vec()
}

/// Says this to the first caller and keeps its line open until it hangs up.
fn answering(bytes: Vec<u8>) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(&bytes).unwrap();
        // Ends when the caller hangs up, however it does so.
        let _ = stream.read_to_end(&mut Vec::new());
    });
    address
}

#[test]
fn who_is_no_chassis_is_named_and_what_to_do_about_it() {
    let at_pile = answering(hello(DeviceId::Pile(PileId(3)), 1));
    let too_new = answering(hello(DeviceId::Chassis(ROBOT), 9));
    let silent = answering(Vec::new());
    let noise = answering(vec![0xA5, 0x5A, 0, 1, 2, 3, 0]);
    let cases = [
        (at_pile, "the line of pile 3, not of a chassis"),
        (too_new, "no common protocol version"),
        (silent, "nothing was heard"),
        (noise, "cannot be read"),
    ];
    for (address, expected) in cases {
        let error = refusal(at(address, &["watch"]));
        assert!(error.contains(expected), "{error}");
        assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    }
    let error = refusal(command(&["--port", "/nowhere/tty", "stop"]));
    assert!(error.contains("/nowhere/tty"), "{error}");
    assert!(refusal(command(&["watch"])).contains("--port PATH or --addr HOST:PORT"));
}

#[test]
#[cfg(unix)]
fn watch_tells_every_report_and_record_keeps_it_until_ctrl_c() {
    let (address, told) = at_socket();
    let mut watch = at(address, &["watch", "--json"]).stdout(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(watch.stdout.take().unwrap()).lines().take(30);
    let reports: Vec<Value> = lines.map(|line| serde_json::from_str(&line.unwrap()).unwrap()).collect();
    assert!(reports.iter().any(|report| report["odometry"]["measured"]["vx"].is_number()));
    watch.kill().unwrap();
    watch.wait().unwrap();
    let before = told.try_iter().last().unwrap().frames;

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rest.mcap");
    let record =
        at(address, &["record", file.to_str().unwrap(), "--json"]).stdout(Stdio::piped()).spawn().unwrap();
    // What it says answers what it has heard, and by then Ctrl-C is its to handle.
    assert!(told.iter().any(|told| told.frames > before));
    assert!(told.iter().nth(50).is_some());
    interrupt(&record);
    assert_eq!(json(&record.wait_with_output().unwrap())["robot"], 7);
    assert!(!Speeds::read(&std::fs::read(&file).unwrap()).unwrap().measured.is_empty());
    let stop = json(&at(address, &["stop", "--json"]).output().unwrap());
    assert_eq!(stop["mode"], "Braked");
    let released = json(&at(address, &["release", "--json"]).output().unwrap());
    assert_eq!(released["done"], 1);
}

fn recording() -> Vec<u8> {
    let (address, _told) = at_socket();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("short.mcap");
    let drive = ["drive", "--wz", "1", "--for", "0.1s", "--record", file.to_str().unwrap()];
    assert!(at(address, &drive).output().unwrap().status.success());
    std::fs::read(file).unwrap()
}

#[test]
fn a_damaged_recording_is_refused_and_never_a_panic() {
    let whole = recording();
    let speeds = Speeds::read(&whole).unwrap();
    proptest!(ProptestConfig::with_cases(256), |(
        cut in 0..whole.len(),
        changes in proptest::collection::vec((0..whole.len(), any::<u8>()), 0..8),
    )| {
        prop_assert!(Speeds::read(&whole[..cut]).is_err());
        let mut changed = whole.clone();
        for (place, byte) in changes {
            changed[place] = byte;
        }
        // Its checks catch nearly every change; what they let through must not break the reader.
        let _ = Speeds::read(&changed);
    });
    assert!(!speeds.measured.is_empty());
    // Every length in it once claims more than there is.
    let mut changed = whole.clone();
    for (place, &byte) in whole.iter().enumerate() {
        changed[place] = byte ^ 0x20;
        let _ = Speeds::read(&changed);
        changed[place] = byte;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("cut.mcap");
    std::fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    let error = refusal(command(&["plot", file.to_str().unwrap()]));
    assert!(error.contains("cut.mcap") && error.contains("mcap recover"), "{error}");
}
