//! The shell around the core: clock, sockets, event log, API.
//!
//! ```text
//!   links (UDP, TCP) --frames--> engine thread --view--> API (HTTP, WebSocket)
//!      ^                            |  core.step, then log, then
//!      `----------- messages -------'
//! ```
//! The core and its log run on a thread of their own, because planning computes and a disk blocks.
//! [`Daemon`] is what `chargehand run`, the demo and tests start in their own process:
//!
//! ```no_run
//! use std::{path::Path, sync::Arc};
//! use host_coordinator::{config::Config, daemon::{Daemon, SiteClock}};
//!
//! # async fn run() -> Result<(), Box<dyn std::error::Error>> {
//! let (config, site) = Config::load(Path::new("chargehand.toml"))?;
//! let daemon = Daemon::start(Arc::new(site), &config, SiteClock::real()).await?;
//! println!("{:?}", daemon.addresses());
//! println!("{} robots wait", daemon.view().borrow().totals.waiting);
//! daemon.shutdown().await;
//! # Ok(())
//! # }
//! ```

mod clock;
mod engine;
mod planning_times;
mod questions;
pub mod warnings;

use std::{
    collections::BTreeSet,
    io,
    net::SocketAddr,
    sync::{Arc, Mutex, PoisonError},
    thread,
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use protocol::{BootEpoch, DeviceId, DurationMs, Sessions, Trust};
use tokio::{
    net::{TcpListener, UdpSocket},
    sync::{mpsc, oneshot, watch},
    task::JoinSet,
    time,
};

pub use clock::{ClockHand, SiteClock};
pub use engine::Ordered;
pub use planning_times::PlanningTimes;
pub use questions::{Desk, OrderOutcome, Unanswered};

use self::{engine::Engine, questions::Questions, warnings::Warnings};
use crate::{
    api,
    config::{Config, Security},
    core::{Coordinator, Input, View},
    links::{self, Links, Sockets},
    memory,
    site::Site,
    store::{Store, StoreError},
};

/// How often time is told to the core, on the site's clock, but not more often than a computer can.
const TICK: (DurationMs, Duration) = (DurationMs(200), Duration::from_millis(2));
/// How often the view is renewed, in real time.
const VIEW_INTERVAL: Duration = Duration::from_millis(100);
/// Frames that wait for the core.
const INBOX: usize = 1024;
/// Frames of which the events are recorded together.
const BATCH: usize = 128;
/// How long to wait before an unwritable log is tried again.
const RETRY: Duration = Duration::from_millis(250);

/// A running coordinator. Dropping it stops it too, without waiting for its end.
#[derive(Debug)]
pub struct Daemon {
    addresses: Addresses,
    view: watch::Receiver<Arc<View>>,
    planning: Arc<Mutex<PlanningTimes>>,
    tasks: JoinSet<()>,
    engine: oneshot::Receiver<()>,
}

/// Where a coordinator can be reached, with the ports that the system chose for port 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Addresses {
    /// The dashboard and its API, if they are served.
    pub http: Option<SocketAddr>,
    /// Piles and robots by UDP.
    pub udp: SocketAddr,
    /// Piles and robots by TCP.
    pub tcp: SocketAddr,
}

/// Why a coordinator does not start.
#[derive(Debug, thiserror::Error)]
pub enum DaemonError {
    /// An address is not to be had.
    #[error(
        "cannot listen on {address} for {what}: {cause}; free it or configure another one under [listen]"
    )]
    Listen {
        /// What for.
        what: &'static str,
        /// Where.
        address: SocketAddr,
        /// What the system says.
        cause: io::Error,
    },
    /// The event log is not to be had.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The system gives no thread.
    #[error("cannot start a thread: {0}; the computer is out of memory or threads")]
    Thread(io::Error),
}

impl Daemon {
    /// Starts a coordinator for `site` as `config` says (its `site` folder is not read again).
    /// The event log is `config.event_log`; times in it are of `clock`.
    ///
    /// # Errors
    /// [`DaemonError`] if an address or the event log is not to be had.
    pub async fn start(site: Arc<Site>, config: &Config, clock: SiteClock) -> Result<Self, DaemonError> {
        let (sockets, http, addresses) = bind(config).await?;
        let warnings = Warnings::default();
        let planning = Arc::new(Mutex::new(PlanningTimes::default()));

        let (store, events) = Store::open(&config.event_log)?;
        let memory = memory::recall_or_plan(&site, &config.event_log);
        let coordinator =
            Coordinator::recover(Arc::clone(&site), memory, config.policy, &config.robots, &events);
        let insecure = config.security == Security::Insecure;
        let mut engine = Engine::new(coordinator, store, warnings.clone(), Arc::clone(&planning), insecure);
        // Nobody is connected yet: there is no one to send to.
        engine.take(clock.now(), Input::Started { boot_floor: boot_floor() }, &mut |_, _| {});
        engine.commit(&mut |_, _| {})?;

        let piles = site.piles.iter().map(|pile| DeviceId::Pile(pile.id));
        let robots = config.robots.iter().map(|robot| DeviceId::Robot(robot.id));
        let known: BTreeSet<_> = piles.chain(robots).collect();
        let boot = engine.coordinator().state().boot;
        let sessions = match &config.security {
            Security::Keys(keys) => {
                known.iter().filter(|device| keys.of(**device).is_none()).for_each(|device| {
                    warnings.note(format!(
                        "{device} has no key and is not heard: `chargehand provision` gives one to a pile, \
                         `chargehand keys` to a robot"
                    ));
                });
                keys.sessions(boot)
            }
            Security::Insecure => {
                tracing::warn!(
                    "INSECURE: this coordinator has no keys and believes whoever can reach it; \
                     `keys = ...` in its configuration ends that"
                );
                Sessions::new(DeviceId::Coordinator, boot, Trust::Insecure)
            }
        };
        let (inputs, inbox) = mpsc::channel(INBOX);
        let (links, mut tasks) =
            links::start(sockets, known, sessions, &config.connect, inputs.clone(), warnings);

        let name = site.name.clone();
        let (publish, view) = watch::channel(Arc::new(engine.view(clock.now())));
        let (desk, questions) = Desk::new();
        if let Some(http) = http {
            tasks.spawn(api::serve(http, view.clone(), desk, site));
        }
        tasks.spawn(tell_time(clock.clone(), inputs));
        let (ended, engine_end) = oneshot::channel();
        let shell = Shell { engine, links, clock, inbox, questions, publish, published: Instant::now() };
        thread::Builder::new()
            .name("coordinator".to_owned())
            .spawn(move || {
                shell.run();
                // Nobody may wait for the end.
                let _ = ended.send(());
            })
            .map_err(DaemonError::Thread)?;
        let Addresses { http, udp, tcp } = addresses;
        tracing::info!(
            "site {}: piles and robots udp://{udp} and tcp://{tcp}, event log {}",
            name,
            config.event_log.display()
        );
        if let Some(http) = http {
            tracing::info!("dashboard http://{http}");
        }
        Ok(Self { addresses, view, planning, tasks, engine: engine_end })
    }

    /// Where it can be reached.
    #[must_use]
    pub const fn addresses(&self) -> Addresses {
        self.addresses
    }

    /// The picture of the site, renewed up to ten times a second.
    #[must_use]
    pub fn view(&self) -> watch::Receiver<Arc<View>> {
        self.view.clone()
    }

    /// How long decisions took so far.
    #[must_use]
    pub fn planning_times(&self) -> PlanningTimes {
        self.planning.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Stops: hangs up on everyone, and returns when the log is closed.
    pub async fn shutdown(mut self) {
        self.tasks.shutdown().await;
        // An error means that the thread is gone already.
        let _ = self.engine.await;
    }
}

/// The time in seconds since 1970: greater than in any start before, unless somebody has set the clock
/// back. Not the site's time, which may be simulated.
fn boot_floor() -> BootEpoch {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
    BootEpoch(u32::try_from(seconds).unwrap_or(0))
}

async fn bind(config: &Config) -> Result<(Sockets, Option<TcpListener>, Addresses), DaemonError> {
    let listen = config.listen;
    let taken = |what, address| move |cause| DaemonError::Listen { what, address, cause };
    let udp = UdpSocket::bind(listen.udp).await.map_err(taken("UDP", listen.udp))?;
    let tcp = TcpListener::bind(listen.tcp).await.map_err(taken("TCP", listen.tcp))?;
    let mut http = None;
    if let Some(address) = listen.http {
        http = Some(TcpListener::bind(address).await.map_err(taken("the dashboard", address))?);
    }
    let addresses = Addresses {
        http: http.as_ref().and_then(|http| http.local_addr().ok()),
        udp: udp.local_addr().map_err(taken("UDP", listen.udp))?,
        tcp: tcp.local_addr().map_err(taken("TCP", listen.tcp))?,
    };
    Ok((Sockets { udp, tcp }, http, addresses))
}

/// Tells the core that time passes; a tick that it has no time for is left out.
async fn tell_time(clock: SiteClock, inputs: mpsc::Sender<Input>) {
    let mut interval = time::interval(clock.really(TICK.0).max(TICK.1));
    interval.set_missed_tick_behavior(time::MissedTickBehavior::Skip);
    while inputs.send(Input::Tick).await.is_ok() {
        interval.tick().await;
    }
}

/// The thread of the core and its log.
struct Shell {
    engine: Engine,
    links: Arc<Links>,
    clock: SiteClock,
    inbox: mpsc::Receiver<Input>,
    questions: Questions,
    publish: watch::Sender<Arc<View>>,
    published: Instant,
}

impl Shell {
    /// Runs until the tasks that bring inputs are gone.
    fn run(mut self) {
        let links = Arc::clone(&self.links);
        let mut send = |to, message| links.send(to, &message);
        while let Some(first) = self.inbox.blocking_recv() {
            self.engine.take(self.clock.now(), first, &mut send);
            for _ in 1..BATCH {
                let Ok(input) = self.inbox.try_recv() else { break };
                self.engine.take(self.clock.now(), input, &mut send);
            }
            if self.engine.commit(&mut send).is_err() {
                self.recover(&mut send);
            }
            if self.questions.answer(&mut self.engine, &self.clock, &mut send).is_err() {
                self.recover(&mut send);
            }
            if self.published.elapsed() >= VIEW_INTERVAL {
                self.publish();
            }
        }
    }

    /// Tries again until the log can be written. What comes in the meantime is not heard: it
    /// would be old by then, and everything worth saying is said again.
    fn recover(&mut self, send: &mut dyn FnMut(DeviceId, protocol::Message)) {
        self.publish();
        while !self.inbox.is_closed() && self.engine.commit(send).is_err() {
            thread::sleep(RETRY);
            while self.inbox.try_recv().is_ok() {}
            self.publish();
        }
        self.publish();
    }

    fn publish(&mut self) {
        self.published = Instant::now();
        self.publish.send_replace(Arc::new(self.engine.view(self.clock.now())));
    }
}
