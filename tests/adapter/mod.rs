//! Tests that need a graphics adapter: without one they are reported as ignored, or fail if `MSM_REQUIRE_GPU` is 1.

use graphics_device::GraphicsDevice;
use libtest_mimic::{Failed, Trial};

/// A test that no missing adapter can turn into a pass.
pub fn gpu_trial(name: String, test: impl FnOnce() -> Result<(), Failed> + Send + 'static) -> Trial {
    trial(name, GraphicsDevice::shared().map(|_| ()).map_err(|error| error.to_string()), test)
}

/// The same for a test that needs timestamps, too.
#[allow(dead_code, reason = "not every test binary times")]
pub fn timed_trial(name: String, test: impl FnOnce() -> Result<(), Failed> + Send + 'static) -> Trial {
    let timestamps = GraphicsDevice::shared().map_err(|error| error.to_string()).and_then(|gpu| {
        let offered = gpu.adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        if offered { Ok(()) } else { Err(format!("{} has no timestamps", gpu.name)) }
    });
    trial(name, timestamps, test)
}

/// The same for a test that needs double precision.
#[allow(dead_code, reason = "not every test binary computes in double precision")]
pub fn double_trial(name: String, test: impl FnOnce() -> Result<(), Failed> + Send + 'static) -> Trial {
    let doubles = GraphicsDevice::shared().map_err(|error| error.to_string()).and_then(|gpu| {
        let offered = gpu.adapter.features().contains(wgpu::Features::SHADER_F64);
        if offered { Ok(()) } else { Err(format!("{} has no double precision", gpu.name)) }
    });
    trial(name, doubles, test)
}

fn trial(
    name: String,
    available: Result<(), String>,
    test: impl FnOnce() -> Result<(), Failed> + Send + 'static,
) -> Trial {
    match available {
        Ok(()) => Trial::test(name, test),
        Err(missing) => ignored(name, format!("needs a graphics adapter: {missing}")),
    }
}

/// A test that cannot run here, and why.
pub fn ignored(name: String, reason: String) -> Trial {
    let required = std::env::var("MSM_REQUIRE_GPU").is_ok_and(|v| v == "1");
    let kind = reason.clone();
    Trial::test(name, move || Err(reason.into())).with_kind(kind).with_ignored_flag(!required)
}
