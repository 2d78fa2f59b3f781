//! Pass times on a graphics processor by sizes of map and output (BHS16 Figure 8): resampling, prefix sums and look-ups apart,
//! ray marching and a plain copy in the same frames. A software driver is not timed, and whatever goes wrong ends these rows
//! and nothing else; gpu.csv says what it was.

use super::run::Plan;
use super::settings::PassTiming;
use super::shot::Shot;
use super::view::ScatteringScene;
use crate::error::EvaluationError;
use crate::fragments::LoadedScene;
use crate::kinds::speed_accuracy::{FrameSample, GpuRecord};
use applications::scattering::{
    Rectification, RectifiedMap, Spacing, StoredPrefixes, ViewRay, look_up_shader, march_shader,
    prefix_map_shader, prefix_words, resample_shader, scattering_uniform,
};
use graphics_device::{DeviceError, GraphicsDevice};
use shadow_renderer::{BINDING_BYTES, ComputeInput, ComputePass, compute_times};
use std::time::Duration;

/// Reads and writes every word of a buffer: what the card can move.
const COPY: &str = "@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> copied: array<vec4<u32>>;
@compute @workgroup_size(64)
fn copy(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index < arrayLength(&source) { copied[index] = source[index]; }
}";

/// Bytes that are copied, read and written.
const COPIED: usize = 64 << 20;

/// Name of the copy among the techniques.
pub const COPIED_BYTES: &str = "copy of 64 MiB";

/// Sizes of a frame.
#[derive(Clone, Copy, PartialEq)]
struct Point {
    map_size: u32,
    output: [u32; 2],
}

impl PassTiming {
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
    passes: &'a [ComputePass<'a>],
    inputs: &'a [(&'a str, ComputeInput<'a>)],
}

/// Rows of frames.csv and gpu.csv, on the first view.
pub(super) fn time(
    plan: &Plan<'_>,
    (loaded, scene): (&LoadedScene<'_>, &ScatteringScene<'_>),
    timing: &PassTiming,
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
    timing: &PassTiming,
    (samples, gpu): (&mut Vec<FrameSample>, &mut GpuRecord),
) -> Result<(), String> {
    let adapter = &GraphicsDevice::shared().map_err(|error| format!("not timed: {error}"))?.name;
    gpu.adapter = adapter.name.clone();
    gpu.device_type = adapter.device_type.clone();
    gpu.driver = adapter.driver.clone();
    gpu.api = adapter.api.clone();
    if adapter.device_type == "Cpu" && !timing.software {
        return Err("not timed: only a software driver".to_owned());
    }
    let bytes = vec![1u8; COPIED];
    for at in timing.points() {
        let copy =
            ComputePass { name: "copy", source: COPY, entry: "copy", threads: [(COPIED / 16) as u32, 1] };
        let inputs =
            [("source", ComputeInput::Bytes(&bytes)), ("copied", ComputeInput::Empty(COPIED as u64))];
        let format = "bytes".to_owned();
        let copied = Timed { technique: COPIED_BYTES, format, at, passes: &[copy], inputs: &inputs };
        measure(&copied, timing, (samples, gpu))?;
        at_sizes(plan, (loaded, scene), at, timing, (samples, gpu))?;
    }
    Ok(())
}

/// All techniques at one size.
fn at_sizes(
    plan: &Plan<'_>,
    (loaded, scene): (&LoadedScene<'_>, &ScatteringScene<'_>),
    at: Point,
    timing: &PassTiming,
    (samples, gpu): (&mut Vec<FrameSample>, &mut GpuRecord),
) -> Result<(), String> {
    let stop = |error: EvaluationError| format!("stopped: {error}");
    let experiment = plan.experiment;
    let Some(light) = scene.lights.first() else { return Ok(()) };
    let maps = (at.map_size, &plan.kernel, &plan.source);
    let lit = super::view::LitScene::new(loaded, scene, light, maps).map_err(stop)?;
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
    let inverse_sines: Vec<u8> =
        spacing.iter().flatten().flat_map(|&value| (value as f32).to_le_bytes()).collect();
    let uniform: Vec<u8> =
        scattering_uniform(&shot.view, &rectification).iter().flat_map(|value| value.to_le_bytes()).collect();
    let rays = |last: &dyn Fn(&ViewRay) -> f64| -> Vec<u8> {
        let of = |ray: &ViewRay| {
            let [x, y, z] = shot.view.axes.direction(ray.direction);
            [x, y, z, last(ray)].map(|value| (value as f32).to_le_bytes()).concat()
        };
        shot.rays.iter().flat_map(of).collect()
    };
    let lengths = rays(&|ray| if ray.length.is_finite() { ray.length } else { -1.0 });
    let ends = rays(&|ray| shot.view.end(ray));
    let noise: Vec<u8> = shot.rays.iter().flat_map(|ray| (ray.noise as f32).to_le_bytes()).collect();
    let depths = ComputeInput::Depths(shot.view.light.map.depths(), at.map_size);
    let texels = u64::from(at.map_size).pow(2);
    let pixels = shot.rays.len() as u32;
    let shares = ComputeInput::Empty(4 * u64::from(pixels));
    let resample = resample_shader(size);
    for name in &timing.techniques {
        let Some(index) = experiment.technique.iter().position(|technique| technique.name == *name) else {
            continue;
        };
        let method = &experiment.technique[index].method;
        if let Some(steps) = method.steps {
            let march = march_shader(steps);
            let pass = ComputePass { name: "march", source: &march, entry: "march", threads: [pixels, 1] };
            let inputs = [
                ("depths", depths),
                ("rays", ComputeInput::Bytes(&ends)),
                ("shares", shares),
                ("view", ComputeInput::Uniform(&uniform)),
                ("noise", ComputeInput::Bytes(&noise)),
            ];
            let of =
                Timed { technique: name, format: "depth".to_owned(), at, passes: &[pass], inputs: &inputs };
            measure(&of, timing, (samples, gpu))?;
            continue;
        }
        let Some(technique) = plan.techniques[index].as_ref() else { continue };
        let stored = StoredPrefixes { technique, blending: method.blending(), margin: method.margin };
        let (Some(prefix), Some(look_up)) = (prefix_map_shader(&stored, size), look_up_shader(&stored, size))
        else {
            gpu.skipped += 1;
            gpu.last_skipped = format!("{name}: no shader");
            continue;
        };
        let map_bytes = 4 * texels * prefix_words(technique) as u64;
        if map_bytes.max(16 * texels).max(lengths.len() as u64) > BINDING_BYTES {
            gpu.skipped += 1;
            gpu.last_skipped = format!("{name}: a map of {} exceeds {BINDING_BYTES} bytes", at.map_size);
            continue;
        }
        let inputs = [
            ("depths", depths),
            ("texels", ComputeInput::Empty(16 * texels)),
            ("stored", ComputeInput::Empty(map_bytes)),
            ("inverse_sines", ComputeInput::Bytes(&inverse_sines)),
            ("rays", ComputeInput::Bytes(&lengths)),
            ("shares", shares),
            ("view", ComputeInput::Uniform(&uniform)),
        ];
        // A group a row: its threads are those of the shader.
        let passes = [
            ComputePass { name: "resample", source: &resample, entry: "resample", threads: [at.map_size; 2] },
            ComputePass {
                name: "prefix sums",
                source: &prefix.text,
                entry: "prefix",
                threads: [at.map_size * prefix.threads, 1],
            },
            ComputePass { name: "look up", source: &look_up, entry: "look_up", threads: [pixels, 1] },
        ];
        let format = technique.encoding().format().name();
        measure(
            &Timed { technique: name, format, at, passes: &passes, inputs: &inputs },
            timing,
            (samples, gpu),
        )?;
    }
    Ok(())
}

fn measure(
    of: &Timed<'_>,
    timing: &PassTiming,
    (samples, gpu): (&mut Vec<FrameSample>, &mut GpuRecord),
) -> Result<(), String> {
    let warm_up = Duration::from_millis(timing.warm_up_ms);
    let times = match compute_times(of.passes, of.inputs, warm_up, timing.frames) {
        Ok(times) => times,
        Err(error @ DeviceError::Lost(_)) => return Err(format!("stopped: {error}")),
        Err(error) => {
            gpu.skipped += 1;
            gpu.last_skipped = format!("{}: {error}", of.technique);
            return Ok(());
        }
    };
    for pass in times {
        for (frame, time) in pass.times.iter().enumerate() {
            samples.push(FrameSample {
                technique: of.technique.to_owned(),
                format: of.format.clone(),
                map_size: of.at.map_size,
                width: of.at.output[0],
                height: of.at.output[1],
                kernel: 0,
                pass: pass.pass.to_owned(),
                frame,
                time_ns: u64::try_from(time.as_nanos()).unwrap_or(u64::MAX),
            });
        }
    }
    Ok(())
}
