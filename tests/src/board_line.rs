//! The lines to an emulated board: how it calls, and its test bench.

use std::io::{self, BufRead, BufReader, ErrorKind, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::str::FromStr;
use std::thread;
use std::time::{Duration, Instant};

use crate::emulator::Serial;

/// Nothing that is waited for takes longer, on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A place where a board that is about to boot calls.
pub struct Awaited(TcpListener);

impl Awaited {
    /// A port of its own.
    ///
    /// # Errors
    /// If there is none to listen on.
    pub fn new() -> io::Result<Self> {
        TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).map(Self)
    }

    /// What the board is told.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn serial(&self) -> io::Result<Serial> {
        self.0.local_addr().map(Serial::Dial)
    }

    /// The board's connection; it calls as soon as QEMU runs.
    ///
    /// # Errors
    /// If it does not call.
    pub fn accept(self) -> io::Result<TcpStream> {
        self.0.set_nonblocking(true)?;
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.0.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false)?;
                    return Ok(stream);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock && Instant::now() < deadline => {
                    thread::sleep(Duration::from_millis(10));
                }
                Err(error) => return Err(error),
            }
        }
    }
}

/// The test bench of a board: a line of words out, a line in.
pub struct TestBench(BufReader<TcpStream>);

impl TestBench {
    /// The bench at the other end of `line`.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn new(line: TcpStream) -> io::Result<Self> {
        line.set_read_timeout(Some(PATIENCE))?;
        Ok(Self(BufReader::new(line)))
    }

    /// What the bench answers to `words`.
    ///
    /// # Errors
    /// If it does not answer.
    pub fn ask(&mut self, words: &str) -> io::Result<String> {
        self.say(words)?;
        let mut line = String::new();
        self.0.read_line(&mut line)?;
        Ok(line.trim_end().to_owned())
    }

    /// The numbers that the bench answers to `word`, after that word.
    ///
    /// # Errors
    /// If it does not answer, or something else.
    pub fn numbers<T: FromStr, const N: usize>(&mut self, word: &str) -> io::Result<[T; N]> {
        let line = self.ask(word)?;
        let numbers: Vec<T> = line.split(' ').skip(1).filter_map(|word| word.parse().ok()).collect();
        numbers.try_into().map_err(|_| io::Error::other(line))
    }

    /// Breaks or mends something: see the image's test bench for the words.
    ///
    /// # Errors
    /// If it does not know them.
    pub fn order(&mut self, words: &str) -> io::Result<()> {
        match self.ask(words)?.as_str() {
            "ok" => Ok(()),
            answer => Err(io::Error::other(format!("the bench answers {answer:?} to {words:?}"))),
        }
    }

    /// Makes a task of the board hang.
    ///
    /// # Errors
    /// If the bench is gone.
    pub fn hang(&mut self) -> io::Result<()> {
        self.say("hang")
    }

    fn say(&mut self, words: &str) -> io::Result<()> {
        self.0.get_mut().write_all(format!("{words}\n").as_bytes())
    }
}
