//! Faults planted into the shaders of soft shadows: each must be found by the comparison that it belongs to.

use super::soft_shadows::{filterable, percentage_closer, prefix_sums};
use applications::soft_shadow::{Reconstruction, Storage, Warp};
use libtest_mimic::Failed;
use moment_problem::MomentBound;

/// A dropped epsilon, a region that is off by half a texel, sums that become floats before they are subtracted, and others.
const FILTERABLE: [&str; 7] = [
    "let total = SEARCH_EPSILON + blockers.mass=>let total = blockers.mass",
    "means(at - 0.5 * searched, at + 0.5 * searched=>means(at + 0.5 - 0.5 * searched, at + 0.5 + 0.5 * searched",
    "let low = dithered(at - 0.5 * used);
    let high = dithered(at + 0.5 * used);=>let low = dithered(at - 0.5 - 0.5 * used);
    let high = dithered(at - 0.5 + 0.5 * used);",
    "let right = prefix(end.x, end.y, channel) - prefix(end.x, first.y, channel)=>\
     let right = u32(f32(prefix(end.x, end.y, channel)) - f32(prefix(end.x, first.y, channel)))",
    "share * f32(size.x * size.y)=>f32(size.x * size.y)",
    "w.x < 0.0 {\n        let lower=>w.x < -3.0 {\n        let lower",
    "floor(corner + noise)=>floor(corner + noise.yx)",
];

const PERCENTAGE_CLOSER: [&str; 2] =
    ["depth < z=>depth <= z + 1e-5", "found.depth_sum / area=>found.depth_sum"];

const PREFIX_SUMS: [&str; 4] = [
    "+ ((a * b) >> 31u)=>+ 3u",
    "running = totals[thread - 1u]=>running = totals[thread]",
    "distance < THREADS=>distance < THREADS / 2u",
    "running = running + part_sums=>running = part_sums",
];

/// Of powers that a transform stores.
const STORED_SUMS: [&str; 2] = ["(low >> (bits - 1u)) & 1u=>5u", "select(size, -size, =>select(size, size, "];

const STORED: [&str; 2] =
    ["(stored[0u] - offset[0u])=>stored[0u]", "return select(variable, 0.5=>return select(variable, 0.4"];

pub fn planted() -> Result<(), Failed> {
    let technique = Reconstruction::new(MomentBound::Hamburger4, Warp::None, 5e-6)?;
    let sparse = technique.stored(Storage::Sparse)?;
    let judged = [
        (
            &FILTERABLE[..],
            &(|fault: &str| filterable(&technique, fault)) as &dyn Fn(&str) -> Result<(), Failed>,
        ),
        (&PERCENTAGE_CLOSER, &percentage_closer),
        (&PREFIX_SUMS, &|fault: &str| prefix_sums(&technique, fault)),
        (&STORED, &|fault: &str| filterable(&sparse, fault)),
        (&STORED_SUMS, &|fault: &str| prefix_sums(&sparse, fault)),
    ];
    for (faults, judge) in judged {
        for fault in faults {
            if judge(fault).is_ok() {
                return Err(format!("the comparison missed `{fault}`").into());
            }
        }
    }
    Ok(())
}
