//! Numbers printed in LMPP: Y. Deng, T. Li, M. Xie, W. Chen, IEEE Access 2023,
//! DOI 10.1109/ACCESS.2023.3257570. Facts only; as text where the printed precision
//! matters.

/// Table 4: where robots ask in Test 1, for Tables 5 and 6.
pub const TABLE_4: [[i32; 2]; 10] =
    [[92, 13], [10, 64], [55, 28], [97, 96], [98, 16], [49, 96], [15, 81], [92, 43], [96, 80], [4, 66]];

/// Table 5: times of LMPP and of A\* for the locations of Table 4, printed in "s".
pub const TABLE_5: [[f64; 2]; 10] = [
    [60.9105, 17367.0],
    [828.6, 11770.0],
    [743.6, 7691.0],
    [953.7, 8569.0],
    [906.0, 13010.0],
    [182.5, 14990.0],
    [558.2, 12850.0],
    [593.2, 6503.0],
    [623.2, 10680.0],
    [981.5, 12040.0],
];

/// Table 6: lengths by A\* and by LMPP for the locations of Table 4.
pub const TABLE_6: [[&str; 2]; 10] = [
    ["14.6011261594915", "14.6011261594915"],
    ["39.4721359549996", "40.7082039324994"],
    ["14.6011261594915", "14.6011261594915"],
    ["5.06449510224598", "5.06449510224598"],
    ["15.4721359549996", "15.4721359549996"],
    ["26.2360679774998", "26.2360679774998"],
    ["18.0219124314841", "18.0219124314841"],
    ["16.2448349897449", "16.2448349897449"],
    ["10.9442719099992", "10.9442719099992"],
    ["45", "46.2360679774998"],
];

/// Table 7: the threshold q_th, the size of Q1, and of Q1 and Q2 together.
pub const TABLE_7: [(f64, &str, &str); 9] = [
    (0.9, "8", "9"),
    (0.8, "8", "10"),
    (0.7, "8", "11"),
    (0.6, "8", "12"),
    (0.5, "8", "12"),
    (0.4, "8", "12"),
    (0.3, "8", "13"),
    (0.2, "8", "13"),
    (0.1, "8", "13"),
];

/// The threshold q_th of Tests 3 and 4.
pub const Q_THRESHOLD: f64 = 0.1;

/// Table 8: the probabilities of piles 1 to 13 in the six conditions of Test 3.
pub const TABLE_8: [[f64; 13]; 6] = [
    [0.003, 0.01, 0.12, 0.0, 0.001, 0.0, 0.0, 0.04, 0.13, 0.09, 0.11, 0.376, 0.12],
    [0.0, 0.0, 0.11, 0.08, 0.0, 0.001, 0.075, 0.06, 0.004, 0.34, 0.27, 0.0, 0.06],
    [0.10, 0.10, 0.10, 0.10, 0.10, 0.10, 0.0, 0.10, 0.10, 0.0, 0.10, 0.0, 0.10],
    [0.080, 0.026, 0.113, 0.015, 0.071, 0.120, 0.016, 0.036, 0.057, 0.145, 0.028, 0.143, 0.150],
    [0.124, 0.094, 0.107, 0.039, 0.118, 0.113, 0.003, 0.059, 0.106, 0.094, 0.068, 0.005, 0.07],
    [0.066, 0.087, 0.073, 0.001, 0.141, 0.069, 0.021, 0.053, 0.064, 0.054, 0.185, 0.007, 0.179],
];

/// Where the robot asks in Test 3.
pub const TEST_3_START: [i32; 2] = [80, 50];

/// Test 3: max and min of D(Q1), max and min of D(Q2). The text calls the last a maximum too.
pub const TEST_3_DISTANCES: [&str; 4] = ["103.5848", "38.88854", "88.67878", "29.56512"];

/// Test 3: the reach and the piles chosen in conditions 1 to 6.
pub const TEST_3_CHOICES: [(u32, [u16; 6]); 3] =
    [(35, [9, 9, 9, 9, 9, 9]), (80, [12, 10, 13, 13, 13, 13]), (120, [12, 10, 9, 13, 1, 11])];

/// Table 9: the probabilities of piles 1 to 13 in Test 4.
pub const TABLE_9: [f64; 13] = [0.01, 0.02, 0.09, 0.22, 0.09, 0.01, 0.05, 0.03, 0.13, 0.07, 0.25, 0.02, 0.01];

/// Table 10: where the robot asks in Test 4, max and min of D(Q1), max and min of D(Q2).
pub const TABLE_10: [([i32; 2], [&str; 4]); 6] = [
    ([92, 43], ["117.2373", "38.08203", "101.5498", "16.24483"]),
    ([96, 80], ["139.9455", "41.67219", "126.5805", "10.94427"]),
    ([4, 66], ["160.526", "101.4831", "152.1215", "87.30495"]),
    ([40, 75], ["156.9424", "11.18034", "148.5379", "40.18034"]),
    ([18, 66], ["146.526", "87.4831", "138.1215", "73.30495"]),
    ([4, 71], ["162.8265", "29.7082", "154.422", "3.236068"]),
];

/// Test 4: the piles chosen at the six locations of Table 10 with these reaches.
pub const TEST_4_REACHES: [u32; 3] = [50, 80, 120];
/// See [`TEST_4_REACHES`].
pub const TEST_4_CHOICES: [[Option<u16>; 3]; 6] = [
    [Some(13), Some(4), Some(4)],
    [Some(4), Some(4), Some(4)],
    [None, None, Some(8)],
    [Some(2), Some(2), Some(2)],
    [None, Some(3), Some(8)],
    [Some(1), Some(1), Some(1)],
];

/// Table 11: where robots ask in Test 5, for Tables 13 and 14.
pub const TABLE_11: [[i32; 2]; 10] =
    [[70, 13], [40, 64], [55, 28], [50, 96], [67, 32], [49, 60], [15, 81], [92, 43], [96, 80], [44, 66]];

/// Table 12: the probability of meeting an obstacle in doors 1 to 7.
pub const TABLE_12: [&str; 7] = ["0.45", "0.12", "0.09", "0.77", "0.09", "0.35", "0.05"];

/// The threshold theta of Test 5 with obstacle avoidance.
pub const THETA: f64 = 0.3;
/// The speed of the robot in Test 5, in cells a second.
pub const SPEED: f64 = 0.5;
/// The delay at an obstructed door in Test 5, in seconds.
pub const DELAY_S: f64 = 200.0;

/// Table 13: seconds from the locations of Table 11 with and without obstacle avoidance.
pub const TABLE_13: [[&str; 2]; 10] = [
    ["15.4164078649987", "15.4164078649987"],
    ["83.4164078649988", "283.073262114491"],
    ["29.2022523189831", "29.2022523189831"],
    ["52", "52"],
    ["24.9442719099992", "24.9442719099992"],
    ["90.3957478239784", "90.3957478239784"],
    ["36.0438248629683", "36.043824862968"],
    ["32.4896699794899", "32.4896699794899"],
    ["21.8885438199983", "21.888543819998"],
    ["90.4721359549996", "290.128990204492"],
];
/// Table 13's last row.
pub const TABLE_13_AVERAGE: [&str; 2] = ["47.62692624", "87.55829709"];

/// Table 14: lengths from the locations of Table 11 without and with obstacle avoidance.
pub const TABLE_14: [[&str; 2]; 10] = [
    ["7.70820393249937", "7.70820393249937"],
    ["41.5366310572456", "41.7082039324994"],
    ["14.6011261594915", "14.6011261594915"],
    ["26", "26"],
    ["12.4721359549996", "12.4721359549996"],
    ["45.1978739119892", "45.1978739119892"],
    ["18.0219124314841", "18.0219124314841"],
    ["16.2448349897449", "16.2448349897449"],
    ["10.9442719099992", "10.9442719099992"],
    ["45.0644951022460", "45.2360679774998"],
];
