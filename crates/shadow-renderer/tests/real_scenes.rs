//! The public scenes, where they are present beside the project.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests fail by panicking and may report")]

use std::path::PathBuf;
use std::time::Instant;

use shadow_renderer::{Scene, load_scene};

/// The path of a public scene; `None`, said aloud, where it is not there.
fn present(name: &str) -> Option<String> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
    if path.is_file() {
        return Some(path.to_string_lossy().into_owned());
    }
    println!("skipped: {} is not here", path.display());
    None
}

fn load(name: &str) -> Option<Scene> {
    let path = present(name)?;
    let start = Instant::now();
    let scene = load_scene(&path).unwrap();
    println!(
        "{name}: {} triangles, {} degenerate, {} materials, {:.1} ms",
        scene.triangles.len(),
        scene.degenerate_triangles,
        scene.materials.len(),
        start.elapsed().as_secs_f64() * 1e3
    );
    Some(scene)
}

#[test]
fn public_scenes_load_with_the_documented_triangles() {
    for (name, triangles, degenerate, masked) in [
        ("kaykit_village.glb", 304_633, 0, false),
        ("dx_shadow_columns.glb", 16_646, 0, false),
        ("eztree_grove.glb", 238_862, 24, true),
        ("stanford_dragon_res2.glb", 202_522, 0, false),
        ("dx_squid_robot.glb", 28_016, 0, false),
    ] {
        let Some(scene) = load(name) else { continue };
        assert_eq!(scene.triangles.len() + scene.degenerate_triangles, triangles, "{name}");
        assert_eq!(scene.degenerate_triangles, degenerate, "{name}");
        assert_eq!(scene.materials.iter().any(|m| m.mask.is_some()), masked, "{name}");
        for vertex in &scene.vertices {
            let length: f32 = vertex.normal.iter().map(|c| c * c).sum();
            assert!((length - 1.0).abs() < 1e-5, "{name}: {:?}", vertex.normal);
        }
    }
}
