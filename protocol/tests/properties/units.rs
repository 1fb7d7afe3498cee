//! Quantities and times keep their range, whatever they are made from.

use proptest::prelude::*;
use protocol::{CoordinateM, DurationMs, EnergyJ, Fraction, Millis, SiteMillis, TagId};

proptest! {
    #[test]
    fn a_quantity_is_built_from_every_number_in_its_range_and_from_no_other(value in prop::num::f32::ANY) {
        prop_assert_eq!(EnergyJ::new(value).is_ok(), (0.0..=1.0e9).contains(&value));
        prop_assert_eq!(Fraction::new(value).is_ok(), (0.0..=1.0).contains(&value));
        prop_assert_eq!(CoordinateM::new(value).is_ok(), (-1.0e5..=1.0e5).contains(&value));
    }

    #[test]
    fn clamping_gives_a_value_in_range_and_leaves_those_in_range_alone(value in prop::num::f32::ANY) {
        let clamped = EnergyJ::clamped(value);
        prop_assert_eq!(EnergyJ::new(clamped.get()), Ok(clamped));
        prop_assert_eq!(EnergyJ::new(value).unwrap_or(clamped), clamped);
        let clamped = CoordinateM::clamped(value);
        prop_assert_eq!(CoordinateM::new(clamped.get()), Ok(clamped));
    }

    #[test]
    fn a_duration_of_any_seconds_is_in_range(seconds in prop::num::f32::ANY, millis: u64) {
        prop_assert!(DurationMs::from_seconds(seconds) <= DurationMs::MAX);
        prop_assert_eq!(u64::from(DurationMs::saturating(millis).0), millis.min(DurationMs::MAX.0.into()));
    }

    #[test]
    fn what_lies_a_duration_later_is_that_duration_later(
        start in 0..=Millis::MAX.0, duration in 0..=DurationMs::MAX.0,
    ) {
        let duration = DurationMs(duration);
        prop_assert_eq!(Millis(start).after(duration).since(Millis(start)), duration);
        prop_assert_eq!(Millis(start).since(Millis(start).after(duration)), DurationMs(0));
        prop_assert_eq!(SiteMillis(start).after(duration).since(SiteMillis(start)), duration);
        prop_assert_eq!(SiteMillis(start).since(SiteMillis(start).after(duration)), DurationMs(0));
    }

    #[test]
    fn a_tag_is_read_from_its_text(tag: [u8; 12]) {
        let text = TagId(tag).to_string();
        prop_assert_eq!(text.parse(), Ok(TagId(tag)));
        prop_assert_eq!(text.to_lowercase().parse(), Ok(TagId(tag)));
    }

    #[test]
    fn no_other_text_is_a_tag(text in "\\PC{0,26}|[0-9A-F]{0,23}|[0-9A-F]{25,30}|[0-9A-F]{23}[G-Z]") {
        prop_assume!(text.len() != 24 || !text.bytes().all(|byte| byte.is_ascii_hexdigit()));
        prop_assert!(text.parse::<TagId>().is_err());
    }
}
