//! Frame times on a graphics processor, as functions of map size, output size and kernel size (MSM15 Figure 7, GDC16).
//!
//! A software driver is not timed: its times say nothing about graphics processors. Whatever goes wrong ends the rows of the
//! GPU and nothing else; gpu.csv says what it was.

use super::records::FrameSample;
use super::scenery::SpeedPlan;
use super::settings::{FrameTiming, SpeedAccuracyExperiment};
use crate::error::EvaluationError;
use crate::fragments::{LoadedScene, Source};
use crate::timing::GpuRecord;
use graphics_device::{DeviceError, GraphicsDevice};
use shaders::{FrameShaders, TexelFormat};
use shadow_filtering::{Kernel, comparison_shaders};
use std::time::Duration;

use shadow_renderer::{FrameRenderer, FrameSettings, RenderError, Route};

/// Times and what they were measured on.
pub(crate) struct FrameTimes {
    pub(crate) samples: Vec<FrameSample>,
    pub(crate) gpu: GpuRecord,
}

/// One point of the curves.
#[derive(Clone, Copy, PartialEq)]
struct Point {
    map_size: u32,
    output: [u32; 2],
    kernel: usize,
    samples: u32,
}

/// Depth samples a texel where nothing else is asked for, as in MSM15.
pub(super) const SAMPLES: u32 = 4;

/// Name of percentage-closer filtering with a receiver plane among the frames.
pub const COMPARED_FRAME: &str = "PCF with receiver plane";

impl FrameTiming {
    /// The middle of everything, then each parameter on its own.
    fn points(&self) -> Vec<Point> {
        let (map_size, output) = (self.map_size, self.output);
        let first = Point { map_size, output, kernel: self.kernel, samples: SAMPLES };
        let mut points = vec![first];
        let sizes = self.map_sizes.iter().map(|&map_size| Point { map_size, ..first });
        let outputs = self.outputs.iter().map(|&output| Point { output, ..first });
        let kernels = self.kernels.iter().map(|&kernel| Point { kernel, ..first });
        let samples = self.samples.iter().map(|&samples| Point { samples, ..first });
        for point in sizes.chain(outputs).chain(kernels).chain(samples) {
            if !points.contains(&point) {
                points.push(point);
            }
        }
        points
    }
}

/// Bytes that a pass moves if it reads every input and writes every output once; `None` for passes of the raster pipeline.
fn least_bytes(pass: &str, shaders: &FrameShaders, settings: &FrameSettings) -> Option<u64> {
    let texels = u64::from(settings.map_size).pow(2);
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let texel = match shaders {
        FrameShaders::Prefiltered { textures, format, .. } => {
            let bytes = match format {
                TexelFormat::Unorm16 | TexelFormat::F16 => 2,
                TexelFormat::F32 => 4,
            };
            // Three channels take four.
            textures.iter().map(|&channels| bytes * (channels as u64).next_power_of_two()).sum()
        }
        FrameShaders::Comparison { .. } => 4,
    };
    // Position, normal and albedo are read, colour and shadow written.
    let of_pixel = 16 + 8 + 4 + 4 + 4;
    match pass {
        "resolve" => Some(texels * (4 * u64::from(settings.samples) + texel)),
        "filter rows" | "filter columns" => Some(2 * texels * texel),
        // Every level is read once and written once, the first only read and the last only written.
        "mip maps" => Some(texels * texel * 5 / 3),
        // Of a map with more texels than there are pixels not all have to be read.
        "shade" => Some(pixels * of_pixel + texels.min(pixels) * texel),
        _ => None,
    }
}

/// Standard deviation of MSM15's kernel for its size, and for others in proportion.
fn gaussian(size: usize) -> Option<Kernel> {
    Kernel::gaussian(size, 2.4 / 9.0 * size as f64).ok()
}

impl SpeedPlan<'_> {
    /// Times every technique that a shader computes on the first scene and view.
    pub(crate) fn frame_times(&self, timing: &FrameTiming) -> FrameTimes {
        let mut gpu = GpuRecord::default();
        let mut samples = Vec::new();
        gpu.status = match self.timed(timing, &mut gpu, &mut samples, &|_| {}) {
            Ok(()) => "timed".to_owned(),
            Err(reason) => reason,
        };
        FrameTimes { samples, gpu }
    }

    fn timed(
        &self,
        timing: &FrameTiming,
        gpu: &mut GpuRecord,
        samples: &mut Vec<FrameSample>,
        before_frames: &dyn Fn(&FrameRenderer),
    ) -> Result<(), String> {
        let adapter = &GraphicsDevice::shared().map_err(|error| format!("not timed: {error}"))?.name;
        *gpu = GpuRecord::of(adapter);
        if gpu.is_software() && !timing.software {
            return Err("not timed: only a software driver".to_owned());
        }
        let experiment = self.experiment;
        let scenes = LoadedScene::load_all(&experiment.scenery.scenes[..1], &experiment.scenery.views)
            .map_err(|error| error.to_string())?;
        let Source::Scene(scene) = &scenes[0].source else {
            return Err("not timed: a stack has no triangles".to_owned());
        };
        if scenes[0].lights[0].light.front().is_some() {
            return Err("not timed: frames are drawn under directional lights only".to_owned());
        }
        gpu.measure_limits();
        let stopped = |error: RenderError| format!("stopped: {error}");
        let renderer = FrameRenderer::new(scene, scenes[0].lights[0].direction).map_err(stopped)?;
        for point in timing.points() {
            let Some(kernel) = gaussian(point.kernel) else { continue };
            let settings = FrameSettings {
                map_size: point.map_size,
                width: point.output[0],
                height: point.output[1],
                samples: point.samples,
                mip_maps: true,
                bias: 0.002,
                leak_reduction: 0.0,
                route: Route::Fragment,
            };
            let mut techniques = self.frame_shaders(&kernel, point.samples);
            techniques.retain(|(name, format, _)| {
                let label = format!("{name}, {format}");
                timing.techniques.is_empty() || format == "depth" || timing.techniques.contains(&label)
            });
            let routes = timing.routes.iter();
            let forwards = techniques
                .iter()
                .flat_map(|technique| routes.clone().map(move |&route| (technique, route)))
                .collect::<Vec<_>>();
            let order = |round: usize| {
                let mut order = forwards.clone();
                if round % 2 == 1 {
                    order.reverse();
                }
                order.into_iter().map(move |technique| (round, technique))
            };
            for (round, ((technique, format, shaders), route)) in (0..timing.rounds).flat_map(order) {
                before_frames(&renderer);
                let settings = FrameSettings { route: route.route(), ..settings };
                let warm_up = Duration::from_millis(timing.warm_up_ms);
                let passes = match renderer.time(shaders, &settings, warm_up, timing.frames) {
                    Ok(passes) => passes,
                    Err(error @ RenderError::Gpu(DeviceError::Lost(_))) => return Err(stopped(error)),
                    // Others may still work, for example where this format cannot be filtered.
                    Err(RenderError::Gpu(reason)) => {
                        gpu.skipped += 1;
                        gpu.last_skipped = format!("{technique} in {format}: {reason}");
                        continue;
                    }
                    Err(error) => return Err(stopped(error)),
                };
                for pass in passes {
                    let least_bytes = least_bytes(pass.pass, shaders, &settings);
                    for (index, time) in pass.times.iter().enumerate() {
                        samples.push(FrameSample {
                            technique: technique.clone(),
                            format: format.clone(),
                            map_size: point.map_size,
                            width: point.output[0],
                            height: point.output[1],
                            kernel: point.kernel,
                            depth_samples: point.samples,
                            route,
                            pass: pass.pass.to_owned(),
                            least_bytes,
                            frame: round * timing.frames + index,
                            time_ns: u64::try_from(time.as_nanos()).unwrap_or(u64::MAX),
                        });
                    }
                }
            }
        }
        if samples.is_empty() {
            return Err("not timed: the adapter has no timestamps".to_owned());
        }
        Ok(())
    }

    fn frame_shaders(&self, kernel: &Kernel, samples: u32) -> Vec<(String, String, FrameShaders)> {
        let candidates = self.candidates.iter().filter_map(|candidate| {
            let passes = candidate.technique().passes(kernel, samples)?;
            Some((candidate.name.clone(), candidate.format.clone(), passes))
        });
        let limit = self.experiment.scenery.plane_limit;
        let reference = comparison_shaders(kernel, limit);
        let name = COMPARED_FRAME.to_owned();
        candidates.chain([(name, "depth".to_owned(), reference)]).collect()
    }
}

impl SpeedAccuracyExperiment {
    /// What is wrong with the frames' settings.
    pub(super) fn check_frames(&self) -> Result<(), EvaluationError> {
        let fail = |key: &str, reason: String| {
            Err(EvaluationError::key(format!("frames.{key}"), format!("frames: {reason}")))
        };
        let Some(timing) = &self.frames else { return Ok(()) };
        if timing.frames == 0 || timing.rounds == 0 {
            let key = if timing.frames == 0 { "frames" } else { "rounds" };
            return fail(key, format!("{} frames in {} rounds are none", timing.frames, timing.rounds));
        }
        if let Some(label) = timing.techniques.iter().find(|label| !self.is_candidate(label)) {
            return fail("techniques", format!("technique `{label}` is not a candidate (`NAME, FORMAT`)"));
        }
        if let Some(samples) = timing.samples.iter().find(|&&samples| samples != 1 && samples != SAMPLES) {
            return fail("samples", format!("{samples} depth samples a texel: 1 and {SAMPLES} are possible"));
        }
        for point in timing.points() {
            if gaussian(point.kernel).is_none() {
                let key = if point.kernel == timing.kernel { "kernel" } else { "kernels" };
                return fail(key, format!("kernel size {} is not odd and at most 129", point.kernel));
            }
            if point.map_size == 0 || point.output.contains(&0) {
                return fail("map_size", "a map or an output has no texel".to_owned());
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::records::FrameRoute;
    use super::*;
    use crate::experiment::{Experiment, Scale};
    use crate::kinds::speed_accuracy::candidates::DEFAULT_CANDIDATES;
    use std::cell::Cell;
    use std::path::Path;

    #[test]
    fn a_lost_device_ends_the_rows_of_the_gpu_and_nothing_else() {
        let file = Path::new("speed-accuracy.toml");
        let read = Experiment::parse(file, DEFAULT_CANDIDATES, Scale::Smoke, None).unwrap();
        let experiment: &SpeedAccuracyExperiment = read.settings().unwrap();
        let plan = SpeedPlan::new(experiment).unwrap();
        let timing = FrameTiming {
            map_size: 64,
            output: [64, 64],
            kernel: 3,
            map_sizes: Vec::new(),
            outputs: Vec::new(),
            kernels: Vec::new(),
            samples: vec![1],
            techniques: Vec::new(),
            routes: vec![FrameRoute::Fragment],
            frames: 1,
            rounds: 1,
            warm_up_ms: 0,
            software: true,
        };
        let (mut gpu, mut samples) = (GpuRecord::default(), Vec::new());
        let frames = Cell::new(0);
        let lose_third = |renderer: &FrameRenderer| {
            frames.set(frames.get() + 1);
            if frames.get() == 3 {
                renderer.lose();
            }
        };
        let stopped = plan.timed(&timing, &mut gpu, &mut samples, &lose_third).unwrap_err();
        if GraphicsDevice::shared().is_err() {
            assert!(stopped.starts_with("not timed: ") && gpu.adapter.is_empty(), "{stopped}");
            assert!(samples.is_empty());
            return;
        }
        assert!(stopped.starts_with("stopped: ") && stopped.contains("lost"), "{stopped}");
        assert_eq!(frames.get(), 3);
        assert!(samples.iter().all(|sample| sample.technique == experiment.technique[0].name));
    }
}
