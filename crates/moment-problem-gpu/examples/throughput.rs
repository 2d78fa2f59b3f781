//! Programs a second on this machine's card, over candidates spread evenly over the 4-subsets of the default family, each bound
//! compared with the CPU's.
//!
//! Programs come from the file that `MSM_PROGRAMS` names, or are made up. `MSM_LIMIT`: at most so many of them;
//! `MSM_CANDIDATES`, `MSM_REPETITIONS`; `MSM_CHECKED=1`: shaders with run-time checks; `MSM_SUBGROUPS=0`: without them.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

use moment_problem::Basis;
use moment_problem::fast_simplex::{FastSimplex, FastStart, FunctionTable, SupportColumns};
use moment_problem::lane_simplex::{
    ExactSimplex, FunctionSpan, LaneSimplex, LaneStarts, ProgramBatch, SpanColumns,
};
use moment_problem_gpu::{Card, GROUP, Programs, Weighting};
use rayon::prelude::*;
use std::time::Instant;

#[path = "../../moment-problem/tests/programs/mod.rs"]
mod programs;

const CELLS: usize = 256;
const TOLERANCE: f64 = 1e-6;

fn main() {
    let clock = Instant::now();
    let (kernels, mut fragments) = match std::env::var_os("MSM_PROGRAMS") {
        Some(path) => programs::read(path.as_ref()),
        None => programs::workload(CELLS, 1, 20_000),
    };
    let limit = variable("MSM_LIMIT", usize::MAX);
    if fragments.len() > limit {
        let every = fragments.len().div_ceil(limit);
        fragments = fragments.into_iter().step_by(every).collect();
    }
    let table = FunctionTable::new(&Basis::default_family(), &FunctionTable::uniform_depths(CELLS)).unwrap();
    let span = FunctionSpan::new(&table);
    let batch = ProgramBatch::new(&span, &kernels, &fragments);
    let start = |functions: [usize; 4]| -> FastStart {
        let columns = SupportColumns::new(&table, &functions).unwrap();
        FastSimplex::new(&columns, TOLERANCE).thorough().solve(&kernels, &fragments).start()
    };
    let given = [start(programs::powers()), start(programs::waves())];
    let starts = LaneStarts::new(&batch, [&given[0], &given[1]], 5);
    let count = variable("MSM_CANDIDATES", 30);
    let number = |i: usize| (2 * i + 1) * 66_045 / (2 * count);
    let columns: Vec<SpanColumns> = (0..count)
        .into_par_iter()
        .map(|i| span.columns(&programs::subset(37, 4, number(i))).unwrap())
        .collect();
    println!("{} programs, prepared in {:.1} s", batch.len(), clock.elapsed().as_secs_f64());

    let card = match Card::with(variable("MSM_CHECKED", 0) == 1, variable("MSM_SUBGROUPS", 1) == 1) {
        Ok(card) => card,
        Err(error) => {
            println!("no card: {error}");
            std::process::exit(1);
        }
    };
    println!("{}", card.name());
    let weighting: Vec<Weighting> =
        fragments.iter().map(|f| Weighting { reference: f.mass_before, control: 0.0, count: 1.0 }).collect();
    let order: Vec<Option<u32>> = (0..fragments.len() as u32).map(Some).collect();
    let clock = Instant::now();
    let resident = card
        .upload(
            Programs { batch: &batch, starts: &starts, weighting: &weighting, order: &order },
            count,
            None,
        )
        .unwrap();
    println!("on the card in {:.2} s", clock.elapsed().as_secs_f64());
    let wanted: Vec<&SpanColumns> = columns.iter().collect();
    let all = (batch.len() * count) as f64;
    let mut walls = Vec::new();
    let mut answer = None;
    for _ in 0..1 + variable("MSM_REPETITIONS", 5) {
        let clock = Instant::now();
        let submitted = resident.submit(&batch, &wanted, TOLERANCE).unwrap();
        let (got, passes) = resident.finish(submitted).unwrap();
        let wall = clock.elapsed().as_secs_f64();
        let on_card: f64 = passes.iter().map(|pass| pass.seconds).sum();
        println!(
            "{:.4} G programs/s ({:.2} ms; on the card {:.2} ms = {:.4} G/s; {}), {:.4} % certified",
            all / wall * 1e-9,
            wall * 1e3,
            on_card * 1e3,
            all / on_card * 1e-9,
            passes
                .iter()
                .map(|p| format!("{} {:.2}", p.name, p.seconds * 1e3))
                .collect::<Vec<_>>()
                .join(", "),
            100.0 * (1.0 - got.left.len() as f64 / all)
        );
        walls.push(wall);
        answer = Some(got);
    }
    let answer = answer.unwrap();
    walls[1..].sort_by(f64::total_cmp);
    println!("median {:.4} G programs/s", all / walls[1 + (walls.len() - 1) / 2] * 1e-9);
    // Work in flight while the next is handed over, as a run does it.
    let clock = Instant::now();
    let rounds = variable("MSM_REPETITIONS", 5);
    let mut before = None;
    for _ in 0..rounds {
        let next = resident.submit(&batch, &wanted, TOLERANCE).unwrap();
        if let Some(submitted) = before.replace(next) {
            resident.finish(submitted).unwrap();
        }
    }
    resident.finish(before.unwrap()).unwrap();
    println!("two in flight: {:.4} G programs/s", all * rounds as f64 / clock.elapsed().as_secs_f64() * 1e-9);

    let clock = Instant::now();
    let exact: Vec<ExactSimplex<'_>> =
        columns.iter().map(|columns| ExactSimplex::new(columns.columns())).collect();
    let decided: Vec<bool> = answer
        .left
        .par_iter()
        .map(|left| {
            let exact = &exact[left.candidate as usize];
            let fragment = &fragments[left.program as usize];
            let kernel = &kernels[fragment.kernel as usize];
            let bound = exact.bound(kernel, fragment.step, fragment.mass_before, &left.support);
            bound.is_some_and(|bound| bound.lower - bound.proved <= TOLERANCE)
        })
        .collect();
    println!(
        "exact route: {} programs, {:.1} us each on {} threads together, {} uncertified",
        decided.len(),
        clock.elapsed().as_secs_f64() / decided.len().max(1) as f64 * 1e6,
        rayon::current_num_threads(),
        decided.iter().filter(|certified| !**certified).count()
    );

    let read: Vec<Vec<f64>> = (0..count).map(|c| resident.bounds(c).unwrap()).collect();
    let clock = Instant::now();
    let compared: Vec<(usize, f64, f64)> = (0..count)
        .into_par_iter()
        .map(|c| {
            let solution = LaneSimplex::new(&columns[c], TOLERANCE).unwrap().solve(&batch, &starts);
            let (mut wrong, mut worst, mut sum) = (0, 0.0f64, 0.0);
            for (i, (bound, lower)) in read[c].iter().zip(&solution.lower).enumerate() {
                if *bound >= 0.0 {
                    let difference = (bound - lower).abs();
                    wrong += usize::from(difference.is_nan() || difference > 2e-6);
                    worst = worst.max(difference);
                    sum += (bound - fragments[i].mass_before).abs();
                }
            }
            let groups = &answer.sums[c * answer.groups..][..answer.groups];
            (wrong, worst, (groups.iter().map(|sum| sum.difference).sum::<f64>() - sum).abs())
        })
        .collect();
    let seconds = clock.elapsed().as_secs_f64();
    println!(
        "{} of {} wrong by more than 2e-6, largest difference {:.1e}; largest difference of sums {:.1e}; the CPU took {seconds:.2} s",
        compared.iter().map(|c| c.0).sum::<usize>(),
        all - answer.left.len() as f64,
        compared.iter().map(|c| c.1).fold(0.0, f64::max),
        compared.iter().map(|c| c.2).fold(0.0, f64::max),
    );
    let group = answer.groups / 2;
    let sampled = answer.sampled(count / 2, group);
    println!(
        "sample: {} is {}",
        answer.sums[count / 2 * answer.groups + group].sample,
        read[count / 2][sampled]
    );
    assert_eq!(resident.stride() % GROUP, 0);
}

fn variable(name: &str, default: usize) -> usize {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}
