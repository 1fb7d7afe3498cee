//! Numbers printed in Mecanum: Z. Mi, H. Xiao, C. Huang, AIP Advances 13, 045313 (2023),
//! DOI 10.1063/5.0144960. Facts only; as text where the printed precision matters.

/// Table I: nodes that A* expands and seconds it takes, in environments (a) to (d).
pub const TABLE_I: [(&str, f64, f64); 4] = [
    ("(a) barrier-free", 90.0, 15.5),
    ("(b) simple", 88.0, 17.0),
    ("(c) intermediate", 110.0, 34.5),
    ("(d) complex", 156.0, 67.5),
];

/// The delay for each node in s that Tables I to III are said to be measured with.
pub const DELAY_S: &str = "0.5";

/// A row of Tables II and III. Pairs are those of the improved A* (I) and of A* (II).
pub struct Comparison {
    /// The map, as the table names it.
    pub map: &'static str,
    /// Columns and rows.
    pub size: (u32, u32),
    /// The share of blocked cells: so many of so many.
    pub density: (u32, u32),
    /// Search times, in s.
    pub seconds: [f64; 2],
    /// Expanded nodes.
    pub nodes: [f64; 2],
    /// Path lengths, in an unknown unit.
    pub lengths: [f64; 2],
    /// The ratios of times and of nodes.
    pub ratios: [&'static str; 2],
}

/// Table II: maps of several sizes, a fifth blocked.
pub const TABLE_II: [Comparison; 5] = [
    sized("10 x 10", (10, 10), [3.5, 13.0], [6.0, 34.0], [27.0, 25.0], ["0.27", "0.17"]),
    sized("20 x 20", (20, 20), [6.5, 25.5], [12.0, 94.0], [59.0, 56.0], ["0.25", "0.13"]),
    sized("30 x 20", (30, 20), [9.5, 41.0], [14.0, 104.0], [91.0, 79.0], ["0.23", "0.13"]),
    sized("30 x 30", (30, 30), [13.5, 61.5], [11.0, 96.0], [106.0, 90.0], ["0.21", "0.11"]),
    sized("40 x 30", (40, 30), [15.5, 74.5], [14.0, 142.0], [128.0, 116.0], ["0.20", "0.10"]),
];

/// Table III: maps of 30 x 20 cells with several densities of obstacles. "2/1" is taken for 1/2
/// (decision 12).
pub const TABLE_III: [Comparison; 5] = [
    dense("1/6", (1, 6), [8.0, 42.0], [16.0, 89.0], [69.0, 61.0], ["0.03", "0.06"]),
    dense("1/4", (1, 4), [7.5, 197.5], [22.0, 360.0], [178.0, 171.0], ["0.04", "0.06"]),
    dense("1/3", (1, 3), [6.5, 131.0], [18.0, 168.0], [84.0, 71.0], ["0.05", "0.11"]),
    dense("2/1", (1, 2), [6.0, 72.0], [11.0, 194.0], [121.0, 96.0], ["0.08", "0.06"]),
    dense("2/3", (2, 3), [5.0, 57.5], [12.0, 127.0], [128.0, 116.0], ["0.09", "0.09"]),
];

const fn sized(
    map: &'static str,
    size: (u32, u32),
    seconds: [f64; 2],
    nodes: [f64; 2],
    lengths: [f64; 2],
    ratios: [&'static str; 2],
) -> Comparison {
    Comparison { map, size, density: (1, 5), seconds, nodes, lengths, ratios }
}

const fn dense(
    map: &'static str,
    density: (u32, u32),
    seconds: [f64; 2],
    nodes: [f64; 2],
    lengths: [f64; 2],
    ratios: [&'static str; 2],
) -> Comparison {
    Comparison { map, size: (30, 20), density, seconds, nodes, lengths, ratios }
}

/// Table IV: paths of a real robot, their lengths in m and times in ms, by improved A* and by A*.
pub const TABLE_IV: [(&str, [f64; 2], [f64; 2]); 2] =
    [("path 1", [11.4, 11.8], [82.4, 210.8]), ("path 2", [40.2, 41.6], [184.8, 682.7])];

/// By how much the abstract says that the improved A* shortens the computing time, in per cent.
pub const TIME_SAVED_PERCENT: &str = "67";

/// III.C.2: the increment of a wheel's speed, in m/s a tick.
pub const INCREMENT_MPS: &str = "0.01";
