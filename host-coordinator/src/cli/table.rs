//! Aligned columns for a person.

/// `rows` under `head`, each column as wide as its widest field; the last one is not padded.
/// Columns named in `right` are aligned to the right.
pub fn table<const N: usize>(head: [&str; N], right: &[usize], rows: &[[String; N]]) -> String {
    let width = |column: usize| {
        let fields = rows.iter().filter_map(|row| row.get(column)).map(|field| field.chars().count());
        fields.chain(head.get(column).map(|name| name.chars().count())).max().unwrap_or(0)
    };
    let widths: Vec<_> = (0..N).map(width).collect();
    let line = |row: &[String; N]| {
        let mut line = String::new();
        for (column, (field, &width)) in row.iter().zip(&widths).enumerate() {
            let padding = " ".repeat(width.saturating_sub(field.chars().count()));
            let (before, after) =
                if right.contains(&column) { (padding.as_str(), "") } else { ("", padding.as_str()) };
            line += &format!("{before}{field}{after}  ");
        }
        line.trim_end().to_owned()
    };
    let head = line(&head.map(str::to_owned));
    let rule = "-".repeat(head.chars().count());
    [head, rule].into_iter().chain(rows.iter().map(line)).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::table;

    #[test]
    fn columns_line_up_whatever_is_in_them() {
        let rows =
            [["ä".to_owned(), "10".to_owned(), "note".to_owned()], ["bbb".into(), "9".into(), String::new()]];
        let expected = "name  n  note\n-------------\nä     10  note\nbbb    9";
        let expected = expected.replace("name  n  note\n-------------", "name   n  note\n--------------");
        assert_eq!(table(["name", "n", "note"], &[1], &rows), expected);
    }
}
