//! Programs a second, alone on one thread, beside good_lp on the same fragments.

use super::records::SearchSample;
use super::sweep::Sweep;
use moment_problem::fast_simplex::{SupportColumns, good_lp_bound};
use moment_problem::lane_simplex::MAX_FUNCTIONS;
use moment_problem::{BasisFunction, LpSolver};
use std::time::Instant;

/// Times the preparation of the columns and all programs of the last block, certificates included, for bases spread
/// over the candidates of four functions (or of the first size) and for the marked ones.
pub(crate) fn time(sweep: &Sweep<'_>, functions: &[BasisFunction]) -> Vec<SearchSample> {
    let settings = sweep.experiment.timing;
    let order = sweep.subsets.iter().position(|subsets| subsets.order() == 4).unwrap_or(0);
    let Some(block) = sweep.workload.blocks.last() else { return Vec::new() };
    let last = sweep.workload.blocks.len() - 1;
    let count = sweep.subsets[order].len();
    let mut numbers: Vec<u32> =
        (0..settings.bases).map(|i| ((2 * i + 1) * count / (2 * settings.bases)) as u32).collect();
    numbers.extend(sweep.always(order));
    let mut samples = Vec::new();
    for repetition in 0..settings.repetitions {
        for &number in &numbers {
            let members = sweep.members(order, number);
            let basis: Vec<&str> = members.iter().map(|&member| functions[member].name()).collect();
            let basis = basis.join(", ");
            let clock = Instant::now();
            let Some((solved, _)) = sweep.solve(last, order, &members) else { continue };
            let nanoseconds = |clock: Instant| u64::try_from(clock.elapsed().as_nanos()).unwrap_or(u64::MAX);
            samples.push(SearchSample {
                solver: if members.len() <= MAX_FUNCTIONS { "LaneSimplex" } else { "FastSimplex" }.to_owned(),
                basis: basis.clone(),
                repetition,
                programs: solved.lower.len(),
                wrong: solved.uncertified,
                time_ns: nanoseconds(clock),
            });
            let Ok(columns) = SupportColumns::new(&sweep.workload.table, &members) else { continue };
            let wanted = settings.microlp_fragments.min(block.fragments.len());
            let places = (0..wanted).map(|i| (2 * i + 1) * block.fragments.len() / (2 * wanted));
            let clock = Instant::now();
            let answers: Vec<(usize, Option<f64>)> = places
                .map(|place| {
                    let fragment = &block.fragments[place];
                    let kernel = &block.kernels[fragment.kernel as usize];
                    let answer = good_lp_bound(&columns, kernel, fragment.step, LpSolver::Microlp);
                    (place, answer.ok())
                })
                .collect();
            let time_ns = nanoseconds(clock);
            let is_wrong = |(place, answer): &&(usize, Option<f64>)| {
                let close = |value: &f64| (value - solved.lower[*place]).abs() <= 1e-6;
                !answer.as_ref().is_some_and(close)
            };
            samples.push(SearchSample {
                solver: "good_lp, microlp".to_owned(),
                basis,
                repetition,
                programs: wanted,
                wrong: answers.iter().filter(is_wrong).count(),
                time_ns,
            });
        }
    }
    samples
}
