//! Rational B-splines (NURBS) as lines with corners, by de Boor's algorithm (The NURBS Book, Piegl and Tiller,
//! 1997).

use crate::floor_plan::Point;

/// The highest degree that is read.
const MAX_DEGREE: usize = 16;
/// A line is nowhere farther than that from its curve where looked, in metres.
const TOLERANCE_M: f64 = 0.001;
/// Between two knots a curve becomes at most 2 to this many lines.
const MAX_HALVINGS: u32 = 6;

/// What is wrong with a curve.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CurveError {
    /// The degree is too low or too high.
    #[error("degree {degree}: expected a whole number from 1 to {}", MAX_DEGREE.min(points.saturating_sub(1)))]
    Degree {
        /// As it was given.
        degree: String,
        /// How many control points there are.
        points: usize,
    },
    /// There are too many knots or too few.
    #[error("{found} knots: expected {expected}, control points plus degree plus 1")]
    Knots {
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A knot is less than the one before it.
    #[error("knot {number} (from 0) is no number, or less than the one before: expected rising numbers")]
    Falling {
        /// Which, from 0.
        number: usize,
    },
    /// The knots leave nothing of the curve.
    #[error("the knots from {first} to {last} (from 0) are all the same: expected the curve between them")]
    Empty {
        /// Where the curve begins, from 0.
        first: usize,
        /// Where it ends, from 0.
        last: usize,
    },
    /// A control point makes no sense.
    #[error(
        "control point {number} (from 0) is far too far away, or its weight is not above 0: expected metres"
    )]
    Point {
        /// Which, from 0.
        number: usize,
    },
}

/// A point that pulls the curve.
pub(super) struct ControlPoint {
    pub(super) at_m: Point,
    pub(super) weight: f64,
}

/// A curve that can be drawn.
pub(super) struct Curve {
    degree: usize,
    knots: Vec<f64>,
    /// Control points times weight, and the weight.
    points: Vec<[f64; 3]>,
}

impl Curve {
    pub(super) fn new(degree: f64, knots: Vec<f64>, points: &[ControlPoint]) -> Result<Self, CurveError> {
        let count = points.len();
        if degree.fract() != 0.0 || !(1.0..=MAX_DEGREE as f64).contains(&degree) || degree as usize >= count {
            return Err(CurveError::Degree { degree: degree.to_string(), points: count });
        }
        let degree = degree as usize;
        let (found, expected) = (knots.len(), count + degree + 1);
        if found != expected {
            return Err(CurveError::Knots { found, expected });
        }
        let mut before = f64::MIN;
        for (number, &knot) in knots.iter().enumerate() {
            if !knot.is_finite() || knot < before {
                return Err(CurveError::Falling { number });
            }
            before = knot;
        }
        if knots[degree] >= knots[count] {
            return Err(CurveError::Empty { first: degree, last: count });
        }
        let weighted = |(number, &ControlPoint { at_m: [x, y], weight }): (usize, &ControlPoint)| {
            let sound = x.abs() < 1e9 && y.abs() < 1e9 && (1e-6..=1e6).contains(&weight);
            sound.then_some([x * weight, y * weight, weight]).ok_or(CurveError::Point { number })
        };
        let points = points.iter().enumerate().map(weighted).collect::<Result<_, _>>()?;
        Ok(Self { degree, knots, points })
    }

    /// The corners of lines along the curve, its ends too.
    pub(super) fn line(&self) -> Vec<Point> {
        let spans = self.degree..self.points.len();
        let mut spans = spans.filter(|&span| self.knots[span] < self.knots[span + 1]).peekable();
        let mut line: Vec<Point> =
            spans.peek().map(|&span| self.at(span, self.knots[span])).into_iter().collect();
        for span in spans {
            let halvings = if self.degree == 1 { 0 } else { MAX_HALVINGS };
            self.draw(span, [self.knots[span], self.knots[span + 1]], halvings, &mut line);
        }
        line
    }

    /// Goes on from one parameter of a span to another.
    fn draw(&self, span: usize, [from, to]: [f64; 2], halvings: u32, line: &mut Vec<Point>) {
        let at = |share: f64| self.at(span, from + share * (to - from));
        let [start, end] = [at(0.0), at(1.0)];
        // A curve that swings to both sides of the line may cross it in its middle.
        let is_near = |share: f64| distance(at(share), [start, end]) <= TOLERANCE_M;
        if halvings == 0 || [0.25, 0.5, 0.75].into_iter().all(is_near) {
            line.push(end);
            return;
        }
        let middle = from + 0.5 * (to - from);
        self.draw(span, [from, middle], halvings - 1, line);
        self.draw(span, [middle, to], halvings - 1, line);
    }

    /// The point at a parameter from the span's knot to the next one.
    fn at(&self, span: usize, parameter: f64) -> Point {
        let degree = self.degree;
        let mut points = [[0.0; 3]; MAX_DEGREE + 1];
        points[..=degree].copy_from_slice(&self.points[span - degree..=span]);
        for level in 1..=degree {
            for place in (level..=degree).rev() {
                let (low, high) = (self.knots[place + span - degree], self.knots[place + 1 + span - level]);
                let share = (parameter - low) / (high - low);
                let [one, other] = [points[place - 1], points[place]];
                points[place] = [0, 1, 2].map(|part| (1.0 - share) * one[part] + share * other[part]);
            }
        }
        let [x, y, weight] = points[degree];
        [x / weight, y / weight]
    }
}

/// How far a point is from a line.
fn distance([x, y]: Point, [from, to]: [Point; 2]) -> f64 {
    let (along, off) = ([to[0] - from[0], to[1] - from[1]], [x - from[0], y - from[1]]);
    let squared = along[0] * along[0] + along[1] * along[1];
    let share =
        if squared > 0.0 { ((off[0] * along[0] + off[1] * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (off[0] - share * along[0]).hypot(off[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn points(points: &[(f64, f64, f64)]) -> Vec<ControlPoint> {
        points.iter().map(|&(x, y, weight)| ControlPoint { at_m: [x, y], weight }).collect()
    }

    fn length(line: &[Point]) -> f64 {
        line.iter().zip(&line[1..]).map(|(from, to)| (from[0] - to[0]).hypot(from[1] - to[1])).sum()
    }

    #[test]
    fn a_half_circle_is_round_and_as_long_as_it_should_be() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let corners =
            [(5.0, 0.0, 1.0), (5.0, 5.0, half), (0.0, 5.0, 1.0), (-5.0, 5.0, half), (-5.0, 0.0, 1.0)];
        let knots = vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0];
        let line = Curve::new(2.0, knots, &points(&corners)).unwrap().line();
        assert!(line.iter().all(|[x, y]| (x.hypot(*y) - 5.0).abs() < 1e-9), "{line:?}");
        assert!((length(&line) / (5.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3, "{}", length(&line));
        assert_eq!(line[0], [5.0, 0.0]);
    }

    #[test]
    fn degree_1_is_the_lines_between_control_points() {
        let corners = [(0.0, 0.0, 1.0), (3.0, 4.0, 2.0), (3.0, 9.0, 1.0)];
        let line = Curve::new(1.0, vec![0.0, 0.0, 0.3, 1.0, 1.0], &points(&corners)).unwrap().line();
        assert_eq!(line, [[0.0, 0.0], [3.0, 4.0], [3.0, 9.0]]);
    }

    #[test]
    fn a_curve_that_crosses_its_chord_in_the_middle_is_not_taken_for_straight() {
        let corners = [(0.0, 0.0, 1.0), (0.0, 4.0, 1.0), (6.0, -4.0, 1.0), (6.0, 0.0, 1.0)];
        let line = Curve::new(3.0, [[0.0; 4], [1.0; 4]].concat(), &points(&corners)).unwrap().line();
        assert!(line.len() > 8 && length(&line) > 7.0, "{line:?}");
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        let error = |degree: f64, knots: &[f64], corners: &[(f64, f64, f64)]| {
            Curve::new(degree, knots.to_vec(), &points(corners)).err().map(|error| error.to_string())
        };
        let two = [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0)];
        assert_eq!(error(2.0, &[0.0; 5], &two).unwrap(), "degree 2: expected a whole number from 1 to 1");
        assert_eq!(error(1.5, &[0.0; 5], &two).unwrap(), "degree 1.5: expected a whole number from 1 to 1");
        assert_eq!(
            error(1.0, &[0.0, 0.0, 1.0], &two).unwrap(),
            "3 knots: expected 4, control points plus degree plus 1"
        );
        assert!(error(1.0, &[0.0, 0.5, 0.2, 1.0], &two).unwrap().starts_with("knot 2 (from 0) is no number"));
        assert!(error(1.0, &[0.5; 4], &two).unwrap().starts_with("the knots from 1 to 2"));
        let none = [(0.0, 0.0, 0.0), (1.0, 0.0, 1.0)];
        assert!(error(1.0, &[0.0, 0.0, 1.0, 1.0], &none).unwrap().starts_with("control point 0"));
    }

    proptest! {
        #[test]
        fn a_curve_stays_within_what_its_control_points_span(
            degree in 1usize..6, more in 0usize..6, places in prop::collection::vec((-9.0..9.0, -9.0..9.0, 0.1..9.0), 12),
            knots in prop::collection::vec(0.0..1.0, 24),
        ) {
            let count = degree + 1 + more;
            let mut knots = knots[..count + degree + 1].to_vec();
            knots.sort_unstable_by(f64::total_cmp);
            let bounds = |of: fn(&(f64, f64, f64)) -> f64| {
                let values = || places[..count].iter().map(of);
                (values().fold(f64::MAX, f64::min) - 1e-6)..(values().fold(f64::MIN, f64::max) + 1e-6)
            };
            let (columns, rows) = (bounds(|place| place.0), bounds(|place| place.1));
            if let Ok(curve) = Curve::new(degree as f64, knots, &points(&places[..count])) {
                for [x, y] in curve.line() {
                    prop_assert!(columns.contains(&x) && rows.contains(&y), "({}, {})", x, y);
                }
            }
        }
    }
}
