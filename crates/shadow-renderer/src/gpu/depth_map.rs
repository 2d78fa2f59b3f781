//! Ordinary depth maps from the GPU's raster pipeline, with one or several samples a texel.

use graphics_device::{DeviceError, GraphicsDevice};
use scenes::Scene;
use wgpu::BufferUsages as Usage;

use super::READ_DEPTHS;
use super::compute_shader::ComputeShader;
use super::geometry::{LightPass, MaskBuffers};
use crate::stack::fixed_point::Masks;
use crate::{BINDING_BYTES, LightFrame, RenderError};

/// Nearest depths of a directional light's view with `samples` samples a texel.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Samples per texel.
    pub samples: u32,
    /// Depths in [0, 1], 1 where nothing is hit: sample `s` of texel (x, y) is `(y * width + x) * samples + s`.
    pub depths: Vec<f32>,
}

/// How many samples a texel of a [`DepthMap`] has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// One, at the texel's centre.
    Single,
    /// Four by the hardware's multisampling, at its positions.
    Multisample4,
    /// Eight, each rendered on its own; positions as in [`SUPERSAMPLE_8`].
    Supersample8,
}

/// Positions of the samples of [`Sampling::Supersample8`] relative to the texel's centre, in texels, x to the right
/// and y downwards: every column and every row of an 8 x 8 raster holds exactly one.
pub const SUPERSAMPLE_8: [[f32; 2]; 8] = [
    [-0.4375, -0.0625],
    [-0.3125, 0.3125],
    [-0.1875, -0.3125],
    [-0.0625, 0.1875],
    [0.0625, -0.1875],
    [0.1875, 0.4375],
    [0.3125, 0.0625],
    [0.4375, -0.4375],
];

/// Entry points of read_depths.wgsl for one and for several samples.
pub(super) const READERS: [&str; 2] = ["read_single", "read_multiple"];

impl DepthMap {
    /// Renders on [`GraphicsDevice::shared`], both sides of triangles.
    ///
    /// Coverage and depth follow the hardware's rules: compare with tolerances, use stacks where bits matter.
    /// Surfaces with a depth outside of [0, 1] are clipped away.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] without adapter or where it fails or lacks memory; [`RenderError::MapSize`],
    /// [`RenderError::Scene`] as for stacks; [`RenderError::Perspective`] for the frame of a local light.
    pub fn render(scene: &Scene, frame: &LightFrame, sampling: Sampling) -> Result<Self, RenderError> {
        crate::light_frame::check_size(frame.width, frame.height)?;
        if frame.eye.is_some() {
            return Err(RenderError::Perspective);
        }
        scene.check()?;
        let masks = Masks::new(scene)?;
        let gpu = GraphicsDevice::shared()?;
        gpu.watched(|| render(gpu, scene, &masks, frame, sampling))
    }
}

fn render(
    gpu: &GraphicsDevice,
    scene: &Scene,
    masks: &Masks,
    frame: &LightFrame,
    sampling: Sampling,
) -> Result<DepthMap, RenderError> {
    let (width, height) = (frame.width, frame.height);
    let (per_pass, offsets): (u32, &[[f32; 2]]) = match sampling {
        Sampling::Single => (1, &[[0.0; 2]]),
        Sampling::Multisample4 => (4, &[[0.0; 2]]),
        Sampling::Supersample8 => (1, &SUPERSAMPLE_8),
    };
    let light = LightPass::new(gpu, scene, (masks, &MaskBuffers::upload(gpu, masks)), frame, per_pass)?;
    let reader = ComputeShader::new(gpu, READ_DEPTHS, READERS[usize::from(per_pass > 1)])?;

    let samples = per_pass * offsets.len() as u32;
    let mut depths = vec![0.0; width as usize * height as usize * samples as usize];
    for (pass_index, &offset) in offsets.iter().enumerate() {
        light.shift(gpu, offset);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        light.pass.draw(&mut encoder, None);
        gpu.queue.submit([encoder.finish()]);

        let band_rows = (BINDING_BYTES / (u64::from(width * per_pass) * 4)).min(u64::from(height)) as u32;
        for first in (0..height).step_by(band_rows as usize) {
            let rows = band_rows.min(height - first);
            let band = read_rows(gpu, &reader, &light.depths, [width, first, rows, per_pass])?;
            let texels = depths.chunks_exact_mut(samples as usize).skip(first as usize * width as usize);
            for (texel, values) in texels.zip(band.chunks_exact(per_pass as usize)) {
                texel[pass_index * per_pass as usize..][..per_pass as usize].copy_from_slice(values);
            }
        }
    }
    Ok(DepthMap { width, height, samples, depths })
}

/// The depths of some rows; `rows` is width, first row, number of rows and samples a texel.
fn read_rows(
    gpu: &GraphicsDevice,
    reader: &ComputeShader,
    view: &wgpu::TextureView,
    rows: [u32; 4],
) -> Result<Vec<f32>, DeviceError> {
    let [width, _, count, samples] = rows;
    let bytes = u64::from(width) * u64::from(count) * u64::from(samples) * 4;
    let depths = gpu.buffer("depths", bytes, Usage::STORAGE | Usage::COPY_SRC);
    let rows = gpu.buffer_of("rows", &rows, Usage::UNIFORM);
    let resources = [
        ("single", wgpu::BindingResource::TextureView(view)),
        ("multiple", wgpu::BindingResource::TextureView(view)),
        ("depths", depths.as_entire_binding()),
        ("rows", rows.as_entire_binding()),
    ];
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    reader.dispatch(gpu, &mut encoder, &resources, reader.groups_of([width, count]))?;
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&depths, 0, bytes)
}
