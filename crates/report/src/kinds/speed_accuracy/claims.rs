//! What the papers publish about the time of a frame.

use super::summary::SpeedTables;
use crate::page::Claim;

pub(crate) fn claims(tables: &SpeedTables) -> Vec<Claim> {
    let adapter = tables.gpu.as_ref().map(|gpu| gpu.adapter.clone()).unwrap_or_default();
    let time = |technique: &str, format: &str| tables.gpu_time(technique, format).map(|t| t.1);
    let pair = |[a, b]: [(&str, &str); 2]| {
        let (x, y) = (time(a.0, a.1)?, time(b.0, b.1)?);
        Some(format!("{x:.2} and {y:.2} ms, {:.2} times, on {adapter}", y / x))
    };
    [
        Claim::new(
            "MSM15 5, Figure 7",
            "A frame with VSM in 32 bits and with four moments in 16 bits takes almost identical times",
            pair([("VSM", "f32"), ("Hamburger 4", "unorm16")]),
        ),
        Claim::new(
            "MSM15 5",
            "VSM in 16 bits performs identical to ESM",
            pair([("ESM, c = 80", "f32"), ("VSM", "unorm16")]),
        ),
        Claim::new(
            "MSM15 5",
            "In 16 bits Hausdorff 4MSM is only slightly slower than Hamburger 4MSM",
            pair([("Hamburger 4", "unorm16"), ("Hausdorff 4", "unorm16")]),
        ),
        Claim::new(
            "MSM15 5",
            "The frame time for filterable shadow maps is governed by the memory per texel",
            tables.times_by_bits(),
        ),
        Claim::new(
            "MSM15 5",
            "Hamburger 4MSM outperforms PCF for large output resolutions, large filter kernels and small shadow maps",
            tables.faster_than_comparison(("Hamburger 4", "unorm16")),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}
