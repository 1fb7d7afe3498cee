//! Real pile cores and robots that stand next to their piles, each behind a UDP socket of its own.

use std::{
    collections::BTreeMap,
    net::{SocketAddr, UdpSocket},
    sync::{
        Arc, LazyLock,
        atomic::{AtomicU8, Ordering},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use firmware_pile::{
    ChargingPile, Input as PileInput, Parameters, TagRead, To,
    plant::{Battery, Plant},
};
use host_coordinator::{config::RobotConfig, daemon::SiteClock, keys::Keys, site::Site};
use protocol::{
    Activity, BootEpoch, ChargeRequest, Deframer, DeviceId, DurationMs, EnergyJ, Epoch, Frame, FrameError,
    Hello, LeaseId, Message, Millis, PileId, Position, Recipient, RequestId, RobotId, RobotState, SealError,
    Session, Sessions, SiteMillis, TagId, TaskPriority,
};

/// What every robot of this world is like.
pub fn robot_config(number: u16) -> RobotConfig {
    let [low, high] = number.to_le_bytes();
    RobotConfig {
        id: RobotId(number),
        tag: TagId([low, high, 0, 0, 0, 0, 0, 0, 0, 0, 0, 9]),
        full: EnergyJ::new(10_000.0).unwrap(),
        energy_per_metre_j: 10.0,
        speed_mps: 0.5,
        gives_w: None,
    }
}

/// The keys of every pile and robot of this world, and of its coordinator.
pub static KEYS: LazyLock<Keys> = LazyLock::new(|| {
    let mut keys = Keys::default();
    keys.make_site().unwrap();
    let piles = (1..=13).map(|pile| DeviceId::Pile(PileId(pile)));
    for device in piles.chain((1..=5).map(|robot| DeviceId::Robot(RobotId(robot)))) {
        keys.make(device).unwrap();
    }
    keys
});

/// The sessions of a device in its first start.
pub fn sessions(device: DeviceId) -> Sessions<Vec<Session>> {
    Sessions::new(device, BootEpoch(1), KEYS.trust_of(device))
}

pub fn hello() -> Message {
    Message::Hello(Hello { min: 1, current: 1, software: [0; 3], epoch: Epoch(0) })
}

/// Leases that piles held: where, and for whom.
pub type Seen = BTreeMap<LeaseId, (PileId, RobotId)>;

/// A world that runs on a thread of its own.
pub struct World {
    command: Arc<AtomicU8>,
    thread: JoinHandle<Seen>,
}

const RUN: u8 = 0;
const PAUSE: u8 = 1;
const STOP: u8 = 2;
const STRAND: u8 = 3;

impl World {
    /// Starts these piles and robots of Fig. 7. Charges take a good second.
    pub fn start(coordinator: SocketAddr, clock: SiteClock, piles: &[u16], robots: &[u16]) -> Self {
        let site = Site::fig7().unwrap();
        let begun = clock.now();
        let mut piles: Vec<_> = piles.iter().map(|number| Pile::new(&site, *number, coordinator)).collect();
        let mut robots: Vec<_> =
            robots.iter().map(|number| Robot::new(&site, *number, coordinator)).collect();
        let command = Arc::new(AtomicU8::new(RUN));
        let commanded = Arc::clone(&command);
        let thread = thread::spawn(move || {
            let mut seen = Seen::new();
            loop {
                let command = commanded.load(Ordering::SeqCst);
                match command {
                    RUN | STRAND => {
                        robots.iter_mut().for_each(|robot| robot.stranded = command == STRAND);
                        let now = Millis(clock.now().since(begun).0.into());
                        piles.iter_mut().for_each(|pile| pile.step(now, &robots, &mut seen));
                        robots.iter_mut().for_each(|robot| robot.step(clock.now(), &piles));
                    }
                    PAUSE => {}
                    _ => return seen,
                }
                thread::sleep(Duration::from_millis(3));
            }
        });
        Self { command, thread }
    }

    /// Says and hears nothing until it goes on.
    pub fn pause(&self) {
        self.command.store(PAUSE, Ordering::SeqCst);
        thread::sleep(Duration::from_millis(50));
    }

    /// All its robots can't move from now on.
    pub fn strand(&self) {
        self.command.store(STRAND, Ordering::SeqCst);
    }

    /// Goes on.
    pub fn go_on(&self) {
        self.command.store(RUN, Ordering::SeqCst);
    }

    /// Ends, and tells what leases the piles held.
    pub fn stop(self) -> Seen {
        self.command.store(STOP, Ordering::SeqCst);
        self.thread.join().unwrap()
    }
}

fn socket(coordinator: SocketAddr) -> UdpSocket {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(coordinator).unwrap();
    socket.set_nonblocking(true).unwrap();
    socket
}

/// A coordinator that was killed refuses datagrams; that is a loss like any other.
fn send(socket: &UdpSocket, sessions: &mut Sessions<Vec<Session>>, message: &Message) {
    let to = Recipient::Device(DeviceId::Coordinator);
    match sessions.seal(to, message) {
        Ok(frame) => drop(socket.send(&frame)),
        // It is repeated.
        Err(error) => assert!(matches!(error, SealError::Unheard { .. }), "{error}"),
    }
}

fn hear(socket: &UdpSocket, sessions: &mut Sessions<Vec<Session>>) -> Vec<Result<Frame, FrameError>> {
    let mut found = Vec::new();
    let mut buffer = [0; 2048];
    loop {
        match socket.recv(&mut buffer) {
            Ok(length) => Deframer::new().feed(&buffer[..length], |packet| {
                found.push(packet.and_then(|packet| sessions.open(packet)));
            }),
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => return found,
            Err(_) => {}
        }
    }
}

struct Pile {
    id: PileId,
    place: Position,
    core: ChargingPile,
    plant: Plant,
    socket: UdpSocket,
    sessions: Sessions<Vec<Session>>,
}

impl Pile {
    fn new(site: &Site, number: u16, coordinator: SocketAddr) -> Self {
        let id = PileId(number);
        let parameters = Parameters { eta: DurationMs(200), ..Parameters::new(id, 5_000.0) };
        Self {
            id,
            place: site.position(site.pile(id).unwrap().cell),
            core: ChargingPile::new(parameters),
            plant: Plant::new(),
            socket: socket(coordinator),
            sessions: sessions(DeviceId::Pile(id)),
        }
    }

    fn step(&mut self, now: Millis, robots: &[Robot], seen: &mut Seen) {
        let found = hear(&self.socket, &mut self.sessions);
        let docked = robots.iter().find(|robot| robot.docked == Some(self.id));
        let read = docked.map(|robot| PileInput::Tag(TagRead { tag: robot.config.tag, rssi_dbm: -40 }));
        let battery = Battery::new(1.0e6, 0.5e6);
        self.plant.battery = docked.is_some().then(|| self.plant.battery.unwrap_or(battery));
        let rest = [read.unwrap_or(PileInput::ReaderIdle), PileInput::Sensors(self.plant.sense(now))];
        let heard = found.iter().map(|found| match found {
            Ok(frame) => PileInput::Frame(frame),
            Err(error) => PileInput::Discarded(*error),
        });
        for input in heard.chain(rest) {
            let outputs = self.core.step(now, input);
            self.plant.command(outputs.power);
            for outgoing in outputs.messages {
                if outgoing.to == To::Coordinator {
                    send(&self.socket, &mut self.sessions, &outgoing.message);
                }
            }
            if let Some(lease) = self.core.leases().current() {
                let held = (self.id, lease.name.robot);
                assert_eq!(*seen.entry(lease.name.lease).or_insert(held), held, "a lease number came twice");
            }
        }
    }
}

struct Robot {
    config: RobotConfig,
    greeted: bool,
    socket: UdpSocket,
    sessions: Sessions<Vec<Session>>,
    /// Where it is when it is at no pile.
    home: Position,
    request: RequestId,
    docked: Option<PileId>,
    charged: bool,
    stranded: bool,
    /// When it asks again after a charge.
    rests_until: SiteMillis,
    say_at: SiteMillis,
}

impl Robot {
    fn new(site: &Site, number: u16, coordinator: SocketAddr) -> Self {
        let config = robot_config(number);
        let places: Vec<_> = site.grid.free_cells().collect();
        Self {
            config,
            socket: socket(coordinator),
            sessions: sessions(DeviceId::Robot(config.id)),
            greeted: false,
            home: site.position(places[usize::from(number) * 577 % places.len()]),
            request: RequestId(1),
            docked: None,
            charged: false,
            stranded: false,
            rests_until: SiteMillis(0),
            say_at: SiteMillis(0),
        }
    }

    /// Is at its pile at once, stays while it is charged, and asks again soon after.
    fn step(&mut self, now: SiteMillis, piles: &[Pile]) {
        let resting = now < self.rests_until;
        for found in hear(&self.socket, &mut self.sessions) {
            // A coordinator that has started anew does not believe, nor is it believed.
            self.greeted = found.is_ok();
            let Ok(frame) = found else { continue };
            match frame.message {
                Message::Assignment(part) if part.request == self.request && !resting => {
                    self.docked = Some(part.pile);
                }
                Message::Unassigned(answer) if answer.request == self.request && !self.charged => {
                    self.docked = None;
                }
                _ => {}
            }
        }
        let pile = self.docked.and_then(|id| piles.iter().find(|pile| pile.id == id));
        if let Some(pile) = pile {
            if pile.core.energised() {
                self.charged = true;
            } else if self.charged {
                self.docked = None;
                self.charged = false;
                self.request.0 += 1;
                self.rests_until = now.after(DurationMs(1_500));
                self.say_at = now;
            }
        }
        if now >= self.say_at {
            self.say_at = now.after(DurationMs(200));
            self.talk(now, pile.map_or(self.home, |pile| pile.place));
        }
    }

    fn talk(&mut self, now: SiteMillis, position: Position) {
        let energy = EnergyJ::new(5_000.0).unwrap();
        let (activity, accepted) = match self.docked {
            _ if self.stranded => (Activity::Stranded, None),
            Some(_) => (Activity::Docked, Some(self.request)),
            None if now < self.rests_until => (Activity::Working, None),
            None => (Activity::Waiting, None),
        };
        if !self.greeted {
            send(&self.socket, &mut self.sessions, &hello());
        }
        let state = RobotState { position, energy, activity, accepted };
        send(&self.socket, &mut self.sessions, &Message::RobotState(state));
        if activity == Activity::Waiting {
            let request = ChargeRequest {
                request: self.request,
                position,
                energy,
                task: None,
                priority: TaskPriority::USUAL,
            };
            send(&self.socket, &mut self.sessions, &Message::ChargeRequest(request));
        }
    }
}
