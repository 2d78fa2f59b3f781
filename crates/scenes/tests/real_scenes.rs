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

/// What a test that is ignored says.
fn absent(missing: bool) -> &'static str {
    if missing { "needs public scenes, which are no part of the project" } else { "" }
}

fn main() -> ExitCode {
    let trials = SCENES.map(|(name, triangles, degenerate, masked)| {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/scenes").join(name);
        let missing = !path.is_file();
        Trial::test(format!("documented_triangles::{}", name.trim_end_matches(".glb")), move || {
            loads_with_the_documented_triangles(&path, triangles, degenerate, masked)
        })
        .with_kind(absent(missing))
        .with_kind(absent(missing))
        .with_ignored_flag(missing)
    });
    let mut trials: Vec<Trial> = trials.into();
    for (file, size, triangles) in CASES {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/cases").join(file);
        let missing = !path.is_file();
        trials.push(
            Trial::test(format!("case::{file}"), move || has_size(&path, size, triangles))
                .with_kind(absent(missing))
                .with_ignored_flag(missing),
        );
    }
    trials.push(every_file_of_a_folder());
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

/// File, size of what it shows, and its triangles without added ground.
const CASES: [(&str, [f64; 3], usize); 24] = [
    ("files/mannequiny.glb", [1.64, 1.80, 0.32], 13_832),
    ("files/player.glb", [1.68, 2.12, 0.64], 1_911),
    ("files/DenseSphere.glb", [1.85, 1.86, 1.85], 30_720),
    ("files/BoxMeshopt.glb", [1.0, 1.0, 1.0], 12),
    ("files/simple-instancing.glb", [14.40, 14.40, 14.40], 1_500),
    ("files/barycentric.gltf", [2.0, 2.0, 0.0], 2),
    ("public/a01_custom_attribute.gltf", [1.0, 1.0, 1.0], 12),
    ("public/a02_sparse_positions.gltf", [1.0, 2.0, 1.0], 12),
    ("public/a06_animation_target_without_node.gltf", [1.0, 1.0, 1.0], 12),
    ("public/a09_bom.gltf", [1.0, 1.0, 1.0], 12),
    ("public/a10_extras_string.gltf", [1.0, 1.0, 1.0], 12),
    ("public/a12_five_instances.gltf", [5.0, 1.0, 3.0], 60),
    ("public/a16_skinned_cm_lying.gltf", [2.80, 1.80, 1.0], 24),
    ("public/a17b_tower_at_origin.obj", [40.0, 6.0, 40.0], 72),
    ("public/a18_tower_at_map_coordinates.obj", [40.0, 6.0, 40.0], 72),
    ("public/a20_two_libraries.obj", [1.0, 1.0, 0.0], 1),
    ("public/a21_missing_library.obj", [1.0, 1.0, 0.0], 1),
    ("scenes/missing-texture.obj", [1.0, 1.0, 1.0], 12),
    ("scenes/two-mtllibs.obj", [1.0, 1.0, 1.0], 12),
    ("scenes/utf16.obj", [1.0, 1.0, 1.0], 12),
    ("scenes/quantized-positions.gltf", [1.0, 1.0, 1.0], 12),
    ("scenes/sparse-positions.gltf", [1.0, 2.0, 1.0], 12),
    ("scenes/skin-lifts-top.gltf", [1.0, 3.0, 1.0], 12),
    ("scenes/far-from-origin.gltf", [1.0, 1.0, 1.0], 12),
];

fn has_size(path: &std::path::Path, size: [f64; 3], triangles: usize) -> Result<(), Failed> {
    let scene = load_scene(&path.to_string_lossy())?;
    let found = [0, 1, 2].map(|k| scene.bounds[1][k] - scene.bounds[0][k]);
    assert!((0..3).all(|k| (found[k] - size[k]).abs() < 0.006), "{found:?}, expected {size:?}");
    let added = |&&material: &&u32| scene.materials[material as usize].name == "ground_added";
    let shown = scene.triangles.len() - scene.triangle_material.iter().filter(added).count();
    assert_eq!(shown + scene.degenerate_triangles, triangles);
    Ok(())
}

/// Prints a line for every scene file below the folder that `MSM_SCENES` names: what it holds, or its error of one line.
fn every_file_of_a_folder() -> Trial {
    let folder = std::env::var_os("MSM_SCENES").map(PathBuf::from);
    let missing = folder.is_none();
    Trial::test("folder", move || {
        let mut left = vec![folder.ok_or("no folder")?];
        let mut files = Vec::new();
        while let Some(path) = left.pop() {
            if path.is_dir() {
                left.extend(std::fs::read_dir(&path)?.filter_map(|entry| Some(entry.ok()?.path())));
            } else if path
                .extension()
                .is_some_and(|e| ["glb", "gltf", "obj"].iter().any(|known| e.eq_ignore_ascii_case(known)))
            {
                files.push(path);
            }
        }
        files.sort();
        for path in files {
            let start = Instant::now();
            let loaded = load_scene(&path.to_string_lossy());
            let seconds = start.elapsed().as_secs_f64();
            match loaded {
                Ok(scene) => {
                    let [x, y, z] = [0, 1, 2].map(|k| scene.bounds[1][k] - scene.bounds[0][k]);
                    let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
                    println!(
                        "{}\tloads\t{}\t{x:.4} x {y:.4} x {z:.4}\t{}\t{}\t{seconds:.2}\t{}",
                        path.display(),
                        scene.triangles.len(),
                        scene.animations.len(),
                        scene.materials.iter().filter(|m| m.texture.is_some()).count(),
                        warnings.join("; ")
                    );
                }
                Err(error) => {
                    let message = error.to_string();
                    assert!(!message.contains('\n'), "{message}");
                    println!("{}\trefused\t\t\t\t\t{seconds:.2}\t{message}", path.display());
                }
            }
        }
        Ok(())
    })
    .with_ignored_flag(missing)
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
