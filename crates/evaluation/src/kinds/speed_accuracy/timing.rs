//! Timings on one thread: technique after technique in each round, so that a machine that slows down slows all alike.

use super::candidate::Candidate;
use super::records::SpeedSample;
use super::scenery::{SceneView, SpeedPlan};
use crate::error::EvaluationError;
use crate::timing::alone;
use shadow_filtering::{FilteringError, Kernel, encode, filter};
use std::hint::black_box;
use std::time::Instant;

/// Filtered samples and depths of fragments, in both precisions.
struct Inputs {
    /// Stored values after filtering.
    single: Vec<f32>,
    double: Vec<f64>,
    depths: Vec<f32>,
}

/// Filters the map of the first view and shades some of its fragments.
pub(crate) fn time(
    plan: &SpeedPlan<'_>,
    view: &SceneView,
    sample: &[u32],
) -> Result<Vec<SpeedSample>, EvaluationError> {
    let settings = plan.experiment.timing;
    let fragments = &sample[..sample.len().min(settings.fragments)];
    let mut samples = Vec::new();
    let filtering = |error: FilteringError| EvaluationError::Value(format!("timing: {error}"));
    alone(|| {
        for repetition in 0..settings.repetitions {
            for (index, candidate) in plan.candidates.iter().enumerate() {
                // Double precision does not depend on the format.
                let is_first = !plan.candidates[..index].iter().any(|other| other.name == candidate.name);
                let mut push = |precision: &str, stage: &str, items: usize, begin: Instant| {
                    samples.push(SpeedSample {
                        technique: candidate.name.clone(),
                        format: candidate.format.clone(),
                        precision: precision.to_owned(),
                        stage: stage.to_owned(),
                        repetition,
                        items,
                        time_ns: u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX),
                    });
                };
                let texels = view.map.depths().len();
                let begin = Instant::now();
                let filtered = candidate.technique().filtered(&view.map, &plan.kernel).map_err(filtering)?;
                push("f32", "filter", texels, begin);
                let mut inputs = Inputs { single: Vec::new(), double: Vec::new(), depths: Vec::new() };
                for &fragment in fragments {
                    let receiver = &view.receivers[fragment as usize];
                    inputs.single.extend_from_slice(filtered.texel(receiver.x, receiver.y));
                    inputs.depths.push(receiver.depth as f32);
                }
                let begin = Instant::now();
                shade_single(candidate, &inputs);
                push("f32", "shade", fragments.len(), begin);
                if is_first {
                    let begin = Instant::now();
                    inputs.double = double(candidate, view, &plan.kernel, fragments).map_err(filtering)?;
                    push("f64", "filter", texels, begin);
                    let begin = Instant::now();
                    shade_double(candidate, &inputs);
                    push("f64", "shade", fragments.len(), begin);
                }
            }
        }
        Ok(samples)
    })
}

fn double(
    candidate: &Candidate,
    view: &SceneView,
    kernel: &Kernel,
    fragments: &[u32],
) -> Result<Vec<f64>, FilteringError> {
    let filtered = filter(&encode::<f64>(&view.map, candidate.technique())?, kernel);
    let mut values = Vec::new();
    for &fragment in fragments {
        let receiver = &view.receivers[fragment as usize];
        values.extend_from_slice(filtered.texel(receiver.x, receiver.y));
    }
    Ok(values)
}

fn shade_single(candidate: &Candidate, inputs: &Inputs) {
    let channels = candidate.channels();
    let mut moments = vec![0.0f32; channels];
    for (sample, &depth) in inputs.single.chunks_exact(channels).zip(&inputs.depths) {
        candidate.technique().restore(sample, &mut moments);
        black_box(candidate.bounds(&moments, 0, depth));
    }
}

fn shade_double(candidate: &Candidate, inputs: &Inputs) {
    let technique = candidate.technique();
    for (b, &depth) in inputs.double.chunks_exact(candidate.channels()).zip(&inputs.depths) {
        // Closed forms always have an answer.
        let _ = black_box(technique.shade(b, f64::from(depth)));
    }
}
