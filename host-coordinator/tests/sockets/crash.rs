//! The real `chargehand run` is killed again and again in full traffic: a few times here, 200 times by
//! `cargo xtask crash-loop`.

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

use crate::udp_world::{KEYS, Seen, World, robot_config};
use host_coordinator::{
    core::{CLOCK_MARGIN, Event, Fact, State, state::Phase},
    daemon::SiteClock,
    keys::Keys,
    store::Store,
};
use protocol::{LeaseId, PileId, RobotId, SiteMillis};
use serde_json::Value;

const ROBOTS: [u16; 5] = [1, 2, 3, 4, 5];
const PILES: [u16; 3] = [2, 7, 13];

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

/// The leases that are not over by their time alone: a refused one, which lingers until no copy of its grant
/// can arrive, may end while nobody is up.
fn leases_alive(state: &State, now: SiteMillis) -> Leases {
    let mut leases = leases_in(state);
    leases.retain(|pile, _| {
        state.lease(*pile).is_some_and(|lease| {
            matches!(lease.phase, Phase::Held { .. }) || now <= lease.expiry.after(CLOCK_MARGIN)
        })
    });
    leases
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

/// Kills a coordinator. Answers with what it has shown a moment before.
fn kill(coordinator: &mut Coordinator) -> Value {
    let shown = coordinator.state();
    // SIGKILL: nothing can be tidied up.
    coordinator.process.kill().unwrap();
    coordinator.process.wait().unwrap();
    shown
}

#[test]
fn killed_at_any_moment_it_resumes_with_the_same_leases_and_no_pile_has_two_holders() {
    kill_again_and_again(10);
}

/// Kills the coordinator so many times in full traffic. After every kill its log has all that it had shown
/// by HTTP, and the next coordinator has the leases of the log and a higher epoch. In the end no pile was
/// given away twice, and whatever a pile held to is in the log.
pub fn kill_again_and_again(kills: u64) {
    let folder = tempfile::tempdir().unwrap();
    let (http, udp) = free_addresses();
    let config = configure(folder.path(), http, udp);
    let mut coordinator = start(&config, http);
    coordinator.state();
    let world = World::start(udp, SiteClock::real(), &PILES, &ROBOTS);

    let (mut alive, mut longest) = (0, Duration::ZERO);
    for number in 0..kills {
        // Moments spread over everything that happens in about a second.
        thread::sleep(Duration::from_millis(300 + number * 977 % 1_100));
        let shown = kill(&mut coordinator);
        world.pause();
        let log = read_log(folder.path());
        let recorded = State::fold(&log);
        nothing_shown_is_lost(&shown, &log, &recorded, number);
        let begun = Instant::now();
        coordinator = start(&config, http);
        let view = coordinator.state();
        longest = longest.max(begun.elapsed());
        let kept = leases_alive(&recorded, SiteMillis(view["now_ms"].as_u64().unwrap()));
        assert_eq!(leases_shown(&view), kept, "kill {number}: {:?}", recorded.piles);
        assert_eq!(view["epoch"], recorded.epoch.0 + 1, "kill {number}");
        alive += leases_in(&recorded).len();
        world.go_on();
    }
    assert!(alive > 0, "no lease was ever alive at a kill");
    thread::sleep(Duration::from_secs(4));
    drop(coordinator);
    let seen = world.stop();
    let log = read_log(folder.path());
    let state = no_pile_is_given_twice(&log, &seen);
    println!(
        "{kills} kills: {alive} leases alive at them, all kept; {} leases held by piles, all in the log of {} \
         events; {} charges complete; epoch {}; up again after at most {longest:.1?}",
        seen.len(),
        log.len(),
        state.totals.charges_completed,
        state.epoch.0
    );
    assert!(state.totals.charges_completed > 3, "{:?}", state.totals);
}

/// What was shown is in the log: its leases are there or have ended since, and no epoch has gone back.
fn nothing_shown_is_lost(shown: &Value, log: &[Event], recorded: &State, kill: u64) {
    let kept = leases_in(recorded);
    for (pile, (lease, robot)) in leases_shown(shown) {
        let has_ended = log.iter().any(|event| {
            matches!(&event.fact, Fact::Ended { pile: at, lease: ended, .. } if (*at, *ended) == (pile, lease))
        });
        let is_kept = kept.get(&pile) == Some(&(lease, robot));
        assert!(is_kept || has_ended, "kill {kill}: lease {lease} of pile {pile} was shown and is lost");
    }
    assert!(shown["epoch"].as_u64().unwrap() <= recorded.epoch.0.into(), "kill {kill}: an epoch is lost");
    let shown = shown["totals"]["requests"].as_u64().unwrap();
    assert!(shown <= recorded.totals.requests, "kill {kill}: a request is lost");
}

/// The log gives no pile away while a lease is alive there, and no number of a lease or an epoch twice, and
/// has all that piles have held to. Answers with the state it leads to.
fn no_pile_is_given_twice(log: &[Event], seen: &Seen) -> State {
    let mut state = State::default();
    let mut granted = BTreeMap::new();
    let mut epochs = BTreeSet::new();
    for event in log {
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
    for (lease, held) in seen {
        assert_eq!(granted.get(lease), Some(held), "lease {lease} was held but never recorded");
    }
    state
}
