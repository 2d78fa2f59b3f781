//! The table of gains: transforms optimised here, and the published ones.

use super::records::{GainRecord, GainSample};
use super::settings::{GainSetting, StructureName};
use moment_problem::Basis;
use quantization::published::{self, Published};
use quantization::{AffineTransform, Optimum, QuantizationError, Search, optimise};
use shadow_filtering::Range;
use std::time::Instant;

fn spaced(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

fn structure_name(structure: StructureName) -> &'static str {
    match structure {
        StructureName::Dense => "dense",
        StructureName::Parity => "parity",
    }
}

/// Optimises one transform.
pub(crate) fn optimised(setting: &GainSetting, seed: u64) -> (GainRecord, GainSample) {
    let begin = Instant::now();
    let search = Search { structure: setting.structure.into(), starts: setting.starts, seed };
    let result =
        setting.basis.parse::<Basis>().map_err(QuantizationError::from).and_then(|basis| {
            optimise(&basis, setting.range.interval(), &search).map(|found| (basis, found))
        });
    let time = begin.elapsed();
    let structure = structure_name(setting.structure).to_owned();
    let name = setting.basis.parse::<Basis>().map_or(setting.basis.clone(), |basis| basis.to_string());
    let sample = GainSample {
        basis: name.clone(),
        structure: structure.clone(),
        threads: rayon::current_num_threads(),
        repetition: 0,
        time_ns: u64::try_from(time.as_nanos()).unwrap_or(u64::MAX),
    };
    let mut record = GainRecord {
        basis: name,
        m: 0,
        transform: structure,
        range: setting.range.name().to_owned(),
        gain_bits: None,
        bound_bits: None,
        range_min: None,
        range_max: None,
        starts: None,
        starts_at_best: None,
        matrix: String::new(),
        offset: String::new(),
        error: String::new(),
    };
    match result {
        Ok((basis, optimum)) => {
            let Optimum { transform, depths, gain_bits, bound_bits, range_min, range_max, starts, hits } =
                optimum;
            if depths != setting.range.interval() {
                record.range = Range::Signed.name().to_owned();
            }
            record.m = basis.len();
            record.gain_bits = Some(gain_bits);
            record.bound_bits = Some(bound_bits);
            record.range_min = Some(range_min);
            record.range_max = Some(range_max);
            record.starts = Some(starts);
            record.starts_at_best = Some(hits);
            (record.matrix, record.offset) = written(&transform);
        }
        Err(error) => record.error = error.to_string(),
    }
    (record, sample)
}

/// The row of a published transform.
pub(crate) fn published(published: &Published) -> Result<GainRecord, QuantizationError> {
    let (range_min, range_max) = published.range()?;
    let (matrix, offset) = written(&published.transform()?);
    Ok(GainRecord {
        basis: Basis::power(published.order).to_string(),
        m: published.order,
        transform: published.name.to_owned(),
        range: Range::of_published(published).name().to_owned(),
        gain_bits: Some(published.gain_bits()?),
        bound_bits: None,
        range_min: Some(range_min),
        range_max: Some(range_max),
        starts: None,
        starts_at_best: None,
        matrix,
        offset,
        error: String::new(),
    })
}

/// All that were published elsewhere.
pub(crate) fn all_published() -> impl Iterator<Item = &'static Published> {
    published::ALL.iter().filter(|published| !published.name.starts_with("ours"))
}

fn written(transform: &AffineTransform) -> (String, String) {
    (spaced(transform.matrix()), spaced(transform.offset()))
}
