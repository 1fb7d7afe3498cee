//! `chargehand keys`, and a coordinator that has them or not.
#![cfg(unix)]

use std::{fs, os::unix::fs::PermissionsExt as _};

use host_coordinator::keys::Keys;
use protocol::{DeviceId, PileId, RobotId};

use super::{chargehand, fig7_with, text};

#[test]
fn a_configuration_is_ready_once_its_keys_are_made_and_nobody_else_can_read_them() {
    let copy = fig7_with("site.toml", "", "");
    let config = copy.path().join("chargehand.toml");
    let file = copy.path().join("keys.toml");
    fs::remove_file(&file).unwrap();
    let check = || chargehand(&["check", "--config", text(&config)]);
    let error = check().fails();
    assert!(
        error.contains("keys.toml: cannot be read") && error.contains("`chargehand keys --site"),
        "{error}"
    );

    let said = chargehand(&["keys", "--site", text(copy.path())]).succeeds();
    assert!(said.contains("keys.toml has the site's key"), "{said}");
    check().succeeds();
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);

    fs::set_permissions(&file, fs::Permissions::from_mode(0o644)).unwrap();
    let error = check().fails();
    assert!(error.contains("mode 0644") && error.contains("chmod 600"), "{error}");
}

#[test]
fn a_robot_gets_a_key_once_and_its_computer_that_key_alone() {
    let copy = fig7_with("site.toml", "", "");
    let site = Keys::change(&copy.path().join("keys.toml"), |keys| keys.make(DeviceId::Pile(PileId(1))));
    let carried = copy.path().join("robot-3.toml");
    let make = ["keys", "--site", text(copy.path()), "--robot", "3", "--out", text(&carried)];
    let said = chargehand(&make).succeeds();
    let robot = DeviceId::Robot(RobotId(3));
    let (all, own) = (Keys::load(&copy.path().join("keys.toml")).unwrap(), Keys::load(&carried).unwrap());
    assert_eq!(all.of(DeviceId::Pile(PileId(1))), Some(site.unwrap()));
    assert!(own.of(robot).is_some() && own.of(robot) == all.of(robot));
    assert_eq!(own, all.only(robot));
    // No key is printed.
    let written = fs::read_to_string(&carried).unwrap();
    let secret = written.split('"').nth(1).unwrap();
    assert_eq!(secret.len(), 64);
    assert!(!said.contains(secret), "{said}");

    chargehand(&make).succeeds();
    assert_eq!(Keys::load(&carried).unwrap(), own);

    // A robot's file is none to run a coordinator with.
    fs::copy(&carried, copy.path().join("keys.toml")).unwrap();
    let error = chargehand(&["check", "--config", text(&copy.path().join("chargehand.toml"))]).fails();
    assert!(error.contains("keys.toml: it has no `site`"), "{error}");
}
