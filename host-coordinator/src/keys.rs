//! The site's file of keys.
//!
//! ```toml
//! site = "64 hexadecimal digits"
//!
//! [[pile]]
//! id = 7
//! key = "64 hexadecimal digits"
//!
//! [[robot]]
//! id = 3
//! key = "64 hexadecimal digits"
//! ```
//! Whoever has it can command the site: only its owner may read it, which is seen to when it is
//! written and checked when it is read. A robot's computer gets a file of the same form with its own
//! key and, as `claims`, the site's, by which it claims piles. No key is ever printed.

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    fs::{self, File, OpenOptions},
    io::{self, Write as _},
    path::{Path, PathBuf},
};

use protocol::{BootEpoch, DeviceId, Key, PileId, RobotId, Session, Sessions, Trust};

use crate::{
    diagnostics::{Diagnostic, Diagnostics},
    document::{self, Section, text, whole},
};

/// What its owner may do with the file, and nobody else anything.
const MODE: u32 = 0o600;

/// The keys of a site, or those that one of its robots has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Keys {
    site: Option<Key>,
    /// Whether the site's key is that of one device alone, which claims piles by it.
    one: bool,
    devices: BTreeMap<DeviceId, Key>,
}

/// Keys could not be made or kept.
#[derive(Debug, thiserror::Error)]
pub enum KeysError {
    /// The system gives no random bytes.
    #[error("cannot make a key: the system has no random numbers ({0})")]
    Random(getrandom::Error),
    /// There is a file with mistakes.
    #[error(transparent)]
    Read(Diagnostics),
    /// The file cannot be written.
    #[error("cannot write the keys file {}: {cause}; check its folder and its permissions", .file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// Why.
        cause: io::Error,
    },
    /// Another program writes the file.
    #[error(
        "{} is there: another `chargehand` writes the keys now; try again, or remove that file if none does",
        .file.display()
    )]
    Busy {
        /// The file that it writes first.
        file: PathBuf,
    },
}

impl Keys {
    /// Reads the keys in `file`.
    ///
    /// # Errors
    /// Every mistake in it, among them that others than its owner may read it.
    pub fn load(file: &Path) -> Result<Self, Diagnostics> {
        if let Err(mistake) = check_mode(file) {
            return Err(Diagnostics::one(file, mistake));
        }
        document::read(file, fs::read_to_string(file), |_, mut root| {
            let site = key(&mut root, "site", false);
            let of_a_robot = key(&mut root, "claims", false);
            let mut devices = BTreeMap::new();
            let pile = |number| DeviceId::Pile(PileId(number));
            for mut section in root.tables("pile") {
                device(&mut section, &mut devices, pile);
            }
            let robot = |number| DeviceId::Robot(RobotId(number));
            for mut section in root.tables("robot") {
                device(&mut section, &mut devices, robot);
            }
            Some(Self { site: site.or(of_a_robot), one: site.is_none() && of_a_robot.is_some(), devices })
        })
    }

    /// Changes the keys in `file`, which is made if it is not there. The file is whole whenever the
    /// computer stops, and nobody but its owner can read it.
    ///
    /// # Errors
    /// [`KeysError`]; the file is as it was then.
    pub fn change<T>(
        file: &Path,
        change: impl FnOnce(&mut Self) -> Result<T, KeysError>,
    ) -> Result<T, KeysError> {
        let mut name = file.file_name().unwrap_or_default().to_owned();
        name.push(".new");
        let new = file.with_file_name(name);
        let failed = |cause| KeysError::Write { file: file.into(), cause };
        // Made before the keys are read: whoever else wants to change them finds it there.
        let mut written = create(&new).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => KeysError::Busy { file: new.clone() },
            _ => failed(error),
        })?;
        let changed = Self::load_or_new(file).map_err(KeysError::Read).and_then(|mut keys| {
            let told = change(&mut keys)?;
            written.write_all(keys.to_toml().as_bytes()).map_err(failed)?;
            written.sync_all().and_then(|()| fs::rename(&new, file)).map_err(failed)?;
            sync_folder(file).map_err(failed)?;
            Ok(told)
        });
        if changed.is_err() {
            // It may have become the file already.
            let _ = fs::remove_file(&new);
        }
        changed
    }

    fn load_or_new(file: &Path) -> Result<Self, Diagnostics> {
        match fs::symlink_metadata(file) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self::default()),
            _ => Self::load(file),
        }
    }

    /// Whether they are a site's and not those of a robot.
    #[must_use]
    pub const fn is_a_site_s(&self) -> bool {
        self.site.is_some() && !self.one
    }

    /// The site's key, made now if there is none.
    ///
    /// # Errors
    /// [`KeysError::Random`].
    pub fn make_site(&mut self) -> Result<Key, KeysError> {
        if self.site.is_none() {
            self.site = Some(random()?);
        }
        self.site.map_or_else(random, Ok)
    }

    /// The key of a device, made now if there is none.
    ///
    /// # Errors
    /// [`KeysError::Random`].
    pub fn make(&mut self, device: DeviceId) -> Result<Key, KeysError> {
        if let Some(key) = self.devices.get(&device) {
            return Ok(*key);
        }
        let key = random()?;
        self.devices.insert(device, key);
        Ok(key)
    }

    /// The key of a device, if it has one.
    #[must_use]
    pub fn of(&self, device: DeviceId) -> Option<Key> {
        self.devices.get(&device).copied()
    }

    /// The keys that `device` itself has: its own and the site's.
    #[must_use]
    pub fn only(&self, device: DeviceId) -> Self {
        Self {
            site: self.site,
            one: self.site.is_some(),
            devices: self.of(device).map(|key| (device, key)).into_iter().collect(),
        }
    }

    /// The coordinator's sessions with all devices that have a key.
    #[must_use]
    pub fn sessions(&self, boot: BootEpoch) -> Sessions<Vec<Session>> {
        let peers = self.devices.iter().map(|(&device, &key)| Session::new(device, key)).collect();
        Sessions::new(DeviceId::Coordinator, boot, Trust::Keys { site: self.site, peers })
    }

    /// The piles that have a key, and what a person's tool believes: each of them, by its key.
    #[must_use]
    pub fn piles(&self) -> (Vec<PileId>, Trust<Vec<Session>>) {
        let keys = self.devices.iter().filter_map(|(device, key)| match device {
            DeviceId::Pile(pile) => Some((*pile, Session::new(*device, *key))),
            _ => None,
        });
        let (piles, peers) = keys.unzip();
        (piles, Trust::Keys { site: self.site, peers })
    }

    /// What `device` trusts: the coordinator, by the key that they share.
    #[must_use]
    pub fn trust_of(&self, device: DeviceId) -> Trust<Vec<Session>> {
        let Self { site, devices, .. } = self.only(device);
        let peers = devices.into_values().map(|key| Session::new(DeviceId::Coordinator, key)).collect();
        Trust::Keys { site, peers }
    }

    fn to_toml(&self) -> String {
        let mut toml = String::from("# Secret: who has this file can command the site.\n");
        let hex = |key: &Key| key.expose().iter().fold(String::new(), |hex, byte| format!("{hex}{byte:02x}"));
        if let Some(site) = &self.site {
            let _ = writeln!(toml, "{} = \"{}\"", if self.one { "claims" } else { "site" }, hex(site));
        }
        for (device, key) in &self.devices {
            let (table, number) = match device {
                DeviceId::Pile(pile) => ("pile", pile.0),
                DeviceId::Robot(robot) => ("robot", robot.0),
                // Nobody shares a key with them.
                DeviceId::Coordinator | DeviceId::Chassis(_) | DeviceId::Service | DeviceId::Factory => {
                    continue;
                }
            };
            let _ = writeln!(toml, "\n[[{table}]]\nid = {number}\nkey = \"{}\"", hex(key));
        }
        toml
    }
}

fn random() -> Result<Key, KeysError> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes).map_err(KeysError::Random)?;
    Ok(Key::new(bytes))
}

fn device(section: &mut Section<'_>, devices: &mut BTreeMap<DeviceId, Key>, named: fn(u16) -> DeviceId) {
    let id = section.required("id", &whole(0..=u16::MAX.into())).map(named);
    let Some((device, key)) = id.zip(key(section, "key", true)) else { return };
    if devices.insert(device, key).is_some() {
        section.mistake("id", format!("{device} is there twice"), "one key for each device");
    }
}

/// A key; what is none is not repeated in the mistake, as it may be most of one.
fn key(section: &mut Section<'_>, name: &'static str, required: bool) -> Option<Key> {
    let written = if required { section.required(name, &text()) } else { section.optional(name, &text()) }?;
    let key = bytes(&written);
    if key.is_none() {
        section.mistake(name, format!("`{name}` is no key"), "64 hexadecimal digits in quotes");
    }
    key.map(Key::new)
}

fn bytes(hex: &str) -> Option<[u8; 32]> {
    let digits: Option<Vec<u8>> = hex.chars().map(|c| u8::try_from(c.to_digit(16)?).ok()).collect();
    let bytes: Vec<u8> =
        digits?.chunks(2).map(|pair| pair.iter().fold(0, |byte, digit| byte << 4 | digit)).collect();
    (hex.len() == 64).then(|| bytes.try_into().ok()).flatten()
}

#[cfg(unix)]
fn check_mode(file: &Path) -> Result<(), Diagnostic> {
    use std::os::unix::fs::PermissionsExt as _;
    let metadata = fs::metadata(file).map_err(|error| {
        Diagnostic::new(
            file,
            None,
            format!("cannot be read ({error})"),
            "a file of keys: `chargehand keys --site FOLDER` makes FOLDER/keys.toml",
        )
    })?;
    let mode = metadata.permissions().mode() & 0o777;
    if mode & !MODE == 0 {
        return Ok(());
    }
    let name = file.display();
    let problem = format!("others than its owner may use it (mode {mode:04o})");
    Err(Diagnostic::new(file, None, problem, format!("mode {MODE:04o}: run `chmod 600 {name}`")))
}

#[cfg(not(unix))]
fn check_mode(_: &Path) -> Result<(), Diagnostic> {
    Ok(())
}

#[cfg(unix)]
fn create(file: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt as _;
    OpenOptions::new().write(true).create_new(true).mode(MODE).open(file)
}

#[cfg(not(unix))]
fn create(file: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(file)
}

/// A rename is on the disk when its folder is.
fn sync_folder(file: &Path) -> io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    const PILE: DeviceId = DeviceId::Pile(PileId(7));
    const ROBOT: DeviceId = DeviceId::Robot(RobotId(3));

    fn folder() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("keys.toml");
        (folder, file)
    }

    fn made(file: &Path) -> Keys {
        Keys::change(file, |keys| {
            keys.make_site()?;
            keys.make(PILE)?;
            keys.make(ROBOT)?;
            Ok(keys.clone())
        })
        .unwrap()
    }

    #[test]
    fn keys_are_kept_and_only_their_owner_may_read_them() {
        let (_folder, file) = folder();
        let keys = made(&file);
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o7777, 0o600);
        assert_eq!(Keys::load(&file).unwrap(), keys);
        let added = Keys::change(&file, |keys| keys.make(DeviceId::Pile(PileId(8)))).unwrap();
        let more = Keys::load(&file).unwrap();
        assert_eq!((more.of(DeviceId::Pile(PileId(8))), more.of(PILE)), (Some(added), keys.of(PILE)));
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o7777, 0o600);
    }

    #[test]
    fn a_file_that_others_may_read_is_refused_with_the_command_that_helps() {
        let (_folder, file) = folder();
        made(&file);
        for mode in [0o640, 0o604, 0o620, 0o644, 0o610] {
            fs::set_permissions(&file, fs::Permissions::from_mode(mode)).unwrap();
            let error = Keys::load(&file).unwrap_err().to_string();
            assert!(error.contains(&format!("(mode {mode:04o})")), "{error}");
            assert!(error.contains(&format!("`chmod 600 {}`", file.display())), "{error}");
        }
        fs::set_permissions(&file, fs::Permissions::from_mode(0o400)).unwrap();
        assert!(Keys::load(&file).is_ok());
    }

    #[test]
    fn a_device_keeps_its_key_and_no_two_are_alike() {
        let (_folder, file) = folder();
        let mut keys = made(&file);
        let (pile, robot, site) =
            (keys.of(PILE).unwrap(), keys.of(ROBOT).unwrap(), keys.make_site().unwrap());
        assert_eq!(keys.make(PILE).unwrap(), pile);
        assert!(pile != robot && pile != site && robot != site);
        let (of_robot, of_pile) = (keys.only(ROBOT), keys.only(PILE));
        assert_eq!((of_robot.of(ROBOT), of_robot.of(PILE), of_robot.site), (Some(robot), None, Some(site)));
        assert_eq!((of_pile.of(PILE), of_pile.of(ROBOT), of_pile.site), (Some(pile), None, Some(site)));
    }

    #[test]
    fn a_mistake_is_told_with_its_line_and_without_the_secret() {
        let (_folder, file) = folder();
        made(&file);
        let good = fs::read_to_string(&file).unwrap();
        let secret = good.lines().find(|line| line.starts_with("key")).unwrap().split('"').nth(1).unwrap();
        for (spoilt, problem) in [
            (good.replacen(secret, &secret[..40], 1), "`key` is no key"),
            (good.replacen(secret, &secret.replacen(|_| true, "x", 1), 1), "`key` is no key"),
            (good.replacen(&format!("\"{secret}\""), secret, 1), "toml:"),
            (good.replacen("[[robot]]\nid = 3", "[[pile]]\nid = 7", 1), "pile 7 is there twice"),
        ] {
            assert_ne!(spoilt, good);
            fs::write(&file, spoilt).unwrap();
            let error = Keys::load(&file).unwrap_err().to_string();
            assert!(error.contains(problem), "{error}");
            assert!(!error.contains(&secret[1..20]) && !error.contains(&secret[20..39]), "{error}");
        }
    }

    #[test]
    fn two_writers_do_not_lose_each_other_s_keys() {
        let (_folder, file) = folder();
        let key = Keys::change(&file, |keys| {
            let error = Keys::change(&file, |keys| keys.make(ROBOT)).unwrap_err();
            assert!(matches!(error, KeysError::Busy { .. }), "{error}");
            keys.make(PILE)
        });
        assert_eq!(Keys::load(&file).unwrap().of(PILE), Some(key.unwrap()));
        assert!(Keys::change(&file, |keys| keys.make(ROBOT)).is_ok());
    }

    #[test]
    fn a_change_that_fails_leaves_the_file_as_it_was() {
        let (_folder, file) = folder();
        made(&file);
        let before = fs::read_to_string(&file).unwrap();
        fs::write(&file, format!("{before}nonsense")).unwrap();
        let error = Keys::change(&file, |keys| keys.make(ROBOT)).unwrap_err();
        assert!(matches!(error, KeysError::Read(_)), "{error}");
        assert_eq!(fs::read_to_string(&file).unwrap(), format!("{before}nonsense"));
        assert_eq!(fs::read_dir(file.parent().unwrap()).unwrap().count(), 1);
    }
}
