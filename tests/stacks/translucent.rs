//! Stacks with opacities: against rays through every texel centre, GPU against CPU, and against stacks that know none.

use std::fs;
use std::sync::Arc;

use libtest_mimic::{Failed, Trial};
use scenes::*;
use shadow_renderer::*;

use crate::compare::compare;
use crate::gpu_trial;
use crate::local_lights::lamp;
use crate::scenes::{Random, SLANTED, ground, scene_of, soup};

pub fn trials() -> Vec<Trial> {
    let mut trials = vec![
        Trial::test("translucent::opacity_by_texel", opacity_by_texel),
        Trial::test("translucent::opaque_or_clear", opaque_or_clear),
        Trial::test("translucent::tested_at_one_half", tested_at_one_half),
        Trial::test("translucent::triangles", triangles),
        Trial::test("translucent::ten_thousand_layers", ten_thousand_layers),
        Trial::test("translucent::files", files),
        Trial::test("translucent::bad_files", bad_files),
    ];
    for name in ["smoke", "glasshouse"] {
        for view in ["high", "long", "lamp"] {
            let trial = move || gpu_equals_cpu(&load_scene(name)?, view);
            trials.push(gpu_trial(format!("gpu_translucent::{name}_{view}"), trial));
        }
    }
    trials.push(gpu_trial("gpu_translucent::soup".into(), || {
        let mut scene = veiled(scene_of(&soup(300, &mut Random(11))), &mut Random(12));
        scene.views = vec![LightView::directional("sun", SLANTED)];
        gpu_equals_cpu(&scene, "sun")
    }));
    trials
}

/// Alpha of factor, texture and vertices, with transmission on every other triangle.
fn veiled(mut scene: Scene, random: &mut Random) -> Scene {
    let mut texture = |width, height| {
        let alpha = (0..width * height).map(|_| (255.0 * random.unit()) as u8).collect();
        Some(Arc::new(AlphaTexture { width, height, alpha }))
    };
    let smoke = Opacity::blended(0.8, texture(7, 5));
    let glass = Opacity {
        transmission: [0.9, 0.5, 0.1],
        transmission_texture: texture(3, 4),
        tested: false,
        ..Opacity::blended(1.0, None)
    };
    for (name, opacity) in [("smoke", smoke), ("glass", glass)] {
        scene.materials.push(Material { opacity: Some(opacity), ..Material::plain(name, [0.5; 3]) });
    }
    for (i, material) in scene.triangle_material.iter_mut().enumerate() {
        *material = i as u32 % 3;
    }
    scene.colors = scene.vertices.iter().map(|_| [1.0, 1.0, 1.0, random.unit()]).collect();
    for vertex in &mut scene.vertices {
        vertex.uv = [3.0 * random.signed(), 3.0 * random.signed() - 9.0];
    }
    scene
}

fn cpu(scene: &Scene, frame: &LightFrame) -> TranslucentStack {
    render_translucent(scene, frame, Spectrum::Luminance, Backend::Cpu).unwrap().0
}

fn gpu_equals_cpu(scene: &Scene, view: &str) -> Result<(), Failed> {
    let view = scene.views.iter().find(|v| v.name == view).ok_or("no such view")?;
    let frame = LightFrame::of_view(scene, view, 256, 256)?;
    for spectrum in [Spectrum::Luminance, Spectrum::Blue] {
        let (on_cpu, _) = render_translucent(scene, &frame, spectrum, Backend::Cpu)?;
        let (on_gpu, report) = render_translucent(scene, &frame, spectrum, Backend::Gpu)?;
        // A silent fallback would compare the CPU with itself.
        if let Some(reason) = report.fallback {
            return Err(format!("the GPU did not render: {reason}").into());
        }
        assert!(on_cpu.stack.opacities.iter().any(|&opacity| opacity < 1.0), "nothing lets light through");
        on_cpu.stack.validate()?;
        compare(&on_gpu.stack, &on_cpu.stack)?;
        assert_eq!(on_gpu.triangles, on_cpu.triangles);
    }
    Ok(())
}

/// Of every fragment by the ray through its texel's centre: weights of the triangle's corners, its texel and alpha.
fn opacity_by_texel() -> Result<(), Failed> {
    let scene = veiled(scene_of(&soup(400, &mut Random(5))), &mut Random(6));
    let sun = LightFrame::fit(&scene, SLANTED, 90, 70)?;
    let local = LightFrame::of_view(&scene, &lamp("rect:0,3,0;0.5,0,0;0,0,0.5"), 80, 80)?;
    for frame in [sun, local] {
        let TranslucentStack { stack, triangles } = cpu(&scene, &frame);
        let (mut checked, mut differing) = (0, 0);
        for texel in 0..stack.offsets.len() - 1 {
            let own = stack.offsets[texel] as usize..stack.offsets[texel + 1] as usize;
            for (i, &triangle) in own.clone().zip(&triangles[own]) {
                let at = [texel as u32 % stack.width, texel as u32 / stack.width];
                let Some(expected) = expected(&scene, &frame, triangle as usize, at) else { continue };
                checked += 1;
                differing += u32::from((f64::from(stack.opacity(i)) - expected).abs() > 1e-4);
            }
        }
        // Texels at borders of the textures, and slivers whose plane is that of the snapped corners.
        assert!(checked > 1500 && differing < checked / 200, "{differing} of {checked}");
        // The same with another texture must be found to differ.
        let mut other = scene.clone();
        let opacity = other.materials[1].opacity.as_mut().ok_or("no opacity")?;
        opacity.factor = 0.75;
        let faulty = cpu(&other, &frame);
        assert!(compare(&faulty.stack, &stack).is_err(), "another factor went unnoticed");
    }
    Ok(())
}

/// `None` where the triangle is seen edge-on or beside its corners, which snapping may do.
fn expected(scene: &Scene, frame: &LightFrame, triangle: usize, [x, y]: [u32; 2]) -> Option<f64> {
    let corners = scene.triangles[triangle];
    let position = |i: u32| scene.vertices[i as usize].position.map(f64::from);
    let world = corners.map(position);
    let [start, end] = [0.0, 1.0].map(|z| frame.unproject([f64::from(x) + 0.5, f64::from(y) + 0.5, z]));
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (ab, ac, ray) = (minus(world[1], world[0]), minus(world[2], world[0]), minus(end, start));
    let across = cross(ray, ac);
    let determinant = dot(ab, across);
    let size = dot(ab, ab).sqrt() * dot(ac, ac).sqrt() * dot(ray, ray).sqrt();
    if determinant.abs() < 0.02 * size {
        return None;
    }
    let from = minus(start, world[0]);
    let v = dot(from, across) / determinant;
    let w = dot(ray, cross(from, ab)) / determinant;
    let weights = [1.0 - v - w, v, w];
    if weights.iter().any(|&weight| weight < 0.02) {
        return None;
    }
    let mix = |value: &dyn Fn(u32) -> f64| (0..3).map(|i| weights[i] * value(corners[i])).sum::<f64>();
    let uv = [0, 1].map(|k| mix(&|i| f64::from(scene.vertices[i as usize].uv[k])));
    let alpha = mix(&|i| f64::from(scene.colors[i as usize][3]));
    let Some(opacity) = &scene.materials[scene.triangle_material[triangle] as usize].opacity else {
        return Some(1.0);
    };
    let value = |texture: &Option<Arc<AlphaTexture>>| {
        texture.as_ref().map_or(1.0, |t| {
            let texel = |c: f64, size: u32| ((c - c.floor()) * f64::from(size)) as u32;
            t.value(texel(uv[0], t.width).min(t.width - 1), texel(uv[1], t.height).min(t.height - 1))
        })
    };
    let covered = f64::from(opacity.factor) * value(&opacity.texture) * alpha;
    let [r, g, b] = opacity.transmission.map(f64::from);
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    Some(covered * (1.0 - luminance * value(&opacity.transmission_texture)))
}

/// All opacities 1 give the stack that knows none; all 0 give nothing.
fn opaque_or_clear() -> Result<(), Failed> {
    let plain = scene_of(&soup(200, &mut Random(8)));
    let frame = LightFrame::fit(&plain, SLANTED, 64, 64)?;
    let (expected, _) = render_in_frame(&plain, &frame, Backend::Cpu)?;
    let with = |factor: f32| {
        let mut scene = plain.clone();
        scene.materials[0].opacity = Some(Opacity::blended(factor, None));
        cpu(&scene, &frame)
    };
    let opaque = with(1.0);
    compare(&opaque.stack, &expected)?;
    assert!(opaque.stack.opacities.is_empty() && opaque.triangles.is_empty());
    let clear = with(0.0).stack;
    clear.validate()?;
    assert_eq!((clear.fragments(), clear.offsets.len()), (0, 64 * 64 + 1));
    let half = with(0.3).stack;
    assert_eq!(half.fragments(), expected.fragments());
    assert!(half.opacities.iter().all(|&opacity| opacity == 0.3));
    for wrong in [1.5, -0.1, f32::NAN] {
        let mut scene = plain.clone();
        scene.materials[0].opacity = Some(Opacity::blended(wrong, None));
        let error = render_translucent(&scene, &frame, Spectrum::Red, Backend::Cpu).expect_err("must fail");
        assert!(error.to_string().contains("outside of [0, 1]"), "{error}");
    }
    Ok(())
}

/// What shadows take that know no translucency is the same from a scene and from its stack with opacities.
fn tested_at_one_half() -> Result<(), Failed> {
    for name in ["smoke", "glasshouse"] {
        let scene = load_scene(name)?;
        let frame = LightFrame::of_view(&scene, &scene.views[1], 200, 200)?;
        let translucent = cpu(&scene, &frame).stack;
        let most = translucent.layer_statistics().max;
        assert!(translucent.fragments() > 30_000 && (5..=64).contains(&most), "{name}: {most} layers");
        let (tested, _) = render_in_frame(&scene, &frame, Backend::Cpu)?;
        assert!(tested.opacities.is_empty());
        if name == "smoke" {
            compare(&translucent.clone().opaque(), &tested)?;
        } else {
            // Glass is opaque where nothing is blended.
            assert!(translucent.opaque().fragments() < tested.fragments());
        }
    }
    Ok(())
}

/// Fragments know their triangles, in perspective too.
fn triangles() -> Result<(), Failed> {
    let scene = veiled(scene_of(&soup(60, &mut Random(15))), &mut Random(16));
    let local = LightFrame::of_view(&scene, &lamp("rect:0,3,0;0.5,0,0;0,0,0.5"), 64, 64)?;
    for frame in [LightFrame::fit(&scene, SLANTED, 64, 64)?, local] {
        let TranslucentStack { stack, triangles } = cpu(&scene, &frame);
        assert_eq!(triangles.len(), stack.fragments());
        for (i, &triangle) in triangles.iter().enumerate() {
            let is_opaque = scene.triangle_material[triangle as usize] == 0;
            assert!(!is_opaque || stack.opacity(i) == 1.0);
        }
    }
    Ok(())
}

fn ten_thousand_layers() -> Result<(), Failed> {
    let corners: Vec<[f32; 3]> = (0..10_000).flat_map(|i| ground(1.0, i as f32 * 1e-3)).collect();
    let mut scene = scene_of(&corners);
    scene.materials[0].opacity = Some(Opacity::blended(0.01, None));
    let frame = LightFrame::fit(&scene, [0.0, -1.0, 0.0], 4, 4)?;
    let stack = cpu(&scene, &frame).stack;
    stack.validate()?;
    assert_eq!(stack.layer_statistics().max, 10_000);
    Ok(())
}

/// Version 2 with opacities, version 1 without, bytes as they were.
fn files() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("stack.npz");
    let scene = veiled(scene_of(&soup(100, &mut Random(2))), &mut Random(3));
    let frame = LightFrame::fit(&scene, SLANTED, 32, 32)?;
    let saved = cpu(&scene, &frame).stack;
    saved.save(&path)?;
    compare(&saved, &ShadowMapStack::load(&path)?)?;
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    assert!(text(fs::read(&path)?).contains("opacities.npy"));
    let opaque = saved.clone().opaque();
    opaque.save(&path)?;
    assert!(!text(fs::read(&path)?).contains("opacities.npy"));
    compare(&opaque, &ShadowMapStack::load(&path)?)?;
    // Clear fragments of a file vanish, and opacities that are all 1 need no list.
    let mut clear = opaque.clone();
    clear.opacities = vec![1.0; clear.fragments()];
    clear.opacities[3] = 0.0;
    clear.save(&path)?;
    let loaded = ShadowMapStack::load(&path)?;
    assert_eq!((loaded.fragments(), loaded.opacities.len()), (opaque.fragments() - 1, 0));
    Ok(())
}

fn bad_files() -> Result<(), Failed> {
    let scene = veiled(scene_of(&soup(100, &mut Random(2))), &mut Random(3));
    let good = cpu(&scene, &LightFrame::fit(&scene, SLANTED, 32, 32)?).stack;
    for (value, needle) in [(1.5, "1.5"), (-0.25, "-0.25"), (f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
        let mut bad = good.clone();
        bad.opacities[7] = value;
        let message = bad.validate().expect_err("must fail").to_string();
        assert!(message.contains(&format!("'opacities' is invalid: holds {needle} at 7")), "{message}");
    }
    let mut short = good.clone();
    short.opacities.pop();
    assert!(short.validate().expect_err("must fail").to_string().contains("opacities"));
    Ok(())
}
