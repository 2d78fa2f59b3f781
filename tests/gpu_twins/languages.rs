//! What is taken home in HLSL and GLSL, compiled to SPIR-V by glslang and run as it is: the errors on fragments of scenes are
//! those of the WGSL.

use std::sync::OnceLock;

use graphics_device::{DeviceError, GraphicsDevice};
use libtest_mimic::{Failed, Trial};
use shaders::{Module, reachable};
use shadow_filtering::{Kernel, ShadowPass, Surroundings, Technique, TechniqueSpec};

use super::Errors;
use super::compute::{self, Resource};
use super::fragments::{FRAGMENTS, Inputs};
use super::programs::{GLSLANG, compiled, program_trial};

/// Errors of a translation may be this many times those of the WGSL: compilers contract products and sums as they like.
const RATIO: f64 = 1.5;

#[derive(Clone, Copy, Debug)]
enum Language {
    Hlsl,
    Glsl,
}

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, spec) in super::techniques() {
        for language in [Language::Hlsl, Language::Glsl] {
            let spec = spec.clone();
            trials
                .push(trial(format!("languages::{language:?}::{name}"), move || same(&spec, language, None)));
        }
    }
    trials.push(trial("languages::planted_faults".to_owned(), planted_faults));
    trials
}

/// Needs a compiler and an adapter that takes SPIR-V.
fn trial(name: String, test: impl FnOnce() -> Result<(), Failed> + Send + 'static) -> Trial {
    match device() {
        Ok(_) => program_trial(name, &[GLSLANG], test),
        Err(missing) => super::adapter::ignored(name, format!("needs a graphics adapter: {missing}")),
    }
}

/// A device that takes modules unseen.
fn device() -> Result<&'static GraphicsDevice, DeviceError> {
    static DEVICE: OnceLock<Result<GraphicsDevice, DeviceError>> = OnceLock::new();
    let feature = wgpu::Features::PASSTHROUGH_SHADERS;
    let open = || {
        let gpu = GraphicsDevice::open(feature)?;
        if gpu.device.features().contains(feature) {
            return Ok(gpu);
        }
        Err(DeviceError::NoAdapter(format!("{} takes no compiled shaders", gpu.name)))
    };
    DEVICE.get_or_init(open).as_ref().map_err(Clone::clone)
}

/// Encodes, decodes and shades.
const CALL: &str = "
    var filtered: array<f32, CHANNELS>;
    for (var k = 0u; k < CHANNELS; k++) { filtered[k] = inputs[start + k]; }
    outputs[first] = shade(filtered, inputs[start + CHANNELS]);
    var decoded = decode(encode(inputs[start + CHANNELS]));
    for (var k = 0u; k < CHANNELS; k++) { outputs[first + 1u + k] = decoded[k]; }";

fn module(technique: &Technique, items: usize) -> Result<String, Failed> {
    let kernel = Kernel::gaussian(9, 2.4)?;
    let around = Surroundings { kernel: &kernel, samples: 4, leak_reduction: 0.0 };
    let whole = technique.standalone(&ShadowPass::ALL, &around).ok_or("no shader")?;
    let functions = reachable(&whole, &["encode", "decode", "shade"]);
    let channels = technique.channels();
    Ok(compute::source(&functions, CALL, items, [channels + 1, channels + 1]))
}

/// With `FROM=>TO` in the translation.
fn translated(source: &str, language: Language, fault: Option<(&str, &str)>) -> Result<Vec<u32>, Failed> {
    let module = Module::new(source)?;
    let (mut text, name, options) = match language {
        Language::Hlsl => (module.hlsl()?, "shader.hlsl", &["-D", "-e", "main"][..]),
        Language::Glsl => (module.glsl("main")?, "shader.glsl", &[][..]),
    };
    if let Some((from, to)) = fault {
        assert!(text.contains(from), "the fault `{from}` is not in\n{text}");
        text = text.replacen(from, to, 1);
    }
    let folder = tempfile::tempdir()?;
    let (file, object) = (folder.path().join(name), folder.path().join("shader.spv"));
    std::fs::write(&file, text)?;
    compiled(&file, "comp", options, &object)?;
    let bytes = std::fs::read(&object)?;
    Ok(bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect())
}

fn run(words: &[u32], inputs: &[f32], each: usize) -> Result<Vec<f32>, Failed> {
    let gpu = device()?;
    // On Vulkan the size of a workgroup is the module's own.
    let entry = wgpu::PassthroughShaderEntryPoint { name: "main".into(), workgroup_size: (0, 0, 0) };
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        entry_points: std::slice::from_ref(&entry).into(),
        spirv: Some(words.into()),
        ..Default::default()
    };
    // SAFETY: glslang has made it from text that naga validated and bounded.
    let module = unsafe { gpu.device.create_shader_module_passthrough(descriptor) };
    let resources = [Resource::Read(bytemuck::cast_slice(inputs)), Resource::Write(size_of_val(inputs))];
    Ok(compute::run_modules(gpu, &[(module, "main", compute::groups(inputs.len() / each))], &resources, 1)?)
}

fn same(spec: &TechniqueSpec, language: Language, fault: Option<(&str, &str)>) -> Result<(), Failed> {
    let technique = spec.build()?;
    let (inputs, each) = (Inputs::of_scenes(&technique).values, technique.channels() + 1);
    let items = inputs.len() / each;
    assert!(items >= FRAGMENTS, "{items} fragments");
    let source = module(&technique, items)?;
    let wgsl: Vec<f32> = compute::run(
        &[(&source, "main", compute::groups(items))],
        &[Resource::Read(bytemuck::cast_slice(&inputs)), Resource::Write(size_of_val(&inputs[..]))],
        1,
    )?;
    let found = run(&translated(&source, language, fault)?, &inputs, each)?;
    // Shadows, then functions of depth relative to the largest value of each.
    let mut tables = Vec::new();
    for values in [&wgsl, &found] {
        let mut shadows = Vec::with_capacity(items);
        for (item, values) in inputs.chunks_exact(each).zip(values.chunks_exact(each)) {
            let b: Vec<f64> = item[..each - 1].iter().map(|&v| f64::from(v)).collect();
            let exact = technique.shade(&b, f64::from(item[each - 1]))?;
            // NaN is as wrong as can be.
            let error = (f64::from(values[0]) - exact).abs();
            shadows.push(if error.is_nan() { f64::INFINITY } else { error });
        }
        tables.push(Errors::of(shadows));
    }
    let differing = wgsl.iter().zip(&found).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    let farthest = wgsl.iter().zip(&found).fold(0.0, |most: f32, (a, b)| {
        let scale = a.abs().max(1.0);
        most.max((a - b).abs() / scale)
    });
    println!(
        "{language:?}, {}: mean, 99.9 %, largest error {}; WGSL {}; {differing} of {} values differ, by {farthest:.1e} at most",
        technique.name(),
        tables[1],
        tables[0],
        wgsl.len(),
    );
    let decoded = |values: &[f32], i: usize| !i.is_multiple_of(each) && !values[i].is_finite();
    if (0..found.len()).any(|i| decoded(&found, i)) {
        return Err(format!("{language:?}: a decoded value is not finite").into());
    }
    let same_codes = (0..found.len()).filter(|i| !i.is_multiple_of(each)).all(|i| {
        let scale = wgsl[i].abs().max(1.0);
        (wgsl[i] - found[i]).abs() <= CODE_TOLERANCE * scale
    });
    let [mean, _, largest] = tables[1].0;
    let invisible = mean <= CONTRACTED && largest <= 1.0 / 255.0;
    if (tables[1].is_within(&tables[0], RATIO) || invisible) && same_codes {
        return Ok(());
    }
    Err(format!(
        "{language:?} errs by {}, the WGSL by {}; same functions of depth: {same_codes}",
        tables[1], tables[0]
    )
    .into())
}

/// Mean error that contraction may leave: HLSL keeps no order of sums and products, on which the compensated moments of Hausdorff 4
/// rest; it then errs by 2.2e-5 where WGSL errs by 1.5e-6, and nowhere visibly.
const CONTRACTED: f64 = 5e-5;

/// How far functions of depth, encoded and decoded, may be apart: a few roundings.
const CODE_TOLERANCE: f32 = 1e-6;

/// A wrong sign in what a back end wrote is found.
fn planted_faults() -> Result<(), Failed> {
    for (name, language, from, to) in [
        ("vsm", Language::Hlsl, "second - (mean * mean)", "second + (mean * mean)"),
        ("vsm", Language::Glsl, "second - (mean * mean)", "second + (mean * mean)"),
        ("hamburger4", Language::Hlsl, "- (l * e)", "+ (l * e)"),
        ("hamburger4", Language::Glsl, "- (l * e)", "+ (l * e)"),
    ] {
        let (_, spec) =
            super::techniques().into_iter().find(|(known, _)| *known == name).ok_or("no such technique")?;
        // Any other error would say that nothing was run.
        let found = same(&spec, language, Some((from, to))).err();
        let reason = found.as_ref().and_then(Failed::message).unwrap_or("nothing");
        if !reason.contains("errs by") {
            return Err(format!("{name} in {language:?} with `{to}`: {reason} was found").into());
        }
    }
    Ok(())
}
