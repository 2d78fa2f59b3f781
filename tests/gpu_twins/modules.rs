//! Every WGSL module that can be put together is valid, and can be written in other languages, on any machine.

use libtest_mimic::{Failed, Trial};
use quantization::published;
use shaders::{FrameShaders, Module, Stage};
use shadow_filtering::{Kernel, TechniqueSpec, comparison_shaders};

use crate::techniques;

/// Kernels with loops that are written out and with loops that are too long for that.
const KERNEL_SIZES: [usize; 4] = [1, 3, 9, 129];

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, spec) in techniques() {
        trials.push(Trial::test(format!("wgsl::{name}"), move || every_module_of(&spec)));
    }
    trials.push(Trial::test("wgsl::percentage_closer", || {
        let of = |size| Ok(comparison_shaders(&Kernel::gaussian(size, 2.4)?, 0.05));
        KERNEL_SIZES.into_iter().map(of).try_for_each(|shaders: Result<_, Failed>| valid(&shaders?))
    }));
    trials.push(Trial::test("wgsl::planted_faults", planted_faults));
    trials
}

/// The functions alone, then all passes: one and several samples, each kernel, with and without a transform.
fn every_module_of(spec: &TechniqueSpec) -> Result<(), Failed> {
    let technique = spec.build()?;
    let functions = technique.real_time().and_then(|t| t.shader()).ok_or("no shader")?;
    Module::new(&functions)?;
    if technique.channels() > 8 {
        assert!(technique.passes(&Kernel::gaussian(3, 2.4)?, 1).is_none(), "more than two textures");
        return Ok(());
    }
    let mut modules = 0;
    let transforms = published::ALL.iter().map(|published| published.name);
    for transform in ["identity", "sampled"].into_iter().chain(transforms) {
        // Transforms of other bases are refused.
        let Ok(stored) = (TechniqueSpec { transform: Some(transform.to_owned()), ..spec.clone() }).build()
        else {
            assert!(!["identity", "sampled"].contains(&transform), "{transform}");
            continue;
        };
        for (size, samples) in KERNEL_SIZES.into_iter().zip([1, 4, 1, 4]) {
            let passes = stored.passes(&Kernel::gaussian(size, 2.4)?, samples).ok_or("no passes")?;
            valid(&passes)?;
            modules += 1;
        }
    }
    assert!(modules >= 2 * KERNEL_SIZES.len());
    Ok(())
}

/// One vertex and one fragment shader each, or one compute shader.
fn valid(shaders: &FrameShaders) -> Result<(), Failed> {
    for (pass, source) in shaders.modules() {
        let module = Module::new(source).map_err(|error| format!("{pass}: {error}"))?;
        let stages = if pass.starts_with("compute") {
            &[Stage::Compute][..]
        } else {
            &[Stage::Vertex, Stage::Fragment]
        };
        for &stage in stages {
            module.only(stage).map_err(|error| format!("{pass}: {error}"))?;
        }
        module.spirv().map_err(|error| format!("{pass}: {error}"))?;
    }
    Ok(())
}

/// A wrong type and a name that is not defined are found, in every pass.
fn planted_faults() -> Result<(), Failed> {
    let stored = TechniqueSpec::named("vsm")?.build()?;
    let passes = stored.passes(&Kernel::gaussian(3, 1.0)?, 4).ok_or("no passes")?;
    for (pass, source) in passes.modules() {
        let faults = if pass.starts_with("compute") {
            [("textureStore(", "texturePut("), ("@builtin(", "@location("), ("let ", "let a_")]
        } else {
            [
                ("vec4<f32>(2.0 * corner", "vec4<u32>(2.0 * corner"),
                ("@builtin(position) at", "at"),
                ("let corner", "let a_corner"),
            ]
        };
        for (from, to) in faults {
            assert!(source.contains(from), "{pass} has no `{from}`");
            assert!(Module::new(&source.replacen(from, to, 1)).is_err(), "{pass}: `{to}` passed");
        }
    }
    Ok(())
}
