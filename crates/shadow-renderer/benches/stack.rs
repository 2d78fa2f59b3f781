//! Stack extraction at 1024^2: about 200 k small triangles, 1.5 M fragments, some 25 layers at most.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use shadow_renderer::*;

const DIRECTION: [f32; 3] = [0.3, -0.8, 0.5];

/// Random triangles of a few texels, half of them crowded into a small part of the map.
fn crowd(triangles: u32) -> Scene {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut vertices = Vec::new();
    for triangle in 0..triangles {
        let spread = if triangle % 5 < 3 { 1.0 } else { 0.5 };
        let centre = [0; 3].map(|_| spread * (random() - 0.5));
        for _ in 0..3 {
            let position = centre.map(|c| c + 0.0163 * (random() - 0.5));
            vertices.push(Vertex { position, normal: [0.0, 1.0, 0.0], uv: [0.0; 2] });
        }
    }
    Scene {
        name: "crowd".into(),
        vertices,
        triangles: (0..triangles).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        triangle_material: vec![0; triangles as usize],
        materials: vec![Material { name: "grey".into(), albedo: [0.5; 3], mask: None }],
        views: vec![LightView { name: "sun".into(), direction: DIRECTION }],
        camera: Camera { eye: [2.0; 3], target: [0.0; 3], vertical_fov: 1.0 },
        degenerate_triangles: 0,
    }
}

fn stack(criterion: &mut Criterion) {
    let scene = crowd(200_000);
    let (stack, report) = render_stack(&scene, DIRECTION, 1024, 1024, Backend::Cpu).unwrap();
    let statistics = stack.layer_statistics();
    // A benchmark of the wrong workload is worthless: state what is measured, and refuse anything else.
    eprintln!("{} fragments, {statistics:?}, {:?}", stack.fragments(), report.times);
    assert!((1_400_000..1_600_000).contains(&stack.fragments()) && (20..=30).contains(&statistics.max));
    let mut group = criterion.benchmark_group("stack");
    group.sample_size(20);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        group.bench_function(format!("cpu, {threads} threads"), |b| {
            b.iter(|| pool.install(|| render_stack(&scene, DIRECTION, 1024, 1024, Backend::Cpu).unwrap()))
        });
    }
}

criterion_group!(benches, stack);
criterion_main!(benches);
