//! The whole daemon over real sockets: a real pile core behind UDP or TCP, a robot, a charge.

use std::{
    net::{SocketAddr, UdpSocket},
    path::Path,
    sync::Arc,
    time::Duration,
};

use crate::udp_world::{KEYS, World, hello, robot_config, sessions};
use firmware_pile::{ChargingPile, Parameters};
use host_coordinator::{
    config::{Config, Listen, Policy, Security},
    core::View,
    daemon::{Daemon, SiteClock},
    site::Site,
};
use protocol::{
    Activity, BootEpoch, Deframer, DeviceId, EnergyJ, Frame, FrameError, Key, Message, Millis, PileId,
    Recipient, RobotId, RobotState, Session, Sessions, SiteMillis, Trust,
};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::TcpStream,
    time::{sleep, timeout},
};

const SPEED: f64 = 10.0;
const COORDINATOR: Recipient = Recipient::Device(DeviceId::Coordinator);

fn config(folder: &Path) -> Config {
    let any: SocketAddr = "127.0.0.1:0".parse().unwrap();
    Config {
        site: folder.to_owned(),
        event_log: folder.join("events.sqlite"),
        security: Security::Keys(KEYS.clone()),
        listen: Listen { http: Some(any), udp: any, tcp: any },
        policy: Policy::default(),
        robots: vec![robot_config(3)],
        connect: Vec::new(),
    }
}

pub async fn start(folder: &Path) -> (Daemon, SiteClock) {
    let clock = SiteClock::simulated(SiteMillis(1_000_000), SPEED);
    let site = Arc::new(Site::fig7().unwrap());
    (Daemon::start(site, &config(folder), clock.clone()).await.unwrap(), clock)
}

pub async fn until(daemon: &Daemon, what: &str, found: impl Fn(&View) -> bool) {
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

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_asks_is_granted_a_pile_and_is_charged_over_udp() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    let world = World::start(daemon.addresses().udp, clock, &[2], &[3]);
    until(&daemon, "charging", |view| view.piles[1].availability == "charging" && view.piles[1].energised)
        .await;
    until(&daemon, "charged", |view| view.totals.charges_completed > 0).await;
    let view = Arc::clone(&daemon.view().borrow());
    assert_eq!(view.decisions[0].chosen, Some(PileId(2)));
    assert!(daemon.planning_times().quantile(0.5) > 0);
    let seen = world.stop();
    assert_eq!(seen.values().next(), Some(&(PileId(2), RobotId(3))));
    daemon.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn strangers_and_noise_are_refused_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let config = Config { security: Security::Insecure, ..config(folder.path()) };
    let clock = SiteClock::simulated(SiteMillis(1_000_000), SPEED);
    let daemon = Daemon::start(Arc::new(Site::fig7().unwrap()), &config, clock).await.unwrap();
    assert!(daemon.view().borrow().insecure, "the page does not say that nobody is authenticated");
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut stranger = Sessions::insecure(DeviceId::Pile(PileId(99)), BootEpoch(1));
    let mut late = Frame {
        header: protocol::Header::new(DeviceId::Pile(PileId(1)), BootEpoch(1), protocol::Sequence(0)),
        message: Message::TimeRequest(protocol::TimeRequest { asked_at: Millis(1) }),
    };
    late.header.version = 99;
    let sealed = sessions(DeviceId::Pile(PileId(1))).seal(COORDINATOR, &hello()).unwrap();
    for bytes in [&stranger.seal(COORDINATOR, &hello()).unwrap()[..], &late.encode().unwrap(), &sealed] {
        socket.send_to(bytes, daemon.addresses().udp).unwrap();
    }
    socket.send_to(&[0, 1, 2, 3, 0], daemon.addresses().udp).unwrap();
    warns_of(&daemon, &["pile 99", "protocol version 99", "sealed", "garbled"], &socket).await;
    assert_eq!(daemon.view().borrow().epoch, 1, "a stranger's epoch counts for nothing");
    daemon.shutdown().await;
}

/// Waits until the daemon warns of all this at the socket's address.
async fn warns_of(daemon: &Daemon, parts: &[&str], socket: &UdpSocket) {
    let address = socket.local_addr().unwrap().to_string();
    for part in parts {
        until(daemon, part, |view| {
            view.warnings.iter().any(|warning| warning.contains(part) && warning.contains(&address))
        })
        .await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn who_has_not_the_key_or_repeats_a_frame_is_not_heard() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    assert!(!daemon.view().borrow().insecure);
    let udp = daemon.addresses().udp;
    let pile = DeviceId::Pile(PileId(1));
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let stranded = RobotState {
        position: Site::fig7().unwrap().position(Site::fig7().unwrap().piles[0].cell),
        energy: EnergyJ::MIN,
        activity: Activity::Stranded,
        accepted: None,
    };

    // Without a seal, and under another key.
    let mut plain = Sessions::insecure(pile, BootEpoch(1));
    socket.send_to(&plain.seal(COORDINATOR, &hello()).unwrap(), udp).unwrap();
    let peers = vec![Session::new(DeviceId::Coordinator, Key::new([7; 32]))];
    let mut forger = Sessions::new(pile, BootEpoch(9), Trust::Keys { site: None, peers });
    warns_of(&daemon, &["frame of pile 1 without a seal"], &socket).await;
    let warned = async {
        while !daemon.view().borrow().warnings.iter().any(|warning| warning.contains("do not authenticate")) {
            socket.send_to(&forger.seal(COORDINATOR, &hello()).unwrap(), udp).unwrap();
            sleep(Duration::from_millis(20)).await;
        }
    };
    timeout(Duration::from_secs(10), warned).await.expect("a forger is not named");
    assert_eq!(daemon.view().borrow().piles[0].availability, "unknown");

    // A robot says that it has stranded, then that it has not; the first is recorded and sent again.
    let mut robot = sessions(DeviceId::Robot(RobotId(3)));
    let link = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
    link.connect(udp).await.unwrap();
    let mut buffer = [0; 512];
    link.send(&robot.seal(COORDINATOR, &hello()).unwrap()).await.unwrap();
    let length = timeout(Duration::from_secs(10), link.recv(&mut buffer)).await.unwrap().unwrap();
    Deframer::new().feed(&buffer[..length], |packet| drop(robot.open(packet.unwrap()).unwrap()));
    let recorded = robot.seal(COORDINATOR, &Message::RobotState(stranded)).unwrap();
    link.send(&recorded).await.unwrap();
    until(&daemon, "stranded", |view| view.robots[0].activity == "stranded").await;
    let works = RobotState { activity: Activity::Working, ..stranded };
    link.send(&robot.seal(COORDINATOR, &Message::RobotState(works)).unwrap()).await.unwrap();
    until(&daemon, "works", |view| view.robots[0].activity == "working").await;
    let resent_at = clock.now();
    socket.send_to(&recorded, udp).unwrap();
    // A stranger's frame comes after it: once that is warned of, the recorded one was taken or not.
    socket.send_to(&[0, 1, 2, 3, 0], udp).unwrap();
    warns_of(&daemon, &["garbled"], &socket).await;
    until(&daemon, "later", |view| view.now_ms > resent_at.0 + 200).await;
    assert_eq!(daemon.view().borrow().robots[0].activity, "working");
    daemon.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn gossip_crosses_from_tcp_to_udp_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, _) = start(folder.path()).await;
    let mut stream = TcpStream::connect(daemon.addresses().tcp).await.unwrap();
    let socket = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
    socket.connect(daemon.addresses().udp).await.unwrap();
    let mut by_tcp = sessions(DeviceId::Pile(PileId(1)));
    let mut by_udp = sessions(DeviceId::Pile(PileId(2)));
    let gossip = |pile| {
        let row = ChargingPile::new(Parameters::new(PileId(pile), 1.0)).row();
        Message::PileTable(protocol::PileTable { rows: [row].into_iter().collect() })
    };
    // Where a pile is, the coordinator believes no gossip.
    stream.write_all(&by_tcp.seal(COORDINATOR, &hello()).unwrap()).await.unwrap();
    socket.send(&by_udp.seal(COORDINATOR, &hello()).unwrap()).await.unwrap();
    let (mut tcp_heard, mut udp_heard) = (Vec::new(), Vec::new());
    let mut deframer = Deframer::new();
    let (mut stream_buffer, mut buffer) = ([0; 2048], [0; 2048]);
    let exchange = async {
        while tcp_heard.is_empty() || udp_heard.is_empty() {
            stream.write_all(&by_tcp.seal(Recipient::Piles, &gossip(1)).unwrap()).await.unwrap();
            socket.send(&by_udp.seal(Recipient::Piles, &gossip(2)).unwrap()).await.unwrap();
            tokio::select! {
                read = stream.read(&mut stream_buffer) => {
                    deframer.feed(&stream_buffer[..read.unwrap()], |packet| gossip_in(by_tcp.open(packet.unwrap()), &mut tcp_heard));
                }
                read = socket.recv(&mut buffer) => {
                    Deframer::new().feed(&buffer[..read.unwrap()], |packet| gossip_in(by_udp.open(packet.unwrap()), &mut udp_heard));
                }
                () = sleep(Duration::from_millis(20)) => {}
            }
        }
    };
    timeout(Duration::from_secs(10), exchange).await.unwrap();
    assert_eq!((tcp_heard[0].clone(), udp_heard[0].clone()), (gossip(2), gossip(1)));

    // Somebody sends recorded gossip from elsewhere: the pile is still where it was.
    let elsewhere = UdpSocket::bind("127.0.0.1:0").unwrap();
    let recorded = by_udp.seal(Recipient::Piles, &gossip(2)).unwrap();
    elsewhere.send_to(&recorded, daemon.addresses().udp).unwrap();
    elsewhere.send_to(&[0, 1, 2, 3, 0], daemon.addresses().udp).unwrap();
    warns_of(&daemon, &["garbled"], &elsewhere).await;
    while socket.try_recv(&mut buffer).is_ok() {}
    stream.write_all(&by_tcp.seal(Recipient::Piles, &gossip(1)).unwrap()).await.unwrap();
    timeout(Duration::from_secs(10), socket.recv(&mut buffer)).await.expect("gossip went elsewhere").unwrap();
    daemon.shutdown().await;
}

/// What was heard, if it is gossip.
fn gossip_in(found: Result<Frame, FrameError>, heard: &mut Vec<Message>) {
    heard.extend(Some(found.unwrap().message).filter(|message| matches!(message, Message::PileTable(_))));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pile_that_has_to_be_called_is_called_until_it_answers_and_again_when_it_hangs_up() {
    let folder = tempfile::tempdir().unwrap();
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let mut config = config(folder.path());
    config.connect = vec![(PileId(4), listener.local_addr().unwrap())];
    let site = Arc::new(Site::fig7().unwrap());
    let clock = SiteClock::simulated(SiteMillis(1_000_000), SPEED);
    let daemon = Daemon::start(site, &config, clock).await.unwrap();
    let mut sessions = sessions(DeviceId::Pile(PileId(4)));
    for _ in 0..2 {
        let (mut stream, _) = timeout(Duration::from_secs(10), listener.accept()).await.unwrap().unwrap();
        let bytes = sessions.seal(COORDINATOR, &hello()).unwrap();
        // Whatever portions a stream comes in.
        let (first, rest) = bytes.split_at(7);
        stream.write_all(first).await.unwrap();
        sleep(Duration::from_millis(30)).await;
        stream.write_all(rest).await.unwrap();
        let mut heard = Vec::new();
        let mut deframer = Deframer::new();
        let mut buffer = [0; 512];
        while !heard.iter().any(|message| matches!(message, Message::Hello(_))) {
            let read = timeout(Duration::from_secs(10), stream.read(&mut buffer)).await.unwrap().unwrap();
            assert!(read > 0, "hung up after {heard:?}");
            deframer
                .feed(&buffer[..read], |packet| heard.push(sessions.open(packet.unwrap()).unwrap().message));
        }
    }
    daemon.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_peer_that_does_not_read_holds_nobody_up() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    // A pile by TCP says Hello without end, and reads nothing.
    let mut stuck = TcpStream::connect(daemon.addresses().tcp).await.unwrap();
    let flood = tokio::spawn(async move {
        let mut sessions = sessions(DeviceId::Pile(PileId(9)));
        while stuck.write_all(&sessions.seal(COORDINATOR, &hello()).unwrap()).await.is_ok() {}
    });
    until(&daemon, "stuck", |view| {
        view.warnings.iter().any(|warning| warning.contains("pile 9 does not read"))
    })
    .await;
    let world = World::start(daemon.addresses().udp, clock, &[2], &[3]);
    until(&daemon, "charged", |view| view.totals.charges_completed > 0).await;
    flood.abort();
    world.stop();
    daemon.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_second_coordinator_on_the_same_log_is_refused_and_the_first_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let (daemon, clock) = start(folder.path()).await;
    let site = Arc::new(Site::fig7().unwrap());
    let error = Daemon::start(site, &config(folder.path()), clock).await.unwrap_err().to_string();
    assert!(error.contains("events.sqlite") && error.contains("in use"), "{error}");
    daemon.shutdown().await;
    let (again, _) = start(folder.path()).await;
    assert_eq!(again.view().borrow().epoch, 2);
    again.shutdown().await;
}
