//! The ROS 2 messages of a recording: their names, definitions and bytes (CDR), as `ros2 bag`,
//! Foxglove and other readers of ROS recordings expect them.

use byteorder::LittleEndian;
use protocol::OutOfRange;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// The bytes in front of a message: CDR, little-endian.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Every message that is used, after those it is made of.
const DEFINITIONS: [(&str, &str); 16] = [
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    ("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"),
    ("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist\n",
    ),
    ("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"),
    (
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
    ),
    ("tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"),
    ("diagnostic_msgs/KeyValue", "string key\nstring value\n"),
    (
        "diagnostic_msgs/DiagnosticStatus",
        "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\n\
         string hardware_id\ndiagnostic_msgs/KeyValue[] values\n",
    ),
    (
        "diagnostic_msgs/DiagnosticArray",
        "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n",
    ),
];

/// The definition of a message, as a `ros2msg` schema: its own fields, then the messages in them.
/// Empty for one that is not used here.
pub(super) fn definition(package: &str, name: &str) -> String {
    let find = |wanted: &str| DEFINITIONS.iter().find(|(name, _)| *name == wanted);
    let mut open: Vec<_> = find(&format!("{package}/{name}")).into_iter().collect();
    let mut text = String::new();
    let mut next = 0;
    while let Some(&&(name, fields)) = open.get(next) {
        if next > 0 {
            text += &format!("{}\nMSG: {name}\n", "=".repeat(80));
        }
        text += fields;
        for part in fields.lines().filter_map(|field| find(field.split([' ', '[']).next()?)) {
            if !open.contains(&part) {
                open.push(part);
            }
        }
        next += 1;
    }
    text
}

/// A message cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RosError {
    /// Its first bytes are not those of CDR.
    #[error("its encoding is not the one of ROS 2")]
    Encoding,
    /// Its bytes are too few or do not fit its fields.
    #[error(transparent)]
    Bytes(#[from] cdr_encoding::Error),
    /// A number in it is beyond what a chassis does.
    #[error(transparent)]
    Quantity(#[from] OutOfRange),
}

/// The bytes of a message.
pub(super) fn to_bytes(message: &impl Serialize) -> Result<Vec<u8>, RosError> {
    let mut bytes = ENCAPSULATION.to_vec();
    bytes.extend(cdr_encoding::to_vec::<_, LittleEndian>(message)?);
    Ok(bytes)
}

/// The message of these bytes.
pub(super) fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, RosError> {
    let body = bytes.strip_prefix(&ENCAPSULATION).ok_or(RosError::Encoding)?;
    Ok(cdr_encoding::from_bytes::<T, LittleEndian>(body)?.0)
}

/// A 6 x 6 matrix over x, y, z and the turns about them, by rows.
pub(super) type Covariance = [[f64; 6]; 6];

macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty,)* })*) => {
        $($(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub(super) struct $name { $(pub $field: $kind,)* })*
    };
}

messages! {
    /// Since 1970 UTC.
    Time { sec: i32, nanosec: u32, }
    Header { stamp: Time, frame_id: String, }
    /// Also a `geometry_msgs/Point`.
    Vector3 { x: f64, y: f64, z: f64, }
    Quaternion { x: f64, y: f64, z: f64, w: f64, }
    Twist { linear: Vector3, angular: Vector3, }
    TwistWithCovariance { twist: Twist, covariance: Covariance, }
    Pose { position: Vector3, orientation: Quaternion, }
    PoseWithCovariance { pose: Pose, covariance: Covariance, }
    Odometry {
        header: Header,
        child_frame_id: String,
        pose: PoseWithCovariance,
        twist: TwistWithCovariance,
    }
    Transform { translation: Vector3, rotation: Quaternion, }
    TransformStamped { header: Header, child_frame_id: String, transform: Transform, }
    TfMessage { transforms: Vec<TransformStamped>, }
    KeyValue { key: String, value: String, }
    DiagnosticStatus {
        level: u8,
        name: String,
        message: String,
        hardware_id: String,
        values: Vec<KeyValue>,
    }
    DiagnosticArray { header: Header, status: Vec<DiagnosticStatus>, }
}

impl Time {
    /// So many nanoseconds after 1970 UTC.
    pub(super) fn from_nanoseconds(nanoseconds: u64) -> Self {
        const SECOND: u64 = 1_000_000_000;
        Self {
            sec: i32::try_from(nanoseconds / SECOND).unwrap_or(i32::MAX),
            nanosec: (nanoseconds % SECOND) as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_holds_each_message_in_it_once() {
        let odometry = definition("nav_msgs", "Odometry");
        let parts: Vec<_> = odometry.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
        assert_eq!(
            parts,
            [
                "std_msgs/Header",
                "geometry_msgs/PoseWithCovariance",
                "geometry_msgs/TwistWithCovariance",
                "builtin_interfaces/Time",
                "geometry_msgs/Pose",
                "geometry_msgs/Twist",
                "geometry_msgs/Point",
                "geometry_msgs/Quaternion",
                "geometry_msgs/Vector3",
            ]
        );
        assert!(odometry.starts_with("std_msgs/Header header\nstring child_frame_id\n"));
    }

    #[test]
    fn every_field_is_a_number_a_text_or_a_message_that_is_defined() {
        for (name, fields) in DEFINITIONS {
            for field in fields.lines() {
                let kind = field.split([' ', '[']).next().unwrap();
                let plain = ["byte", "float64", "int32", "uint32", "string"].contains(&kind);
                assert!(plain || DEFINITIONS.iter().any(|(known, _)| *known == kind), "{name}: {field}");
            }
        }
    }

    #[test]
    fn numbers_stand_at_multiples_of_their_size_behind_texts_that_end_in_zero() {
        let zero = || Vector3 { x: 0.0, y: 0.0, z: 0.0 };
        let twist = Twist { linear: zero(), angular: zero() };
        let odometry = Odometry {
            header: Header { stamp: Time::from_nanoseconds(1_500_000_007), frame_id: "odom".into() },
            child_frame_id: "base_link".into(),
            pose: PoseWithCovariance {
                pose: Pose {
                    position: Vector3 { x: 1.5, ..zero() },
                    orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 },
                },
                covariance: Covariance::default(),
            },
            twist: TwistWithCovariance { twist, covariance: Covariance::default() },
        };
        let bytes = to_bytes(&odometry).unwrap();
        let head = b"\0\x01\0\0\x01\0\0\0\x07\x65\xcd\x1d\x05\0\0\0odom\0\0\0\0\x0a\0\0\0base_link\0";
        assert_eq!(&bytes[..head.len()], head);
        // Offsets count behind the first four bytes: the text ends at 38, the next multiple of 8 is 40.
        assert_eq!(bytes[44..52], 1.5_f64.to_le_bytes());
        // Two covariances, a pose of seven numbers and a twist of six.
        assert_eq!(bytes.len(), 44 + 8 * (36 + 36 + 7 + 6));
        assert_eq!(from_bytes::<Odometry>(&bytes).unwrap(), odometry);
        for end in 0..bytes.len() {
            assert!(from_bytes::<Odometry>(&bytes[..end]).is_err());
        }
    }
}
