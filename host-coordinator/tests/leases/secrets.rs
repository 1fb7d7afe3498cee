//! The keys of a site, and what devices know by them.

use firmware_pile::store::Identity;
use protocol::{
    BootEpoch, CurrentA, DeviceId, DurationMs, Key, Message, PileId, PileParameters, PowerW, Recipient,
    RobotId, SealError, Session, Sessions, TemperatureC, Trust, VoltageV,
};

use crate::box_site::POWER_W;

pub const SITE_KEY: Key = Key::new([0x5A; 32]);

/// The key of a pile or a robot.
pub fn key(device: DeviceId) -> Key {
    let (kind, number) = match device {
        DeviceId::Pile(PileId(number)) => (1, number),
        DeviceId::Robot(RobotId(number)) => (2, number),
        other => panic!("{other} has no key of its own"),
    };
    let mut bytes = [kind; 32];
    bytes[..2].copy_from_slice(&number.to_le_bytes());
    Key::new(bytes)
}

pub fn robot_sessions(id: RobotId) -> Sessions<[Session; 1]> {
    let robot = DeviceId::Robot(id);
    let peers = [Session::new(DeviceId::Coordinator, key(robot))];
    Sessions::new(robot, BootEpoch(1), Trust::Keys { site: None, peers })
}

pub fn identity(pile: PileId) -> Identity {
    let parameters = PileParameters {
        power: PowerW::new(POWER_W).unwrap(),
        eta: DurationMs(5_000),
        voltage_max: VoltageV::new(30.0).unwrap(),
        current_max: CurrentA::new(POWER_W / 20.0).unwrap(),
        derate_from: TemperatureC::new(60.0).unwrap(),
        stop_at: TemperatureC::new(80.0).unwrap(),
        dock_enter_dbm: -60,
        dock_leave_dbm: -66,
    };
    let device_key = key(DeviceId::Pile(pile));
    Identity { pile, device_key, site_key: SITE_KEY, boot_floor: BootEpoch(0), parameters }
}

/// Nothing but Hello goes to who was not heard.
pub fn sealed<Peers: AsMut<[Session]>>(
    sessions: &mut Sessions<Peers>,
    to: Recipient,
    message: &Message,
) -> Option<Vec<u8>> {
    match sessions.seal(to, message) {
        Ok(bytes) => Some(bytes.to_vec()),
        Err(SealError::Unheard { .. }) => None,
        Err(error) => panic!("{error}"),
    }
}
