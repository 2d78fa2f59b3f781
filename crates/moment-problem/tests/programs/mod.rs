//! Programs that tests of the solvers share.

use moment_problem::fast_simplex::{FastFragment, SupportDistribution};

/// Kernels of one to seven clusters, from a single depth to half of the interval wide, and fragments at all kinds of
/// depths, in ascending order of depth.
#[allow(dead_code)]
pub(crate) fn workload(
    cells: usize,
    seed: u64,
    count: usize,
) -> (Vec<SupportDistribution>, Vec<FastFragment>) {
    let mut state = seed;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut scratch = Vec::new();
    let mut kernels = Vec::new();
    let mut fragments = Vec::new();
    for kernel in 0..count {
        let clusters = 1 + (7.0 * unit()) as usize;
        let width = 0.5 * unit().powi(4);
        let centres: Vec<f64> = (0..clusters).map(|_| unit()).collect();
        let taps: Vec<(f64, f64)> =
            (0..25).map(|i| (centres[i % clusters] + width * (unit() - 0.5), 1.0 / 25.0)).collect();
        let distribution = SupportDistribution::snapped(taps.iter().copied(), cells, &mut scratch);
        for depth in [unit(), taps[3].0, taps[7].0 + 1.0 / cells as f64] {
            let step = (depth.clamp(0.0, 1.0) * cells as f64).round() as u16;
            fragments.push(FastFragment { kernel: kernel as u32, step, mass_before: distribution.cdf(step) });
        }
        kernels.push(distribution);
    }
    fragments.retain(|fragment| fragment.mass_before > 0.0);
    fragments.sort_by_key(|fragment| fragment.step);
    (kernels, fragments)
}

/// Kernels of five neighbouring cells of 256, at depths within them: high powers need dual vectors of 1e10 and more there.
#[allow(dead_code)]
pub(crate) fn narrow(count: usize) -> (Vec<SupportDistribution>, Vec<FastFragment>) {
    let mut state = 5u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut kernels, mut fragments, mut scratch) = (Vec::new(), Vec::new(), Vec::new());
    for kernel in 0..count as u32 {
        let first = 1.0 + (unit() * 250.0).floor();
        let weights: Vec<f64> = (0..5).map(|_| unit().powi(4)).collect();
        let sum: f64 = weights.iter().sum();
        let taps = weights.iter().enumerate().map(|(i, &w)| ((first + i as f64) / 256.0, w / sum));
        let distribution = SupportDistribution::snapped(taps, 256, &mut scratch);
        let step = first as u16 + 1 + (unit() * 4.0) as u16;
        fragments.push(FastFragment { kernel, step, mass_before: distribution.cdf(step) });
        kernels.push(distribution);
    }
    fragments.sort_by_key(|fragment| fragment.step);
    (kernels, fragments)
}

/// Kernels and fragments from a file: counts, indices with weights of each kernel, then kernel, step and F of each fragment,
/// little-endian.
#[allow(dead_code)]
pub(crate) fn read(path: &std::path::Path) -> (Vec<SupportDistribution>, Vec<FastFragment>) {
    let bytes = std::fs::read(path).unwrap();
    let mut at = 0;
    let mut take = |count: usize| {
        at += count;
        &bytes[at - count..at]
    };
    let kernels = u64::from_le_bytes(take(8).try_into().unwrap());
    let fragments = u64::from_le_bytes(take(8).try_into().unwrap());
    let mut scratch = Vec::new();
    let mut distributions = Vec::new();
    for _ in 0..kernels {
        let count = u32::from_le_bytes(take(4).try_into().unwrap());
        let taps: Vec<(f64, f64)> = (0..count)
            .map(|_| {
                let j = u16::from_le_bytes(take(2).try_into().unwrap());
                (f64::from(j) / 256.0, f64::from_le_bytes(take(8).try_into().unwrap()))
            })
            .collect();
        distributions.push(SupportDistribution::snapped(taps.into_iter(), 256, &mut scratch));
    }
    let fragments = (0..fragments).map(|_| FastFragment {
        kernel: u32::from_le_bytes(take(4).try_into().unwrap()),
        step: u16::from_le_bytes(take(2).try_into().unwrap()),
        mass_before: f64::from_le_bytes(take(8).try_into().unwrap()),
    });
    (distributions, fragments.collect())
}

/// Power moments in the default family.
#[allow(dead_code)]
pub(crate) fn powers() -> [usize; 4] {
    places(moment_problem::Basis::power(4))
}

/// Trigonometric moments in the default family.
#[allow(dead_code)]
pub(crate) fn waves() -> [usize; 4] {
    places(moment_problem::Basis::trigonometric(2))
}

fn places(basis: moment_problem::Basis) -> [usize; 4] {
    let family = moment_problem::Basis::default_family();
    std::array::from_fn(|i| family.iter().position(|function| *function == basis.functions()[i]).unwrap())
}

/// The subset of a number, in lexicographic order.
#[allow(dead_code)]
pub(crate) fn subset(members: usize, order: usize, mut number: usize) -> Vec<usize> {
    let binomial = |n: usize, k: usize| (0..k).fold(1, |product, i| product * (n - i) / (i + 1));
    let (mut subset, mut next) = (Vec::new(), 0);
    while subset.len() < order {
        let after = binomial(members - next - 1, order - subset.len() - 1);
        if number < after {
            subset.push(next);
        } else {
            number -= after;
        }
        next += 1;
    }
    subset
}
