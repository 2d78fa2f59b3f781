//! Any bytes, read as a Wavefront OBJ, become a scene or an error.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(scene) = scenes::load_obj_bytes("fuzz.obj", bytes) {
        assert!(scene.triangles.iter().flatten().all(|&i| (i as usize) < scene.vertices.len()));
        assert!(scene.vertices.iter().all(|v| v.position.iter().chain(&v.normal).all(|c| c.is_finite())));
    }
});
