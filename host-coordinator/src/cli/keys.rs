//! `chargehand keys`: makes the site's keys, and one for a robot's computer.

use std::path::{Path, PathBuf};

use host_coordinator::keys::Keys;
use protocol::{DeviceId, RobotId};

use super::{Outcome, out};

/// Make the site's file of keys, and the key of a robot
#[derive(clap::Args)]
pub struct MakeKeys {
    /// The folder of the site; its keys are in DIR/keys.toml
    #[arg(long, value_name = "DIR")]
    site: PathBuf,
    /// Give this robot a key, if it has none
    #[arg(long, value_name = "N", requires = "out")]
    robot: Option<u16>,
    /// Write the robot's key into FILE too, for its own computer
    #[arg(long, value_name = "FILE", requires = "robot")]
    out: Option<PathBuf>,
}

/// Where the keys of a site are.
pub fn file_in(site: &Path) -> PathBuf {
    site.join("keys.toml")
}

impl MakeKeys {
    pub fn run(self) -> Outcome {
        let file = file_in(&self.site);
        let name = file.display();
        let Some((robot, computer)) = self.robot.map(|id| DeviceId::Robot(RobotId(id))).zip(self.out) else {
            Keys::change(&file, |keys| keys.make_site().map(drop))?;
            return out(&format!("{name} has the site's key; `chargehand provision` adds those of piles"));
        };
        let only = Keys::change(&file, |keys| {
            keys.make_site()?;
            keys.make(robot)?;
            Ok(keys.only(robot))
        })?;
        Keys::change(&computer, |keys| {
            *keys = only;
            Ok(())
        })?;
        let computer = computer.display();
        out(&format!("{robot} has a key in {name}; its own is in {computer}: move that to its computer"))
    }
}
