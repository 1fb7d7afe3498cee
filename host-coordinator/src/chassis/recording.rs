//! Recordings of a chassis as MCAP files, which Foxglove and the MCAP tools open.
//!
//! | channel | message, as JSON |
//! |---|---|
//! | `/cmd_vel` | `geometry_msgs/Twist`: the command in force |
//! | `/cmd_vel_ramped` | `geometry_msgs/Twist`: what the ramp makes of it |
//! | `/odom` | `nav_msgs/Odometry`: pose and measured twist |
//! | `/chassis/state` | [`ChassisState`] |
//!
//! A message's publish time follows the chassis' clock, which knows no jitter of the line; its log
//! time is that of its arrival. Both are nanoseconds since 1970 UTC.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufWriter, Seek, Write},
    path::Path,
};

use mcap::{McapError, MessageStream, WriteOptions, Writer, records::MessageHeader};
use protocol::{ChassisState, Odometry, SpeedMps, TurnRateRadps, Twist};
use serde::Deserialize;
use serde_json::{Value, json};

use super::session::Heard;

const COMMANDED: &str = "/cmd_vel";
const RAMPED: &str = "/cmd_vel_ramped";
const ODOMETRY: &str = "/odom";
const STATE: &str = "/chassis/state";

/// What is wrong with a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// It cannot be written.
    #[error("cannot write the recording: {0}")]
    Write(McapError),
    /// It cannot be read.
    #[error("no readable MCAP file ({0}); if its recording was cut off, `mcap recover` may save it")]
    Read(McapError),
    /// A message of ours that is none.
    #[error("{topic}: {error}; was this recorded by `chargehand chassis`?")]
    Message {
        /// Its channel.
        topic: &'static str,
        /// What is wrong with it.
        error: serde_json::Error,
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
    state: u16,
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
        let mut writer = WriteOptions::new().compression(None).library("chargehand").create(to)?;
        let mut channel = |topic: &str, name: &str, schema: Value| -> Result<u16, McapError> {
            let schema = writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?;
            writer.add_channel(schema, topic, "json", &BTreeMap::new())
        };
        Ok(Self {
            commanded: channel(COMMANDED, "geometry_msgs/Twist", twist_schema())?,
            ramped: channel(RAMPED, "geometry_msgs/Twist", twist_schema())?,
            odometry: channel(ODOMETRY, "nav_msgs/Odometry", odometry_schema())?,
            state: channel(STATE, "chargehand/ChassisState", state_schema())?,
            writer,
            sequence: 0,
            zero: None,
        })
    }

    /// Adds what was heard `now_ns` nanoseconds after 1970 UTC.
    ///
    /// # Errors
    /// [`RecordingError::Write`].
    pub fn record(&mut self, now_ns: u64, heard: &Heard) -> Result<(), RecordingError> {
        let written = match heard {
            Heard::State(state) => self.write(self.state, now_ns, now_ns, &state_json(state)),
            Heard::Odometry(odometry) => {
                let at = self.published(now_ns, odometry.stamp.0.saturating_mul(1_000_000));
                self.write(self.commanded, now_ns, at, &twist_json(&odometry.commanded))
                    .and_then(|()| self.write(self.ramped, now_ns, at, &twist_json(&odometry.ramped)))
                    .and_then(|()| self.write(self.odometry, now_ns, at, &odometry_json(odometry)))
            }
        };
        written.map_err(RecordingError::Write)
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
        data: &Value,
    ) -> Result<(), McapError> {
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time, publish_time };
        self.sequence = self.sequence.wrapping_add(1);
        self.writer.write_to_known_channel(&header, data.to_string().as_bytes())
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
        let mut found: [Vec<(u64, Twist)>; 3] = Default::default();
        let [commanded, ramped, measured] = &mut found;
        for message in MessageStream::new(bytes).map_err(RecordingError::Read)? {
            let message = message.map_err(RecordingError::Read)?;
            let (at, data) = (message.publish_time, message.data.as_ref());
            match message.channel.topic.as_str() {
                COMMANDED => commanded.push((at, read::<RosTwist>(COMMANDED, data)?.into())),
                RAMPED => ramped.push((at, read::<RosTwist>(RAMPED, data)?.into())),
                ODOMETRY => measured.push((at, read::<RosOdometry>(ODOMETRY, data)?.twist.twist.into())),
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

fn read<'a, T: Deserialize<'a>>(topic: &'static str, data: &'a [u8]) -> Result<T, RecordingError> {
    serde_json::from_slice(data).map_err(|error| RecordingError::Message { topic, error })
}

#[derive(Deserialize)]
struct RosTwist {
    linear: Linear,
    angular: Angular,
}

#[derive(Deserialize)]
struct Linear {
    x: SpeedMps,
    y: SpeedMps,
}

#[derive(Deserialize)]
struct Angular {
    z: TurnRateRadps,
}

#[derive(Deserialize)]
struct RosOdometry {
    twist: WithCovariance,
}

#[derive(Deserialize)]
struct WithCovariance {
    twist: RosTwist,
}

impl From<RosTwist> for Twist {
    fn from(ros: RosTwist) -> Self {
        Self { vx: ros.linear.x, vy: ros.linear.y, wz: ros.angular.z }
    }
}

fn twist_json(twist: &Twist) -> Value {
    json!({
        "linear": { "x": twist.vx, "y": twist.vy, "z": 0.0 },
        "angular": { "x": 0.0, "y": 0.0, "z": twist.wz },
    })
}

fn odometry_json(odometry: &Odometry) -> Value {
    let Odometry { stamp, pose, pose_covariance: p, measured, measured_variance: v, .. } = odometry;
    let (sin, cos) = (f64::from(pose.yaw.get()) / 2.0).sin_cos();
    // Rows and columns: x, y, z, and turns about them. What does not move is known to stand still.
    let covariance = |rows: [[f32; 3]; 3]| {
        let plane = |index: usize| [0, 1, 5].iter().position(|&axis| axis == index);
        let at = |cell: usize| match (plane(cell / 6), plane(cell % 6)) {
            (Some(row), Some(column)) => rows[row][column],
            _ => 0.0,
        };
        (0..36).map(at).collect::<Vec<_>>()
    };
    let (xy, xyaw, yyaw) = (p.xy.get(), p.xyaw.get(), p.yyaw.get());
    json!({
        "header": {
            "stamp": { "sec": stamp.0 / 1_000, "nsec": stamp.0 % 1_000 * 1_000_000 },
            "frame_id": "odom",
        },
        "child_frame_id": "base_link",
        "pose": {
            "pose": {
                "position": { "x": pose.x, "y": pose.y, "z": 0.0 },
                "orientation": { "x": 0.0, "y": 0.0, "z": sin, "w": cos },
            },
            "covariance": covariance([
                [p.xx.get(), xy, xyaw],
                [xy, p.yy.get(), yyaw],
                [xyaw, yyaw, p.yawyaw.get()],
            ]),
        },
        "twist": {
            "twist": twist_json(measured),
            "covariance": covariance([
                [v.vx.get(), 0.0, 0.0],
                [0.0, v.vy.get(), 0.0],
                [0.0, 0.0, v.wz.get()],
            ]),
        },
    })
}

fn state_json(state: &ChassisState) -> Value {
    let faults: Vec<_> = state.faults.iter().map(|&fault| super::words::fault(fault)).collect();
    json!({
        "mode": state.mode,
        "stop": state.stop,
        "faults": faults,
        "battery": state.battery,
        "discarded": state.discarded,
    })
}

fn object<const N: usize>(properties: [(&str, Value); N]) -> Value {
    json!({ "type": "object", "properties": properties.into_iter().collect::<BTreeMap<_, _>>() })
}

fn numbers<const N: usize>(names: [&str; N]) -> Value {
    object(names.map(|name| (name, json!({ "type": "number" }))))
}

fn twist_schema() -> Value {
    object([("linear", numbers(["x", "y", "z"])), ("angular", numbers(["x", "y", "z"]))])
}

fn odometry_schema() -> Value {
    let text = || json!({ "type": "string" });
    let covariance = || json!({ "type": "array", "items": { "type": "number" } });
    let whole = || json!({ "type": "integer" });
    let stamp = object([("sec", whole()), ("nsec", whole())]);
    let pose =
        object([("position", numbers(["x", "y", "z"])), ("orientation", numbers(["x", "y", "z", "w"]))]);
    object([
        ("header", object([("stamp", stamp), ("frame_id", text())])),
        ("child_frame_id", text()),
        ("pose", object([("pose", pose), ("covariance", covariance())])),
        ("twist", object([("twist", twist_schema()), ("covariance", covariance())])),
    ])
}

fn state_schema() -> Value {
    object([
        ("mode", json!({ "type": "string" })),
        ("stop", json!({ "type": ["string", "null"] })),
        ("faults", json!({ "type": "array", "items": { "type": "string" } })),
        ("battery", numbers(["voltage", "current", "energy"])),
        ("discarded", json!({ "type": "integer" })),
    ])
}
