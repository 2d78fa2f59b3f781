//! Compute passes of applications as they run here, with settings as published.

use super::preset::Preset;
use crate::outcome::Failure;
use anyhow::{Context, anyhow};
use applications::scattering::{
    Blending, StoredPrefixes, look_up_shader, march_shader, prefix_map_shader, resample_shader,
};
use applications::soft_shadow::{
    BlockerSearch, Filter, FilterSize, Reconstruction, Warp, filterable_shader, percentage_closer_shader,
    prefix_sums_shader,
};
use moment_problem::MomentBound;
use quantization::NumberFormat;

/// As on the command line.
pub(super) const NAMES: [&str; 7] = [
    "soft-shadows-table",
    "soft-shadows",
    "percentage-closer-soft-shadows",
    "scattering-resample",
    "scattering-prefix-map",
    "scattering-look-up",
    "scattering-march",
];

/// Texels of the shadow map; constants of the file.
const MAP: [usize; 2] = [1024, 1024];

/// Columns and rows of the rectified map.
const RECTIFIED: [usize; 2] = [1024, 1024];

/// Most texels of a region of a summed-area table, whose fixed point leaves room for so many.
const REGION: u32 = 29 * 29;

/// Moment bias of soft shadows in a table of 32 bits, as in `experiments/soft-shadows.toml`.
const TABLE_ALPHA: f64 = 5e-6;

/// Samples of a marched ray.
const STEPS: usize = 64;

/// One line on what a pass does.
pub(super) fn purpose(name: &str) -> &'static str {
    match name {
        "soft-shadows-table" => {
            "summed-area table of four moments of a depth map, for `soft-shadows` (BHS16 section 3)"
        }
        "soft-shadows" => "moment soft shadows by two queries to a summed-area table (BHS16 section 3)",
        "percentage-closer-soft-shadows" => "percentage-closer soft shadows, tap by tap (Fernando 2005)",
        "scattering-resample" => "a shadow map in rectified coordinates (BHS16 section 2.1)",
        "scattering-prefix-map" => {
            "prefix sums of four moments along the rows of a rectified map (BHS16 section 2.2)"
        }
        "scattering-look-up" => {
            "single scattering of a view ray by one look-up in the prefix map (BHS16 section 2.3)"
        }
        "scattering-march" => "single scattering of a view ray by samples along it",
        _ => "",
    }
}

/// WGSL of a pass; `None` for names of others.
pub(super) fn source(name: &str) -> Result<Option<String>, Failure> {
    if !NAMES.contains(&name) {
        return Ok(None);
    }
    let (search, filter) = (BlockerSearch::published(), Filter::published());
    let soft = Reconstruction::new(MomentBound::Hamburger4, Warp::None, TABLE_ALPHA)
        .map_err(|error| anyhow!("soft shadows: {error}"))?;
    let four = Preset::of("hamburger4", Some(NumberFormat::Unorm16), None)?;
    let stored = StoredPrefixes { technique: &four.technique, blending: Blending::Adaptive, margin: 0.0 };
    let text = match name {
        "soft-shadows-table" => Some(prefix_sums_shader(&soft, MAP, REGION)),
        "soft-shadows" => filterable_shader(&soft, MAP, REGION, FilterSize::Searched(&search), &filter),
        "percentage-closer-soft-shadows" => Some(percentage_closer_shader(MAP, &search, &filter)),
        "scattering-resample" => Some(resample_shader(RECTIFIED)),
        "scattering-prefix-map" => prefix_map_shader(&stored, RECTIFIED),
        "scattering-look-up" => look_up_shader(&stored, RECTIFIED),
        _ => Some(march_shader(STEPS)),
    };
    Ok(Some(text.context("the pass has no shader")?))
}
