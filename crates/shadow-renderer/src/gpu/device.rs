//! One graphics device per process, its name, and errors as values.

use std::sync::OnceLock;

use crate::{AdapterName, RenderError};

/// A device with a queue and the name of its adapter.
pub(crate) struct Gpu {
    pub adapter: wgpu::Adapter,
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub name: AdapterName,
    /// The adapter runs on the CPU.
    pub software: bool,
    pub pipelines: super::abuffer::Pipelines,
}

/// The device of the best adapter, found on the first call, or why there is none.
pub(crate) fn gpu() -> Result<&'static Gpu, &'static str> {
    static GPU: OnceLock<Result<Gpu, String>> = OnceLock::new();
    GPU.get_or_init(|| open(wgpu::Features::empty())).as_ref().map_err(String::as_str)
}

/// Opens the best adapter, with those of the wanted features that it has.
pub(crate) fn open(wanted: wgpu::Features) -> Result<Gpu, String> {
    // The environment may narrow the choice, for example WGPU_BACKEND=vulkan.
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle().with_env();
    descriptor.backends &= wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let instance = wgpu::Instance::new(descriptor);
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..Default::default()
    };
    let adapter =
        pollster::block_on(instance.request_adapter(&options)).map_err(|e| format!("no adapter: {e}"))?;
    let info = adapter.get_info();
    // The default limits (128 MiB a binding) are what the chunk sizes are made for.
    let descriptor =
        wgpu::DeviceDescriptor { required_features: adapter.features() & wanted, ..Default::default() };
    let (device, queue) =
        pollster::block_on(adapter.request_device(&descriptor)).map_err(|e| format!("{}: {e}", info.name))?;
    let driver = [info.driver, info.driver_info].map(|s| s.trim().to_owned()).join(" ");
    let name = AdapterName {
        name: info.name,
        device_type: format!("{:?}", info.device_type),
        driver: driver.trim().to_owned(),
        api: info.backend.to_str().to_owned(),
    };
    let scopes = Scopes::open(&device);
    let pipelines = super::abuffer::Pipelines::new(&device);
    scopes.close().map_err(|e| e.to_string())?;
    Ok(Gpu { adapter, device, queue, name, software: info.device_type == wgpu::DeviceType::Cpu, pipelines })
}

/// Catches what the device reports while open; without it wgpu would end the process.
pub(crate) struct Scopes([wgpu::ErrorScopeGuard; 3]);

impl Scopes {
    pub fn open(device: &wgpu::Device) -> Self {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        Self([Internal, Validation, OutOfMemory].map(|filter| device.push_error_scope(filter)))
    }

    /// The most telling error since opening: lack of memory first, as it makes invalid buffers that fail later.
    pub fn close(self) -> Result<(), RenderError> {
        let [internal, validation, memory] = self.0;
        let errors = [memory, validation, internal].map(|scope| pollster::block_on(scope.pop()));
        match errors.into_iter().flatten().next() {
            None => Ok(()),
            Some(wgpu::Error::OutOfMemory { .. }) => Err(RenderError::Gpu("out of graphics memory".into())),
            Some(error) => Err(RenderError::Gpu(error.to_string())),
        }
    }
}

impl Gpu {
    /// Waits until all submitted work is done.
    pub fn wait(&self) -> Result<(), RenderError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map(|_| ())
            .map_err(|e| RenderError::Gpu(e.to_string()))
    }

    /// An empty buffer of at least 16 bytes.
    pub fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let size = size.max(16).next_multiple_of(4);
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// A texture.
    pub fn texture(
        &self,
        format: wgpu::TextureFormat,
        (width, height): (u32, u32),
        levels: u32,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }

    /// A module from WGSL.
    pub fn shader(&self, source: &str) -> wgpu::ShaderModule {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source })
    }

    /// Level 0 of a texture with texels of so many bytes, row by row.
    pub fn read_texture(&self, texture: &wgpu::Texture, texel_bytes: u32) -> Result<Vec<u8>, RenderError> {
        let (width, height) = (texture.width(), texture.height());
        let row = width * texel_bytes;
        // Copies need rows of a multiple of 256 bytes.
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(padded) * u64::from(height);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer = self.buffer("texels", bytes, usage);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        let all: Vec<u8> = self.read(&buffer, 0, bytes)?;
        Ok(all.chunks_exact(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect())
    }

    /// A buffer with `contents`, zero-padded to at least 64 bytes.
    pub fn buffer_of<T: bytemuck::NoUninit>(
        &self,
        label: &str,
        contents: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        let buffer = self.buffer(label, (bytes.len() as u64).max(64), usage | wgpu::BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// The first `bytes` bytes of `source`, which needs the usage `COPY_SRC`, read back through a staging buffer.
    pub fn read<T: bytemuck::Pod>(
        &self,
        source: &wgpu::Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<Vec<T>, RenderError> {
        if bytes == 0 {
            return Ok(Vec::new());
        }
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.buffer("staging", bytes, usage);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(source, offset, &staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
            // The receiver lives until the end of this function; if it is gone, nobody wants the answer.
            let _ = sender.send(result);
        });
        self.wait()?;
        let mapped = receiver.recv().map_err(|e| RenderError::Gpu(e.to_string()))?;
        mapped.map_err(|e| RenderError::Gpu(e.to_string()))?;
        let view = staging.get_mapped_range(0..bytes).map_err(|e| RenderError::Gpu(format!("{e:?}")))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }
}
