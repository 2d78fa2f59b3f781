//! Stencil routing, as in section 3.2 of the moment shadow mapping paper: in pass k the stencil test lets exactly the
//! k-th fragment of each texel through, in drawing order. Coverage and depth come from the driver's own rasteriser,
//! so this shares nothing with the renderer's shaders.

use libtest_mimic::Failed;
use scenes::*;
use shadow_renderer::*;
use wgpu::util::DeviceExt;

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
        let routed = route(&scene, &report.frame, layers + 1);
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
fn route(scene: &Scene, frame: &LightFrame, passes: u32) -> Vec<Vec<f32>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default())).unwrap();

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
    let vertices = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&corners),
        usage: wgpu::BufferUsages::VERTEX,
    });
    let texture = |format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
            view_formats: &[],
        })
    };
    let color = texture(wgpu::TextureFormat::R32Float, wgpu::TextureUsages::COPY_SRC);
    let stencil = texture(wgpu::TextureFormat::Stencil8, wgpu::TextureUsages::empty());
    let pipeline = pipeline(&device);
    let row_bytes = SIZE * 4; // a multiple of 256, as copies need
    let read_back = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row_bytes * SIZE),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let (color_view, stencil_view) =
        (color.create_view(&Default::default()), stencil.create_view(&Default::default()));
    (0..passes)
        .map(|k| {
            let mut encoder = device.create_command_encoder(&Default::default());
            {
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
            }
            encoder.copy_texture_to_buffer(
                color.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &read_back,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row_bytes),
                        rows_per_image: None,
                    },
                },
                wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
            );
            queue.submit([encoder.finish()]);
            read_back.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
            device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            let depths = bytemuck::pod_collect_to_vec(&read_back.get_mapped_range(..).unwrap());
            read_back.unmap();
            depths
        })
        .collect()
}

fn pipeline(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("stencil.wgsl"));
    // The stencil counts down to the fragment's turn. The fragment that passes sets it to 255, from where it counts
    // down again, too far from 0 to matter.
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Equal,
        fail_op: wgpu::StencilOperation::DecrementClamp,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: wgpu::StencilOperation::Invert,
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
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
