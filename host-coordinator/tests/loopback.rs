//! The whole daemon over real sockets: a real pile core behind UDP or TCP, a robot, a charge.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::{
    net::{SocketAddr, UdpSocket},
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

use firmware_pile::{ChargingPile, Input as PileInput, Parameters, TagRead, To};
use host_coordinator::{
    config::{Config, Listen, Policy, RobotConfig},
    core::View,
    daemon::{Daemon, SiteClock},
    site::Site,
};
use protocol::{
    Activity, BootEpoch, ChargeRequest, Deframer, DeviceId, EnergyJ, Frame, FrameWriter, Message, Millis,
    PileId, RequestId, RobotId, RobotState, SiteMillis, TagId,
};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
    time::{sleep, timeout},
};

const SPEED: f64 = 20.0;
const TAG: TagId = TagId([7; 12]);

fn config(folder: &Path) -> Config {
    let any: SocketAddr = "127.0.0.1:0".parse().unwrap();
    let full = EnergyJ::new(10_000.0).unwrap();
    Config {
        site: folder.to_owned(),
        event_log: folder.join("events.sqlite"),
        listen: Listen { http: any, udp: any, tcp: any },
        policy: Policy::default(),
        robots: vec![RobotConfig { id: RobotId(3), tag: TAG, full, energy_per_metre_j: 10.0 }],
        connect: Vec::new(),
    }
}

async fn start(folder: &Path) -> (Daemon, SiteClock) {
    let clock = SiteClock::simulated(SiteMillis(1_000_000), SPEED);
    let site = Arc::new(Site::fig7().unwrap());
    (Daemon::start(site, &config(folder), clock).await.unwrap(), clock)
}

async fn until(daemon: &Daemon, what: &str, found: impl Fn(&View) -> bool) {
    let mut views = daemon.view();
    let reached = async {
        while !found(&views.borrow_and_update()) {
            views.changed().await.unwrap();
        }
    };
    if timeout(Duration::from_secs(20), reached).await.is_err() {
        panic!("never {what}: {:#?}", daemon.view().borrow());
    }
}

/// A pile and, next to it, a robot, both on one thread with a UDP socket each.
fn play_charge(coordinator: SocketAddr, clock: SiteClock, until: Instant) {
    let site = Site::fig7().unwrap();
    let place = site.position(site.pile(PileId(2)).unwrap().cell);
    let socket = || {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(coordinator).unwrap();
        socket.set_nonblocking(true).unwrap();
        socket
    };
    let (pile_socket, robot_socket) = (socket(), socket());
    let mut pile = ChargingPile::new(Parameters::new(PileId(2), 500.0));
    let mut pile_writer = FrameWriter::new(DeviceId::Pile(PileId(2)), BootEpoch(1));
    let mut robot_writer = FrameWriter::new(DeviceId::Robot(RobotId(3)), BootEpoch(1));
    let mut accepted = None;
    let begun = clock.now();
    let mut said = SiteMillis(0);
    while Instant::now() < until {
        let now = Millis(clock.now().since(begun).0.into());
        let mut inputs: Vec<Frame> = Vec::new();
        let mut buffer = [0; 2048];
        while let Ok(length) = pile_socket.recv(&mut buffer) {
            Deframer::new().feed(&buffer[..length], |frame| inputs.push(frame.unwrap()));
        }
        let docked = accepted.is_some();
        let read =
            if docked { PileInput::Tag(TagRead { tag: TAG, rssi_dbm: -40 }) } else { PileInput::ReaderIdle };
        let feedback = PileInput::ContactorFeedback { closed: pile.energised() };
        let inputs = inputs.iter().map(PileInput::Frame).chain([feedback, read, PileInput::Tick]);
        for input in inputs {
            for outgoing in pile.step(now, input).messages {
                if outgoing.to == To::Coordinator {
                    pile_socket.send(&pile_writer.write(outgoing.message).unwrap()).unwrap();
                }
            }
        }
        while let Ok(length) = robot_socket.recv(&mut buffer) {
            Deframer::new().feed(&buffer[..length], |frame| {
                if let Message::Assignment(part) = frame.unwrap().message {
                    assert_eq!(part.pile, PileId(2));
                    accepted = Some(part.request);
                }
            });
        }
        if clock.now().since(said).0 >= 500 {
            said = clock.now();
            let energy = EnergyJ::new(5_000.0).unwrap();
            let activity = if docked { Activity::Docked } else { Activity::Waiting };
            let state = RobotState { position: place, energy, activity, accepted };
            robot_socket.send(&robot_writer.write(Message::RobotState(state)).unwrap()).unwrap();
            if !docked {
                let request = ChargeRequest { request: RequestId(1), position: place, energy };
                robot_socket.send(&robot_writer.write(Message::ChargeRequest(request)).unwrap()).unwrap();
            }
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_asks_is_granted_a_pile_and_is_charged_over_udp() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    let udp = daemon.addresses().udp;
    let player = std::thread::spawn(move || play_charge(udp, clock, Instant::now() + Duration::from_secs(4)));
    until(&daemon, "charging", |view| view.piles[1].availability == "charging" && view.piles[1].energised)
        .await;
    until(&daemon, "charged", |view| view.totals.charges_completed == 1).await;
    let view = Arc::clone(&daemon.view().borrow());
    assert_eq!(view.decisions[0].chosen, Some(PileId(2)));
    assert_eq!((view.totals.requests, view.totals.waiting), (1, 0));
    assert!(daemon.planning_times().quantile(0.5) > 0);
    daemon.shutdown().await;
    player.join().unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn strangers_and_noise_are_refused_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, _) = start(folder.path()).await;
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut stranger = FrameWriter::new(DeviceId::Pile(PileId(99)), BootEpoch(1));
    let hello =
        Message::Hello(protocol::Hello { min: 1, current: 1, software: [0; 3], epoch: protocol::Epoch(9) });
    socket.send_to(&stranger.write(hello.clone()).unwrap(), daemon.addresses().udp).unwrap();
    let mut late = Frame {
        header: protocol::Header::new(DeviceId::Pile(PileId(1)), BootEpoch(1), protocol::Sequence(0)),
        message: Message::TimeRequest(protocol::TimeRequest { asked_at: Millis(1) }),
    };
    late.header.version = 99;
    socket.send_to(&late.encode().unwrap(), daemon.addresses().udp).unwrap();
    socket.send_to(&[0, 1, 2, 3, 0], daemon.addresses().udp).unwrap();
    let address = socket.local_addr().unwrap().to_string();
    for part in ["pile 99", "protocol version 99", "garbled"] {
        until(&daemon, part, |view| {
            view.warnings.iter().any(|warning| warning.contains(part) && warning.contains(&address))
        })
        .await;
    }
    assert_eq!(daemon.view().borrow().epoch, 1, "a stranger's epoch counts for nothing");
    daemon.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn gossip_crosses_from_tcp_to_udp_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, _) = start(folder.path()).await;
    let mut stream = TcpStream::connect(daemon.addresses().tcp).await.unwrap();
    let socket = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
    socket.connect(daemon.addresses().udp).await.unwrap();
    let mut by_tcp = FrameWriter::new(DeviceId::Pile(PileId(1)), BootEpoch(1));
    let mut by_udp = FrameWriter::new(DeviceId::Pile(PileId(2)), BootEpoch(1));
    let gossip = |pile| {
        let row = ChargingPile::new(Parameters::new(PileId(pile), 1.0)).row();
        Message::PileTable(protocol::PileTable { rows: [row].into_iter().collect() })
    };
    let (mut tcp_heard, mut udp_heard) = (Vec::new(), Vec::new());
    let mut deframer = Deframer::new();
    let (mut stream_buffer, mut buffer) = ([0; 2048], [0; 2048]);
    let exchange = async {
        while tcp_heard.is_empty() || udp_heard.is_empty() {
            stream.write_all(&by_tcp.write(gossip(1)).unwrap()).await.unwrap();
            socket.send(&by_udp.write(gossip(2)).unwrap()).await.unwrap();
            tokio::select! {
                read = stream.read(&mut stream_buffer) => {
                    deframer.feed(&stream_buffer[..read.unwrap()], |frame| tcp_heard.push(frame.unwrap().message));
                }
                read = socket.recv(&mut buffer) => {
                    Deframer::new().feed(&buffer[..read.unwrap()], |frame| udp_heard.push(frame.unwrap().message));
                }
                () = sleep(Duration::from_millis(20)) => {}
            }
        }
    };
    timeout(Duration::from_secs(10), exchange).await.unwrap();
    assert_eq!((tcp_heard[0].clone(), udp_heard[0].clone()), (gossip(2), gossip(1)));
    daemon.shutdown().await;
}
