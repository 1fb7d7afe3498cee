//! A board in QEMU, its UARTs on TCP, its log as lines.
//!
//! The images are those that `cargo xtask firmware` built. QEMU ends when the [`Emulator`] is
//! dropped.

use std::fmt;
use std::io::{self, Read};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

use defmt_decoder::{DecodeError, Table};

/// The emulator, of version 10 or newer.
const QEMU: &str = "qemu-system-arm";

/// Its machine with the USARTs, SysTick and interrupt controller of the boards' STM32F407.
const MACHINE: &str = "olimex-stm32-h405";

/// Why a board is not there.
#[derive(Debug, thiserror::Error)]
pub enum EmulatorError {
    /// There is no image, or it cannot be read.
    #[error("cannot read the image {}: {cause}; build it with `cargo xtask firmware`", path.display())]
    Image {
        /// Where it should be.
        path: PathBuf,
        /// Why it is not.
        cause: io::Error,
    },
    /// The image has no defmt log, or one of another version.
    #[error("the image {} has no log that can be read: {cause}; build it with `cargo xtask firmware`", path.display())]
    Log {
        /// The image.
        path: PathBuf,
        /// What its table lacks.
        cause: String,
    },
    /// QEMU is missing or does not run.
    #[error("cannot start {QEMU}: {0}; `cargo xtask setup` installs it")]
    Qemu(#[from] io::Error),
    /// The emulated board ended, which it never should.
    #[error("{QEMU} ended ({0}) before the log said {1:?}; its log and its messages above say why")]
    Ended(ExitStatus, String),
    /// The board lives and did not say it in time.
    #[error("the board's log did not say {wanted:?} within {limit:?}, only: {lines:#?}")]
    Silent {
        /// What was waited for.
        wanted: String,
        /// How long.
        limit: Duration,
        /// What came instead.
        lines: Vec<String>,
    },
}

/// The other end of a UART: a TCP connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Serial {
    /// The board connects to who listens there, again and again.
    Dial(SocketAddr),
    /// The board listens there.
    Listen(SocketAddr),
}

impl fmt::Display for Serial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Dial(address) | Self::Listen(address)) = self;
        write!(f, "host={},port={},nodelay=on,", address.ip(), address.port())?;
        f.write_str(match self {
            Self::Dial(_) => "server=off,reconnect-ms=200",
            Self::Listen(_) => "server=on,wait=off",
        })
    }
}

/// What an emulated board does with the time in which it has nothing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// It lets it pass, as a board does.
    RealTime,
    /// It skips it: its clock runs ahead of ours.
    Hurried,
}

/// Bytes of a pile's flash that are its store's.
pub const FLASH: usize = 32 * 1024;

/// A running board.
pub struct Emulator {
    qemu: Child,
    log: Receiver<String>,
    seen: Vec<String>,
    /// How many of the lines seen were searched by [`Self::wait_for`].
    searched: usize,
}

impl Emulator {
    /// Boots the pile's image with USART1 as its `link` and USART2 as its RFID `reader`.
    ///
    /// # Errors
    /// [`EmulatorError`] says what is missing and how to get it.
    pub fn boot(link: Serial, reader: Serial) -> Result<Self, EmulatorError> {
        Self::start("firmware-pile-emulated", &[(1, link), (2, reader)], &[])
    }

    /// Boots the pile's image with nothing connected. Its clock counts instructions, one a nanosecond.
    ///
    /// # Errors
    /// [`EmulatorError`] says what is missing and how to get it.
    pub fn boot_counting() -> Result<Self, EmulatorError> {
        Self::start("firmware-pile-emulated", &[], &["-icount", "shift=0"])
    }

    /// Boots the same with USART6 as its test `bench`. Its clock counts instructions, one a
    /// nanosecond, so that no control tick is late when this machine is busy.
    ///
    /// # Errors
    /// [`EmulatorError`] says what is missing and how to get it.
    pub fn boot_pile(link: Serial, reader: Serial, bench: Serial) -> Result<Self, EmulatorError> {
        let uarts = [(1, link), (2, reader), (6, bench)];
        Self::start("firmware-pile-emulated", &uarts, &["-icount", "shift=0"])
    }

    /// Boots the same with the file `flash` as its flash, of [`FLASH`] bytes that are `FF` at first, and
    /// with its button held or not. The board of an erased flash is nobody yet.
    ///
    /// # Errors
    /// [`EmulatorError`] says what is missing and how to get it.
    pub fn boot_board(
        [link, reader, bench]: [Serial; 3],
        flash: &Path,
        button_held: bool,
    ) -> Result<Self, EmulatorError> {
        let uarts = [(1, link), (2, reader), (6, bench)];
        let button = if button_held { "button " } else { "" };
        let words = format!("enable=on,target=native,arg={button}flash={}", flash.display());
        Self::start("firmware-pile-emulated", &uarts, &["-icount", "shift=0", "-semihosting-config", &words])
    }

    /// Boots the chassis' image with USART1 as its `link`, USART2 as its RFID `reader` and USART6 as
    /// its test `bench`. Its clock counts instructions, one a nanosecond, so that no control tick is
    /// late when this machine is busy.
    ///
    /// # Errors
    /// [`EmulatorError`] says what is missing and how to get it.
    pub fn boot_chassis(
        link: Serial,
        reader: Serial,
        bench: Serial,
        pace: Pace,
    ) -> Result<Self, EmulatorError> {
        let uarts = [(1, link), (2, reader), (6, bench)];
        let clock = match pace {
            Pace::RealTime => "shift=0",
            Pace::Hurried => "shift=0,sleep=off",
        };
        Self::start("firmware-chassis-emulated", &uarts, &["-icount", clock])
    }

    /// Boots an image with these of its USARTs connected, by number.
    fn start(image: &str, uarts: &[(u8, Serial)], options: &[&str]) -> Result<Self, EmulatorError> {
        let path = path(image);
        let table = log_table(&path)?;
        let mut command = Command::new(QEMU);
        command.args(["-M", MACHINE, "-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]).args(options);
        // QEMU numbers them by the order of these options.
        for number in 1..=6 {
            match uarts.iter().find(|(uart, _)| *uart == number) {
                Some((_, serial)) => {
                    command.args(["-chardev", &format!("socket,id=usart{number},{serial}")]);
                    command.args(["-serial", &format!("chardev:usart{number}")]);
                }
                None => {
                    command.args(["-serial", "null"]);
                }
            }
        }
        command.arg("-kernel").arg(path);
        let mut qemu = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn()?;
        let (lines, log) = mpsc::channel();
        if let Some(output) = qemu.stdout.take() {
            thread::spawn(move || read_log(output, &table, &lines));
        }
        Ok(Self { qemu, log, seen: Vec::new(), searched: 0 })
    }

    /// The next line of the log, `None` when the board has ended or said nothing for `limit`.
    pub fn next_line(&mut self, limit: Duration) -> Option<&str> {
        let line = self.log.recv_timeout(limit).ok()?;
        self.seen.push(line);
        self.seen.last().map(String::as_str)
    }

    /// Waits until the log says something that contains `wanted`, after what the last call found.
    ///
    /// # Errors
    /// [`EmulatorError::Silent`] if it does not within `limit`, [`EmulatorError::Ended`] if the
    /// board is no more.
    pub fn wait_for(&mut self, wanted: &str, limit: Duration) -> Result<(), EmulatorError> {
        let deadline = Instant::now() + limit;
        loop {
            while let Some(line) = self.seen.get(self.searched) {
                self.searched += 1;
                if line.contains(wanted) {
                    return Ok(());
                }
            }
            match self.log.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(line) => self.seen.push(line),
                Err(RecvTimeoutError::Timeout) => {
                    let lines = self.seen.clone();
                    return Err(EmulatorError::Silent { wanted: wanted.into(), limit, lines });
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(EmulatorError::Ended(self.qemu.wait()?, wanted.into()));
                }
            }
        }
    }

    /// All that the log has said so far.
    pub fn log(&mut self) -> &[String] {
        self.seen.extend(self.log.try_iter());
        &self.seen
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Both fail only if it has ended already, which is what is wanted.
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

/// Where `cargo xtask firmware` puts an image.
fn path(image: &str) -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).join("target/thumbv7em-none-eabihf/release").join(image)
}

/// The texts of the log, which are in the image and not in what it sends.
fn log_table(path: &Path) -> Result<Table, EmulatorError> {
    let elf = std::fs::read(path).map_err(|cause| EmulatorError::Image { path: path.into(), cause })?;
    let table = Table::parse(&elf)
        .map_err(|error| error.to_string())
        .and_then(|table| table.ok_or_else(|| "it was built without defmt".to_owned()));
    table.map_err(|cause| EmulatorError::Log { path: path.into(), cause })
}

/// Turns what the board writes into lines until it ends, or nobody wants them any more.
fn read_log(mut output: ChildStdout, table: &Table, lines: &Sender<String>) {
    let mut decoder = table.new_stream_decoder();
    let mut buffer = [0; 1024];
    while let Ok(length @ 1..) = output.read(&mut buffer) {
        decoder.received(buffer.get(..length).unwrap_or_default());
        loop {
            let line = match decoder.decode() {
                Ok(frame) => frame.display(false).to_string(),
                Err(DecodeError::Malformed) => "(a garbled line)".to_owned(),
                Err(DecodeError::UnexpectedEof) => break,
            };
            if lines.send(line).is_err() {
                return;
            }
        }
    }
}
