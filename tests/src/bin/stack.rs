//! Of `cargo xtask size`: how deep the stack of each board's emulated image gets under every kind of
//! frame, noise and tags, as JSON.

use std::error::Error;
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use protocol::{
    Availability, BootEpoch, ClearFault, CommandHead, CommandId, Deframer, DeviceId, DurationMs, EnergyJ,
    Epoch, FaultCode, Fraction, Grant, Hello, LeaseId, LeaseRef, Message, PileId, PileRow, PileTable, Query,
    Recipient, Revoke, RobotId, Sessions, SiteMillis, TagId, TimeSync, Topic, limits,
};
use serde_json::json;
use tests::chassis_bench::{ChassisBench, twist};
use tests::emulator::{Emulator, Pace, Serial};
use tests::uhf_reader::UhfReader;

/// How long the pile is kept busy.
const TIME: Duration = Duration::from_secs(10);
/// Between two frames to the pile: no inbox is that quick.
const INTERVAL: Duration = Duration::from_millis(5);
/// How long the chassis drives, by its clock.
const DRIVE: DurationMs = DurationMs(5_000);
/// What the emulated board says when the stack was never as deep.
const SAID: &str = "stack: ";

const PILE: DeviceId = DeviceId::Pile(PileId(1));
const TAG: TagId = TagId(*b"robot no. 03");

fn main() -> ExitCode {
    match pile().and_then(|pile| Ok((pile, chassis()?))) {
        Ok((pile, chassis)) => {
            println!("{}", json!({ "firmware-pile": pile, "firmware-chassis": chassis }));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn chassis() -> Result<u32, Box<dyn Error>> {
    let mut bench = ChassisBench::boot_at(Pace::Hurried)?;
    for (vx, vy, wz) in [(0.5, 0.0, 0.0), (0.2, -0.1, 1.0)] {
        bench.drive_for(twist(vx, vy, wz)?, DRIVE)?;
        bench.transmit(&[0xA5; 300])?;
    }
    Ok(bench.costs()?.stack)
}

fn pile() -> Result<u32, Box<dyn Error>> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let reader = UhfReader::start()?;
    let mut board = Emulator::boot(Serial::Dial(listener.local_addr()?), Serial::Dial(reader.address()))?;
    let (mut link, _) = listener.accept()?;
    link.set_read_timeout(Some(INTERVAL))?;
    let mut coordinator = Sessions::insecure(DeviceId::Coordinator, BootEpoch(1));
    let mut deframer = Deframer::new();
    let started = Instant::now();
    let mut number = 0;
    while started.elapsed() < TIME {
        let site_now = SiteMillis(started.elapsed().as_millis() as u64);
        number += 1;
        if number % 40 == 0 {
            reader.clear();
        } else if number % 40 == 20 {
            reader.dock(TAG);
        }
        if number % 7 == 0 {
            link.write_all(&[0xA5; 300])?;
        }
        let frame = coordinator.seal(Recipient::Device(PILE), &message(number, site_now))?;
        link.write_all(&frame)?;
        answer(&mut link, &mut deframer, &mut coordinator, site_now)?;
        thread::sleep(INTERVAL);
    }
    let said = board.log().iter().rev().find_map(|line| line.split_once(SAID));
    let bytes = said.and_then(|(_, rest)| rest.split(' ').next()).and_then(|bytes| bytes.parse().ok());
    bytes.ok_or_else(|| format!("the pile said nothing of its stack: {:#?}", board.log()).into())
}

/// Tells the time to who asks.
fn answer(
    link: &mut TcpStream,
    deframer: &mut Deframer,
    coordinator: &mut Sessions,
    site_now: SiteMillis,
) -> Result<(), Box<dyn Error>> {
    let mut bytes = [0; 4096];
    let length = match link.read(&mut bytes) {
        Ok(length) => length,
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
        Err(error) => return Err(error.into()),
    };
    let mut asked = None;
    deframer.feed(bytes.get(..length).unwrap_or_default(), |packet| {
        if let Ok(Message::TimeRequest(request)) =
            packet.and_then(|packet| coordinator.open(packet)).map(|frame| frame.message)
        {
            asked = Some(request.asked_at);
        }
    });
    if let Some(asked_at) = asked {
        let told = Message::TimeSync(TimeSync { asked_at, site_now });
        link.write_all(&coordinator.seal(Recipient::Device(PILE), &told)?)?;
    }
    Ok(())
}

/// Every kind of message that a pile hears, one after the other.
fn message(number: u32, site_now: SiteMillis) -> Message {
    let later = site_now.after(DurationMs(60_000));
    let head = CommandHead { id: CommandId(number), valid_until: later };
    // Granted, and only later revoked.
    let lease = LeaseRef { epoch: Epoch(1), lease: LeaseId(number / 64), robot: RobotId(3) };
    match number % 8 {
        0 => Message::Hello(Hello::new(Epoch(1))),
        1 => Message::Grant(Grant { head, lease, tag: TAG, expiry: later, energy: EnergyJ::MIN }),
        2 => Message::PileTable(PileTable { rows: (0..limits::ROWS_PER_TABLE).map(row).collect() }),
        3 => Message::ClearFault(ClearFault { command: CommandId(number), code: FaultCode::OverCurrent }),
        4 if number % 64 == 60 => Message::Revoke(Revoke { head, lease }),
        4 => Message::Query(Query { topic: Topic::Table }),
        5 => Message::Query(Query { topic: Topic::State }),
        6 => Message::Query(Query { topic: Topic::Faults }),
        _ => Message::Query(Query { topic: Topic::Passes }),
    }
}

fn row(index: usize) -> PileRow {
    PileRow {
        pile: PileId(index as u16 + 2),
        boot: BootEpoch(1),
        version: 1,
        stamp: None,
        availability: Availability::Free,
        remaining: Fraction::MIN,
        planned: DurationMs(0),
    }
}
