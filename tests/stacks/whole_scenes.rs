//! GPU against CPU on whole scenes: every procedural view, and the public scenes where they are present.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use libtest_mimic::{Failed, Trial};
use scenes::*;
use shadow_renderer::*;

use crate::compare::compare;
use crate::gpu_trial;

const SIZE: u32 = 512;

/// Public scenes and the light directions in which they are compared.
const PUBLIC: [(&str, &[[f32; 3]]); 5] = [
    ("kaykit_village.glb", &[[0.8, -0.6, 0.35], [0.95, -0.25, 0.2]]),
    ("eztree_grove.glb", &[[0.3, -1.0, 0.2]]),
    ("dx_squid_robot.glb", &[[0.5, -0.7, 0.4]]),
    ("dx_shadow_columns.glb", &[[0.9, -0.4, 0.1]]),
    ("stanford_dragon_res2.glb", &[[0.4, -0.8, 0.4]]),
];

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for name in procedural::NAMES {
        // Loaded once, by the first of the trials that runs.
        let scene = Arc::new(OnceLock::new());
        for (view, label) in ["high", "oblique", "long", "grazing", "wide", "lamp"].into_iter().enumerate() {
            let scene = scene.clone();
            trials.push(gpu_trial(format!("gpu_whole::{name}_{label}"), move || {
                let scene = scene.get_or_init(|| procedural(name, procedural::DEFAULT_SEED));
                let scene = scene.as_ref().ok_or("no such scene")?;
                assert_eq!((scene.views.len(), scene.views[view].name.as_str()), (6, label));
                gpu_equals_cpu(scene, &scene.views[view])
            }));
        }
    }
    for (file, directions) in PUBLIC {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(file);
        for (index, &direction) in directions.iter().enumerate() {
            let name = format!("gpu_whole::{}_{index}", file.trim_end_matches(".glb"));
            if !path.is_file() {
                // Shown as ignored; asking for it nevertheless says why it cannot run.
                let why = format!("{} is not here", path.display());
                let kind = why.clone();
                trials
                    .push(Trial::test(name, move || Err(why.into())).with_kind(kind).with_ignored_flag(true));
                continue;
            }
            let path = path.clone();
            trials.push(gpu_trial(name, move || {
                let view = LightView::directional("public", direction);
                gpu_equals_cpu(&load_scene(&path.to_string_lossy())?, &view)
            }));
        }
    }
    trials
}

/// Offsets, depths, gradients and facing, bit for bit.
fn gpu_equals_cpu(scene: &Scene, view: &LightView) -> Result<(), Failed> {
    let (on_cpu, _) = render_view(scene, view, SIZE, SIZE, Backend::Cpu)?;
    let (on_gpu, report) = render_view(scene, view, SIZE, SIZE, Backend::Gpu)?;
    // A silent fallback would compare the CPU with itself.
    if let Some(reason) = report.fallback {
        return Err(format!("the GPU did not render: {reason}").into());
    }
    assert!(on_cpu.fragments() > 100_000, "only {} fragments", on_cpu.fragments());
    on_cpu.validate()?;
    Ok(compare(&on_gpu, &on_cpu)?)
}
