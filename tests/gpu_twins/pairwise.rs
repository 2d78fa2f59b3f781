//! Shaders against double precision input by input, on kernels whose bounds rounding hardly moves: aggregates over hard
//! kernels hide a wrong constant, these do not.

use super::adapter::gpu_trial;
use super::compute;
use libtest_mimic::{Failed, Trial};
use moment_problem::MomentBound;
use random_stream::Random;
use shadow_filtering::{Technique, TechniqueSpec};

/// Kernels of a technique.
const COUNT: usize = 4096;

/// A bias that moves every kernel deep into the set of moments: the wrong b* shows by this share of what it is off.
const ALPHA: f64 = 0.01;

/// Both ends of the bound count.
const BETA: f64 = 0.25;

/// An answer may be off by what so many roundings of each of its inputs do, since single precision rounds some tens of
/// intermediate results whose sensitivities are about those of the inputs; 49 were seen for trigonometric moments in Rust ...
const ROUNDINGS: f64 = 96.0;

/// ... and by four units in the last place of 1.
const FLOOR: f64 = 4.8e-7;

/// Kernels that may err by more: the quartic of trigonometric moments has double roots where the bound itself is smooth. A
/// quarter of a hundredth of all; a wrong constant concerns every kernel.
const UNEXPLAINED: usize = COUNT / 400;

/// Errors of all kernels together must not look as if one input had been moved: rounding goes both ways and leaves
/// at most 9e-8 of the mean over thousands (six moments in Rust); a shift of three units in the last place of z_f is 2e-7.
const COMMON_SHIFT: f64 = 1.3e-7;

pub fn trials() -> Vec<Trial> {
    let techniques = [
        ("hamburger4", MomentBound::Hamburger4),
        ("hamburger6", MomentBound::Hamburger6),
        ("hausdorff4", MomentBound::Hausdorff4),
        ("trigonometric4", MomentBound::Trigonometric4),
    ];
    let spec = |bound| TechniqueSpec { alpha: Some(ALPHA), beta: BETA, ..TechniqueSpec::from(bound) };
    let mut trials = Vec::new();
    for (name, bound) in techniques {
        trials.push(gpu_trial(format!("pairwise::{name}"), move || {
            let technique = spec(bound).build()?;
            compare(&technique, bound, "")
        }));
    }
    trials.push(gpu_trial("pairwise::planted_faults".into(), move || {
        let call = "biased_bounds(filtered, unit(z_f";
        let shifted = |by: &str| format!("{call}))=>{call} + {by}))");
        for (number, fault) in [
            (0, "var centre = CENTRE;=>var centre = CENTRE; centre[0] += 0.05;".to_owned()),
            (0, shifted("1e-5")),
            (1, shifted("1e-5")),
            (3, shifted("1e-6")),
            (2, shifted("2e-7")),
        ] {
            let (name, bound) = techniques[number];
            let technique = spec(bound).build()?;
            if compare(&technique, bound, &fault).is_ok() {
                return Err(format!("{name}: the comparison missed `{fault}`").into());
            }
        }
        Ok(())
    }));
    trials
}

/// Filtered moments and z_f of a kernel of three surfaces and more, z_f at some distance from each.
fn inputs(technique: &Technique) -> Vec<f32> {
    let channels = technique.channels();
    let mut random = Random::stream(7, channels as u64);
    let mut values = Vec::with_capacity(COUNT * (channels + 1));
    while values.len() < COUNT * (channels + 1) {
        let surfaces = 3 + (random.unit() * 2.0) as usize;
        let depths: Vec<f64> = (0..surfaces).map(|_| 0.05 + 0.9 * random.unit()).collect();
        let weights: Vec<f64> = (0..surfaces).map(|_| 0.2 + random.unit()).collect();
        let z_f = 0.05 + 0.9 * random.unit();
        if depths.iter().any(|z| (z - z_f).abs() < 0.05) {
            continue;
        }
        let total: f64 = weights.iter().sum();
        let (mut sum, mut vector) = (vec![0.0; channels], vec![0.0; channels]);
        for (&z, weight) in depths.iter().zip(&weights) {
            technique.evaluate(z, &mut vector);
            sum.iter_mut().zip(&vector).for_each(|(sum, b)| *sum += weight / total * b);
        }
        values.extend(sum.into_iter().map(|b| b as f32));
        values.push(z_f as f32);
    }
    values
}

/// `fault` replaces `FROM=>TO` in the shader.
fn compare(technique: &Technique, bound: MomentBound, fault: &str) -> Result<(), Failed> {
    let real_time = technique.real_time().ok_or("no shader")?;
    let mut shader = real_time.shader().ok_or("no shader")?;
    if let Some((from, to)) = fault.split_once("=>") {
        assert!(shader.contains(from), "the fault `{from}` is not in the shader");
        shader = shader.replacen(from, to, 1);
    }
    let call = "
    var filtered: array<f32, CHANNELS>;
    for (var k = 0u; k < CHANNELS; k++) { filtered[k] = inputs[start + k]; }
    outputs[first] = shade(filtered, inputs[start + CHANNELS]);";
    let each = bound.order() + 1;
    let values = inputs(technique);
    let found = compute::map(&shader, call, (&values, each), 1, None)?;
    let single: Vec<f32> = values
        .chunks_exact(each)
        .map(|item| real_time.shade_single(&item[..each - 1], item[each - 1]))
        .collect();
    judge(technique, &values, each, &single).map_err(|reason| format!("Rust in f32: {reason}"))?;
    judge(technique, &values, each, &found).map_err(|reason| format!("shader: {reason}").into())
}

/// Whether every answer is right to what rounding explains, and all together show no shift of an input.
fn judge(technique: &Technique, values: &[f32], each: usize, found: &[f32]) -> Result<(), String> {
    let shade = |item: &[f64]| technique.shade(&item[..each - 1], item[each - 1]).map_err(|e| e.to_string());
    let mut projections = vec![(0.0f64, 0.0f64); each];
    let mut largest: f64 = 0.0;
    let mut unexplained = 0;
    for (i, (item, &g)) in values.chunks_exact(each).zip(found).enumerate() {
        let exact: Vec<f64> = item.iter().map(|&v| f64::from(v)).collect();
        let error = f64::from(g) - shade(&exact)?;
        let mut slopes = Vec::with_capacity(each);
        let mut tolerance = FLOOR;
        for k in 0..each {
            let (mut above, mut below) = (exact.clone(), exact.clone());
            (above[k], below[k]) = (f64::from(item[k].next_up()), f64::from(item[k].next_down()));
            let change = 0.5 * (shade(&above)? - shade(&below)?);
            slopes.push(change / (0.5 * (above[k] - below[k])));
            // Inputs near 0 are rounded like the others once they meet them in a sum.
            tolerance += ROUNDINGS * change.abs().max(slopes[k].abs() * 3e-8);
        }
        // NaN is no error within it.
        if error.is_nan() || error.abs() > tolerance {
            unexplained += 1;
            if unexplained > UNEXPLAINED {
                let more = format!("and {UNEXPLAINED} before it more than rounding explains");
                return Err(format!("input {i} errs by {error:.2e}, {tolerance:.2e} is explained; {more}"));
            }
            continue;
        }
        largest = largest.max(error.abs() / tolerance);
        for (sums, slope) in projections.iter_mut().zip(&slopes) {
            let weight = 1.0 / (tolerance * tolerance);
            *sums = (sums.0 + weight * error * slope, sums.1 + weight * slope * slope);
        }
    }
    let shifts: Vec<f64> = projections.into_iter().map(|(along, square)| along / square).collect();
    let listed: Vec<String> = shifts.iter().map(|shift| format!("{shift:.1e}")).collect();
    println!("{}: {largest:.2} of the tolerance, shifts {}", technique.name(), listed.join(", "));
    match shifts.iter().position(|shift| shift.is_nan() || shift.abs() > COMMON_SHIFT) {
        Some(k) => Err(format!("errors look as if input {k} of {each} were moved by {:.2e}", shifts[k])),
        None => Ok(()),
    }
}
