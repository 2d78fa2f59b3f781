//! Tests that need a graphics adapter: without one they are reported as ignored, or fail if `MSM_REQUIRE_GPU` is 1.

use graphics_device::GraphicsDevice;
use libtest_mimic::{Failed, Trial};

/// A test that no missing adapter can turn into a pass.
pub fn gpu_trial(name: String, test: impl FnOnce() -> Result<(), Failed> + Send + 'static) -> Trial {
    match GraphicsDevice::shared() {
        Ok(_) => Trial::test(name, test),
        Err(error) if std::env::var("MSM_REQUIRE_GPU").is_ok_and(|v| v == "1") => {
            let message = format!("MSM_REQUIRE_GPU is 1 but there is no adapter: {error}");
            Trial::test(name, move || Err(message.into()))
        }
        Err(_) => Trial::test(name, || Err("needs a graphics adapter".into())).with_ignored_flag(true),
    }
}
