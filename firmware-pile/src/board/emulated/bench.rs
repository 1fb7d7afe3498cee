//! The test bench on USART6. Besides the words of [every test bench](firmware_common::emulated::bench):
//!
//! | line | what happens |
//! |---|---|
//! | `robot 0` or `1` | nothing touches the contacts, or a robot with a half full battery does |
//! | `reversed 0` or `1` | that battery's poles are right, or the wrong way round |
//! | `mains 0` or `1` | there are no mains, or there are |
//! | `stop 0` or `1` | the emergency stop is released, or pressed |
//! | `welded 0` or `1` | the contactor can open, or not |
//! | `jammed 0` or `1` | the contactor can close, or not |
//! | `runaway 0` or `A` | the power stage follows its limit, or gives A amperes |
//! | `leak A` | A amperes flow past the open contactor |
//! | `voltage`, `current` or `temperature` `truth` | the sensor says what it measures |
//! | `voltage`, `current` or `temperature` `about X` | it says X, with noise; X may be `nan` or `inf` |
//! | `voltage`, `current` or `temperature` `exactly X` | it says X again and again |
//! | `power` | `power CLOSED LIMIT FOUND VOLTAGE CURRENT TEMPERATURE`: the contactor's command (0 or 1) and the limit in amperes; then what is true: contactor, volts, amperes, degrees Celsius |
//! | `reaction` | `reaction TICKS INSTRUCTIONS CURRENT`: how many samples after the first that shows the last order the contactor was told to open, how many instructions after that sample, and the true current then; `reaction none` if it was not |
//!
//! Orders are answered `ok` once they hold.

use core::cell::Cell;

use cortex_m::peripheral::SYST;
use embassy_sync::blocking_mutex::{Mutex, raw::CriticalSectionRawMutex};
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embedded_io_async::{Read, Write};
use firmware_common::emulated::bench::{self, Line, text};
use firmware_common::emulated::{cost, elapsed_cycles};
use firmware_common::supervisor::Place;

use crate::Power;
use crate::plant::{Battery, Plant, Says};

/// Of the robot that stands on the contacts.
pub(super) const BATTERY: Battery = Battery::new(1.0e6, 0.5e6);

/// Something of the plant that shall be otherwise.
enum Order {
    Robot(bool),
    Reversed(bool),
    Mains(bool),
    Stop(bool),
    Welded(bool),
    Jammed(bool),
    Runaway(Option<f32>),
    Leak(f32),
    Voltage(Says),
    Current(Says),
    Temperature(Says),
}

/// What the contactor's opening took since the last order.
#[derive(Clone, Copy)]
struct Reaction {
    ticks: u32,
    instructions: u32,
    current_a: f32,
}

/// The plant at the last tick: the numbers that `power` gives.
#[derive(Clone, Copy)]
struct Seen {
    power: Power,
    closed: bool,
    voltage_v: f32,
    current_a: f32,
    contact_c: f32,
}

type Shared<T> = Mutex<CriticalSectionRawMutex, Cell<T>>;

static ORDERS: Channel<CriticalSectionRawMutex, Order, 1> = Channel::new();
static OBEYED: Signal<CriticalSectionRawMutex, ()> = Signal::new();
static SEEN: Shared<Seen> = Mutex::new(Cell::new(Seen {
    power: Power::OFF,
    closed: false,
    voltage_v: 0.0,
    current_a: 0.0,
    contact_c: 0.0,
}));
static REACTION: Shared<Option<Reaction>> = Mutex::new(Cell::new(None));

/// Watches the ticks for the bench.
pub(super) struct Ticks {
    /// When the tick began that is not over.
    started: Option<u32>,
    /// Samples since the last order, if the contactor was closed then and is still.
    since_order: Option<u32>,
}

impl Ticks {
    pub const fn new() -> Self {
        Self { started: None, since_order: None }
    }

    /// A tick begins: does what was ordered.
    pub fn begin(&mut self, plant: &mut Plant) {
        self.since_order = self.since_order.map(|ticks| ticks + 1);
        if let Ok(order) = ORDERS.try_receive() {
            obey(order, plant);
            REACTION.lock(|place| place.set(None));
            self.since_order = plant.power().is_closed().then_some(0);
            OBEYED.signal(());
        }
    }

    /// The sensors have said what they say.
    pub fn sensed(&mut self) {
        self.started = Some(SYST::get_current());
    }

    /// The core commands `power`, in this tick or between two.
    pub fn command(&mut self, plant: &Plant, power: Power) {
        let cycles = self.started.take().map(elapsed_cycles);
        if let Some(cycles) = cycles {
            cost::record(cycles);
        }
        if !power.is_closed()
            && let Some(ticks) = self.since_order.take()
        {
            let instructions = cost::instructions(cycles.unwrap_or(0));
            let reaction = Reaction { ticks, instructions, current_a: plant.current_a() };
            REACTION.lock(|place| place.set(Some(reaction)));
        }
        let seen = Seen {
            power,
            closed: plant.supply_w().is_some(),
            voltage_v: plant.voltage_v(),
            current_a: plant.current_a(),
            contact_c: plant.contact_c(),
        };
        SEEN.lock(|place| place.set(seen));
    }
}

/// Serves the test bench on `port`.
pub async fn serve(port: impl Read + Write, place: Place) -> ! {
    bench::serve(port, place, answer).await
}

async fn answer(line: &str) -> Option<Line> {
    match line {
        "power" => {
            let Seen { power, closed, voltage_v, current_a, contact_c } = SEEN.lock(Cell::get);
            let (told, limit_a) = (u8::from(power.is_closed()), power.current_limit_a);
            let found = u8::from(closed);
            let numbers = format_args!("{voltage_v:.3} {current_a:.3} {contact_c:.3}");
            return Some(text(format_args!("power {told} {limit_a:.3} {found} {numbers}")));
        }
        "reaction" => {
            return Some(match REACTION.lock(Cell::get) {
                Some(Reaction { ticks, instructions, current_a }) => {
                    text(format_args!("reaction {ticks} {instructions} {current_a:.3}"))
                }
                None => text(format_args!("reaction none")),
            });
        }
        _ => {}
    }
    let order = order(line)?;
    OBEYED.reset();
    ORDERS.send(order).await;
    OBEYED.wait().await;
    Some(text(format_args!("ok")))
}

fn order(line: &str) -> Option<Order> {
    let mut words = line.split_whitespace();
    let (name, value) = (words.next()?, words.next()?);
    let flag = || match value {
        "0" => Some(false),
        "1" => Some(true),
        _ => None,
    };
    let mut says = || {
        let mut number = || words.next()?.parse().ok();
        match value {
            "truth" => Some(Says::Truth),
            "about" => Some(Says::About(number()?)),
            "exactly" => Some(Says::Exactly(number()?)),
            _ => None,
        }
    };
    Some(match name {
        "robot" => Order::Robot(flag()?),
        "reversed" => Order::Reversed(flag()?),
        "mains" => Order::Mains(flag()?),
        "stop" => Order::Stop(flag()?),
        "welded" => Order::Welded(flag()?),
        "jammed" => Order::Jammed(flag()?),
        "runaway" => Order::Runaway(value.parse().ok().filter(|&current_a| current_a != 0.0)),
        "leak" => Order::Leak(value.parse().ok()?),
        "voltage" => Order::Voltage(says()?),
        "current" => Order::Current(says()?),
        "temperature" => Order::Temperature(says()?),
        _ => return None,
    })
}

fn obey(order: Order, plant: &mut Plant) {
    match order {
        Order::Robot(touches) => plant.battery = touches.then_some(BATTERY),
        Order::Reversed(reversed) => {
            if let Some(battery) = &mut plant.battery {
                battery.reversed = reversed;
            }
        }
        Order::Mains(mains) => plant.mains = mains,
        Order::Stop(pressed) => plant.emergency_stop = pressed,
        Order::Welded(welded) => plant.welded = welded,
        Order::Jammed(jammed) => plant.jammed = jammed,
        Order::Runaway(current_a) => plant.runaway_a = current_a,
        Order::Leak(current_a) => plant.leak_a = current_a,
        Order::Voltage(says) => plant.voltage = says,
        Order::Current(says) => plant.current = says,
        Order::Temperature(says) => plant.temperature = says,
    }
}
