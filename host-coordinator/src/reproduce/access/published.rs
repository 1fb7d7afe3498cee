//! Numbers printed in Access: A. Ravankar et al., *Multi-robot path planning for smart access of
//! distributed charging points in map*, Artificial Life and Robotics 2020. Facts only; as text where
//! the printed precision matters.

/// Table 1: tasks and their priorities. What a task takes is printed as a symbol only.
pub const TABLE_1: [(&str, &str); 5] =
    [("patrolling", "10"), ("item delivery", "8"), ("cleaning", "3"), ("escort", "9"), ("others", "5")];

/// Experiments 1 and 2: where the robot asks.
pub const DEPOT_START: [i32; 2] = [90, 80];
/// Experiment 1: the point that is free, of 1 to 6.
pub const EMPTY_POINT: usize = 5;
/// Experiment 1: how long it takes to see whether a point is free, in seconds.
pub const CHECK_S: f64 = 15.0;
/// Experiment 2: the point whose robot is charged enough to leave.
pub const CHARGED_POINT: usize = 6;

/// Table 3: the stations.
pub const TABLE_3: [(&str, [i32; 2]); 12] = [
    ("A1", [20, 327]),
    ("A2", [20, 376]),
    ("A3", [20, 425]),
    ("B1", [280, 485]),
    ("B2", [327, 485]),
    ("B3", [375, 485]),
    ("C1", [482, 156]),
    ("C2", [482, 107]),
    ("C3", [482, 57]),
    ("D1", [223, 15]),
    ("D2", [173, 15]),
    ("D3", [127, 15]),
];

/// Experiment 3: where the robot starts.
pub const START: [i32; 2] = [250, 250];

/// Table 4: the way of the search, the stations in the order of the visits, and the distance.
pub const TABLE_4: [(&str, [&str; 12], &str); 6] = [
    ("Random-1", ["A3", "A1", "C3", "D3", "B1", "D1", "A2", "B2", "B3", "C1", "C2", "D2"], "5004.25"),
    ("Random-2", ["A2", "D2", "C2", "B1", "B3", "B2", "A1", "A3", "D3", "C3", "C1", "D1"], "3840.39"),
    ("Random-3", ["D2", "D1", "B2", "C3", "C1", "C2", "A2", "A3", "B3", "A1", "D3", "B1"], "4656.09"),
    ("Random-4", ["C3", "A3", "C2", "B1", "D1", "A2", "A1", "B2", "D3", "C1", "B3", "D2"], "6221.19"),
    ("Random-5", ["B3", "C3", "D3", "C2", "B2", "B1", "A2", "C1", "D2", "A1", "A3", "D1"], "5018.92"),
    ("Sequential", ["A1", "A2", "A3", "B1", "B2", "B3", "C1", "C2", "C3", "D1", "D2", "D3"], "2131.0"),
];

/// Experiment 3: the mean planning times of random search, sequential search and direct access, in
/// milliseconds.
pub const PLANNING_MS: [f64; 3] = [2730.0, 1280.0, 196.73];

/// Table 5: the start as it is printed, which is (y, x), the nearest empty station, the distance.
pub const TABLE_5: [([i32; 2], &str, &str); 12] = [
    ([111, 58], "D3", "124.581"),
    ([222, 201], "D1", "277.167"),
    ([233, 342], "C1", "277.794"),
    ([240, 56], "A1", "142.539"),
    ([270, 178], "A1", "273.25"),
    ([305, 448], "C1", "207.711"),
    ([378, 423], "B3", "126.882"),
    ([397, 252], "B1", "99.598"),
    ([469, 140], "A3", "138.225"),
    ([487, 113], "A3", "118.681"),
    ([84, 393], "C2", "98.527"),
    ([91, 326], "D1", "155.309"),
];
