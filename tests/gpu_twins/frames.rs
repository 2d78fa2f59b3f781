//! Whole frames: the filtered map against Rust and double precision, shadows against percentage-closer filtering, and
//! what happens when the device is lost.

use std::time::Duration;

use graphics_device::DeviceError;
use libtest_mimic::{Failed, Trial};
use scenes::{Scene, load_scene};
use shaders::FrameShaders;
use shadow_filtering::{ChannelMap, Kernel, Technique, TechniqueSpec, comparison_shaders, filter, resolve};
use shadow_renderer::{
    DepthMap, Frame, FrameRenderer, FrameSettings, LightFrame, RenderError, Route, Sampling, WHOLE_FRAME,
};

use quantization::NumberFormat;

use crate::adapter::{gpu_trial, timed_trial};
use crate::{compare, techniques};

const SETTINGS: FrameSettings = FrameSettings {
    map_size: 256,
    width: 320,
    height: 180,
    samples: 4,
    mip_maps: true,
    bias: 0.002,
    leak_reduction: 0.0,
    route: Route::Fragment,
};

pub fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    for (name, spec) in techniques() {
        if spec.build().unwrap().channels() <= 8 {
            trials.push(gpu_trial(format!("map::{name}"), {
                let spec = spec.clone();
                move || filtered_map(&spec)
            }));
            trials.push(gpu_trial(format!("compute::{name}"), move || compute_passes(&spec, &[])));
        }
    }
    trials.push(gpu_trial("compute::comparison".into(), compute_comparison));
    trials.push(gpu_trial("compute::planted_faults".into(), planted_faults));
    trials.push(gpu_trial("frame::shadows".into(), shadows));
    trials.push(gpu_trial("frame::stored".into(), stored));
    trials.push(gpu_trial("frame::colours".into(), colours));
    trials.push(timed_trial("frame::times".into(), times));
    trials.push(gpu_trial("frame::lost_device".into(), lost_device));
    trials
}

fn scene() -> (Scene, [f32; 3]) {
    let scene = load_scene("village").unwrap();
    let direction = scene.views.iter().find(|view| view.name == "oblique").unwrap().direction;
    (scene, direction)
}

/// Encoding, resolve and both filter passes, in single floats.
fn filtered_map(spec: &TechniqueSpec) -> Result<(), Failed> {
    let (scene, direction) = scene();
    let kernel = Kernel::gaussian(9, 2.4)?;
    let technique = spec.build()?;
    let passes = technique.passes(&kernel, 4).ok_or("no passes")?;
    let renderer = FrameRenderer::new(&scene, direction)?;
    let frame = renderer.render(&passes, &SETTINGS)?;
    let found = frame.filtered.ok_or("the map was not read back")?;

    let light = LightFrame::fit(&scene, direction, SETTINGS.map_size, SETTINGS.map_size)?;
    let depths = DepthMap::render(&scene, &light, Sampling::Multisample4)?;
    let single = map(&depths, &technique, &kernel, |depth, b| {
        technique.evaluate(depth, b);
    })?;
    let exact = map(&depths, &technique, &kernel, |depth, b: &mut [f64]| {
        technique.evaluate(f64::from(depth), b);
    })?;
    let channels = technique.channels();
    let scales: Vec<f64> = (0..channels)
        .map(|k| exact.iter().skip(k).step_by(channels).fold(0.0, |most: f64, v| most.max(v.abs())))
        .collect();
    compare(&format!("{}, filtered map", technique.name()), &found, &single, &exact, &scales)
}

/// Encoded samples, resolved and filtered.
fn map<R: moment_problem::arithmetic::Real + Send + Sync>(
    depths: &DepthMap,
    technique: &Technique,
    kernel: &Kernel,
    encode: impl Fn(f32, &mut [R]),
) -> Result<Vec<R>, Failed> {
    let channels = technique.channels();
    let mut samples = vec![R::zero(); depths.depths.len() * channels];
    for (b, &depth) in samples.chunks_exact_mut(channels).zip(&depths.depths) {
        encode(depth, b);
    }
    let (width, height) = ((depths.width * depths.samples) as usize, depths.height as usize);
    let resolved = resolve(&ChannelMap::new(width, height, channels, samples)?, depths.samples as usize)?;
    Ok(filter(&resolved, kernel).data().to_vec())
}

/// Shadows of a good technique are those of percentage-closer filtering but for a few percent; a wrong one is not.
fn shadows() -> Result<(), Failed> {
    let (scene, direction) = scene();
    let kernel = Kernel::gaussian(9, 2.4)?;
    let renderer = FrameRenderer::new(&scene, direction)?;
    let truth = renderer.render(&comparison_shaders(&kernel, 0.05), &SETTINGS)?;
    let distance = |spec: TechniqueSpec, fault: Option<(&str, &str)>| -> Result<f64, Failed> {
        let technique = spec.build()?;
        let mut passes = technique.passes(&kernel, 4).ok_or("no passes")?;
        if let Some((from, to)) = fault {
            let FrameShaders::Prefiltered { shade, .. } = &mut passes else { return Err("no map".into()) };
            assert!(shade.contains(from));
            *shade = shade.replacen(from, to, 1);
        }
        let frame = renderer.render(&passes, &SETTINGS)?;
        assert_eq!(frame.shadow.len(), truth.shadow.len());
        assert!(frame.shadow.iter().all(|g| (0.0..=1.0).contains(g)), "{}", technique.name());
        let distances = frame.shadow.iter().zip(&truth.shadow).map(|(g, f)| f64::from((g - f).abs()));
        Ok(distances.sum::<f64>() / frame.shadow.len() as f64)
    };
    let covered = truth.shadow.iter().filter(|f| **f > 0.5).count();
    assert!(covered * 20 > truth.shadow.len(), "{covered} pixels in shadow");
    let mut all = Vec::new();
    for (name, spec) in techniques() {
        if spec.build()?.channels() <= 8 && !name.starts_with("csm") && !name.starts_with("esm") {
            let error = distance(spec, None)?;
            println!("{name}: mean distance from PCF {error:.4}");
            assert!(error < 0.1, "{name}: {error}");
            all.push((name, error));
        }
    }
    let of = |wanted: &str| all.iter().find(|(name, _)| *name == wanted).map(|(_, error)| *error).unwrap();
    assert!(of("hamburger4") < of("vsm") && of("hamburger6") < of("vsm"), "{all:?}");
    let wrong = distance(TechniqueSpec::named("vsm")?, Some(("z_f - mean", "mean - z_f")))?;
    assert!(wrong > 0.1, "a reversed depth test went unnoticed: {wrong}");
    Ok(())
}

/// Sixteen bits with a transform give nearly the picture of single floats.
fn stored() -> Result<(), Failed> {
    let (scene, direction) = scene();
    let kernel = Kernel::gaussian(9, 2.4)?;
    let renderer = FrameRenderer::new(&scene, direction)?;
    let spec = techniques().into_iter().find(|(name, _)| *name == "hamburger4").ok_or("none")?.1;
    let mut frames = Vec::new();
    let theta = Some("GDC16 four moments".to_owned());
    for (transform, format) in [(None, NumberFormat::F32), (theta, NumberFormat::Unorm16)] {
        let technique = TechniqueSpec { transform, format: Some(format), ..spec.clone() }.build()?;
        frames.push(renderer.render(&technique.passes(&kernel, 4).ok_or("none")?, &SETTINGS)?);
    }
    let pairs = frames[0].shadow.iter().zip(&frames[1].shadow);
    let distance = pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / frames[0].shadow.len() as f64;
    assert!(distance > 0.0 && distance < 0.03, "{distance}");
    Ok(())
}

/// Colours of textures, repeated far into the distance, and of vertices: as on the CPU.
fn colours() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let picture = image::RgbImage::from_fn(64, 32, |x, y| {
        image::Rgb([4 * x as u8, if (x / 8 + y / 8) % 2 == 0 { 250 } else { 20 }, 255 - 8 * y as u8])
    });
    picture.save(folder.path().join("tiles.png"))?;
    std::fs::write(
        folder.path().join("a.mtl"),
        "newmtl tiles\nKd 0.9 1 0.8\nmap_Kd tiles.png\nnewmtl plain\nKd 0.5 0.4 0.3\n",
    )?;
    let text = "mtllib a.mtl\nv -20 0 20 1 1 1\nv 20 0 20 1 0.5 1\nv 20 0 -20 0.2 1 1\nv -20 0 -20 1 1 0\n\
        vt -3.5 0\nvt 8 0\nvt 8 15.25\nvt -3.5 15.25\nusemtl tiles\nf 1/1 2/2 3/3 4/4\n\
        v -2 0 0\nv 2 0 0\nv 0 5 0\nusemtl plain\nf 5 6 7\n";
    std::fs::write(folder.path().join("a.obj"), text)?;
    let mut scene = load_scene(&folder.path().join("a.obj").to_string_lossy())?;
    let view = scene.views[0].clone();
    let distance = |scene: &Scene| -> Result<(f64, f64), Failed> {
        let renderer = FrameRenderer::new(scene, view.direction)?;
        let gpu = renderer.render(&comparison_shaders(&Kernel::gaussian(3, 1.0)?, 0.01), &SETTINGS)?;
        let mut scene = scene.clone();
        // The CPU's is always the textured one.
        scene
            .materials
            .iter_mut()
            .filter(|m| m.name == "tiles")
            .for_each(|m| m.texture.clone_from(&texture(&folder)));
        let frame = Frame::render(&scene, SETTINGS.width, SETTINGS.height)?;
        let visibility: Vec<f32> = gpu.shadow.iter().map(|shadow| 1.0 - shadow).collect();
        let cpu = frame.shade(&view, &visibility);
        let mut differences: Vec<f64> = Vec::new();
        for ((a, b), covered) in gpu.image.pixels().zip(cpu.pixels()).zip(frame.covered()) {
            if covered {
                differences.push((0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).fold(0.0, f64::max));
            }
        }
        assert!(differences.len() > 10_000, "{} pixels", differences.len());
        differences.sort_by(f64::total_cmp);
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        Ok((mean, differences[differences.len() * 95 / 100]))
    };
    let (mean, high) = distance(&scene)?;
    println!("colours: mean distance {mean:.2} of 255, 95 % below {high}");
    // Levels follow from differences within two by two pixels on one side, from neighbours on the other.
    assert!(mean < 2.5 && high < 10.0, "{mean} {high}");
    scene.materials.iter_mut().for_each(|material| material.texture = None);
    let (mean, _) = distance(&scene)?;
    assert!(mean > 10.0, "a missing texture went unnoticed: {mean}");
    Ok(())
}

/// The texture of the file in a folder.
fn texture(folder: &tempfile::TempDir) -> Option<scenes::Texture> {
    let scene = load_scene(&folder.path().join("a.obj").to_string_lossy()).ok()?;
    scene.materials.into_iter().find(|material| material.name == "tiles")?.texture
}

/// Largest difference of two images, a share of the largest value.
fn distance(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len());
    let scale = a.iter().fold(0.0f32, |most, value| most.max(value.abs()));
    let most =
        a.iter().zip(b).fold(0.0f32, |most, (a, b)| if a == b { most } else { most.max((a - b).abs()) });
    assert!(b.iter().all(|value| value.is_finite()));
    f64::from(most) / f64::from(scale.max(f32::MIN_POSITIVE))
}

/// Compute passes with and without run-time checks against the fragment shaders: maps to a rounding of single floats, shadows
/// of pixels but for few, where hardware picks mip levels and interpolates in its own digits.
fn compute_passes(spec: &TechniqueSpec, faults: &[(usize, &str, &str)]) -> Result<(), Failed> {
    let (scene, direction) = scene();
    let technique = spec.build()?;
    let renderer = FrameRenderer::new(&scene, direction)?;
    // A side that no tile divides, and kernels that reach over a tile's edge.
    for (map_size, kernel) in [(256, 9), (200, 21), (64, 65)] {
        let kernel = Kernel::gaussian(kernel, 0.27 * kernel as f64)?;
        let mut passes = technique.passes(&kernel, 4).ok_or("no passes")?;
        let settings = FrameSettings { map_size, mip_maps: map_size != 200, ..SETTINGS };
        let fragment = renderer.render(&passes, &settings)?;
        let FrameShaders::Prefiltered { compute, .. } = &mut passes else { return Err("no map".into()) };
        for (pass, from, to) in faults {
            let module = [&mut compute.resolve, &mut compute.rows, &mut compute.columns, &mut compute.shade]
                .into_iter()
                .chain(&mut compute.halve)
                .nth(*pass)
                .ok_or("no such pass")?;
            assert!(module.contains(from), "the fault `{from}` is not in the shader");
            *module = module.replace(from, to);
        }
        for route in [Route::Compute, Route::Unchecked] {
            let found = renderer.render(&passes, &FrameSettings { route, ..settings })?;
            let what = format!("{} {map_size}, {route:?}", technique.name());
            if let (Some(a), Some(b)) = (&fragment.filtered, &found.filtered) {
                let most = distance(a, b);
                if most > MAP_DISTANCE {
                    return Err(format!("{what}: maps differ by {most:.1e}").into());
                }
            }
            let pairs = fragment.shadow.iter().zip(&found.shadow);
            let far = pairs.filter(|(a, b)| (*a - *b).abs() > SHADOW_DISTANCE).count();
            println!("{what}: {far} of {} shadows differ", fragment.shadow.len());
            if far * SHADOWS_APART > fragment.shadow.len() {
                return Err(format!("{what}: {far} shadows differ").into());
            }
        }
    }
    Ok(())
}

/// Maps of both routes: sums of up to 65 products in single floats.
const MAP_DISTANCE: f64 = 2e-6;

/// Shadows of both routes that count as equal.
const SHADOW_DISTANCE: f32 = 0.01;

/// One in so many shadows may differ more: derivatives of quads at edges of surfaces, where hardware takes what lies outside.
const SHADOWS_APART: usize = 50;

fn compute_comparison() -> Result<(), Failed> {
    let (scene, direction) = scene();
    let renderer = FrameRenderer::new(&scene, direction)?;
    let shaders = comparison_shaders(&Kernel::gaussian(9, 2.4)?, 0.05);
    let fragment = renderer.render(&shaders, &SETTINGS)?;
    for route in [Route::Compute, Route::Unchecked] {
        let found = renderer.render(&shaders, &FrameSettings { route, ..SETTINGS })?;
        let most = distance(&fragment.shadow, &found.shadow);
        if most > 1e-5 {
            return Err(format!("{route:?}: shadows differ by {most:.1e}").into());
        }
    }
    Ok(())
}

/// A tile that is off by a texel, one that is too short, a level that takes the wrong neighbours, swapped derivatives, and races:
/// without its barrier a thread reads what another has not written yet, which a software driver shows in every group that it
/// runs thread by thread.
fn planted_faults() -> Result<(), Failed> {
    let spec = TechniqueSpec::named("hamburger4")?;
    for fault in [
        (1, "- AXIS * i32(SIZE / 2u)", "- AXIS * i32(SIZE / 2u - 1u)"),
        (2, "- AXIS * i32(SIZE / 2u)", "- AXIS * i32(SIZE / 2u - 1u)"),
        (1, "i < TILE * ACROSS", "i < (TILE - 1u) * ACROSS"),
        (2, "first + place_of(i)", "first + place_of(i).yx"),
        (7, "level[thread + 8u * step]", "level[thread + 7u * step]"),
        (1, "workgroupBarrier();", ""),
        (2, "workgroupBarrier();", ""),
        (7, "workgroupBarrier();", ""),
        (0, "1.0 / f32(SAMPLES)", "1.0 / f32(SAMPLES + 1)"),
        (3, "- light.towards.w", "+ light.towards.w"),
    ] {
        if compute_passes(&spec, &[fault]).is_ok() {
            return Err(format!("the comparison missed {fault:?}").into());
        }
    }
    Ok(())
}

/// Every pass is timed or none is; passes do not overlap, so that they fill the frame.
fn times() -> Result<(), Failed> {
    let (scene, direction) = scene();
    let kernel = Kernel::gaussian(9, 2.4)?;
    let renderer = FrameRenderer::new(&scene, direction)?;
    let technique = TechniqueSpec::named("vsm")?.build()?;
    let prefiltered = technique.passes(&kernel, 4).ok_or("none")?;
    let comparison = comparison_shaders(&kernel, 0.05);
    let passes = ["shadow map", "resolve", "filter rows", "filter columns", "mip maps", "surfaces", "shade"];
    for (shaders, expected) in
        [(&prefiltered, &passes[..]), (&comparison, &["shadow map", "surfaces", "shade"])]
    {
        for route in [Route::Fragment, Route::Compute] {
            let settings = FrameSettings { route, ..SETTINGS };
            let times = renderer.time(shaders, &settings, Duration::from_millis(5), 3)?;
            let (whole, parts) = times.split_last().ok_or("the adapter has no timestamps")?;
            assert_eq!(whole.pass, WHOLE_FRAME);
            assert_eq!(parts.iter().map(|pass| pass.pass).collect::<Vec<_>>(), expected);
            assert!(times.iter().all(|pass| pass.times.len() == 3), "{times:?}");
            for frame in 0..3 {
                let sum: Duration = parts.iter().map(|pass| pass.times[frame]).sum();
                // The clock may tick once in each pass.
                assert!(
                    sum <= whole.times[frame] + Duration::from_micros(8),
                    "{sum:?} of {:?}",
                    whole.times[frame]
                );
            }
        }
    }
    Ok(())
}

fn lost_device() -> Result<(), Failed> {
    let (scene, direction) = scene();
    let kernel = Kernel::gaussian(3, 1.0)?;
    let renderer = FrameRenderer::new(&scene, direction)?;
    let shaders = comparison_shaders(&kernel, 0.05);
    renderer.render(&shaders, &SETTINGS)?;
    renderer.lose();
    match renderer.render(&shaders, &SETTINGS) {
        Err(RenderError::Gpu(DeviceError::Lost(_))) => Ok(()),
        other => {
            Err(format!("a lost device went unnoticed: {:?}", other.map(|frame| frame.shadow.len())).into())
        }
    }
}
