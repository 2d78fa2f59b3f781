//! Runs a WGSL function over an array of inputs.

use graphics_device::{DeviceError, GraphicsDevice};
use wgpu::{
    BindGroupLayoutEntry, BindingResource, BindingType, BufferBindingType, BufferUsages, ShaderStages,
    TextureFormat, TextureSampleType, TextureUsages, TextureViewDimension,
};

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
    let source = source(&format!("{functions}\n{declared}"), call, items, [inputs_each, outputs_each]);
    let mut resources =
        vec![Resource::Read(bytemuck::cast_slice(inputs)), Resource::Write(items * outputs_each * 4)];
    resources.extend(depths.map(Resource::Depths));
    run(&[(&source, "main", groups(items))], &resources, 1)
}

/// Workgroups for so many items.
pub fn groups(items: usize) -> u32 {
    (items as u32).div_ceil(GROUP)
}

/// The module of [`map`].
pub fn source(functions: &str, call: &str, items: usize, [inputs_each, outputs_each]: [usize; 2]) -> String {
    format!(
        "{functions}
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
    )
}

/// What a pass is given, in order of its bindings in group 0.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// `var<storage, read>`.
    Read(&'a [u8]),
    /// `var<storage, read_write>` of so many bytes.
    Write(usize),
    /// `var<uniform>`.
    Uniform(&'a [u8]),
    /// `texture_2d<f32>`.
    Depths(Depths<'a>),
}

/// Runs compute passes (module, entry point, number of groups) one after another, and reads one of the bindings.
pub fn run<T: bytemuck::Pod>(
    passes: &[(&str, &str, u32)],
    resources: &[Resource<'_>],
    read: usize,
) -> Result<Vec<T>, DeviceError> {
    let gpu = GraphicsDevice::shared()?;
    let passes: Vec<_> =
        passes.iter().map(|(source, entry, groups)| (gpu.shader(source), *entry, *groups)).collect();
    run_modules(gpu, &passes, resources, read)
}

/// The same for modules of a device.
pub fn run_modules<T: bytemuck::Pod>(
    gpu: &GraphicsDevice,
    passes: &[(wgpu::ShaderModule, &str, u32)],
    resources: &[Resource<'_>],
    read: usize,
) -> Result<Vec<T>, DeviceError> {
    let entry = |(binding, resource): (u32, &Resource<'_>)| {
        let buffer = |ty| BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let ty = match resource {
            Resource::Read(_) => buffer(BufferBindingType::Storage { read_only: true }),
            Resource::Write(_) => buffer(BufferBindingType::Storage { read_only: false }),
            Resource::Uniform(_) => buffer(BufferBindingType::Uniform),
            Resource::Depths(_) => BindingType::Texture {
                sample_type: TextureSampleType::Float { filterable: false },
                view_dimension: TextureViewDimension::D2,
                multisampled: false,
            },
        };
        BindGroupLayoutEntry { binding, visibility: ShaderStages::COMPUTE, ty, count: None }
    };
    let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
    gpu.watched(|| {
        let layout = gpu
            .device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries });
        let usage = BufferUsages::STORAGE;
        let buffer = |resource: &Resource<'_>| match *resource {
            Resource::Read(bytes) => Some(gpu.buffer_of("read", bytes, usage)),
            Resource::Write(bytes) => {
                Some(gpu.buffer("written", bytes as u64, usage | BufferUsages::COPY_SRC))
            }
            Resource::Uniform(bytes) => Some(gpu.buffer_of("uniform", bytes, BufferUsages::UNIFORM)),
            Resource::Depths(_) => None,
        };
        let buffers: Vec<_> = resources.iter().map(buffer).collect();
        let views: Vec<_> = resources
            .iter()
            .map(|resource| match *resource {
                Resource::Depths(depths) => Some(texture(gpu, depths)),
                Resource::Read(_) | Resource::Write(_) | Resource::Uniform(_) => None,
            })
            .collect();
        let bound = buffers.iter().zip(&views).zip(0..).filter_map(|((buffer, view), binding)| {
            let resource = match (buffer, view) {
                (Some(buffer), _) => buffer.as_entire_binding(),
                (None, view) => BindingResource::TextureView(view.as_ref()?),
            };
            Some(wgpu::BindGroupEntry { binding, resource })
        });
        let entries: Vec<_> = bound.collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &entries,
        });
        let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for (module, entry, groups) in passes {
            let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: None,
                layout: Some(&pipeline_layout),
                module,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            });
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(*groups, 1, 1);
        }
        gpu.queue.submit([encoder.finish()]);
        let Some(Some(output)) = buffers.get(read) else { return Ok(Vec::new()) };
        gpu.read(output, 0, output.size())
    })
}

fn texture(gpu: &GraphicsDevice, (rows, width): Depths<'_>) -> wgpu::TextureView {
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    let texture = gpu.texture(TextureFormat::R32Float, (width, rows.len() as u32 / width), 1, 1, usage);
    let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * width), ..Default::default() };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(rows), layout, texture.size());
    texture.create_view(&Default::default())
}
