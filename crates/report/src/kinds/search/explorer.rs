//! All candidates of a search, for readers to look up.

use super::summary::{POWER_4, SearchTables};
use crate::drawing::{SKY_BLUE, VERMILLION, css};
use crate::error::ReportError;
use crate::page::{Explorer, json};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Unit of the errors that the page holds.
const UNIT: f64 = 1e-7;

/// All candidates of a search in little space.
#[derive(Serialize)]
struct Candidates {
    functions: Vec<String>,
    sizes: Vec<CandidatesOfSize>,
}

/// Best first: for each candidate its functions' places, a byte each, and the error in units of [`UNIT`], four bytes with
/// the least first; in base 64.
#[derive(Serialize)]
struct CandidatesOfSize {
    m: usize,
    data: String,
}

/// What the script shares with the histogram.
pub(super) fn script() -> String {
    format!(
        "const CANDIDATES = {{ unit: {UNIT:e}, all: \"{}\", chosen: \"{}\", example: \"{POWER_4}\" }};\n",
        css(SKY_BLUE),
        css(VERMILLION)
    )
}

/// Nothing for a family of more functions than a byte can name.
pub(super) fn candidates(tables: &SearchTables<'_>) -> Result<Option<Explorer>, ReportError> {
    let mut functions: Vec<String> =
        tables.experiment.functions()?.iter().map(|f| f.name().to_owned()).collect();
    let mut sizes: Vec<(usize, Vec<u8>)> = Vec::new();
    for record in tables.records.iter().filter(|r| r.fragments > 0) {
        let place = sizes.iter().position(|(m, _)| *m == record.m).unwrap_or_else(|| {
            sizes.push((record.m, Vec::new()));
            sizes.len() - 1
        });
        for function in record.basis.split(", ") {
            let index = functions.iter().position(|known| known == function).unwrap_or_else(|| {
                functions.push(function.to_owned());
                functions.len() - 1
            });
            sizes[place].1.push(index as u8);
        }
        sizes[place].1.extend(((record.l1_error / UNIT).round() as u32).to_le_bytes());
    }
    if functions.len() > 1 + usize::from(u8::MAX) {
        return Ok(None);
    }
    let encode = |(m, bytes): (usize, Vec<u8>)| CandidatesOfSize { m, data: STANDARD.encode(bytes) };
    let sizes = sizes.into_iter().map(encode).collect();
    let data = json(&Candidates { functions, sizes });
    Ok(Some(Explorer::Chart { class: "candidates", data, without_script: None }))
}
