//! The triangles of a scene on the GPU: the light's depth map and what the camera sees.

use bytemuck::{Pod, Zeroable};
use wgpu::{BufferUsages as Usage, TextureFormat as Format, TextureUsages as Uses};

use super::cover_pass::cleared;
use super::depth_map;
use crate::frame::raster::View;
use crate::stack::fixed_point::Masks;
use crate::{LightFrame, RenderError};
use graphics_device::GraphicsDevice;
use scenes::Scene;

/// Corners sent to the device in one piece.
const TRIANGLES_PER_BUFFER: usize = 1 << 19;

const DEPTH: Format = Format::Depth32Float;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Corner {
    position: [f32; 3],
    normal: [f32; 3],
    albedo: [f32; 3],
    uv: [f32; 2],
    mask: u32,
}

/// Uploaded triangles.
pub(super) struct Geometry {
    buffers: Vec<(wgpu::Buffer, u32)>,
    masks: Masks,
    entries: wgpu::Buffer,
    bits: wgpu::Buffer,
}

/// Textures with what the camera sees.
pub(super) struct Targets {
    pub width: u32,
    pub height: u32,
    /// Positions, normals, albedos.
    pub views: [wgpu::TextureView; 3],
    depth: wgpu::TextureView,
}

const TARGET_FORMATS: [Format; 3] = [Format::Rgba32Float, Format::Rgba16Float, Format::Rgba8Unorm];

impl Targets {
    pub fn new(gpu: &GraphicsDevice, width: u32, height: u32) -> Self {
        let view = |format: Format, more: Uses| {
            gpu.texture(format, (width, height), 1, 1, Uses::RENDER_ATTACHMENT | more)
                .create_view(&Default::default())
        };
        Self {
            width,
            height,
            views: TARGET_FORMATS.map(|format| view(format, Uses::TEXTURE_BINDING)),
            depth: view(DEPTH, Uses::empty()),
        }
    }
}

/// A pass that draws all triangles.
pub(super) struct TrianglePass {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroup,
    buffers: Vec<(wgpu::Buffer, u32)>,
    colours: Vec<wgpu::TextureView>,
    /// The depth target.
    pub view: wgpu::TextureView,
    clear_depth: f32,
}

impl Geometry {
    pub fn upload(gpu: &GraphicsDevice, scene: &Scene) -> Result<Self, RenderError> {
        let masks = Masks::new(scene)?;
        let chunks = scene.triangles.chunks(TRIANGLES_PER_BUFFER);
        let materials = scene.triangle_material.chunks(TRIANGLES_PER_BUFFER);
        let buffers = chunks.zip(materials).map(|(triangles, materials)| {
            let corners: Vec<Corner> = triangles
                .iter()
                .zip(materials)
                .flat_map(|(triangle, &material)| triangle.map(|i| corner(scene, &masks, i, material)))
                .collect();
            (gpu.buffer_of("corners", &corners, Usage::VERTEX), corners.len() as u32)
        });
        let buffers = buffers.collect();
        let entries: Vec<[u32; 3]> = masks.entries.iter().map(|e| [e.width, e.height, e.first_bit]).collect();
        let entries = gpu.buffer_of("masks", &entries, Usage::STORAGE);
        let bits = gpu.buffer_of("mask bits", &masks.bits, Usage::STORAGE);
        Ok(Self { buffers, masks, entries, bits })
    }

    /// The light's depth map with so many samples.
    pub fn shadow_map(
        &self,
        gpu: &GraphicsDevice,
        scene: &Scene,
        light: &LightFrame,
        samples: u32,
    ) -> Result<TrianglePass, RenderError> {
        let module = gpu.shader(concat!(include_str!("mask.wgsl"), include_str!("depth_map.wgsl")));
        let pipeline = depth_map::raster_pipeline(gpu, &module, samples);
        let shift = gpu.buffer_of("shift", &[0.0f32; 4], Usage::UNIFORM);
        let bindings = self.bind(gpu, &pipeline, &shift);
        let view =
            depth_map::target(gpu, light.width, light.height, samples).create_view(&Default::default());
        let buffers = depth_map::upload(gpu, scene, &self.masks, light);
        Ok(TrianglePass { pipeline, bindings, buffers, colours: Vec::new(), view, clear_depth: 1.0 })
    }

    /// What the camera sees.
    pub fn surfaces(
        &self,
        gpu: &GraphicsDevice,
        scene: &Scene,
        targets: &Targets,
    ) -> Result<TrianglePass, RenderError> {
        let view = View::new(&scene.camera, targets.width, targets.height)?;
        let camera = gpu.buffer_of("camera", &view.clip_rows(), Usage::UNIFORM);
        let module = gpu.shader(concat!(include_str!("mask.wgsl"), include_str!("surfaces.wgsl")));
        let states = TARGET_FORMATS.map(|format| {
            Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
        });
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("surfaces"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: size_of::<Corner>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![
                        0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x2, 4 => Uint32
                    ],
                })],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                // Depth is reversed: 1 at the near plane, 0 at infinity.
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("surface"),
                compilation_options: Default::default(),
                targets: &states,
            }),
            multiview_mask: None,
            cache: None,
        });
        let bindings = self.bind(gpu, &pipeline, &camera);
        Ok(TrianglePass {
            pipeline,
            bindings,
            buffers: self.buffers.clone(),
            colours: targets.views.to_vec(),
            view: targets.depth.clone(),
            clear_depth: 0.0,
        })
    }

    fn bind(
        &self,
        gpu: &GraphicsDevice,
        pipeline: &wgpu::RenderPipeline,
        first: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        depth_map::bind(
            gpu,
            &pipeline.get_bind_group_layout(0),
            &[
                (0, first.as_entire_binding()),
                (1, self.entries.as_entire_binding()),
                (2, self.bits.as_entire_binding()),
            ],
        )
    }
}

fn corner(scene: &Scene, masks: &Masks, index: u32, material: u32) -> Corner {
    let vertex = &scene.vertices[index as usize];
    let of = &scene.materials[material as usize];
    Corner {
        position: vertex.position,
        normal: vertex.normal,
        albedo: of.albedo,
        uv: vertex.uv,
        mask: masks.of_material[material as usize],
    }
}

impl TrianglePass {
    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let colours = cleared(&self.colours);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &colours,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(self.clear_depth),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        for (corners, count) in &self.buffers {
            pass.set_vertex_buffer(0, corners.slice(..));
            pass.draw(0..*count, 0..1);
        }
    }
}
