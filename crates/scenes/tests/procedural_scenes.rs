//! What the procedural scenes promise: size, closed solids, determinism, and depth complexity, which is
//! counted here by a small rasteriser of its own.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests fail by panicking and may report")]

use std::collections::{HashMap, HashSet};

use scenes::procedural::{DEFAULT_SEED, NAMES};
use scenes::{LightView, Scene, procedural};

/// Texels along each side of the counting grid.
const SIZE: usize = 256;

fn scene(name: &str) -> Scene {
    procedural(name, DEFAULT_SEED).unwrap()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Surfaces along the light through the centre of each texel of a grid that bounds the scene, alpha-tested.
fn surfaces_per_texel(scene: &Scene, view: &LightView) -> Vec<u32> {
    let direction = view.direction.map(f64::from);
    let helper = if direction[1].abs() > 0.99 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let unit = |v: [f64; 3]| v.map(|c| c / dot(v, v).sqrt());
    let u = unit(cross(helper, direction));
    let v = unit(cross(direction, u));
    let projected: Vec<[f64; 2]> = scene
        .vertices
        .iter()
        .map(|vertex| vertex.position.map(f64::from))
        .map(|p| [dot(p, u), dot(p, v)])
        .collect();
    let bound = |axis: usize| {
        projected.iter().fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p[axis]), high.max(p[axis])))
    };
    let bounds = [bound(0), bound(1)];
    let grid: Vec<[f64; 2]> = projected
        .iter()
        .map(|p| {
            [0, 1].map(|axis| (p[axis] - bounds[axis].0) / (bounds[axis].1 - bounds[axis].0) * SIZE as f64)
        })
        .collect();
    let mut counts = vec![0; SIZE * SIZE];
    for (triangle, &material) in scene.triangles.iter().zip(&scene.triangle_material) {
        let corners = triangle.map(|i| grid[i as usize]);
        let uvs = triangle.map(|i| scene.vertices[i as usize].uv.map(f64::from));
        let mask = scene.materials[material as usize].mask.as_deref();
        let edge = |p: [f64; 2], q: [f64; 2], x: [f64; 2]| {
            (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0])
        };
        let area = edge(corners[0], corners[1], corners[2]);
        if area == 0.0 {
            continue;
        }
        let range = |axis: usize| {
            let values = corners.map(|c| c[axis]);
            let low = values.iter().fold(f64::MAX, |a, &b| a.min(b)).floor().max(0.0) as usize;
            let high = values.iter().fold(f64::MIN, |a, &b| a.max(b)).ceil().min(SIZE as f64) as usize;
            low..high
        };
        for y in range(1) {
            for x in range(0) {
                let centre = [x as f64 + 0.5, y as f64 + 0.5];
                let weights = [1, 2, 0].map(|i: usize| edge(corners[i], corners[(i + 1) % 3], centre) / area);
                if weights.iter().any(|&w| w < 0.0) {
                    continue;
                }
                let passes = mask.is_none_or(|mask| {
                    let texel = |axis: usize, size: u32| {
                        let t: f64 = (0..3).map(|i| weights[i] * uvs[i][axis]).sum();
                        ((t.rem_euclid(1.0) * f64::from(size)) as usize).min(size as usize - 1)
                    };
                    let at = texel(1, mask.height) * mask.width as usize + texel(0, mask.width);
                    mask.alpha[at] >= mask.cutoff
                });
                counts[y * SIZE + x] += u32::from(passes);
            }
        }
    }
    counts
}

/// 95th percentile and mean over texels with at least one surface.
fn complexity(scene: &Scene, view: &LightView) -> (u32, f64) {
    let mut counts = surfaces_per_texel(scene, view);
    counts.retain(|&count| count > 0);
    counts.sort_unstable();
    let mean = counts.iter().map(|&c| f64::from(c)).sum::<f64>() / counts.len() as f64;
    (counts[counts.len() * 95 / 100], mean)
}

#[test]
fn every_scene_has_a_view_with_eight_surfaces_at_the_95th_percentile() {
    for name in NAMES {
        let scene = scene(name);
        let measured: Vec<_> = scene
            .views
            .iter()
            .map(|view| {
                let (p95, mean) = complexity(&scene, view);
                (view.name.as_str(), p95, (mean * 100.0).round() / 100.0)
            })
            .collect();
        println!("{name}: {} triangles, (view, p95, mean) {measured:?}", scene.triangles.len());
        assert!(measured.iter().any(|&(_, p95, _)| p95 >= 8), "{name}: {measured:?}");
    }
}

#[test]
fn scenes_have_the_promised_size_and_parts() {
    for name in NAMES {
        let scene = scene(name);
        assert_eq!(scene.name, name);
        assert!((50_000..=300_000).contains(&scene.triangles.len()), "{name}: {}", scene.triangles.len());
        assert_eq!(scene.triangle_material.len(), scene.triangles.len());
        assert_eq!(scene.degenerate_triangles, 0, "{name}");
        assert!(scene.materials.iter().any(|material| material.name == "ground"));
        let names: Vec<_> = scene.views.iter().map(|view| view.name.as_str()).collect();
        assert_eq!(names, ["high", "oblique", "long", "grazing", "wide", "lamp"]);
        let extents: Vec<bool> = scene.views.iter().map(|view| view.light.has_extent()).collect();
        assert_eq!(extents, [false, false, false, false, true, true]);
        assert_eq!(scene.views[5].light.to_string().parse(), Ok(scene.views[5].light));
        for vertex in &scene.vertices {
            assert!(vertex.position.iter().all(|c| c.is_finite()));
            let length: f32 = vertex.normal.iter().map(|c| c * c).sum();
            assert!((length - 1.0).abs() < 1e-5, "{name}: {:?}", vertex.normal);
        }
        let grazing = &scene.views[3].direction;
        assert!(-grazing[1] < 0.12 * grazing[0].hypot(grazing[2]), "{name}: grazing means below 7 degrees");
    }
}

/// Every solid is watertight and outward: each directed edge, by position, is matched by its reverse.
#[test]
fn solids_are_closed() {
    for name in NAMES {
        let scene = scene(name);
        let mut balance: HashMap<_, i32> = HashMap::new();
        for (triangle, &material) in scene.triangles.iter().zip(&scene.triangle_material) {
            let material_name = scene.materials[material as usize].name.as_str();
            if ["ground", "leaf"].contains(&material_name) {
                continue;
            }
            let corners = triangle.map(|i| scene.vertices[i as usize].position.map(f32::to_bits));
            for i in 0..3 {
                let (from, to) = (corners[i], corners[(i + 1) % 3]);
                if from < to {
                    *balance.entry((from, to)).or_default() += 1;
                } else {
                    *balance.entry((to, from)).or_default() -= 1;
                }
            }
        }
        let open = balance.values().filter(|&&b| b != 0).count();
        assert_eq!(open, 0, "{name}: {open} of {} edges are open", balance.len());
    }
}

/// Solids enclose positive volume, so front faces point outward.
#[test]
fn solids_face_outward() {
    for name in NAMES {
        let scene = scene(name);
        let mut volumes: HashMap<u32, f64> = HashMap::new();
        for (triangle, &material) in scene.triangles.iter().zip(&scene.triangle_material) {
            let [a, b, c] = triangle.map(|i| scene.vertices[i as usize].position.map(f64::from));
            *volumes.entry(material).or_default() += dot(a, cross(b, c)) / 6.0;
        }
        for (material, volume) in volumes {
            let material = &scene.materials[material as usize];
            if !["ground", "leaf"].contains(&material.name.as_str()) {
                assert!(volume > 0.0, "{name}: {} encloses {volume}", material.name);
            }
        }
    }
}

#[test]
fn seeds_decide_and_nothing_else_does() {
    for name in NAMES {
        let positions = |seed| -> Vec<[u32; 3]> {
            let scene = procedural(name, seed).unwrap();
            scene.vertices.iter().map(|vertex| vertex.position.map(f32::to_bits)).collect()
        };
        let first = positions(1);
        assert_eq!(first, positions(1), "{name}");
        assert_ne!(first, positions(2), "{name}");
    }
    assert!(procedural("nowhere", 1).is_none());
}

/// Coordinates lie on the grid of 2^-16 that makes them independent of the platform's sine.
#[test]
fn positions_are_platform_independent() {
    let mut hashes = Vec::new();
    for name in NAMES {
        let scene = scene(name);
        let mut distinct = HashSet::new();
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for vertex in &scene.vertices {
            for c in vertex.position {
                assert_eq!((f64::from(c) * 65536.0).fract(), 0.0, "{name}: {c}");
                for byte in c.to_le_bytes() {
                    hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                }
            }
            distinct.insert(vertex.position.map(f32::to_bits));
        }
        assert!(distinct.len() > 20_000, "{name}");
        hashes.push(hash);
    }
    // A change here changes every committed result of a procedural scene.
    assert_eq!(
        hashes,
        [0x46cb_6d4a_7813_243a, 0xaa0b_28cd_06e3_1d49, 0xb1e3_5c50_a13b_bf5d, 0xa91f_7716_4adc_8837],
        "{hashes:#x?}"
    );
}

/// What lets light through stands beside the others: glass is not closed, and needs few triangles.
#[test]
fn smoke_and_glass_let_light_through() {
    for (name, translucent) in [("smoke", 30..=30), ("glasshouse", 400..=1000)] {
        let scene = scene(name);
        assert_eq!(scene.views.len(), 6, "{name}");
        let opacity = |triangle: usize| {
            let material = &scene.materials[scene.triangle_material[triangle] as usize];
            material.opacity.as_ref().map(|opacity| (opacity, material.mask.is_some()))
        };
        let veils: Vec<_> = (0..scene.triangles.len()).filter_map(opacity).collect();
        assert!(translucent.contains(&veils.len()), "{name}: {} triangles", veils.len());
        for (opacity, has_mask) in veils {
            assert_eq!(opacity.fault(), None);
            // Smoke is tested where shadows are not translucent, glass is opaque there.
            assert_eq!(has_mask, opacity.transmission == [0.0; 3], "{name}");
        }
        let mut textures = scene.materials.iter().flat_map(|m| &m.opacity).flat_map(|o| o.textures());
        let is_varied = |alpha: &[u8]| alpha.contains(&0) && alpha.iter().any(|&a| a > 100);
        assert!(textures.all(|texture| is_varied(&texture.alpha)), "{name}");
        let again = procedural(name, DEFAULT_SEED).unwrap();
        assert!(again.vertices == scene.vertices && again.triangles == scene.triangles);
        assert!(
            procedural(name, 7).unwrap().vertices != scene.vertices,
            "{name} does not depend on the seed"
        );
    }
}
