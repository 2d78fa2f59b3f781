//! What users get wrong: a typed error with one clear line, never a panic.

use libtest_mimic::{Failed, Trial};
use scenes::*;
use shadow_renderer::*;

use crate::scenes::{SLANTED, ground, scene_of};

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("bad_input::errors", errors),
        Trial::test("bad_input::too_many_fragments", too_many_fragments),
        Trial::test("bad_input::edge_on_scene", edge_on_scene),
    ]
}

fn errors() -> Result<(), Failed> {
    let good = scene_of(&ground(1.0, 0.0));
    let edited = |edit: &dyn Fn(&mut Scene)| {
        let mut scene = good.clone();
        edit(&mut scene);
        scene
    };
    let error = |scene: &Scene, direction, width, height| {
        let error = render_stack(scene, direction, width, height, Backend::Cpu).expect_err("must fail");
        let message = error.to_string();
        assert!(!message.is_empty() && !message.contains('\n'), "{message:?}");
        error
    };
    for direction in [[0.0; 3], [f32::NAN, 1.0, 0.0], [0.0, f32::INFINITY, 0.0]] {
        assert!(matches!(error(&good, direction, 64, 64), RenderError::LightDirection(_)));
    }
    for (width, height) in [(0, 64), (64, 0), (8193, 64), (u32::MAX, u32::MAX)] {
        assert!(matches!(error(&good, SLANTED, width, height), RenderError::MapSize { .. }));
    }
    let empty = edited(&|s| {
        s.triangles.clear();
        s.triangle_material.clear();
    });
    assert!(matches!(error(&empty, SLANTED, 64, 64), RenderError::Scene(InvalidScene::Empty(_))));
    let leaf = |width, height, texels| {
        let mask = AlphaMask { width, height, alpha: vec![255; texels], cutoff: 1 };
        move |s: &mut Scene| s.materials[0].mask = Some(mask.clone().into())
    };
    type Edit<'a> = &'a dyn Fn(&mut Scene);
    let inconsistent: [(&str, Edit); 9] = [
        ("vertex index", &|s| s.triangles[1][2] = 99),
        ("material index", &|s| s.triangle_material[0] = 1),
        ("material list", &|s| s.triangle_material.truncate(1)),
        ("nan position", &|s| s.vertices[3].position[1] = f32::NAN),
        ("infinite position", &|s| s.vertices[0].position[0] = f32::NEG_INFINITY),
        ("mask without texels", &leaf(0, 4, 0)),
        ("mask with missing texels", &leaf(4, 4, 15)),
        ("mask too wide", &leaf(1 << 16, 1, 1 << 16)),
        ("nan uv", &|s| {
            leaf(1, 1, 1)(s);
            s.vertices[0].uv[1] = f32::NAN;
        }),
    ];
    for (name, edit) in inconsistent {
        let found = error(&edited(edit), SLANTED, 64, 64);
        assert!(matches!(found, RenderError::Scene(InvalidScene::Inconsistent { .. })), "{name}: {found}");
    }
    let mut frame = LightFrame::fit(&good, SLANTED, 64, 64)?;
    frame.texels_per_unit[1] *= 1e6;
    let far = render_in_frame(&good, &frame, Backend::Cpu);
    assert!(matches!(far, Err(RenderError::GuardBand { .. })));
    // Extreme, but valid.
    for scale in [1e-38f32, 1e-20, 1e20, 1e38] {
        let scene =
            edited(&|s| s.vertices.iter_mut().for_each(|v| v.position = v.position.map(|c| c * scale)));
        let (stack, _) = render_stack(&scene, [1e-30, -3e-30, 0.0], 64, 64, Backend::Cpu)?;
        stack.validate()?;
        assert!(stack.fragments() > 500, "scale {scale}");
    }
    Ok(())
}

/// 70 full layers of 8192^2 are 4.7e9 fragments: refused by estimate, before anything of that size is allocated.
fn too_many_fragments() -> Result<(), Failed> {
    let layers: Vec<_> = (0..70).flat_map(|i| ground(1.0, 0.001 * i as f32)).collect();
    let error =
        render_stack(&scene_of(&layers), [0.0, -1.0, 0.0], 8192, 8192, Backend::Cpu).expect_err("must fail");
    assert!(
        matches!(error, RenderError::TooManyFragments { .. } | RenderError::OutOfMemory { .. }),
        "{error}"
    );
    Ok(())
}

/// All triangles seen edge-on: no fragments, no error, and the report says where the triangles went.
fn edge_on_scene() -> Result<(), Failed> {
    let (stack, report) = render_stack(&scene_of(&ground(1.0, 0.0)), [1.0, 0.0, 0.0], 64, 64, Backend::Cpu)?;
    stack.validate()?;
    assert_eq!((stack.fragments(), report.degenerate_triangles), (0, 2));
    assert_eq!(stack.layer_statistics(), LayerStatistics::default());
    Ok(())
}
