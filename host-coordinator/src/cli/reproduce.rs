//! `chargehand reproduce`: do the papers' tables come out?

use host_coordinator::reproduce::{Row, Verdict, lmpp};

use super::{Outcome, out, out_json, table::table};

/// Compute the papers' tables again and compare them with what is printed
///
/// The map of LMPP's Fig. 7 is lost; it was reconstructed from the printed lengths, so that
/// their match is a fit and no independent test.
#[derive(clap::Args)]
pub struct Reproduce {
    /// One table of LMPP, 5 to 14; all if left out
    #[arg(long, value_name = "N")]
    table: Option<u32>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What the notes on door sets mean.
const DOORS: [(&str, &str); 2] = [
    ("doors as drawn", "each subarea has its own doors"),
    (
        "doors as run",
        "what the lengths of Tests 3 and 4 demand: the hall also offers doors 1 and 2 and links them to \
         door 4, the corridor offers doors 3 and 7 only",
    ),
];

impl Reproduce {
    pub fn run(self) -> Outcome {
        let rows = lmpp::rows(self.table)?;
        if self.json { out_json(&rows) } else { out(&text(&rows)) }
    }
}

fn text(rows: &[Row]) -> String {
    let fields = |row: &Row| {
        let Row { table, row: name, column, published, verdict, note, .. } = row;
        let ours = row.ours_as_printed();
        let (published, verdict) = (published.to_string(), verdict.to_string());
        [table.to_string(), name.clone(), column.clone(), published, ours, verdict, note.clone()]
    };
    let fields: Vec<_> = rows.iter().map(fields).collect();
    let head = ["table", "row", "column", "published", "ours", "verdict", "note"];
    let table = table(head, &[0, 3, 4], &fields);
    let mut lines = table.lines();
    let mut text: Vec<String> = lines.by_ref().take(2).map(str::to_owned).collect();
    text.extend(lines.zip(rows).map(|(line, row)| coloured(line, row.verdict)));
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    text.push(String::new());
    text.extend(
        DOORS
            .iter()
            .filter(|(set, _)| rows.iter().any(|row| row.note.contains(set)))
            .map(|(set, meaning)| format!("{set}: {meaning}")),
    );
    text.push(format!(
        "LMPP: {} rows, {} exact, {} close, {} differ, {} not comparable",
        rows.len(),
        count(Verdict::Exact),
        count(Verdict::Close),
        count(Verdict::Differs),
        count(Verdict::NotComparable),
    ));
    text.join("\n")
}

fn coloured(line: &str, verdict: Verdict) -> String {
    let colour = match verdict {
        Verdict::Exact => return line.to_owned(),
        Verdict::Close => "\x1b[33m",
        Verdict::Differs => "\x1b[31m",
        Verdict::NotComparable => "\x1b[2m",
    };
    format!("{colour}{line}\x1b[0m")
}
