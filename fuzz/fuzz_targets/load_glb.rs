//! Any bytes, read as a binary or textual glTF, become a scene or an error.
//!
//! `cargo +nightly fuzz run load_glb`, or on a stable toolchain with `RUSTC_BOOTSTRAP=1` and
//! `--sanitizer none`. The files of `crates/scenes/tests` and small ones with skins, morph targets, instances and compressed
//! views are good to begin with.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(scene) = scenes::load_gltf_bytes("fuzz.glb", bytes) {
        assert!(scene.triangles.iter().flatten().all(|&i| (i as usize) < scene.vertices.len()));
        assert!(scene.vertices.iter().all(|v| v.position.iter().chain(&v.normal).all(|c| c.is_finite())));
        assert!(scene.colors.is_empty() || scene.colors.len() == scene.vertices.len());
        assert!(scene.triangle_material.iter().all(|&m| (m as usize) < scene.materials.len()));
    }
});
