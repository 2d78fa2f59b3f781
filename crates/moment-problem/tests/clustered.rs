//! Kernels whose depths nearly coincide, on the whole line: the right number, proved, whatever the width and the place.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use moment_problem::{Basis, DepthDistribution, Hamburger, Interval, LowerBound, MomentError, closed_form};
use random_stream::Random;
use std::path::Path;

/// Answers whose attained and proved values differ by more than this are errors.
const CERTIFIED_GAP: f64 = 1e-8;

/// Recorded bounds have twenty digits; weights as written sum to 1 up to rounding.
const TOLERANCE: f64 = 1e-12;

#[test]
fn recorded_clusters_are_right_and_proved() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/clustered.csv");
    let mut reader = csv::Reader::from_path(path).unwrap();
    let mut count = 0;
    for row in reader.records().map(Result::unwrap) {
        let number = |i: usize| row[i].parse::<f64>().unwrap();
        let atoms = row[2].split(',').map(|atom| {
            let (z, w) = atom.split_once(':').unwrap();
            (z.parse::<f64>().unwrap(), w.parse::<f64>().unwrap())
        });
        let (depths, weights): (Vec<f64>, Vec<f64>) = atoms.unzip();
        let z = DepthDistribution::new(&depths, &weights).unwrap();
        let basis: Basis = row[1].parse().unwrap();
        let solver = closed_form(&basis, Interval::Real).unwrap().unwrap();
        let bounds =
            solver.bounds_of(&z, number(3)).unwrap_or_else(|error| panic!("row {}: {error}", &row[0]));
        let (lower, upper, f) = (number(4), number(5), number(6));
        let error = (bounds.lower - lower).abs().max((bounds.upper - upper).abs());
        assert!(error <= TOLERANCE, "row {}: {bounds:?} against {lower}, {upper}", &row[0]);
        assert!(bounds.gap() <= CERTIFIED_GAP, "row {}: {bounds:?}", &row[0]);
        assert!(bounds.lower <= f && bounds.certificate.lower_proved <= lower, "row {}: {bounds:?}", &row[0]);
        count += 1;
    }
    assert_eq!(count, 60);
}

/// One or two clusters of widths from 1e-7 to 1e-2, near 0 or far from it, with weights of any size; z_f at a depth, within the
/// cluster, beside it or far away.
fn clustered(random: &mut Random) -> (DepthDistribution, f64) {
    let width = 10f64.powf(-2.0 - 5.0 * random.unit());
    let centre = match random.below(4) {
        0 => 0.0,
        1 => 1e6 * (random.unit() - 0.5),
        _ => random.unit(),
    };
    let second = random.below(4) == 0;
    let count = 1 + random.below(9);
    let mut depths: Vec<f64> = (0..count).map(|_| centre + width * (random.unit() - 0.5)).collect();
    if second {
        let offset = random.unit();
        depths.extend((0..1 + random.below(3)).map(|_| centre + offset + width * random.unit()));
    }
    let smallest = 5.0 * random.unit();
    let raw: Vec<f64> = depths.iter().map(|_| 10f64.powf(-smallest * random.unit())).collect();
    let sum: f64 = raw.iter().sum();
    let weights: Vec<f64> = raw.iter().map(|w| w / sum).collect();
    let z_f = match random.below(5) {
        0 => depths[random.below(depths.len())],
        1 => centre + width * (random.unit() - 0.5),
        2 => centre + 3.0 * width * (random.unit() - 0.5),
        3 => {
            depths[random.below(depths.len())]
                + width * 10f64.powf(-8.0 * random.unit()) * (random.unit() - 0.5)
        }
        _ => centre + 2.0 * (random.unit() - 0.5),
    };
    (DepthDistribution::new(&depths, &weights).unwrap(), z_f)
}

/// How often moments alone leave the answer open, and why.
#[derive(Debug, Default)]
struct Counts {
    answered: usize,
    /// Rounding put the moments outside the set of moments, and the answer depends on the way back.
    undetermined: usize,
    /// Rounding put them further outside than rounding can.
    impossible: usize,
}

fn check<const M: usize>(z: &DepthDistribution, z_f: f64, from_doubles: Option<&mut Counts>)
where
    Hamburger<M>: LowerBound,
{
    let solver = Hamburger::<M>::default();
    let bounds = solver.bounds_of(z, z_f).unwrap_or_else(|error| panic!("{M} {error}: {z:?} at {z_f:?}"));
    let certificate = &bounds.certificate;
    let context = || format!("{M}: {bounds:?} of {z:?} at {z_f:?}");
    assert!(bounds.gap() <= CERTIFIED_GAP && bounds.gap() >= 0.0, "{}", context());
    assert!(bounds.lower <= z.cdf(z_f) && bounds.upper >= z.cdf_inclusive(z_f), "{}", context());
    // The same kernel seen from z_f, where nothing cancels, mirrored: another way through the arithmetic.
    let offsets: Vec<f64> = z.depths().iter().map(|z| z_f - z).collect();
    if offsets.iter().zip(z.depths()).all(|(u, z)| z_f - u == *z && *z + u == z_f) {
        let weights: Vec<f64> = z.weights().iter().map(|w| w.to_f64()).collect();
        let mirrored = DepthDistribution::new(&offsets, &weights).unwrap();
        let other = solver.bounds_of(&mirrored, 0.0).unwrap();
        let error =
            (bounds.lower - (1.0 - other.upper)).abs().max((bounds.upper - (1.0 - other.lower)).abs());
        assert!(error <= 2e-8, "{error}: {} {other:?}", context());
    }
    assert!(certificate.lower_proved <= bounds.lower && certificate.upper_proved >= bounds.upper);
    let Some(from_doubles) = from_doubles else { return };
    // Moments that arrive as doubles are another distribution's; its bounds are certified or refused.
    let moments: Vec<f64> = z.moments(solver.basis());
    match solver.bounds(&moments, z_f) {
        Ok(bounds) => {
            assert!(bounds.gap() <= CERTIFIED_GAP && bounds.lower <= bounds.upper, "{}", context());
            from_doubles.answered += 1;
        }
        Err(MomentError::Uncertified { .. }) => from_doubles.undetermined += 1,
        Err(MomentError::NotPositiveDefinite { .. }) => from_doubles.impossible += 1,
        Err(error) => panic!("{error}: {}", context()),
    }
}

/// All orders on random clusters; `MSM_CLUSTERS` sets their number.
#[test]
fn random_clusters_are_certified() {
    let count = std::env::var("MSM_CLUSTERS").map_or(10_000, |count| count.parse().unwrap());
    let mut random = Random::new(18);
    let mut from_doubles: [Counts; 4] = Default::default();
    for i in 0..count {
        let (z, z_f) = clustered(&mut random);
        // The way back into the set of moments costs ten times the rest.
        let counts = Some(&mut from_doubles[i % 4]).filter(|_| i % 20 < 4);
        match i % 4 {
            0 => check::<2>(&z, z_f, counts),
            1 => check::<4>(&z, z_f, counts),
            2 => check::<6>(&z, z_f, counts),
            _ => check::<8>(&z, z_f, counts),
        }
    }
    println!("moments as doubles: {from_doubles:?}");
}
