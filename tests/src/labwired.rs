//! A board's image that is flashed, in LabWired: an emulator with the clocks, timers and peripherals of
//! the STM32F407, where QEMU has none of them. It runs some hundred times slower than the board would,
//! and gives it no bytes to receive.
//!
//! It lacks most of the FPU (`vcmp.f32` and others are undefined to it), so the image is compiled for the
//! same core without one, `thumbv7em-none-eabi`, and is otherwise what is flashed.

use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use protocol::{BootEpoch, Deframer, DeviceId, FrameError, Header, Message, Sessions};

/// Where `cargo xtask setup` puts LabWired.
const PYTHON: &str = "target/labwired/bin/python";
/// Where `cargo xtask boot` and `cargo xtask test` put the images.
const IMAGES: &str = "target/thumbv7em-none-eabi/release";
/// What runs an image.
const SCRIPT: &str = "tests/labwired/boot.py";

/// What a board sent in its first moments.
#[derive(Clone, Debug)]
pub struct Boot {
    /// What left, in order.
    pub frames: Vec<Sent>,
    /// What was between frames: LabWired adds bytes.
    pub discarded: Vec<FrameError>,
}

/// A frame that left a board.
#[derive(Clone, Debug)]
pub struct Sent {
    /// Since the start, at most a millisecond too much.
    pub at: Duration,
    /// Who sent it, in which of its starts.
    pub header: Header,
    /// What it says, if it says so without a key.
    pub message: Option<Message>,
}

impl Boot {
    /// When the first Hello left.
    #[must_use]
    pub fn hello_at(&self) -> Option<Duration> {
        let is_hello = |sent: &&Sent| matches!(sent.message, Some(Message::Hello(_)));
        self.frames.iter().find(is_hello).map(|sent| sent.at)
    }

    /// Whether all frames are of one start of the board, one after the other: a reset begins anew.
    #[must_use]
    pub fn is_one_start(&self) -> bool {
        let number = |sent: &Sent| (sent.header.boot, sent.header.sequence);
        self.frames.windows(2).all(|pair| match pair {
            [one, next] => one.header.boot == next.header.boot && number(one) < number(next),
            _ => true,
        })
    }
}

/// Why nothing is known about a board's start.
#[derive(Debug, thiserror::Error)]
pub enum LabwiredError {
    /// LabWired is not there or does not start.
    #[error("cannot run {PYTHON}: {0}; `cargo xtask setup` installs LabWired")]
    Start(#[from] io::Error),
    /// It ended with an error.
    #[error("LabWired cannot run {}: {message}; `cargo xtask boot` builds the image", image.display())]
    Failed {
        /// The image.
        image: PathBuf,
        /// What it said.
        message: String,
    },
    /// What the script printed is not what it should print.
    #[error("{SCRIPT} printed {0:?}; report this as a defect")]
    Script(String),
    /// The core took a fault.
    #[error("the board faulted: CFSR {cfsr}, HFSR {hfsr}")]
    Fault {
        /// The configurable fault status register.
        cfsr: String,
        /// The hard fault status register.
        hfsr: String,
    },
}

/// A board in LabWired.
#[derive(Clone, Copy, Debug)]
pub struct Board {
    /// The package of its image.
    pub package: &'static str,
    /// The pins that are held low; all others are open.
    pub low: &'static [&'static str],
}

/// The pile: no emergency stop is pressed, and there is mains. Without mains it would fall silent.
pub const PILE: Board = Board { package: "firmware-pile", low: &["e9", "e10"] };
/// The chassis.
pub const CHASSIS: Board = Board { package: "firmware-chassis", low: &[] };

/// Starts a board's image and lets it run for `time`, in whole milliseconds.
///
/// # Errors
/// [`LabwiredError`].
pub fn boot(Board { package, low }: Board, time: Duration) -> Result<Boot, LabwiredError> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = here.parent().unwrap_or(here);
    let image = root.join(IMAGES).join(format!("{package}-stm32"));
    let output = Command::new(root.join(PYTHON))
        .arg(root.join(SCRIPT))
        .arg(&image)
        .arg(time.as_millis().to_string())
        .args(low)
        .output()?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let message = said.trim().lines().last().unwrap_or("it gave no reason").to_owned();
        return Err(LabwiredError::Failed { image, message });
    }
    read(&String::from_utf8_lossy(&output.stdout))
}

/// Reads what the script printed.
fn read(printed: &str) -> Result<Boot, LabwiredError> {
    let mut boot = Boot { frames: Vec::new(), discarded: Vec::new() };
    let mut deframer = Deframer::new();
    let mut coordinator = Sessions::insecure(DeviceId::Coordinator, BootEpoch(1));
    let mut ended = false;
    for line in printed.lines() {
        let defect = || LabwiredError::Script(line.to_owned());
        match line.split(' ').collect::<Vec<_>>()[..] {
            ["end", "00000000", "00000000"] => ended = true,
            ["end", cfsr, hfsr] => {
                return Err(LabwiredError::Fault { cfsr: cfsr.into(), hfsr: hfsr.into() });
            }
            [milliseconds, bytes] => {
                let at = Duration::from_millis(milliseconds.parse().map_err(|_| defect())?);
                deframer.feed(&bytes_of(bytes).ok_or_else(defect)?, |packet| match packet {
                    Ok(packet) => {
                        let header = packet.header();
                        let message = coordinator.open(packet).ok().map(|frame| frame.message);
                        boot.frames.push(Sent { at, header, message });
                    }
                    Err(error) => boot.discarded.push(error),
                });
            }
            _ => return Err(defect()),
        }
    }
    if ended { Ok(boot) } else { Err(LabwiredError::Script(printed.to_owned())) }
}

/// Bytes from hexadecimal digits.
fn bytes_of(digits: &str) -> Option<Vec<u8>> {
    let (pairs, rest) = digits.as_bytes().as_chunks::<2>();
    let byte = |pair: &[u8; 2]| u8::from_str_radix(str::from_utf8(pair).ok()?, 16).ok();
    if rest.is_empty() { pairs.iter().map(byte).collect() } else { None }
}

#[cfg(test)]
mod tests {
    use protocol::{Ack, Recipient, Reference};

    use super::*;

    /// What a board in its start `boot` sends first.
    fn sent(boot: u32) -> String {
        let mut sessions = Sessions::insecure(DeviceId::Service, BootEpoch(boot));
        let ack = Message::Ack(Ack { of: Reference::Command(protocol::CommandId(1)) });
        let frame = sessions.seal(Recipient::Device(DeviceId::Coordinator), &ack);
        frame.unwrap_or_default().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    #[test]
    fn a_reset_shows_whether_starts_are_counted_or_not() {
        for boot in [1, 2] {
            let printed = format!("3 {}\n9 {}\nend 00000000 00000000\n", sent(1), sent(boot));
            let boot = read(&printed).expect("it is well formed");
            assert_eq!(boot.frames.len(), 2);
            assert!(!boot.is_one_start());
        }
        let one = read(&format!("3 {}\nend 00000000 00000000\n", sent(1))).expect("it is well formed");
        assert!(one.is_one_start());
        assert_eq!(one.hello_at(), None);
    }

    #[test]
    fn stray_bytes_between_frames_cost_no_frame() {
        let printed = format!("3 {}4142\n9 00ff{}\nend 00000000 00000000\n", sent(1), sent(2));
        let boot = read(&printed).expect("it is well formed");
        assert_eq!(boot.frames.iter().map(|sent| sent.at.as_millis()).collect::<Vec<_>>(), [3, 9]);
        assert_eq!(boot.discarded.len(), 2);
    }

    #[test]
    fn a_fault_and_a_script_that_did_not_end_are_errors() {
        assert!(matches!(read("end 00010000 40000000\n"), Err(LabwiredError::Fault { .. })));
        assert!(matches!(read("3 00\n"), Err(LabwiredError::Script(_))));
        assert!(matches!(read("Traceback\n"), Err(LabwiredError::Script(_))));
    }
}
