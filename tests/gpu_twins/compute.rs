//! Runs a WGSL function over an array of inputs.

use graphics_device::{DeviceError, GraphicsDevice};
use wgpu::{BindingResource, BufferUsages, TextureFormat, TextureUsages};

const GROUP: u32 = 64;

/// A depth texture by its rows and width.
pub type Depths<'a> = (&'a [f32], u32);

/// `functions` define what `call` uses: statements that read `inputs[start + k]`, k < `inputs_each`, and write
/// `outputs[first + k]`, k < `outputs_each`; they may read a texture called `depths`, where one is given.
pub fn map(
    functions: &str,
    call: &str,
    (inputs, inputs_each): (&[f32], usize),
    outputs_each: usize,
    depths: Option<Depths<'_>>,
) -> Result<Vec<f32>, DeviceError> {
    let declared = depths.map_or("", |_| "@group(0) @binding(2) var depths: texture_2d<f32>;");
    let items = inputs.len() / inputs_each;
    let source = format!(
        "{functions}
{declared}
@group(0) @binding(0) var<storage, read> inputs: array<f32>;
@group(0) @binding(1) var<storage, read_write> outputs: array<f32>;
@compute @workgroup_size({GROUP})
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x >= {items}u {{ return; }}
    let start = id.x * {inputs_each}u;
    let first = id.x * {outputs_each}u;
    {call}
}}
"
    );
    let gpu = GraphicsDevice::shared()?;
    gpu.watched(|| {
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &gpu.shader(&source),
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let bytes = (items * outputs_each * 4) as u64;
        let input = gpu.buffer_of("inputs", inputs, BufferUsages::STORAGE);
        let output = gpu.buffer("outputs", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let texture = depths.map(|depths| texture(gpu, depths));
        let mut resources = vec![input.as_entire_binding(), output.as_entire_binding()];
        resources.extend(texture.iter().map(BindingResource::TextureView));
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((items as u32).div_ceil(GROUP), 1, 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        gpu.read(&output, 0, bytes)
    })
}

fn texture(gpu: &GraphicsDevice, (rows, width): Depths<'_>) -> wgpu::TextureView {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    let texture = gpu.texture(TextureFormat::R32Float, (width, rows.len() as u32 / width), 1, 1, usage);
    let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * width), ..Default::default() };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(rows), layout, texture.size());
    texture.create_view(&Default::default())
}
