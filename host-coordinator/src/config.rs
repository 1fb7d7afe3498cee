//! What `chargehand run` is told by its configuration file.
//!
//! Paths in the file are relative to the file. Everything but `site`, `event_log` and the robots
//! has a default.

use std::{
    fs,
    net::{Ipv4Addr, SocketAddr},
    path::{Path, PathBuf},
};

use protocol::{DurationMs, EnergyJ, PileId, RobotId, TagId};

use crate::{
    diagnostics::{Diagnostic, Diagnostics},
    document::{self, Document, Section, flag, number, parsed, text, whole},
    keys::Keys,
    selection::PolicyName,
    site::Site,
};

/// A coordinator's configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The folder of the site.
    pub site: PathBuf,
    /// The SQLite file of the event log; it is made if it is not there.
    pub event_log: PathBuf,
    /// Whom it believes.
    pub security: Security,
    /// Where the coordinator can be reached.
    pub listen: Listen,
    /// How it decides.
    pub policy: Policy,
    /// The robots it serves.
    pub robots: Vec<RobotConfig>,
    /// The piles that it calls by TCP; the others call it.
    pub connect: Vec<(PileId, SocketAddr)>,
}

/// Whom a coordinator believes.
#[derive(Clone, Debug, PartialEq)]
pub enum Security {
    /// Who has the key that belongs to it.
    Keys(Keys),
    /// Anyone who can reach it.
    Insecure,
}

/// Where the coordinator can be reached. By default on this computer only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listen {
    /// The dashboard and its API; `None` serves none.
    pub http: Option<SocketAddr>,
    /// Piles and robots by UDP.
    pub udp: SocketAddr,
    /// Piles and robots by TCP.
    pub tcp: SocketAddr,
}

impl Default for Listen {
    fn default() -> Self {
        let local = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        Self { http: Some(local(8480)), udp: local(8481), tcp: local(8481) }
    }
}

/// How the coordinator decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy {
    /// How piles are chosen for robots that wait.
    pub choose: PolicyName,
    /// Doors whose congestion exceeds this are not used (LMPP's theta, eq. 11); from 1 on all
    /// doors are.
    pub theta: f64,
    /// A charge this far done counts as almost done (LMPP's q_th), 0 to 1.
    pub q_threshold: f64,
    /// How long a lease lasts before it is extended.
    pub lease: DurationMs,
    /// No more power than this is given to all piles together, in watts; `None` for no limit.
    pub power_cap_w: Option<f64>,
}

impl Default for Policy {
    fn default() -> Self {
        Self {
            choose: PolicyName::default(),
            theta: 1.0,
            q_threshold: 0.9,
            lease: DurationMs(60_000),
            power_cap_w: None,
        }
    }
}

/// One robot of the fleet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotConfig {
    /// Which robot.
    pub id: RobotId,
    /// The RFID tag it carries.
    pub tag: TagId,
    /// The energy of its full battery.
    pub full: EnergyJ,
    /// The energy it takes to drive a metre, in joules; more than 0.
    pub energy_per_metre_j: f32,
    /// How fast it drives, in metres a second; more than 0.
    pub speed_mps: f32,
    /// What it gives another robot as a mobile charger, in watts; `None` if it is none.
    pub gives_w: Option<f32>,
}

/// How fast a robot drives whose configuration does not say so, in metres a second.
pub const USUAL_SPEED_MPS: f32 = 0.5;

impl Config {
    /// Reads the configuration in `file` and the site that it names.
    ///
    /// # Errors
    /// Every mistake in their files.
    pub fn load(file: &Path) -> Result<(Self, Site), Diagnostics> {
        document::read(file, fs::read_to_string(file), |document, root| {
            let (config, pile_lines) = config(document, root)?;
            let site = Site::load(&config.site);
            let site = site.map_err(|found| document.mistake_elsewhere(found.into_mistakes())).ok()?;
            for (&(pile, _), line) in config.connect.iter().zip(pile_lines) {
                if site.pile(pile).is_none() {
                    let problem = format!("pile {pile} is not in the site");
                    document.mistake(line, problem, format!("a pile of {}", config.site.display()));
                }
            }
            Some((config, site))
        })
    }
}

/// The configuration, and the lines in which the piles to call stand.
fn config(document: &Document<'_>, mut root: Section<'_>) -> Option<(Config, Vec<usize>)> {
    let site = root.required("site", &text());
    let event_log = root.required("event_log", &text());
    let security = security(document, &mut root);
    let listen = listen(root.table("listen"));
    let policy = policy(root.table("policy"));
    let robots = robots(root.tables("robot"));
    let (connect, pile_lines) = connect(root.tables("pile")).into_iter().unzip();
    let (site, event_log) = (document.resolve(&site?), document.resolve(&event_log?));
    let security = security?;
    Some((Config { site, event_log, security, listen, policy, robots, connect }, pile_lines))
}

fn security(document: &Document<'_>, root: &mut Section<'_>) -> Option<Security> {
    let insecure = root.optional("insecure", &flag());
    let keys = root.optional("keys", &text());
    match (keys, insecure == Some(true)) {
        (None, true) => Some(Security::Insecure),
        (Some(file), false) => {
            let file = document.resolve(&file);
            let keys = Keys::load(&file);
            let keys = keys.map_err(|found| document.mistake_elsewhere(found.into_mistakes())).ok()?;
            if !keys.is_a_site_s() {
                let expected = "the site's file of keys, not that of one of its robots";
                document.mistake_elsewhere([Diagnostic::new(&file, None, "it has no `site`", expected)]);
            }
            Some(Security::Keys(keys))
        }
        (Some(_), true) => {
            root.mistake("insecure", "`insecure` is true and there are `keys`", "one of the two");
            None
        }
        (None, false) => {
            root.mistake(
                "keys",
                "the file has no `keys`",
                "`keys = \"keys.toml\"`, a file that `chargehand keys` makes, or `insecure = true` to believe \
                 whoever can reach this coordinator",
            );
            None
        }
    }
}

fn listen(mut section: Section<'_>) -> Listen {
    let default = Listen::default();
    let address = || parsed("an address and port such as \"127.0.0.1:8480\"");
    Listen {
        http: section.optional("http", &address()).or(default.http),
        udp: section.optional("udp", &address()).unwrap_or(default.udp),
        tcp: section.optional("tcp", &address()).unwrap_or(default.tcp),
    }
}

fn policy(mut section: Section<'_>) -> Policy {
    const NAMES: &str = "\"joint\", \"lmpp\", \"lmpp-literal\", \"access\" or \"nearest\"";
    let default = Policy::default();
    let lease_s = section.optional("lease_s", &number(5.0..=86_400.0));
    Policy {
        power_cap_w: section.optional("power_cap_w", &number(1.0..=1.0e9)),
        choose: section.optional("choose", &parsed(NAMES)).unwrap_or(default.choose),
        theta: section.optional("theta", &number(0.0..=f64::INFINITY)).unwrap_or(default.theta),
        q_threshold: section.optional("q_threshold", &number(0.0..=1.0)).unwrap_or(default.q_threshold),
        lease: lease_s.map_or(default.lease, |seconds| DurationMs::from_seconds(seconds as f32)),
    }
}

fn robots(sections: Vec<Section<'_>>) -> Vec<RobotConfig> {
    let mut robots = Vec::new();
    let (mut ids, mut tags) = (Vec::new(), Vec::new());
    for mut section in sections {
        let id = section.required("id", &whole(0..=u16::MAX.into())).map(RobotId);
        let tag = section.required("tag", &parsed("a tag of 24 hexadecimal digits in quotes"));
        let full = section.required("full_j", &number(1.0..=EnergyJ::MAX.get().into()));
        let energy_per_metre_j = section.required("energy_per_metre_j", &number(0.001..=1.0e6));
        let gives_w = section.optional("gives_w", &number(1.0..=1.0e6)).map(|watts| watts as f32);
        let speed_mps = section.optional("speed_mps", &number(0.01..=100.0));
        if let Some(id) = id.filter(|id| ids.contains(id)) {
            section.mistake("id", format!("robot {id} is there twice"), "one [[robot]] for each robot");
        }
        if let Some(tag) = tag.filter(|tag| tags.contains(tag)) {
            section.mistake("tag", format!("tag {tag} is there twice"), "a tag of its own for each robot");
        }
        ids.extend(id);
        tags.extend(tag);
        if let (Some(id), Some(tag), Some(full), Some(per_metre)) = (id, tag, full, energy_per_metre_j) {
            let full = EnergyJ::clamped(full as f32);
            let speed_mps = speed_mps.map_or(USUAL_SPEED_MPS, |speed| speed as f32);
            let energy_per_metre_j = per_metre as f32;
            robots.push(RobotConfig { id, tag, full, energy_per_metre_j, speed_mps, gives_w });
        }
    }
    robots
}

fn connect(sections: Vec<Section<'_>>) -> Vec<((PileId, SocketAddr), usize)> {
    let (mut connect, mut ids) = (Vec::new(), Vec::new());
    for mut section in sections {
        let id = section.required("id", &whole(0..=u16::MAX.into())).map(PileId);
        let address = section.required("address", &parsed("an address and port such as \"10.0.0.7:8481\""));
        if let Some(id) = id.filter(|id| ids.contains(id)) {
            section.mistake("id", format!("pile {id} is there twice"), "one [[pile]] for each pile");
        }
        ids.extend(id);
        connect.extend(id.zip(address).zip(Some(section.line_of("id"))));
    }
    connect
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const EXAMPLE: &str = include_str!("../../sites/lmpp-fig7/chargehand.toml");
    const KEYS: &str = "keys = \"keys.toml\"";

    /// The example in a folder where there are no keys.
    fn example() -> String {
        assert!(EXAMPLE.contains(KEYS));
        EXAMPLE.replace(KEYS, "insecure = true")
    }

    fn read(text: String) -> Result<Config, Diagnostics> {
        document::read(Path::new("x.toml"), Ok(text), |document, root| Some(config(document, root)?.0))
    }

    #[test]
    fn the_example_says_what_the_defaults_are() {
        let example = read(example()).unwrap();
        assert_eq!((example.listen, example.policy), (Listen::default(), Policy::default()));
        let least = read("site = \".\"\nevent_log = \"log\"\ninsecure = true".into()).unwrap();
        assert_eq!((least.listen, least.policy), (example.listen, example.policy));
    }

    #[test]
    fn a_coordinator_without_keys_is_one_by_name() {
        let found = |security: &str| {
            let text = example().replace("insecure = true", security);
            read(text).map(|config| config.security).map_err(|found| found.to_string())
        };
        assert_eq!(found("insecure = true"), Ok(Security::Insecure));
        for neither in ["", "insecure = false"] {
            let error = found(neither).unwrap_err();
            assert!(
                error.contains("`keys = \"keys.toml\"`") && error.contains("`insecure = true`"),
                "{error}"
            );
        }
        let error = found("insecure = true\nkeys = \"src/lib.rs\"").unwrap_err();
        assert!(error.contains("one of the two"), "{error}");
        let error = found("keys = \"no-such.toml\"").unwrap_err();
        assert!(
            error.contains("no-such.toml: cannot be read") && error.contains("`chargehand keys"),
            "{error}"
        );
    }

    proptest! {
        #[test]
        fn a_spoilt_file_is_read_or_refused_without_panic(
            start: prop::sample::Index, length in 0usize..40, replacement in "[\\[\\]{}\"'=.,#0-9a-z\u{e9}\n -]{0,8}",
        ) {
            let example = example();
            let start = start.index(example.len());
            let end = (start + length).min(example.len());
            let spoilt = [&example[..start], &replacement, &example[end..]].concat();
            if let Err(found) = read(spoilt) {
                prop_assert!(!found.mistakes().is_empty());
            }
        }
    }
}
