//! Which protocol versions two devices can speak.
//!
//! A device speaks every version from its [`MIN`] to its [`CURRENT`] and says so in
//! [`Hello`](crate::Hello); two devices use the newest that both speak.
//!
//! - The frame's header and `Hello`, which is the message with ordinal 0, are frozen. A `Hello` is
//!   understood whatever its frame's version; a later version may add to it, but only behind.
//! - Of a version that is not spoken here nothing but a `Hello` is decoded.
//! - A released version never changes. A new one may append variants to enums; it never reorders
//!   them and never touches the fields of what is there. A message that needs another field becomes
//!   a new variant, and the old one stays as long as `MIN` reaches back to it.
//! - What a version added is kept as bytes in `tests/versioning/vNN.rs`, which is never edited once
//!   the version is released.

/// The oldest version this code speaks.
pub const MIN: u8 = 1;
/// The newest version this code speaks; what it sends until it has heard the other side's.
pub const CURRENT: u8 = 1;

/// The version of the software: of the workspace, which all devices share. Major, minor, patch.
pub const SOFTWARE: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

const fn number(text: &str) -> u8 {
    match u8::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => u8::MAX,
    }
}

/// The versions a device speaks, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Range {
    /// The oldest.
    pub min: u8,
    /// The newest.
    pub current: u8,
}

impl Range {
    /// Whether `version` is one of them.
    #[must_use]
    pub const fn contains(self, version: u8) -> bool {
        self.min <= version && version <= self.current
    }
}

/// What this code speaks.
pub const OURS: Range = Range { min: MIN, current: CURRENT };

/// Two devices have no version in common: the one that speaks the older ones needs an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no common protocol version: we speak {}..={}, the other side {}..={}; update the older one",
    ours.min, ours.current, theirs.min, theirs.current
)]
pub struct NoCommonVersion {
    /// What we speak.
    pub ours: Range,
    /// What the other side speaks.
    pub theirs: Range,
}

/// The newest version both sides speak.
///
/// # Errors
/// [`NoCommonVersion`] if the ranges do not meet.
pub const fn negotiate(ours: Range, theirs: Range) -> Result<u8, NoCommonVersion> {
    let newest = if ours.current < theirs.current { ours.current } else { theirs.current };
    let oldest = if ours.min > theirs.min { ours.min } else { theirs.min };
    if oldest <= newest { Ok(newest) } else { Err(NoCommonVersion { ours, theirs }) }
}
