//! Pass times on a graphics processor by sizes of map and output (BHS16 Figure 8): resampling, prefix sums and look-ups apart,
//! and ray marching. A software driver is not timed, and whatever goes wrong ends these rows and nothing else; gpu.csv says what
//! it was.

use super::run::Plan;
use super::settings::ScatteringPasses;
use super::shot::Shot;
use super::view::{LitScene, ScatteringScene};
use crate::error::EvaluationError;
use crate::fragments::LoadedScene;
use crate::kinds::speed_accuracy::{FrameRoute, FrameSample};
use crate::timing::GpuRecord;
use applications::scattering::{
    FilteredDepths, Rectification, RectifiedMap, Spacing, StoredPrefixes, ViewRay, look_up_shader,
    march_shader, prefix_map_shader, prefix_words, resample_filtered_shader, resample_shader,
    scattering_uniform,
};
use graphics_device::DeviceError;
use shadow_renderer::{ComputeChain, ComputePass, Content};
use std::time::Duration;

/// Sizes of a frame.
#[derive(Clone, Copy, PartialEq)]
struct Point {
    map_size: u32,
    output: [u32; 2],
}

impl ScatteringPasses {
    /// The middle of everything, then each parameter on its own.
    fn points(&self) -> Vec<Point> {
        let first = Point { map_size: self.map_size, output: self.output };
        let mut points = vec![first];
        let sizes = self.map_sizes.iter().map(|&map_size| Point { map_size, ..first });
        for point in sizes.chain(self.outputs.iter().map(|&output| Point { output, ..first })) {
            if !points.contains(&point) {
                points.push(point);
            }
        }
        points
    }
}

/// What is timed once.
struct Timed<'a> {
    technique: &'a str,
    format: String,
    at: Point,
    /// Each with the bytes that it moves at least: every input read once, every output written once.
    passes: &'a [(ComputePass<'a>, u64)],
    /// What its passes share with no others.
    own: &'a [(&'a str, Content<'a>)],
}

/// The device with what was found.
struct Bench<'a> {
    chain: ComputeChain,
    timing: &'a ScatteringPasses,
    samples: &'a mut Vec<FrameSample>,
    gpu: &'a mut GpuRecord,
}

/// Rows of frames.csv and gpu.csv, on the first view.
pub(super) fn time(
    plan: &Plan<'_>,
    (loaded, scene): (&LoadedScene<'_>, &ScatteringScene<'_>),
    timing: &ScatteringPasses,
) -> (Vec<FrameSample>, GpuRecord) {
    let (mut samples, mut gpu) = (Vec::new(), GpuRecord::default());
    gpu.status = match timed(plan, (loaded, scene), timing, (&mut samples, &mut gpu)) {
        Ok(()) if samples.is_empty() => "not timed: the adapter has no timestamps".to_owned(),
        Ok(()) => "timed".to_owned(),
        Err(reason) => reason,
    };
    (samples, gpu)
}

fn timed(
    plan: &Plan<'_>,
    (loaded, scene): (&LoadedScene<'_>, &ScatteringScene<'_>),
    timing: &ScatteringPasses,
    (samples, gpu): (&mut Vec<FrameSample>, &mut GpuRecord),
) -> Result<(), String> {
    let chain = ComputeChain::open().map_err(|error| format!("not timed: {error}"))?;
    *gpu = GpuRecord::of(chain.adapter());
    if gpu.is_software() && !timing.software {
        return Err("not timed: only a software driver".to_owned());
    }
    gpu.measure_limits();
    let mut bench = Bench { chain, timing, samples, gpu };
    for at in timing.points() {
        bench.at_sizes(plan, (loaded, scene), at)?;
    }
    Ok(())
}

/// Threads of a group.
const GROUP: usize = 64;

impl Bench<'_> {
    /// All techniques at one size.
    fn at_sizes(
        &mut self,
        plan: &Plan<'_>,
        (loaded, scene): (&LoadedScene<'_>, &ScatteringScene<'_>),
        at: Point,
    ) -> Result<(), String> {
        let stop = |error: EvaluationError| format!("stopped: {error}");
        let lost = |error: DeviceError| format!("stopped: {error}");
        let experiment = plan.experiment;
        let Some(light) = scene.lights.first() else { return Ok(()) };
        let maps = (at.map_size, &plan.kernel, &plan.source);
        let lit = LitScene::new(loaded, scene, light, maps).map_err(stop)?;
        let Some(setting) = experiment.standpoint.iter().find(|setting| setting.is_in(scene.label)) else {
            return Ok(());
        };
        let camera = setting.camera(scene.scene, &scene.extent, lit.axes.light);
        let shot = Shot::new(&lit, camera, at.output, (&plan.noise, 0)).map_err(stop)?;
        let size = [at.map_size as usize; 2];
        let rectification = Rectification::new(&shot.frustum, shot.view.axes, size, experiment.guard_band)
            .map_err(|error| format!("stopped: {error}"))?;
        let rectified = RectifiedMap::nearest(rectification, &shot.view.light);
        let spacing = Spacing::default().inverse_sines(&rectified, &shot.frustum, &shot.view, &shot.rays);
        let inverse_sines = single(spacing.iter().flatten().copied());
        let uniform = scattering_uniform(&shot.view, &rectification);
        let uniform = single(uniform.iter().map(|&value| f64::from(value)));
        let rays = |last: &dyn Fn(&ViewRay) -> f64| {
            let of = |ray: &ViewRay| {
                let [x, y, z] = shot.view.axes.direction(ray.direction);
                [x, y, z, last(ray)]
            };
            single(shot.rays.iter().flat_map(of))
        };
        let lengths = rays(&|ray| if ray.length.is_finite() { ray.length } else { -1.0 });
        let ends = rays(&|ray| shot.view.end(ray));
        let noise = single(shot.rays.iter().map(|ray| ray.noise));
        let texels = u64::from(at.map_size).pow(2);
        let pixels = shot.rays.len();
        for (name, content) in [
            ("depths", Content::Depths { depths: shot.view.light.map.depths(), width: at.map_size }),
            ("texels", Content::Empty(16 * texels)),
            ("inverse_sines", Content::Bytes(&inverse_sines)),
            ("noise", Content::Bytes(&noise)),
            ("shares", Content::Empty(4 * pixels as u64)),
            ("view", Content::Uniform(&uniform)),
        ] {
            self.chain.put(name, content).map_err(lost)?;
        }
        let groups = pixels.div_ceil(GROUP) as u32;
        let nearest = resample_shader(size);
        let filtered_depths = FilteredDepths::new(&plan.source, &lit.stored);
        let filtered_depths = filtered_depths.map_err(|error| format!("stopped: source: {error}"))?;
        let levels = filtered_depths.for_shader();
        self.chain.put("levels", Content::Bytes(bytemuck::cast_slice(&levels))).map_err(lost)?;
        let filtered = resample_filtered_shader(&filtered_depths, size);
        let timing = self.timing;
        for index in experiment.named(&timing.techniques, "passes.techniques").map_err(stop)? {
            let name = experiment.technique[index].name.as_str();
            let method = &experiment.technique[index].method;
            if let Some(steps) = method.steps {
                let march = march_shader(steps);
                let pass = ComputePass { name: "march", source: &march, entry: "march", groups };
                // Rays, noise and answers, and the shadow map once.
                let bytes = (16 + 4 + 4) * pixels as u64 + 4 * texels;
                let own = [("rays", Content::Bytes(&ends))];
                let format = "depth".to_owned();
                self.measure(&Timed { technique: name, format, at, passes: &[(pass, bytes)], own: &own })?;
                continue;
            }
            let Some(technique) = plan.techniques[index].as_ref() else { continue };
            let stored = StoredPrefixes { technique, blending: method.blending(), margin: method.margin };
            let (Some(prefix), Some(look_up)) =
                (prefix_map_shader(&stored, size), look_up_shader(&stored, size))
            else {
                self.gpu.skipped += 1;
                self.gpu.last_skipped = format!("{name}: no shader");
                continue;
            };
            let map_bytes = 4 * texels * prefix_words(technique) as u64;
            let own = [("stored", Content::Empty(map_bytes)), ("rays", Content::Bytes(&lengths))];
            let of_texels = texels.div_ceil(GROUP as u64) as u32;
            let passes = [
                if method.filtered {
                    let (name, source, entry) = ("resample", &filtered, "resample_filtered");
                    let bytes = 4 * levels.len() as u64 + 16 * texels;
                    (ComputePass { name, source, entry, groups: of_texels }, bytes)
                } else {
                    let (name, source, entry) = ("resample", &nearest, "resample");
                    (ComputePass { name, source, entry, groups: of_texels }, (4 + 16) * texels)
                },
                (
                    ComputePass {
                        name: "prefix sums",
                        source: &prefix,
                        entry: "prefix",
                        groups: at.map_size,
                    },
                    16 * texels + map_bytes,
                ),
                (
                    ComputePass { name: "look up", source: &look_up, entry: "look_up", groups },
                    (16 + 4) * pixels as u64 + map_bytes,
                ),
            ];
            let format = technique.encoding().format().name();
            self.measure(&Timed { technique: name, format, at, passes: &passes, own: &own })?;
        }
        Ok(())
    }

    fn measure(&mut self, of: &Timed<'_>) -> Result<(), String> {
        let warm_up = Duration::from_millis(self.timing.warm_up_ms);
        let put = of.own.iter().try_for_each(|&(name, content)| self.chain.put(name, content));
        let passes: Vec<ComputePass<'_>> = of.passes.iter().map(|(pass, _)| *pass).collect();
        let times = match put.and_then(|()| self.chain.time(&passes, warm_up, self.timing.frames)) {
            Ok(times) => times,
            Err(error @ DeviceError::Lost(_)) => return Err(format!("stopped: {error}")),
            // Others may still work, for example with a smaller map.
            Err(error) => {
                self.gpu.skipped += 1;
                self.gpu.last_skipped = format!("{} at {}^2: {error}", of.technique, of.at.map_size);
                return Ok(());
            }
        };
        // The whole frame comes last and has no pass.
        for (pass, &(_, bytes)) in times.iter().zip(of.passes) {
            self.samples.extend(pass.times.iter().enumerate().map(|(frame, time)| FrameSample {
                technique: of.technique.to_owned(),
                format: of.format.clone(),
                map_size: of.at.map_size,
                width: of.at.output[0],
                height: of.at.output[1],
                depth_samples: 1,
                kernel: 0,
                route: FrameRoute::Compute,
                pass: pass.pass.to_owned(),
                least_bytes: Some(bytes),
                frame,
                time_ns: u64::try_from(time.as_nanos()).unwrap_or(u64::MAX),
            }));
        }
        Ok(())
    }
}

/// Bytes of single floats, as shaders read them.
fn single(values: impl Iterator<Item = f64>) -> Vec<u8> {
    values.flat_map(|value| (value as f32).to_le_bytes()).collect()
}
