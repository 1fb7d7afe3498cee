//! A simulated robot: its computer between its own socket and the world's floor.

use std::{io, net::SocketAddr};

use protocol::{DeviceId, FrameError, Message, Millis, Recipient, RobotId, TimeRequest};

use super::{
    link::Link,
    robot::Robot,
    world::{Body, Sensed},
};
use crate::keys::Keys;

/// A robot on the wire.
#[derive(Debug)]
pub struct RobotNode {
    core: Robot,
    link: Link,
    coordinator: SocketAddr,
    piles: Vec<SocketAddr>,
    /// What has come since the last step.
    heard: Vec<Message>,
}

impl RobotNode {
    /// A robot that speaks to `coordinator`, and to `piles` when it hears none, which believes it and which it believes by `keys`.
    ///
    /// # Errors
    /// Its socket cannot be opened.
    pub async fn start(
        robot: RobotId,
        core: Robot,
        coordinator: SocketAddr,
        piles: Vec<SocketAddr>,
        keys: &Keys,
    ) -> io::Result<Self> {
        let device = DeviceId::Robot(robot);
        let link = Link::bind(device, keys.trust_of(device)).await?;
        Ok(Self { core, link, coordinator, piles, heard: Vec::new() })
    }

    /// Where piles reach it.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.link.address()
    }

    /// The robot's computer.
    #[must_use]
    pub const fn core(&self) -> &Robot {
        &self.core
    }

    /// Reads the sensors and the socket, and commands the drive of `body`.
    pub fn step(&mut self, now: Millis, sensed: &Sensed, body: &mut Body) {
        self.listen();
        let outputs = self.core.step(now, sensed, &std::mem::take(&mut self.heard));
        body.moving = outputs.moving;
        if let Some(route) = outputs.route {
            body.route = route;
        }
        for message in outputs.messages {
            self.say(&message);
        }
        if let Some(claim) = outputs.claim {
            let piles = self.piles.iter().copied();
            self.link.send(Recipient::Piles, &Message::ClaimPile(claim), piles);
        }
    }

    /// Asks the coordinator for the time.
    pub fn ask_time(&mut self, now: Millis) {
        self.say(&Message::TimeRequest(TimeRequest { asked_at: now }));
    }

    fn say(&mut self, message: &Message) {
        self.link.send(Recipient::Device(DeviceId::Coordinator), message, [self.coordinator]);
    }

    /// Reads the socket without letting time pass. Answers the newest question for the time that
    /// was answered.
    pub fn listen(&mut self) -> Option<Millis> {
        for found in self.link.received() {
            match found {
                Ok(frame) => self.heard.push(frame.message),
                Err(FrameError::Unauthentic { .. }) => self.core.distrusted(),
                Err(_) => {}
            }
        }
        let answered = self.heard.iter().filter_map(|message| match message {
            Message::TimeSync(sync) => Some(sync.asked_at),
            _ => None,
        });
        answered.max()
    }
}
