//! One number of a paper beside ours, and how they compare.

use std::fmt;

use serde::Serialize;

use super::Paper;

/// One number or choice of a paper beside ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Which paper.
    pub paper: &'static str,
    /// Which table, experiment or figure of it, such as `5`, `III` or `Experiment 1`; a test's results
    /// stand with the table of its inputs.
    pub table: &'static str,
    /// Which row of the table.
    pub row: String,
    /// Which column.
    pub column: String,
    /// What the paper prints.
    pub published: Value,
    /// What we get.
    pub ours: Value,
    /// How they compare.
    pub verdict: Verdict,
    /// What a reader should know about the difference; often nothing.
    pub note: String,
}

/// What stands in a field of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A number that we computed, or one that is not compared.
    Number(f64),
    /// A number as it is printed, with the precision it is printed to.
    Printed(Printed),
    /// Something else, such as a pile.
    Text(String),
    /// Nothing.
    Missing,
}

/// A number with the decimals it is printed to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(into = "f64")]
pub struct Printed {
    value: f64,
    decimals: usize,
}

impl From<Printed> for f64 {
    fn from(printed: Printed) -> Self {
        printed.value
    }
}

/// How our value compares with the published one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The same at the printed precision, but for the rounding error of a sum of doubles, which
    /// shows where 15 digits are printed.
    Exact,
    /// Within 1 %.
    Close,
    /// Neither.
    Differs,
    /// An input, or a time on another computer.
    NotComparable,
}

/// The rounding error of a sum of some dozens of doubles, in units in the last place.
const ROUNDING_ULPS: f64 = 4.0;

impl Paper {
    /// A row whose verdict is computed.
    pub(super) fn compared(
        &self,
        table: &'static str,
        row: impl Into<String>,
        column: impl Into<String>,
        published: Value,
        ours: Value,
    ) -> Row {
        let verdict = Verdict::of(&published, &ours);
        let (row, column, note) = (row.into(), column.into(), String::new());
        let mut row = Row { paper: self.name, table, row, column, published, ours, verdict, note };
        if row.verdict == Verdict::Exact && row.ours_as_printed() != row.published.to_string() {
            row.add_note("but for the rounding error of a sum");
        }
        row
    }
}

impl Row {
    /// The same with nothing to compare, and why.
    pub(super) fn uncompared(self, why: impl Into<String>) -> Self {
        Self { verdict: Verdict::NotComparable, note: why.into(), ..self }
    }

    /// Adds a remark.
    pub(super) fn add_note(&mut self, note: &str) {
        if !self.note.is_empty() {
            self.note += "; ";
        }
        self.note += note;
    }

    /// The same with a remark more.
    #[must_use]
    pub(super) fn noted(mut self, note: &str) -> Self {
        self.add_note(note);
        self
    }

    /// Our value, as a person compares it: a number to the precision that is printed.
    #[must_use]
    pub fn ours_as_printed(&self) -> String {
        match (&self.published, &self.ours) {
            (Value::Printed(Printed { decimals, .. }), Value::Number(ours)) => format!("{ours:.decimals$}"),
            (_, ours) => ours.to_string(),
        }
    }
}

impl Value {
    /// A number that we computed, if we could.
    #[must_use]
    pub fn number(number: Option<f64>) -> Self {
        number.map_or(Self::Missing, Self::Number)
    }

    /// A number as the paper prints it; text if it is none.
    #[must_use]
    pub fn printed(text: &str) -> Self {
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        match text.parse() {
            Ok(value) => Self::Printed(Printed { value, decimals }),
            Err(_) => Self::Text(text.into()),
        }
    }
}

impl Verdict {
    /// Compares `ours` with what is printed.
    #[must_use]
    pub fn of(published: &Value, ours: &Value) -> Self {
        match (published, ours) {
            (Value::Printed(printed), Value::Number(ours)) => {
                let Printed { value, decimals } = *printed;
                let half_a_digit = 0.5 * 10f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX));
                let rounding = ROUNDING_ULPS * (ours.next_up() - ours);
                if (value - ours).abs() <= half_a_digit + rounding {
                    Self::Exact
                } else if (value - ours).abs() <= 0.01 * value.abs() {
                    Self::Close
                } else {
                    Self::Differs
                }
            }
            (Value::Text(published), Value::Text(ours)) if published == ours => Self::Exact,
            _ => Self::Differs,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => f.pad(format!("{number:.4}").trim_end_matches('0').trim_end_matches('.')),
            Self::Printed(Printed { value, decimals }) => f.pad(&format!("{value:.decimals$}")),
            Self::Text(text) => f.pad(text),
            Self::Missing => f.pad("-"),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Exact => "exact",
            Self::Close => "close",
            Self::Differs => "differs",
            Self::NotComparable => "not comparable",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(printed: &str, ours: f64) -> Verdict {
        Verdict::of(&Value::printed(printed), &Value::Number(ours))
    }

    #[test]
    fn exact_means_equal_at_the_printed_precision_and_no_more() {
        assert_eq!(verdict("38.88854", 38.888_543_8), Verdict::Exact);
        assert_eq!(verdict("38.88854", 38.888_55), Verdict::Close);
        assert_eq!(verdict("45", 45.4), Verdict::Exact);
        assert_eq!(verdict("45.0", 45.4), Verdict::Close);
        assert_eq!(verdict("100", 101.0), Verdict::Close);
        assert_eq!(verdict("100", 101.6), Verdict::Differs);
    }

    #[test]
    fn the_rounding_of_a_sum_is_forgiven_and_no_more() {
        assert_eq!(verdict("83.4164078649988", 83.416_407_864_998_74), Verdict::Exact);
        assert_eq!(verdict("83.4164078649988", 83.416_407_864_998_6), Verdict::Close);
        assert_eq!(verdict("83.4164078649989", 83.416_407_864_998_74), Verdict::Close);
        assert_eq!(verdict("0.45", 0.455_000_1), Verdict::Differs);
    }

    #[test]
    fn a_value_that_is_none_is_never_exact() {
        assert_eq!(verdict("45", f64::NAN), Verdict::Differs);
        assert_eq!(verdict("45", f64::INFINITY), Verdict::Differs);
        assert_eq!(Verdict::of(&Value::printed("s9"), &Value::Text("s13".into())), Verdict::Differs);
        assert_eq!(Verdict::of(&Value::printed("s9"), &Value::Text("s9".into())), Verdict::Exact);
    }
}
