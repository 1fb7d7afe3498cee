//! What the robot's computer tells its chassis, and how that is answered.

use protocol::{
    Ack, BootEpoch, ChassisRefusal, CommandId, DeviceId, Drive, Frame, Message, Nack, NackReason, Reference,
    StopReason, Task, TaskEnergy,
};

use super::{Chassis, Messages, say};
use crate::{commands::Answer, limits, motion::Motion};

/// Slower than this a wheel stands, in m/s.
const REST_MPS: f32 = 0.02;

impl Chassis {
    /// Only the robot's own computer is obeyed.
    pub(super) fn hear(&mut self, frame: &Frame, messages: &mut Messages) {
        if frame.header.sender != DeviceId::Robot(self.parameters.robot) {
            return;
        }
        self.discarded_before = self.discarded;
        let boot = frame.header.boot;
        match &frame.message {
            Message::Hello(_) => {
                let wanted = self.voice.greeted(self.now);
                messages.extend(wanted.then(|| Message::Hello(self.voice.hello(self.now))));
            }
            Message::Drive(drive) => {
                self.obey(boot, drive.command, messages, |chassis| (chassis.drive(drive), None));
            }
            Message::Stop(stop) if stop.emergency => {
                self.brake(StopReason::Emergency);
                // One that comes late is obeyed, but makes no late release new again.
                if self.commands.answered(boot, stop.command).is_none() {
                    self.commands.remember(boot, stop.command, Ok(()));
                }
                say(messages, answered(stop.command, Ok(())));
            }
            Message::Stop(stop) => self.obey(boot, stop.command, messages, |chassis| {
                chassis.motion.stop_for(StopReason::Commanded);
                (Ok(()), None)
            }),
            Message::Release(release) => {
                self.obey(boot, release.command, messages, |chassis| (chassis.release(), None));
            }
            Message::Task(task) => {
                self.obey(boot, task.command, messages, |chassis| chassis.switch_task(task));
            }
            Message::TimeSync(sync) => self.passing.synchronise(self.now, sync),
            Message::Ack(Ack { of: Reference::Report(report) }) => self.passing.acknowledged(*report),
            _ => {}
        }
    }

    /// Does a command if it is new, and answers it.
    fn obey(
        &mut self,
        boot: BootEpoch,
        command: CommandId,
        messages: &mut Messages,
        act: impl FnOnce(&mut Self) -> (Answer, Option<TaskEnergy>),
    ) {
        let answer = self.commands.answered(boot, command).unwrap_or_else(|| {
            let (answer, energy) = act(self);
            self.commands.remember(boot, command, answer);
            if let Some(energy) = energy {
                say(messages, Message::TaskEnergy(energy));
            }
            answer
        });
        say(messages, answered(command, answer));
    }

    fn drive(&mut self, drive: &Drive) -> Answer {
        let velocity = limits::check(&self.parameters.limits, drive).map_err(refused)?;
        if let Some(by) = self.motion.held() {
            return Err(refused(ChassisRefusal::Stopped { by }));
        }
        let target = limits::slow_down(&self.parameters.limits, self.kinematics.wheels(&velocity));
        self.motion = Motion::Driving { target, until: self.now.after(drive.ttl) };
        Ok(())
    }

    fn release(&mut self) -> Answer {
        if self.motion.held().is_none() {
            return Ok(());
        }
        if self.speeds().amax() > REST_MPS {
            return Err(refused(ChassisRefusal::Moving));
        }
        if !self.monitor.release() {
            return Err(refused(ChassisRefusal::NotCleared));
        }
        self.motion = Motion::Braked { reason: StopReason::Commanded };
        Ok(())
    }

    fn switch_task(&mut self, task: &Task) -> (Answer, Option<TaskEnergy>) {
        match self.tasks.switch(task.task, self.battery.drawn_uj()) {
            Ok(ended) => (Ok(()), ended),
            Err(_) => (Err(refused(ChassisRefusal::TooManyTasks)), None),
        }
    }
}

fn refused(refusal: ChassisRefusal) -> NackReason {
    NackReason::Chassis { refusal }
}

fn answered(command: CommandId, answer: Answer) -> Message {
    let of = Reference::Command(command);
    match answer {
        Ok(()) => Message::Ack(Ack { of }),
        Err(reason) => Message::Nack(Nack { of, reason }),
    }
}
