//! All candidates of a search, for readers to look up.

use super::summary::{POWER_4, SearchTables};
use crate::error::ReportError;
use crate::page::{Explorer, json};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Unit of the errors that the page holds: a tenth of what it shows.
const UNIT: f64 = 1e-6;

/// All candidates of a search in little space.
#[derive(Serialize)]
struct Candidates {
    functions: Vec<String>,
    /// What has an error of its own: percentage-closer filtering and techniques, by name.
    marks: Vec<(String, f64)>,
    sizes: Vec<CandidatesOfSize>,
}

/// Best first, in base 64: the functions' places one after another, as many bits each as the last place needs, the lowest
/// first; and how much each error, in units of [`UNIT`], exceeds the one before, seven bits a byte with the lowest first,
/// the eighth bit set where more follow. By [`changes`] how far the first rank that a candidate may have lies above its own, and the last
/// below it.
#[derive(Serialize)]
struct CandidatesOfSize {
    m: usize,
    count: usize,
    /// With those that are not recorded one by one.
    all: usize,
    members: String,
    errors: String,
    above: String,
    below: String,
}

/// Candidates of one size, best first.
#[derive(Default)]
struct Ranked {
    m: usize,
    all: usize,
    places: Vec<usize>,
    errors: Vec<u64>,
    above: Vec<u64>,
    below: Vec<u64>,
}

/// Places in as few bits as they need.
fn packed(places: &[usize], bits: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(places.len() * bits as usize / 8 + 1);
    let (mut held, mut count) = (0usize, 0);
    for place in places {
        held |= place << count;
        count += bits;
        while count >= 8 {
            bytes.push(held as u8);
            held >>= 8;
            count -= 8;
        }
    }
    if count > 0 {
        bytes.push(held as u8);
    }
    bytes
}

/// Whole numbers, small ones in a byte.
fn numbers(values: impl IntoIterator<Item = u64>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for mut rest in values {
        while rest > 0x7f {
            bytes.push(0x80 | (rest & 0x7f) as u8);
            rest >>= 7;
        }
        bytes.push(rest as u8);
    }
    bytes
}

/// Differences of any values: twice a rise, and twice a fall less one.
fn changes(values: &[u64]) -> impl Iterator<Item = u64> {
    let mut before = 0;
    values.iter().map(move |&value| {
        let change = if value >= before { 2 * (value - before) } else { 2 * (before - value) - 1 };
        before = value;
        change
    })
}

/// Differences of values that do not fall.
fn differences(values: &[u64]) -> impl Iterator<Item = u64> {
    let mut before = 0;
    values.iter().map(move |&value| {
        let difference = value.saturating_sub(before);
        before = value.max(before);
        difference
    })
}

/// What the script shares with the histogram.
pub(super) fn script() -> String {
    format!("const CANDIDATES = {{ unit: {UNIT:e}, example: \"{POWER_4}\" }};\n")
}

/// Nothing for a family of more functions than a byte can name.
pub(super) fn candidates(tables: &SearchTables<'_>) -> Result<Option<Explorer>, ReportError> {
    let mut functions: Vec<String> =
        tables.experiment.functions()?.iter().map(|f| f.name().to_owned()).collect();
    let mut sizes: Vec<Ranked> = Vec::new();
    for record in tables.records.iter().filter(|r| r.fragments > 0) {
        let size = sizes.iter().position(|size| size.m == record.m).unwrap_or_else(|| {
            sizes.push(Ranked { m: record.m, ..Ranked::default() });
            sizes.len() - 1
        });
        // The page counts ranks by rows.
        sizes[size].all = record.rank;
        if record.rank != sizes[size].errors.len() + 1 {
            continue;
        }
        for function in record.basis.split(", ") {
            let place = functions.iter().position(|known| known == function).unwrap_or_else(|| {
                functions.push(function.to_owned());
                functions.len() - 1
            });
            sizes[size].places.push(place);
        }
        let of = &mut sizes[size];
        of.errors.push((record.l1_error / UNIT).round() as u64);
        of.above.push(record.rank.saturating_sub(record.rank_low) as u64);
        of.below.push(record.rank_high.saturating_sub(record.rank) as u64);
    }
    if functions.len() > 1 + usize::from(u8::MAX) {
        return Ok(None);
    }
    let bits = functions.len().next_power_of_two().ilog2().max(1);
    let encode = |of: Ranked| CandidatesOfSize {
        m: of.m,
        count: of.errors.len(),
        all: of.all,
        members: STANDARD.encode(packed(&of.places, bits)),
        errors: STANDARD.encode(numbers(differences(&of.errors))),
        above: STANDARD.encode(numbers(changes(&of.above))),
        below: STANDARD.encode(numbers(changes(&of.below))),
    };
    let sizes = sizes.into_iter().map(encode).collect();
    let marks = tables.landmarks().into_iter().map(|mark| (mark.name, mark.error)).collect();
    let data = json(&Candidates { functions, marks, sizes });
    Ok(Some(Explorer::Chart { class: "candidates", data }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_errors_come_back() {
        let places: Vec<usize> = (0..100).map(|i| i * 7 % 37).collect();
        let bytes = packed(&places, 6);
        assert_eq!(bytes.len(), 75);
        let bit = |i: usize| usize::from(bytes[i / 8] >> (i % 8) & 1);
        let back: Vec<usize> = (0..100).map(|i| (0..6).map(|k| bit(6 * i + k) << k).sum()).collect();
        assert_eq!(back, places);
        let errors = [5, 5, 132, 133, 70_000];
        assert_eq!(numbers(differences(&errors)), [5, 0, 127, 1, 0x80 | 0x6b, 0x80 | 0x21, 4]);
        assert_eq!(changes(&[3, 5, 5, 1]).collect::<Vec<_>>(), [6, 4, 0, 7]);
        assert_eq!(133 + 0x6b + (0x21 << 7) + (4 << 14), 70_000);
    }
}
