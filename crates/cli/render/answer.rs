//! What `msm render` answers: one JSON object, or the same as lines.

use graphics_device::AdapterName;
use scenes::{AreaLight, LightView, Scene, Warning};
use serde::Serialize;
use shadow_renderer::{RenderReport, ShadowMapStack};
use std::io::{self, Write};
use std::time::Duration;

/// The result as recorded in JSON.
#[derive(Serialize)]
pub(super) struct Answer {
    scene: String,
    view: String,
    direction: [f32; 3],
    /// As `--light` takes it.
    light: AreaLight,
    width: u32,
    height: u32,
    backend: &'static str,
    adapter: Option<Adapter>,
    /// Why the CPU rendered although a GPU was asked for.
    fallback: Option<String>,
    /// Of the scene as rendered, without those dropped on loading.
    triangles: usize,
    /// Without area in the file.
    degenerate_on_loading: usize,
    /// Without area as seen by the light, on the map's grid.
    degenerate_on_map: usize,
    fragments: usize,
    covered_texels: usize,
    /// Of those, the ones where the first surface has another behind it.
    shadowing_texels: usize,
    /// Least and greatest coordinates of what the file shows, without added ground.
    bounds: [[f64; 3]; 2],
    /// The file's animations, and the one whose pose is shown.
    animations: Vec<String>,
    animation: Option<String>,
    /// Cameras of the file.
    cameras: Vec<String>,
    /// What the file asks for and does not get.
    warnings: Vec<Warning>,
    layers: Layers,
    light_frame: Light,
    time_ms: Times,
    files: Files,
}

#[derive(Serialize)]
struct Adapter {
    name: String,
    device_type: String,
    driver: String,
    api: String,
}

impl From<&AdapterName> for Adapter {
    fn from(adapter: &AdapterName) -> Self {
        let AdapterName { name, device_type, driver, api } = adapter.clone();
        Self { name, device_type, driver, api }
    }
}

#[derive(Serialize)]
struct Layers {
    mean: f64,
    p95: u32,
    max: u32,
}

/// From world positions p to texels and depth.
#[derive(Serialize)]
struct Light {
    right: [f64; 3],
    down: [f64; 3],
    forward: [f64; 3],
    /// Where a local light's map is seen from; null for a directional light.
    eye: Option<[f64; 3]>,
    texels_per_unit: [f64; 2],
    origin_texel: [f64; 2],
    near: f64,
    depth_range: f64,
}

#[derive(Serialize)]
struct Times {
    load: f64,
    prepare: f64,
    device: f64,
    raster: f64,
    group: f64,
    sort: f64,
    assemble: f64,
    /// From the scene to the stack, wall clock; on the CPU raster, group and sort overlap and are sums over threads.
    render: f64,
    pictures_and_files: f64,
}

#[derive(Serialize)]
pub(super) struct Files {
    pub stack: String,
    pub depth: String,
    pub layers: String,
    pub scene: String,
}

fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}

/// Gathers it; `load` and `pictures_and_files` are times.
pub(super) fn answer(
    scene: &Scene,
    light: LightView,
    stack: &ShadowMapStack,
    report: &RenderReport,
    [load, pictures_and_files]: [Duration; 2],
    files: Files,
) -> Answer {
    let statistics = stack.layer_statistics();
    let (frame, times) = (report.frame, report.times);
    // The scene's positions are relative to its origin; the answer's are the file's.
    let origin = scene.origin;
    let world = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] + origin[k]);
    let frame = frame.from_origin(origin);
    let light = light.relative_to(origin.map(|c| -c));
    Answer {
        scene: scene.name.clone(),
        view: light.name,
        direction: light.direction,
        light: light.light,
        width: stack.width,
        height: stack.height,
        backend: if report.adapter.is_some() { "gpu" } else { "cpu" },
        adapter: report.adapter.as_ref().map(Adapter::from),
        fallback: report.fallback.clone(),
        triangles: report.triangles,
        degenerate_on_loading: scene.degenerate_triangles,
        degenerate_on_map: report.degenerate_triangles,
        fragments: report.fragments,
        covered_texels: statistics.covered_texels,
        shadowing_texels: stack.offsets.windows(2).filter(|pair| pair[1] - pair[0] > 1).count(),
        bounds: scene.bounds.map(world),
        animations: scene.animations.clone(),
        animation: scene.animation.clone(),
        cameras: scene.cameras.iter().map(|camera| camera.name.clone()).collect(),
        warnings: scene.warnings.clone(),
        layers: Layers { mean: statistics.mean, p95: statistics.p95, max: statistics.max },
        light_frame: Light {
            right: frame.right,
            down: frame.down,
            forward: frame.forward,
            eye: frame.eye,
            texels_per_unit: frame.texels_per_unit,
            origin_texel: frame.origin_texel,
            near: frame.near,
            depth_range: frame.depth_range,
        },
        time_ms: Times {
            load: milliseconds(load),
            prepare: milliseconds(times.prepare),
            device: milliseconds(times.device),
            raster: milliseconds(times.raster),
            group: milliseconds(times.group),
            sort: milliseconds(times.sort),
            assemble: milliseconds(times.assemble),
            render: milliseconds(times.total),
            pictures_and_files: milliseconds(pictures_and_files),
        },
        files,
    }
}

/// As lines.
pub(super) fn write_table(out: &mut dyn Write, answer: &Answer) -> io::Result<()> {
    let [x, y, z] = answer.direction;
    write!(out, "{}, {}: light along ({x}, {y}, {z})", answer.scene, answer.view)?;
    if answer.light.has_extent() {
        write!(out, ", {}", answer.light)?;
    }
    writeln!(out)?;
    writeln!(
        out,
        "triangles  {} (without area: {} dropped on loading, {} on the map)",
        answer.triangles, answer.degenerate_on_loading, answer.degenerate_on_map
    )?;
    writeln!(
        out,
        "fragments  {} on {} of {}x{} texels, {} of them with another surface behind the first",
        answer.fragments, answer.covered_texels, answer.width, answer.height, answer.shadowing_texels
    )?;
    let Layers { mean, p95, max } = answer.layers;
    writeln!(out, "layers     mean {mean:.2}, p95 {p95}, max {max}")?;
    match (&answer.adapter, &answer.fallback) {
        (Some(Adapter { name, device_type, driver, api }), _) => {
            writeln!(out, "backend    gpu: {name} ({device_type}, {api}, {driver})")?
        }
        (None, Some(reason)) => writeln!(out, "backend    cpu, no gpu: {reason}")?,
        (None, None) => writeln!(out, "backend    cpu")?,
    }
    let t = &answer.time_ms;
    writeln!(out, "load       {:.1} ms", t.load)?;
    writeln!(
        out,
        "render     {:.1} ms: prepare {:.1}, device {:.1}, raster {:.1}, group {:.1}, sort {:.1}, assemble {:.1}{}",
        t.render,
        t.prepare,
        t.device,
        t.raster,
        t.group,
        t.sort,
        t.assemble,
        if answer.adapter.is_some() { "" } else { " (raster, group, sort: sums over threads)" }
    )?;
    writeln!(out, "write      {:.1} ms, pictures included", t.pictures_and_files)?;
    answer.warnings.iter().try_for_each(|warning| writeln!(out, "warning    {warning}"))?;
    let files = &answer.files;
    [&files.stack, &files.depth, &files.layers, &files.scene].iter().try_for_each(|f| writeln!(out, "  {f}"))
}
