//! What IGWO's text prints of its tables and figures; the tables themselves are missing from the text
//! at hand.

/// What changed from GWO to IGWO on one map: in per cent and in iterations or metres, signed; `None`
/// where the text is silent.
pub struct Changes {
    /// The mean of the iterations that were needed.
    pub mean_iterations: [Option<&'static str>; 2],
    pub best_iterations: [Option<&'static str>; 2],
    pub mean_length: [Option<&'static str>; 2],
    pub best_length: [Option<&'static str>; 2],
}

/// Tables II and III: test maps 1 to 4. The text prints the 22.2 iterations of map 1 as per cent.
pub const TABLES_II_III: [Changes; 4] = [
    Changes {
        mean_iterations: [Some("-89.36"), Some("-22.2")],
        best_iterations: [Some("-50"), Some("-2")],
        mean_length: [Some("-11.56"), Some("-2.69")],
        best_length: [Some("-11.56"), Some("-2.69")],
    },
    Changes {
        mean_iterations: [Some("-91.7"), Some("-16.8")],
        best_iterations: [Some("-82"), Some("-9")],
        mean_length: [Some("-4.81"), Some("-1.12")],
        best_length: [Some("-4.81"), Some("-1.12")],
    },
    Changes {
        mean_iterations: [Some("-50.36"), Some("-28.2")],
        best_iterations: [Some("-43.75"), Some("-7")],
        mean_length: [Some("-10.88"), Some("-2.62")],
        best_length: [Some("-7.39"), Some("-1.72")],
    },
    Changes {
        mean_iterations: [Some("1640"), Some("32.8")],
        best_iterations: [Some("250"), Some("5")],
        mean_length: [Some("-7.02"), Some("-1.74")],
        best_length: [Some("-7.14"), Some("-1.77")],
    },
];

/// Tables IV and V: parking lots 1 to 4.
pub const TABLES_IV_V: [Changes; 4] = [
    Changes {
        mean_iterations: [Some("-33.61"), Some("-8.2")],
        best_iterations: [Some("-75.00"), Some("-15")],
        mean_length: [None, Some("-2.44")],
        best_length: [None, Some("-1.57")],
    },
    Changes {
        mean_iterations: [Some("-22.63"), Some("-3.1")],
        best_iterations: [None, None],
        mean_length: [None, Some("-1.59")],
        best_length: [None, Some("-1.54")],
    },
    Changes {
        mean_iterations: [Some("120.00"), Some("2.4")],
        best_iterations: [Some("50"), Some("1")],
        mean_length: [None, Some("-2.54")],
        best_length: [None, Some("-2.54")],
    },
    Changes {
        mean_iterations: [Some("149.18"), Some("9.1")],
        best_iterations: [Some("-20.00"), Some("-1")],
        mean_length: [None, Some("-2.42")],
        best_length: [None, Some("-3.00")],
    },
];

/// Tables VI and VII: the convergence factor with the fewest iterations, on every lot.
pub const BEST_FACTOR: &str = "a4";

/// Table VIII: what changes from GWO to A\*-IGWO over all lots, in per cent: iterations and length.
pub const TABLE_VIII: [&str; 2] = ["-69.7", "-6.1"];

/// Fig. 3: from cells of 2.60 m to 1.30 m: iterations, length in per cent, length in metres.
pub const FINER: [&str; 3] = ["0.5", "-2.9", "-1.12"];
/// Fig. 3: from cells of 1.30 m to 0.65 m: iterations, and that in per cent.
pub const FINEST: [&str; 2] = ["4.72", "171.6"];
/// Fig. 3: from cells of 1.30 m to 0.65 m the length falls by this many per cent at most.
pub const FINEST_LENGTH_PERCENT: f64 = 0.1;

/// Section 4 and 4.3.1: runs, population, iterations, and PSO's particles.
pub const PARAMETERS: [(&str, &str); 4] =
    [("runs", "20"), ("population", "5"), ("iterations", "100"), ("particles of PSO", "20")];
