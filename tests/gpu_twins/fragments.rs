//! Inputs of shaders: filtered shadow maps at fragments of the procedural scenes, and kernels that are hard.

use std::sync::OnceLock;

use scenes::load_scene;
use shadow_filtering::{ChannelMap, DepthMap, Kernel, Receiver, Technique, filter};
use shadow_renderer::{Backend, ShadowMapStack, render_stack};

/// Fragments that every technique is compared on, at least.
pub const FRAGMENTS: usize = 100_000;

const SIZE: u32 = 256;

/// Filtered values and z_f, one after another.
pub struct Inputs {
    pub values: Vec<f32>,
    each: usize,
}

impl Inputs {
    pub fn count(&self) -> usize {
        self.values.len() / self.each
    }

    /// Light-facing entries of one view of each procedural scene.
    pub fn of_scenes(technique: &Technique) -> Self {
        let kernel = Kernel::gaussian(9, 2.4).unwrap();
        let mut values = Vec::new();
        for stack in stacks() {
            let filtered = filter(&encoded(&depth_map(stack), technique), &kernel);
            for y in 0..SIZE {
                for x in 0..SIZE {
                    for layer in stack.layers(x, y).filter(|layer| layer.light_facing) {
                        values.extend_from_slice(filtered.texel(x as usize, y as usize));
                        values.push(layer.depth);
                    }
                }
            }
        }
        Self { values, each: technique.channels() + 1 }
    }

    /// Kernels of one and two depths and of moments that no distribution has, with z_f on, beside and between them.
    pub fn degenerate(technique: &Technique) -> Self {
        let channels = technique.channels();
        let vector = |depth: f32| {
            let mut b = vec![0.0; channels];
            technique.evaluate(depth, &mut b);
            b
        };
        let mut values = Vec::new();
        let depths = [0.0, 1e-4, 0.2, 0.5, 0.500001, 0.75, 0.9999, 1.0];
        for (i, &one) in depths.iter().enumerate() {
            for &other in &depths[i..] {
                for share in [0.0, 1.0 / 1024.0, 0.25, 0.5] {
                    let (a, b) = (vector(one), vector(other));
                    for shift in [0.0, 1e-6, -1e-6] {
                        for z_f in [one, other, 0.5 * (one + other), one + 1e-5, other - 1e-5, 0.0, 1.0] {
                            let mixed = a.iter().zip(&b).enumerate();
                            values.extend(mixed.map(|(k, (a, b))| {
                                // Rounding noise with alternating signs leaves the set of moments.
                                let noise = if k % 2 == 0 { shift } else { -shift };
                                ((1.0 - share) * a + share * b) * (1.0 + noise)
                            }));
                            values.push(f32::clamp(z_f, 0.0, 1.0));
                        }
                    }
                }
            }
        }
        Self { values, each: channels + 1 }
    }
}

/// Without a bias most taps would compare a surface with its own plane, equal but for rounding.
const BIAS: f32 = 0.001;

/// Shadow maps with their light-facing entries, moved towards the light by a bias.
pub fn receivers() -> Vec<(DepthMap, Vec<Receiver>)> {
    let of = |stack: &ShadowMapStack| {
        let mut receivers = Vec::new();
        for y in 0..SIZE {
            for x in 0..SIZE {
                let layers = stack.layers(x, y).filter(|layer| layer.light_facing);
                receivers.extend(layers.map(|layer| Receiver {
                    x: x as usize,
                    y: y as usize,
                    depth: f64::from(layer.depth - BIAS),
                    gradient: layer.gradient.map(f64::from),
                }));
            }
        }
        (depth_map(stack), receivers)
    };
    stacks().iter().map(of).collect()
}

/// F with a plane limit of 0.05 and no bias, all of it in single precision.
pub fn percentage_closer_single(map: &DepthMap, kernel: &Kernel, at: &Receiver) -> f32 {
    let gradient = at.gradient.map(|slope| slope as f32);
    let mut total = 0.0f32;
    let radius = kernel.radius() as isize;
    for (j, &v) in (-radius..).zip(kernel.weights()) {
        let mut line = 0.0f32;
        for (i, &w) in (-radius..).zip(kernel.weights()) {
            let across = gradient[0] * i as f32 + gradient[1] * j as f32;
            let compared = at.depth as f32 + across.clamp(-0.05, 0.05);
            if map.at(at.x as isize + i, at.y as isize + j) < compared {
                line += w as f32;
            }
        }
        total += v as f32 * line;
    }
    total.min(1.0)
}

/// Depths of the scenes, and what is special.
pub fn depths() -> Vec<f32> {
    let special = [0.0, 1.0, 0.5, 0.25, 0.75, 1e-7, 0.999_999_94, -0.5, 2.0];
    stacks().iter().flat_map(|stack| stack.depths.iter().copied()).chain(special).collect()
}

fn encoded(map: &DepthMap, technique: &Technique) -> ChannelMap<f32> {
    let channels = technique.channels();
    let mut data = vec![0.0; map.depths().len() * channels];
    for (texel, &depth) in data.chunks_exact_mut(channels).zip(map.depths()) {
        technique.evaluate(depth, texel);
    }
    ChannelMap::new(map.width(), map.height(), channels, data).unwrap()
}

fn depth_map(stack: &ShadowMapStack) -> DepthMap {
    let depths = stack.shadow_map().into_iter().map(|depth| depth.unwrap_or(1.0)).collect();
    DepthMap::new(SIZE as usize, SIZE as usize, depths).unwrap()
}

fn stacks() -> &'static [ShadowMapStack] {
    static STACKS: OnceLock<Vec<ShadowMapStack>> = OnceLock::new();
    STACKS.get_or_init(|| {
        [("stairs", "oblique"), ("village", "long"), ("grove", "grazing")]
            .map(|(name, view)| {
                let scene = load_scene(name).unwrap();
                let light = scene.views.iter().find(|light| light.name == view).unwrap();
                render_stack(&scene, light.direction, SIZE, SIZE, Backend::Cpu).unwrap().0
            })
            .into()
    })
}
