//! The whole charge: the real coordinator, the pile's image in QEMU on its TCP link, a robot on UDP,
//! and the robot's tag at the pile's reader.

use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use firmware_pile::charge::planned_time;
use host_coordinator::config::{Config, Listen, Policy, RobotConfig, Security};
use host_coordinator::core::Coordinator;
use host_coordinator::core::view::{PileView, View};
use host_coordinator::daemon::{Daemon, SiteClock};
use host_coordinator::site::Site;
use host_coordinator::store::Store;
use protocol::{
    Activity, Assignment, BootEpoch, ChargeRequest, Deframer, DeviceId, DurationMs, EnergyJ, Message, PileId,
    Position, Recipient, RequestId, RobotId, RobotState, Sessions, TaskPriority,
};
use tempfile::TempDir;
use tests::emulator::{Emulator, Serial};
use tests::uhf_reader::UhfReader;
use tokio::runtime::Runtime;

use tests::pile_bench::{ETA, PILE, POWER_W, ROBOT, SOON};

const ROBOT_ID: RobotId = RobotId(3);
const FULL_J: f32 = 100_000.0;

/// A site with the real coordinator and one pile that is switched on.
struct Charging {
    site: Arc<Site>,
    config: Config,
    /// `None` while the coordinator is down.
    daemon: Option<Daemon>,
    runtime: Runtime,
    robot: Robot,
    reader: UhfReader,
    board: Emulator,
    _folder: TempDir,
}

impl Charging {
    /// Starts everything; the robot stands at the pile's place, out of the reader's field.
    fn new(lacking_j: f32) -> Self {
        let folder = TempDir::new().unwrap();
        let site = Arc::new(Site::load(&repository().join("sites/lmpp-fig7")).unwrap());
        let anywhere = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let full = EnergyJ::new(FULL_J).unwrap();
        let mut config = Config {
            site: PathBuf::new(),
            event_log: folder.path().join("events.sqlite"),
            // The image has no keys yet.
            security: Security::Insecure,
            listen: Listen { http: Some(anywhere), udp: anywhere, tcp: anywhere },
            policy: Policy::default(),
            robots: vec![RobotConfig {
                id: ROBOT_ID,
                tag: ROBOT,
                full,
                energy_per_metre_j: 10.0,
                speed_mps: 0.5,
                gives_w: None,
            }],
            connect: Vec::new(),
        };
        let runtime = Runtime::new().unwrap();
        let daemon = start(&runtime, &site, &config);
        // A coordinator that starts again listens where it did.
        config.listen = Listen {
            http: daemon.addresses().http,
            udp: daemon.addresses().udp,
            tcp: daemon.addresses().tcp,
        };
        let reader = UhfReader::start().unwrap();
        let board = Emulator::boot(Serial::Dial(config.listen.tcp), Serial::Dial(reader.address()))
            .unwrap_or_else(|error| panic!("{error}"));
        let pile = site.piles.iter().find(|pile| pile.id == PILE).expect("the site has no such pile");
        let robot = Robot::new(config.listen.udp, site.position(pile.cell), FULL_J - lacking_j);
        Self { site, config, daemon: Some(daemon), runtime, robot, reader, board, _folder: folder }
    }

    /// Goes on until the coordinator's view is as wanted, and returns it.
    fn until(&mut self, what: &str, wanted: impl Fn(&View, &Robot) -> bool) -> Arc<View> {
        let deadline = Instant::now() + SOON;
        loop {
            self.robot.go_on();
            let view = self.view();
            if wanted(&view, &self.robot) {
                return view;
            }
            let log = self.board.log();
            assert!(
                Instant::now() < deadline,
                "not within {SOON:?}: {what}; pile: {:#?}, its log: {log:#?}, warnings: {:#?}",
                pile(&view),
                view.warnings
            );
            thread::sleep(Duration::from_millis(20));
        }
    }

    fn view(&self) -> Arc<View> {
        let daemon = self.daemon.as_ref().expect("the coordinator is down");
        Arc::clone(&daemon.view().borrow())
    }

    /// The robot asks, gets the pile, and drives up to it; the contactor closes.
    fn begin(&mut self) {
        self.until("the pile says Hello and is free", |view, _| pile(view).availability == "free");
        self.robot.ask();
        self.until("the pile is granted and holds to it", |view, _| {
            pile(view).lease.is_some_and(|lease| lease.phase == "held" && lease.robot == ROBOT_ID)
        });
        self.until("the robot is sent to it", |_, robot| robot.assigned == Some(PILE));
        self.robot.does(Activity::Docked);
        self.reader.dock(ROBOT);
        self.board.wait_for("contactor closed", SOON).unwrap_or_else(|error| panic!("{error}"));
    }

    fn stop_coordinator(&mut self) {
        let daemon = self.daemon.take().expect("the coordinator is down");
        self.runtime.block_on(daemon.shutdown());
    }

    fn start_coordinator(&mut self) {
        self.daemon = Some(start(&self.runtime, &self.site, &self.config));
    }
}

fn start(runtime: &Runtime, site: &Arc<Site>, config: &Config) -> Daemon {
    let started = runtime.block_on(Daemon::start(Arc::clone(site), config, SiteClock::real()));
    started.unwrap_or_else(|error| panic!("{error}"))
}

fn pile(view: &View) -> &PileView {
    view.piles.iter().find(|row| row.id == PILE).expect("the coordinator does not know the pile")
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// A robot as far as the coordinator can tell.
struct Robot {
    socket: UdpSocket,
    sessions: Sessions,
    state: RobotState,
    told_at: Option<Instant>,
    assigned: Option<PileId>,
}

impl Robot {
    fn new(coordinator: SocketAddr, position: Position, energy_j: f32) -> Self {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        socket.connect(coordinator).unwrap();
        socket.set_nonblocking(true).unwrap();
        let energy = EnergyJ::new(energy_j).unwrap();
        Self {
            socket,
            sessions: Sessions::insecure(DeviceId::Robot(ROBOT_ID), BootEpoch(1)),
            state: RobotState { position, energy, activity: Activity::Working, accepted: None },
            told_at: None,
            assigned: None,
        }
    }

    fn say(&mut self, message: Message) {
        let frame = self.sessions.seal(Recipient::Device(DeviceId::Coordinator), &message).unwrap();
        // Nobody listens while the coordinator is down.
        let _ = self.socket.send(&frame);
    }

    fn ask(&mut self) {
        self.does(Activity::Waiting);
        let RobotState { position, energy, .. } = self.state;
        self.say(Message::ChargeRequest(ChargeRequest {
            request: RequestId(1),
            position,
            energy,
            task: None,
            priority: TaskPriority::USUAL,
        }));
    }

    fn does(&mut self, activity: Activity) {
        self.state.activity = activity;
        self.told_at = None;
        self.go_on();
    }

    /// Tells its state when it is time, and takes assignments.
    fn go_on(&mut self) {
        if self.told_at.is_none_or(|at| at.elapsed() > Duration::from_millis(500)) {
            self.told_at = Some(Instant::now());
            self.say(Message::RobotState(self.state));
        }
        let mut datagram = [0; 2048];
        while let Ok(length) = self.socket.recv(&mut datagram) {
            Deframer::new().feed(&datagram[..length], |packet| {
                let frame = self.sessions.open(packet.unwrap());
                if let Message::Assignment(Assignment { request, pile, .. }) = frame.unwrap().message {
                    self.assigned = Some(pile);
                    self.state.accepted = Some(request);
                }
            });
        }
    }
}

#[test]
fn the_coordinator_charges_a_robot_at_the_emulated_pile() {
    let lacking_j = 500.0;
    let mut site = Charging::new(lacking_j);
    site.begin();
    let begun = Instant::now();

    // Eq. 2.
    let planned = planned_time([EnergyJ::new(lacking_j).unwrap()], POWER_W, ETA);
    let mut fallen = Vec::new();
    loop {
        let view = site.until("the charge goes on", |_, _| true);
        let row = pile(&view);
        if row.availability == "charging" {
            assert!(row.energised, "charging with dead contacts: {row:?}");
            assert_eq!((row.holder, DurationMs::from_seconds(row.planned_s)), (Some(ROBOT_ID), planned));
            // Eq. 1.
            let expected = 1.0 - row.elapsed_s / row.planned_s;
            assert!((row.remaining - expected).abs() < 1e-3, "q is not {expected}: {row:?}");
            fallen.push(row.remaining);
        }
        if view.totals.charges_completed == 1 {
            break;
        }
        let limit = planned.as_seconds() + 10.0;
        assert!(begun.elapsed().as_secs_f32() < limit, "the charge does not end: {row:?}");
        thread::sleep(Duration::from_millis(20));
    }
    assert!(fallen.is_sorted_by(|before, after| before >= after), "q rose: {fallen:?}");
    fallen.dedup();
    assert!(fallen.len() > 10, "q fell in these steps only: {fallen:?}");
    assert!(fallen[0] > 0.8 && fallen[fallen.len() - 1] < 0.2, "q did not fall from 1 to 0: {fallen:?}");

    site.board.wait_for("contactor open", SOON).unwrap_or_else(|error| panic!("{error}"));
    site.until("the robot is still there", |view, _| pile(view).availability == "done");
    site.reader.clear();
    site.robot.does(Activity::Working);
    let view = site.until("the pile is free again", |view, _| pile(view).availability == "free");
    assert_eq!(pile(&view).lease, None);

    // The pass is in the event log, which outlives the coordinator (eq. 4).
    site.stop_coordinator();
    let (_, events) = Store::open(&site.config.event_log).unwrap();
    let coordinator = Coordinator::recover(
        Arc::clone(&site.site),
        site.site.lmpp(1.0),
        site.config.policy,
        &site.config.robots,
        &events,
    );
    let passes: Vec<_> =
        coordinator.state().passes.iter().map(|((robot, _), piles)| (*robot, piles)).collect();
    assert_eq!(passes, [(ROBOT_ID, &[(PILE, 1)].into())]);
}

#[test]
fn a_charge_outlives_its_coordinator_and_is_taken_over_by_the_next() {
    // Long enough for a coordinator to go and come back.
    let mut site = Charging::new(2_500.0);
    site.begin();
    let before = site.until("it charges", |view, _| pile(view).energised);
    let lease = pile(&before).lease.expect("it charges without a lease");

    site.stop_coordinator();
    site.start_coordinator();
    let after = site.until("it still charges", |view, _| pile(view).energised);
    let kept = pile(&after).lease.expect("the lease is lost");
    assert_eq!((kept.id, kept.robot), (lease.id, ROBOT_ID));
    assert!(after.epoch > before.epoch, "two coordinators with one epoch");

    site.until("the charge is completed", |view, _| view.totals.charges_completed == 1);
    let log = site.board.log();
    let closings = log.iter().filter(|line| line.contains("contactor closed")).count();
    assert_eq!(closings, 1, "the charge was interrupted: {log:#?}");
}
