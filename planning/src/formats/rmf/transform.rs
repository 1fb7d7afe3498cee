//! Levels of a building over each other.

use crate::floor_plan::Point;

/// A turn, a scale and a shift that keep shapes: `z -> turn z + shift` on complex numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Similarity {
    turn: Point,
    shift: Point,
}

impl Similarity {
    /// Only a scale.
    pub(super) const fn scale(factor: f64) -> Self {
        Self { turn: [factor, 0.0], shift: [0.0; 2] }
    }

    /// The one that brings the first of each pair as near as possible to the second (least squares);
    /// none if the first are not two points at least.
    pub(super) fn between(pairs: &[(Point, Point)]) -> Option<Self> {
        let count = pairs.len() as f64;
        let mean = |of: fn(&(Point, Point)) -> Point| {
            let sum = pairs.iter().map(of).fold([0.0; 2], add);
            sum.map(|sum| sum / count)
        };
        let (from, to) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let (mut product, mut square) = ([0.0; 2], 0.0);
        for &(one, other) in pairs {
            let (one, other) = (sub(one, from), sub(other, to));
            // The conjugate of `one` times `other`.
            product =
                add(product, [one[0] * other[0] + one[1] * other[1], one[0] * other[1] - one[1] * other[0]]);
            square += one[0] * one[0] + one[1] * one[1];
        }
        let turn = product.map(|part| part / square);
        let sound = turn.iter().all(|part| part.is_finite()) && turn != [0.0; 2];
        sound.then(|| Self { turn, shift: sub(to, multiplied(turn, from)) })
    }

    pub(super) fn apply(self, point: Point) -> Point {
        add(multiplied(self.turn, point), self.shift)
    }
}

fn add(one: Point, other: Point) -> Point {
    [one[0] + other[0], one[1] + other[1]]
}

fn sub(one: Point, other: Point) -> Point {
    [one[0] - other[0], one[1] - other[1]]
}

fn multiplied(one: Point, other: Point) -> Point {
    [one[0] * other[0] - one[1] * other[1], one[0] * other[1] + one[1] * other[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_scaled_and_shifted_triangle_is_brought_back() {
        // Twice as large, turned by a right angle, moved by (5, -1).
        let moved = |[x, y]: Point| [5.0 - 2.0 * y, -1.0 + 2.0 * x];
        let pairs = [[1.0, 2.0], [4.0, 2.0], [3.0, 7.0]].map(|point| (point, moved(point)));
        let found = Similarity::between(&pairs).unwrap();
        let [x, y] = found.apply([-3.0, 0.5]);
        assert!((x - 4.0).abs() < 1e-9 && (y + 7.0).abs() < 1e-9, "({x}, {y})");
        assert_eq!(Similarity::between(&pairs[..1]), None);
    }
}
