//! `msm render`: the shadow-map stack of a scene for one light, as arrays and pictures.

mod answer;

use crate::backend::BackendName;
use crate::outcome::{Failure, Output};
use crate::progress::Spinner;
use crate::staging::Staging;
use answer::{Files, answer, write_table};
use anyhow::{Context, anyhow};
use clap::ValueEnum;
use scenes::{
    AreaLight, LightView, LoadOptions, PoseChoice, Scene, SceneError, ViewError, find_view, lit_by,
    load_with_files, procedural, read_views,
};
use shadow_renderer::{
    Frame, LightFrame, MAX_MAP_SIZE, RenderError, RenderReport, ShadowMapStack, Spectrum, pictures,
    render_translucent,
};
use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Instant;

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
    /// stairs, village, grove, hall, smoke, glasshouse or grids, or a .glb, .gltf or .obj file.
    #[arg(value_parser = crate::scene_name())]
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
    #[command(flatten)]
    file: FileArguments,
    /// Camera of the file for the picture, in place of its first one or of one that shows all.
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// What the map is fitted to: all, or casters, which leaves out planes below everything and shows of them what the map
    /// covers. For the sun only.
    #[arg(long, value_enum, default_value = "all")]
    fit: Fit,
    /// The picture in plain grey, so that shadows stand out from busy textures.
    #[arg(long)]
    plain: bool,
    /// Seed of a procedural scene in place of its usual one.
    #[arg(long)]
    seed: Option<u64>,
    #[command(flatten)]
    output: Output,
}

/// What a light frame is fitted to.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Fit {
    All,
    Casters,
}

/// How scene files are read.
#[derive(clap::Args)]
struct FileArguments {
    /// Animation of a glTF file by name or number, none for the pose that the file stores. Without this its only one; several
    /// are clips to choose from, of which none is shown.
    #[arg(long, value_name = "NAME")]
    animation: Option<String>,
    /// Time of the animation, or of the first one, in seconds; before its first frame and after its last it stands still.
    /// Without this its first frame.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    time: Option<f64>,
    /// Refuse a file with whatever would otherwise be a warning.
    #[arg(long)]
    strict: bool,
}

impl FileArguments {
    fn options(&self) -> Result<LoadOptions, Failure> {
        if let Some(time) = self.time.filter(|time| !time.is_finite()) {
            return Err(Failure::Input(anyhow!("--time: {time} is no time")));
        }
        let pose = PoseChoice { animation: self.animation.clone(), time: self.time };
        Ok(LoadOptions { pose, strict: self.strict })
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
            None => load_with_files(&self.scene, &self.file.options()?).map_err(scene_failure)?.0,
            Some(seed) => procedural(&self.scene, seed).ok_or_else(|| {
                let known = procedural::NAMES.join(", ");
                Failure::Input(anyhow!("--seed: `{}` is no procedural scene ({known})", self.scene))
            })?,
        };
        if let Some(path) = &self.views {
            let views = read_views(path).map_err(scene_failure)?;
            scene.views = views.into_iter().map(|view| view.relative_to(scene.origin)).collect();
        }
        if let Some(wanted) = &self.camera {
            let found = scene.cameras.iter().find(|camera| camera.name == *wanted);
            scene.camera = found.map(|found| found.camera).ok_or_else(|| {
                let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
                let known = if names.is_empty() { "it has none".to_owned() } else { names.join(", ") };
                Failure::Input(anyhow!("--camera: `{wanted}` is no camera of this file ({known})"))
            })?;
        }
        Ok(scene)
    }

    /// The light that was asked for, a local one by itself, others along a view.
    fn light(&self, scene: &Scene) -> Result<LightView, Failure> {
        let fail = |error: ViewError| Failure::Input(error.into());
        let wanted = self.view.as_deref();
        let views = match wanted {
            // A local light has its own direction, and its complaint comes first.
            Some(_) if self.light.is_some_and(|light| light.front().is_some()) => Vec::new(),
            Some(wanted) => vec![find_view(&scene.views, wanted).map_err(fail)?],
            None => scene.views.iter().take(1).cloned().collect(),
        };
        let lit = lit_by(self.light, views, wanted, scene.origin).map_err(fail)?;
        lit.into_iter().next().ok_or_else(|| fail(ViewError::None))
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

/// Loads, renders, writes.
pub(crate) fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let spinner = Spinner::new();
    spinner.step("loading the scene");
    let begin = Instant::now();
    let scene = arguments.load()?;
    let light = arguments.light(&scene)?;
    let load = begin.elapsed();

    let base = format!("{}-{}", name_part(&scene.name), name_part(&light.name));
    let names = [".stack.npz", "-depth.png", "-layers.png", "-scene.png"].map(|end| format!("{base}{end}"));
    // Before the long work, so that a folder which cannot be written is reported soon.
    let staging = Staging::new(&arguments.out, &names)?;

    spinner.step("rendering the stack");
    let [width, height] = arguments.size;
    let backend = arguments.backend.into();
    let rendered = match (arguments.fit, light.light.front()) {
        (Fit::All, _) => LightFrame::of_view(&scene, &light, width, height)
            .and_then(|frame| render_translucent(&scene, &frame, Spectrum::Luminance, backend)),
        (Fit::Casters, None) => LightFrame::fit_casters(&scene, light.direction, width, height)
            .and_then(|(cut, frame)| render_translucent(&cut, &frame, Spectrum::Luminance, backend)),
        (Fit::Casters, Some(_)) => {
            return Err(Failure::Input(anyhow!("--fit casters: the light `{}` is not the sun", light.light)));
        }
    };
    if let (BackendName::Gpu, Ok((_, RenderReport { adapter: None, fallback, .. }))) =
        (arguments.backend, &rendered)
    {
        let reason = fallback.as_deref().unwrap_or("none was found");
        return Err(Failure::Failed(anyhow!("--backend gpu: no graphics adapter: {reason}")));
    }
    let (translucent, report) = rendered.map_err(|error| match error {
        RenderError::Light(_) if arguments.light.is_some() => Failure::Input(anyhow!("--light: {error}")),
        RenderError::Light(_) => Failure::Input(anyhow!("view `{}`: {error}", light.name)),
        other => render_failure(other),
    })?;

    spinner.step("writing the stack and pictures");
    let writing = Instant::now();
    let stack = translucent.stack;
    write(&staging, &names, &scene, &light, &stack, &report, arguments.plain)?;
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
    plain: bool,
) -> Result<(), Failure> {
    let frame = report.frame.from_origin(scene.origin);
    stack.save_seen_by(&staging.path(stack_name), Some(&frame)).map_err(render_failure)?;
    // One after another: at the largest size each takes 200 MB.
    pictures::depth_image(stack).save(staging.path(depth)).with_context(|| depth.clone())?;
    pictures::layer_count_image(stack).save(staging.path(layers)).with_context(|| layers.clone())?;
    let mut frame = Frame::render(scene, PICTURE[0], PICTURE[1]).map_err(render_failure)?;
    if plain {
        frame.paint_plain();
    }
    // The picture shows what its own surfaces are: those that are closer to opaque than to clear.
    let opaque =
        if stack.opacities.is_empty() { Cow::Borrowed(stack) } else { Cow::Owned(stack.clone().opaque()) };
    let visibility = frame.hard_shadow(&opaque, &report.frame);
    let shaded = frame.shade(light, &visibility);
    Ok(shaded.save(staging.path(picture)).with_context(|| picture.clone())?)
}
