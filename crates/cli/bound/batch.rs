//! `msm bound --batch`: one bound a row, millions of them in one process.

use crate::outcome::{Failure, Output, print};
use crate::progress::Bar;
use anyhow::{Context, anyhow};
use evaluation::write_whole;
use moment_problem::BoundMethod;
use rayon::prelude::*;
use serde::Serialize;
use shadow_renderer::write_array;
use std::fs::File;
use std::io::{BufReader, Cursor, ErrorKind, Read};
use std::path::Path;
use zip::ZipWriter;

/// Rows between two reports of progress.
const CHUNK: usize = 1 << 12;

/// A row of the answer. Where there is no bound, it is what holds without knowing anything: 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    bounds: [f64; 4],
    is_bounded: bool,
}

/// Names of the columns, and of the arrays of an archive; `ok` is 1 where there is a bound.
const COLUMNS: [&str; 4] = ["lower", "upper", "lower_proved", "upper_proved"];

#[derive(Serialize)]
struct Answer {
    rows: usize,
    failed: usize,
    /// Row, from 0, and reason of the first one without a bound.
    first_failure: Option<(usize, String)>,
    out: String,
}

/// Reads, bounds, writes. A row of the input holds m moments and the depth z_f.
pub(super) fn execute(
    (input, out): (&Path, Option<&Path>),
    method: &BoundMethod,
    output: Output,
) -> Result<(), Failure> {
    if out.is_none() && output.is_json() {
        return Err(Failure::Input(anyhow!(
            "--format json needs --out FILE: without it rows are printed as CSV"
        )));
    }
    let width = method.basis().len() + 1;
    let values = read(input, width)?;
    let rows = values.len() / width;
    let bar = Bar::new("bounds");
    bar.expect(rows.div_ceil(CHUNK));
    let bounded = |row: &[f64]| -> Result<[f64; 4], String> {
        let bounds = method.bounds(&row[..width - 1], row[width - 1]).map_err(|error| error.to_string())?;
        let proved = bounds.certificate;
        // Adding zero turns a negative zero into zero.
        Ok([bounds.lower + 0.0, bounds.upper, proved.lower_proved, proved.upper_proved])
    };
    let chunks = values.par_chunks(CHUNK * width).map(|chunk| {
        let rows: Vec<Result<[f64; 4], String>> = chunk.chunks_exact(width).map(bounded).collect();
        bar.advance();
        rows
    });
    let found: Vec<Result<[f64; 4], String>> = chunks.collect::<Vec<_>>().into_iter().flatten().collect();
    bar.finish();
    let first_failure =
        found.iter().enumerate().find_map(|(row, found)| Some((row, found.as_ref().err()?.clone())));
    let rows_of = |found: Result<[f64; 4], String>| match found {
        Ok(bounds) => Row { bounds, is_bounded: true },
        Err(_) => Row { bounds: [0.0, 1.0, 0.0, 1.0], is_bounded: false },
    };
    let answers: Vec<Row> = found.into_iter().map(rows_of).collect();
    let Some(out) = out else { return print(csv(&answers).as_bytes()) };
    if has_extension(out, "npz") {
        write_whole(out, &archive(&answers).context("putting the archive together")?)?;
    } else {
        write_whole(out, csv(&answers).as_bytes())?;
    }
    let failed = answers.iter().filter(|row| !row.is_bounded).count();
    let answer = Answer { rows, failed, first_failure, out: out.display().to_string() };
    output.emit(&answer, |text| {
        writeln!(text, "{} bounds, {} rows without one, in {}", rows - failed, failed, answer.out)?;
        match &answer.first_failure {
            Some((row, reason)) => writeln!(text, "first without one: row {row}: {reason}"),
            None => Ok(()),
        }
    })
}

fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

fn csv(rows: &[Row]) -> String {
    let mut text = format!("{},ok\n", COLUMNS.join(","));
    for row in rows {
        let [lower, upper, lower_proved, upper_proved] = row.bounds;
        text += &format!("{lower},{upper},{lower_proved},{upper_proved},{}\n", u8::from(row.is_bounded));
    }
    text
}

fn archive(rows: &[Row]) -> std::io::Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let count = [rows.len() as u64];
    for (k, name) in COLUMNS.iter().enumerate() {
        write_array(&mut zip, name, &count, rows.iter().map(|row| row.bounds[k]))?;
    }
    write_array(&mut zip, "ok", &count, rows.iter().map(|row| u8::from(row.is_bounded)))?;
    Ok(zip.finish()?.into_inner())
}

/// All rows, one after another.
fn read(path: &Path, width: usize) -> Result<Vec<f64>, Failure> {
    let fail = |reason: String| Failure::Input(anyhow!("--batch {}: {reason}", path.display()));
    if path == Path::new("-") {
        let mut text = String::new();
        std::io::stdin().read_to_string(&mut text).map_err(|error| fail(error.to_string()))?;
        return parse(&text, width).map_err(fail);
    }
    if !has_extension(path, "npy") {
        let text = std::fs::read_to_string(path).map_err(|error| fail(error.to_string()))?;
        return parse(&text, width).map_err(fail);
    }
    let file = File::open(path).map_err(|error| fail(error.to_string()))?;
    let npy = npyz::NpyFile::new(BufReader::new(file)).map_err(|error| fail(error.to_string()))?;
    let shape = npy.shape().to_vec();
    if shape.len() != 2 || shape[1] != width as u64 || npy.order() != npyz::Order::C {
        return Err(fail(format!(
            "has shape {shape:?}, expected rows of {} moments and z_f, {width} columns in C order",
            width - 1
        )));
    }
    let found = npy.dtype().descr();
    let damaged = |error: std::io::Error| match error.kind() {
        ErrorKind::UnexpectedEof => fail("is truncated".to_owned()),
        _ => fail(error.to_string()),
    };
    match npy.try_data::<f64>() {
        Ok(values) => values.collect::<Result<_, _>>().map_err(damaged),
        Err(npy) => match npy.try_data::<f32>() {
            Ok(values) => values.map(|value| value.map(f64::from)).collect::<Result<_, _>>().map_err(damaged),
            Err(_) => Err(fail(format!("has type {found}, expected float64 or float32"))),
        },
    }
}

/// Numbers separated by commas or spaces, a row a line; empty lines, comments with # and one heading are passed over.
fn parse(text: &str, width: usize) -> Result<Vec<f64>, String> {
    let mut values = Vec::new();
    let is_blank = |line: &&str| line.trim().is_empty() || line.trim_start().starts_with('#');
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !is_blank(line)) {
        let cells: Vec<&str> =
            line.split(|c: char| c == ',' || c.is_whitespace()).filter(|cell| !cell.is_empty()).collect();
        let row: Result<Vec<f64>, _> = cells.iter().map(|cell| cell.parse::<f64>()).collect();
        let row = match row {
            Ok(row) => row,
            // What is no number at all stands above the first row.
            Err(_) if values.is_empty() && cells.iter().all(|cell| cell.parse::<f64>().is_err()) => continue,
            Err(_) => return Err(format!("line {}: `{line}` is not a row of numbers", number + 1)),
        };
        if row.len() != width {
            return Err(format!(
                "line {}: {} numbers, expected {} moments and z_f",
                number + 1,
                row.len(),
                width - 1
            ));
        }
        values.extend(row);
    }
    if values.is_empty() {
        return Err(format!("no row of {} moments and z_f", width - 1));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_and_mistakes_named() {
        assert_eq!(
            parse("b1,b2,z\n# no\n0.5, 0.3 ,0.7\n\n1 2 3\n", 3),
            Ok(vec![0.5, 0.3, 0.7, 1.0, 2.0, 3.0])
        );
        assert!(parse("1,2\n", 3).is_err_and(|reason| reason.contains("line 1: 2 numbers")));
        assert!(parse("1,2,3\na,b,c\n", 3).is_err_and(|reason| reason.contains("line 2")));
        assert!(parse("1,x,3\n", 3).is_err_and(|reason| reason.contains("line 1")));
        for nothing in ["", "b1,b2,z\n", "PNG\n", "0.5;0.3;0.7\n"] {
            assert!(
                parse(nothing, 3).is_err_and(|reason| reason.contains("no row of 2 moments")),
                "{nothing}"
            );
        }
    }

    #[test]
    fn archives_and_tables_hold_the_same() {
        let rows = [
            Row { bounds: [0.25, 0.5, 0.2, 0.6], is_bounded: true },
            Row { bounds: [0.0, 1.0, 0.0, 1.0], is_bounded: false },
        ];
        assert_eq!(csv(&rows).lines().nth(1), Some("0.25,0.5,0.2,0.6,1"));
        assert_eq!(csv(&rows).lines().nth(2), Some("0,1,0,1,0"));
    }
}
