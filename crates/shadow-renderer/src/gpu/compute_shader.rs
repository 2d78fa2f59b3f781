//! Compute shaders, bound by name like the passes of the raster pipeline.

use graphics_device::{DeviceError, GraphicsDevice};
use shaders::{EntryPoint, Module, Stage};

use super::bind::{Resource, bind};

/// A compute shader, compiled.
pub(crate) struct ComputeShader {
    pipeline: wgpu::ComputePipeline,
    entry_point: EntryPoint,
}

impl ComputeShader {
    /// Compiles one entry point of a WGSL module.
    pub(super) fn new(gpu: &GraphicsDevice, source: &str, name: &str) -> Result<Self, DeviceError> {
        let entry_point = Module::new(source)?.entry_point(name)?.clone();
        Ok(Self::of(gpu, &gpu.shader(source), entry_point))
    }

    /// Compiles the only compute shader of a module.
    pub(super) fn only(gpu: &GraphicsDevice, source: &str) -> Result<Self, DeviceError> {
        let entry_point = Module::new(source)?.only(Stage::Compute)?.clone();
        Ok(Self::of(gpu, &gpu.shader(source), entry_point))
    }

    /// The same without run-time checks.
    ///
    /// # Safety
    /// As for [`GraphicsDevice::shader_unchecked`].
    pub(super) unsafe fn only_unchecked(gpu: &GraphicsDevice, source: &str) -> Result<Self, DeviceError> {
        let entry_point = Module::new(source)?.only(Stage::Compute)?.clone();
        // SAFETY: the caller vouches for it.
        let module = unsafe { gpu.shader_unchecked(source) };
        Ok(Self::of(gpu, &module, entry_point))
    }

    fn of(gpu: &GraphicsDevice, module: &wgpu::ShaderModule, entry_point: EntryPoint) -> Self {
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&entry_point.name),
            layout: None,
            module,
            entry_point: Some(&entry_point.name),
            compilation_options: Default::default(),
            cache: None,
        });
        Self { pipeline, entry_point }
    }

    /// Workgroups along x and y for so many threads.
    pub(super) fn groups_of(&self, threads: [u32; 2]) -> [u32; 2] {
        let [x, y, _] = self.entry_point.workgroup_size;
        [threads[0].div_ceil(x), threads[1].div_ceil(y)]
    }

    /// Runs so many workgroups.
    pub(super) fn dispatch(
        &self,
        gpu: &GraphicsDevice,
        encoder: &mut wgpu::CommandEncoder,
        resources: &[Resource<'_>],
        groups: [u32; 2],
    ) -> Result<(), DeviceError> {
        self.run(encoder, &self.bound(gpu, resources)?, groups, None);
        Ok(())
    }

    /// What the shader uses of some resources.
    pub(super) fn bound(
        &self,
        gpu: &GraphicsDevice,
        resources: &[Resource<'_>],
    ) -> Result<wgpu::BindGroup, DeviceError> {
        bind(gpu, &self.pipeline.get_bind_group_layout(0), &[&self.entry_point], resources)
    }

    /// Runs so many workgroups on bound resources.
    pub(super) fn run(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bound: &wgpu::BindGroup,
        [x, y]: [u32; 2],
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bound, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}
