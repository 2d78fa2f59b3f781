//! Whole shadowed frames on the GPU with a timestamp around each pass: shadow map, resolve with transform, two filter
//! passes, mip maps, surfaces as the camera sees them, deferred shading (MSM15 section 4.4 and Figure 7).
//!
//! The shaders of a technique come from outside, as WGSL; this module knows textures, passes and times only.

use std::time::{Duration, Instant};

use graphics_device::{DeviceError, GraphicsDevice, PassTimer};
use scenes::Scene;
use scenes::vector::normalize;
use shaders::{FrameShaders, TexelFormat};
use wgpu::{TextureFormat as Format, TextureUsages as Uses};

use super::bind::Resource;
use super::compute_frame::{ComputeMaps, ComputeShading};
use super::filter_chain::{Chain, filtered, map_resources};
use super::geometry::{Geometry, LightPass, Surfaces};
use super::raster_pass::RasterPass;
use crate::light_frame::check_size;
use crate::{LightFrame, RenderError};

/// A frame's sizes and parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameSettings {
    /// Side of the shadow map in texels.
    pub map_size: u32,
    /// Output width in pixels.
    pub width: u32,
    /// Output height in pixels.
    pub height: u32,
    /// Samples a texel of the shadow map, 1 or 4; comparisons take 1.
    pub samples: u32,
    /// Whether mip maps are made and read.
    pub mip_maps: bool,
    /// Depth bias.
    pub bias: f32,
    /// Shadows are divided by 1 minus this.
    pub leak_reduction: f32,
    /// How everything but the depth map and the surfaces is computed.
    pub route: Route,
}

/// How the passes after rasterisation are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// As fragment shaders.
    Fragment,
    /// As compute shaders.
    Compute,
    /// As compute shaders without run-time checks of indices.
    Unchecked,
}

/// Numbers passes as they are drawn.
pub(super) struct Stamps<'a> {
    pub timer: Option<&'a PassTimer>,
    names: Vec<&'static str>,
}

impl Stamps<'_> {
    /// Draws a pass of the raster pipeline.
    pub(super) fn draw(&mut self, encoder: &mut wgpu::CommandEncoder, name: &'static str, pass: &RasterPass) {
        let number = self.next(name);
        pass.draw(encoder, self.timer.map(|timer| timer.writes(number)));
    }

    /// The number of the next pass.
    pub(super) fn next(&mut self, name: &'static str) -> u32 {
        self.names.push(name);
        self.names.len() as u32 - 1
    }
}

/// GPU times of one pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTimes {
    /// `shadow map`, `resolve`, `filter rows`, `filter columns`, `mip maps`, `surfaces`, `shade`, or [`WHOLE_FRAME`] from the
    /// beginning of the first to the end of the last.
    pub pass: &'static str,
    /// One a frame.
    pub times: Vec<Duration>,
}

/// Most passes of a frame.
const PASSES: u32 = 7;

/// The last row of [`PassTimes`].
pub const WHOLE_FRAME: &str = "frame";

/// A rendered frame.
#[derive(Clone, Debug, PartialEq)]
pub struct GpuFrame {
    /// sRGB, row by row.
    pub image: image::RgbaImage,
    /// Shadow a pixel, 0 lit.
    pub shadow: Vec<f32>,
    /// The filtered map before mip maps, channel by channel within each texel as stored in single floats; `None` for comparisons
    /// and other formats.
    pub filtered: Option<Vec<f32>>,
}

/// A device with a scene on it.
pub struct FrameRenderer {
    gpu: GraphicsDevice,
    geometry: Geometry,
    scene_light: [f64; 3],
    scene: Scene,
    direction: [f32; 3],
}

/// Features that are used where the adapter has them.
const WANTED: wgpu::Features = wgpu::Features::TIMESTAMP_QUERY
    .union(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM)
    .union(wgpu::Features::FLOAT32_FILTERABLE)
    .union(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);

impl FrameRenderer {
    /// Opens a device of its own and uploads a scene, lit along `direction`.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] without an adapter or where it fails; the errors of [`LightFrame::fit`] and
    /// [`crate::Frame::render`] for a scene, direction or camera that make no sense.
    pub fn new(scene: &Scene, direction: [f32; 3]) -> Result<Self, RenderError> {
        LightFrame::fit(scene, direction, 64, 64)?;
        let gpu = GraphicsDevice::open(WANTED)?;
        let geometry = gpu.watched(|| Geometry::upload(&gpu, scene))?;
        let scene_light = normalize(direction.map(|c| -f64::from(c)));
        Ok(Self { gpu, geometry, scene_light, scene: scene.clone(), direction })
    }

    /// Gives the device up, as a driver that crashes does. Every later frame is an error.
    pub fn lose(&self) {
        self.gpu.lose();
    }

    /// Renders a frame with a technique.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] where the device fails or is lost, lacks memory or cannot filter the format;
    /// [`RenderError::MapSize`] for sizes outside 1..=[`crate::MAX_MAP_SIZE`].
    pub fn render(&self, shaders: &FrameShaders, settings: &FrameSettings) -> Result<GpuFrame, RenderError> {
        self.checked(settings, || {
            let frame = Prepared::new(self, shaders, settings)?;
            frame.draw(&self.gpu)?;
            frame.read(&self.gpu, settings)
        })
    }

    /// GPU times of `frames` frames, by pass; empty where the adapter has no timestamps. Frames before these are not
    /// counted: one that compiles, and more until `warm_up` is over, since an idle processor runs at a lower clock.
    ///
    /// # Errors
    /// Those of [`FrameRenderer::render`].
    pub fn time(
        &self,
        shaders: &FrameShaders,
        settings: &FrameSettings,
        warm_up: Duration,
        frames: usize,
    ) -> Result<Vec<PassTimes>, RenderError> {
        self.checked(settings, || {
            let prepared = Prepared::new(self, shaders, settings)?;
            prepared.draw(&self.gpu)?;
            let start = Instant::now();
            while start.elapsed() < warm_up {
                prepared.draw(&self.gpu)?;
            }
            let mut passes: Vec<PassTimes> = Vec::new();
            for _ in 0..frames {
                let times = prepared.draw(&self.gpu)?;
                if passes.is_empty() {
                    passes = times.iter().map(|&(pass, _)| PassTimes { pass, times: Vec::new() }).collect();
                }
                passes.iter_mut().zip(times).for_each(|(pass, (_, time))| pass.times.push(time));
            }
            Ok(passes)
        })
    }

    fn checked<T>(
        &self,
        settings: &FrameSettings,
        work: impl FnOnce() -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        check_size(settings.map_size, settings.map_size)?;
        check_size(settings.width, settings.height)?;
        self.gpu.watched(work)
    }
}

/// Textures, pipelines and queries of a technique's frames.
struct Prepared {
    light: LightPass,
    surfaces: RasterPass,
    steps: Steps,
    timer: Option<PassTimer>,
}

/// The passes that a technique brings.
enum Steps {
    Fragment(Option<Chain>, Shading),
    Compute(Option<ComputeMaps>, ComputeShading),
}

impl Prepared {
    fn new(
        renderer: &FrameRenderer,
        shaders: &FrameShaders,
        settings: &FrameSettings,
    ) -> Result<Self, RenderError> {
        let (gpu, scene) = (&renderer.gpu, &renderer.scene);
        let samples = match shaders {
            FrameShaders::Prefiltered { .. } => settings.samples,
            FrameShaders::Comparison { .. } => 1,
        };
        let frame = LightFrame::fit(scene, renderer.direction, settings.map_size, settings.map_size)?;
        let light = renderer.geometry.light_pass(gpu, scene, &frame, samples)?;
        let size = (settings.width, settings.height);
        let (surfaces, seen) = renderer.geometry.surfaces(gpu, scene, size)?;
        let light_rows = light_uniform(&frame, renderer.scene_light, settings);
        let light_rows = gpu.buffer_of("light", &light_rows, wgpu::BufferUsages::UNIFORM);
        let formats: Vec<Format> = match shaders {
            FrameShaders::Prefiltered { textures, format, .. } => {
                textures.iter().map(|&channels| texture_format(*format, channels)).collect()
            }
            FrameShaders::Comparison { .. } => Vec::new(),
        };
        let depths = &light.depths;
        let steps = if settings.route == Route::Fragment {
            let (shade, chain) = match shaders {
                FrameShaders::Prefiltered { resolve, rows, columns, halve, shade, .. } => {
                    let passes = [resolve, rows, columns, halve].map(String::as_str);
                    (shade, Some(Chain::new(gpu, passes, &formats, settings, depths)?))
                }
                FrameShaders::Comparison { shade, .. } => (shade, None),
            };
            let views = whole(chain.as_ref().map_or(&[][..], |chain| &chain.maps));
            let linear = linear(gpu);
            let resources = shading_resources(&seen, &light_rows, (&views, &linear), depths);
            Steps::Fragment(chain, Shading::new(gpu, shade, resources, size)?)
        } else {
            let (shade, maps) = match shaders {
                FrameShaders::Prefiltered { compute, .. } => {
                    (&compute.shade, Some(ComputeMaps::new(gpu, compute, &formats, settings, depths)?))
                }
                FrameShaders::Comparison { compute_shade, .. } => (compute_shade, None),
            };
            let views = whole(maps.as_ref().map_or(&[][..], |maps| &maps.maps));
            let linear = linear(gpu);
            let resources = shading_resources(&seen, &light_rows, (&views, &linear), depths);
            Steps::Compute(maps, ComputeShading::new(gpu, (shade, settings.route), resources, size)?)
        };
        Ok(Self { light, surfaces, steps, timer: PassTimer::new(gpu, PASSES) })
    }

    /// Renders a frame and waits for it: its passes with their times, none without timestamps.
    fn draw(&self, gpu: &GraphicsDevice) -> Result<Vec<(&'static str, Duration)>, RenderError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut stamps = Stamps { timer: self.timer.as_ref(), names: Vec::new() };
        stamps.draw(&mut encoder, "shadow map", &self.light.pass);
        match &self.steps {
            Steps::Fragment(chain, _) => {
                if let Some(chain) = chain {
                    chain.draw(&mut encoder, &mut stamps);
                }
            }
            Steps::Compute(maps, _) => {
                if let Some(maps) = maps {
                    maps.draw(&mut encoder, &mut stamps);
                }
            }
        }
        stamps.draw(&mut encoder, "surfaces", &self.surfaces);
        match &self.steps {
            Steps::Fragment(_, shade) => stamps.draw(&mut encoder, "shade", &shade.pass),
            Steps::Compute(_, shade) => shade.draw(&mut encoder, &mut stamps),
        }
        let mut names = stamps.names;
        if let Some(timer) = &self.timer {
            timer.resolve(&mut encoder, names.len());
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let Some(timer) = &self.timer else { return Ok(Vec::new()) };
        let times = timer.read(gpu, names.len())?;
        names.push(WHOLE_FRAME);
        Ok(names.into_iter().zip(times).collect())
    }

    fn read(&self, gpu: &GraphicsDevice, settings: &FrameSettings) -> Result<GpuFrame, RenderError> {
        let (maps, colour, shadow) = match &self.steps {
            Steps::Fragment(chain, shade) => {
                (chain.as_ref().map(|chain| &chain.maps), &shade.colour, &shade.shadow)
            }
            Steps::Compute(maps, shade) => {
                (maps.as_ref().map(|maps| &maps.maps), &shade.colour, &shade.shadow)
            }
        };
        let pixels = gpu.read_texture(colour)?;
        let image = image::RgbaImage::from_raw(settings.width, settings.height, pixels)
            .ok_or_else(|| DeviceError::Failed("the picture has another size".to_owned()))?;
        let shadow = gpu.read_texture(shadow)?;
        let filtered = maps.map(|maps| filtered(gpu, maps)).transpose()?.flatten();
        Ok(GpuFrame { image, shadow, filtered })
    }
}

fn texture_format(format: TexelFormat, channels: usize) -> Format {
    match (format, channels) {
        (TexelFormat::F32, 1) => Format::R32Float,
        (TexelFormat::F32, 2) => Format::Rg32Float,
        (TexelFormat::F32, _) => Format::Rgba32Float,
        (TexelFormat::F16, 1) => Format::R16Float,
        (TexelFormat::F16, 2) => Format::Rg16Float,
        (TexelFormat::F16, _) => Format::Rgba16Float,
        (TexelFormat::Unorm16, 1) => Format::R16Unorm,
        (TexelFormat::Unorm16, 2) => Format::Rg16Unorm,
        (TexelFormat::Unorm16, _) => Format::Rgba16Unorm,
    }
}

fn light_uniform(light: &LightFrame, towards: [f64; 3], settings: &FrameSettings) -> [[f32; 4]; 5] {
    let row = |axis: [f64; 3], scale: f64, offset: f64| {
        [axis[0] * scale, axis[1] * scale, axis[2] * scale, offset].map(|value| value as f32)
    };
    let towards = towards.map(|c| c as f32);
    [
        row(light.right, light.texels_per_unit[0], light.origin_texel[0]),
        row(light.down, light.texels_per_unit[1], light.origin_texel[1]),
        row(light.forward, 1.0 / light.depth_range, -light.near / light.depth_range),
        [towards[0], towards[1], towards[2], settings.bias],
        [settings.map_size as f32, settings.leak_reduction, 0.0, 0.0],
    ]
}

/// Views of all levels.
fn whole(maps: &[wgpu::Texture]) -> Vec<wgpu::TextureView> {
    maps.iter().map(|map| map.create_view(&Default::default())).collect()
}

fn linear(gpu: &GraphicsDevice) -> wgpu::Sampler {
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}

/// What shading reads, by name.
fn shading_resources<'a>(
    surfaces: &'a Surfaces,
    light: &'a wgpu::Buffer,
    (maps, linear): (&'a [wgpu::TextureView], &'a wgpu::Sampler),
    depths: &'a wgpu::TextureView,
) -> Vec<Resource<'a>> {
    let mut resources = map_resources(maps);
    resources.push(("light", light.as_entire_binding()));
    resources.push(("linear", wgpu::BindingResource::Sampler(linear)));
    let named = ["positions", "normals", "albedos"].into_iter().zip(surfaces);
    resources.extend(
        named
            .chain([("depths", depths)])
            .map(|(name, view)| (name, wgpu::BindingResource::TextureView(view))),
    );
    resources
}

struct Shading {
    pass: RasterPass,
    colour: wgpu::Texture,
    shadow: wgpu::Texture,
}

impl Shading {
    fn new(
        gpu: &GraphicsDevice,
        shader: &str,
        resources: Vec<Resource<'_>>,
        size: (u32, u32),
    ) -> Result<Self, DeviceError> {
        let usage = Uses::RENDER_ATTACHMENT | Uses::COPY_SRC;
        let [colour, shadow] =
            [Format::Rgba8Unorm, Format::R32Float].map(|format| gpu.texture(format, size, 1, 1, usage));
        let to = [&colour, &shadow].map(|texture| texture.create_view(&Default::default()));
        let pass = RasterPass::new(gpu, shader, &resources, Vec::new(), to.to_vec(), None)?;
        Ok(Self { pass, colour, shadow })
    }
}
