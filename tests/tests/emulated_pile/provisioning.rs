//! A board from the factory becomes a pile, and works for the coordinator that has its key.

use std::fs;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use host_coordinator::config::{Config, Listen, Policy, Security};
use host_coordinator::daemon::{Daemon, SiteClock};
use host_coordinator::keys::Keys;
use host_coordinator::line::Address;
use host_coordinator::provision::{BAUD, command_of, parameters, run};
use host_coordinator::site::Site;
use protocol::{BootEpoch, DeviceId, PileId, Provision};
use tests::board_line::Awaited;
use tests::emulator::{Emulator, FLASH, Serial};
use tests::pile_bench::SOON;
use tests::uhf_reader::UhfReader;
use tokio::runtime::Runtime;

const PILE: PileId = PileId(5);

/// A board and what is wired to it; nobody uses its test bench.
struct Wired {
    board: Emulator,
    _reader: UhfReader,
    _test: Awaited,
}

fn boot(link: SocketAddr, flash: &Path) -> Wired {
    let (reader, test) = (UhfReader::start().unwrap(), Awaited::new().unwrap());
    let uarts = [Serial::Listen(link), Serial::Dial(reader.address()), test.serial().unwrap()];
    let mut board = Emulator::boot_board(uarts, flash, false).unwrap_or_else(|error| panic!("{error}"));
    // It listens by then.
    board.wait_for("keeps: pile", SOON).unwrap_or_else(|error| panic!("{error}"));
    Wired { board, _reader: reader, _test: test }
}

/// What `chargehand provision` does, in a run that began at this second.
async fn provision(link: SocketAddr, keys: &mut Keys, pile: PileId, run_at: u32) -> Result<(), String> {
    let provision = Provision {
        command: command_of(BootEpoch(run_at)),
        pile,
        device_key: keys.make(DeviceId::Pile(pile)).unwrap(),
        site_key: keys.make_site().unwrap(),
        boot_floor: BootEpoch(run_at),
        parameters: parameters(500.0),
    };
    let mut line = Address::Tcp(link.to_string()).open(BAUD).await.unwrap();
    let told = run(&mut *line, provision, BootEpoch(run_at), std::future::pending()).await;
    told.map_err(|error| error.to_string())
}

/// Waits until the coordinator believes the pile, and the pile the coordinator.
async fn comes_to_life(link: SocketAddr, keys: &Keys, log: &mut Emulator) {
    let folder = tempfile::tempdir().unwrap();
    let anywhere = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let config = Config {
        site: PathBuf::new(),
        event_log: folder.path().join("events.sqlite"),
        security: Security::Keys(keys.clone()),
        listen: Listen { http: Some(anywhere), udp: anywhere, tcp: anywhere },
        policy: Policy::default(),
        robots: Vec::new(),
        connect: vec![(PILE, link)],
    };
    let site = Arc::new(Site::fig7().unwrap());
    let daemon = Daemon::start(site, &config, SiteClock::real()).await.unwrap();
    let deadline = Instant::now() + SOON;
    loop {
        let view = Arc::clone(&daemon.view().borrow());
        assert!(!view.insecure);
        let pile = view.piles.iter().find(|row| row.id == PILE).unwrap();
        if pile.availability == "free" {
            break;
        }
        let warnings = &view.warnings;
        assert!(Instant::now() < deadline, "{pile:?}, {warnings:?}, its log: {:#?}", log.log());
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    daemon.shutdown().await;
}

#[test]
fn a_board_from_the_factory_becomes_a_pile_that_only_its_coordinator_commands() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("flash");
    fs::write(&flash, [0xFF; FLASH]).unwrap();
    let link = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap();
    let mut wired = boot(link, &flash);
    let (mut ours, mut theirs) = (Keys::default(), Keys::default());
    Runtime::new().unwrap().block_on(async {
        let given = provision(link, &mut ours, PILE, 1_800_000_000).await;
        given.unwrap_or_else(|error| panic!("{error}; its log: {:#?}", wired.board.log()));
        wired.board.wait_for("restarts", SOON).unwrap_or_else(|error| panic!("{error}"));
        comes_to_life(link, &ours, &mut wired.board).await;

        // Another run gives it what it has; another site, or another number, is refused.
        provision(link, &mut ours, PILE, 1_800_000_100).await.unwrap();
        for (keys, pile) in [(&mut theirs, PILE), (&mut ours, PileId(6))] {
            let error = provision(link, keys, pile, 1_800_000_200).await.unwrap_err();
            assert!(error.contains("pile 5 already") && error.contains("hold its button"), "{error}");
        }
        // A loss of power changes nothing.
        drop(wired);
        let mut wired = boot(link, &flash);
        comes_to_life(link, &ours, &mut wired.board).await;
    });
}
