//! Which adapter a device runs on.

use crate::DeviceError;

/// A graphics adapter, told apart from others by a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterName {
    /// Name of the device.
    pub name: String,
    /// Kind of device: `DiscreteGpu`, `IntegratedGpu`, `VirtualGpu`, `Cpu` (software) or `Other`.
    pub device_type: String,
    /// Driver with version, as far as it tells.
    pub driver: String,
    /// Graphics interface, for example `vulkan`.
    pub api: String,
}

impl std::fmt::Display for AdapterName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({}, {}, {})", self.name, self.device_type, self.api, self.driver)
    }
}

impl From<wgpu::AdapterInfo> for AdapterName {
    fn from(info: wgpu::AdapterInfo) -> Self {
        let driver = [info.driver, info.driver_info].map(|s| s.trim().to_owned()).join(" ");
        Self {
            name: info.name,
            device_type: format!("{:?}", info.device_type),
            driver: driver.trim().to_owned(),
            api: info.backend.to_str().to_owned(),
        }
    }
}

/// The fastest adapter there is; the environment may narrow the choice, for example `WGPU_BACKEND=vulkan`.
pub(crate) fn best() -> Result<wgpu::Adapter, DeviceError> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle().with_env();
    descriptor.backends &= wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        ..Default::default()
    };
    let adapter = wgpu::Instance::new(descriptor).request_adapter(&options);
    pollster::block_on(adapter).map_err(|e| DeviceError::NoAdapter(e.to_string()))
}
