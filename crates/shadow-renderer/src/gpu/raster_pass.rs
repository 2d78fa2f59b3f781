//! Passes of the raster pipeline. Entry points, bindings and vertex attributes are reflected from the shader's text; what it
//! reads is given by name.

use graphics_device::{DeviceError, GraphicsDevice};
use shaders::{Module, Stage, VertexInput};
use wgpu::{TextureView, VertexFormat};

use super::bind::{Resource, bind};

/// Corners of triangles in a vertex buffer, and how many.
pub(super) type Corners = (wgpu::Buffer, u32);

/// A depth target that is cleared first.
pub(super) struct Depth {
    pub view: TextureView,
    /// Passes what is nearer.
    pub compare: wgpu::CompareFunction,
    /// The farthest depth.
    pub clear: f32,
}

/// A pass over corners, or without any over one triangle that covers the targets. Targets are cleared to zero.
pub(super) struct RasterPass {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroup,
    corners: Vec<Corners>,
    colours: Vec<TextureView>,
    depth: Option<Depth>,
}

impl RasterPass {
    /// Compiles WGSL with one vertex and one fragment shader. Of the resources those are bound that it uses.
    pub(super) fn new(
        gpu: &GraphicsDevice,
        source: &str,
        resources: &[Resource<'_>],
        corners: Vec<Corners>,
        colours: Vec<TextureView>,
        depth: Option<Depth>,
    ) -> Result<Self, DeviceError> {
        let reflected = Module::new(source)?;
        let (vertex, fragment) = (reflected.only(Stage::Vertex)?, reflected.only(Stage::Fragment)?);
        let module = gpu.shader(source);
        let (attributes, stride) = attributes(&vertex.inputs);
        let layout = [Some(wgpu::VertexBufferLayout {
            array_stride: stride,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })];
        let targets: Vec<_> = colours.iter().map(|view| Some(view.texture().format().into())).collect();
        let samples = depth.iter().map(|depth| &depth.view).chain(&colours).next();
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(&fragment.name),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(&vertex.name),
                compilation_options: Default::default(),
                buffers: if corners.is_empty() { &[] } else { &layout },
            },
            primitive: Default::default(),
            depth_stencil: depth.as_ref().map(|depth| wgpu::DepthStencilState {
                format: depth.view.texture().format(),
                depth_write_enabled: Some(true),
                depth_compare: Some(depth.compare),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: samples.map_or(1, |view| view.texture().sample_count()),
                ..Default::default()
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(&fragment.name),
                compilation_options: Default::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        });
        let bindings = bind(gpu, &pipeline.get_bind_group_layout(0), &[vertex, fragment], resources)?;
        Ok(Self { pipeline, bindings, corners, colours, depth })
    }

    pub(super) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let colours: Vec<_> = self.colours.iter().map(cleared).collect();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &colours,
            depth_stencil_attachment: self.depth.as_ref().map(|depth| {
                wgpu::RenderPassDepthStencilAttachment {
                    view: &depth.view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(depth.clear),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }
            }),
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        for (corners, count) in &self.corners {
            pass.set_vertex_buffer(0, corners.slice(..));
            pass.draw(0..*count, 0..1);
        }
        if self.corners.is_empty() {
            pass.draw(0..3, 0..1);
        }
    }
}

fn cleared(view: &TextureView) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            store: wgpu::StoreOp::Store,
        },
    })
}

/// Attributes one after another without gaps, and their size in bytes.
pub(super) fn attributes(inputs: &[VertexInput]) -> (Vec<wgpu::VertexAttribute>, u64) {
    let mut offset = 0;
    let attributes = (0..).zip(inputs).map(|(shader_location, input)| {
        let format = match input {
            VertexInput::Float(1) => VertexFormat::Float32,
            VertexInput::Float(2) => VertexFormat::Float32x2,
            VertexInput::Float(3) => VertexFormat::Float32x3,
            VertexInput::Float(_) => VertexFormat::Float32x4,
            VertexInput::Unsigned(1) => VertexFormat::Uint32,
            VertexInput::Unsigned(2) => VertexFormat::Uint32x2,
            VertexInput::Unsigned(3) => VertexFormat::Uint32x3,
            VertexInput::Unsigned(_) => VertexFormat::Uint32x4,
        };
        let attribute = wgpu::VertexAttribute { format, offset, shader_location };
        offset += format.size();
        attribute
    });
    (attributes.collect(), offset)
}
