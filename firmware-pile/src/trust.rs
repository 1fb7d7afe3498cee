//! Whom a board believes: with an identity, the coordinator and the service tool, which both have its
//! key, and as gossip what carries the site's. A board without identity has nobody to believe yet.

use protocol::{BootEpoch, DeviceId, Session, Sessions, Trust};

use crate::store::Identity;

/// With whom a pile has sessions: the coordinator and the service tool.
pub const PEERS: usize = 2;

/// The sessions of a board in its start `boot`.
#[must_use]
pub fn sessions(identity: Option<&Identity>, boot: BootEpoch) -> Sessions<[Session; PEERS]> {
    let Some(Identity { pile, device_key, site_key, .. }) = identity else {
        return Sessions::new(DeviceId::Factory, boot, Trust::Insecure);
    };
    let peers = [DeviceId::Coordinator, DeviceId::Service].map(|peer| Session::new(peer, *device_key));
    Sessions::new(DeviceId::Pile(*pile), boot, Trust::Keys { site: Some(*site_key), peers })
}

#[cfg(test)]
mod tests {
    use protocol::{
        CommandId, Deframer, DurationMs, Epoch, Frame, FrameError, Hello, Key, Message, Millis, PileId,
        PileTable, Provision, Recipient, TimeRequest,
    };

    use super::*;

    const PILE: DeviceId = DeviceId::Pile(PileId(7));
    const BOOT: BootEpoch = BootEpoch(3);

    fn identity(pile: u16) -> Identity {
        let parameters = protocol::PileParameters {
            power: protocol::PowerW::MAX,
            eta: DurationMs(0),
            voltage_max: protocol::VoltageV::MAX,
            current_max: protocol::CurrentA::MAX,
            derate_from: protocol::TemperatureC::MIN,
            stop_at: protocol::TemperatureC::MAX,
            dock_enter_dbm: -60,
            dock_leave_dbm: -66,
        };
        Identity {
            pile: PileId(pile),
            device_key: Key::new([pile as u8; 32]),
            site_key: Key::new([0xFF; 32]),
            boot_floor: BootEpoch(1),
            parameters,
        }
    }

    fn hello() -> Message {
        Message::Hello(Hello::new(Epoch(0)))
    }

    fn open<Peers: AsMut<[Session]>>(at: &mut Sessions<Peers>, bytes: &[u8]) -> Result<Frame, FrameError> {
        let mut opened = None;
        Deframer::new().feed(bytes, |found| opened = Some(found.and_then(|packet| at.open(packet))));
        opened.expect("nothing was sent")
    }

    /// Whether both sides believe each other's Hello, and then something else.
    fn converse(pile: &mut Sessions<[Session; PEERS]>, with: DeviceId, key: Key) -> bool {
        let peers = [Session::new(PILE, key)];
        let mut other = Sessions::new(with, BootEpoch(5), Trust::Keys { site: None, peers });
        let asked = Message::TimeRequest(TimeRequest { asked_at: Millis(1) });
        [hello(), asked].iter().all(|message| {
            let from_pile = pile.seal(Recipient::Device(with), message).unwrap();
            let to_pile = other.seal(Recipient::Device(PILE), &hello()).unwrap();
            open(&mut other, &from_pile).is_ok() && open(pile, &to_pile).is_ok()
        })
    }

    #[test]
    fn a_pile_talks_with_coordinator_and_tool_by_its_own_key_and_with_nobody_else() {
        let key = identity(7).device_key;
        for with in [DeviceId::Coordinator, DeviceId::Service] {
            assert!(converse(&mut sessions(Some(&identity(7)), BOOT), with, key), "{with}");
        }
        let mut pile = sessions(Some(&identity(7)), BOOT);
        let peers = [Session::new(PILE, identity(8).device_key)];
        let mut forger = Sessions::new(DeviceId::Coordinator, BOOT, Trust::Keys { site: None, peers });
        let forged = forger.seal(Recipient::Device(PILE), &hello()).unwrap();
        let sender = DeviceId::Coordinator;
        assert_eq!(open(&mut pile, &forged), Err(FrameError::Unauthentic { sender }));
    }

    #[test]
    fn piles_of_a_site_gossip() {
        let mut teller = sessions(Some(&identity(7)), BOOT);
        let gossip = Message::PileTable(PileTable { rows: heapless::Vec::new() });
        let bytes = teller.seal(Recipient::Piles, &gossip).unwrap();
        let heard = open(&mut sessions(Some(&identity(8)), BOOT), &bytes);
        assert_eq!(heard.map(|frame| frame.message), Ok(gossip));
    }

    #[test]
    fn a_board_that_is_nobody_can_be_provisioned_and_says_that_it_is_nobody() {
        let Identity { pile, device_key, site_key, boot_floor, parameters } = identity(7);
        let command = CommandId(1);
        let provision = Provision { command, pile, device_key, site_key, boot_floor, parameters };
        let provision = Message::Provision(provision);
        let mut tool = Sessions::insecure(DeviceId::Service, BootEpoch(9));
        let bytes = tool.seal(Recipient::Device(DeviceId::Factory), &provision).unwrap();
        for identity in [None, Some(&identity(3))] {
            let heard = open(&mut sessions(identity, BOOT), &bytes);
            assert_eq!(
                heard.map(|frame| frame.message),
                Ok(provision.clone()),
                "whether it obeys is its own"
            );
        }
        let said = sessions(None, BOOT).seal(Recipient::Device(DeviceId::Service), &hello()).unwrap();
        assert_eq!(open(&mut tool, &said).map(|frame| frame.header.sender), Ok(DeviceId::Factory));
    }
}
