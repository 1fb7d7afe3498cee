//! The real `chargehand run` is killed again and again in full traffic.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    io::{Read as _, Write as _},
    net::{SocketAddr, TcpListener, TcpStream, UdpSocket},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use crate::udp_world::{KEYS, World, robot_config};
use host_coordinator::{
    core::{Event, Fact, State},
    daemon::SiteClock,
    keys::Keys,
    store::Store,
};
use protocol::{LeaseId, PileId, RobotId};
use serde_json::Value;

const ROBOTS: [u16; 5] = [1, 2, 3, 4, 5];
const PILES: [u16; 3] = [2, 7, 13];
const KILLS: u64 = 8;

struct Coordinator {
    process: Child,
    http: SocketAddr,
}

impl Drop for Coordinator {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Addresses that were free a moment ago.
fn free_addresses() -> (SocketAddr, SocketAddr) {
    let http = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let udp = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    (http, udp)
}

fn configure(folder: &Path, http: SocketAddr, udp: SocketAddr) -> PathBuf {
    let site = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sites/lmpp-fig7");
    let mut text = format!(
        "site = {site:?}\nevent_log = \"events.sqlite\"\nkeys = \"keys.toml\"\n\
         [listen]\nhttp = \"{http}\"\nudp = \"{udp}\"\ntcp = \"127.0.0.1:0\"\n"
    );
    for robot in ROBOTS.map(robot_config) {
        text += &format!(
            "[[robot]]\nid = {}\ntag = \"{}\"\nfull_j = {}\nenergy_per_metre_j = {}\n",
            robot.id, robot.tag, robot.full, robot.energy_per_metre_j
        );
    }
    Keys::change(&folder.join("keys.toml"), |keys| {
        *keys = KEYS.clone();
        Ok(())
    })
    .unwrap();
    let file = folder.join("chargehand.toml");
    fs::write(&file, text).unwrap();
    file
}

fn start(config: &Path, http: SocketAddr) -> Coordinator {
    let process = Command::new(env!("CARGO_BIN_EXE_chargehand"))
        .args(["run", "--config"])
        .arg(config)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    Coordinator { process, http }
}

impl Coordinator {
    /// The state by HTTP, as soon as the coordinator answers.
    fn state(&mut self) -> Value {
        let deadline = Instant::now() + Duration::from_secs(20);
        loop {
            if let Some(status) = self.process.try_wait().unwrap() {
                panic!("the coordinator has ended: {status}");
            }
            match self.get() {
                Some(state) => return state,
                None => assert!(Instant::now() < deadline, "the coordinator does not answer"),
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn get(&self) -> Option<Value> {
        let mut stream = TcpStream::connect(self.http).ok()?;
        stream.write_all(b"GET /api/v1/state HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").ok()?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).ok()?;
        serde_json::from_str(answer.split_once("\r\n\r\n")?.1).ok()
    }
}

type Leases = BTreeMap<PileId, (LeaseId, RobotId)>;

fn leases_in(state: &State) -> Leases {
    let row = |(pile, record): (&PileId, &host_coordinator::core::state::PileRecord)| {
        record.lease.map(|lease| (*pile, (lease.name.lease, lease.name.robot)))
    };
    state.piles.iter().filter_map(row).collect()
}

fn leases_shown(view: &Value) -> Leases {
    let number = |value: &Value| value.as_u64().unwrap();
    let row = |pile: &Value| {
        let lease = pile["lease"].as_object()?;
        let names = (LeaseId(number(&lease["id"]) as u32), RobotId(number(&lease["robot"]) as u16));
        Some((PileId(number(&pile["id"]) as u16), names))
    };
    view["piles"].as_array().unwrap().iter().filter_map(row).collect()
}

/// Reads the log, as any other program could.
fn read_log(folder: &Path) -> Vec<Event> {
    Store::open(&folder.join("events.sqlite")).unwrap().1
}

#[test]
fn killed_at_any_moment_it_resumes_with_the_same_leases_and_no_pile_has_two_holders() {
    let folder = tempfile::tempdir().unwrap();
    let (http, udp) = free_addresses();
    let config = configure(folder.path(), http, udp);
    let mut coordinator = start(&config, http);
    coordinator.state();
    let world = World::start(udp, SiteClock::real(), &PILES, &ROBOTS);

    let mut alive = 0;
    for kill in 0..KILLS {
        // Moments spread over everything that happens in about a second.
        thread::sleep(Duration::from_millis(700 + kill * 977 % 1_100));
        // SIGKILL: nothing can be tidied up.
        coordinator.process.kill().unwrap();
        coordinator.process.wait().unwrap();
        world.pause();
        let recorded = State::fold(&read_log(folder.path()));
        coordinator = start(&config, http);
        let view = coordinator.state();
        assert_eq!(leases_shown(&view), leases_in(&recorded), "kill {kill}");
        assert_eq!(view["epoch"], recorded.epoch.0 + 1, "kill {kill}");
        alive += leases_in(&recorded).len();
        world.go_on();
    }
    assert!(alive > 0, "no lease was ever alive at a kill");
    thread::sleep(Duration::from_secs(4));
    drop(coordinator);
    let seen = world.stop();

    let log = read_log(folder.path());
    let mut state = State::default();
    let mut granted = BTreeMap::new();
    let mut epochs = BTreeSet::new();
    for event in &log {
        if let Fact::Granted { pile, lease, .. } = &event.fact {
            assert_eq!(state.lease(*pile), None, "pile {pile} was given away twice");
            let before = granted.insert(lease.lease, (*pile, lease.robot));
            assert_eq!(before, None, "lease {} was given twice", lease.lease);
        }
        if let Fact::EpochStarted { epoch, .. } = event.fact {
            assert!(epochs.insert(epoch), "epoch {epoch} began twice");
        }
        state.apply(event);
    }
    for (lease, held) in &seen {
        assert_eq!(granted.get(lease), Some(held), "lease {lease} was held but never recorded");
    }
    assert!(state.totals.charges_completed > 3, "{:?}", state.totals);
}
