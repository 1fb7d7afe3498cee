//! What a chassis says at a tick; when, its [`Voice`](crate::voice::Voice) knows.

use protocol::{ChassisState, Message, Odometry};

use super::{Chassis, Messages, say};
use crate::report;

impl Chassis {
    /// Messages that are due.
    pub(super) fn speak(&mut self, messages: &mut Messages) {
        if self.voice.hello_is_due(self.now) {
            say(messages, Message::Hello(self.voice.hello(self.now)));
        }
        let state = self.state();
        if let Some(state) = self.voice.tell(self.now, state) {
            say(messages, Message::ChassisState(state));
        }
        messages.extend(self.passing.time_request(self.now).map(Message::TimeRequest));
        messages.extend(self.passing.due(self.now).map(Message::PassReport));
        say(messages, Message::Odometry(self.odometry()));
    }

    fn state(&self) -> ChassisState {
        ChassisState {
            mode: self.motion.mode(),
            stop: self.motion.stop(),
            faults: self.monitor.faults(self.gyro.is_silent(), self.battery.is_silent()),
            battery: self.battery.state(),
            discarded: self.discarded,
        }
    }

    fn odometry(&self) -> Odometry {
        let speed_variance = report::speed_variance(self.parameters.geometry.metres_per_count());
        let variance = self.odometer.velocity_variance(&self.kinematics, speed_variance, self.gyro_heard);
        Odometry {
            stamp: self.now,
            pose: report::pose(self.odometer.pose()),
            pose_covariance: report::pose_covariance(self.odometer.covariance()),
            measured: report::twist(&self.velocity),
            measured_variance: report::twist_variance(&variance),
            ramped: report::twist(&self.kinematics.twist(self.ramp.setpoints())),
            commanded: report::twist(&self.kinematics.twist(&self.motion.target())),
        }
    }
}
