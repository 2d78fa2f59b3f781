//! Stacks: GPU against CPU bit for bit, both against brute force, stencil routing and analysis.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]
// The measured errors are for people to read.
#![allow(clippy::print_stdout)]

#[path = "../adapter/mod.rs"]
mod adapter;
mod analysis;
mod bad_input;
mod blending;
mod brute_force;
mod compare;
mod depth_maps;
mod files;
mod frames;
mod local_lights;
mod scenes;
mod shadow_rays;
mod stencil;
mod translucent;
mod whole_scenes;

use std::process::ExitCode;
use std::sync::Arc;

use libtest_mimic::{Arguments, Failed, Trial};
use shadow_renderer::*;

use crate::adapter::gpu_trial;
use crate::scenes::Case;

fn cpu(case: &Case) -> ShadowMapStack {
    render_in_frame(&case.scene, &case.frame, Backend::Cpu).unwrap().0
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = Vec::new();
    for case in scenes::cases().into_iter().chain(local_lights::cases()).map(Arc::new) {
        let name = case.name.replace(' ', "_");
        let brute = case.clone();
        trials.push(Trial::test(format!("brute_force::{name}"), move || {
            let stack = cpu(&brute);
            stack.validate()?;
            match brute.frame.eye {
                None => brute_force::check(&brute, &stack)?,
                Some(_) => local_lights::check(&brute, &stack)?,
            }
            Ok(())
        }));
        let threads = case.clone();
        trials.push(Trial::test(format!("threads::{name}"), move || thread_counts(&threads)));
        let whole = case.clone();
        trials.push(gpu_trial(format!("gpu::{name}"), move || gpu_equals_cpu(&whole, BINDING_BYTES)));
        // So small that there are many chunks of triangles, batches of rectangles, and bands to halve.
        trials.push(gpu_trial(format!("gpu_in_chunks::{name}"), move || gpu_equals_cpu(&case, 65_536)));
    }
    trials.push(Trial::test("comparison_finds_planted_faults", || {
        let case = scenes::cases().into_iter().find(|c| c.name == "soup 1").ok_or("no such scene")?;
        Ok(compare::finds_planted_faults(&cpu(&case))?)
    }));
    trials.push(Trial::test("auto_avoids_software_adapters", auto_avoids_software_adapters));
    trials.push(gpu_trial("gpu_falls_back_to_the_cpu".into(), gpu_falls_back_to_the_cpu));
    trials.push(Trial::test("brute_force_finds_planted_faults", brute_force_can_fail));
    trials.push(gpu_trial("stencil_routing".into(), stencil::agrees_with_the_stack));
    trials.push(gpu_trial("depth_maps::single".into(), depth_maps::single_sample_is_layer_0));
    trials.push(gpu_trial("depth_maps::several".into(), depth_maps::several_samples));
    trials.extend(analysis::trials());
    trials.extend(files::trials());
    trials.extend(bad_input::trials());
    trials.extend(frames::trials());
    trials.extend(local_lights::trials());
    trials.extend(shadow_rays::trials());
    trials.extend(translucent::trials());
    trials.extend(blending::trials());
    trials.extend(whole_scenes::trials());
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn gpu_equals_cpu(case: &Case, binding_bytes: u64) -> Result<(), Failed> {
    let (stack, report) = render_in_chunks(&case.scene, &case.frame, Backend::Gpu, binding_bytes)?;
    // A silent fallback would compare the CPU with itself.
    if let Some(reason) = report.fallback {
        return Err(format!("the GPU did not render: {reason}").into());
    }
    assert!(report.adapter.is_some());
    Ok(compare::compare(&stack, &cpu(case))?)
}

fn thread_counts(case: &Case) -> Result<(), Failed> {
    let expected = cpu(case);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        compare::compare(&pool.install(|| cpu(case)), &expected)
            .map_err(|e| format!("{threads} threads: {e}"))?;
    }
    Ok(())
}

fn brute_force_can_fail() -> Result<(), Failed> {
    let case = scenes::cases().into_iter().find(|c| c.name == "soup 2").ok_or("no such scene")?;
    let stack = cpu(&case);
    let mut deeper = stack.clone();
    let last = deeper.fragments() - 1;
    deeper.depths[last] = (deeper.depths[last] - 0.01).abs();
    let mut turned = stack.clone();
    turned.light_facing = stack.light_facing.iter().enumerate().map(|(i, b)| b ^ (i == last)).collect();
    let mut without = stack;
    without.offsets.iter_mut().skip(5000).for_each(|o| *o = o.saturating_sub(1));
    for (name, faulty) in [("depth", deeper), ("facing", turned), ("fragment", without)] {
        if brute_force::check(&case, &faulty).is_ok() {
            return Err(format!("brute force missed a wrong {name}").into());
        }
    }
    Ok(())
}

fn auto_avoids_software_adapters() -> Result<(), Failed> {
    let case = scenes::cases().into_iter().find(|c| c.name == "soup 3").ok_or("no such scene")?;
    let (stack, report) = render_in_frame(&case.scene, &case.frame, Backend::Auto)?;
    match (&report.adapter, &report.fallback) {
        (Some(adapter), None) => assert_ne!(adapter.device_type, "Cpu"),
        (None, Some(reason)) => assert!(!reason.is_empty()),
        other => return Err(format!("neither a GPU nor a reason against it: {other:?}").into()),
    }
    Ok(compare::compare(&stack, &cpu(&case))?)
}

/// With too little memory for a single row on the device, the stack comes from the CPU, and the report says why.
fn gpu_falls_back_to_the_cpu() -> Result<(), Failed> {
    let case = scenes::cases().into_iter().find(|c| c.name == "many layers").ok_or("no such scene")?;
    let (stack, report) = render_in_chunks(&case.scene, &case.frame, Backend::Gpu, 4096)?;
    let reason = report.fallback.ok_or("the GPU rendered")?;
    assert!(reason.contains("too many fragments") && report.adapter.is_none(), "{reason}");
    Ok(compare::compare(&stack, &cpu(&case))?)
}
