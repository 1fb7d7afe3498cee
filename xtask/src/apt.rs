//! Debian's packages, and its backports.
//!
//! The backports live on the mirror that the machine uses already, signed by the same key: both are
//! read from its apt sources, in either format, and no host is known here.

use std::path::{Path, PathBuf};
use std::{env, fs};

use crate::command::{Command, Failure};
use crate::setup::as_root;

const SOURCES: &str = "/etc/apt";

/// The source this module adds.
const BACKPORTS: &str = "/etc/apt/sources.list.d/chargehand-backports.sources";

/// A place that packages come from: what one stanza or line of apt's sources says.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Source {
    uris: Vec<String>,
    suites: Vec<String>,
    components: Vec<String>,
    /// The file with the key, or the key itself, as in the source.
    signed_by: Option<String>,
}

/// Reads what packages there are.
pub fn update() -> Result<(), Failure> {
    as_root("apt-get")?.words("update --quiet=2").run()
}

/// Installs `packages`, from `suite` if one is given.
pub fn install(packages: &[&str], suite: Option<&str>) -> Result<(), Failure> {
    as_root("env")?
        .words("DEBIAN_FRONTEND=noninteractive apt-get install --yes --quiet=2 --no-install-recommends")
        .args(suite.into_iter().flat_map(|suite| ["--target-release", suite]))
        .args(packages.iter().copied())
        .run()
}

/// Installs QEMU of version `major` or newer, from the backports if the system's own is older.
pub fn install_qemu(package: &str, major: u32) -> Result<(), Failure> {
    update()?;
    if let Some(suite) = suite_with(package, major)? {
        return install(&[package], Some(&suite));
    }
    add_backports()?;
    update()?;
    match suite_with(package, major)? {
        Some(suite) => install(&[package], Some(&suite)),
        None => Err(Failure::new(
            format!("neither this release of the system nor its backports have {package} {major}"),
            "use a newer release",
        )),
    }
}

/// The suite that has `package` in version `major` or newer.
fn suite_with(package: &str, major: u32) -> Result<Option<String>, Failure> {
    let table = Command::new("apt-cache").words("madison").words(package).output()?;
    Ok(suite_in(&table, major))
}

/// Finds a suite in lines such as
/// `qemu-system-arm | 1:10.0.2+ds-2 | http://mirror/debian bookworm-backports/main amd64 Packages`.
fn suite_in(madison: &str, major: u32) -> Option<String> {
    madison.lines().find_map(|line| {
        let mut columns = line.split('|').map(str::trim).skip(1);
        let version = columns.next()?;
        let upstream = version.split_once(':').map_or(version, |(_epoch, upstream)| upstream);
        let found: u32 = upstream.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()?;
        let suite = columns.next()?.split_whitespace().nth(1)?.split('/').next()?;
        (found >= major).then(|| suite.to_owned())
    })
}

/// Adds the backports of this Debian release to apt's sources.
fn add_backports() -> Result<(), Failure> {
    let release = fs::read_to_string("/etc/os-release").unwrap_or_default();
    let field = |name: &str| {
        let line = release.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix('='));
        line.map(|value| value.trim_matches('"').to_owned())
    };
    let (Some("debian"), Some(codename)) = (field("ID").as_deref(), field("VERSION_CODENAME")) else {
        return Err(Failure::new(
            "this release's package is too old and only Debian's backports are known",
            "use a newer release",
        ));
    };
    let sources = read_sources(Path::new(SOURCES));
    let Some(backports) = backports_of(&codename, &sources) else {
        return Err(Failure::new(
            format!("apt's sources name no mirror of Debian {codename} that could have its backports"),
            format!("add {codename}-backports to {SOURCES}/sources.list.d"),
        ));
    };
    eprintln!("setup: adding {BACKPORTS}");
    let written = env::temp_dir().join(format!("chargehand-backports-{}", std::process::id()));
    fs::write(&written, backports.to_stanza()).map_err(|error| {
        Failure::new(format!("cannot write {}: {error}", written.display()), "make the folder writable")
    })?;
    let installed =
        as_root("install")?.words("-m 644").args([written.to_string_lossy(), BACKPORTS.into()]).run();
    // It has been copied or is of no use: nothing depends on its removal.
    let _ = fs::remove_file(written);
    installed
}

/// The backports of `codename`, on the mirror and with the key of its main suite.
fn backports_of(codename: &str, sources: &[Source]) -> Option<Source> {
    let main = |source: &&Source| {
        source.suites.iter().any(|suite| suite == codename) && source.components.iter().any(|c| c == "main")
    };
    let source = sources.iter().find(main)?;
    Some(Source {
        uris: source.uris.clone(),
        suites: vec![format!("{codename}-backports")],
        components: vec!["main".into()],
        signed_by: source.signed_by.clone(),
    })
}

fn read_sources(apt: &Path) -> Vec<Source> {
    let listed = fs::read_dir(apt.join("sources.list.d")).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = listed.map(|entry| entry.path()).collect();
    files.sort();
    files.insert(0, apt.join("sources.list"));
    let parse = |file: PathBuf| {
        let text = fs::read_to_string(&file).ok()?;
        match file.extension()?.to_str()? {
            "sources" => Some(parse_deb822(&text)),
            "list" => Some(text.lines().filter_map(parse_line).collect()),
            _ => None,
        }
    };
    files.into_iter().filter_map(parse).flatten().collect()
}

/// A line such as `deb [signed-by=/usr/share/keyrings/debian.gpg] http://mirror/debian bookworm main`.
fn parse_line(line: &str) -> Option<Source> {
    let rest = line.split('#').next()?.trim().strip_prefix("deb")?.strip_prefix([' ', '\t'])?.trim_start();
    let (options, rest) = match rest.strip_prefix('[') {
        Some(bracketed) => bracketed.split_once(']')?,
        None => ("", rest),
    };
    let signed_by = options.split_whitespace().find_map(|option| option.strip_prefix("signed-by="));
    let mut words = rest.split_whitespace().map(str::to_owned);
    Some(Source {
        uris: vec![words.next()?],
        suites: vec![words.next()?],
        components: words.collect(),
        signed_by: signed_by.map(str::to_owned),
    })
}

/// The enabled binary sources of a deb822 file: stanzas of `Field: value`, continued by indented
/// lines.
fn parse_deb822(text: &str) -> Vec<Source> {
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    lines.split(|line| line.trim().is_empty()).filter_map(parse_stanza).collect()
}

fn parse_stanza(lines: &[&str]) -> Option<Source> {
    let mut fields: Vec<(String, String)> = Vec::new();
    for line in lines {
        if line.starts_with([' ', '\t']) {
            let (_, value) = fields.last_mut()?;
            value.push('\n');
            value.push_str(line);
        } else {
            let (name, value) = line.split_once(':')?;
            fields.push((name.to_ascii_lowercase(), value.trim().to_owned()));
        }
    }
    let field = |name: &str| fields.iter().find(|(found, _)| found == name).map(|(_, value)| value.as_str());
    let words = |name: &str| Some(field(name)?.split_whitespace().map(str::to_owned).collect::<Vec<_>>());
    if field("enabled").is_some_and(|enabled| enabled.eq_ignore_ascii_case("no"))
        || !words("types")?.iter().any(|kind| kind == "deb")
    {
        return None;
    }
    Some(Source {
        uris: words("uris")?,
        suites: words("suites")?,
        components: words("components").unwrap_or_default(),
        signed_by: field("signed-by").map(str::to_owned),
    })
}

impl Source {
    fn to_stanza(&self) -> String {
        let words = [
            "Types: deb".to_owned(),
            format!("URIs: {}", self.uris.join(" ")),
            format!("Suites: {}", self.suites.join(" ")),
            format!("Components: {}", self.components.join(" ")),
        ];
        let signed = self.signed_by.iter().map(|key| format!("Signed-By: {key}"));
        words.into_iter().chain(signed).map(|line| line + "\n").collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEB822: &str = "\
Types: deb deb-src
# a comment inside a stanza
URIs: http://mirror.example/debian
Suites: bookworm bookworm-updates
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg

Enabled: no
Types: deb
URIs: http://other.example/debian
Suites: bookworm
Components: main
";

    fn backports(text: Vec<Source>) -> Option<String> {
        backports_of("bookworm", &text).map(|source| source.to_stanza())
    }

    #[test]
    fn the_backports_come_from_the_machines_own_mirror_and_key() {
        let expected = "Types: deb\nURIs: http://mirror.example/debian\nSuites: bookworm-backports\n\
                        Components: main\nSigned-By: /usr/share/keyrings/debian-archive-keyring.gpg\n";
        assert_eq!(backports(parse_deb822(DEB822)).as_deref(), Some(expected));
        let line = "deb [arch=amd64 signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] \
                    http://mirror.example/debian bookworm main contrib # a mirror";
        assert_eq!(backports(parse_line(line).into_iter().collect()).as_deref(), Some(expected));
    }

    #[test]
    fn a_source_without_a_key_has_none_and_an_embedded_key_is_kept_whole() {
        let bare = parse_line("deb http://mirror.example/debian bookworm main").unwrap();
        assert!(!bare.to_stanza().contains("Signed-By"));
        let key = "Types: deb\nURIs: http://m.example/debian\nSuites: bookworm\nComponents: main\nSigned-By:\n \
                   -----BEGIN PGP PUBLIC KEY BLOCK-----\n .\n mDME\n";
        let stanza = backports(parse_deb822(key)).unwrap();
        assert!(
            stanza.ends_with("Signed-By: \n -----BEGIN PGP PUBLIC KEY BLOCK-----\n .\n mDME\n"),
            "{stanza}"
        );
    }

    #[test]
    fn disabled_foreign_and_source_only_entries_give_no_mirror() {
        let disabled = DEB822.split("\n\n").nth(1).unwrap();
        assert_eq!(backports(parse_deb822(disabled)), None);
        assert_eq!(parse_line("deb-src http://mirror.example/debian bookworm main"), None);
        assert_eq!(parse_line("# deb http://mirror.example/debian bookworm main"), None);
        let security = parse_line("deb http://mirror.example/debian-security bookworm-security main");
        assert_eq!(backports(security.into_iter().collect()), None);
    }

    #[test]
    fn the_suite_with_a_new_enough_version_is_chosen() {
        let table = "\
qemu-system-arm | 1:10.0.2+ds-2~bpo12+1 | http://mirror.example/debian bookworm-backports/main amd64 Packages
qemu-system-arm | 1:7.2+dfsg-7 | http://mirror.example/debian bookworm/main amd64 Packages
";
        assert_eq!(suite_in(table, 10).as_deref(), Some("bookworm-backports"));
        assert_eq!(suite_in(table, 11), None);
        assert_eq!(suite_in("", 10), None);
    }
}
