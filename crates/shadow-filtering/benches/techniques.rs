//! Filter and techniques on a 1024^2 map: noise over a slope under a lattice, so that no branch is ever predictable.

// A panic is how a benchmark reports.
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rayon::prelude::*;
use shadow_filtering::*;
use std::hint::black_box;

const SIZE: usize = 1024;

fn map() -> DepthMap {
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let depths = (0..SIZE * SIZE).map(|t| {
        let (x, y) = (t % SIZE, t / SIZE);
        let ground = 0.6 + 0.3 * (x + y) as f32 / (2 * SIZE) as f32;
        if (x / 7 + y / 5) % 3 == 0 { 0.2 + 0.1 * unit() } else { ground }
    });
    DepthMap::new(SIZE, SIZE, depths.collect()).unwrap()
}

fn built() -> Vec<Technique> {
    let spec = |text: &str| toml::from_str::<TechniqueSpec>(text).unwrap().build().unwrap();
    [
        "bound = 'vsm'",
        "bound = 'esm'\nexponent = 80.0",
        "bound = 'evsm'\nexponent = 10.0\nnegative_exponent = 10.0",
        "bound = 'lvsm'\nlayers = 4",
        "bound = 'csm'\ncoefficients = 4",
        "bound = 'hamburger4'",
        "bound = 'hausdorff4'",
        "bound = 'trigonometric4'",
        "bound = 'hamburger6'",
        "bound = 'hamburger8'",
    ]
    .map(spec)
    .into()
}

/// A fragment a texel.
fn shade_all(technique: &Technique, filtered: &ChannelMap<f64>) -> f64 {
    let row = |y: usize| -> f64 {
        let z_f = |x: usize| ((x * 7 + y * 13) % 1009) as f64 / 1009.0;
        (0..SIZE).map(|x| technique.shade(filtered.texel(x, y), z_f(x)).unwrap()).sum()
    };
    (0..SIZE).into_par_iter().map(row).sum()
}

fn filters(criterion: &mut Criterion) {
    let map = map();
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let mut group = criterion.benchmark_group("filter");
    group.sample_size(10).throughput(Throughput::Elements((SIZE * SIZE) as u64));
    let technique = TechniqueSpec::named("hamburger4").unwrap().build().unwrap();
    let single = encode::<f32>(&map, &technique).unwrap();
    let double = encode::<f64>(&map, &technique).unwrap();
    group.bench_function("4 channels, f32", |b| b.iter(|| filter(black_box(&single), &kernel)));
    group.bench_function("4 channels, f64", |b| b.iter(|| filter(black_box(&double), &kernel)));
    group.finish();
}

fn techniques(criterion: &mut Criterion) {
    let map = map();
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let mut group = criterion.benchmark_group("shade");
    group.sample_size(10).throughput(Throughput::Elements((SIZE * SIZE) as u64));
    for technique in built() {
        let filtered = filter(&encode::<f64>(&map, &technique).unwrap(), &kernel);
        group.bench_function(technique.name(), |b| b.iter(|| shade_all(&technique, &filtered)));
    }
    let percentage_closer = || -> f64 {
        let row = |y: usize| (0..SIZE).map(|x| kernel.percentage_closer(&map, x, y, 0.5)).sum::<f64>();
        (0..SIZE).into_par_iter().map(row).sum()
    };
    group.bench_function("PCF 9x9", |b| b.iter(percentage_closer));
    group.finish();
}

/// Encoding, filtering and shading a million fragments with every closed form, one after the other.
fn together(criterion: &mut Criterion) {
    let map = map();
    let kernel = Kernel::gaussian(9, 2.4).unwrap();
    let techniques = built();
    let mut group = criterion.benchmark_group("1024^2 map, a million fragments");
    group.sample_size(10);
    group.bench_function("all closed forms", |b| {
        b.iter(|| {
            let one = |technique: &Technique| {
                let filtered = filter(&encode::<f64>(&map, technique).unwrap(), &kernel);
                shade_all(technique, &filtered)
            };
            techniques.iter().map(one).sum::<f64>()
        })
    });
    group.finish();
}

criterion_group!(benches, filters, techniques, together);
criterion_main!(benches);
