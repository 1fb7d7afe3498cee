//! The test bench on USART6. Besides the words of [every test bench](firmware_common::emulated::bench):
//!
//! | line | what happens |
//! |---|---|
//! | `encoder W 0` or `1` | the encoder of wheel W (0 to 3) counts, or is stuck |
//! | `driver W 0` or `1` | the driver of wheel W is well, or reports a fault |
//! | `wheel W 0` or `1` | wheel W is free, or cannot turn |
//! | `grip W SHARE` | so much of the wheel's speed reaches the floor |
//! | `gyro 0` or `1` | the gyroscope is silent, or answers |
//! | `meter 0` or `1` | the battery's meter is silent, or answers |
//! | `truth` | `truth X Y YAW VX VY WZ`: where the robot really is, and how it really moves |
//!
//! All but the last are answered `ok`.

use core::cell::Cell;

use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use embedded_io_async::{Read, Write};
use firmware_common::emulated::bench::{self, Line, text};
use firmware_common::supervisor::Place;

use super::ORDERS;
use crate::plant::Plant;

/// Of the modelled gyroscope when it answers, in rad/s.
const GYRO_BIAS_RADPS: f32 = 0.02;

/// Something of the plant that shall be otherwise.
pub(super) enum Order {
    Encoder { wheel: usize, stuck: bool },
    Driver { wheel: usize, fault: bool },
    Wheel { wheel: usize, blocked: bool },
    Grip { wheel: usize, share: f32 },
    Gyro { answers: bool },
    Meter { answers: bool },
}

/// The plant's pose and velocity at the last tick.
static TRUTH: Mutex<CriticalSectionRawMutex, Cell<[f32; 6]>> = Mutex::new(Cell::new([0.0; 6]));

/// Does what was ordered.
pub(super) fn obey(order: Order, plant: &mut Plant) {
    fn set<T>(places: &mut [T; 4], wheel: usize, value: T) {
        if let Some(place) = places.get_mut(wheel) {
            *place = value;
        }
    }
    match order {
        Order::Encoder { wheel, stuck } => set(&mut plant.encoder_stuck, wheel, stuck),
        Order::Driver { wheel, fault } => set(&mut plant.driver_faults, wheel, fault),
        Order::Wheel { wheel, blocked } => set(&mut plant.blocked, wheel, blocked),
        Order::Grip { wheel, share } => set(&mut plant.grip, wheel, share),
        Order::Gyro { answers } => plant.gyro_bias_radps = answers.then_some(GYRO_BIAS_RADPS),
        Order::Meter { answers } => plant.meter_answers = answers,
    }
}

/// Tells the test bench where the robot really is.
pub(super) fn publish(plant: &Plant) {
    let (pose, velocity) = (plant.pose(), plant.velocity());
    let truth = [pose.x, pose.y, pose.yaw, velocity.x, velocity.y, velocity.z];
    TRUTH.lock(|place| place.set(truth));
}

/// Serves the test bench on `port`.
pub async fn serve(port: impl Read + Write, place: Place) -> ! {
    bench::serve(port, place, answer).await
}

async fn answer(line: &str) -> Option<Line> {
    if line == "truth" {
        let [x, y, yaw, vx, vy, wz] = TRUTH.lock(Cell::get);
        return Some(text(format_args!("truth {x:.5} {y:.5} {yaw:.5} {vx:.5} {vy:.5} {wz:.5}")));
    }
    ORDERS.send(order(line.split_whitespace())?).await;
    Some(text(format_args!("ok")))
}

fn order<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<Order> {
    let word = words.next()?;
    let mut number = || words.next()?.parse::<f32>().ok();
    match word {
        "gyro" => return Some(Order::Gyro { answers: number()? != 0.0 }),
        "meter" => return Some(Order::Meter { answers: number()? != 0.0 }),
        _ => {}
    }
    let wheel = number()? as usize;
    let value = number()?;
    let broken = value != 0.0;
    Some(match word {
        "encoder" => Order::Encoder { wheel, stuck: broken },
        "driver" => Order::Driver { wheel, fault: broken },
        "wheel" => Order::Wheel { wheel, blocked: broken },
        "grip" => Order::Grip { wheel, share: value },
        _ => return None,
    })
}
