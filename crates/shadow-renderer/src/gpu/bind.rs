//! Resources by the names that shaders give them.

use graphics_device::{DeviceError, GraphicsDevice};
use shaders::{EntryPoint, ShaderError};

/// A resource and the name of the variable that it is bound to.
pub(super) type Resource<'a> = (&'a str, wgpu::BindingResource<'a>);

/// Binds what the entry points of a pipeline use; further resources are left out.
pub(super) fn bind(
    gpu: &GraphicsDevice,
    layout: &wgpu::BindGroupLayout,
    entry_points: &[&EntryPoint],
    resources: &[Resource<'_>],
) -> Result<wgpu::BindGroup, DeviceError> {
    let mut entries: Vec<wgpu::BindGroupEntry<'_>> = Vec::new();
    for binding in entry_points.iter().flat_map(|entry| &entry.bindings) {
        if entries.iter().any(|entry| entry.binding == binding.number) {
            continue;
        }
        let found = resources.iter().find(|(name, _)| *name == binding.name);
        let (_, resource) = found.ok_or_else(|| ShaderError::Unbound(binding.name.clone()))?;
        entries.push(wgpu::BindGroupEntry { binding: binding.number, resource: resource.clone() });
    }
    Ok(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries }))
}
