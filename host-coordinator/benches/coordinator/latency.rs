//! The whole daemon: how long a robot waits from its request to its assignment, the pile's consent included.
//!
//! Every robot and every pile has a UDP socket and a key of its own; a pile is the real firmware core. A robot
//! asks, drives for four seconds once it has its assignment, goes back to work, which gives the pile
//! back, and asks again 20 s later from elsewhere: about 20 requests a second.

use std::{
    net::SocketAddr,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use firmware_pile::{ChargingPile, Input as PileInput, Parameters, To, plant::Plant};
use host_coordinator::{
    config::{Config, Listen, Policy, Security},
    daemon::{Daemon, SiteClock},
    keys::Keys,
};
use protocol::{
    Activity, BootEpoch, ChargeRequest, Deframer, DeviceId, EnergyJ, Epoch, Frame, FrameError, Hello,
    Message, Millis, PileId, Position, Recipient, RequestId, RobotId, RobotState, Session, Sessions,
    TaskPriority,
};
use tokio::{net::UdpSocket, runtime::Runtime, task::JoinSet, time};

use crate::site;

const WARM_UP: Duration = Duration::from_secs(25);
const MEASURED: Duration = Duration::from_secs(40);
const TICK: Duration = Duration::from_millis(200);
const WORKS: Duration = Duration::from_secs(20);
const DRIVES: Duration = Duration::from_secs(4);

/// What robots have waited, in milliseconds, in order.
pub struct Waits {
    ms: Vec<f64>,
    pub unanswered: usize,
}

impl Waits {
    pub fn len(&self) -> usize {
        self.ms.len()
    }

    pub fn quantile(&self, share: f64) -> f64 {
        let at = (share * self.ms.len() as f64).ceil() as usize;
        self.ms[at.clamp(1, self.ms.len()) - 1]
    }
}

pub fn measure() -> Waits {
    Runtime::new().unwrap().block_on(run())
}

async fn run() -> Waits {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let mut keys = Keys::default();
    keys.make_site().unwrap();
    let piles: Vec<_> = (1..=site::PILES).map(PileId).collect();
    let robots: Vec<_> = (1..=site::ROBOTS).map(RobotId).collect();
    let devices =
        piles.iter().map(|id| DeviceId::Pile(*id)).chain(robots.iter().map(|id| DeviceId::Robot(*id)));
    for device in devices {
        keys.make(device).unwrap();
    }
    let any: SocketAddr = "127.0.0.1:0".parse().unwrap();
    let config = Config {
        site: folder.path().to_owned(),
        event_log: folder.path().join("events.sqlite"),
        security: Security::Keys(keys.clone()),
        listen: Listen { http: None, udp: any, tcp: any },
        policy: Policy::default(),
        robots: site::robots(),
        connect: Vec::new(),
    };
    let site = Arc::new(site::site());
    let places = Arc::new(site::places(&site));
    let daemon = Daemon::start(Arc::clone(&site), &config, SiteClock::real()).await.unwrap();
    let to = daemon.addresses().udp;
    let (measuring, waits) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(Vec::new())));
    let asked = Arc::new(Mutex::new(0));
    let mut tasks = JoinSet::new();
    for id in piles {
        tasks.spawn(serve(Line::new(DeviceId::Pile(id), &keys, to).await, id));
    }
    for id in robots {
        let robot = Robot {
            line: Line::new(DeviceId::Robot(id), &keys, to).await,
            id,
            places: Arc::clone(&places),
            greeted: false,
            turn: 0,
            measuring: Arc::clone(&measuring),
            waits: Arc::clone(&waits),
            asked: Arc::clone(&asked),
        };
        tasks.spawn(robot.work());
    }
    time::sleep(WARM_UP).await;
    measuring.store(true, Ordering::Relaxed);
    time::sleep(MEASURED).await;
    measuring.store(false, Ordering::Relaxed);
    // Who asked last is answered too.
    time::sleep(Duration::from_secs(2)).await;
    tasks.shutdown().await;
    daemon.shutdown().await;
    let mut ms = std::mem::take(&mut *waits.lock().unwrap());
    ms.sort_by(f64::total_cmp);
    let unanswered = *asked.lock().unwrap() - ms.len();
    Waits { ms, unanswered }
}

/// A device's socket and session.
struct Line {
    socket: UdpSocket,
    sessions: Sessions<Vec<Session>>,
}

impl Line {
    async fn new(device: DeviceId, keys: &Keys, to: SocketAddr) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").await.unwrap();
        socket.connect(to).await.unwrap();
        Self { socket, sessions: Sessions::new(device, BootEpoch(1), keys.trust_of(device)) }
    }

    fn send(&mut self, message: &Message) {
        // To who was not heard yet nothing but Hello can be sealed.
        if let Ok(frame) = self.sessions.seal(Recipient::Device(DeviceId::Coordinator), message) {
            // A full buffer is a loss like any other.
            let _ = self.socket.try_send(&frame);
        }
    }

    /// What comes until an instant.
    async fn hear(&mut self, until: Instant) -> Vec<Result<Frame, FrameError>> {
        let mut found = Vec::new();
        let mut buffer = [0; 2048];
        if let Ok(Ok(length)) = time::timeout_at(until.into(), self.socket.recv(&mut buffer)).await {
            Deframer::new().feed(&buffer[..length], |packet| {
                found.push(packet.and_then(|packet| self.sessions.open(packet)));
            });
        }
        found
    }
}

/// A pile: the firmware's core, with nobody at its contacts.
async fn serve(mut line: Line, id: PileId) {
    let mut core = ChargingPile::new(Parameters::new(id, site::POWER_W));
    let mut plant = Plant::new();
    let begun = Instant::now();
    let mut tick_at = begun + TICK * u32::from(id.0) / u32::from(site::PILES);
    loop {
        let found = line.hear(tick_at).await;
        let now = Millis(begun.elapsed().as_millis() as u64);
        let mut inputs: Vec<_> = found
            .iter()
            .map(|found| match found {
                Ok(frame) => PileInput::Frame(frame),
                Err(error) => PileInput::Discarded(*error),
            })
            .collect();
        if Instant::now() >= tick_at {
            tick_at += TICK;
            inputs.extend([PileInput::ReaderIdle, PileInput::Sensors(plant.sense(now))]);
        }
        for input in inputs {
            let outputs = core.step(now, input);
            plant.command(outputs.power);
            for outgoing in outputs.messages.iter().filter(|outgoing| outgoing.to == To::Coordinator) {
                line.send(&outgoing.message);
            }
        }
    }
}

struct Robot {
    line: Line,
    id: RobotId,
    places: Arc<Vec<Position>>,
    greeted: bool,
    turn: u32,
    measuring: Arc<AtomicBool>,
    waits: Arc<Mutex<Vec<f64>>>,
    asked: Arc<Mutex<usize>>,
}

impl Robot {
    /// Works, asks, drives, again and again.
    async fn work(mut self) {
        let mut until = Instant::now() + WORKS * u32::from(self.id.0) / u32::from(site::ROBOTS);
        loop {
            self.pass(Activity::Working, until).await;
            self.turn += 1;
            self.wait().await;
            self.pass(Activity::Approaching, Instant::now() + DRIVES).await;
            until = Instant::now() + WORKS;
        }
    }

    async fn wait(&mut self) {
        let counts = self.measuring.load(Ordering::Relaxed);
        *self.asked.lock().unwrap() += usize::from(counts);
        let begun = Instant::now();
        loop {
            self.say(Activity::Waiting);
            let again = Instant::now() + Duration::from_secs(1);
            while Instant::now() < again {
                let heard = self.hear(again).await;
                let given = |message: &Message| matches!(message, Message::Assignment(part) if part.request.0 == self.turn);
                if heard.iter().any(given) {
                    if counts {
                        self.waits.lock().unwrap().push(begun.elapsed().as_secs_f64() * 1e3);
                    }
                    return;
                }
            }
        }
    }

    /// Says each second that it does something.
    async fn pass(&mut self, activity: Activity, until: Instant) {
        while Instant::now() < until {
            self.say(activity);
            let next = until.min(Instant::now() + Duration::from_secs(1));
            while Instant::now() < next {
                self.hear(next).await;
            }
        }
    }

    async fn hear(&mut self, until: Instant) -> Vec<Message> {
        let found = self.line.hear(until).await;
        found
            .into_iter()
            .filter_map(|found| {
                self.greeted = found.is_ok();
                Some(found.ok()?.message)
            })
            .collect()
    }

    fn say(&mut self, activity: Activity) {
        if !self.greeted {
            self.line.send(&Message::Hello(Hello::new(Epoch(0))));
        }
        let position: Position = site::place(&self.places, self.id, self.turn);
        let energy = EnergyJ::clamped(0.4 * site::FULL_J);
        let request = RequestId(self.turn);
        let accepted = (activity == Activity::Approaching).then_some(request);
        self.line.send(&Message::RobotState(RobotState { position, energy, activity, accepted }));
        if activity == Activity::Waiting {
            self.line.send(&Message::ChargeRequest(ChargeRequest {
                request,
                position,
                energy,
                task: None,
                priority: TaskPriority::USUAL,
            }));
        }
    }
}
