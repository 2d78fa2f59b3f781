//! The fast solver against the double-double route, against its own certificates, and against theorems.
#![allow(clippy::unwrap_used)]

mod programs;

use moment_problem::fast_simplex::{
    FastFragment, FastSimplex, FastSolution, FunctionTable, SupportColumns, SupportDistribution,
    reference_bound,
};
use moment_problem::{Basis, BasisFunction, Hausdorff4, LowerBound, LpSolver};
use programs::workload;

const CELLS: usize = 64;
const TOLERANCE: f64 = 1e-6;

fn table(functions: &[BasisFunction]) -> FunctionTable {
    FunctionTable::new(functions, &FunctionTable::uniform_depths(CELLS)).unwrap()
}

/// Bases of every size, from the best to the worst conditioned of the default family.
fn bases() -> Vec<Vec<usize>> {
    let mut bases =
        vec![vec![0], vec![0, 1], vec![29, 30, 33, 34], vec![0, 18, 22, 25], vec![35, 36], vec![5, 6, 7]];
    for m in 1..=8 {
        bases.push((0..m).collect());
        bases.push((0..m).map(|i| (5 * i + 3 * m) % 37).collect());
    }
    bases
}

#[test]
fn bounds_are_those_of_the_double_double_route_for_every_size() {
    let table = table(&Basis::default_family());
    let (kernels, fragments) = workload(CELLS, 1, 40);
    for basis in bases() {
        let columns = SupportColumns::new(&table, &basis).unwrap();
        let solution = FastSimplex::new(&columns, TOLERANCE).solve(&kernels, &fragments);
        assert!(solution.uncertified.is_empty(), "{basis:?}: {:?}", solution.uncertified);
        for (fragment, bound) in fragments.iter().zip(&solution.bounds).step_by(3) {
            let kernel = &kernels[fragment.kernel as usize];
            let reference = reference_bound(&columns, kernel, fragment.step).unwrap();
            let difference = (bound.lower - reference).abs();
            assert!(
                difference <= 1.01 * TOLERANCE,
                "{basis:?} {fragment:?}: {} and {reference}",
                bound.lower
            );
            assert!(bound.lower_proved <= reference + 1e-9 && bound.lower <= fragment.mass_before + 1e-12);
        }
    }
}

/// Checks every bound with nothing but its certificate and the columns: the dual vector must be feasible up to what it
/// says it lacks, and its value must be what is proved.
fn check_certificates(
    columns: &SupportColumns,
    kernels: &[SupportDistribution],
    fragments: &[FastFragment],
    solution: &FastSolution,
) {
    for (fragment, bound) in fragments.iter().zip(&solution.bounds) {
        let vertex = &solution.vertices[bound.vertex as usize];
        assert_eq!(vertex.step, fragment.step);
        for j in 0..columns.depths() {
            let excess = vertex.excess(columns, j);
            assert!(excess <= vertex.lacking + 1e-15, "{fragment:?} at {j}: {excess} > {}", vertex.lacking);
        }
        let kernel = &kernels[fragment.kernel as usize];
        let value: f64 = kernel
            .indices()
            .iter()
            .zip(kernel.weights())
            .map(|(&j, w)| {
                let cost = if j < fragment.step { 1.0 } else { 0.0 };
                w * (vertex.excess(columns, usize::from(j)) + cost)
            })
            .sum();
        // Sums of terms of both signs as large as the dual function.
        let size = (0..columns.depths()).map(|j| vertex.excess(columns, j).abs()).fold(1.0, f64::max);
        assert!(bound.lower_proved <= (value - vertex.lacking).max(0.0) + 1e-14 * size, "{fragment:?}");
        assert!((0.0..=1.0 + 1e-12).contains(&bound.lower) && bound.lower - bound.lower_proved <= TOLERANCE);
    }
}

#[test]
fn every_bound_follows_from_its_certificate() {
    let table = table(&Basis::default_family());
    let (kernels, fragments) = workload(CELLS, 2, 60);
    for basis in bases() {
        let columns = SupportColumns::new(&table, &basis).unwrap();
        let mut solution = FastSimplex::new(&columns, TOLERANCE).solve(&kernels, &fragments);
        check_certificates(&columns, &kernels, &fragments, &solution);
        // The check notices a dual vector that promises too much.
        let vertex = solution.bounds[fragments.len() / 2].vertex as usize;
        solution.vertices[vertex].dual[0] += 1e-3;
        let planted =
            std::panic::catch_unwind(|| check_certificates(&columns, &kernels, &fragments, &solution));
        assert!(planted.is_err(), "{basis:?}");
    }
}

#[test]
fn vector_width_start_and_order_change_nothing_that_matters() {
    let table = table(&Basis::default_family());
    let (kernels, fragments) = workload(CELLS, 3, 60);
    for basis in bases() {
        let columns = SupportColumns::new(&table, &basis).unwrap();
        let solver = FastSimplex::new(&columns, TOLERANCE);
        let solution = solver.solve(&kernels, &fragments);
        let portable = solver.portable().solve(&kernels, &fragments);
        assert_eq!((&solution.bounds, solution.pivots), (&portable.bounds, portable.pivots), "{basis:?}");
        // From the solution of power moments.
        let power: Vec<usize> = (0..basis.len()).collect();
        let other = SupportColumns::new(&table, &power).unwrap();
        let other = FastSimplex::new(&other, TOLERANCE).thorough().solve(&kernels, &fragments);
        let near = solver.solve_near(&kernels, &fragments, &[&other.start()]);
        check_certificates(&columns, &kernels, &fragments, &near);
        let mut reversed = fragments.clone();
        reversed.reverse();
        let mut backwards = solver.solve(&kernels, &reversed).bounds;
        backwards.reverse();
        for (i, bound) in solution.bounds.iter().enumerate() {
            for other in [&near.bounds[i], &backwards[i]] {
                assert!(
                    (bound.lower - other.lower).abs() <= 1.01 * TOLERANCE,
                    "{basis:?} {:?}",
                    fragments[i]
                );
            }
        }
    }
}

#[test]
fn more_functions_never_lower_a_bound_and_dependent_ones_change_none() {
    let functions: Vec<BasisFunction> =
        ["z", "z^2", "sin(3pi z)", "exp(-2z)", "(z+1)^2"].map(|f| f.parse().unwrap()).into();
    let table = table(&functions);
    let (kernels, fragments) = workload(CELLS, 4, 80);
    let solve = |basis: &[usize]| {
        let columns = SupportColumns::new(&table, basis).unwrap();
        FastSimplex::new(&columns, TOLERANCE).solve(&kernels, &fragments).bounds
    };
    let sizes: Vec<_> = (1..=4).map(|m| solve(&(0..m).collect::<Vec<_>>())).collect();
    for pair in sizes.windows(2) {
        assert!(pair[0].iter().zip(&pair[1]).all(|(few, more)| few.lower <= more.lower + 2.0 * TOLERANCE));
    }
    let columns = SupportColumns::new(&table, &[0, 1, 4]).unwrap();
    assert_eq!((columns.rank(), columns.dropped()), (3, &[4][..]));
    for (a, b) in solve(&[0, 1]).iter().zip(solve(&[0, 1, 4])) {
        assert!((a.lower - b.lower).abs() <= 2.0 * TOLERANCE);
    }
}

#[test]
fn a_support_bound_is_above_the_bound_on_the_interval() {
    let table = table(Basis::power(4).functions());
    let columns = SupportColumns::new(&table, &[0, 1, 2, 3]).unwrap();
    let (kernels, fragments) = workload(CELLS, 5, 30);
    let solution = FastSimplex::new(&columns, TOLERANCE).solve(&kernels, &fragments);
    let depth = |j: u16| f64::from(j) / CELLS as f64;
    for (fragment, bound) in fragments.iter().zip(&solution.bounds) {
        let kernel = &kernels[fragment.kernel as usize];
        let depths: Vec<f64> = kernel.indices().iter().map(|&j| depth(j)).collect();
        let z = moment_problem::DepthDistribution::new(&depths, kernel.weights()).unwrap();
        // Closed forms refuse what lies on the boundary of the moment space to rounding.
        let Ok(interval) = Hausdorff4::new().unwrap().bounds_of(&z, depth(fragment.step)) else { continue };
        assert!(bound.lower >= interval.certificate.lower_proved - 2.0 * TOLERANCE, "{fragment:?}");
        assert!(bound.lower <= interval.lower + 0.2, "{fragment:?}: {} and {}", bound.lower, interval.lower);
    }
}

#[test]
fn a_general_solver_agrees_where_it_has_an_answer() {
    let table = table(&Basis::default_family());
    let columns = SupportColumns::new(&table, &[29, 30, 33, 34]).unwrap();
    let (kernels, fragments) = workload(CELLS, 6, 20);
    let solution = FastSimplex::new(&columns, TOLERANCE).solve(&kernels, &fragments);
    let mut agreed = 0;
    for (fragment, bound) in fragments.iter().zip(&solution.bounds) {
        let kernel = &kernels[fragment.kernel as usize];
        let answer =
            moment_problem::fast_simplex::good_lp_bound(&columns, kernel, fragment.step, LpSolver::Microlp);
        agreed += usize::from(answer.is_ok_and(|value| (value - bound.lower).abs() < 1e-5));
    }
    // It is known to be wrong in up to a tenth of all cases.
    assert!(agreed * 10 >= fragments.len() * 8, "{agreed} of {}", fragments.len());
}
