//! The line to one board: a serial port, or a TCP connection to where one ends (the emulated board,
//! a serial server).

use std::{fmt, io, path::PathBuf, time::Duration};

use serial2_tokio::SerialPort;
use tokio::{
    io::{AsyncRead, AsyncWrite},
    net::TcpStream,
    time,
};

mod wire;

pub use wire::{Event, Wire};

/// Who does not answer a call for this long is not there.
const CALL: Duration = Duration::from_secs(2);

/// Where a board is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// At a serial port.
    Serial(PathBuf),
    /// At `HOST:PORT`.
    Tcp(String),
}

/// An open line.
pub trait Line: AsyncRead + AsyncWrite + Send + Unpin {}
impl<T: AsyncRead + AsyncWrite + Send + Unpin> Line for T {}

/// A line could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum LineError {
    /// No such port, or not ours to open.
    #[error("cannot open serial port {}: {error}; {}", .port.display(), advice(.ports))]
    Serial {
        /// The port.
        port: PathBuf,
        /// Why.
        error: io::Error,
        /// Those that are there.
        ports: Vec<PathBuf>,
    },
    /// Nobody there.
    #[error("cannot connect to {address}: {error}; is the board on, and is HOST:PORT right?")]
    Tcp {
        /// Where.
        address: String,
        /// Why.
        error: io::Error,
    },
}

impl Address {
    /// Opens the line; a serial one with `baud`, to which the board's USART is set.
    ///
    /// # Errors
    /// [`LineError`] says which, why, and what to look at.
    pub async fn open(&self, baud: u32) -> Result<Box<dyn Line>, LineError> {
        match self {
            Self::Serial(port) => {
                let opened = SerialPort::open(port, baud);
                let port = opened.map_err(|error| LineError::Serial {
                    port: port.clone(),
                    error,
                    ports: SerialPort::available_ports().unwrap_or_default(),
                })?;
                Ok(Box::new(port))
            }
            Self::Tcp(address) => {
                let failed = |error| LineError::Tcp { address: address.clone(), error };
                let call = time::timeout(CALL, TcpStream::connect(address.as_str())).await;
                let stream = call.map_err(|elapsed| failed(elapsed.into()))?.map_err(failed)?;
                // Frames are small and wanted now.
                stream.set_nodelay(true).map_err(failed)?;
                Ok(Box::new(stream))
            }
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(port) => write!(f, "{}", port.display()),
            Self::Tcp(address) => f.write_str(address),
        }
    }
}

fn advice(ports: &[PathBuf]) -> String {
    if ports.is_empty() {
        return "this computer sees no serial port at all: is the board plugged in?".into();
    }
    let names: Vec<_> = ports.iter().map(|port| port.display().to_string()).collect();
    format!("this computer has {}; may you open it?", names.join(", "))
}
