//! Seconds to find the best transform of each order, and its bound.

#![allow(missing_docs)]

use criterion::{Criterion, criterion_group, criterion_main};
use moment_problem::Basis;
use quantization::{DepthInterval, Search, optimise};
use std::hint::black_box;

fn orders(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("optimise");
    group.sample_size(10);
    for order in [2, 3, 4, 5, 6] {
        let basis = Basis::power(order);
        group.bench_function(format!("order {order}"), |bencher| {
            bencher.iter(|| black_box(optimise(&basis, DepthInterval::UNIT, &Search::default())))
        });
    }
    group.finish();
}

criterion_group!(benches, orders);
criterion_main!(benches);
