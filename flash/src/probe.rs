//! Onto the board, through the first debug probe that is plugged in.

use probe_rs::flashing::{DownloadOptions, FlashError, FlashLoader};
use probe_rs::probe::DebugProbeError;
use probe_rs::probe::list::Lister;
use probe_rs::{Permissions, Target};

use crate::image::Image;

/// Why the board is not flashed.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// No probe.
    #[error("no debug probe is plugged in; connect the board's ST-LINK by USB")]
    NoProbe,
    /// The probe cannot be used.
    #[error("the debug probe cannot be opened: {0}; may this user open USB devices?")]
    Open(#[from] DebugProbeError),
    /// The chip does not answer as it should.
    #[error("the chip does not answer: {0}; is the board powered, and its chip an STM32F407VG?")]
    Attach(#[from] probe_rs::Error),
    /// It was not written.
    #[error("flashing failed: {0}; try again")]
    Flash(#[from] FlashError),
}

/// What probe-rs would write: it refuses what the chip's map has no place for.
///
/// # Errors
/// [`ProbeError::Flash`].
pub fn loader(image: &Image, target: &Target) -> Result<FlashLoader, ProbeError> {
    let mut loader = target.flash_loader();
    for segment in image.segments.iter().filter(|segment| !segment.data.is_empty()) {
        loader.add_data(segment.flashed_at, &segment.data)?;
    }
    Ok(loader)
}

/// Writes and verifies, sector by sector: what the image does not touch stays. Then starts it.
///
/// # Errors
/// [`ProbeError`].
pub fn write(loader: FlashLoader, target: Target) -> Result<(), ProbeError> {
    let probe = Lister::new().list_all().into_iter().next().ok_or(ProbeError::NoProbe)?.open()?;
    let mut session = probe.attach(target, Permissions::default())?;
    let mut options = DownloadOptions::default();
    options.verify = true;
    loader.commit(&mut session, options)?;
    session.core(0)?.reset()?;
    Ok(())
}
