//! Passes whose one triangle covers their targets.

use wgpu::TextureFormat as Format;

use super::depth_map;
use graphics_device::GraphicsDevice;

/// A pass that covers its targets.
pub(super) struct CoverPass {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroup,
    targets: Vec<wgpu::TextureView>,
}

impl CoverPass {
    pub fn new(
        gpu: &GraphicsDevice,
        module: &wgpu::ShaderModule,
        entry: &str,
        resources: &[(u32, wgpu::BindingResource<'_>)],
        targets: &[(Format, wgpu::TextureView)],
    ) -> Self {
        let states: Vec<_> = targets
            .iter()
            .map(|&(format, _)| {
                Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
            })
            .collect();
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(entry),
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("cover"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                targets: &states,
            }),
            multiview_mask: None,
            cache: None,
        });
        let bindings = depth_map::bind(gpu, &pipeline.get_bind_group_layout(0), resources);
        Self { pipeline, bindings, targets: targets.iter().map(|(_, view)| view.clone()).collect() }
    }

    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let attachments = cleared(&self.targets);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &attachments,
            timestamp_writes,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// Colour attachments that are cleared to zero and kept.
pub(super) fn cleared(views: &[wgpu::TextureView]) -> Vec<Option<wgpu::RenderPassColorAttachment<'_>>> {
    let attachment = |view| {
        Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            },
        })
    };
    views.iter().map(attachment).collect()
}
