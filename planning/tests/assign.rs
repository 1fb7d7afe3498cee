//! The best matching is the best: against brute force, against the crate `lapjv`, and after changes
//! against a fresh solution.
#![allow(clippy::unwrap_used)]

use planning::assign::{Assignment, PairCost};
use proptest::{prelude::*, sample::Index};

type Costs = Vec<Vec<Option<PairCost>>>;

fn solved(costs: &Costs, columns: usize) -> Assignment {
    let mut assignment = Assignment::default();
    assignment.solve(costs.len(), columns, |row, column| costs[row][column]);
    assignment
}

/// The most pairs, then the least cost, by trying all matchings: `(pairs, cost)`.
fn brute_force(costs: &[Vec<Option<PairCost>>], taken: &mut Vec<bool>) -> (usize, u64) {
    let Some((row, rest)) = costs.split_first() else { return (0, 0) };
    let mut best = brute_force(rest, taken);
    for (column, cost) in row.iter().enumerate() {
        if let (Some(cost), false) = (cost, taken[column]) {
            taken[column] = true;
            let (pairs, rest) = brute_force(rest, taken);
            taken[column] = false;
            let new = (pairs + 1, rest + u64::from(*cost));
            if new.0 > best.0 || (new.0 == best.0 && new.1 < best.1) {
                best = new;
            }
        }
    }
    best
}

/// Pairs and cost, after checking that both sides tell the same and that no pair is impossible.
fn outcome(assignment: &Assignment, costs: &Costs) -> (usize, u64) {
    let pairs: Vec<_> = assignment.pairs().collect();
    let mut total = 0;
    for &(row, column) in &pairs {
        assert_eq!((assignment.of_row(row), assignment.of_column(column)), (Some(column), Some(row)));
        total += u64::from(costs[row][column].unwrap());
    }
    let columns = costs.first().map_or(0, Vec::len);
    assert_eq!((0..columns).filter_map(|column| assignment.of_column(column)).count(), pairs.len());
    assert_eq!(assignment.cost(), total);
    (pairs.len(), total)
}

/// What a pair costs: impossible, one of a few (so that there are ties), or any.
fn cost() -> impl Strategy<Value = Option<PairCost>> {
    prop_oneof![2 => Just(None), 3 => (0..4u32).prop_map(Some), 2 => any::<u32>().prop_map(Some)]
}

fn matrices(rows: usize, columns: usize) -> impl Strategy<Value = (Costs, usize)> {
    (0..=rows, 0..=columns).prop_flat_map(|(rows, columns)| {
        prop::collection::vec(prop::collection::vec(cost(), columns), rows)
            .prop_map(move |costs| (costs, columns))
    })
}

#[derive(Clone, Debug)]
enum Change {
    Row(Index, Vec<Option<PairCost>>),
    Column(Index, Vec<Option<PairCost>>),
}

fn changes(side: usize) -> impl Strategy<Value = Vec<Change>> {
    let new = || prop::collection::vec(cost(), side);
    let change = prop_oneof![
        (any::<Index>(), new()).prop_map(|(row, new)| Change::Row(row, new)),
        (any::<Index>(), new()).prop_map(|(column, new)| Change::Column(column, new)),
    ];
    prop::collection::vec(change, 1..30)
}

proptest! {
    #[test]
    fn no_matching_has_more_pairs_or_costs_less((costs, columns) in matrices(6, 6)) {
        let best = brute_force(&costs, &mut vec![false; columns]);
        prop_assert_eq!(outcome(&solved(&costs, columns), &costs), best);
    }

    #[test]
    fn a_large_matrix_costs_what_lapjv_finds(
        side in 1usize..60, spread in 1u32..10_000, numbers in prop::collection::vec(any::<u32>(), 3600),
    ) {
        let row = |row: &[u32]| row.iter().map(|number| Some(number % spread)).collect();
        let costs: Costs = numbers.chunks_exact(side).take(side).map(row).collect();
        let matrix = lapjv::Matrix::from_shape_fn((side, side), |(row, column)| {
            f64::from(costs[row][column].unwrap())
        });
        let (of_row, _) = lapjv::lapjv(&matrix).unwrap();
        let theirs = lapjv::cost(&matrix, &of_row) as u64;
        prop_assert_eq!(outcome(&solved(&costs, side), &costs), (side, theirs));
    }

    #[test]
    fn after_any_changes_it_is_as_good_as_a_fresh_solution(
        (mut costs, columns) in matrices(12, 12), changes in changes(12),
    ) {
        prop_assume!(!costs.is_empty() && columns > 0);
        let mut assignment = solved(&costs, columns);
        for change in changes {
            match change {
                Change::Row(row, new) => {
                    let row = row.index(costs.len());
                    costs[row].copy_from_slice(&new[..columns]);
                    assignment.set_row(row, |column| new[column]);
                }
                Change::Column(column, new) => {
                    let column = column.index(columns);
                    for (costs, &new) in costs.iter_mut().zip(&new) {
                        costs[column] = new;
                    }
                    assignment.set_column(column, |row| new[row]);
                }
            }
            prop_assert_eq!(outcome(&assignment, &costs), outcome(&solved(&costs, columns), &costs));
        }
    }

    #[test]
    fn the_same_calls_give_the_same_matching((costs, columns) in matrices(9, 9)) {
        let mut used = solved(&vec![vec![Some(3); 5]; 7], 5);
        used.solve(costs.len(), columns, |row, column| costs[row][column]);
        prop_assert!(used.pairs().eq(solved(&costs, columns).pairs()));
    }
}

#[test]
fn costs_at_the_upper_end_do_not_outweigh_a_pair() {
    // One pair for nothing or two for all that can be asked: two it is.
    let costs = vec![vec![Some(0), Some(u32::MAX)], vec![Some(u32::MAX), None]];
    assert_eq!(outcome(&solved(&costs, 2), &costs), (2, 2 * u64::from(u32::MAX)));
}

#[test]
fn rows_and_columns_outside_are_ignored() {
    let mut assignment = solved(&vec![vec![Some(1)]], 1);
    assignment.set_row(1, |_| None);
    assignment.set_column(1, |_| None);
    assert_eq!((assignment.of_row(0), assignment.of_row(9), assignment.of_column(9)), (Some(0), None, None));
}

proptest! {
    #[test]
    fn a_pair_that_becomes_cheaper_by_less_than_its_margin_improves_nothing(
        (mut costs, columns) in matrices(6, 6), row in any::<Index>(), column in any::<Index>(),
    ) {
        prop_assume!(!costs.is_empty() && columns > 0);
        let (row, column) = (row.index(costs.len()), column.index(columns));
        let before = solved(&costs, columns);
        let margin = before.margin(row, column);
        prop_assert_eq!(margin.is_some(), costs[row][column].is_some());
        let Some(cost) = costs[row][column] else { return Ok(()) };
        let margin = margin.unwrap_or_default();
        if before.of_row(row) == Some(column) {
            prop_assert_eq!(margin, 0);
        }
        let cheaper = u64::from(cost).min(margin);
        costs[row][column] = Some(cost - PairCost::try_from(cheaper).unwrap());
        prop_assert_eq!(outcome(&solved(&costs, columns), &costs), outcome(&before, &costs_before(&costs, row, column, cost)));
    }
}

fn costs_before(costs: &Costs, row: usize, column: usize, cost: PairCost) -> Costs {
    let mut before = costs.clone();
    before[row][column] = Some(cost);
    before
}
