//! Times of the compute passes of a method on a graphics processor, as functions of map size, output size and search region
//! (BHS16 Figure 14).
//!
//! A software driver is not timed: its times say nothing about graphics processors. Whatever goes wrong ends these rows and
//! nothing else; gpu.csv says what it was.

use super::method::MethodSetting;
use super::records::PassSample;
use super::run::SoftPlan;
use super::settings::PassTiming;
use super::view::SoftView;
use crate::fragments::{Seen, texel_depth};
use crate::timing::GpuRecord;
use applications::field::Table;
use applications::soft_shadow::{
    FilterSize, Penumbra, filterable_shader, penumbra_uniform, percentage_closer_shader, prefix_sums_shader,
};
use graphics_device::DeviceError;
use rayon::prelude::*;
use shadow_filtering::DepthMap;
use shadow_renderer::{ComputeChain, ComputePass, Content, Frame, LightFrame, Sampling};
use std::time::Duration;

/// One point of the curves.
#[derive(Clone, Copy, PartialEq)]
struct Point {
    map_size: u32,
    output: [u32; 2],
    region: f64,
}

/// The modules of a method on a map of some size.
struct Modules {
    /// None where texels are compared.
    prefix_sums: Option<String>,
    shade: String,
    channels: usize,
}

/// What is shaded.
struct Pixels {
    /// Position on the map, depth and bias; all 0 for pixels without a surface that faces the light.
    fragments: Vec<[f32; 4]>,
    receivers: usize,
}

impl PassTiming {
    /// The middle of everything, then each parameter on its own.
    fn points(&self) -> Vec<Point> {
        let first = Point { map_size: self.map_size, output: self.output, region: self.region };
        let mut points = vec![first];
        let sizes = self.map_sizes.iter().map(|&map_size| Point { map_size, ..first });
        let outputs = self.outputs.iter().map(|&output| Point { output, ..first });
        let regions = self.regions.iter().map(|&region| Point { region, ..first });
        for point in sizes.chain(outputs).chain(regions) {
            if !points.contains(&point) {
                points.push(point);
            }
        }
        points
    }
}

impl MethodSetting {
    /// `None` for methods without a shader: tables that are no whole numbers, bounds without one.
    fn modules(&self, map: &DepthMap, penumbra: &Penumbra<f64>) -> Option<Modules> {
        let size = [map.width(), map.height()];
        let filter = self.filter(penumbra);
        let search = self.search();
        let Some(technique) = self.reconstruction().ok()? else {
            let shade = percentage_closer_shader(size, &search, &filter);
            return Some(Modules { prefix_sums: None, shade, channels: 0 });
        };
        if self.table != Table::Uint32 {
            return None;
        }
        let texels = self.texels(map, penumbra);
        let filter_size = match self.width {
            Some(width) => FilterSize::Fixed([width; 2]),
            None => FilterSize::Searched(&search),
        };
        let shade = filterable_shader(&technique, size, texels, filter_size, &filter)?;
        let prefix_sums = Some(prefix_sums_shader(&technique, size, texels));
        Some(Modules { prefix_sums, shade, channels: technique.channels() })
    }
}

impl Modules {
    fn passes(&self, map_size: u32, pixels: usize) -> Vec<ComputePass<'_>> {
        let mut passes = Vec::new();
        if let Some(source) = &self.prefix_sums {
            let columns = (map_size * self.channels as u32).div_ceil(16);
            passes.push(ComputePass { name: "rows", source, entry: "rows", groups: map_size });
            passes.push(ComputePass { name: "columns", source, entry: "columns", groups: columns });
        }
        let groups = (pixels as u32).div_ceil(64);
        passes.push(ComputePass { name: "shade", source: &self.shade, entry: "shade", groups });
        passes
    }
}

impl SoftPlan<'_> {
    /// Times the techniques that have a shader.
    pub(super) fn pass_times(&self, timing: &PassTiming) -> (Vec<PassSample>, GpuRecord) {
        let (mut samples, mut gpu) = (Vec::new(), GpuRecord::default());
        gpu.status = match self.timed(timing, &mut gpu, &mut samples) {
            Ok(()) => "timed".to_owned(),
            Err(reason) => reason,
        };
        (samples, gpu)
    }

    fn timed(
        &self,
        timing: &PassTiming,
        gpu: &mut GpuRecord,
        samples: &mut Vec<PassSample>,
    ) -> Result<(), String> {
        let stopped = |error: DeviceError| format!("stopped: {error}");
        let mut chain = ComputeChain::open().map_err(|error| format!("not timed: {error}"))?;
        *gpu = GpuRecord::of(chain.adapter());
        if gpu.is_software() && !timing.software {
            return Err("not timed: only a software driver".to_owned());
        }
        gpu.measure_limits();
        let view = self.views.iter().find(|view| view.frame.eye.is_none());
        let view = view.ok_or("not timed: no view under a light at infinity")?;
        let techniques: Vec<usize> = self
            .experiment
            .named(&timing.techniques, "passes.techniques")
            .map_err(|error| error.to_string())?;
        for point in timing.points() {
            let (map, penumbra, pixels) =
                self.prepared(view, point).map_err(|reason| format!("stopped: {reason}"))?;
            let noises: Vec<[f32; 2]> = (0..pixels.fragments.len())
                .map(|i| self.noise.at(i % point.output[0] as usize, i / point.output[0] as usize))
                .map(|noise| noise.map(|u| u as f32))
                .collect();
            let uniform = penumbra_uniform(&penumbra);
            let width = point.map_size;
            for (name, content) in [
                ("depths", Content::Depths { depths: map.depths(), width }),
                ("fragments", Content::Bytes(bytemuck::cast_slice(&pixels.fragments))),
                ("noises", Content::Bytes(bytemuck::cast_slice(&noises))),
                ("shadows", Content::Empty(4 * pixels.fragments.len() as u64)),
                ("penumbra", Content::Uniform(bytemuck::cast_slice(&uniform))),
            ] {
                chain.put(name, content).map_err(stopped)?;
            }
            for round in 0..timing.rounds {
                let mut order = techniques.clone();
                if round % 2 == 1 {
                    order.reverse();
                }
                for index in order {
                    let technique = &self.experiment.technique[index];
                    let Some(modules) = technique.method.modules(&map, &penumbra) else { continue };
                    let table = 4 * u64::from(width * width) * modules.channels as u64;
                    let passes = modules.passes(width, pixels.fragments.len());
                    let warm_up = Duration::from_millis(timing.warm_up_ms);
                    let timed = chain
                        .put("table", Content::Empty(table))
                        .and_then(|()| chain.time(&passes, warm_up, timing.frames));
                    let timed = match timed {
                        Ok(timed) => timed,
                        Err(error @ DeviceError::Lost(_)) => return Err(stopped(error)),
                        // Others may still work, for example with a smaller table.
                        Err(reason) => {
                            gpu.skipped += 1;
                            gpu.last_skipped = format!("{} at {width}^2: {reason}", technique.name);
                            continue;
                        }
                    };
                    for pass in timed {
                        samples.extend(pass.times.iter().enumerate().map(|(index, time)| PassSample {
                            technique: technique.name.clone(),
                            region: point.region,
                            map_size: point.map_size,
                            width: point.output[0],
                            height: point.output[1],
                            receivers: pixels.receivers,
                            pass: pass.pass.to_owned(),
                            frame: round * timing.frames + index,
                            time_ns: u64::try_from(time.as_nanos()).unwrap_or(u64::MAX),
                        }));
                    }
                }
            }
        }
        if samples.is_empty() {
            return Err("not timed: the adapter has no timestamps".to_owned());
        }
        Ok(())
    }

    /// The map, a light whose search region has the wanted width, and what the camera sees.
    fn prepared(
        &self,
        view: &SoftView<'_>,
        Point { map_size, output, region }: Point,
    ) -> Result<(DepthMap, Penumbra<f64>, Pixels), String> {
        let scene = view.scene.scene;
        let light =
            LightFrame::of_view(scene, view.light, map_size, map_size).map_err(|error| error.to_string())?;
        let map = shadow_renderer::DepthMap::render(scene, &light, Sampling::Single)
            .map_err(|error| error.to_string())?;
        let size = map_size as usize;
        let map = DepthMap::new(size, size, map.depths).map_err(|error| error.to_string())?;
        let depth_range = light.depth_range;
        let half_size = light.texels_per_unit.map(|texels| 0.5 * region / (depth_range * texels));
        let penumbra =
            Penumbra { half_size, near: None, depth_range, texels_per_unit: light.texels_per_unit };
        let frame = Frame::render(scene, output[0], output[1]).map_err(|error| error.to_string())?;
        let seen = Seen { frame: &frame, light: &light };
        let (bias, texel_depth) = (&self.experiment.bias[0], texel_depth(&light));
        let fragment = |pixel: usize| {
            let (receiver, at) = seen.receiver(pixel).filter(|_| seen.faces_light(pixel))?;
            let compared = bias.compared(&receiver, texel_depth, self.experiment.scenery.plane_limit);
            Some([at.x, at.y, receiver.depth, receiver.depth - compared].map(|value| value as f32))
        };
        let found: Vec<Option<[f32; 4]>> = (0..seen.len()).into_par_iter().map(fragment).collect();
        let receivers = found.iter().flatten().count();
        let fragments = found.into_iter().map(Option::unwrap_or_default).collect();
        Ok((map, penumbra, Pixels { fragments, receivers }))
    }
}
