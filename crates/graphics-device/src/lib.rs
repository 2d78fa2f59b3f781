//! A graphics device: its adapter, buffers, textures, read-back and timestamps. It knows no shader and no pipeline.

mod adapter;
mod device;
mod error;
mod pass_timer;

pub use adapter::AdapterName;
pub use device::GraphicsDevice;
pub use error::DeviceError;
pub use pass_timer::PassTimer;
