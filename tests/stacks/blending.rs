//! Back-to-front blending by a real render target against the model of its rounding.

use applications::translucency::{Layer, Rounding, blended, blended_texel};
use graphics_device::{DeviceError, GraphicsDevice};
use libtest_mimic::{Failed, Trial};
use quantization::NumberFormat;
use shadow_filtering::{Technique, TechniqueSpec};
use wgpu::{BufferUsages as Usage, TextureFormat as Format, TextureUsages as Uses};

use crate::gpu_trial;
use crate::scenes::Random;

/// Texels along a side, each with its own layers; as in the shader.
const SIDE: u32 = 64;

/// Layers of a texel, as many as the planes of BHS16's smoke.
const LAYERS: usize = 15;

/// Least opacity of a layer that has any.
const THINNEST: f32 = 0.1;

/// Steps of the format between device and model after all layers, on average. Devices blend in single precision or in fixed
/// point, in which opacities are rounded, too: that is within a step in each layer, and what follows fades by its opacity.
const MEAN_STEPS: f64 = 1.0;

/// At most: one step in each layer, of which the thinnest opacity leaves a geometric series.
const STEPS: f64 = 1.0 / THINNEST as f64;

/// Mean steps by which what is no model of it must be off.
const FAULT: f64 = 10.0;

pub fn trials() -> Vec<Trial> {
    vec![
        gpu_trial("blending::f16".into(), || agrees(NumberFormat::F16, Format::Rg16Float, "identity")),
        norm16_trial("blending::unorm16"),
    ]
}

/// 16-bit fixed point is an optional feature; without it the test is reported as ignored.
fn norm16_trial(name: &str) -> Trial {
    let missing = match GraphicsDevice::shared() {
        Err(error) => Some(error.to_string()),
        Ok(gpu) if gpu.adapter.features().contains(features()) => None,
        Ok(gpu) => Some(format!("{} has no 16-bit fixed point that is blended", gpu.name)),
    };
    match missing {
        None => {
            gpu_trial(name.into(), || agrees(NumberFormat::Unorm16, Format::Rg16Unorm, "GDC16 four moments"))
        }
        Some(missing) => Trial::test(name, move || Err(missing.into())).with_ignored_flag(true),
    }
}

/// What tells that the format can be blended.
fn features() -> wgpu::Features {
    wgpu::Features::TEXTURE_FORMAT_16BIT_NORM | wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES
}

fn technique(format: NumberFormat, transform: &str) -> Result<Technique, Failed> {
    let spec = TechniqueSpec {
        format: Some(format),
        transform: Some(transform.to_owned()),
        ..TechniqueSpec::named("hamburger4")?
    };
    Ok(spec.build()?)
}

/// Texels of layers, nearest first; some of them clear.
fn texels(random: &mut Random) -> Result<Vec<Vec<Layer>>, Failed> {
    let texel = |random: &mut Random| -> Result<Vec<Layer>, Failed> {
        let mut depths: Vec<f32> = (0..LAYERS).map(|_| random.unit()).collect();
        depths.sort_by(f32::total_cmp);
        let opacity = |random: &mut Random| match random.unit() {
            clear if clear < 0.1 => 0.0,
            _ => THINNEST + (0.9 - THINNEST) * random.unit(),
        };
        let layer = |depth: f32| Ok(Layer::new(f64::from(depth), f64::from(opacity(random)))?);
        depths.into_iter().map(layer).collect()
    };
    (0..SIDE * SIDE).map(|_| texel(random)).collect()
}

fn agrees(format: NumberFormat, target: Format, transform: &str) -> Result<(), Failed> {
    let technique = technique(format, transform)?;
    let texels = texels(&mut Random(77))?;
    let found = drawn(&technique, &texels, target)?;
    // Steps of half floats grow with the value; those below 1 are the largest here.
    let step = if format == NumberFormat::F16 { 2f64.powi(-11) } else { 1.0 / 65535.0 };
    let distances = |model: &dyn Fn(&[Layer]) -> Vec<f64>| -> (f64, f64) {
        let pairs = found.iter().zip(&texels).flat_map(|(codes, layers)| {
            let values = codes.iter().map(|&code| format.decode(u32::from(code)));
            values.zip(model(layers)).map(|(found, value)| (found - value).abs() / step).collect::<Vec<_>>()
        });
        let all: Vec<f64> = pairs.collect();
        (all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(0.0, f64::max))
    };
    let modelled =
        |rounding: Rounding| distances(&|layers| blended_texel(&technique, layers, None, rounding));
    let [nearest, never] = [Rounding::EachLayer, Rounding::Never].map(modelled);
    // Direct3D and Vulkan leave it to devices whether floats are rounded to the nearest or cut off.
    let cut = distances(&|layers| cut_off(&technique, layers));
    let (mean, most) = if cut.0 < nearest.0 { cut } else { nearest };
    println!(
        "{}: mean and most steps off, rounded {:.3} {:.2}, cut off {:.3} {:.2}, not rounded {:.3} {:.2}",
        format.name(),
        nearest.0,
        nearest.1,
        cut.0,
        cut.1,
        never.0,
        never.1
    );
    if mean > MEAN_STEPS || most > STEPS {
        return Err(format!("{mean:.3} steps off on average, {most:.2} at most").into());
    }
    // Front to back must be found to differ.
    let ranks: Vec<f32> = (0..LAYERS).map(|i| -(i as f32)).collect();
    let backwards = distances(&|layers| blended_texel(&technique, layers, Some(&ranks), Rounding::EachLayer));
    assert!(backwards.0 > FAULT, "the wrong order is only {:.2} steps off", backwards.0);
    Ok(())
}

/// The model with values cut off towards zero in place of rounded ones.
fn cut_off(technique: &Technique, layers: &[Layer]) -> Vec<f64> {
    let format = technique.encoding().format();
    let mut b = [0.0; 4];
    let mut values = |depth: f64, out: &mut [f64]| {
        technique.evaluate(depth, &mut b);
        technique.encoding().transform().apply(&b, out);
    };
    let mut background = vec![0.0; 4];
    values(1.0, &mut background);
    let farthest_first: Vec<Layer> = layers.iter().rev().copied().collect();
    blended(&farthest_first, background, values, |value| {
        let code = format.encode(value);
        let nearest = format.decode(code);
        // Codes of one sign grow with the magnitude.
        if nearest.abs() > value.abs() { format.decode(code - 1) } else { nearest }
    })
}

/// Codes of four channels a texel, as the device blends them.
fn drawn(technique: &Technique, texels: &[Vec<Layer>], format: Format) -> Result<Vec<[u16; 4]>, DeviceError> {
    let gpu = GraphicsDevice::open(features())?;
    gpu.watched(|| draw(&gpu, technique, texels, format))
}

fn draw(
    gpu: &GraphicsDevice,
    technique: &Technique,
    texels: &[Vec<Layer>],
    format: Format,
) -> Result<Vec<[u16; 4]>, DeviceError> {
    let stored = |depth: f64| {
        let (mut b, mut values) = ([0.0; 4], [0.0; 4]);
        technique.evaluate(depth, &mut b);
        technique.encoding().transform().apply(&b, &mut values);
        values
    };
    let (mut values, mut opacities) = (Vec::new(), Vec::new());
    for layer in (0..LAYERS).rev() {
        for texel in texels {
            values.push(stored(texel[layer].depth()).map(|value| value as f32));
            opacities.push(texel[layer].opacity() as f32);
        }
    }
    let values = gpu.buffer_of("values", &values, Usage::STORAGE);
    let opacities = gpu.buffer_of("opacities", &opacities, Usage::STORAGE);
    let targets =
        [0, 1].map(|_| gpu.texture(format, (SIDE, SIDE), 1, 1, Uses::RENDER_ATTACHMENT | Uses::COPY_SRC));
    let views = [0, 1].map(|i| targets[i].create_view(&Default::default()));
    let far = stored(1.0);
    let attachment = |i: usize| {
        let clear = wgpu::Color { r: far[2 * i], g: far[2 * i + 1], b: 0.0, a: 0.0 };
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store };
        Some(wgpu::RenderPassColorAttachment {
            view: &views[i],
            depth_slice: None,
            resolve_target: None,
            ops,
        })
    };
    let pipeline = pipeline(gpu, format);
    let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: values.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: opacities.as_entire_binding() },
        ],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let attachments = [attachment(0), attachment(1)];
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &attachments,
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.draw(0..3, 0..LAYERS as u32);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let [first, second] = [0, 1].map(|i| gpu.read_texture::<[u16; 2]>(&targets[i]));
    let pairs = first?.into_iter().zip(second?);
    Ok(pairs.map(|([a, b], [c, d])| [a, b, c, d]).collect())
}

fn pipeline(gpu: &GraphicsDevice, format: Format) -> wgpu::RenderPipeline {
    let module = gpu.shader(include_str!("blending.wgsl"));
    let over = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::SrcAlpha,
        dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
        operation: wgpu::BlendOperation::Add,
    };
    let target = Some(wgpu::ColorTargetState {
        format,
        blend: Some(wgpu::BlendState { color: over, alpha: over }),
        write_mask: wgpu::ColorWrites::ALL,
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("everywhere"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("blend"),
            compilation_options: Default::default(),
            targets: &[target.clone(), target],
        }),
        multiview_mask: None,
        cache: None,
    })
}
