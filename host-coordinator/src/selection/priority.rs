//! Who comes first: the priority score (Access eqs. 4, 5) and the ageing of those who wait.
//!
//! The paper's score alone lets a robot with an unimportant task wait for ever. Here a robot's
//! [`urgency`] also grows with the time for which it has waited, by 1 every [`AGEING_S`]. As the score's
//! part is from 0 to [`CRITICAL`], nobody who asked `CRITICAL * AGEING_S` later can be more urgent:
//! that bounds how many robots can overtake one that waits.
//!
//! The total order is: more urgent first, then who asked first, then the lower number.

use std::cmp::Ordering;

use protocol::TaskPriority;

use super::situation::Asker;

/// A robot whose battery holds no more than this share of its full charge is critical (P_TH, eq. 5).
pub const CRITICAL_SHARE: f64 = 0.1;
/// The part of a critical robot's urgency that is not its waiting (eq. 5's infinity, made finite so that
/// also critical robots can't starve others). All others have less than 1.
pub const CRITICAL: f64 = 2.0;
/// Waiting this long is worth 1, in seconds.
pub const AGEING_S: f64 = 300.0;

/// The score S of a robot that has `share` of its full charge, 0 to 1, and whose next task has this
/// priority (Access eqs. 4, 5): none if the robot is critical.
///
/// The two weights of eq. 4 only scale it, which no comparison sees: they are 1.
#[must_use]
pub fn score(share: f64, task_priority: TaskPriority) -> Option<f64> {
    let priority = f64::from(task_priority.get());
    // A share that is no number is not above the threshold either.
    (share > CRITICAL_SHARE).then(|| priority / share.min(1.0))
}

/// How urgent a robot's need is after `waited_s` seconds: its score, mapped to 0 to 1, or
/// [`CRITICAL`]; and its age.
#[must_use]
pub fn urgency(share: f64, task_priority: TaskPriority, waited_s: f64) -> f64 {
    let highest = f64::from(TaskPriority::MAX.get()) / CRITICAL_SHARE;
    let need = score(share, task_priority).map_or(CRITICAL, |score| score / highest);
    need + waited_s.max(0.0) / AGEING_S
}

/// The order in which robots come.
#[must_use]
pub fn order(one: &Asker, other: &Asker) -> Ordering {
    let asked = |asker: &Asker| (asker.asked_at, asker.robot);
    other.urgency.total_cmp(&one.urgency).then_with(|| asked(one).cmp(&asked(other)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_low_battery_and_an_important_task_come_first() {
        let score = |share, priority| score(share, TaskPriority::new(priority).unwrap()).unwrap();
        assert_eq!(score(0.5, 10), 20.0);
        assert!(score(0.2, 8) > score(0.4, 8));
        assert!(score(0.4, 8) > score(0.4, 3));
        assert!(score(0.2, 3) < score(0.5, 10), "eq. 4 weighs both");
    }

    #[test]
    fn a_critical_robot_is_more_urgent_than_any_other_that_asked_when_it_did() {
        for share in [0.0, 0.05, CRITICAL_SHARE, -1.0, f64::NAN] {
            assert_eq!(score(share, TaskPriority::USUAL), None, "{share}");
            assert!(urgency(share, TaskPriority::MIN, 60.0) > urgency(0.101, TaskPriority::MAX, 60.0));
        }
    }

    proptest! {
        #[test]
        fn nobody_who_asked_so_much_later_overtakes(
            share in 0.0..1.0, other in 0.0..1.0, priority in 0u8..=10, others in 0u8..=10, waited_s in 0.0..1e6,
        ) {
            let [priority, others] = [priority, others].map(|value| TaskPriority::new(value).unwrap());
            let later_s = waited_s + CRITICAL * AGEING_S + 0.001;
            prop_assert!(urgency(share, priority, later_s) > urgency(other, others, waited_s));
        }

        #[test]
        fn urgency_is_a_number_whatever_the_battery_says(share: f64, priority in 0u8..=10, waited_s in 0.0..1e9) {
            let priority = TaskPriority::new(priority).unwrap();
            let urgency = urgency(share, priority, waited_s);
            prop_assert!(urgency.is_finite() && urgency >= 0.0);
        }
    }
}
