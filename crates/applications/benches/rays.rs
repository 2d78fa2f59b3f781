//! Shadow rays a second on one core: a height field of 200 978 triangles, houses, and trees with masked leaves.

use applications::PlacedLight;
use applications::rays::{LastOccluder, Segment, Triangles};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use random_stream::Random;
use scenes::{Scene, load_scene};
use std::hint::black_box;
use std::time::{Duration, Instant};

const SIDE: usize = 317;

fn height(x: f64, z: f64) -> f64 {
    (1.3 * x).sin() * (0.9 * z).cos() + 0.3 * (5.1 * x + 2.0 * z).sin()
}

fn height_field() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let at = |i: usize| 20.0 * i as f64 / SIDE as f64;
    let vertex = |i: usize| {
        let (x, z) = (at(i % (SIDE + 1)), at(i / (SIDE + 1)));
        [x as f32, height(x, z) as f32, z as f32]
    };
    let square = |i: usize| {
        let a = (i / SIDE * (SIDE + 1) + i % SIDE) as u32;
        let c = a + SIDE as u32 + 1;
        [[a, c, a + 1], [a + 1, c, c + 1]]
    };
    ((0..(SIDE + 1) * (SIDE + 1)).map(vertex).collect(), (0..SIDE * SIDE).flat_map(square).collect())
}

/// From points on the hills to points of a light: low and wide, so that about half of the rays are occluded.
fn rays(positions: &[[f32; 3]], triangles: &[[u32; 3]], count: usize) -> Vec<Segment> {
    let mut random = Random::stream(1, 0);
    let mut rays = Vec::with_capacity(count);
    // 256 rays a receiver, as a soft shadow sends them.
    while rays.len() < count {
        let triangle = (random.unit() * triangles.len() as f64) as u32;
        let corners = triangles[triangle as usize].map(|v| positions[v as usize].map(f64::from));
        let origin = [0, 1, 2].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
        for _ in 0..256 {
            let direction =
                [0.9 + 0.2 * random.unit(), 0.25 + 0.2 * random.unit(), 0.5 + 0.2 * random.unit()];
            rays.push(Segment { origin, direction, endless: true, from: Some(triangle) });
        }
    }
    rays
}

/// From random points of a scene's triangles to its lamp.
fn rays_to_lamp(scene: &Scene, count: usize) -> Vec<Segment> {
    let lamp = scene.views.iter().find(|view| view.name == "lamp").expect("every scene has a lamp");
    let lamp = PlacedLight::new(&lamp.light, [[0.0; 3]; 3]);
    let mut random = Random::stream(2, 0);
    let mut rays = Vec::with_capacity(count);
    while rays.len() < count {
        let triangle = random.below(scene.triangles.len()) as u32;
        let corners = scene.triangles[triangle as usize].map(|v| scene.vertices[v as usize].position);
        let origin = [0, 1, 2].map(|k| corners.iter().map(|corner| f64::from(corner[k]) / 3.0).sum());
        for _ in 0..256 {
            let direction = lamp.towards(origin, [random.unit(), random.unit()]);
            rays.push(Segment { origin, direction, endless: false, from: Some(triangle) });
        }
    }
    rays
}

fn shadow_rays(criterion: &mut Criterion) {
    let (positions, triangles) = height_field();
    let scene = Triangles::new(&positions, &triangles).expect("valid triangles");
    measure(criterion, "hills", &scene, &rays(&positions, &triangles, 1 << 16));
    for name in ["village", "grove"] {
        let scene = load_scene(name).expect("a procedural scene");
        let triangles = Triangles::of_scene(&scene).expect("valid triangles");
        measure(criterion, name, &triangles, &rays_to_lamp(&scene, 1 << 16));
    }
}

fn measure(criterion: &mut Criterion, name: &str, scene: &Triangles, rays: &[Segment]) {
    let occluded = rays.iter().filter(|ray| scene.occludes(ray)).count();
    assert!((rays.len() / 10..rays.len()).contains(&occluded), "{occluded} of {}", rays.len());
    let mut group = criterion.benchmark_group(format!("rays/{name}"));
    group.throughput(Throughput::Elements(rays.len() as u64)).sample_size(20);
    // Each on its own, and in the order in which the truth sends them.
    let alone = || rays.iter().filter(|ray| scene.occludes(black_box(ray))).count();
    let in_order = || {
        let mut last = LastOccluder::default();
        rays.iter().filter(|ray| scene.occludes_again(black_box(ray), &mut last)).count()
    };
    assert_eq!([alone(), in_order()], [occluded; 2]);
    group.bench_function("any_hit", |bencher| bencher.iter_custom(|n| processor_time(n, alone)));
    group.bench_function("any_hit_by_receiver", |bencher| {
        bencher.iter_custom(|n| processor_time(n, in_order))
    });
    group.finish();
}

/// Time that this thread had on a processor, as machines are shared; elapsed time where that is unknown.
fn processor_time(rounds: u64, work: impl Fn() -> usize) -> Duration {
    let start = (thread_time(), Instant::now());
    for _ in 0..rounds {
        black_box(work());
    }
    match (start.0, thread_time()) {
        (Some(before), Some(after)) => after - before,
        _ => start.1.elapsed(),
    }
}

/// The first field of Linux's schedstat counts nanoseconds.
fn thread_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().ok().map(Duration::from_nanos)
}

criterion_group!(benches, shadow_rays);
criterion_main!(benches);
