//! Shaders against their Rust twins in single precision and against double precision, on fragments of scenes and on
//! degenerate kernels.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]
// The measured errors are for people to read.
#![allow(clippy::print_stdout)]

#[path = "../adapter/mod.rs"]
mod adapter;
mod compute;
mod fragments;
mod frames;
mod languages;
mod modules;
mod pairwise;
#[path = "../programs/mod.rs"]
mod programs;
mod scattering;
mod scattering_faults;
mod search;
mod soft_shadow_faults;
mod soft_shadows;
mod stochastic;
mod temporal;

use std::process::ExitCode;

use adapter::gpu_trial;
use fragments::{FRAGMENTS, Inputs};
use libtest_mimic::{Arguments, Failed};
use moment_problem::MomentBound;
use quantization::published::{self, Published};
use shadow_filtering::{DepthBias, Kernel, Range, RealTime, Reference, Technique, TechniqueSpec, wgsl};

/// The shader's error against double precision may be this many times that of Rust in single precision.
const RATIO: f64 = 2.0;

/// Where the shader's largest errors exceed that, on at most so many inputs, Rust is asked again with inputs moved by a
/// unit in the last place: a bound that such a change moves as far is no fault of the shader.
const ILL_CONDITIONED: usize = 16;

/// Errors below this are as good as none: two units in the last place of 1.
const NEGLIGIBLE: f64 = 2.4e-7;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = Vec::new();
    for (name, spec) in techniques() {
        let technique = spec.build().unwrap();
        assert!(technique.real_time().and_then(RealTime::shader).is_some(), "{name} has no shader");
        trials.push(gpu_trial(format!("shade::{name}"), move || shade(&technique, "")));
        let technique = spec.build().unwrap();
        trials.push(gpu_trial(format!("encode::{name}"), move || encode(&technique)));
    }
    trials.push(gpu_trial("shade::percentage_closer".into(), || percentage_closer("")));
    for transform in published::ALL.iter().filter(|p| matches!(p.order, 4 | 6)) {
        let name = transform.name.replace(' ', "_");
        trials.push(gpu_trial(format!("transform::{name}"), || quantise_and_decode(transform)));
    }
    trials.extend(languages::trials());
    trials.extend(modules::trials());
    trials.extend(frames::trials());
    trials.extend(pairwise::trials());
    trials.extend(scattering::trials());
    trials.extend(scattering_faults::trials());
    trials.extend(soft_shadows::trials());
    trials.extend(stochastic::trials());
    trials.extend(temporal::trials());
    trials.push(search::trial());
    trials.push(gpu_trial("planted_faults".into(), planted_faults));
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Every technique with a shader. Moment biases are given, so that double precision has the same ones.
fn techniques() -> Vec<(&'static str, TechniqueSpec)> {
    let named = |bound: &str| TechniqueSpec::named(bound).unwrap();
    let exponential = |bound: &str, exponent: f64, negative_exponent: Option<f64>| TechniqueSpec {
        exponent: Some(exponent),
        negative_exponent,
        ..named(bound)
    };
    let csm = |coefficients: usize| TechniqueSpec { coefficients: Some(coefficients), ..named("csm") };
    let moments = |bound: MomentBound| TechniqueSpec {
        alpha: Some(bound.single_precision_bias()),
        ..TechniqueSpec::from(bound)
    };
    vec![
        ("vsm", named("vsm")),
        ("esm_80", exponential("esm", 80.0, None)),
        ("esm_11", exponential("esm", 11.0, None)),
        ("evsm2", exponential("evsm", 10.0, None)),
        ("evsm4", exponential("evsm", 42.0, Some(10.0))),
        ("lvsm4", TechniqueSpec { layers: Some(4), ..named("lvsm") }),
        ("csm4", csm(4)),
        ("csm16", csm(16)),
        ("hamburger2", moments(MomentBound::Hamburger2)),
        ("hamburger4", moments(MomentBound::Hamburger4)),
        ("hamburger4_16_bit", TechniqueSpec { alpha: Some(6e-5), beta: 0.25, ..named("hamburger4") }),
        ("hamburger4_unit", TechniqueSpec { range: Some(Range::Unit), ..moments(MomentBound::Hamburger4) }),
        ("hamburger6", moments(MomentBound::Hamburger6)),
        ("hausdorff4", moments(MomentBound::Hausdorff4)),
        ("trigonometric4", moments(MomentBound::Trigonometric4)),
    ]
}

/// Mean, 99.9th percentile and largest of a set of errors.
struct Errors([f64; 3]);

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [mean, most, all] = self.0;
        write!(f, "{mean:.2e}, {most:.2e}, {all:.2e}")
    }
}

impl Errors {
    fn of(mut errors: Vec<f64>) -> Self {
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
        Self([mean, at(0.999), at(1.0)])
    }

    fn is_within(&self, other: &Self, ratio: f64) -> bool {
        self.0.iter().zip(other.0).all(|(mine, other)| *mine <= (ratio * other).max(NEGLIGIBLE))
    }
}

fn compare(what: &str, shader: &[f32], single: &[f32], exact: &[f64], scales: &[f64]) -> Result<(), Failed> {
    if let Some(i) = shader.iter().position(|value| !value.is_finite()) {
        return Err(format!("{what}: value {i} of the shader is {}", shader[i]).into());
    }
    let against = |values: &[f32]| {
        let pairs = values.iter().zip(exact).enumerate();
        Errors::of(pairs.map(|(i, (v, e))| (f64::from(*v) - e).abs() / scales[i % scales.len()]).collect())
    };
    let (shader, single) = (against(shader), against(single));
    println!("{what}: mean, 99.9 %, largest error: shader {shader}; Rust in f32 {single}");
    if shader.is_within(&single, RATIO) {
        return Ok(());
    }
    Err(format!("{what}: the shader errs by {shader} (mean, 99.9 %, largest), Rust in f32 by {single}")
        .into())
}

/// `fault` replaces `FROM=>TO` in the shader, for checking that the comparison can fail.
fn shade(technique: &Technique, fault: &str) -> Result<(), Failed> {
    let real_time = technique.real_time().ok_or("no shader")?;
    let mut shader = real_time.shader().ok_or("no shader")?;
    if let Some((from, to)) = fault.split_once("=>") {
        assert!(shader.contains(from), "the fault `{from}` is not in the shader");
        shader = shader.replacen(from, to, 1);
    }
    let inputs = Inputs::of_scenes(technique);
    assert!(inputs.count() >= FRAGMENTS, "{} fragments", inputs.count());
    let call = "
    var filtered: array<f32, CHANNELS>;
    for (var k = 0u; k < CHANNELS; k++) { filtered[k] = inputs[start + k]; }
    outputs[first] = shade(filtered, inputs[start + CHANNELS]);";
    let each = technique.channels() + 1;
    for (kind, inputs) in [("fragments", inputs), ("degenerate kernels", Inputs::degenerate(technique))] {
        let found = compute::map(&shader, call, (&inputs.values, each), 1, None)?;
        let items = || inputs.values.chunks_exact(each).map(|item| item.split_at(each - 1));
        let single: Vec<f32> = items().map(|(b, z)| real_time.shade_single(b, z[0])).collect();
        let double = |(b, z): (&[f32], &[f32])| {
            let b: Vec<f64> = b.iter().map(|&v| f64::from(v)).collect();
            technique.shade(&b, f64::from(z[0]))
        };
        let exact = items().map(double).collect::<Result<Vec<f64>, _>>()?;
        let what = format!("{}, shade, {} {kind}", technique.name(), inputs.count());
        let moved = |i: usize| {
            let (b, z) = inputs.values[i * each..(i + 1) * each].split_at(each - 1);
            moved_error(real_time, b, z[0], exact[i])
        };
        let single = excuse(&what, &found, single, &exact, moved);
        compare(&what, &found, &single, &exact, &[1.0])?;
    }
    Ok(())
}

/// The reference with its receiver plane; single precision errs where a depth and the plane are equal but for rounding.
fn percentage_closer(fault: &str) -> Result<(), Failed> {
    let kernel = Kernel::gaussian(9, 2.4)?;
    let reference = Reference { bias: DepthBias::default(), plane_limit: 0.05 };
    let mut shader = wgsl::percentage_closer(&kernel, reference.plane_limit);
    if let Some((from, to)) = fault.split_once("=>") {
        assert!(shader.contains(from), "the fault `{from}` is not in the shader");
        shader = shader.replacen(from, to, 1);
    }
    let call = "
    let at = vec2<f32>(inputs[start], inputs[start + 1u]) + 0.5;
    let gradient = vec2<f32>(inputs[start + 3u], inputs[start + 4u]);
    outputs[first] = percentage_closer(depths, at, inputs[start + 2u], gradient);";
    let mut all: [Vec<f64>; 3] = Default::default();
    for (map, receivers) in fragments::receivers() {
        let inputs: Vec<f32> = receivers
            .iter()
            .flat_map(|r| [r.x as f64, r.y as f64, r.depth, r.gradient[0], r.gradient[1]].map(|v| v as f32))
            .collect();
        let depths = Some((map.depths(), map.width() as u32));
        let found = compute::map(&shader, call, (&inputs, 5), 1, depths)?;
        all[0].extend(found.into_iter().map(f64::from));
        all[1].extend(
            receivers.iter().map(|r| f64::from(fragments::percentage_closer_single(&map, &kernel, r))),
        );
        all[2].extend(receivers.iter().map(|r| reference.intensity(&map, &kernel, r, 0.0)));
    }
    let [found, single, exact] = all;
    assert!(found.len() >= FRAGMENTS, "{} fragments", found.len());
    let single_precision =
        |values: Vec<f64>| values.into_iter().map(|value| value as f32).collect::<Vec<_>>();
    let what = format!("PCF, shade, {} fragments", found.len());
    compare(&what, &single_precision(found), &single_precision(single), &exact, &[1.0])
}

/// The largest error of Rust in single precision when one input moves to its neighbour.
fn moved_error(technique: &dyn RealTime, b: &[f32], z_f: f32, exact: f64) -> f64 {
    let mut values = b.to_vec();
    values.push(z_f);
    let mut largest: f64 = 0.0;
    for k in 0..values.len() {
        for neighbour in [values[k].next_up(), values[k].next_down()] {
            let mut moved = values.clone();
            moved[k] = neighbour;
            let g = technique.shade_single(&moved[..b.len()], moved[b.len()]);
            largest = largest.max((f64::from(g) - exact).abs());
        }
    }
    largest
}

/// Replaces the values of Rust that are far better than the shader's by those of its worst neighbour, few as they are.
fn excuse(
    what: &str,
    shader: &[f32],
    mut single: Vec<f32>,
    exact: &[f64],
    moved: impl Fn(usize) -> f64,
) -> Vec<f32> {
    let error = |value: f32, i: usize| (f64::from(value) - exact[i]).abs();
    let most = single.iter().enumerate().fold(0.0, |most: f64, (i, &v)| most.max(error(v, i)));
    let worse: Vec<usize> = (0..shader.len()).filter(|&i| error(shader[i], i) > RATIO * most).collect();
    if worse.len() > ILL_CONDITIONED {
        return single;
    }
    for i in worse {
        let moved = moved(i);
        println!(
            "{what}: input {i}: the shader errs by {:.2e}, Rust in f32 by {:.2e}, by {moved:.2e} one unit aside",
            error(shader[i], i),
            error(single[i], i)
        );
        single[i] = (exact[i] + moved) as f32;
    }
    single
}

/// Both directions of a published transform of power moments, on the moments of the scenes' depths.
fn quantise_and_decode(published: &Published) -> Result<(), Failed> {
    let m = published.order;
    let bound = if m == 4 { MomentBound::Hamburger4 } else { MomentBound::Hamburger6 };
    // Single floats round nothing further.
    let transform = Some(published.name.to_owned());
    let stored = TechniqueSpec { transform, ..TechniqueSpec::from(bound) }.build()?;
    let transform = stored.encoding().transform();
    let [quantise, dequantise] = stored.transform_wgsl();
    let functions = format!("const CHANNELS: u32 = {m}u;\n{quantise}{dequantise}");
    let call = |name: &str| {
        format!(
            "var values: array<f32, CHANNELS>;
    for (var k = 0u; k < CHANNELS; k++) {{ values[k] = inputs[start + k]; }}
    var result = {name}(values);
    for (var k = 0u; k < CHANNELS; k++) {{ outputs[first + k] = result[k]; }}"
        )
    };
    let depths = fragments::depths();
    let (mut moments, mut single) = (vec![0.0f32; depths.len() * m], vec![0.0f32; depths.len() * m]);
    for (i, &depth) in depths.iter().enumerate() {
        stored.evaluate(depth, &mut moments[i * m..(i + 1) * m]);
        stored.encode(depth, &mut single[i * m..(i + 1) * m]);
    }
    let exact = |values: &[f32], apply: &dyn Fn(&[f64], &mut [f64])| {
        let values: Vec<f64> = values.iter().map(|&value| f64::from(value)).collect();
        let mut out = vec![0.0; values.len()];
        values.chunks_exact(m).zip(out.chunks_exact_mut(m)).for_each(|(from, to)| apply(from, to));
        out
    };
    let found = compute::map(&functions, &call("quantise"), (&moments, m), m, None)?;
    let truth = exact(&moments, &|b, out| transform.apply(b, out));
    compare(&format!("{}, transform", published.name), &found, &single, &truth, &[1.0])?;
    let found = compute::map(&functions, &call("dequantise"), (&single, m), m, None)?;
    let mut decoded = vec![0.0; single.len()];
    single.chunks_exact(m).zip(decoded.chunks_exact_mut(m)).for_each(|(from, to)| stored.restore(from, to));
    let truth = exact(&single, &|s, out| transform.invert(s, out));
    compare(&format!("{}, inverse", published.name), &found, &decoded, &truth, &[1.0])
}

fn encode(technique: &Technique) -> Result<(), Failed> {
    let real_time = technique.real_time().ok_or("no shader")?;
    let shader = real_time.shader().ok_or("no shader")?;
    let channels = technique.channels();
    let depths: Vec<f32> = fragments::depths();
    let call = "
    var stored = encode(inputs[start]);
    for (var k = 0u; k < CHANNELS; k++) { outputs[first + k] = stored[k]; }";
    let found = compute::map(&shader, call, (&depths, 1), channels, None)?;
    let (mut single, mut exact) = (vec![0.0; found.len()], vec![0.0; found.len()]);
    for (i, &depth) in depths.iter().enumerate() {
        let place = i * channels..(i + 1) * channels;
        technique.evaluate(depth, &mut single[place.clone()]);
        technique.evaluate(f64::from(depth), &mut exact[place]);
    }
    // Relative to the largest value of a channel: warps span many orders of magnitude.
    let scales: Vec<f64> = (0..channels)
        .map(|k| exact.iter().skip(k).step_by(channels).fold(0.0, |most: f64, v| most.max(v.abs())))
        .collect();
    compare(
        &format!("{}, encode, {} depths", technique.name(), depths.len()),
        &found,
        &single,
        &exact,
        &scales,
    )
}

/// A wrong sign or constant in a shader is found.
fn planted_faults() -> Result<(), Failed> {
    if percentage_closer("+ 0.5 - at=>- at").is_ok() {
        return Err("PCF: the comparison missed a plane that is off by half a texel".into());
    }
    for (name, fault) in [
        ("vsm", "variance = abs(second - mean * mean)=>variance = abs(second - 0.999 * mean * mean)"),
        ("esm_80", "2.12194440e-4=>2.12e-4"),
        ("csm16", "wave.x * stored[2u * 0u] - =>wave.x * stored[2u * 0u] + "),
        ("hamburger4", "points.s.x - points.s.y * w.y=>points.s.x - points.s.y * w.x"),
        ("hamburger6", "front + weight, w < 0.0=>front + weight, w > 0.0"),
        ("hausdorff4", "1.0 - at_z_f - at_one=>1.0 - at_one"),
        ("trigonometric4", "let product = 1.0 + cosine=>let product = 1.0 - cosine"),
    ] {
        let (_, spec) =
            techniques().into_iter().find(|(known, _)| *known == name).ok_or("no such technique")?;
        if shade(&spec.build()?, fault).is_ok() {
            return Err(format!("{name}: the comparison missed `{fault}`").into());
        }
    }
    Ok(())
}
