//! What must hold of swarms on every map.
#![allow(clippy::unwrap_used)]

use planning::{
    grid::{Cell, Grid},
    moves::MoveSet,
    parking::{CellSize, Lot},
    search::{AStar, Planner, SearchError, Workspace as SearchWorkspace},
    swarm::{Algorithm, Convergence, Fitness, Settings, Swarm, Weights, Workspace},
};
use proptest::{prelude::*, sample::Index};

const ALGORITHMS: [Algorithm; 5] = [
    Algorithm::Gwo,
    Algorithm::Pso,
    Algorithm::IGWO,
    Algorithm::ASTAR_IGWO,
    Algorithm::Igwo { convergence: Convergence::Late, fitness: Fitness::Goal(Weights::HALF) },
];

/// A map of random cells, down to one row or column.
fn maps() -> impl Strategy<Value = Grid> {
    (1u32..24, 1u32..24).prop_flat_map(|(width, height)| {
        prop::collection::vec(prop::bool::weighted(0.8), (width * height) as usize).prop_map(move |cells| {
            let mut grid = Grid::blocked(width, height).unwrap();
            cells.into_iter().enumerate().for_each(|(index, free)| grid.set(grid.cell(index), free));
            grid
        })
    })
}

fn settings() -> impl Strategy<Value = Settings> {
    (1u16..7, 1u32..25, 0u16..9).prop_map(|(population, iterations, nodes)| Settings {
        population: population.try_into().unwrap(),
        iterations: iterations.try_into().unwrap(),
        nodes,
    })
}

proptest! {
    #[test]
    fn a_swarm_finds_a_path_where_there_is_one_and_it_can_be_walked(
        grid in maps(), from in any::<Index>(), to in any::<Index>(), settings in settings(), seed in any::<u64>(),
    ) {
        let (from, to) = (grid.cell(from.index(grid.len())), grid.cell(to.index(grid.len())));
        let mut searched = SearchWorkspace::default();
        let shortest = AStar::new(&grid, MoveSet::Eight).plan(from, to, &mut searched);
        let mut workspace = Workspace::default();
        for algorithm in ALGORITHMS {
            let swarm = Swarm { grid: &grid, algorithm, settings, seed };
            match (swarm.hunt(from, to, &mut workspace), &shortest) {
                (Ok(hunt), Ok(shortest)) => {
                    prop_assert!(hunt.path.is_walkable(&grid, MoveSet::Eight));
                    prop_assert_eq!((hunt.path.start(), hunt.path.end()), (from, to));
                    prop_assert!(hunt.path.length() >= shortest.path.length());
                    prop_assert!(hunt.length_cells <= hunt.path.length().units() + 1e-9);
                    prop_assert_eq!(hunt.curve.len(), settings.iterations.get() as usize);
                    prop_assert!(hunt.curve.is_sorted_by(|before, after| before >= after));
                    prop_assert!(hunt.curve.iter().all(|fitness| fitness.is_finite()));
                    prop_assert!((1..=settings.iterations.get()).contains(&hunt.iterations()));
                }
                (Err(ours), Err(theirs)) => prop_assert_eq!(&ours, theirs),
                (ours, theirs) => prop_assert!(false, "{:?}, but A* {:?}", ours.map(|hunt| hunt.length_cells), theirs),
            }
        }
    }
}

#[test]
fn walls_and_wrong_ends_have_their_own_errors() {
    let mut grid = Grid::open(5, 3);
    (0..3).for_each(|y| grid.set((2, y).into(), false));
    for algorithm in ALGORITHMS {
        let swarm = Swarm::new(&grid, algorithm, 1);
        let error = |from: (i32, i32), to: (i32, i32)| {
            swarm
                .plan(from.into(), to.into(), &mut Workspace::default())
                .map(|plan| plan.expanded)
                .unwrap_err()
        };
        let (from, to): (Cell, Cell) = ((0, 0).into(), (4, 0).into());
        assert_eq!(error((0, 0), (4, 0)), SearchError::NoPath { from, to });
        assert_eq!(error((0, 0), (2, 1)), SearchError::Blocked { cell: (2, 1).into() });
        assert!(matches!(error((0, -1), (4, 0)), SearchError::Outside { .. }));
    }
}

#[test]
fn a_seed_has_one_answer_whatever_the_workspace_was_used_for_before() {
    let mut used = Workspace::default();
    for (cars, seed) in [(40, 1), (30, 2), (20, 3)] {
        for size in CellSize::ALL {
            let lot = Lot::parked(size, cars, seed);
            let to = lot.stop(*lot.cars().last().unwrap());
            for algorithm in ALGORITHMS {
                let swarm = Swarm::new(lot.grid(), algorithm, seed);
                let mut fresh = Workspace::default();
                let hunt = swarm.hunt(lot.cabin(), to, &mut fresh).unwrap();
                let again = swarm.hunt(lot.cabin(), to, &mut used).unwrap();
                assert_eq!((hunt.path, hunt.turns, hunt.curve), (again.path, again.turns, again.curve));
            }
        }
    }
}

#[test]
fn a_seed_has_the_answer_it_always_had_on_every_machine() {
    let lot = Lot::parked(CellSize::M1_30, 35, 1);
    let to = lot.stop(*lot.cars().last().unwrap());
    let mut workspace = Workspace::default();
    let mut answer = |algorithm: Algorithm, seed: u64| {
        let hunt = Swarm::new(lot.grid(), algorithm, seed).hunt(lot.cabin(), to, &mut workspace).unwrap();
        (hunt.iterations(), hunt.length_cells)
    };
    let answers = ALGORITHMS.map(|algorithm| [1, 2].map(|seed| answer(algorithm, seed)));
    // To the last bit.
    let pinned = [
        [(94, 36.33420817654564), (1, 39.071067811865476)],
        [(19, 36.06374439217422), (93, 37.384402799378826)],
        [(1, 36.10544360778351), (1, 35.747892009580966)],
        [(51, 35.747892009580966), (1, 35.747892009580966)],
        [(93, 35.747892009580966), (1, 35.747892009580966)],
    ];
    assert_eq!(answers, pinned);
}
