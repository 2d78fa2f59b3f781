//! Single precision beside other programs' shaders, on the inputs that these were run with.
//!
//! The inputs and outputs are not part of the project; where they are missing there is nothing to compare with.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use moment_problem::arithmetic::{FloatFloat, Real};
use moment_problem::hamburger::{hamburger, hamburger4};
use moment_problem::hausdorff::hausdorff4;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn folder() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).parent()?.join("shared/vectors/peers");
    path.is_dir().then_some(path)
}

/// A row: moments, z_f, alpha, the peer's bound and the exact one.
struct Row {
    kind: String,
    inputs: Vec<f32>,
    z_f: f32,
    alpha: f32,
    peer: f64,
    exact: Option<f64>,
}

fn rows(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let headers = reader.headers().unwrap().clone();
    let place = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let moments: Vec<usize> =
        (0..headers.len()).filter(|&i| headers[i].starts_with("in") && headers[i].len() == 3).collect();
    let number = |text: &str| text.parse::<f64>().unwrap_or(f64::NAN);
    let read = |row: csv::StringRecord| Row {
        kind: row[place("kind")].to_owned(),
        inputs: moments.iter().map(|&i| number(&row[i]) as f32).collect(),
        z_f: number(&row[place("zf")]) as f32,
        alpha: number(&row[place("alpha")]) as f32,
        peer: number(&row[place("G_lvp")]),
        exact: row[place("exact_in")].parse().ok(),
    };
    reader.records().map(|row| read(row.unwrap())).collect()
}

/// Errors against the exact bound, ascending.
#[derive(Default)]
struct Errors(Vec<f64>);

impl Errors {
    fn push(&mut self, value: f64, exact: f64) {
        // A NaN that a clamp hides is an error all the same.
        self.0.push(if value.is_nan() { 1.0 } else { (value.clamp(0.0, 1.0) - exact).abs() });
    }

    fn sorted(mut self) -> Vec<f64> {
        self.0.sort_by(f64::total_cmp);
        self.0
    }
}

/// Maximum, 99th percentile and share above 1e-3.
fn summary(sorted: &[f64]) -> [f64; 3] {
    let above = sorted.iter().filter(|&&error| error > 1e-3).count();
    let p99 = sorted[(0.99 * sorted.len() as f64).ceil() as usize - 1];
    [*sorted.last().unwrap(), p99, above as f64 / sorted.len() as f64]
}

const CASES: [(&str, &[f32]); 6] = [
    ("mjp_hamburger4_f32", &[0.5; 4]),
    ("mjp_hausdorff4_f32", &[0.5; 4]),
    ("forge3d_msm4_f32", &[0.5; 4]),
    ("mboit_power4_f32", &[0.0, 0.375, 0.0, 0.375]),
    ("mboit_power6_f32", &[0.0, 0.48, 0.0, 0.451, 0.0, 0.45]),
    ("mboit_power8_f32", &[0.0, 0.75, 0.0, 0.676_666_7, 0.0, 0.63, 0.0, 0.600_303_03]),
];

fn ours<R: Real>(file: &str, b: &[R], z_f: R) -> R {
    fn array<R: Real, const M: usize>(b: &[R]) -> [R; M] {
        std::array::from_fn(|i| b[i])
    }
    match (file, b.len()) {
        ("mjp_hausdorff4_f32", _) => hausdorff4(&array(b), z_f).lower,
        (_, 4) => hamburger4(&array(b), z_f).lower,
        (_, 6) => hamburger(&array::<R, 6>(b), z_f).lower,
        _ => hamburger(&array::<R, 8>(b), z_f).lower,
    }
}

/// Ours first.
type Both = [Errors; 2];

#[test]
fn pairs_of_single_floats_err_less_than_other_programs() {
    let Some(folder) = folder() else {
        println!("no outputs of other programs at hand: nothing compared");
        return;
    };
    for (file, target) in CASES {
        let mut by_kind: BTreeMap<String, Both> = BTreeMap::new();
        for row in rows(&folder.join(format!("{file}.csv"))) {
            let Some(exact) = row.exact else { continue };
            let pair = FloatFloat::from;
            let bias = |(&b, &t): (&f32, &f32)| pair(b) + pair(row.alpha) * (pair(t) - pair(b));
            let biased: Vec<FloatFloat> = row.inputs.iter().zip(target).map(bias).collect();
            let value = f64::from(ours(file, &biased, pair(row.z_f)).to_f32());
            assert!(value.is_finite() && (0.0..=1.0).contains(&value), "{file} {}: {value}", row.kind);
            for kind in ["all kinds", &row.kind] {
                let [mine, theirs] = by_kind.entry(kind.to_owned()).or_default();
                mine.push(value, exact);
                theirs.push(row.peer, exact);
            }
        }
        assert!(by_kind.len() > 10, "{file}");
        for (kind, [mine, theirs]) in by_kind {
            let (mine, theirs) = (summary(&mine.sorted()), summary(&theirs.sorted()));
            println!(
                "{file:20} {kind:10} ours {:.1e} {:.1e} {:.4}  theirs {:.1e} {:.1e} {:.4}",
                mine[0], mine[1], mine[2], theirs[0], theirs[1], theirs[2]
            );
            // The result itself is a single float: no error below half of its last place counts.
            let below = |i: usize| mine[i] <= theirs[i].max(LAST_PLACE);
            assert!(below(0) && below(1) && mine[2] <= theirs[2], "{file}, {kind}: {mine:?} {theirs:?}");
            assert!(mine[2] == 0.0, "{file}, {kind}");
        }
    }
}

/// Half of the distance of neighbouring single floats below 1.
const LAST_PLACE: f64 = 3e-8;
