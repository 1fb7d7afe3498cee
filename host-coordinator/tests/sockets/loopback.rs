//! The whole daemon over real sockets: a real pile core behind UDP or TCP, a robot, a charge.

use std::{
    net::{SocketAddr, UdpSocket},
    path::Path,
    sync::Arc,
    time::Duration,
};

use crate::udp_world::{World, robot_config};
use firmware_pile::{ChargingPile, Parameters};
use host_coordinator::{
    config::{Config, Listen, Policy},
    core::View,
    daemon::{Daemon, SiteClock},
    site::Site,
};
use protocol::{
    BootEpoch, Deframer, DeviceId, Frame, Message, Millis, PileId, Recipient, RobotId, Sessions, SiteMillis,
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
    let (daemon, _) = start(folder.path()).await;
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let mut stranger = Sessions::insecure(DeviceId::Pile(PileId(99)), BootEpoch(1));
    let hello =
        Message::Hello(protocol::Hello { min: 1, current: 1, software: [0; 3], epoch: protocol::Epoch(9) });
    socket.send_to(&stranger.seal(COORDINATOR, &hello).unwrap(), daemon.addresses().udp).unwrap();
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
    let mut by_tcp = Sessions::insecure(DeviceId::Pile(PileId(1)), BootEpoch(1));
    let mut by_udp = Sessions::insecure(DeviceId::Pile(PileId(2)), BootEpoch(1));
    let gossip = |pile| {
        let row = ChargingPile::new(Parameters::new(PileId(pile), 1.0)).row();
        Message::PileTable(protocol::PileTable { rows: [row].into_iter().collect() })
    };
    let (mut tcp_heard, mut udp_heard) = (Vec::new(), Vec::new());
    let mut deframer = Deframer::new();
    let (mut stream_buffer, mut buffer) = ([0; 2048], [0; 2048]);
    let exchange = async {
        while tcp_heard.is_empty() || udp_heard.is_empty() {
            stream.write_all(&by_tcp.seal(Recipient::Piles, &gossip(1)).unwrap()).await.unwrap();
            socket.send(&by_udp.seal(Recipient::Piles, &gossip(2)).unwrap()).await.unwrap();
            tokio::select! {
                read = stream.read(&mut stream_buffer) => {
                    deframer.feed(&stream_buffer[..read.unwrap()], |packet| tcp_heard.push(by_tcp.open(packet.unwrap()).unwrap().message));
                }
                read = socket.recv(&mut buffer) => {
                    Deframer::new().feed(&buffer[..read.unwrap()], |packet| udp_heard.push(by_udp.open(packet.unwrap()).unwrap().message));
                }
                () = sleep(Duration::from_millis(20)) => {}
            }
        }
    };
    timeout(Duration::from_secs(10), exchange).await.unwrap();
    assert_eq!((tcp_heard[0].clone(), udp_heard[0].clone()), (gossip(2), gossip(1)));
    daemon.shutdown().await;
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
    let mut sessions = Sessions::insecure(DeviceId::Pile(PileId(4)), BootEpoch(1));
    for _ in 0..2 {
        let (mut stream, _) = timeout(Duration::from_secs(10), listener.accept()).await.unwrap().unwrap();
        let asked = Message::TimeRequest(protocol::TimeRequest { asked_at: Millis(5) });
        let bytes = sessions.seal(COORDINATOR, &asked).unwrap();
        // Whatever portions a stream comes in.
        let (first, rest) = bytes.split_at(7);
        stream.write_all(first).await.unwrap();
        sleep(Duration::from_millis(30)).await;
        stream.write_all(rest).await.unwrap();
        let mut heard = Vec::new();
        let mut deframer = Deframer::new();
        let mut buffer = [0; 512];
        while !heard.iter().any(|message| matches!(message, Message::TimeSync(_))) {
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
    // A pile by TCP asks for the time without end, and reads nothing.
    let mut stuck = TcpStream::connect(daemon.addresses().tcp).await.unwrap();
    let flood = tokio::spawn(async move {
        let mut sessions = Sessions::insecure(DeviceId::Pile(PileId(9)), BootEpoch(1));
        let asked = Message::TimeRequest(protocol::TimeRequest { asked_at: Millis(5) });
        while stuck.write_all(&sessions.seal(COORDINATOR, &asked).unwrap()).await.is_ok() {}
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
