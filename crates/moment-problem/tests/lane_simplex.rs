//! One program a lane: bounds are those of the other solvers, the same for all vectors, and follow from their bases in rational
//! arithmetic.
#![allow(clippy::unwrap_used)]

mod programs;

use moment_problem::Basis;
use moment_problem::fast_simplex::{
    FastFragment, FastSimplex, FastSolution, FastStart, FunctionTable, SupportColumns, SupportDistribution,
    reference_bound,
};
use moment_problem::lane_simplex::{
    BatchSolution, ExactSimplex, FunctionSpan, LaneSimplex, LaneStarts, ProgramBatch,
};
use num_bigint::BigInt;
use programs::workload;

const CELLS: usize = 256;
const TOLERANCE: f64 = 1e-6;

/// Bases of every size that lanes serve, among them the best and the worst conditioned of the default family.
fn bases() -> Vec<Vec<usize>> {
    let mut bases = vec![programs::waves().to_vec(), vec![0, 18, 22, 25], vec![5, 6, 7], vec![35, 36]];
    for m in 1..=4 {
        bases.push((0..m).collect());
        bases.push((0..m).map(|i| (5 * i + 3 * m) % 37).collect());
    }
    bases.extend((0..6).map(|i| programs::subset(37, 4, (2 * i + 1) * 66_045 / 12)));
    bases
}

/// What a basis is solved for, by both solvers.
struct Case {
    kernels: Vec<SupportDistribution>,
    fragments: Vec<FastFragment>,
    table: FunctionTable,
    span: FunctionSpan,
}

impl Case {
    fn new(cells: usize, seed: u64, count: usize) -> Self {
        Self::of(cells, workload(cells, seed, count))
    }

    fn of(cells: usize, (kernels, fragments): (Vec<SupportDistribution>, Vec<FastFragment>)) -> Self {
        let table =
            FunctionTable::new(&Basis::default_family(), &FunctionTable::uniform_depths(cells)).unwrap();
        let span = FunctionSpan::new(&table);
        Self { kernels, fragments, table, span }
    }

    fn batch(&self) -> ProgramBatch<'_> {
        ProgramBatch::new(&self.span, &self.kernels, &self.fragments)
    }

    fn starts(&self, batch: &ProgramBatch<'_>, order: usize) -> LaneStarts {
        let start = |functions: &[usize]| -> FastStart {
            let columns = SupportColumns::new(&self.table, &functions[..order]).unwrap();
            let solver = FastSimplex::new(&columns, TOLERANCE).thorough();
            solver.solve(&self.kernels, &self.fragments).start()
        };
        LaneStarts::new(batch, [&start(&programs::powers()), &start(&programs::waves())], order + 1)
    }

    fn fast(&self, basis: &[usize]) -> FastSolution {
        let columns = SupportColumns::new(&self.table, basis).unwrap();
        FastSimplex::new(&columns, TOLERANCE).solve(&self.kernels, &self.fragments)
    }

    /// With all vectors that there are, which must agree to the bit.
    fn lanes(&self, basis: &[usize]) -> BatchSolution {
        let (batch, columns) = (self.batch(), self.span.columns(basis).unwrap());
        let starts = self.starts(&batch, basis.len());
        let solver = LaneSimplex::new(&columns, TOLERANCE).unwrap();
        let solution = solver.solve(&batch, &starts);
        for (name, solver) in solver.widths() {
            assert!(solver.solve(&batch, &starts) == solution, "{name}: {basis:?}");
        }
        solution
    }
}

#[test]
fn bounds_are_those_of_the_other_solver_with_all_vectors() {
    let mut differing = 0;
    for (cells, count) in [(CELLS, 1500), (64, 700), (1000, 150)] {
        let case = Case::new(cells, 1, count);
        for basis in bases() {
            let (fast, lanes) = (case.fast(&basis), case.lanes(&basis));
            assert_eq!(lanes.lower.len(), case.fragments.len());
            assert!(lanes.uncertified.is_empty(), "{basis:?}: {:?}", lanes.uncertified);
            for (i, (bound, lower)) in fast.bounds.iter().zip(&lanes.lower).enumerate() {
                let fragment = &case.fragments[i];
                let difference = (bound.lower - lower).abs();
                if difference.is_nan() || difference > 2.0 * TOLERANCE {
                    // The other solver lets weights be negative by more.
                    let columns = SupportColumns::new(&case.table, &basis).unwrap();
                    let kernel = &case.kernels[fragment.kernel as usize];
                    let exact = reference_bound(&columns, kernel, fragment.step).unwrap();
                    assert!(
                        (exact - lower).abs() <= 2.0 * TOLERANCE,
                        "{basis:?} {fragment:?}: {exact} and {lower}"
                    );
                    differing += 1;
                }
                assert!(lower - lanes.proved[i] <= TOLERANCE && *lower <= fragment.mass_before + 1e-12);
            }
        }
    }
    assert!(differing <= 3, "{differing}");
}

/// A nearly singular basis that holds both depths of a kernel gave the wrong one of two neighbouring columns the mass, and G = 0
/// for 0.48.
#[test]
fn where_the_solvers_differ_the_lanes_are_right() {
    let case = Case::new(CELLS, 1, 20_000);
    let basis = [22, 27, 30, 36];
    let batch = case.batch();
    let columns = case.span.columns(&basis).unwrap();
    let solution = LaneSimplex::new(&columns, TOLERANCE).unwrap().solve(&batch, &case.starts(&batch, 4));
    let fast = case.fast(&basis);
    let mut differ = 0;
    for (program, (lower, bound)) in solution.lower.iter().zip(&fast.bounds).enumerate() {
        if (lower - bound.lower).abs() > 2.0 * TOLERANCE {
            differ += 1;
            let FastFragment { kernel, step, .. } = case.fragments[program];
            let exact = reference_bound(columns.columns(), &case.kernels[kernel as usize], step).unwrap();
            assert!((lower - exact).abs() <= 2.0 * TOLERANCE, "{program}: {lower:e} for {exact:e}");
        }
    }
    assert!(differ > 0, "nothing was compared");
}

#[test]
fn columns_of_the_span_are_those_of_the_functions() {
    let case = Case::new(CELLS, 2, 50);
    let batch = case.batch();
    assert!(case.span.dimensions() < 36, "{} dimensions", case.span.dimensions());
    for basis in bases() {
        let (direct, columns) =
            (SupportColumns::new(&case.table, &basis).unwrap(), case.span.columns(&basis).unwrap());
        assert_eq!(
            (direct.rank(), direct.dropped()),
            (columns.columns().rank(), columns.columns().dropped())
        );
        for (program, fragment) in case.fragments.iter().enumerate() {
            let kernel = &case.kernels[fragment.kernel as usize];
            let moments = direct.moments(kernel);
            let others = columns.columns().moments(kernel);
            for i in 0..direct.rank() {
                assert!((moments[i] - others[i]).abs() < 1e-14, "{basis:?}: {} {}", moments[i], others[i]);
            }
            let coordinates = batch.coordinates(program);
            for i in 1..direct.rank() {
                let terms = columns.transform().zip(coordinates);
                let moment: f64 = terms.map(|(factor, m)| factor[i - 1] * m).sum();
                assert!((moment - moments[i]).abs() < 1e-14, "{basis:?}: {moment} {}", moments[i]);
            }
        }
    }
}

/// A number as an integer multiple of 2^-SCALE, exactly; below it is none of these columns and weights.
const SCALE: i32 = 220;

fn integer(value: f64) -> BigInt {
    let bits = value.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32;
    if exponent == 0 {
        return BigInt::from(0);
    }
    let mantissa = BigInt::from(bits & ((1 << 52) - 1) | 1 << 52);
    let shift = exponent - 1075 + SCALE;
    assert!(shift >= 0, "{value:e} is too small for the scale");
    let size = mantissa << shift;
    if value < 0.0 { -size } else { size }
}

fn one() -> BigInt {
    BigInt::from(1) << SCALE
}

/// Determinant without divisions that leave a rest (Bareiss).
fn determinant(mut m: Vec<Vec<BigInt>>) -> BigInt {
    let n = m.len();
    let (mut sign, mut before) = (1, BigInt::from(1));
    for k in 0..n {
        let Some(pivot) = (k..n).find(|&i| m[i][k] != BigInt::from(0)) else { return BigInt::from(0) };
        if pivot != k {
            m.swap(pivot, k);
            sign = -sign;
        }
        for i in k + 1..n {
            for j in k + 1..n {
                m[i][j] = (&m[i][j] * &m[k][k] - &m[i][k] * &m[k][j]) / &before;
            }
        }
        before = m[k][k].clone();
    }
    sign * before
}

/// numerator / denominator as a double, for quotients that are small.
fn quotient(numerator: &BigInt, denominator: &BigInt) -> f64 {
    if *denominator == BigInt::from(0) {
        return f64::NAN;
    }
    let scaled: BigInt = (numerator << 80) / denominator;
    scaled.to_string().parse::<f64>().unwrap() / 2f64.powi(80)
}

/// What a basis gives in rational arithmetic: its least weight, the objective of its weights, and by how much its dual vector
/// fails at the worst column.
fn rational(columns: &[Vec<BigInt>], target: &[BigInt], step: u16, support: &[u16]) -> (f64, f64, f64) {
    let rank = support.len();
    let matrix = |replace: Option<(usize, &[BigInt])>| -> Vec<Vec<BigInt>> {
        (0..rank)
            .map(|r| match replace {
                Some((row, by)) if row == r => by.to_vec(),
                Some(_) | None => columns[usize::from(support[r])].clone(),
            })
            .collect()
    };
    let whole = determinant(matrix(None));
    let weights: Vec<BigInt> = (0..rank).map(|r| determinant(matrix(Some((r, target))))).collect();
    let least = weights.iter().map(|w| quotient(w, &whole)).fold(f64::INFINITY, f64::min);
    let is_front = |j: usize| j < usize::from(step);
    let value: BigInt =
        (0..rank).filter(|&r| is_front(usize::from(support[r]))).map(|r| weights[r].clone()).sum();
    let mut excess = 0.0f64;
    for (j, column) in columns.iter().enumerate() {
        // y . a is the objective of the weights that make up the column.
        let front = (0..rank).filter(|&r| is_front(usize::from(support[r])));
        let sum: BigInt = front.map(|r| determinant(matrix(Some((r, column))))).sum();
        let cost = if is_front(j) { whole.clone() } else { BigInt::from(0) };
        excess = excess.max(quotient(&(sum - cost), &whole));
    }
    (least, quotient(&value, &whole), excess)
}

/// Compares a solution with its bases in rational arithmetic, on every so many programs. Returns how many were compared.
fn recheck(case: &Case, basis: &[usize], solution: &BatchSolution, every: usize) -> usize {
    let columns = SupportColumns::new(&case.table, basis).unwrap();
    let unit = |j: u16| {
        SupportDistribution::snapped([(f64::from(j) / CELLS as f64, 1.0)].into_iter(), CELLS, &mut Vec::new())
    };
    let exact: Vec<Vec<BigInt>> = (0..columns.depths() as u16)
        .map(|j| columns.moments(&unit(j))[..columns.rank()].iter().map(|&a| integer(a)).collect())
        .collect();
    let simplex = ExactSimplex::new(&columns);
    let mut compared = 0;
    for (program, fragment) in case.fragments.iter().enumerate().step_by(every) {
        let kernel = &case.kernels[fragment.kernel as usize];
        let mut target = vec![BigInt::from(0); columns.rank()];
        for (&j, &weight) in kernel.indices().iter().zip(kernel.weights()) {
            for (sum, a) in target.iter_mut().zip(&exact[usize::from(j)]) {
                *sum += (integer(weight) * a) >> SCALE;
            }
        }
        let support = &solution.supports[program * solution.rank..][..solution.rank];
        let (least, value, excess) = rational(&exact, &target, fragment.step, support);
        let (lower, proved) = (solution.lower[program], solution.proved[program]);
        // The basis proves value - excess from below; that no bound is negative needs no proof.
        let shown = proved == 0.0 || proved <= value - excess + 1e-7;
        assert!(shown, "{basis:?} {fragment:?}: {proved} is not proved by {support:?}");
        if proved < fragment.mass_before - TOLERANCE {
            // Its weights attain the value, if none is negative. Where one is, by rounding, the optimum says by how much that
            // may be wrong.
            let value = if least >= 0.0 && value.is_finite() {
                value
            } else {
                let optimum = simplex.bound(kernel, fragment.step, fragment.mass_before, support).unwrap();
                let (least, value, excess) = rational(&exact, &target, fragment.step, &optimum.support);
                // Columns may be equal, those of both ends for functions of period 1: then fewer than five are enough.
                if value.is_nan() {
                    optimum.lower
                } else {
                    assert!(
                        least >= -1e-20 && excess <= 1e-10,
                        "{basis:?} {fragment:?}: {least:e} {excess:e}"
                    );
                    value
                }
            };
            assert!((lower - value).abs() <= 2.0 * TOLERANCE, "{basis:?} {fragment:?}: {lower} and {value}");
        }
        compared += 1;
    }
    assert_eq!(one() >> SCALE, BigInt::from(1));
    compared
}

#[test]
fn a_thousand_bounds_follow_from_their_bases_in_rational_arithmetic() {
    let case = Case::new(CELLS, 3, 400);
    let mut compared = 0;
    for basis in bases().into_iter().filter(|basis| basis.len() == 4) {
        let mut solution = case.lanes(&basis);
        compared += recheck(&case, &basis, &solution, 9);
        // The check notices a bound that promises too much, and a basis that is another one.
        let place = solution.lower.iter().step_by(9).position(|&lower| lower > 0.1).unwrap() * 9;
        let right = solution.clone();
        solution.proved[place] += 1e-5;
        assert!(std::panic::catch_unwind(|| recheck(&case, &basis, &solution, 9)).is_err());
        solution = right;
        solution.supports[place * 5 + 4] = if solution.supports[place * 5 + 4] == 256 { 255 } else { 256 };
        assert!(std::panic::catch_unwind(|| recheck(&case, &basis, &solution, 9)).is_err());
    }
    assert!(compared >= 1000, "{compared}");
}

#[test]
fn narrow_kernels_are_solved_in_rational_arithmetic() {
    let case = Case::of(CELLS, programs::narrow(3000));
    let mut compared = 0;
    for functions in [["z^2", "z^8", "exp(-2z)", "cos(3pi z)"], ["z^4", "z^6", "z^7", "z^8"]] {
        let place = |name: &str| {
            let function = name.parse().unwrap();
            Basis::default_family().iter().position(|other| *other == function).unwrap()
        };
        let basis = functions.map(place);
        let solution = case.lanes(&basis);
        assert!(solution.uncertified.is_empty() && solution.exact > 0);
        compared += recheck(&case, &basis, &solution, 10);
    }
    assert!(compared >= 600, "{compared}");
}

#[test]
fn bases_of_more_functions_are_refused() {
    let case = Case::new(64, 4, 2);
    let columns = case.span.columns(&[0, 1, 2, 3, 20]).unwrap();
    assert!(LaneSimplex::new(&columns, TOLERANCE).is_none());
}
