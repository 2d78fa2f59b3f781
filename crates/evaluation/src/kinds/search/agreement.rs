//! The fast solver against the double-double simplex method, which starts cold and shares only the columns with it.

use super::records::SearchAgreementRecord;
use super::sweep::Sweep;
use moment_problem::BasisFunction;
use moment_problem::fast_simplex::{FastFragment, SupportColumns, reference_bound};
use random_stream::Random;
use rayon::prelude::*;

/// Stream of random numbers, apart from those of the views.
const STREAM: u64 = 1 << 32;

/// One row a basis, drawn at random over all orders.
pub(crate) fn compare(sweep: &Sweep<'_>, functions: &[BasisFunction]) -> Vec<SearchAgreementRecord> {
    let wanted = sweep.experiment.agreement;
    (0..wanted.bases).into_par_iter().filter_map(|i| one(sweep, functions, i, wanted.fragments)).collect()
}

fn one(
    sweep: &Sweep<'_>,
    functions: &[BasisFunction],
    i: usize,
    fragments: usize,
) -> Option<SearchAgreementRecord> {
    let mut random = Random::substream(sweep.experiment.scenery.seed, STREAM, i as u64);
    let order = i % sweep.subsets.len();
    let number = (random.unit() * sweep.subsets[order].len() as f64) as u32;
    let members = sweep.members(order, number);
    let columns = SupportColumns::new(&sweep.workload.table, &members).ok()?;
    let block = sweep.workload.blocks.last()?;
    let (solved, _) = sweep.solve(sweep.workload.blocks.len() - 1, order, &members)?;
    let names: Vec<&str> = members.iter().map(|&member| functions[member].name()).collect();
    let mut record = SearchAgreementRecord {
        basis: names.join(", "),
        fragments: 0,
        largest_disagreement: 0.0,
        largest_gap: 0.0,
        failed: 0,
    };
    let count = block.fragments.len();
    for _ in 0..fragments.min(count) {
        let place = ((random.unit() * count as f64) as usize).min(count - 1);
        let FastFragment { kernel, step, .. } = block.fragments[place];
        record.fragments += 1;
        record.largest_gap = record.largest_gap.max(solved.lower[place] - solved.proved[place]);
        match reference_bound(&columns, &block.kernels[kernel as usize], step) {
            Ok(value) => {
                let difference = (solved.lower[place] - value).abs();
                record.largest_disagreement = record.largest_disagreement.max(difference);
            }
            Err(_) => record.failed += 1,
        }
    }
    // Nine digits are more than the tolerance has.
    let short = |value: f64| (value * 1e12).round() / 1e12;
    record.largest_disagreement = short(record.largest_disagreement);
    record.largest_gap = short(record.largest_gap);
    Some(record)
}
