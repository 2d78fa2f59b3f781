//! Runs a WGSL function over an array of inputs.

use std::sync::OnceLock;

use wgpu::util::DeviceExt;

/// A device of its own: tests share nothing with the renderer but the adapter.
pub struct Device {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

const GROUP: u32 = 64;

impl Device {
    /// The device of this process.
    pub fn shared() -> Result<&'static Self, String> {
        static DEVICE: OnceLock<Result<Device, String>> = OnceLock::new();
        DEVICE.get_or_init(Self::open).as_ref().map_err(Clone::clone)
    }

    fn open() -> Result<Self, String> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle().with_env());
        let adapter =
            pollster::block_on(instance.request_adapter(&Default::default())).map_err(|e| e.to_string())?;
        let (device, queue) =
            pollster::block_on(adapter.request_device(&Default::default())).map_err(|e| e.to_string())?;
        Ok(Self { device, queue })
    }

    /// `functions` define what `call` uses: statements that read `inputs[start + k]`, k < `inputs_each`, and write
    /// `outputs[first + k]`, k < `outputs_each`.
    pub fn map(
        &self,
        functions: &str,
        call: &str,
        (inputs, inputs_each): (&[f32], usize),
        outputs_each: usize,
    ) -> Result<Vec<f32>, String> {
        self.map_with_depths(functions, call, (inputs, inputs_each), outputs_each, None)
    }

    /// The same with a depth texture called `depths`, given by its rows and width.
    pub fn map_with_depths(
        &self,
        functions: &str,
        call: &str,
        (inputs, inputs_each): (&[f32], usize),
        outputs_each: usize,
        depths: Option<(&[f32], u32)>,
    ) -> Result<Vec<f32>, String> {
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
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(error.to_string());
        }
        let input = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(inputs),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let bytes = (items * outputs_each * 4) as u64;
        let buffer = |usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: bytes,
                usage,
                mapped_at_creation: false,
            })
        };
        let output = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let staging = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let texture = depths.map(|(rows, width)| self.texture(rows, width));
        let mut entries = vec![
            wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
        ];
        if let Some(view) = &texture {
            let resource = wgpu::BindingResource::TextureView(view);
            entries.push(wgpu::BindGroupEntry { binding: 2, resource });
        }
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((items as u32).div_ceil(GROUP), 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&output, 0, &staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| sender.send(result).unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| e.to_string())?;
        receiver.recv().map_err(|e| e.to_string())?.map_err(|e| e.to_string())?;
        let view = staging.get_mapped_range(..).map_err(|e| format!("{e:?}"))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }

    fn texture(&self, rows: &[f32], width: u32) -> wgpu::TextureView {
        let size = wgpu::Extent3d { width, height: rows.len() as u32 / width, depth_or_array_layers: 1 };
        let texture = self.device.create_texture_with_data(
            &self.queue,
            &wgpu::TextureDescriptor {
                label: None,
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::R32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            Default::default(),
            bytemuck::cast_slice(rows),
        );
        texture.create_view(&Default::default())
    }
}
