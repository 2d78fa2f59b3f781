//! Compute passes of stochastic soft shadow maps against their Rust twin: from rays to the shadows of fragments, against double
//! precision under a lamp in each of three scenes.

use std::time::Duration;

use super::adapter::gpu_trial;
use super::scattering::{faulty, judge};
use applications::PlacedLight;
use applications::rays::Triangles;
use applications::samples::{PoissonTaps, TapShape};
use applications::stochastic::{
    FilterPass, FilterShaders, Footprint, Lens, LensMap, PlaneFilter, PlaneFragment, PlaneSet, SampleCentre,
    filter_plane, plane_uniform,
};
use libtest_mimic::{Failed, Trial};
use quantization::NumberFormat;
use scenes::load_scene;
use scenes::vector::{dot, norm};
use shaders::Module;
use shadow_filtering::{Precision, Technique, TechniqueSpec};
use shadow_renderer::{Backend, ComputeChain, ComputePass, Content, render_view};

/// Side of maps.
const SIDE: u32 = 160;

/// Depths of the planes.
const PLANES: [f64; 3] = [0.3, 0.6, 0.9];

/// The light's sides over those of the lamp: circles of half a texel and of dozens.
const SCALE: f64 = 2.0;

/// Depth bias.
const BIAS: f64 = 0.002;

/// Seed of rays and taps.
const SEED: u64 = 7;

/// One answer in so many is left out on both sides: rays on the border of a texel and surfaces on that of a circle fall to either
/// side, and any rounding decides.
const JUMPS: usize = 1000;

/// Most passes of a chain at a time.
const CHAIN: usize = 16;

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, spec, filter, blend_shadows) in methods() {
        let (of, with) = (spec.clone(), filter.clone());
        trials.push(Trial::test(format!("wgsl::stochastic::{name}"), move || valid(&of, &with)));
        trials.push(gpu_trial(format!("stochastic::{name}"), move || {
            twins(&spec, &filter, blend_shadows, &SCENES, "")
        }));
    }
    trials.push(gpu_trial("stochastic::planted_faults".into(), planted_faults));
    trials
}

const SCENES: [&str; 3] = ["stairs", "village", "grove"];

fn taps(filter: &PlaneFilter) -> PoissonTaps {
    PoissonTaps::new(TapShape::Disc, filter.edge_taps, SEED, 1)
}

/// As published, but for how far edges are looked for: on small maps no tap would fall into a circle.
fn published() -> PlaneFilter {
    PlaneFilter { edge_reach: 6.0, ..PlaneFilter::published() }
}

fn mended() -> PlaneFilter {
    PlaneFilter {
        footprint: Footprint::Rectangle,
        centre: SampleCentre::Projected,
        coarse_levels: 4,
        interleaved: false,
        box_filter: false,
        ..published()
    }
}

fn methods() -> Vec<(&'static str, TechniqueSpec, PlaneFilter, bool)> {
    let single = |bound: &str| TechniqueSpec::named(bound).unwrap();
    let four = TechniqueSpec { alpha: Some(1e-6), ..single("hamburger4") };
    let stored = TechniqueSpec {
        transform: Some("GDC16 four moments".to_owned()),
        format: Some(NumberFormat::Unorm16),
        alpha: Some(6e-5),
        ..single("hamburger4")
    };
    let exponential = TechniqueSpec { exponent: Some(10.0), negative_exponent: Some(5.0), ..single("evsm") };
    let six = TechniqueSpec { alpha: Some(5e-6), ..single("hamburger6") };
    let published = published();
    let no_edges = PlaneFilter { edge_taps: 0, least_radius: 0.5, gather_radius: 15, ..published.clone() };
    vec![
        ("variance", single("vsm"), published.clone(), false),
        ("exponential_variance", exponential, published.clone(), false),
        ("four_moments", four.clone(), published.clone(), false),
        ("four_moments_16_bit", stored, published, false),
        ("four_moments_mended", four.clone(), mended(), true),
        ("four_moments_no_edges", four, no_edges, true),
        ("six_moments_mended", six, mended(), false),
    ]
}

/// A scene's rays from all over a lamp, and what faces it.
struct Seen {
    map: LensMap,
    near: f64,
    range: f64,
    /// Position in texels, depth, compared depth.
    fragments: Vec<[f32; 4]>,
}

impl Seen {
    fn new(scene: &str) -> Result<Self, Failed> {
        let scene = load_scene(scene)?;
        let view = scene.views.iter().find(|view| view.name == "lamp").ok_or("no lamp")?;
        let (stack, report) = render_view(&scene, view, SIDE, SIDE, Backend::Cpu)?;
        let (frame, triangles) = (report.frame, Triangles::of_scene(&scene)?);
        let placed = PlacedLight::new(&view.light, [frame.right, frame.down, frame.forward]);
        let distance = |depth: f64| frame.near + depth * frame.depth_range;
        let (focus, far) = (distance(PLANES[1]), distance(1.0));
        let lens = Lens {
            size: [SIDE as usize; 2],
            texels: frame.texels_per_unit.map(|texels| texels * frame.near),
            half_size: placed.half_axes.map(|axis| SCALE * norm(axis)),
        };
        let map = LensMap::trace(lens, focus, (SEED, 0), |[x, y], point| {
            let offset = placed.towards(placed.middle, point).map(|c| SCALE * c);
            let start = [0, 1, 2].map(|k| placed.middle[k] + offset[k]);
            let through = frame.unproject([x, y, PLANES[1]]);
            let direction = [0, 1, 2].map(|k| (through[k] - start[k]) * (far / focus));
            let first = triangles.first(start, direction, false).map(|(at, _)| at * far);
            ([dot(offset, frame.right), dot(offset, frame.down)], first.filter(|&distance| distance > 0.0))
        });
        let mut fragments = Vec::new();
        // Half of the map is left alone, so that not all tiles are needed.
        for (x, y) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)).filter(|(x, y)| x + y < SIDE) {
            for layer in stack.layers(x, y).filter(|layer| layer.light_facing) {
                // A third of a texel off the middle, so that texels are interpolated.
                let place = [f64::from(x) + 0.2, f64::from(y) + 0.7].map(|t| t as f32);
                let compared = (f64::from(layer.depth) - BIAS).clamp(0.0, 1.0) as f32;
                fragments.push([place[0], place[1], layer.depth, compared]);
            }
        }
        Ok(Self { map, near: frame.near, range: frame.depth_range, fragments })
    }

    fn distance(&self, depth: f64) -> f64 {
        self.near + depth * self.range
    }

    /// By Rust; -1 where no sample reaches.
    fn shadows<R: Precision>(
        &self,
        technique: &Technique,
        filter: &PlaneFilter,
        blend_shadows: bool,
    ) -> Result<Vec<R>, Failed> {
        let number = |value: f32| R::from_f64(f64::from(value));
        let channels = technique.channels();
        let (near, range) = (number(self.near as f32), number(self.range as f32));
        let mut values = vec![R::zero(); self.map.samples().len() * channels];
        for (values, ray) in values.chunks_exact_mut(channels).zip(self.map.samples()) {
            let depth = (number(ray.distance.min(1e30)) - near) / range;
            technique.encode(depth.clamp_unit(), values);
        }
        let format = technique.encoding().format();
        let planes: Vec<_> = PLANES
            .iter()
            .map(|&depth| {
                let values = (values.as_slice(), channels);
                let taps = (&taps(filter), SEED);
                let mut plane = filter_plane(&self.map, self.distance(depth), values, filter, taps, None);
                plane.for_each_texel(|values| {
                    values.iter_mut().for_each(|value| *value = value.rounded(format));
                });
                plane
            })
            .collect();
        let distances = PLANES.map(|depth| number(self.distance(depth) as f32));
        let set = PlaneSet {
            distances: &distances,
            planes: &planes,
            technique,
            channels: 0..channels,
            blend_shadows,
        };
        let shadow = |&[x, y, depth, compared]: &[f32; 4]| {
            let distance = near + number(depth) * range;
            let position = [number(x), number(y)];
            let found = set.shadow(&PlaneFragment { position, distance, compared: number(compared) })?;
            Ok(found.unwrap_or(-R::one()))
        };
        self.fragments.iter().map(shadow).collect()
    }

    /// By shaders.
    fn shaded(&self, shaders: &FilterShaders<'_>, fault: &str) -> Result<Vec<f32>, Failed> {
        let mut chain = ComputeChain::open()?;
        for (name, bytes) in shaders.buffers(self.fragments.len()) {
            chain.put(name, Content::Empty(bytes))?;
        }
        let rays = self.map.for_shader(SEED);
        let distances = PLANES.map(|depth| self.distance(depth) as f32);
        chain.put("rays", Content::Bytes(bytemuck::cast_slice(&rays)))?;
        chain.put("fragments", Content::Bytes(bytemuck::cast_slice(&self.fragments)))?;
        chain.put("plane_distances", Content::Bytes(bytemuck::cast_slice(&distances)))?;
        let mut run = |passes: &[FilterPass], number: usize| -> Result<(), Failed> {
            let distance = self.distance(PLANES[number]);
            let uniform = plane_uniform(&self.map, distance, number, [self.near, self.range]);
            chain.put("plane", Content::Uniform(bytemuck::cast_slice(&uniform)))?;
            let sources: Vec<String> =
                passes.iter().map(|pass| faulty(pass.source.clone(), &[fault])).collect();
            let pass = |(pass, source): (&FilterPass, _)| ComputePass {
                name: pass.entry,
                source,
                entry: pass.entry,
                groups: pass.groups,
            };
            let passes: Vec<ComputePass<'_>> =
                passes.iter().zip(sources.iter().map(String::as_str)).map(pass).collect();
            for part in passes.chunks(CHAIN) {
                chain.time(part, Duration::ZERO, 0)?;
            }
            Ok(())
        };
        run(&shaders.before(self.fragments.len()).ok_or("no shader")?, 0)?;
        for number in 0..PLANES.len() {
            run(&shaders.plane().ok_or("no shader")?, number)?;
        }
        run(&[shaders.shade(self.fragments.len()).ok_or("no shader")?], 0)?;
        Ok(chain.read("shadows")?)
    }
}

fn twins(
    spec: &TechniqueSpec,
    filter: &PlaneFilter,
    blend_shadows: bool,
    scenes: &[&str],
    fault: &str,
) -> Result<(), Failed> {
    let technique = spec.build()?;
    let taps = taps(filter);
    let shaders = FilterShaders {
        technique: &technique,
        filter,
        taps: &taps,
        size: [SIDE as usize; 2],
        planes: PLANES.len(),
        blend_shadows,
    };
    let (mut found, mut single, mut exact) = (Vec::new(), Vec::new(), Vec::new());
    for scene in scenes {
        let seen = Seen::new(scene)?;
        found.extend(seen.shaded(&shaders, fault)?);
        single.extend(seen.shadows::<f32>(&technique, filter, blend_shadows)?);
        exact.extend(seen.shadows::<f64>(&technique, filter, blend_shadows)?);
    }
    let what = format!("{} in {}, {} fragments", technique.name(), spec.format(), found.len());
    let partly = exact.iter().filter(|shadow| (0.05..0.95).contains(*shadow)).count();
    assert!(partly > found.len() / 50, "{what}: only {partly} in penumbrae");
    judge(&what, &found, &single, &exact, found.len() / JUMPS)
}

/// Every module is valid without an adapter.
fn valid(spec: &TechniqueSpec, filter: &PlaneFilter) -> Result<(), Failed> {
    let (technique, taps) = (spec.build()?, taps(filter));
    // One texel at last, and sides that are no multiple of anything.
    for size in [[64, 64], [33, 20]] {
        let shaders = FilterShaders {
            technique: &technique,
            filter,
            taps: &taps,
            size,
            planes: 2,
            blend_shadows: false,
        };
        let mut passes = shaders.before(100).ok_or("no shader")?;
        passes.extend(shaders.plane().ok_or("no shader")?);
        passes.push(shaders.shade(100).ok_or("no shader")?);
        for pass in passes {
            Module::new(&pass.source)?.entry_point(pass.entry)?;
        }
    }
    Ok(())
}

/// Weights of levels reversed, no weight by radius, a level half a texel off, lists cut and merged wrongly, a barrier left out,
/// and more.
const FAULTS: [&str; 14] = [
    "clamp(1.0 - (WIDEST - radius)=>clamp((WIDEST - radius)",
    "SCALE * sample.x / (sample.y * sample.y)=>SCALE * sample.x",
    "0.5 * (f32(t) + 0.5) - 0.5=>0.5 * (f32(t) + 0.5)",
    "        last = next;=>",
    "atomicStore(&links[COUNT + index], before)=>atomicStore(&links[COUNT + index], 0u)",
    "workgroupBarrier();\n            for (var line=>for (var line",
    "max(at, vec2<u32>(1u)) - 1u=>at",
    "between.lower * TILE_COUNT + tile=>between.lower * TILE_COUNT",
    "(distance - before) / (plane=>1.0 - (distance - before) / (plane",
    "rays[index].xy * plane.lever=>rays[index].xy * -plane.lever",
    "max(max(texels[texel].y, circle), LEAST_RADIUS)=>max(texels[texel].y, LEAST_RADIUS)",
    "abs(1.0 / ray.z - plane.per_distance)=>abs(1.0 / ray.z - plane.per_focus)",
    "circles[COUNT + row * WIDTH=>circles[row * WIDTH",
    "TOTAL + COARSER_FIRST + place=>COARSER_FIRST + place",
];

fn planted_faults() -> Result<(), Failed> {
    let (_, spec, filter, blend_shadows) = methods().swap_remove(2);
    let technique = spec.build()?;
    let taps = taps(&filter);
    let shaders = FilterShaders {
        technique: &technique,
        filter: &filter,
        taps: &taps,
        size: [SIDE as usize; 2],
        planes: PLANES.len(),
        blend_shadows,
    };
    let mut passes = shaders.before(1).ok_or("no shader")?;
    passes.extend(shaders.plane().ok_or("no shader")?);
    passes.push(shaders.shade(1).ok_or("no shader")?);
    for fault in FAULTS {
        let (from, _) = fault.split_once("=>").ok_or("no fault")?;
        assert!(passes.iter().any(|pass| pass.source.contains(from)), "`{from}` is in no shader");
        if twins(&spec, &filter, blend_shadows, &SCENES[..1], fault).is_ok() {
            return Err(format!("the comparison missed `{fault}`").into());
        }
    }
    Ok(())
}
