//! Depth maps of the raster pipeline against layer 0 of the stack.

use libtest_mimic::Failed;
use shadow_renderer::*;

use crate::scenes::{Random, SLANTED, ground, masked, scene_of, soup};

/// One sample a texel is layer 0, up to the hardware's freedom at edges.
pub fn single_sample_is_layer_0() -> Result<(), Failed> {
    let random = &mut Random(31);
    let solid = scene_of(&soup(800, random));
    let leaves = masked(scene_of(&soup(300, random)), 8, 8, random);
    for (scene, share) in [(solid, 0.002), (leaves, 0.02)] {
        let (stack, report) = render_stack(&scene, SLANTED, 150, 130, Backend::Cpu)?;
        let map = DepthMap::render(&scene, &report.frame, Sampling::Single)?;
        assert_eq!((map.width, map.height, map.samples, map.depths.len()), (150, 130, 1, 150 * 130));
        let expected = stack.shadow_map().into_iter().map(|d| d.unwrap_or(1.0));
        let different =
            map.depths.iter().zip(expected).filter(|(found, e)| (**found - e).abs() > 1e-3).count();
        assert!((different as f64) < share * map.depths.len() as f64, "{different} texels differ");
    }
    Ok(())
}

/// On a plane, samples lie on the plane at their positions, and the outline is covered in part.
pub fn several_samples() -> Result<(), Failed> {
    let scene = scene_of(&ground(1.0, 0.0));
    let (stack, report) = render_stack(&scene, SLANTED, 64, 64, Backend::Cpu)?;
    for (sampling, samples) in [(Sampling::Multisample4, 4), (Sampling::Supersample8, 8)] {
        let map = DepthMap::render(&scene, &report.frame, sampling)?;
        assert_eq!((map.samples, map.depths.len()), (samples, 64 * 64 * samples as usize));
        let (mut inside, mut partly) = (0, 0);
        for (texel, depths) in map.depths.chunks(samples as usize).enumerate() {
            let hit = depths.iter().filter(|d| **d < 1.0).count();
            partly += usize::from(hit > 0 && hit < samples as usize);
            let Some(centre) = stack.layers(texel as u32 % 64, texel as u32 / 64).next() else { continue };
            if hit < samples as usize {
                continue;
            }
            inside += 1;
            let at = |s: usize| match sampling {
                Sampling::Supersample8 => {
                    let [dx, dy] = SUPERSAMPLE_8[s];
                    centre.depth + dx * centre.gradient[0] + dy * centre.gradient[1]
                }
                // The hardware's positions are its own business, but their mean is the centre.
                _ => centre.depth,
            };
            let error = if samples == 8 {
                (0..8).map(|s| (depths[s] - at(s)).abs()).fold(0.0, f32::max)
            } else {
                (depths.iter().sum::<f32>() / 4.0 - at(0)).abs()
            };
            assert!(error < 1e-5, "{sampling:?}, texel {texel}: {depths:?} around {}", centre.depth);
        }
        assert!(inside > 500 && partly > 50, "{sampling:?}: {inside} inside, {partly} partly covered");
    }
    Ok(())
}
