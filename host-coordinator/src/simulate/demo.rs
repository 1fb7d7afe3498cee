//! One process with everything in it: the coordinator's daemon, the simulated site, and the clock
//! that both live by.

use std::{
    io,
    net::{Ipv4Addr, SocketAddr},
    sync::Arc,
    time::{Duration, Instant},
};

use protocol::{Activity, DeviceId, Millis, SiteMillis};
use tempfile::TempDir;
use tokio::{sync::watch, time};

use super::{
    auditor::Claim,
    fleet::Fleet,
    report::{Planning, Report},
    simulation::{STEP, Simulation},
};
use crate::{
    config::{Config, Listen, Policy, Security},
    core::View,
    daemon::{ClockHand, Daemon, DaemonError, SiteClock},
    diagnostics::Diagnostics,
    keys::{Keys, KeysError},
    site::Site,
};

/// How many robots the demo has.
const ROBOTS: u16 = 10;
/// Timers are no finer than this.
const SHORTEST_PAUSE: Duration = Duration::from_millis(2);
/// After a stall this many pauses are caught up, the rest is forgiven: time then was slow.
const CATCH_UP: u32 = 4;
/// How often an overdue question for the time is repeated.
const ASK_AGAIN: Duration = Duration::from_millis(100);
/// A coordinator that leaves the question open for so long is broken.
const BROKEN: Duration = Duration::from_secs(30);

/// What a person may choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Simulated seconds in a real one; more than 0.
    pub speed: f64,
    /// Another seed gives other robots.
    pub seed: u64,
    /// Whether to serve no dashboard.
    pub headless: bool,
}

/// Why a demo does not run.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// The built-in site is broken.
    #[error(transparent)]
    Site(#[from] Diagnostics),
    /// There are no keys.
    #[error(transparent)]
    Keys(#[from] KeysError),
    /// There is no room for the event log.
    #[error("cannot make a temporary folder for the event log: {0}; free space or set TMPDIR")]
    Folder(io::Error),
    /// The coordinator does not start.
    #[error(transparent)]
    Daemon(#[from] DaemonError),
    /// The sockets of piles and robots.
    #[error(
        "cannot open a UDP socket on loopback for each pile and robot: {0}; raise the limit of open files"
    )]
    Sockets(io::Error),
    /// The coordinator does not answer.
    #[error("the coordinator has not answered for {} s; is the disk under {folder} full or very slow?", BROKEN.as_secs())]
    Silent {
        /// Where the event log is.
        folder: String,
    },
}

/// A running demo.
#[derive(Debug)]
pub struct Demo {
    daemon: Daemon,
    view: watch::Receiver<Arc<View>>,
    hand: ClockHand,
    simulation: Simulation,
    speed: f64,
    /// Holds the event log; removed at the end.
    folder: TempDir,
}

/// New keys for everyone, never in a file.
fn keys(site: &Site, fleet: &Fleet) -> Result<Keys, KeysError> {
    let mut keys = Keys::default();
    keys.make_site()?;
    let piles = site.piles.iter().map(|pile| DeviceId::Pile(pile.id));
    let robots = fleet.configs.iter().map(|robot| DeviceId::Robot(robot.id));
    piles.chain(robots).try_for_each(|device| keys.make(device).map(drop))?;
    Ok(keys)
}

/// How far a demo has come.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// The simulated time since the start.
    pub now: Millis,
    /// What the robots do.
    pub robots: Vec<Activity>,
    /// Charges given in full.
    pub charges_completed: u64,
}

impl Demo {
    /// Starts a coordinator with an event log in a temporary folder, all piles and all robots.
    ///
    /// # Errors
    /// [`DemoError`] says what is missing.
    pub async fn start(options: Options) -> Result<Self, DemoError> {
        let site = Arc::new(Site::fig7()?);
        let fleet = Fleet::new(&site, ROBOTS, options.seed);
        let folder = TempDir::with_prefix("chargehand-demo-").map_err(DemoError::Folder)?;
        let keys = keys(&site, &fleet)?;
        let any_port = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let http = (!options.headless).then_some(Listen::default().http).flatten();
        let mut config = Config {
            site: "sites/lmpp-fig7".into(),
            event_log: folder.path().join("events.sqlite"),
            security: Security::Keys(keys.clone()),
            listen: Listen { http, udp: any_port, tcp: any_port },
            policy: Policy::default(),
            robots: fleet.configs.clone(),
            connect: Vec::new(),
        };
        let (clock, hand) = SiteClock::moved_by_hand(SiteMillis(0), options.speed);
        let daemon = match Daemon::start(Arc::clone(&site), &config, clock.clone()).await {
            Err(DaemonError::Listen { address, .. }) if Some(address) == http => {
                config.listen.http = Some(any_port);
                Daemon::start(site, &config, clock).await?
            }
            started => started?,
        };
        let simulation =
            Simulation::start(fleet, daemon.addresses().udp, &keys).await.map_err(DemoError::Sockets)?;
        let view = daemon.view();
        Ok(Self { daemon, view, hand, simulation, speed: options.speed, folder })
    }

    /// Where the dashboard is, if there is one.
    #[must_use]
    pub const fn dashboard(&self) -> Option<SocketAddr> {
        self.daemon.addresses().http
    }

    /// The simulated time since the start.
    #[must_use]
    pub const fn now(&self) -> Millis {
        self.simulation.now()
    }

    /// Runs until `end`, or for ever, and tells how far it is after every pause. Can be dropped
    /// at any await and called again.
    ///
    /// # Errors
    /// [`DemoError::Silent`] if the coordinator is broken.
    pub async fn run(
        &mut self,
        end: Option<Millis>,
        mut tell: impl FnMut(Progress),
    ) -> Result<(), DemoError> {
        let step = Duration::from_millis(STEP.0.into());
        let pause = step.div_f64(self.speed).max(SHORTEST_PAUSE);
        let mut ticks = time::interval(pause);
        ticks.set_missed_tick_behavior(time::MissedTickBehavior::Delay);
        let mut owed = Duration::ZERO;
        let mut last = Instant::now();
        let mut lively = last;
        while end.is_none_or(|end| self.simulation.now() < end) {
            ticks.tick().await;
            let passed = last.elapsed().min(pause * CATCH_UP);
            last = Instant::now();
            owed += passed.mul_f64(self.speed);
            while owed >= step && end.is_none_or(|end| self.simulation.now() < end) {
                if self.simulation.waits_for_the_coordinator() {
                    owed = Duration::ZERO;
                    self.ask_again(lively).await?;
                    break;
                }
                lively = last;
                owed -= step;
                self.step();
            }
            tell(self.progress());
        }
        Ok(())
    }

    /// Ends the demo and sums it up.
    pub async fn finish(mut self) -> (Report, Vec<String>) {
        let now = self.simulation.now();
        // The picture may be a moment old. Should no newer one come, the old one has to do.
        let up_to_date = self.view.wait_for(|view| view.now_ms >= now.0);
        let _ = time::timeout(Duration::from_secs(2), up_to_date).await;
        let totals = self.view.borrow().totals;
        let planning = self.daemon.planning_times();
        let violations: Vec<String> =
            self.simulation.auditor().violations().map(ToString::to_string).collect();
        let stranded =
            self.simulation.activities().filter(|&activity| activity == Activity::Stranded).count();
        let report = Report {
            charges_completed: totals.charges_completed,
            mean_wait_s: totals.mean_wait_s,
            worst_wait_s: totals.worst_wait_s,
            stranded,
            double_grants: violations.len(),
            planning_us: Planning { p50: planning.quantile(0.5), p99: planning.quantile(0.99) },
        };
        self.daemon.shutdown().await;
        (report, violations)
    }

    fn step(&mut self) {
        self.hand.set(SiteMillis(self.simulation.now().after(STEP).0));
        self.simulation.step();
        if self.view.has_changed().unwrap_or(false) {
            let view = Arc::clone(&self.view.borrow_and_update());
            for pile in &view.piles {
                let Some(lease) = pile.lease.filter(|lease| lease.phase == "held") else { continue };
                let claim = Claim { at: Millis(view.now_ms), pile: pile.id, granted: lease.robot };
                self.simulation.auditor().hear(claim);
            }
        }
    }

    /// The question for the time, or its answer, may have been lost on the way.
    async fn ask_again(&mut self, lively: Instant) -> Result<(), DemoError> {
        if lively.elapsed() > BROKEN {
            return Err(DemoError::Silent { folder: self.folder.path().display().to_string() });
        }
        if lively.elapsed() > ASK_AGAIN {
            self.simulation.ask_time();
            time::sleep(ASK_AGAIN).await;
        }
        Ok(())
    }

    fn progress(&self) -> Progress {
        Progress {
            now: self.simulation.now(),
            robots: self.simulation.activities().collect(),
            charges_completed: self.view.borrow().totals.charges_completed,
        }
    }
}
