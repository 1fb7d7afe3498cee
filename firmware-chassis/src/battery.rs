//! What the battery holds (g_real), and what tasks take from it (Access eqs. 1, 2).
//!
//! The first sample says what it holds by its open-circuit voltage, taken as linear between empty
//! and full; from then on voltage times current is summed up. Energies are whole microjoules, so
//! that the 0.1 J of a tick is not lost beside the 200 kJ of a battery.

use heapless::LinearMap;
use protocol::{BatteryState, CurrentA, EnergyJ, TaskEnergy, TaskId, VoltageV};

use crate::parameters::Pack;

/// So many kinds of task are told apart.
pub const TASKS: usize = 16;
/// So many ticks without a sample are a fault: 1 s.
const SILENT_TICKS: u16 = 100;
const MICROJOULES: f32 = 1e6;

/// A battery that is measured.
#[derive(Clone, Debug)]
pub struct Battery {
    pack: Pack,
    state: Option<BatteryState>,
    held_uj: u64,
    drawn_uj: u64,
    unheard: u16,
}

impl Battery {
    /// A battery nothing is known of.
    #[must_use]
    pub const fn new(pack: Pack) -> Self {
        Self { pack, state: None, held_uj: 0, drawn_uj: 0, unheard: 0 }
    }

    /// Voltage, current and energy, once they were measured.
    #[must_use]
    pub const fn state(&self) -> Option<BatteryState> {
        self.state
    }

    /// Whether it has not been measured for 1 s.
    #[must_use]
    pub const fn is_silent(&self) -> bool {
        self.unheard >= SILENT_TICKS
    }

    /// All that was ever drawn, in microjoules; charging does not take from it.
    #[must_use]
    pub const fn drawn_uj(&self) -> u64 {
        self.drawn_uj
    }

    /// Takes a sample in V and A, which holds for the `elapsed_s` before it. What is no number, or
    /// no voltage or current at all, is no sample.
    pub fn update(&mut self, sample: Option<(f32, f32)>, elapsed_s: f32) {
        let quantities = sample
            .and_then(|(voltage, current)| VoltageV::new(voltage).ok().zip(CurrentA::new(current).ok()));
        let Some((voltage, current)) = quantities else {
            self.unheard = self.unheard.saturating_add(1);
            return;
        };
        self.unheard = 0;
        let full_uj = microjoules(self.pack.full_j);
        if self.state.is_none() {
            self.held_uj =
                microjoules(self.pack.full_j * self.charge_by_voltage(voltage.get(), current.get()));
        }
        let flow_uj = microjoules(voltage.get() * current.get().abs() * elapsed_s);
        if current.get() >= 0.0 {
            self.drawn_uj = self.drawn_uj.saturating_add(flow_uj);
            self.held_uj = self.held_uj.saturating_sub(flow_uj);
        } else {
            self.held_uj = self.held_uj.saturating_add(flow_uj).min(full_uj);
        }
        self.state = Some(BatteryState { voltage, current, energy: joules(self.held_uj) });
    }

    fn charge_by_voltage(&self, voltage: f32, current: f32) -> f32 {
        let open_circuit = voltage + current * self.pack.resistance_ohm;
        ((open_circuit - self.pack.empty_v) / (self.pack.full_v - self.pack.empty_v)).clamp(0.0, 1.0)
    }
}

/// What each kind of task takes in the mean of its runs.
///
/// Eq. 1 takes the difference of what the battery holds before and after, which is what was drawn
/// in between unless it was charged on the way; this sums up what was drawn.
#[derive(Clone, Debug, Default)]
pub struct Tasks {
    /// Runs and what they have drawn together, in microjoules.
    done: LinearMap<TaskId, (u32, u64), TASKS>,
    /// The present task, and what had been drawn when it began.
    present: Option<(TaskId, u64)>,
}

/// There is no room for another kind of task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooManyTasks;

impl Tasks {
    /// No task was done yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { done: LinearMap::new(), present: None }
    }

    /// Ends the present task, if there is one, and begins `next`, when `drawn_uj` was ever drawn.
    /// Answers what the ended one took.
    ///
    /// # Errors
    /// [`TooManyTasks`] if `next` is of a new kind and there is no room; the present one goes on.
    pub fn switch(
        &mut self,
        next: Option<TaskId>,
        drawn_uj: u64,
    ) -> Result<Option<TaskEnergy>, TooManyTasks> {
        if let Some(next) = next.filter(|next| !self.done.contains_key(next)) {
            self.done.insert(next, (0, 0)).map_err(|_| TooManyTasks)?;
        }
        let ended = self.present.take();
        self.present = next.map(|next| (next, drawn_uj));
        Ok(ended.and_then(|(task, began_uj)| self.end(task, drawn_uj.saturating_sub(began_uj))))
    }

    fn end(&mut self, task: TaskId, last_uj: u64) -> Option<TaskEnergy> {
        let (runs, total_uj) = self.done.get_mut(&task)?;
        *runs = runs.saturating_add(1);
        *total_uj = total_uj.saturating_add(last_uj);
        let mean_uj = *total_uj / u64::from(*runs);
        Some(TaskEnergy { task, runs: *runs, last: joules(last_uj), mean: joules(mean_uj) })
    }
}

/// Negative and NaN become zero.
fn microjoules(joules: f32) -> u64 {
    (joules * MICROJOULES) as u64
}

fn joules(microjoules: u64) -> EnergyJ {
    EnergyJ::clamped(microjoules as f32 / MICROJOULES)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use protocol::RobotId;

    use super::*;
    use crate::parameters::Parameters;

    const PACK: Pack = Parameters::new(RobotId(1)).pack;

    fn energy(battery: &Battery) -> f32 {
        battery.state().unwrap().energy.get()
    }

    #[test]
    fn the_first_voltage_says_what_it_holds_with_the_drop_of_its_current_taken_out() {
        for (voltage, current, share) in
            [(12.6, 0.0, 1.0), (11.1, 0.0, 0.5), (10.9, 2.0, 0.5), (5.0, 0.0, 0.0)]
        {
            let mut battery = Battery::new(PACK);
            battery.update(Some((voltage, current)), 0.0);
            assert!((energy(&battery) - share * PACK.full_j).abs() < 1.0, "{voltage}");
        }
    }

    #[test]
    fn an_hour_at_a_hundred_hertz_loses_none_of_its_small_draws() {
        let mut battery = Battery::new(PACK);
        battery.update(Some((12.6, 0.0)), 0.01);
        for _ in 0..360_000 {
            battery.update(Some((12.0, 1.0)), 0.01);
        }
        // 12 W for 3600 s.
        assert!((energy(&battery) - (PACK.full_j - 43_200.0)).abs() < 1.0, "{}", energy(&battery));
        assert!(battery.drawn_uj().abs_diff(43_200_000_000) < 1_000_000);
    }

    #[test]
    fn charging_fills_it_and_no_more_than_full() {
        let mut battery = Battery::new(PACK);
        battery.update(Some((11.1, 0.0)), 0.0);
        battery.update(Some((12.0, -10.0)), 100.0);
        assert!((energy(&battery) - (0.5 * PACK.full_j + 12_000.0)).abs() < 1.0);
        battery.update(Some((12.0, -100.0)), 1e6);
        assert!((energy(&battery) - PACK.full_j).abs() < 0.1);
        assert_eq!(battery.drawn_uj(), 0);
    }

    #[test]
    fn a_battery_is_silent_after_a_second_of_nonsense() {
        let mut battery = Battery::new(PACK);
        for _ in 1..SILENT_TICKS {
            battery.update(Some((f32::NAN, 1.0)), 0.01);
            assert!(!battery.is_silent());
        }
        battery.update(Some((12.0, f32::INFINITY)), 0.01);
        assert!(battery.is_silent());
        assert_eq!(battery.state(), None);
    }

    #[test]
    fn a_task_takes_what_was_drawn_and_in_the_mean_that_over_its_runs() {
        let mut tasks = Tasks::new();
        let patrol = TaskId(1);
        assert_eq!(tasks.switch(Some(patrol), 1_000_000), Ok(None));
        let first = tasks.switch(None, 4_000_000).unwrap().unwrap();
        assert_eq!((first.runs, first.last.get(), first.mean.get()), (1, 3.0, 3.0));
        assert_eq!(tasks.switch(None, 9_000_000), Ok(None));
        assert_eq!(tasks.switch(Some(patrol), 10_000_000), Ok(None));
        // The next task ends it as well.
        let second = tasks.switch(Some(TaskId(2)), 15_000_000).unwrap().unwrap();
        assert_eq!((second.task, second.runs, second.last.get(), second.mean.get()), (patrol, 2, 5.0, 4.0));
    }

    #[test]
    fn one_kind_of_task_too_many_is_refused_and_the_present_one_goes_on() {
        let mut tasks = Tasks::new();
        for kind in 0..TASKS as u16 {
            tasks.switch(Some(TaskId(kind)), 0).unwrap();
        }
        assert_eq!(tasks.switch(Some(TaskId(1_000)), 0), Err(TooManyTasks));
        let ended = tasks.switch(None, 7_000_000).unwrap().unwrap();
        assert_eq!((ended.task, ended.last.get()), (TaskId(TASKS as u16 - 1), 7.0));
    }

    proptest! {
        #[test]
        fn whatever_is_measured_the_battery_holds_from_nothing_to_full(
            samples in prop::collection::vec((prop::num::f32::ANY, prop::num::f32::ANY), 1..100),
        ) {
            let mut battery = Battery::new(PACK);
            for sample in samples {
                battery.update(Some(sample), 0.01);
                if let Some(state) = battery.state() {
                    prop_assert!((0.0..=PACK.full_j + 0.1).contains(&state.energy.get()));
                }
            }
        }
    }
}
