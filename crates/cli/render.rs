//! `msm render`: the shadow-map stack of a scene for one light, as arrays and pictures.

use crate::outcome::{Failure, Output};
use crate::progress::Spinner;
use crate::staging::Staging;
use anyhow::{Context, anyhow};
use clap::ValueEnum;
use graphics_device::AdapterName;
use scenes::{AreaLight, LightView, Scene, SceneError, load_scene, procedural, read_views};
use serde::Serialize;
use shadow_renderer::{
    Backend, Frame, MAX_MAP_SIZE, RenderError, RenderReport, ShadowMapStack, pictures, render_view,
};
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Pixels of the picture from the camera; it shows the shadow map's resolution, so it does not follow it.
const PICTURE: [u32; 2] = [1280, 720];

/// Longest part of a file name taken from a scene or view, in characters.
const NAME_PART: usize = 60;

/// Render every surface that the light's rays cross, per texel and in order, and pictures of it.
///
/// Writes SCENE-VIEW.stack.npz, SCENE-VIEW-depth.png (layer 0), SCENE-VIEW-layers.png (number of layers) and
/// SCENE-VIEW-scene.png (from the scene's camera, with shadows).
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// stairs, village or grove, or a .glb, .gltf or .obj file.
    scene: String,
    /// Name of a light view, or the direction in which the light travels. Without this the first view: `high` of
    /// procedural scenes, (0.8, -0.6, 0.35) for files.
    #[arg(long, value_name = "NAME|X,Y,Z", allow_hyphen_values = true)]
    view: Option<String>,
    /// Light views in place of the scene's own: a TOML file of `view` tables with name, direction and light.
    #[arg(long, value_name = "FILE.toml")]
    views: Option<PathBuf>,
    /// A light of some size in place of the view's: sun:DEGREES or sun:AxB along the direction of the view, or in space
    /// rect:CENTRE;U;V or disc:CENTRE;U;V with the half axes U and V, shining along U x V; vectors are x,y,z.
    #[arg(long, value_name = "LIGHT", allow_hyphen_values = true, conflicts_with = "views")]
    light: Option<AreaLight>,
    /// Texels of the shadow map, N for a square or WxH.
    #[arg(long, default_value = "1024", value_name = "N|WxH", value_parser = parse_size, allow_hyphen_values = true)]
    size: [u32; 2],
    /// auto takes a graphics adapter unless it is a software one; gpu takes any. The stack is the same.
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendName,
    /// Folder for the files; created where it is missing. Files of the same name are replaced.
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Seed of a procedural scene in place of its usual one.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    output: Output,
}

#[derive(Clone, Copy, ValueEnum)]
enum BackendName {
    Cpu,
    Gpu,
    Auto,
}

impl From<BackendName> for Backend {
    fn from(name: BackendName) -> Self {
        match name {
            BackendName::Cpu => Self::Cpu,
            BackendName::Gpu => Self::Gpu,
            BackendName::Auto => Self::Auto,
        }
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let number = |side: &str| match side.trim().parse::<u32>() {
        Ok(side) if (1..=MAX_MAP_SIZE).contains(&side) => Ok(side),
        _ => Err(format!("expected N or WxH with whole numbers from 1 to {MAX_MAP_SIZE}")),
    };
    match text.split_once('x') {
        Some((width, height)) => Ok([number(width)?, number(height)?]),
        None => number(text).map(|side| [side; 2]),
    }
}

fn scene_failure(error: SceneError) -> Failure {
    Failure::Input(error.into())
}

/// Sorts errors by whose fault they are: what scene, light and size ask for is input.
fn render_failure(error: RenderError) -> Failure {
    match error {
        RenderError::File { .. } | RenderError::InvalidStack { .. } | RenderError::Gpu(_) => {
            Failure::Failed(error.into())
        }
        _ => Failure::Input(error.into()),
    }
}

impl Arguments {
    fn load(&self) -> Result<Scene, Failure> {
        let mut scene = match self.seed {
            None => load_scene(&self.scene).map_err(scene_failure)?,
            Some(seed) => procedural(&self.scene, seed).ok_or_else(|| {
                let known = procedural::NAMES.join(", ");
                Failure::Input(anyhow!("--seed: `{}` is no procedural scene ({known})", self.scene))
            })?,
        };
        if let Some(path) = &self.views {
            scene.views = read_views(path).map_err(scene_failure)?;
        }
        Ok(scene)
    }

    /// The light that was asked for, a local one by itself, others along a view.
    fn light(&self, views: &[LightView]) -> Result<LightView, Failure> {
        let Some(light) = self.light else { return self.view(views) };
        if light.front().is_none() {
            let along = self.view(views)?;
            return Ok(LightView::new(format!("{} {light}", along.name), light, along.direction));
        }
        match &self.view {
            None => Ok(LightView::new(light.to_string(), light, [0.0; 3])),
            Some(view) => {
                Err(Failure::Input(anyhow!("--view {view}: the light `{light}` shines along U x V")))
            }
        }
    }

    /// A view's name first, else a direction.
    fn view(&self, views: &[LightView]) -> Result<LightView, Failure> {
        let Some(wanted) = &self.view else {
            let none = || Failure::Input(anyhow!("the scene has no light view; give --view x,y,z"));
            return views.first().cloned().ok_or_else(none);
        };
        if let Some(view) = views.iter().find(|view| view.name == *wanted) {
            return Ok(view.clone());
        }
        let numbers: Result<Vec<f64>, _> = wanted.split(',').map(|number| number.trim().parse()).collect();
        let direction = match numbers.as_deref() {
            Ok(&[x, y, z]) => [x, y, z].map(|component| component as f32),
            _ => {
                let names: Vec<&str> = views.iter().map(|view| view.name.as_str()).collect();
                let known = names.join(", ");
                return Err(Failure::Input(anyhow!(
                    "--view: `{wanted}` is neither a view of this scene ({known}) nor a direction x,y,z"
                )));
            }
        };
        if !direction.iter().all(|component| component.is_finite()) || direction == [0.0; 3] {
            let what = "is no direction: it must be finite and not zero";
            return Err(Failure::Input(anyhow!("--view: `{wanted}` {what}")));
        }
        Ok(LightView::directional(format!("light {wanted}"), direction))
    }
}

/// A part of a file name that every file system takes.
fn name_part(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || "-+.".contains(c) { c } else { '_' };
    let part: String = name.chars().map(safe).take(NAME_PART).collect();
    // No hidden files and no `..`.
    let visible = part.trim_start_matches('.');
    if visible.is_empty() { "_".to_owned() } else { visible.to_owned() }
}

/// The result as recorded in JSON.
#[derive(Serialize)]
struct Answer {
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
struct Files {
    stack: String,
    depth: String,
    layers: String,
    scene: String,
}

fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}

/// Loads, renders, writes.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let spinner = Spinner::new();
    spinner.step("loading the scene");
    let begin = Instant::now();
    let scene = arguments.load()?;
    let light = arguments.light(&scene.views)?;
    let load = begin.elapsed();

    let base = format!("{}-{}", name_part(&scene.name), name_part(&light.name));
    let names = [".stack.npz", "-depth.png", "-layers.png", "-scene.png"].map(|end| format!("{base}{end}"));
    // Before the long work, so that a folder which cannot be written is reported soon.
    let staging = Staging::new(&arguments.out, &names)?;

    spinner.step("rendering the stack");
    let [width, height] = arguments.size;
    let (stack, report) = render_view(&scene, &light, width, height, arguments.backend.into()).map_err(
        |error| match error {
            RenderError::Light(_) if arguments.light.is_some() => Failure::Input(anyhow!("--light: {error}")),
            RenderError::Light(_) => Failure::Input(anyhow!("view `{}`: {error}", light.name)),
            other => render_failure(other),
        },
    )?;

    spinner.step("writing the stack and pictures");
    let writing = Instant::now();
    write(&staging, &names, &scene, &light, &stack, &report)?;
    let files = staging.publish(&names)?;
    let pictures_and_files = writing.elapsed();
    drop(spinner);

    let [stack_file, depth, layers, picture] = [0, 1, 2, 3].map(|i| files[i].display().to_string());
    let files = Files { stack: stack_file, depth, layers, scene: picture };
    let answer = answer(&scene, light, &stack, &report, [load, pictures_and_files], files);
    arguments.output.emit(&answer, |out| write_table(out, &answer))
}

fn write(
    staging: &Staging,
    [stack_name, depth, layers, picture]: &[String; 4],
    scene: &Scene,
    light: &LightView,
    stack: &ShadowMapStack,
    report: &RenderReport,
) -> Result<(), Failure> {
    stack.save(&staging.path(stack_name)).map_err(render_failure)?;
    // One after another: at the largest size each takes 200 MB.
    pictures::depth_image(stack).save(staging.path(depth)).with_context(|| depth.clone())?;
    pictures::layer_count_image(stack).save(staging.path(layers)).with_context(|| layers.clone())?;
    let frame = Frame::render(scene, PICTURE[0], PICTURE[1]).map_err(render_failure)?;
    let visibility = frame.hard_shadow(stack, &report.frame);
    let shaded = frame.shade(light, &visibility);
    Ok(shaded.save(staging.path(picture)).with_context(|| picture.clone())?)
}

fn answer(
    scene: &Scene,
    light: LightView,
    stack: &ShadowMapStack,
    report: &RenderReport,
    [load, pictures_and_files]: [Duration; 2],
    files: Files,
) -> Answer {
    let statistics = stack.layer_statistics();
    let (frame, times) = (report.frame, report.times);
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

fn write_table(out: &mut dyn Write, answer: &Answer) -> io::Result<()> {
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
        "fragments  {} on {} of {}x{} texels",
        answer.fragments, answer.covered_texels, answer.width, answer.height
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
    let files = &answer.files;
    [&files.stack, &files.depth, &files.layers, &files.scene].iter().try_for_each(|f| writeln!(out, "  {f}"))
}
