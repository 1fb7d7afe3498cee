//! `cargo xtask emulate`: boots the pile's image and shows its log until it is interrupted.

use std::net::{Ipv4Addr, SocketAddr};
use std::process::ExitCode;
use std::time::Duration;

use tests::emulator::{Emulator, Serial};

fn main() -> ExitCode {
    let mut ports = std::env::args().skip(1).map_while(|port| port.parse().ok());
    let (Some(link), Some(reader)) = (ports.next(), ports.next()) else {
        eprintln!(
            "error: two ports are needed, for the link and the reader; `cargo xtask emulate` gives them"
        );
        return ExitCode::FAILURE;
    };
    let listen = |port| Serial::Listen(SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    let mut board = match Emulator::boot(listen(link), listen(reader)) {
        Ok(board) => board,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    println!("USART1, the link to the coordinator: 127.0.0.1:{link}");
    println!("USART2, the RFID reader:             127.0.0.1:{reader}");
    println!("For a coordinator to call it, its configuration needs:");
    println!("    [[pile]]\n    id = 1  # or what its log below says\n    address = \"127.0.0.1:{link}\"");
    println!("It has no keys, so that the coordinator has to run without them: `insecure = true`.");
    println!("Until an RFID reader answers, the pile reports that it is silent.");
    while let Some(line) = board.next_line(Duration::MAX) {
        println!("{line}");
    }
    eprintln!("error: the board has ended; its log above says why");
    ExitCode::FAILURE
}
