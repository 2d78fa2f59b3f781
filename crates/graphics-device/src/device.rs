//! A device with its queue: memory there and back, and errors as values.

use std::sync::{Arc, OnceLock};

use bytemuck::{NoUninit, Pod};
use wgpu::{BufferUsages, ErrorFilter, TextureFormat, TextureUsages};

use crate::DeviceError;
use crate::adapter::{self, AdapterName};

/// A device with a queue and the name of its adapter.
pub struct GraphicsDevice {
    /// What it runs on.
    pub adapter: wgpu::Adapter,
    /// Makes buffers, textures and pipelines.
    pub device: wgpu::Device,
    /// Takes work.
    pub queue: wgpu::Queue,
    /// The adapter's name.
    pub name: AdapterName,
    /// The adapter runs on the CPU: its times are no GPU times.
    pub software: bool,
    /// Why the device was lost, once it is.
    lost: Arc<OnceLock<String>>,
}

impl GraphicsDevice {
    /// The device of this process, opened on the first call without optional features, on the best adapter, a software
    /// one included.
    ///
    /// # Errors
    /// [`DeviceError::NoAdapter`] with the reason why there is none.
    pub fn shared() -> Result<&'static Self, DeviceError> {
        static SHARED: OnceLock<Result<GraphicsDevice, DeviceError>> = OnceLock::new();
        SHARED.get_or_init(|| Self::open(wgpu::Features::empty())).as_ref().map_err(Clone::clone)
    }

    /// Opens the best adapter, with those of the wanted features that it has. Limits are wgpu's default ones, 128 MiB for
    /// a storage binding, whatever the adapter offers.
    ///
    /// # Errors
    /// [`DeviceError::NoAdapter`] with the reason why there is none.
    pub fn open(wanted: wgpu::Features) -> Result<Self, DeviceError> {
        Self::with_limits(wanted, |_| wgpu::Limits::default())
    }

    /// The same with all limits of the adapter: the sizes of buffers, the number of storage bindings of a stage and so on.
    ///
    /// # Errors
    /// As [`GraphicsDevice::open`].
    pub fn open_whole(wanted: wgpu::Features) -> Result<Self, DeviceError> {
        Self::with_limits(wanted, wgpu::Adapter::limits)
    }

    fn with_limits(
        wanted: wgpu::Features,
        limits: impl FnOnce(&wgpu::Adapter) -> wgpu::Limits,
    ) -> Result<Self, DeviceError> {
        let adapter = adapter::best()?;
        let info = adapter.get_info();
        let software = info.device_type == wgpu::DeviceType::Cpu;
        let name = AdapterName::from(info);
        let descriptor = wgpu::DeviceDescriptor {
            required_features: adapter.features() & wanted,
            required_limits: limits(&adapter),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| DeviceError::NoAdapter(format!("{}: {e}", name.name)))?;
        let lost = Arc::new(OnceLock::new());
        let heard = lost.clone();
        device.set_device_lost_callback(move |reason, message| {
            // The first reason stays.
            let _ = heard.set(format!("{reason:?} {message}").trim().to_owned());
        });
        Ok(Self { adapter, device, queue, name, software, lost })
    }

    /// Does `work` with what the device reports meanwhile as an error; without this wgpu would end the process.
    ///
    /// # Errors
    /// [`DeviceError::Lost`] if the device is gone, else what it reported, else the error of `work`: the loss explains
    /// more than what was reported, and that more than what followed from it.
    pub fn watched<T, E: From<DeviceError>>(&self, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let scopes = [ErrorFilter::Internal, ErrorFilter::Validation, ErrorFilter::OutOfMemory]
            .map(|filter| self.device.push_error_scope(filter));
        let done = work();
        // Innermost first.
        let [internal, validation, memory] = scopes;
        let reported = [memory, validation, internal].map(|scope| pollster::block_on(scope.pop()));
        if let Some(reason) = self.lost.get() {
            return Err(DeviceError::Lost(reason.clone()).into());
        }
        // Lack of memory counts most, as it makes invalid buffers that fail later.
        match reported.into_iter().flatten().next() {
            None => done,
            Some(wgpu::Error::OutOfMemory { .. }) => Err(DeviceError::OutOfMemory.into()),
            Some(error) => Err(DeviceError::failed(error).into()),
        }
    }

    /// Gives the device up, as a driver that crashes does.
    pub fn lose(&self) {
        self.device.destroy();
        // Whatever this answers, the device is gone.
        let _ = self.wait();
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// [`DeviceError::Failed`] where that never happens.
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(|_| ()).map_err(DeviceError::failed)
    }

    /// An empty buffer of at least 16 bytes.
    pub fn buffer(&self, label: &str, size: u64, usage: BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size.max(16).next_multiple_of(4),
            usage,
            mapped_at_creation: false,
        })
    }

    /// A buffer with `contents`, zero-padded to at least 64 bytes.
    pub fn buffer_of<T: NoUninit>(&self, label: &str, contents: &[T], usage: BufferUsages) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        let buffer = self.buffer(label, (bytes.len() as u64).max(64), usage | BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// A texture of so many texels, mip levels and samples a texel.
    pub fn texture(
        &self,
        format: TextureFormat,
        (width, height): (u32, u32),
        levels: u32,
        samples: u32,
        usage: TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: levels,
            sample_count: samples,
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

    /// A module without the checks that keep indices in range and loops from running for ever: on some processors they take
    /// as long as the work itself.
    ///
    /// # Safety
    /// Every index must be in range and every loop must end, whatever the resources hold.
    pub unsafe fn shader_unchecked(&self, source: &str) -> wgpu::ShaderModule {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        let descriptor = wgpu::ShaderModuleDescriptor { label: None, source };
        let checks = wgpu::ShaderRuntimeChecks::unchecked();
        // SAFETY: the caller vouches for indices and loops.
        unsafe { self.device.create_shader_module_trusted(descriptor, checks) }
    }

    /// The values of level 0 of `texture`, which needs the usage `COPY_SRC`, row by row.
    ///
    /// # Errors
    /// [`DeviceError::Failed`] where the copy fails, [`DeviceError::Unsupported`] for a format of several planes.
    pub fn read_texture<T: Pod>(&self, texture: &wgpu::Texture) -> Result<Vec<T>, DeviceError> {
        let format = texture.format();
        let of_texel = format.block_copy_size(None);
        let row = texture.width()
            * of_texel.ok_or_else(|| DeviceError::Unsupported(format!("{format:?} cannot be read back")))?;
        // Copies need rows of a multiple of 256 bytes.
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(padded) * u64::from(texture.height());
        let buffer = self.buffer("texels", bytes, BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(padded), ..Default::default() };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            texture.size(),
        );
        self.queue.submit([encoder.finish()]);
        let all: Vec<u8> = self.read(&buffer, 0, bytes)?;
        let rows = all.chunks_exact(padded as usize).map(|line| &line[..row as usize]);
        Ok(bytemuck::pod_collect_to_vec(&rows.collect::<Vec<_>>().concat()))
    }

    /// `bytes` bytes of `source` from `offset` on, which needs the usage `COPY_SRC`, read back through a staging buffer.
    ///
    /// # Errors
    /// [`DeviceError::Failed`] where the copy fails.
    pub fn read<T: Pod>(
        &self,
        source: &wgpu::Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<Vec<T>, DeviceError> {
        if bytes == 0 {
            return Ok(Vec::new());
        }
        let staging = self.buffer("staging", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(source, offset, &staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
            // The receiver lives until the end of this function; if it is gone, nobody wants the answer.
            let _ = sender.send(result);
        });
        self.wait()?;
        receiver.recv().map_err(DeviceError::failed)?.map_err(DeviceError::failed)?;
        let view = staging.get_mapped_range(0..bytes).map_err(|e| DeviceError::Failed(format!("{e:?}")))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }
}
