//! Writes a map as another program, or this one, reads it.

use std::{error::Error, fmt::Write as _, fs, io, path::Path};

use planning::{
    floor_plan::Layout,
    formats::{movingai, ros},
    rooms::Rooms,
};

use super::rooms::Pile;

type Failure = Box<dyn Error>;

fn written(file: &Path, content: impl AsRef<[u8]>) -> Result<(), Failure> {
    fs::write(file, content).map_err(|error| unwritten(file, &error))
}

fn unwritten(file: &Path, error: &io::Error) -> Failure {
    format!("{} cannot be written ({error}); name a place where you may write", file.display()).into()
}

/// Writes a MovingAI map.
pub fn moving_ai(file: &Path, layout: &Layout) -> Result<(), Failure> {
    written(file, movingai::write_map(&layout.grid))
}

/// Writes a ROS map: `file` and a picture beside it.
pub fn ros(file: &Path, layout: &Layout) -> Result<(), Failure> {
    let picture = file.with_extension("pgm");
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    let (text, pixels) = ros::write(&layout.grid, &layout.frame, &name);
    written(&picture, pixels)?;
    written(file, text)
}

/// Writes a site's folder.
pub fn site(
    folder: &Path,
    name: &str,
    layout: &Layout,
    rooms: &Rooms,
    piles: &[Pile],
) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| unwritten(folder, &error))?;
    moving_ai(&folder.join("site.map"), layout)?;
    written(&folder.join("subareas.txt"), rooms.subareas().picture())?;
    written(&folder.join("site.toml"), site_toml(name, layout, rooms, piles))?;
    let configuration = "# Add `[[robot]]`s; `chargehand keys --site` of this folder makes the keys.\n\
                         site = \".\"\nevent_log = \"chargehand.sqlite\"\nkeys = \"keys.toml\"\n";
    written(&folder.join("chargehand.toml"), configuration)
}

/// `text` as TOML has it, in quotes.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

fn site_toml(name: &str, layout: &Layout, rooms: &Rooms, piles: &[Pile]) -> String {
    let ([x, y], yaw) = (layout.frame.origin_m, layout.frame.yaw_rad);
    let mut text = format!(
        "# Made by `chargehand map convert`. The lower left corner of the map is at ({x}, {y}) m of its own\n\
         # world, turned by {yaw} rad; here cells count from the upper left, y downwards.\n\
         name = {}\nmap = \"site.map\"\nsubareas = \"subareas.txt\"\nresolution_m = {:?}\nneighbours = 16\n",
        quoted(name),
        layout.frame.resolution_m
    );
    text += &doors(rooms);
    if !piles.is_empty() {
        text += "\n# A map does not say what a pile gives: correct `power_w`.\n";
    }
    for (id, pile) in (1..).zip(piles) {
        let (cell, comment) = (pile.cell, pile.name.replace(char::is_control, " "));
        // Writing to a string never fails.
        let _ = write!(
            text,
            "\n# {comment}\n[[pile]]\nid = {id}\nat = [{}, {}]\npower_w = 500\n",
            cell.x, cell.y
        );
    }
    text
}

/// Writes subareas and doors as a site has them.
pub fn segmentation(folder: &Path, rooms: &Rooms) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| unwritten(folder, &error))?;
    written(&folder.join("subareas.txt"), rooms.subareas().picture())?;
    written(&folder.join("doors.toml"), doors(rooms))
}

/// The doors of a site file.
fn doors(rooms: &Rooms) -> String {
    let mut text = String::new();
    for door in rooms.doors() {
        let [one, other] = door.joins.map(|id| rooms.subareas().name(id).unwrap_or('?'));
        let _ = write!(
            text,
            "\n[[door]]\nid = {}\nat = [{}, {}]\njoins = [\"{one}\", \"{other}\"]\n",
            door.id, door.cell.x, door.cell.y
        );
    }
    text
}
