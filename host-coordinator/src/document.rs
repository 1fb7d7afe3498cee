//! Reads a TOML file and collects every mistake in it instead of stopping at the first.
//!
//! A [`Section`] is asked for its keys; a missing, ill-typed or out-of-range value is noted with
//! its line and reads as `None`. Keys that nobody asked for are noted when the section is
//! dropped.

use std::{
    cell::RefCell,
    fmt::Display,
    io,
    ops::{Range, RangeInclusive},
    path::{Path, PathBuf},
    str::FromStr,
};

use toml::de::{DeTable, DeValue};

use crate::diagnostics::{Diagnostic, Diagnostics};

/// A file while it is read, with the mistakes found so far.
pub struct Document<'a> {
    file: &'a Path,
    text: &'a str,
    mistakes: RefCell<Vec<Diagnostic>>,
}

/// Reads `text`, the content of `file`, with `read`, which returns `None` only after noting a
/// mistake.
///
/// # Errors
/// Every mistake that was noted.
pub fn read<T>(
    file: &Path,
    text: io::Result<String>,
    read: impl FnOnce(&Document<'_>, Section<'_>) -> Option<T>,
) -> Result<T, Diagnostics> {
    let text = match text {
        Ok(text) => text,
        Err(error) => {
            let mistake = Diagnostic::new(file, None, format!("cannot be read ({error})"), "a TOML file");
            return Diagnostics::check(file, vec![mistake], None);
        }
    };
    let document = Document { file, text: &text, mistakes: RefCell::default() };
    let (root, errors) = DeTable::parse_recoverable(&text);
    let value = read(&document, document.section("the file".into(), 1, root.into_inner()));
    let mut mistakes = document.mistakes.take();
    for error in errors {
        let line = error.span().map(|span| document.line(&span));
        // What else seems wrong with this line follows from it.
        mistakes.retain(|mistake| mistake.file != file || mistake.line != line);
        let problem = format!("is no valid TOML ({})", error.message());
        mistakes.push(Diagnostic::new(file, line, problem, "`key = value` or `[section]`"));
    }
    Diagnostics::check(file, mistakes, value)
}

impl<'a> Document<'a> {
    /// Notes a mistake in this file.
    pub fn mistake(
        &self,
        line: impl Into<Option<usize>>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) {
        self.mistake_elsewhere([Diagnostic::new(self.file, line, problem, expected)]);
    }

    /// Notes mistakes in a file that this one names.
    pub fn mistake_elsewhere(&self, mistakes: impl IntoIterator<Item = Diagnostic>) {
        self.mistakes.borrow_mut().extend(mistakes);
    }

    /// A path that this file gives, relative to the file itself.
    #[must_use]
    pub fn resolve(&self, path: &str) -> PathBuf {
        let path = self.file.parent().unwrap_or(Path::new("")).join(path);
        // Tidy `dir/.`, which would look odd in messages.
        path.components().collect()
    }

    fn line(&self, span: &Range<usize>) -> usize {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        1 + before.bytes().filter(|&byte| byte == b'\n').count()
    }

    fn section<'s>(&'s self, title: String, line: usize, entries: DeTable<'s>) -> Section<'s> {
        Section { document: self, title, line, entries, asked: Vec::new() }
    }
}

/// One table of the file.
pub struct Section<'a> {
    document: &'a Document<'a>,
    title: String,
    line: usize,
    /// What nobody asked for yet.
    entries: DeTable<'a>,
    /// What was asked for, and its line if it is there.
    asked: Vec<(&'static str, Option<usize>)>,
}

impl<'a> Section<'a> {
    /// The value of `key`; a mistake if there is none.
    pub fn required<T>(&mut self, key: &'static str, kind: &Kind<T>) -> Option<T> {
        if !self.entries.contains_key(key) {
            self.asked.push((key, None));
            let problem = format!("{} has no `{key}`", self.title);
            self.document.mistake(self.line, problem, &*kind.expected);
            return None;
        }
        self.optional(key, kind)
    }

    /// The value of `key`, if there is one.
    pub fn optional<T>(&mut self, key: &'static str, kind: &Kind<T>) -> Option<T> {
        let (span, value) = self.take(key)?;
        let read = (kind.read)(&value);
        if read.is_none() {
            self.is_not(key, &span, &value, &kind.expected);
        }
        read
    }

    /// The table `[key]`; an empty one if there is none.
    pub fn table(&mut self, key: &'static str) -> Section<'a> {
        let entries = match self.take(key) {
            Some((_, DeValue::Table(entries))) => entries,
            Some((span, other)) => {
                self.is_not(key, &span, &other, &format!("a table `[{key}]`"));
                DeTable::new()
            }
            None => DeTable::new(),
        };
        self.document.section(format!("[{key}]"), self.line_of(key), entries)
    }

    /// The tables `[[key]]`, in the file's order.
    pub fn tables(&mut self, key: &'static str) -> Vec<Section<'a>> {
        let expected = format!("tables `[[{key}]]`");
        let elements = match self.take(key) {
            Some((_, DeValue::Array(elements))) => elements,
            Some((span, other)) => {
                self.is_not(key, &span, &other, &expected);
                return Vec::new();
            }
            None => return Vec::new(),
        };
        let mut sections = Vec::new();
        for element in elements {
            let span = element.span();
            match element.into_inner() {
                DeValue::Table(entries) => {
                    let line = self.document.line(&span);
                    sections.push(self.document.section(format!("[[{key}]]"), line, entries));
                }
                other => self.is_not(key, &span, &other, &expected),
            }
        }
        sections
    }

    /// Notes that the value of `key`, or an element of it, is not what is expected.
    fn is_not(&self, key: &str, span: &Range<usize>, value: &DeValue<'_>, expected: &str) {
        let written = self.document.text.get(span.clone()).unwrap_or_default();
        let long = written.chars().count() > 60 || written.contains('\n');
        let found = if long { value.type_str() } else { written };
        self.document.mistake(self.document.line(span), format!("`{key}` is {found}"), expected);
    }

    /// The line of `key`, or of the section if the key is not there.
    #[must_use]
    pub fn line_of(&self, key: &str) -> usize {
        let line = self.asked.iter().find(|(asked, _)| *asked == key).and_then(|&(_, line)| line);
        line.unwrap_or(self.line)
    }

    /// Notes a mistake in the value of `key`.
    pub fn mistake(&self, key: &str, problem: impl Into<String>, expected: impl Into<String>) {
        self.document.mistake(self.line_of(key), problem, expected);
    }

    fn take(&mut self, key: &'static str) -> Option<(Range<usize>, DeValue<'a>)> {
        let taken = self.entries.remove_entry(key);
        self.asked.push((key, taken.as_ref().map(|(key, _)| self.document.line(&key.span()))));
        taken.map(|(_, value)| (value.span(), value.into_inner()))
    }
}

impl Drop for Section<'_> {
    fn drop(&mut self) {
        for key in self.entries.keys() {
            let known: Vec<_> = self.asked.iter().map(|(key, _)| format!("`{key}`")).collect();
            self.document.mistake(
                self.document.line(&key.span()),
                format!("{} has an unknown key `{}`", self.title, key.get_ref()),
                format!("one of {}", known.join(", ")),
            );
        }
    }
}

/// What kind of value a key has: how it is read and how a person is told.
pub struct Kind<T> {
    expected: String,
    read: Box<Read<T>>,
}

type Read<T> = dyn Fn(&DeValue<'_>) -> Option<T>;

impl<T: 'static> Kind<T> {
    fn new(expected: impl Into<String>, read: impl Fn(&DeValue<'_>) -> Option<T> + 'static) -> Self {
        Self { expected: expected.into(), read: Box::new(read) }
    }
}

/// Text that is not empty.
#[must_use]
pub fn text() -> Kind<String> {
    Kind::new("a text in quotes", |value| {
        value.as_str().filter(|text| !text.trim().is_empty()).map(str::to_owned)
    })
}

/// Text that can be read as `T`, such as `expected`.
#[must_use]
pub fn parsed<T: FromStr + 'static>(expected: &str) -> Kind<T> {
    Kind::new(expected, |value| value.as_str()?.parse().ok())
}

/// True or false.
#[must_use]
pub fn flag() -> Kind<bool> {
    Kind::new("true or false", |value| value.as_bool())
}

/// A number out of a few.
#[must_use]
pub fn one_number_of<T: Copy + 'static>(choices: &'static [(i64, T)]) -> Kind<T> {
    let numbers: Vec<_> = choices.iter().map(|(number, _)| number.to_string()).collect();
    Kind::new(numbers.join(" or "), |value| {
        let number = integer(value)?;
        choices.iter().find(|&&(choice, _)| choice == number).map(|&(_, choice)| choice)
    })
}

/// Two letters, such as the names of two subareas.
#[must_use]
pub fn two_letters() -> Kind<[char; 2]> {
    Kind::new("two letters as [\"A\", \"B\"]", |value| {
        let elements = value.as_array()?;
        let letter = |index: usize| {
            let mut letters = elements.get(index)?.get_ref().as_str()?.chars();
            letters.next().filter(|_| letters.next().is_none())
        };
        (elements.len() == 2).then_some([letter(0)?, letter(1)?])
    })
}

/// A whole number in `range`.
#[must_use]
pub fn whole<T: TryFrom<i64> + 'static>(range: RangeInclusive<i64>) -> Kind<T> {
    Kind::new(format!("a whole number from {} to {}", range.start(), range.end()), move |value| {
        integer(value).filter(|number| range.contains(number)).and_then(|number| T::try_from(number).ok())
    })
}

/// A finite number in `range`, whose end may be infinite.
#[must_use]
pub fn number(range: RangeInclusive<f64>) -> Kind<f64> {
    let expected = if range.end().is_finite() {
        format!("a number from {} to {}", range.start(), range.end())
    } else {
        format!("a finite number of {} or more", range.start())
    };
    Kind::new(expected, move |value| {
        let number = match value {
            DeValue::Float(float) => float.as_str().parse().ok()?,
            other => integer(other)? as f64,
        };
        (number.is_finite() && range.contains(&number)).then_some(number)
    })
}

/// A cell or point as `[x, y]`, in whole numbers of `what`.
#[must_use]
pub fn pair(what: impl Display) -> Kind<[i32; 2]> {
    Kind::new(format!("[x, y] in whole {what}"), |value| match value {
        DeValue::Array(elements) => {
            let whole = |index: usize| i32::try_from(integer(elements.get(index)?.get_ref())?).ok();
            (elements.len() == 2).then_some([whole(0)?, whole(1)?])
        }
        _ => None,
    })
}

fn integer(value: &DeValue<'_>) -> Option<i64> {
    let integer = value.as_integer()?;
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}
