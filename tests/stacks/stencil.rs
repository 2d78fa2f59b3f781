//! Stencil routing, as in section 3.2 of the moment shadow mapping paper: in pass k the stencil test lets exactly the
//! k-th fragment of each texel through, in drawing order. Coverage and depth come from the driver's own rasteriser,
//! so this shares nothing with the renderer's shaders.

use graphics_device::{DeviceError, GraphicsDevice};
use libtest_mimic::Failed;
use scenes::*;
use shadow_renderer::*;

use crate::scenes::{Random, SLANTED, jittered_plane, scene_of, soup};

/// A power of two, so that corners snapped to 1/256 texel are exact in normalised device coordinates.
const SIZE: u32 = 128;

pub fn agrees_with_the_stack() -> Result<(), Failed> {
    let random = &mut Random(99);
    for corners in [soup(600, random), jittered_plane(30, random)] {
        let scene = scene_of(&corners);
        let (stack, report) = render_stack(&scene, SLANTED, SIZE, SIZE, Backend::Cpu)?;
        let layers = stack.layer_statistics().max;
        assert!((1..200).contains(&layers), "{layers} layers");
        // One pass more than there are layers: it must come back empty.
        let routed = route(&scene, &report.frame, layers + 1)?;
        for texel in 0..(SIZE * SIZE) as usize {
            let mut found: Vec<f32> = routed.iter().map(|pass| pass[texel]).filter(|d| *d >= 0.0).collect();
            found.sort_by(f32::total_cmp);
            let (x, y) = (texel as u32 % SIZE, texel as u32 / SIZE);
            let expected: Vec<_> = stack.layers(x, y).collect();
            assert_eq!(found.len(), expected.len(), "texel ({x}, {y})");
            for (d, e) in found.iter().zip(&expected) {
                // The driver interpolates over snapped corners, at the precision it likes.
                let steepest = expected.iter().flat_map(|e| e.gradient).fold(0.0f32, |m, g| m.max(g.abs()));
                assert!(
                    (d - e.depth).abs() < 1e-5 + 0.01 * steepest,
                    "texel ({x}, {y}): {d} instead of {}",
                    e.depth
                );
            }
        }
    }
    Ok(())
}

/// For each pass the depth at every texel, or -1.
fn route(scene: &Scene, frame: &LightFrame, passes: u32) -> Result<Vec<Vec<f32>>, DeviceError> {
    let gpu = GraphicsDevice::shared()?;
    let corners: Vec<[f32; 3]> = scene
        .triangles
        .iter()
        .flatten()
        .map(|&i| {
            let [x, y, depth] = frame.project(scene.vertices[i as usize].position.map(f64::from));
            let half = f64::from(SIZE) / 2.0;
            let device = |t: f64| (t * 256.0 + 0.5).floor() / 256.0 / half - 1.0;
            [device(x) as f32, -device(y) as f32, depth as f32]
        })
        .collect();
    let vertices = gpu.buffer_of("corners", &corners, wgpu::BufferUsages::VERTEX);
    let target = |format, usage| {
        gpu.texture(format, (SIZE, SIZE), 1, 1, wgpu::TextureUsages::RENDER_ATTACHMENT | usage)
    };
    let color = target(wgpu::TextureFormat::R32Float, wgpu::TextureUsages::COPY_SRC);
    let stencil = target(wgpu::TextureFormat::Stencil8, wgpu::TextureUsages::empty());
    let (color_view, stencil_view) =
        (color.create_view(&Default::default()), stencil.create_view(&Default::default()));
    let pipeline = pipeline(gpu);
    (0..passes)
        .map(|k| {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &color_view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color { r: -1.0, ..wgpu::Color::BLACK }),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &stencil_view,
                    depth_ops: None,
                    stencil_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(k),
                        store: wgpu::StoreOp::Store,
                    }),
                }),
                ..Default::default()
            });
            pass.set_pipeline(&pipeline);
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.set_stencil_reference(0);
            pass.draw(0..corners.len() as u32, 0..1);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            gpu.read_texture(&color)
        })
        .collect()
}

fn pipeline(gpu: &GraphicsDevice) -> wgpu::RenderPipeline {
    let module = gpu.shader(include_str!("stencil.wgsl"));
    // The stencil counts down to the fragment's turn. The fragment that passes sets it to 255, from where it counts
    // down again, too far from 0 to matter.
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Equal,
        fail_op: wgpu::StencilOperation::DecrementClamp,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: wgpu::StencilOperation::Invert,
    };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("corner"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32],
            })],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Stencil8,
            depth_write_enabled: None,
            depth_compare: None,
            stencil: wgpu::StencilState { front: face, back: face, read_mask: 0xff, write_mask: 0xff },
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: Default::default(),
            targets: &[Some(wgpu::TextureFormat::R32Float.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
