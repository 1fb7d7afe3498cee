//! Recordings of a chassis as MCAP files of ROS 2 messages, for `ros2 bag`, Foxglove and scripts.
//!
//! | channel | message |
//! |---|---|
//! | `/cmd_vel` | `geometry_msgs/msg/Twist`: the command in force |
//! | `/cmd_vel_ramped` | `geometry_msgs/msg/Twist`: what the ramp makes of it |
//! | `/odom` | `nav_msgs/msg/Odometry`: pose and measured twist |
//! | `/tf` | `tf2_msgs/msg/TFMessage`: the pose once more, for a view in space |
//! | `/diagnostics` | `diagnostic_msgs/msg/DiagnosticArray`: mode, stop, faults, battery |
//!
//! A message's publish time and stamp follow the chassis' clock, which knows no jitter of the line;
//! its log time is that of its arrival. All are times since 1970 UTC.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufWriter, Seek, Write},
    path::Path,
};

use mcap::{McapError, MessageStream, WriteOptions, Writer, records::MessageHeader};
use protocol::{ChassisFault, ChassisState, Odometry, SpeedMps, TurnRateRadps, Twist};
use serde::{Serialize, de::DeserializeOwned};

use super::{
    ros::{self, Header, RosError, Time, Vector3},
    session::Heard,
    words,
};

const COMMANDED: &str = "/cmd_vel";
const RAMPED: &str = "/cmd_vel_ramped";
const ODOMETRY: &str = "/odom";
const TRANSFORM: &str = "/tf";
const DIAGNOSTICS: &str = "/diagnostics";

/// What is wrong with a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// It cannot be written.
    #[error("cannot write the recording: {0}")]
    Write(McapError),
    /// A message has no bytes.
    #[error("cannot write a message of the recording: {0}")]
    Encode(RosError),
    /// It cannot be read.
    #[error("no readable MCAP file ({0}); if its recording was cut off, `mcap recover` may save it")]
    Read(McapError),
    /// A message of ours that is none.
    #[error("{topic}: {error}; was this recorded by `chargehand chassis`?")]
    Message {
        /// Its channel.
        topic: &'static str,
        /// What is wrong with it.
        error: RosError,
    },
    /// Nothing to see.
    #[error("nothing about a chassis' speed in it; record with `chargehand chassis record`")]
    Empty,
}

/// Writes a recording.
pub struct Recorder<W: Write + Seek> {
    writer: Writer<W>,
    commanded: u16,
    ramped: u16,
    odometry: u16,
    transform: u16,
    diagnostics: u16,
    sequence: u32,
    /// The chassis' zero in nanoseconds since 1970, and its last stamp.
    zero: Option<(u64, u64)>,
}

impl Recorder<BufWriter<File>> {
    /// A new file, in place of one that was there.
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn create(file: &Path) -> Result<Self, RecordingError> {
        let file = File::create(file).map_err(|error| RecordingError::Write(error.into()))?;
        Self::new(BufWriter::new(file)).map_err(RecordingError::Write)
    }
}

impl<W: Write + Seek> Recorder<W> {
    fn new(to: W) -> Result<Self, McapError> {
        let options = WriteOptions::new().compression(None).library("chargehand").profile("ros2");
        let mut writer = options.create(to)?;
        let mut channel = |topic: &str, package: &str, name: &str| -> Result<u16, McapError> {
            let definition = ros::definition(package, name);
            let schema =
                writer.add_schema(&format!("{package}/msg/{name}"), "ros2msg", definition.as_bytes())?;
            writer.add_channel(schema, topic, "cdr", &BTreeMap::new())
        };
        Ok(Self {
            commanded: channel(COMMANDED, "geometry_msgs", "Twist")?,
            ramped: channel(RAMPED, "geometry_msgs", "Twist")?,
            odometry: channel(ODOMETRY, "nav_msgs", "Odometry")?,
            transform: channel(TRANSFORM, "tf2_msgs", "TFMessage")?,
            diagnostics: channel(DIAGNOSTICS, "diagnostic_msgs", "DiagnosticArray")?,
            writer,
            sequence: 0,
            zero: None,
        })
    }

    /// Adds what was heard `now_ns` nanoseconds after 1970 UTC.
    ///
    /// # Errors
    /// [`RecordingError::Write`]; [`RecordingError::Encode`] is not to be expected.
    pub fn record(&mut self, now_ns: u64, heard: &Heard) -> Result<(), RecordingError> {
        match heard {
            Heard::State(state) => self.write(self.diagnostics, now_ns, now_ns, &diagnostics(now_ns, state)),
            Heard::Odometry(told) => {
                let at = self.published(now_ns, told.stamp.0.saturating_mul(1_000_000));
                self.write(self.commanded, now_ns, at, &twist(&told.commanded))?;
                self.write(self.ramped, now_ns, at, &twist(&told.ramped))?;
                let odometry = odometry(at, told);
                self.write(self.transform, now_ns, at, &transform(&odometry))?;
                self.write(self.odometry, now_ns, at, &odometry)
            }
        }
    }

    /// Ends the file properly.
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn finish(mut self) -> Result<(), RecordingError> {
        self.writer.finish().map(drop).map_err(RecordingError::Write)
    }

    /// A chassis whose clock goes back has started anew.
    fn published(&mut self, now_ns: u64, stamp_ns: u64) -> u64 {
        let started = self.zero.filter(|(_, last)| *last <= stamp_ns);
        let zero = started.map_or_else(|| now_ns.saturating_sub(stamp_ns), |(zero, _)| zero);
        self.zero = Some((zero, stamp_ns));
        zero.saturating_add(stamp_ns)
    }

    fn write(
        &mut self,
        channel_id: u16,
        log_time: u64,
        publish_time: u64,
        message: &impl Serialize,
    ) -> Result<(), RecordingError> {
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time, publish_time };
        self.sequence = self.sequence.wrapping_add(1);
        let bytes = ros::to_bytes(message).map_err(RecordingError::Encode)?;
        self.writer.write_to_known_channel(&header, &bytes).map_err(RecordingError::Write)
    }
}

/// A speed at a time, in seconds since the recording began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When.
    pub at_s: f64,
    /// How fast.
    pub twist: Twist,
}

/// The speeds in a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Speeds {
    /// The command in force.
    pub commanded: Vec<Sample>,
    /// What the ramp made of it.
    pub ramped: Vec<Sample>,
    /// What the wheels and the gyroscope said.
    pub measured: Vec<Sample>,
}

impl Speeds {
    /// Reads a recording.
    ///
    /// # Errors
    /// [`RecordingError`] says what is wrong with it.
    pub fn read(bytes: &[u8]) -> Result<Self, RecordingError> {
        // mcap 0.26 subtracts without a check where a record in a chunk claims to be longer than the
        // chunk, and panics where overflows are checked.
        let read = std::panic::catch_unwind(|| Self::read_records(bytes));
        read.unwrap_or(Err(RecordingError::Read(McapError::UnexpectedEof)))
    }

    fn read_records(bytes: &[u8]) -> Result<Self, RecordingError> {
        let mut found: [Vec<(u64, Twist)>; 3] = Default::default();
        let [commanded, ramped, measured] = &mut found;
        for message in MessageStream::new(bytes).map_err(RecordingError::Read)? {
            let message = message.map_err(RecordingError::Read)?;
            let (at, data) = (message.publish_time, message.data.as_ref());
            match message.channel.topic.as_str() {
                COMMANDED => commanded.push((at, read::<ros::Twist>(COMMANDED, data)?)),
                RAMPED => ramped.push((at, read::<ros::Twist>(RAMPED, data)?)),
                ODOMETRY => measured.push((at, read::<ros::Odometry>(ODOMETRY, data)?)),
                _ => {}
            }
        }
        let start = found.iter().flatten().map(|(at, _)| *at).min().ok_or(RecordingError::Empty)?;
        let [commanded, ramped, measured] = found.map(|samples| {
            let sample = |(at, twist)| Sample { at_s: (at - start) as f64 / 1e9, twist };
            samples.into_iter().map(sample).collect()
        });
        Ok(Self { commanded, ramped, measured })
    }
}

fn read<T>(topic: &'static str, data: &[u8]) -> Result<Twist, RecordingError>
where
    T: DeserializeOwned,
    Twist: TryFrom<T, Error = RosError>,
{
    ros::from_bytes::<T>(data)
        .and_then(Twist::try_from)
        .map_err(|error| RecordingError::Message { topic, error })
}

impl TryFrom<ros::Twist> for Twist {
    type Error = RosError;

    fn try_from(ros::Twist { linear, angular }: ros::Twist) -> Result<Self, RosError> {
        Ok(Self {
            vx: SpeedMps::new(linear.x as f32)?,
            vy: SpeedMps::new(linear.y as f32)?,
            wz: TurnRateRadps::new(angular.z as f32)?,
        })
    }
}

impl TryFrom<ros::Odometry> for Twist {
    type Error = RosError;

    fn try_from(odometry: ros::Odometry) -> Result<Self, RosError> {
        odometry.twist.twist.try_into()
    }
}

fn header(at_ns: u64, frame: &str) -> Header {
    Header { stamp: Time::from_nanoseconds(at_ns), frame_id: frame.into() }
}

fn vector(x: f32, y: f32, z: f32) -> Vector3 {
    Vector3 { x: x.into(), y: y.into(), z: z.into() }
}

fn twist(twist: &Twist) -> ros::Twist {
    ros::Twist {
        linear: vector(twist.vx.get(), twist.vy.get(), 0.0),
        angular: vector(0.0, 0.0, twist.wz.get()),
    }
}

/// Rows and columns: x, y, z, and turns about them. What does not move is known to stand still.
fn covariance(plane: [[f32; 3]; 3]) -> ros::Covariance {
    const AXES: [usize; 3] = [0, 1, 5];
    let mut whole = ros::Covariance::default();
    for (row, values) in AXES.into_iter().zip(plane) {
        for (column, value) in AXES.into_iter().zip(values) {
            whole[row][column] = value.into();
        }
    }
    whole
}

fn odometry(at_ns: u64, odometry: &Odometry) -> ros::Odometry {
    let Odometry { pose, pose_covariance: p, measured, measured_variance: v, .. } = odometry;
    let (sin, cos) = (f64::from(pose.yaw.get()) / 2.0).sin_cos();
    let (xy, xyaw, yyaw) = (p.xy.get(), p.xyaw.get(), p.yyaw.get());
    ros::Odometry {
        header: header(at_ns, "odom"),
        child_frame_id: "base_link".into(),
        pose: ros::PoseWithCovariance {
            pose: ros::Pose {
                position: vector(pose.x.get(), pose.y.get(), 0.0),
                orientation: ros::Quaternion { x: 0.0, y: 0.0, z: sin, w: cos },
            },
            covariance: covariance([
                [p.xx.get(), xy, xyaw],
                [xy, p.yy.get(), yyaw],
                [xyaw, yyaw, p.yawyaw.get()],
            ]),
        },
        twist: ros::TwistWithCovariance {
            twist: twist(measured),
            covariance: covariance([[v.vx.get(), 0.0, 0.0], [0.0, v.vy.get(), 0.0], [0.0, 0.0, v.wz.get()]]),
        },
    }
}

fn transform(odometry: &ros::Odometry) -> ros::TfMessage {
    let ros::Pose { position, orientation } = odometry.pose.pose.clone();
    ros::TfMessage {
        transforms: vec![ros::TransformStamped {
            header: odometry.header.clone(),
            child_frame_id: odometry.child_frame_id.clone(),
            transform: ros::Transform { translation: position, rotation: orientation },
        }],
    }
}

fn diagnostics(at_ns: u64, state: &ChassisState) -> ros::DiagnosticArray {
    let value = |key: &str, value: String| ros::KeyValue { key: key.into(), value };
    let mut values = vec![value("damaged frames", state.discarded.to_string())];
    values.extend(state.faults.iter().map(|&fault| value("fault", words::fault(fault))));
    if let Some(battery) = state.battery {
        values.push(value("battery voltage (V)", battery.voltage.get().to_string()));
        values.push(value("battery current (A)", battery.current.get().to_string()));
        values.push(value("battery energy (J)", battery.energy.get().to_string()));
    }
    ros::DiagnosticArray {
        header: header(at_ns, ""),
        status: vec![ros::DiagnosticStatus {
            level: state.faults.iter().map(level).max().unwrap_or(0),
            name: "chassis".into(),
            message: words::standing(state),
            hardware_id: String::new(),
            values,
        }],
    }
}

/// What stops the chassis is an error (2), what does not a warning (1).
fn level(fault: &ChassisFault) -> u8 {
    match fault {
        ChassisFault::Driver { .. } | ChassisFault::EncoderStuck { .. } | ChassisFault::Stalled { .. } => 2,
        ChassisFault::Slipping | ChassisFault::GyroSilent | ChassisFault::BatterySilent => 1,
    }
}
