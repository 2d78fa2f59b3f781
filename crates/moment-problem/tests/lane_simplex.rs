//! One program a lane: bounds are those of the other solvers, whatever the vectors, and follow from their certificates.

mod programs;

use moment_problem::fast_simplex::{FastSimplex, FastStart, FunctionTable, SupportColumns};
use moment_problem::lane_simplex::{FunctionSpan, LaneSimplex, LaneStarts, ProgramBatch};
use moment_problem::Basis;
use programs::workload;

const CELLS: usize = 256;
const TOLERANCE: f64 = 1e-6;

#[test]
fn smoke() {
    let functions = Basis::default_family();
    let table = FunctionTable::new(&functions, &FunctionTable::uniform_depths(CELLS)).unwrap();
    let span = FunctionSpan::new(&table);
    println!("dimensions {}", span.dimensions());
    let (kernels, fragments) = workload(CELLS, 1, 4000);
    let batch = ProgramBatch::new(&span, &kernels, &fragments);
    println!("{} programs", batch.len());
    for basis in [vec![0, 1, 2, 3], vec![29, 30, 33, 34], vec![0, 5, 20, 30], vec![3, 11, 22, 36], vec![1, 2, 7], vec![4, 30], vec![8]] {
        let rank = basis.len() + 1;
        let start = |functions: Vec<usize>| -> FastStart {
            let columns = SupportColumns::new(&table, &functions).unwrap();
            FastSimplex::new(&columns, TOLERANCE).thorough().solve(&kernels, &fragments).start()
        };
        let starts = [start((0..basis.len()).collect()), start((29..29 + basis.len()).collect())];
        let lane_starts = LaneStarts::new(&batch, [&starts[0], &starts[1]], rank);
        let clock = std::time::Instant::now();
        let columns = SupportColumns::new(&table, &basis).unwrap();
        println!("columns {:?}", clock.elapsed());
        let clock = std::time::Instant::now();
        let fast = FastSimplex::new(&columns, TOLERANCE).solve_near(&kernels, &fragments, &[&starts[0], &starts[1]]);
        let base = clock.elapsed().as_secs_f64();
        println!("{basis:?} fast {:.1} ns exact {} uncertified {}", base / batch.len() as f64 * 1e9, fast.exact, fast.uncertified.len());
        let clock = std::time::Instant::now();
        let columns = span.columns(&basis).unwrap();
        println!("span columns {:?}", clock.elapsed());
        for (name, solver) in LaneSimplex::new(&columns, TOLERANCE).unwrap().widths() {
            let clock = std::time::Instant::now();
            let solution = solver.solve(&batch, &lane_starts);
            let time = clock.elapsed().as_secs_f64();
            let worst = solution.lower.iter().zip(&fast.bounds).map(|(a, b)| (a - b.lower).abs()).fold(0.0, f64::max);
            println!("  {name}: {:.1} ns, {:.2} x, exact {} uncertified {} pivots {:.2} worst {worst:.1e}", time / batch.len() as f64 * 1e9, base / time, solution.exact, solution.uncertified.len(), solution.pivots as f64 / batch.len() as f64);
        }
    }
}
