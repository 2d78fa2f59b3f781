//! Nanoseconds per bound: closed forms in double and single precision, and linear programs.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use moment_problem::arithmetic::FloatFloat;
use moment_problem::hamburger::hamburger;
use moment_problem::hausdorff::hausdorff4;
use moment_problem::trigonometric::trigonometric4;
use moment_problem::{
    Basis, DepthDistribution, ExchangeSimplex, Hamburger, LinearProgram, LowerBound, LpSolver,
};
use std::hint::black_box;

/// Kernels of two to five surfaces with 81 taps, and a fragment depth each.
fn kernels(count: usize) -> Vec<(DepthDistribution, f64)> {
    let mut state = 7u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let surfaces = 2 + (unit() * 4.0) as usize;
            let centres: Vec<f64> = (0..surfaces).map(|_| 0.05 + 0.9 * unit()).collect();
            let depths: Vec<f64> = (0..81).map(|i| centres[i % surfaces] + 0.02 * (unit() - 0.5)).collect();
            let z = DepthDistribution::new(&depths, &[1.0 / 81.0; 81]).expect("a valid kernel");
            (z, unit())
        })
        .collect()
}

fn scalar(criterion: &mut Criterion) {
    let inputs: Vec<([f64; 8], [f64; 4], f64)> = kernels(256)
        .iter()
        .map(|(z, z_f)| {
            let power: Vec<f64> = z.moments(&Basis::power(8));
            let trigonometric: Vec<f64> = z.moments(&Basis::trigonometric(2));
            (std::array::from_fn(|i| power[i]), std::array::from_fn(|i| trigonometric[i]), *z_f)
        })
        .collect();
    let mut group = criterion.benchmark_group("f64 scalar");
    group.throughput(Throughput::Elements(inputs.len() as u64));
    macro_rules! bench {
        ($name:literal, |$b:ident, $t:ident, $z:ident| $body:expr) => {
            group.bench_function($name, |bencher| {
                bencher.iter(|| {
                    for &($b, $t, $z) in &inputs {
                        let _ = ($b, $t);
                        black_box($body);
                    }
                })
            });
        };
    }
    bench!("Chebyshev", |b, t, z| hamburger(&[b[0], b[1]], z));
    bench!("Hamburger 4", |b, t, z| hamburger(&[b[0], b[1], b[2], b[3]], z));
    bench!("Hamburger 6", |b, t, z| hamburger::<f64, 6>(&std::array::from_fn(|i| b[i]), z));
    bench!("Hamburger 8", |b, t, z| hamburger(&b, z));
    bench!("Hausdorff 4", |b, t, z| hausdorff4(&[b[0], b[1], b[2], b[3]], z));
    bench!("trigonometric 4", |b, t, z| trigonometric4(&t, z));
    group.finish();
    single(criterion, &inputs);
}

/// Single floats and pairs of them, bias included: what a graphics processor computes.
fn single(criterion: &mut Criterion, inputs: &[([f64; 8], [f64; 4], f64)]) {
    let mut group = criterion.benchmark_group("single precision");
    group.throughput(Throughput::Elements(inputs.len() as u64));
    let inputs: Vec<([f32; 8], f32)> =
        inputs.iter().map(|(b, _, z)| (b.map(|value| value as f32), *z as f32)).collect();
    macro_rules! bench {
        ($name:literal, $number:ty, |$b:ident, $z:ident| $body:expr) => {
            group.bench_function($name, |bencher| {
                bencher.iter(|| {
                    for &(b, z) in &inputs {
                        let (alpha, half) = (<$number>::from(2e-6f32), <$number>::from(0.5f32));
                        let $b = b.map(|b| <$number>::from(b)).map(|b| b + alpha * (half - b));
                        let $z = <$number>::from(z);
                        black_box($body);
                    }
                })
            });
        };
    }
    bench!("Hamburger 4, f32", f32, |b, z| hamburger(&[b[0], b[1], b[2], b[3]], z));
    bench!("Hamburger 4, pairs", FloatFloat, |b, z| hamburger(&[b[0], b[1], b[2], b[3]], z));
    bench!("Hamburger 6, f32", f32, |b, z| hamburger::<f32, 6>(&std::array::from_fn(|i| b[i]), z));
    bench!("Hamburger 6, pairs", FloatFloat, |b, z| {
        hamburger::<FloatFloat, 6>(&std::array::from_fn(|i| b[i]), z)
    });
    bench!("Hausdorff 4, f32", f32, |b, z| hausdorff4(&[b[0], b[1], b[2], b[3]], z));
    bench!("Hausdorff 4, pairs", FloatFloat, |b, z| hausdorff4(&[b[0], b[1], b[2], b[3]], z));
    group.finish();
}

fn programs(criterion: &mut Criterion) {
    let kernels = kernels(8);
    let basis = Basis::power(4);
    let exchange = ExchangeSimplex::new(&basis).expect("a power basis");
    let clarabel = LinearProgram::with_solver(&basis, LpSolver::Clarabel).expect("a power basis");
    let microlp = LinearProgram::with_solver(&basis, LpSolver::Microlp).expect("a power basis");
    let line = Hamburger::<4>::default();
    let solvers: [(&str, &dyn LowerBound); 4] = [
        ("closed form with certificate", &line),
        ("exchange simplex", &exchange),
        ("clarabel, checked", &clarabel),
        ("microlp, checked", &microlp),
    ];
    let mut group = criterion.benchmark_group("both certified bounds, 4 power moments");
    group.sample_size(10);
    group.throughput(Throughput::Elements(kernels.len() as u64));
    for (name, solver) in solvers {
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                for (z, z_f) in &kernels {
                    let _ = black_box(solver.bounds_of(z, *z_f));
                }
            })
        });
    }
    group.finish();
}

criterion_group!(benches, scalar, programs);
criterion_main!(benches);
