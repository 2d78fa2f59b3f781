//! Ordinary depth maps from the GPU's raster pipeline, with one or several samples a texel.

use bytemuck::{Pod, Zeroable};
use wgpu::{BufferUsages as Usage, TextureUsages};

use crate::stack::fixed_point::Masks;
use crate::{BINDING_BYTES, LightFrame, RenderError};
use graphics_device::GraphicsDevice;
use scenes::Scene;

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

/// Corners sent to the device in one piece: 24 bytes each, three a triangle.
const TRIANGLES_PER_BUFFER: usize = 1 << 20;
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Corner {
    position: [f32; 3],
    uv: [f32; 2],
    mask: u32,
}

impl DepthMap {
    /// Renders on [`GraphicsDevice::shared`], both sides of triangles.
    ///
    /// Coverage and depth follow the hardware's rules: compare with tolerances, use stacks where bits matter.
    /// Surfaces with a depth outside of [0, 1] are clipped away.
    ///
    /// # Errors
    /// [`RenderError::Gpu`] without adapter or where it fails or lacks memory; [`RenderError::MapSize`],
    /// [`RenderError::Scene`] as for stacks.
    pub fn render(scene: &Scene, frame: &LightFrame, sampling: Sampling) -> Result<Self, RenderError> {
        crate::light_frame::check_size(frame.width, frame.height)?;
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
    let buffers = upload(gpu, scene, masks, frame);
    let entries: Vec<[u32; 3]> = masks.entries.iter().map(|e| [e.width, e.height, e.first_bit]).collect();
    let entries = gpu.buffer_of("masks", &entries, Usage::STORAGE);
    let bits = gpu.buffer_of("mask bits", &masks.bits, Usage::STORAGE);
    let view = target(gpu, width, height, per_pass).create_view(&Default::default());
    let module = gpu.shader(concat!(include_str!("mask.wgsl"), include_str!("depth_map.wgsl")));
    let raster = raster_pipeline(gpu, &module, per_pass);
    let reader = read_pipeline(gpu, &module, per_pass);

    let samples = per_pass * offsets.len() as u32;
    let mut depths = vec![0.0; width as usize * height as usize * samples as usize];
    for (pass_index, offset) in offsets.iter().enumerate() {
        let shift = [-2.0 * offset[0] / width as f32, 2.0 * offset[1] / height as f32, 0.0, 0.0];
        let shift = gpu.buffer_of("shift", &shift, Usage::UNIFORM);
        let bindings = bind(
            gpu,
            &raster.get_bind_group_layout(0),
            &[
                (0, shift.as_entire_binding()),
                (1, entries.as_entire_binding()),
                (2, bits.as_entire_binding()),
            ],
        );
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&raster);
        pass.set_bind_group(0, &bindings, &[]);
        for (corners, count) in &buffers {
            pass.set_vertex_buffer(0, corners.slice(..));
            pass.draw(0..*count, 0..1);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);

        let band_rows = (BINDING_BYTES / (u64::from(width * per_pass) * 4)).min(u64::from(height)) as u32;
        for first in (0..height).step_by(band_rows as usize) {
            let rows = band_rows.min(height - first);
            let band = read_rows(gpu, &reader, &view, [width, first, rows, per_pass])?;
            let texels = depths.chunks_exact_mut(samples as usize).skip(first as usize * width as usize);
            for (texel, values) in texels.zip(band.chunks_exact(per_pass as usize)) {
                texel[pass_index * per_pass as usize..][..per_pass as usize].copy_from_slice(values);
            }
        }
    }
    Ok(DepthMap { width, height, samples, depths })
}

/// A depth texture that shaders can read.
pub(super) fn target(gpu: &GraphicsDevice, width: u32, height: u32, samples: u32) -> wgpu::Texture {
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
    gpu.texture(FORMAT, (width, height), 1, samples, usage)
}

pub(super) fn upload(
    gpu: &GraphicsDevice,
    scene: &Scene,
    masks: &Masks,
    frame: &LightFrame,
) -> Vec<(wgpu::Buffer, u32)> {
    let corner = |index: u32, mask| {
        let vertex = &scene.vertices[index as usize];
        let [x, y, depth] = frame.project(vertex.position.map(f64::from));
        let across = 2.0 * x / f64::from(frame.width) - 1.0;
        let down = 2.0 * y / f64::from(frame.height) - 1.0;
        Corner { position: [across as f32, -down as f32, depth as f32], uv: vertex.uv, mask }
    };
    let chunks = scene.triangles.chunks(TRIANGLES_PER_BUFFER);
    let materials = scene.triangle_material.chunks(TRIANGLES_PER_BUFFER);
    let corners = chunks.zip(materials).map(|(triangles, materials)| {
        let corners = triangles.iter().zip(materials).flat_map(|(triangle, &material)| {
            triangle.map(|i| corner(i, masks.of_material[material as usize]))
        });
        let corners: Vec<Corner> = corners.collect();
        (gpu.buffer_of("corners", &corners, Usage::VERTEX), corners.len() as u32)
    });
    corners.collect()
}

pub(super) fn raster_pipeline(
    gpu: &GraphicsDevice,
    module: &wgpu::ShaderModule,
    samples: u32,
) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("depth map"),
        layout: None,
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Corner>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x2, 2 => Uint32],
            })],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("alpha_test"),
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn read_pipeline(gpu: &GraphicsDevice, module: &wgpu::ShaderModule, samples: u32) -> wgpu::ComputePipeline {
    gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("read depths"),
        layout: None,
        module,
        entry_point: Some(if samples == 1 { "read_single" } else { "read_multiple" }),
        compilation_options: Default::default(),
        cache: None,
    })
}

pub(super) fn bind(
    gpu: &GraphicsDevice,
    layout: &wgpu::BindGroupLayout,
    resources: &[(u32, wgpu::BindingResource<'_>)],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.clone() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// The depths of some rows; `rows` is width, first row, number of rows and samples a texel.
fn read_rows(
    gpu: &GraphicsDevice,
    reader: &wgpu::ComputePipeline,
    view: &wgpu::TextureView,
    rows: [u32; 4],
) -> Result<Vec<f32>, RenderError> {
    let [width, _, count, samples] = rows;
    let bytes = u64::from(width) * u64::from(count) * u64::from(samples) * 4;
    let depths = gpu.buffer("depths", bytes, Usage::STORAGE | Usage::COPY_SRC);
    let rows = gpu.buffer_of("rows", &rows, Usage::UNIFORM);
    let bindings = bind(
        gpu,
        &reader.get_bind_group_layout(0),
        &[
            (if samples == 1 { 3 } else { 4 }, wgpu::BindingResource::TextureView(view)),
            (5, depths.as_entire_binding()),
            (6, rows.as_entire_binding()),
        ],
    );
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(reader);
    pass.set_bind_group(0, &bindings, &[]);
    pass.dispatch_workgroups(width.div_ceil(8), count.div_ceil(8), 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    Ok(gpu.read(&depths, 0, bytes)?)
}
