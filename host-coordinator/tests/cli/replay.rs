//! `chargehand replay`: what was known when, and what another policy would have decided.

use std::{path::PathBuf, sync::Arc};

use host_coordinator::{
    config::Config,
    core::{Coordinator, Input},
    store::Store,
};
use protocol::{
    Availability, BootEpoch, ChargeRequest, DeviceId, DurationMs, EnergyJ, Fraction, Frame, Header, Message,
    PileId, PileRow, PileState, RequestId, RobotId, Sequence, SiteMillis, TaskPriority,
};
use tempfile::TempDir;

use super::{chargehand, copy_of, fig7, json, text};

/// Half past two on the afternoon of 2026-11-25.
const BEGIN: SiteMillis = SiteMillis(1_795_617_000_000);

/// A site's folder with its configuration, and a log in which a robot asks one minute after the beginning.
fn site_with_log() -> (TempDir, PathBuf, PathBuf) {
    let folder = copy_of(&fig7());
    let config_file = folder.path().join("chargehand.toml");
    let log = folder.path().join("afternoon.sqlite");
    let (config, site) = Config::load(&config_file).unwrap();
    let (site, policy) = (Arc::new(site), config.policy);
    let mut coordinator = Coordinator::recover(Arc::clone(&site), site.lmpp(1.0), policy, &config.robots, []);
    let (mut store, _) = Store::open(&log).unwrap();
    let mut step = |at: SiteMillis, input| store.append(&coordinator.step(at, input).events).unwrap();
    step(BEGIN, Input::Started { boot_floor: BootEpoch(1) });
    let frame = |sender, sequence, message| {
        Input::Frame(Frame { header: Header::new(sender, BootEpoch(1), Sequence(sequence)), message })
    };
    let asked_at = BEGIN.after(DurationMs(60_000));
    // Pile 2, where the robot stands, is not heard.
    for pile in site.piles.iter().filter(|pile| pile.id != PileId(2)) {
        step(asked_at, frame(DeviceId::Pile(pile.id), 1, Message::PileState(idle(pile.id))));
    }
    let position = site.position(site.piles[1].cell);
    let asked = ChargeRequest {
        request: RequestId(1),
        position,
        energy: EnergyJ::new(60_000.0).unwrap(),
        task: None,
        priority: TaskPriority::USUAL,
    };
    step(asked_at, frame(DeviceId::Robot(RobotId(1)), 1, Message::ChargeRequest(asked)));
    (folder, config_file, log)
}

fn idle(pile: PileId) -> PileState {
    let row = PileRow {
        pile,
        boot: BootEpoch(1),
        version: 1,
        stamp: None,
        availability: Availability::Free,
        remaining: Fraction::default(),
        planned: DurationMs(0),
    };
    PileState {
        row,
        elapsed: DurationMs(0),
        holder: None,
        energised: false,
        ended: None,
        standing: None,
        current: None,
    }
}

#[test]
fn what_was_known_is_told_up_to_an_instant_in_each_form() {
    let (_folder, _, log) = site_with_log();
    let whole = json(&["replay", text(&log)]);
    assert_eq!(whole["standing"]["requests"][0]["robot"], 1);
    assert_eq!(whole["standing"]["requests"][0]["place"], "granted");
    assert_eq!(whole["standing"]["piles"][0]["lease"]["phase"], "offered");
    for until in ["59s", "2026-11-25T14:30:59Z", "1795617059000"] {
        let before = json(&["replay", text(&log), "--until", until]);
        assert_eq!(before["standing"]["requests"].as_array().unwrap().len(), 0, "{until}");
        assert!(before["events"].as_u64() < whole["events"].as_u64());
    }
    let told = chargehand(&["replay", text(&log)]).succeeds();
    assert!(told.contains("from 2026-11-25T14:30:00Z to 2026-11-25T14:31:00Z"), "{told}");
}

#[test]
fn a_decision_is_taken_anew_by_another_policy_and_the_log_stays_as_it_is() {
    let (_folder, config, log) = site_with_log();
    let before = std::fs::read(&log).unwrap();
    let replay = |what_if: &str| {
        json(&["replay", text(&log), "--config", text(&config), "--what-if", what_if])["what_if"].clone()
    };
    let same = replay("choose=nearest");
    assert_eq!((&same["decisions"], &same["repeated"], &same["untold"]), (&1.into(), &1.into(), &0.into()));
    assert_eq!(same["differ"].as_array().unwrap().len(), 0, "pile 5 is the nearest too: {same}");
    // Without doors 1 and 6 the way to pile 5 is longer than that to pile 3; without 2 there is none.
    for (what_if, pile) in [("theta=0.3", 3.into()), ("theta=0.1", serde_json::Value::Null)] {
        let differ = &replay(what_if)["differ"][0];
        assert_eq!((&differ["was"]["pile"], &differ["would_be"]["pile"]), (&5.into(), &pile), "{differ}");
    }
    let told = chargehand(&["replay", text(&log), "--config", text(&config), "--what-if", "theta=0.3"]);
    let told = told.succeeds();
    assert!(told.contains("1 of 1 decisions come out as in the log when nothing is changed"), "{told}");
    assert!(told.contains("pile 5  pile 3"), "{told}");
    assert_eq!(std::fs::read(&log).unwrap(), before);
}

#[test]
fn what_cannot_be_replayed_says_why() {
    let (folder, config, log) = site_with_log();
    let error = chargehand(&["replay", text(&log), "--until", "2026-11-25T14:29:00Z"]).fails();
    assert!(error.contains("afternoon.sqlite has no event until then"), "{error}");
    let error = chargehand(&["replay", text(&log), "--until", "yesterday"]).fails();
    assert!(error.contains("2026-11-25T14:30:00Z"), "{error}");
    let error = chargehand(&["replay", text(&log), "--what-if", "theta=0.3"]).fails();
    assert!(error.contains("--config"), "{error}");
    let error = chargehand(&["replay", text(&log), "--config", text(&config), "--what-if", "tau=1"]).fails();
    assert!(error.contains("theta=F, q_threshold=F or choose=POLICY"), "{error}");
    let missing = folder.path().join("none.sqlite");
    let error = chargehand(&["replay", text(&missing)]).fails();
    assert!(error.contains("none.sqlite"), "{error}");
}
