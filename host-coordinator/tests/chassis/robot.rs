//! The real chassis core on a model of its robot, in real time behind a line: a TCP socket, or a
//! pseudo-terminal in place of a serial port.

use std::{
    io::{self, Read, Write},
    net::{SocketAddr, TcpListener},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

use firmware_chassis::{Chassis, Input, Messages, Motors, Parameters, plant::Plant};
use protocol::{
    BootEpoch, ChassisMode, Deframer, DeviceId, Frame, Millis, Recipient, RobotId, Sessions, StopReason,
};

pub const ROBOT: RobotId = RobotId(7);

/// What the chassis says of itself and its speed after each tick.
pub struct Told {
    pub mode: ChassisMode,
    pub stop: Option<StopReason>,
    pub forward_mps: f32,
    /// Frames it has heard since its start.
    pub frames: u32,
}

/// A line that does not wait for bytes.
trait Line: Read + Write + Send {}
impl<T: Read + Write + Send> Line for T {}

/// A chassis behind a socket that takes one caller after the other, the newest one being the line,
/// for as long as somebody wants to be told.
pub fn at_socket() -> (SocketAddr, Receiver<Told>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    listener.set_nonblocking(true).unwrap();
    let told = run(move || {
        let (stream, _) = listener.accept().ok()?;
        stream.set_nonblocking(true).unwrap();
        stream.set_nodelay(true).unwrap();
        Some(Box::new(stream))
    });
    (address, told)
}

/// A chassis at a serial port of this computer: the port's path, and what keeps it there.
#[cfg(unix)]
pub fn at_port() -> (std::path::PathBuf, impl Drop, Receiver<Told>) {
    use std::{ffi::OsStr, fs::File, os::unix::ffi::OsStrExt as _};

    use rustix::{fs, pty, termios};

    let chassis = pty::openpt(pty::OpenptFlags::RDWR | pty::OpenptFlags::NOCTTY).unwrap();
    pty::grantpt(&chassis).unwrap();
    pty::unlockpt(&chassis).unwrap();
    let name = pty::ptsname(&chassis, Vec::new()).unwrap();
    let path = std::path::PathBuf::from(OsStr::from_bytes(name.as_bytes()));
    // Held open, as a cable is: a port that nobody has open would end. And without an echo.
    let flags = fs::OFlags::RDWR | fs::OFlags::NOCTTY;
    let held = fs::open(&path, flags, fs::Mode::empty()).unwrap();
    let mut settings = termios::tcgetattr(&held).unwrap();
    settings.make_raw();
    termios::tcsetattr(&held, termios::OptionalActions::Now, &settings).unwrap();
    fs::fcntl_setfl(&chassis, fs::OFlags::RDWR | fs::OFlags::NONBLOCK).unwrap();
    let mut line = Some(Box::new(File::from(chassis)) as Box<dyn Line>);
    (path, held, run(move || line.take()))
}

fn run(mut caller: impl FnMut() -> Option<Box<dyn Line>> + Send + 'static) -> Receiver<Told> {
    let (tell, told) = channel();
    thread::spawn(move || {
        let parameters = Parameters::new(ROBOT);
        let mut chassis = Chassis::new(parameters).unwrap();
        let mut plant = Plant::new(&parameters, [0; 4]);
        let mut motors = Motors::Brake;
        let mut sessions = Sessions::insecure(DeviceId::Chassis(ROBOT), BootEpoch(1));
        let computer = Recipient::Device(DeviceId::Robot(ROBOT));
        let mut line: Option<(Box<dyn Line>, Deframer)> = None;
        let mut frames = 0;
        let start = Instant::now();
        for tick in 1.. {
            let now = Millis(tick * 10);
            thread::sleep((start + Duration::from_millis(now.0)).saturating_duration_since(Instant::now()));
            if let Some(new) = caller() {
                line = Some((new, Deframer::new()));
            }
            let (mut sent, mut messages) = (Vec::new(), Messages::new());
            for frame in heard(&mut line, &mut sessions) {
                frames += 1;
                motors = chassis.step(now, Input::Frame(&frame), &mut messages);
                sent.extend(messages.drain(..));
            }
            motors = chassis.step(now, Input::Tick(plant.advance(motors)), &mut messages);
            for message in sent.into_iter().chain(messages) {
                let bytes = sessions.seal(computer, &message).unwrap();
                if let Some((line, _)) = &mut line {
                    // A caller that hung up, or does not read, misses it.
                    let _ = line.write_all(&bytes);
                }
            }
            let (mode, stop) = (chassis.motion().mode(), chassis.motion().stop());
            if tell.send(Told { mode, stop, forward_mps: chassis.velocity().x, frames }).is_err() {
                return;
            }
        }
    });
    told
}

fn heard(line: &mut Option<(Box<dyn Line>, Deframer)>, sessions: &mut Sessions) -> Vec<Frame> {
    let mut frames = Vec::new();
    let mut buffer = [0; 1024];
    while let Some((stream, deframer)) = line {
        match stream.read(&mut buffer) {
            Ok(length @ 1..) => deframer.feed(&buffer[..length], |found| {
                frames.extend(found.and_then(|packet| sessions.open(packet)));
            }),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
            Ok(0) | Err(_) => *line = None,
        }
    }
    frames
}
