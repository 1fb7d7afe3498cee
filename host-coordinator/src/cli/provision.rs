//! `chargehand provision`: gives a board its identity and its key.

use std::{
    error::Error,
    path::PathBuf,
    time::{SystemTime, UNIX_EPOCH},
};

use host_coordinator::{
    keys::Keys,
    line::Address,
    provision::{self, BAUD},
    site::Site,
};
use protocol::{BootEpoch, DeviceId, PileId, Provision};
use tokio::runtime;

use super::{Outcome, keys, out, stop::stop_signal};

/// Make a factory-fresh board a pile of the site: give it its identity and its key
#[derive(clap::Args)]
pub struct MakePile {
    /// The serial port it is at, such as /dev/ttyUSB0
    #[arg(long, value_name = "PATH", conflicts_with = "addr", required_unless_present = "addr")]
    port: Option<PathBuf>,
    /// Where its line ends in the network
    #[arg(long, value_name = "HOST:PORT")]
    addr: Option<String>,
    /// Which pile of the site it is to be
    #[arg(long, value_name = "N")]
    id: u16,
    /// The folder of the site; its keys are in DIR/keys.toml
    #[arg(long, value_name = "DIR")]
    site: PathBuf,
}

impl MakePile {
    pub fn run(self) -> Outcome {
        let Self { port, addr, id, site: folder } = self;
        let address = match (port, addr) {
            (Some(port), _) => Address::Serial(port),
            (None, Some(addr)) => Address::Tcp(addr),
            (None, None) => return Err("where is the board? give --port PATH or --addr HOST:PORT".into()),
        };
        let site = Site::load(&folder)?;
        let pile = PileId(id);
        let Some(known) = site.pile(pile) else {
            let name = folder.join("site.toml");
            return Err(format!("pile {pile} is not in {}: add it there first", name.display()).into());
        };
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs();
        let boot_floor = BootEpoch(u32::try_from(seconds)?);
        let file = keys::file_in(&folder);
        runtime::Builder::new_current_thread().enable_all().build()?.block_on(async {
            let interrupt = stop_signal()?;
            let mut line = address.open(BAUD).await?;
            // Not before the line is open, and before anything is sent.
            let (device_key, site_key) =
                Keys::change(&file, |keys| Ok((keys.make(DeviceId::Pile(pile))?, keys.make_site()?)))?;
            let provision = Provision {
                command: provision::command_of(boot_floor),
                pile,
                device_key,
                site_key,
                boot_floor,
                parameters: provision::parameters(known.power_w),
            };
            provision::run(&mut *line, provision, boot_floor, interrupt).await?;
            Ok::<(), Box<dyn Error>>(())
        })?;
        out(&format!("the board is pile {pile} of \"{}\" now; its key is in {}", site.name, file.display()))
    }
}
