//! Published and independent numbers: certified bounds, and what public shaders should have returned.

use moment_problem::arithmetic::DoubleDouble;
use moment_problem::hamburger::hamburger;
use moment_problem::hausdorff::hausdorff4;
use moment_problem::{
    Basis, DepthDistribution, ExchangeSimplex, Hamburger, Hausdorff4, Interval, LowerBound, MomentError,
    closed_form,
};
use std::path::{Path, PathBuf};

/// The sample kept here and, where it exists, the full set beside the checkout.
fn files(name: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let full = root.join("../shared/vectors").join(name);
    if !full.exists() {
        println!("skipped: the full set {name} is not here");
    }
    let all = [root.join("tests/data").join(name), full];
    all.into_iter().filter(|path| path.exists()).collect()
}

fn rows(path: &Path) -> Vec<csv::StringRecord> {
    let mut reader =
        csv::Reader::from_path(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    assert!(rows.len() >= 30, "{} has {} rows", path.display(), rows.len());
    rows
}

#[test]
fn certified_reference_bounds_are_met() {
    for path in files("bounds.csv") {
        let mut worst = 0.0f64;
        for row in rows(&path) {
            let number = |i: usize| row[i].parse::<f64>().unwrap();
            let depths: Vec<f64> = serde_json::from_str(&row[2]).unwrap();
            let weights: Vec<f64> = serde_json::from_str(&row[3]).unwrap();
            let z = DepthDistribution::new(&depths, &weights).unwrap();
            let (z_f, lower, upper, gap) = (number(4), number(7), number(8), number(9));
            let (basis, interval) = match &row[1] {
                "trig4" => (Basis::trigonometric(2), Interval::Unit),
                "hausdorff4" => (Basis::power(4), Interval::Unit),
                name if name.starts_with("hamburger") => {
                    (Basis::power(name["hamburger".len()..].parse().unwrap()), Interval::Real)
                }
                list => (list.replace(';', ",").parse().unwrap(), Interval::Unit),
            };
            let mut solvers: Vec<Box<dyn LowerBound>> = Vec::new();
            if let Some(closed) = closed_form(&basis, interval).unwrap() {
                solvers.push(closed);
            }
            if interval == Interval::Unit {
                solvers.push(Box::new(ExchangeSimplex::new(&basis).unwrap()));
            }
            for solver in solvers {
                let b = solver
                    .bounds_of(&z, z_f)
                    .unwrap_or_else(|e| panic!("row {}, {}: {e}", &row[0], solver.name()));
                let error = (b.lower - lower).abs().max((b.upper - upper).abs());
                assert!(
                    error <= gap + 1e-8,
                    "row {}, {}: {b:?} against {lower}, {upper}",
                    &row[0],
                    solver.name()
                );
                assert!(
                    b.certificate.lower_proved <= lower + gap + 1e-12,
                    "row {}: proved too much",
                    &row[0]
                );
                assert!(
                    b.certificate.upper_proved >= upper - gap - 1e-12,
                    "row {}: proved too much",
                    &row[0]
                );
                worst = worst.max(error);
            }
        }
        println!("{}: largest error {worst:e}", path.display());
    }
}

/// Stored values to moments.
type Decode = fn(&[f64]) -> Vec<f64>;

/// How a peer stores moments: the inverse transform to moments, and the bias vector.
struct Peer {
    file: &'static str,
    order: usize,
    unit: bool,
    bias: &'static [f64],
    /// Stored values to moments; `None` if moments are stored.
    decode: Option<Decode>,
    /// Share of rows that plain f64 arithmetic may miss by more than 1e-6.
    f64_misses: f64,
    /// Largest error of the evidence path: rounding of the peer's own float32 constants, where it has any.
    precise: f64,
}

/// GDC16's transform for four moments on [-1, 1].
fn decode_gdc4(q: &[f64]) -> Vec<f64> {
    let (r, g, b, a) = (q[0] - 0.5, q[1], q[2] - 0.5, q[3]);
    let root = 3f64.sqrt();
    vec![-r / 3.0 + root * b, 0.125 * g + a, -0.75 * r + 0.75 * root * b, -0.125 * g + a]
}

/// Four power moments as they are.
const FOUR: Peer =
    Peer { file: "", order: 4, unit: false, bias: &[0.5; 4], decode: None, f64_misses: 0.02, precise: 1e-9 };

/// More of them.
const MORE: Peer = Peer { f64_misses: 0.05, precise: 1e-6, ..FOUR };

const PEERS: [Peer; 6] = [
    Peer { file: "mjp_hamburger4_f32", ..FOUR },
    Peer { file: "mjp_hausdorff4_f32", unit: true, ..FOUR },
    Peer { file: "forge3d_msm4_f32", ..FOUR },
    Peer { file: "mboit_power4_f32", bias: &[0.0, 0.375, 0.0, 0.375], ..FOUR },
    Peer { file: "mboit_power6_f32", order: 6, bias: &[0.0, 0.48, 0.0, 0.451, 0.0, 0.45], ..MORE },
    Peer {
        file: "mboit_power8_f32",
        order: 8,
        bias: &[0.0, 0.75, 0.0, 0.676666667, 0.0, 0.63, 0.0, 0.600303030],
        ..MORE
    },
];

/// The peer multiplies by float32 constants that are not in our sources, so moments differ by 1e-8 and bounds by that
/// times their sensitivity; both precisions show the same differences.
const QUANTISED: [Peer; 1] = [Peer {
    file: "mboit_power4_u16_paper",
    order: 4,
    unit: false,
    bias: &[0.0, 0.628, 0.0, 0.628],
    decode: Some(decode_gdc4),
    f64_misses: 0.5,
    precise: 1e-2,
}];

fn fast(order: usize, unit: bool, b: &[f64], z_f: f64) -> f64 {
    match (order, unit) {
        (4, true) => hausdorff4(&std::array::from_fn(|i| b[i]), z_f).lower,
        (4, false) => hamburger::<f64, 4>(&std::array::from_fn(|i| b[i]), z_f).lower,
        (6, _) => hamburger::<f64, 6>(&std::array::from_fn(|i| b[i]), z_f).lower,
        _ => hamburger::<f64, 8>(&std::array::from_fn(|i| b[i]), z_f).lower,
    }
}

/// Disagreement with `exact_in`, per file: of the plain f64 functions, and of the evidence path.
#[test]
fn exact_values_beside_public_shaders_are_met() {
    let hausdorff = Hausdorff4::new().unwrap();
    for peer in PEERS.iter().chain(&QUANTISED) {
        for path in files(&format!("peers/{}.csv", peer.file)) {
            let solver: &dyn LowerBound = match (peer.order, peer.unit) {
                (4, true) => &hausdorff,
                (4, false) => &Hamburger::<4>::default(),
                (6, _) => &Hamburger::<6>::default(),
                _ => &Hamburger::<8>::default(),
            };
            let (mut errors, mut worst_precise, mut refused) = (Vec::new(), 0.0f64, 0);
            for row in rows(&path) {
                let exact = &row[row.len() - 4];
                if exact.is_empty() {
                    continue; // the stored moments belong to no distribution
                }
                let exact: f64 = exact.parse().unwrap();
                let stored: Vec<f64> = (6..6 + peer.order).map(|i| row[i].parse().unwrap()).collect();
                let moments: Vec<f64> = match peer.decode {
                    Some(decode) => {
                        decode(&stored.iter().map(|q| f64::from((q / 65535.0) as f32)).collect::<Vec<_>>())
                    }
                    None => stored.iter().map(|&b| f64::from(b as f32)).collect(),
                };
                let alpha = f64::from(row[4].parse::<f32>().unwrap());
                let z_f: f64 = f64::from(row[6 + peer.order].parse::<f32>().unwrap());
                let biased: Vec<f64> =
                    moments.iter().zip(peer.bias).map(|(b, bias)| (1.0 - alpha) * b + alpha * bias).collect();
                errors.push((fast(peer.order, peer.unit, &biased, z_f) - exact).abs());
                let precise: Vec<DoubleDouble> = moments
                    .iter()
                    .zip(peer.bias)
                    .map(|(&b, &bias)| {
                        let (b, bias, alpha) =
                            (DoubleDouble::from(b), DoubleDouble::from(bias), DoubleDouble::from(alpha));
                        (DoubleDouble::from(1.0) - alpha) * b + alpha * bias
                    })
                    .collect();
                match solver.bounds_precise(&precise, z_f) {
                    Ok(b) => worst_precise = worst_precise.max((b.lower - exact).abs()),
                    Err(
                        MomentError::Infeasible { .. }
                        | MomentError::Uncertified { .. }
                        | MomentError::NotPositiveDefinite { .. },
                    ) => refused += 1,
                    Err(error) => panic!("{}, case {}: {error}", peer.file, &row[0]),
                }
            }
            errors.sort_by(f64::total_cmp);
            let count = errors.len();
            let misses = errors.iter().filter(|&&e| e > 1e-6).count();
            println!(
                "{} ({count} rows): f64 median {:.1e}, 99 % {:.1e}, max {:.1e}, {misses} above 1e-6; double-double max {worst_precise:.1e}, {refused} refused",
                peer.file,
                errors[count / 2],
                errors[count * 99 / 100],
                errors[count - 1],
            );
            assert!(
                misses as f64 <= peer.f64_misses * count as f64 + 1.0,
                "{}: {misses} f64 misses",
                peer.file
            );
            assert!(worst_precise <= peer.precise, "{}: {worst_precise:e}", peer.file);
        }
    }
}
