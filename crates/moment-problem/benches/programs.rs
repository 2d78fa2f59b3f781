//! Programs a second of both solvers in one process, over candidates spread evenly over the 4-subsets of the default family.
//!
//! Programs come from the file that `MSM_PROGRAMS` names, or are made up. `MSM_CANDIDATES`, `MSM_REPETITIONS`: how many;
//! `MSM_NUMBER`: this candidate only;
//! `MSM_GOOD_LP`: programs a candidate for the solvers behind good_lp, with `--features highs` for HiGHS, too. Times are
//! those of the one thread that works, where the system tells them.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use moment_problem::fast_simplex::{
    FastFragment, FastSimplex, FastStart, FunctionTable, SupportColumns, SupportDistribution, good_lp_bound,
    reference_bound,
};
use moment_problem::lane_simplex::{FunctionSpan, LaneSimplex, LaneStarts, ProgramBatch};
use moment_problem::{Basis, LpSolver};
use std::time::Instant;

#[path = "../tests/programs/mod.rs"]
mod programs;

const CELLS: usize = 256;
const TOLERANCE: f64 = 1e-6;

/// Seconds that this thread has worked.
fn seconds(start: &Instant) -> f64 {
    let known = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let first = known.as_ref().and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    first.map_or_else(|| start.elapsed().as_secs_f64(), |nanoseconds| nanoseconds * 1e-9)
}

fn main() {
    let clock = Instant::now();
    let candidates = variable("MSM_CANDIDATES", 30);
    let repetitions = variable("MSM_REPETITIONS", 1);
    let libraries = variable("MSM_GOOD_LP", 100);
    let (kernels, fragments) = match std::env::var_os("MSM_PROGRAMS") {
        Some(path) => programs::read(path.as_ref()),
        None => programs::workload(CELLS, 1, 20_000),
    };
    let table = FunctionTable::new(&Basis::default_family(), &FunctionTable::uniform_depths(CELLS)).unwrap();
    let span = FunctionSpan::new(&table);
    let batch = ProgramBatch::new(&span, &kernels, &fragments);
    let start = |functions: [usize; 4]| -> FastStart {
        let columns = SupportColumns::new(&table, &functions).unwrap();
        FastSimplex::new(&columns, TOLERANCE).thorough().solve(&kernels, &fragments).start()
    };
    let given = [start(programs::powers()), start(programs::waves())];
    let starts = LaneStarts::new(&batch, [&given[0], &given[1]], 5);
    println!("{} programs, {} dimensions", batch.len(), span.dimensions());
    let mut rates: Vec<Rate> = Vec::new();
    for i in 0..candidates {
        let number = match std::env::var("MSM_NUMBER") {
            Ok(text) => text.parse().unwrap(),
            Err(_) => (2 * i + 1) * 66_045 / (2 * candidates),
        };
        let members = programs::subset(37, 4, number);
        let mut line = format!("{number:6} {members:?}");
        for _ in 0..repetitions {
            let before = seconds(&clock);
            let columns = SupportColumns::new(&table, &members).unwrap();
            let solution = FastSimplex::new(&columns, TOLERANCE).solve_near(
                &kernels,
                &fragments,
                &[&given[0], &given[1]],
            );
            let time = seconds(&clock) - before;
            note(&mut rates, "FastSimplex", batch.len(), time, solution.exact, 0);
            line += &format!(" fast {:.3}", batch.len() as f64 / time * 1e-6);
            let fast = solution;
            let widths =
                LaneSimplex::new(&span.columns(&members).unwrap(), TOLERANCE).unwrap().widths().count();
            for width in 0..widths - 1 {
                let before = seconds(&clock);
                let columns = span.columns(&members).unwrap();
                let (name, solver) =
                    LaneSimplex::new(&columns, TOLERANCE).unwrap().widths().nth(width).unwrap();
                let solution = solver.solve(&batch, &starts);
                let time = seconds(&clock) - before;
                let bounds = &fast.bounds;
                let differences = solution.lower.iter().zip(bounds).map(|(a, b)| (a - b.lower).abs());
                for (program, (lower, bound)) in solution.lower.iter().zip(bounds).enumerate() {
                    if is_off(lower - bound.lower) {
                        let FastFragment { kernel, step, mass_before } = fragments[program];
                        let kernel = &kernels[kernel as usize];
                        let reference = reference_bound(columns.columns(), kernel, step);
                        println!(
                            "{lower} (proved {}), FastSimplex {} (proved {}), double-double {reference:?}: {:?} {:?} \
                             step {step} F {mass_before} {:?}",
                            solution.proved[program],
                            bound.lower,
                            bound.lower_proved,
                            kernel.indices(),
                            kernel.weights(),
                            &solution.supports[5 * program..][..5]
                        );
                    }
                }
                let wrong = differences.clone().filter(|d| is_off(*d)).count() + solution.uncertified.len();
                line += &format!(
                    " {} {:.3} (exact {} pivots {:.2} worst {:.1e} wrong {wrong})",
                    &name[..7],
                    batch.len() as f64 / time * 1e-6,
                    solution.exact,
                    solution.pivots as f64 / batch.len() as f64,
                    differences.fold(0.0, f64::max)
                );
                note(&mut rates, name, batch.len(), time, solution.exact, wrong);
            }
        }
        let columns = SupportColumns::new(&table, &members).unwrap();
        through_good_lp(&columns, &kernels, &fragments, (&clock, libraries), &mut rates);
        println!("{line}");
    }
    let first = rates[0].programs as f64 / rates[0].seconds;
    for Rate { name, programs, seconds, exact, wrong } in &rates {
        let rate = *programs as f64 / seconds;
        println!(
            "{name}: {:.6} M programs/s (harmonic mean), {:.4} % exact, {wrong} of {programs} wrong or uncertified, {:.5} x",
            rate * 1e-6,
            *exact as f64 / *programs as f64 * 100.0,
            rate / first
        );
    }
}

/// The solvers behind good_lp on so many programs, evenly spread; an answer that is not the double-double method's is wrong.
fn through_good_lp(
    columns: &SupportColumns,
    kernels: &[SupportDistribution],
    fragments: &[FastFragment],
    (clock, count): (&Instant, usize),
    rates: &mut Vec<Rate>,
) {
    let count = count.min(fragments.len());
    let chosen: Vec<&FastFragment> =
        (0..count).map(|i| &fragments[(2 * i + 1) * fragments.len() / (2 * count)]).collect();
    let kernel = |fragment: &FastFragment| &kernels[fragment.kernel as usize];
    let exact: Vec<f64> =
        chosen.iter().map(|f| reference_bound(columns, kernel(f), f.step).unwrap_or(f64::NAN)).collect();
    for (name, solver) in [
        ("good_lp with microlp", LpSolver::Microlp),
        ("good_lp with clarabel", LpSolver::Clarabel),
        #[cfg(feature = "highs")]
        ("good_lp with HiGHS", LpSolver::Highs),
    ] {
        let before = seconds(clock);
        let found: Vec<f64> = chosen
            .iter()
            .map(|f| good_lp_bound(columns, kernel(f), f.step, solver).unwrap_or(f64::NAN))
            .collect();
        let time = seconds(clock) - before;
        let wrong = found.iter().zip(&exact).filter(|(a, b)| is_off(*a - *b)).count();
        note(rates, name, count, time, 0, wrong);
    }
}

/// What a solver took for all candidates.
struct Rate {
    name: String,
    programs: usize,
    seconds: f64,
    exact: usize,
    wrong: usize,
}

fn note(rates: &mut Vec<Rate>, name: &str, programs: usize, seconds: f64, exact: usize, wrong: usize) {
    if !rates.iter().any(|rate| rate.name == name) {
        rates.push(Rate { name: name.to_owned(), programs: 0, seconds: 0.0, exact: 0, wrong: 0 });
    }
    for rate in rates.iter_mut().filter(|rate| rate.name == name) {
        rate.programs += programs;
        rate.seconds += seconds;
        rate.exact += exact;
        rate.wrong += wrong;
    }
}

fn variable(name: &str, default: usize) -> usize {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Whether bounds differ; NaN does.
fn is_off(difference: f64) -> bool {
    difference.is_nan() || difference.abs() > 2e-6
}
