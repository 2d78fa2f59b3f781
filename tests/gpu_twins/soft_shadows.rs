//! Compute passes of soft shadows against their Rust twins: tables and queries of whole numbers bit for bit, shadows against
//! double precision on fragments of scenes.

use super::adapter::gpu_trial;
use super::compute::{self, Resource};
use super::fragments::{self, FRAGMENTS};
use applications::field::{Fit, SummedMoments};
use applications::soft_shadow::{
    BlockerSearch, Filter, FilterSize, Fragment, Penumbra, Reconstruction, Storage, Warp, filterable_shader,
    filterable_soft_shadow, filtered_hard_shadow, penumbra_uniform, percentage_closer_shader,
    percentage_closer_soft_shadow, prefix_sums_shader,
};
use libtest_mimic::{Failed, Trial};
use moment_problem::MomentBound;
use moment_problem::arithmetic::Real;
use quantization::Rectangle;
use random_stream::Random;
use shaders::Module;
use shadow_filtering::DepthMap;

/// Half widths in texels of the widest search region.
const HALF_SEARCH: f64 = 13.5;

/// N, with room for whole texels.
const TEXELS: u32 = 29 * 29;

/// Depth bias of the filter.
const BIAS: f64 = 0.002;

/// Worst answers that are left out on both sides, of a hundred thousand and more: at the umbra's threshold and where a region
/// snaps to the next texel, methods jump, and any rounding decides.
const JUMPS: usize = 16;

/// Full widths of the filter of fixed size.
const FIXED_WIDTHS: [f64; 2] = [7.0, 5.5];

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, bound, exponent, storage, alpha) in [
        ("variance", MomentBound::Hamburger2, None, Storage::Unit, 1e-6),
        ("moments4", MomentBound::Hamburger4, None, Storage::Unit, 5e-6),
        ("moments6", MomentBound::Hamburger6, None, Storage::Unit, 3e-5),
        ("hausdorff4", MomentBound::Hausdorff4, None, Storage::Unit, 3e-5),
        ("exponential_moments4", MomentBound::Hamburger4, Some(4.0), Storage::Unit, 5e-6),
        ("signed4", MomentBound::Hamburger4, None, Storage::Signed, 6e-5),
        ("signed6", MomentBound::Hamburger6, None, Storage::Signed, 3e-4),
        ("sparse4", MomentBound::Hamburger4, None, Storage::Sparse, 6e-5),
    ] {
        let warp = exponent.map_or(Warp::None, Warp::Exponential);
        let technique = Reconstruction::new(bound, warp, alpha).and_then(|plain| plain.stored(storage));
        let technique = technique.expect("a technique in use");
        trials.push(Trial::test(format!("wgsl::soft_shadows::{name}"), move || valid(&technique)));
        trials.push(gpu_trial(format!("soft_shadows::{name}"), move || filterable(&technique, "")));
        trials.push(gpu_trial(format!("soft_shadows::{name}::fixed_size"), move || fixed_size(&technique)));
        if exponent.is_none() {
            trials.push(gpu_trial(format!("soft_shadows::{name}::prefix_sums"), move || {
                prefix_sums(&technique, "")
            }));
        }
    }
    trials.push(gpu_trial("soft_shadows::percentage_closer".into(), || percentage_closer("")));
    trials.push(gpu_trial("soft_shadows::planted_faults".into(), super::soft_shadow_faults::planted));
    trials
}

fn searches() -> [(BlockerSearch<f64>, Filter<f64>); 3] {
    let published = (BlockerSearch::published(), Filter::published());
    let later =
        BlockerSearch { epsilon: 0.001, bias_share: 0.5, most_width: 9.0, fit: Fit::Nearest, ..published.0 };
    let filter = Filter { fit: Fit::Nearest, least_width: 2.0, full_bias_width: 9.0, ..published.1 };
    let outwards = Filter { fit: Fit::Outwards, least_width: 1.0, ..filter };
    [published, (later, Filter { dithered: true, ..filter }), (published.0, outwards)]
}

/// One light at infinity, one near.
fn penumbrae() -> [Penumbra<f64>; 2] {
    let sun =
        Penumbra { half_size: [1.0, 0.75], near: None, depth_range: 1.0, texels_per_unit: [HALF_SEARCH; 2] };
    [sun, Penumbra { near: Some(0.5), half_size: [1.5, 1.0], ..sun }]
}

fn cast<R: Real>(
    penumbra: &Penumbra<f64>,
    search: &BlockerSearch<f64>,
    filter: &Filter<f64>,
) -> (Penumbra<R>, BlockerSearch<R>, Filter<R>) {
    (penumbra.cast(), search.cast(), filter.cast())
}

/// The table of a map.
fn field(map: &DepthMap, technique: &Reconstruction<f64>) -> Result<SummedMoments, Failed> {
    let encode = |depth: f64, out: &mut [f64]| technique.encode(depth, out);
    let size = [map.width(), map.height()];
    Ok(SummedMoments::new(size, map.depths(), technique.channels(), TEXELS, encode)?)
}

/// Fragments of a map in single precision, a few of them a little off the middle of their texel.
fn fragments() -> Vec<(DepthMap, Vec<[f32; 4]>)> {
    let mut random = Random::new(19);
    let mut of = |(map, receivers): (DepthMap, Vec<shadow_filtering::Receiver>)| {
        let fragments = receivers.iter().map(|receiver| {
            let offset = [random.unit(), random.unit()];
            let at = [receiver.x as f64 + offset[0], receiver.y as f64 + offset[1]];
            [at[0] as f32, at[1] as f32, receiver.depth as f32, BIAS as f32]
        });
        let fragments = fragments.collect();
        (map, fragments)
    };
    fragments::receivers().into_iter().map(&mut of).collect()
}

/// Two numbers in \[0, 1) for each fragment, whole multiples of 2^-23.
fn noise(fragment: usize) -> [f32; 2] {
    [0x9e37_79b9u32, 0x85eb_ca6b].map(|step| (step.wrapping_mul(fragment as u32) >> 9) as f32 / 8_388_608.0)
}

fn fragment<R: Real>((index, &[x, y, depth, bias]): (usize, &[f32; 4])) -> Fragment<R> {
    let of = |value: f32| R::from_f64(f64::from(value));
    Fragment { position: [of(x), of(y)], depth: of(depth), bias: of(bias), noise: noise(index).map(of) }
}

/// With or without `FROM=>TO`.
fn faulty(source: String, fault: &str) -> String {
    let Some((from, to)) = fault.split_once("=>") else { return source };
    assert!(source.contains(from), "the fault `{from}` is not in the shader");
    source.replacen(from, to, 1)
}

fn shadows(
    source: &str,
    field: Resource<'_>,
    fragments: &[[f32; 4]],
    penumbra: &Penumbra<f64>,
) -> Result<Vec<f32>, Failed> {
    let uniform = penumbra_uniform(penumbra);
    let noises: Vec<[f32; 2]> = (0..fragments.len()).map(noise).collect();
    let resources = [
        field,
        Resource::Read(bytemuck::cast_slice(fragments)),
        Resource::Write(4 * fragments.len()),
        Resource::Uniform(bytemuck::cast_slice(&uniform)),
        Resource::Read(bytemuck::cast_slice(&noises)),
    ];
    let groups = (fragments.len() as u32).div_ceil(64);
    Ok(compute::run(&[(source, "shade", groups)], &resources, 2)?)
}

/// Found by the shader, by Rust in single precision, and in double precision.
#[derive(Default)]
struct Compared {
    shader: Vec<f32>,
    single: Vec<f32>,
    exact: Vec<f64>,
}

impl Compared {
    fn judge(&self, what: &str) -> Result<(), Failed> {
        assert!(self.shader.len() >= FRAGMENTS, "{} fragments", self.shader.len());
        let what = format!("{what}, {} fragments", self.shader.len());
        if let Some(i) = self.shader.iter().position(|value| !value.is_finite()) {
            return Err(format!("{what}: value {i} of the shader is {}", self.shader[i]).into());
        }
        let errors = |values: &[f32]| {
            let error = |(value, exact): (&f32, &f64)| (f64::from(*value) - exact).abs() as f32;
            let mut errors: Vec<f32> = values.iter().zip(&self.exact).map(error).collect();
            errors.sort_by(f32::total_cmp);
            errors.truncate(errors.len() - JUMPS);
            errors
        };
        let (shader, single) = (errors(&self.shader), errors(&self.single));
        super::compare(&what, &shader, &single, &vec![0.0; single.len()], &[1.0])
    }
}

pub(super) fn filterable(technique: &Reconstruction<f64>, fault: &str) -> Result<(), Failed> {
    let single = technique.cast::<f32>();
    for (number, (search, filter)) in searches().into_iter().enumerate() {
        for penumbra in penumbrae() {
            let mut compared = Compared::default();
            let (p, s, f) = cast::<f32>(&penumbra, &search, &filter);
            for (map, fragments) in fragments() {
                let size = [map.width(), map.height()];
                let field = field(&map, technique)?;
                let source =
                    filterable_shader(technique, size, TEXELS, FilterSize::Searched(&search), &filter)
                        .ok_or("no shader")?;
                let table = Resource::Read(bytemuck::cast_slice(field.table().prefix_sums()));
                compared.shader.extend(shadows(&faulty(source, fault), table, &fragments, &penumbra)?);
                for at in fragments.iter().enumerate() {
                    let at = (fragment::<f32>(at), fragment::<f64>(at));
                    compared.single.push(filterable_soft_shadow(&field, &single, &p, &s, &f, &at.0)?);
                    let exact =
                        filterable_soft_shadow(&field, technique, &penumbra, &search, &filter, &at.1)?;
                    compared.exact.push(exact);
                }
            }
            let near = if penumbra.near.is_some() { "near" } else { "far" };
            compared.judge(&format!("{}, settings {number}, {near} light", technique.bound().name()))?;
        }
    }
    Ok(())
}

fn fixed_size(technique: &Reconstruction<f64>) -> Result<(), Failed> {
    let single = technique.cast::<f32>();
    let (filter, penumbra) = (Filter::published(), penumbrae()[0]);
    let mut compared = Compared::default();
    for (map, fragments) in fragments() {
        let size = [map.width(), map.height()];
        let field = field(&map, technique)?;
        let source = filterable_shader(technique, size, TEXELS, FilterSize::Fixed(FIXED_WIDTHS), &filter)
            .ok_or("no shader")?;
        let table = Resource::Read(bytemuck::cast_slice(field.table().prefix_sums()));
        compared.shader.extend(shadows(&source, table, &fragments, &penumbra)?);
        for at in fragments.iter().enumerate() {
            let widths = FIXED_WIDTHS.map(|width| width as f32);
            compared.single.push(filtered_hard_shadow(
                &field,
                &single,
                widths,
                &Filter::published(),
                &fragment(at),
            )?);
            compared.exact.push(filtered_hard_shadow(
                &field,
                technique,
                FIXED_WIDTHS,
                &filter,
                &fragment(at),
            )?);
        }
    }
    compared.judge(&format!("{}, fixed size", technique.bound().name()))
}

pub(super) fn percentage_closer(fault: &str) -> Result<(), Failed> {
    let search = BlockerSearch::percentage_closer();
    let filter = Filter::published();
    for penumbra in penumbrae() {
        let mut compared = Compared::default();
        let (p, s, f) = cast::<f32>(&penumbra, &search, &filter);
        for (map, fragments) in fragments() {
            let size = [map.width(), map.height()];
            let source = faulty(percentage_closer_shader(size, &search, &filter), fault);
            let depths = Resource::Depths((map.depths(), map.width() as u32));
            compared.shader.extend(shadows(&source, depths, &fragments, &penumbra)?);
            for at in fragments.iter().enumerate() {
                compared.single.push(percentage_closer_soft_shadow::<f32>(&map, &p, &s, &f, &fragment(at)));
                compared.exact.push(percentage_closer_soft_shadow(
                    &map,
                    &penumbra,
                    &search,
                    &filter,
                    &fragment(at),
                ));
            }
        }
        compared.judge("percentage-closer soft shadows")?;
    }
    Ok(())
}

/// Codes to one unit, their sums and queries bit for bit.
pub(super) fn prefix_sums(technique: &Reconstruction<f64>, fault: &str) -> Result<(), Failed> {
    let channels = technique.channels();
    for (map, _) in fragments() {
        let size = [map.width(), map.height()];
        let source = faulty(prefix_sums_shader(technique, size, TEXELS), fault);
        let resources = [
            Resource::Depths((map.depths(), size[0] as u32)),
            Resource::Write(4 * size[0] * size[1] * channels),
        ];
        let line = size[0] * channels;
        let passes =
            [(source.as_str(), "rows", size[1] as u32), (&source, "columns", (line as u32).div_ceil(16))];
        let found: Vec<u32> = compute::run(&passes, &resources, 1)?;
        let field = field(&map, technique)?;
        let expected = field.table().prefix_sums();
        // Differences of sums are codes, whatever wrapped around.
        let code = |sums: &[u32], i: usize| {
            let at = |dx: bool, dy: bool| {
                if (dx && i % line < channels) || (dy && i < line) {
                    return 0;
                }
                sums[i - if dx { channels } else { 0 } - if dy { line } else { 0 }]
            };
            at(false, false)
                .wrapping_sub(at(true, false))
                .wrapping_sub(at(false, true))
                .wrapping_add(at(true, true))
        };
        let codes: Vec<u32> = (0..found.len()).map(|i| code(&found, i)).collect();
        let off = (0..found.len()).map(|i| codes[i].abs_diff(code(expected, i))).max().unwrap_or(0);
        if off > 1 {
            return Err(format!("a code is off by {off}").into());
        }
        let scale = f64::from(u32::MAX / TEXELS);
        let values: Vec<f64> = codes.iter().map(|&code| f64::from(code) / scale).collect();
        let table = quantization::SummedAreaTable::new((size[0], size[1], channels), &values, TEXELS)?;
        if table.prefix_sums() != found {
            return Err("sums of the shader's own codes differ".into());
        }
        queries(technique, &field, size)?;
    }
    Ok(())
}

fn queries(technique: &Reconstruction<f64>, field: &SummedMoments, size: [usize; 2]) -> Result<(), Failed> {
    let (search, filter) = (BlockerSearch::published(), Filter::published());
    let shader = filterable_shader(technique, size, TEXELS, FilterSize::Searched(&search), &filter);
    let functions = shader.ok_or("no shader")?;
    let source = format!(
        "{functions}
@group(0) @binding(4) var<storage, read> rectangles: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> sums: array<u32>;
@compute @workgroup_size(64)
fn ask(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x >= arrayLength(&rectangles) {{ return; }}
    let rectangle = rectangles[id.x];
    for (var k = 0u; k < CHANNELS; k++) {{
        sums[id.x * CHANNELS + k] = rectangle_sum(rectangle.xy, rectangle.zw, k);
    }}
}}"
    );
    let mut random = Random::new(5);
    let rectangles: Vec<[u32; 4]> = (0..4096)
        .map(|_| {
            let first = size.map(|size| random.below(size));
            let last = [0, 1].map(|k| (first[k] + random.below(29)).min(size[k] - 1));
            [first[0], first[1], last[0], last[1]].map(|texel| texel as u32)
        })
        .collect();
    let channels = technique.channels();
    let resources = [
        Resource::Read(bytemuck::cast_slice(field.table().prefix_sums())),
        Resource::Read(&[0; 16]),
        Resource::Write(16),
        Resource::Uniform(&[0; 16]),
        Resource::Read(bytemuck::cast_slice(&rectangles)),
        Resource::Write(4 * rectangles.len() * channels),
    ];
    let found: Vec<u32> = compute::run(&[(&source, "ask", 64)], &resources, 5)?;
    for (rectangle, found) in rectangles.iter().zip(found.chunks_exact(channels)) {
        let [x, y, last_x, last_y] = rectangle.map(|texel| texel as usize);
        let rectangle = Rectangle { first: (x, y), last: (last_x, last_y) };
        for (channel, &sum) in found.iter().enumerate() {
            if field.table().sum(rectangle, channel)? != sum {
                return Err(format!("{rectangle:?}: the shader sums {sum}").into());
            }
        }
    }
    Ok(())
}

/// Every module is valid without an adapter.
fn valid(technique: &Reconstruction<f64>) -> Result<(), Failed> {
    for (search, filter) in searches() {
        for filter_size in [FilterSize::Searched(&search), FilterSize::Fixed(FIXED_WIDTHS)] {
            let source =
                filterable_shader(technique, [64, 32], TEXELS, filter_size, &filter).ok_or("no shader")?;
            Module::new(&source)?;
        }
        Module::new(&percentage_closer_shader([64, 32], &search, &filter))?;
    }
    Module::new(&prefix_sums_shader(technique, [64, 32], TEXELS))?;
    Ok(())
}
