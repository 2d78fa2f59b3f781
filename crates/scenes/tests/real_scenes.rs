//! The public scenes beside the project; those that are not there are reported as ignored.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests fail by panicking and may report")]

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use libtest_mimic::{Arguments, Failed, Trial};
use scenes::load_scene;

/// Name of the file, triangles, those of them without area, whether there are alpha masks.
const SCENES: [(&str, usize, usize, bool); 5] = [
    ("kaykit_village.glb", 304_633, 0, false),
    ("dx_shadow_columns.glb", 16_646, 0, false),
    ("eztree_grove.glb", 238_862, 24, true),
    ("stanford_dragon_res2.glb", 202_522, 0, false),
    ("dx_squid_robot.glb", 28_016, 0, false),
];

fn main() -> ExitCode {
    let trials = SCENES.map(|(name, triangles, degenerate, masked)| {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
        let missing = !path.is_file();
        Trial::test(format!("documented_triangles::{}", name.trim_end_matches(".glb")), move || {
            loads_with_the_documented_triangles(&path, triangles, degenerate, masked)
        })
        .with_ignored_flag(missing)
    });
    libtest_mimic::run(&Arguments::from_args(), trials.into()).exit_code()
}

fn loads_with_the_documented_triangles(
    path: &std::path::Path,
    triangles: usize,
    degenerate: usize,
    masked: bool,
) -> Result<(), Failed> {
    let start = Instant::now();
    let scene = load_scene(&path.to_string_lossy())?;
    println!("{} materials, {:.1} ms", scene.materials.len(), start.elapsed().as_secs_f64() * 1e3);
    assert_eq!(scene.triangles.len() + scene.degenerate_triangles, triangles);
    assert_eq!(scene.degenerate_triangles, degenerate);
    assert_eq!(scene.materials.iter().any(|m| m.mask.is_some()), masked);
    for vertex in &scene.vertices {
        let length: f32 = vertex.normal.iter().map(|c| c * c).sum();
        // Zero stands for that of the triangle.
        assert!(length == 0.0 || (length - 1.0).abs() < 1e-5, "{:?}", vertex.normal);
    }
    Ok(())
}
