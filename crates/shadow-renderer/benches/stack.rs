//! Stack extraction at 1024^2 of synthetic scenes (200 k small triangles, 1.5 M fragments, some 25 layers at most) and of
//! the procedural village (260 k triangles of all sizes), and loading of a large file.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use scenes::*;
use shadow_renderer::*;

const DIRECTION: [f32; 3] = [0.3, -0.8, 0.5];

/// A small generator: the workload must not change with a dependency's version.
struct Random(u64);

impl Random {
    fn signed(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}

fn scene(name: &str, positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Scene {
    let vertex = |position| Vertex { position, normal: [0.0, 1.0, 0.0], uv: [0.0; 2] };
    Scene {
        name: name.into(),
        vertices: positions.into_iter().map(vertex).collect(),
        triangle_material: vec![0; triangles.len()],
        triangles,
        materials: vec![Material::plain("grey", [0.5; 3])],
        views: vec![LightView::directional("sun", DIRECTION)],
        camera: Camera::new([2.0; 3], [0.0; 3], 1.0),
        ..Scene::default()
    }
}

/// Random triangles of a few texels without any order or shared vertex, two fifths of them crowded in the middle:
/// every access to memory is a surprise.
fn soup() -> Scene {
    let mut random = Random(1);
    let mut positions = Vec::new();
    for triangle in 0..200_000u32 {
        let spread = if triangle % 5 < 3 { 0.5 } else { 0.25 };
        let centre = [0; 3].map(|_| spread * random.signed());
        positions.extend([0; 3].map(|_| centre.map(|c| c + 0.0074 * random.signed())));
    }
    scene("soup", positions, (0..200_000).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
}

/// Spheres of 1000 triangles with shared vertices, like meshes from a modeller.
fn spheres() -> Scene {
    let (mut random, rings, sectors) = (Random(2), 20, 25);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for sphere in 0..200 {
        let spread = if sphere % 5 < 3 { 0.5 } else { 0.2 };
        let centre = [0; 3].map(|_| spread * random.signed());
        let first = positions.len() as u32;
        for (ring, sector) in (0..=rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
            let t = std::f32::consts::PI * ring as f32 / rings as f32;
            let p = std::f32::consts::TAU * sector as f32 / sectors as f32;
            let unit = [t.sin() * p.cos(), t.cos(), t.sin() * p.sin()];
            positions.push([0, 1, 2].map(|k| centre[k] + 0.047 * unit[k]));
        }
        for (ring, sector) in (0..rings).flat_map(|r| (0..sectors).map(move |s| (r, s))) {
            let at = |r: u32, s: u32| first + r * sectors + s % sectors;
            let (a, b) = (at(ring, sector), at(ring, sector + 1));
            let (c, d) = (at(ring + 1, sector), at(ring + 1, sector + 1));
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    scene("spheres", positions, triangles)
}

fn stack(criterion: &mut Criterion) {
    for scene in [soup(), spheres()] {
        let (stack, report) = render_stack(&scene, DIRECTION, 1024, 1024, Backend::Cpu).unwrap();
        let statistics = stack.layer_statistics();
        // A benchmark of the wrong workload is worthless: state what is measured, and refuse anything else.
        eprintln!("{}: {} fragments, {statistics:?}, {:?}", scene.name, stack.fragments(), report.times);
        assert_eq!(scene.triangles.len(), 200_000);
        assert!((1_300_000..1_700_000).contains(&stack.fragments()) && (20..=30).contains(&statistics.max));
        let mut group = criterion.benchmark_group("stack");
        group.sample_size(20);
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            group.bench_function(format!("{}, cpu, {threads} threads", scene.name), |b| {
                b.iter(|| pool.install(|| render_stack(&scene, DIRECTION, 1024, 1024, Backend::Cpu).unwrap()))
            });
        }
    }
}

/// Houses, fences and a tower: large and small triangles, few layers here and many there.
fn village(criterion: &mut Criterion) {
    let village = procedural("village", procedural::DEFAULT_SEED).unwrap();
    let mut group = criterion.benchmark_group("stack");
    group.sample_size(20);
    for view in &village.views {
        let render = || render_stack(&village, view.direction, 1024, 1024, Backend::Cpu).unwrap();
        let (stack, report) = render();
        let statistics = stack.layer_statistics();
        eprintln!("village {}: {} fragments, {statistics:?}", view.name, stack.fragments());
        assert!((200_000..300_000).contains(&report.triangles) && stack.fragments() > 1_000_000);
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            group.bench_function(format!("village {}, cpu, {threads} threads", view.name), |b| {
                b.iter(|| pool.install(render))
            });
        }
    }
}

/// The largest public scene, and the procedural ones.
fn load(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("load");
    group.sample_size(20);
    for name in procedural::NAMES {
        group.bench_function(name, |b| b.iter(|| load_scene(name).unwrap()));
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes/kaykit_village.glb");
    if std::path::Path::new(path).is_file() {
        assert!(load_scene(path).unwrap().triangles.len() > 300_000);
        group.bench_function("kaykit_village.glb", |b| b.iter(|| load_scene(path).unwrap()));
    } else {
        eprintln!("skipped: {path} is not here");
    }
}

criterion_group!(benches, stack, village, load);
criterion_main!(benches);
