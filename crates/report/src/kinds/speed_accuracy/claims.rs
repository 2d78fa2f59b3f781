//! What the papers publish about the time of a frame.

use super::summary::SpeedTables;
use crate::page::{Claim, Measured, recorded};

pub(crate) fn claims(tables: &SpeedTables<'_>) -> Vec<Claim> {
    let pair = |roles| pair(tables, roles);
    [
        Claim::new(
            "MSM15 5, Figure 7",
            "A frame with VSM in 32 bits and with four moments in 16 bits takes almost identical times",
            pair(["VSM, 32 bits", "four moments, 16 bits"]),
        ),
        Claim::new(
            "MSM15 5",
            "VSM in 16 bits performs identical to ESM",
            pair(["ESM, 32 bits", "VSM, 16 bits"]),
        ),
        Claim::new(
            "MSM15 5",
            "In 16 bits Hausdorff 4MSM is only slightly slower than Hamburger 4MSM",
            pair(["four moments, 16 bits", "Hausdorff, 16 bits"]),
        ),
        Claim::new(
            "MSM15 5",
            "The frame time for filterable shadow maps is governed by the memory per texel",
            recorded(tables.times_by_bits()),
        ),
        Claim::new(
            "MSM15 5",
            "Hamburger 4MSM outperforms PCF for large output resolutions, large filter kernels and small shadow maps",
            tables.player("four moments, 16 bits").and_then(|(name, format)| recorded(tables.faster_than_comparison((name, &format)))),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn pair(tables: &SpeedTables<'_>, roles: [&'static str; 2]) -> Measured<String> {
    let [a, b] = roles.map(|role| tables.player(role));
    let (a, b) = (a?, b?);
    let (_, x, _) = recorded(tables.gpu_time(a.0, &a.1))?;
    let (_, y, _) = recorded(tables.gpu_time(b.0, &b.1))?;
    let adapter = tables.gpu.first().map(|gpu| gpu.adapter.as_str()).unwrap_or_default();
    Ok(format!("{x:.2} and {y:.2} ms, {:.2} times, on {adapter}", y / x))
}
