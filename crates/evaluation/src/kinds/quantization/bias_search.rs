//! Error and validity of one way to store moments as functions of the moment bias.

use super::records::{BiasRecord, QuantizationRecord};
use super::settings::{BiasTarget, QuantizationExperiment};
use super::stored_technique::StoredTechnique;
use super::workload::StoredView;
use crate::error::EvaluationError;
use crate::fragments::spread;
use crate::statistics::{NOTHING, Sums, percentile, rounded};
use moment_problem::Basis;
use quantization::bias::{Target, fastest, smallest_alpha};
use quantization::{DepthInterval, MomentMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shadow_filtering::{FilteringError, Kernel, Position, Receiver, ShadowBound, TechniqueSpec};

/// Steps of the search between two biases of the scale: narrows them to a thousandth of their distance.
const GOLDEN_STEPS: usize = 14;

/// Most moments of a bound.
const MAX_MOMENTS: usize = 8;

/// Everything about the fragments that does not depend on how moments are stored, view by view in one list.
pub(crate) struct Fragments<'a> {
    pub(crate) views: &'a [StoredView],
    /// F.
    pub(crate) reference: Vec<f64>,
    /// F_Z at the depth that techniques compare, without a receiver plane: what no lower bound exceeds.
    pub(crate) plain: Vec<f64>,
    depths: Vec<f64>,
}

/// A way to store moments on all fragments.
pub(crate) struct Evaluated {
    pub(crate) records: Vec<QuantizationRecord>,
    pub(crate) biases: Vec<BiasRecord>,
    /// Filtered texels of all fragments.
    pub(crate) texels: Vec<f64>,
    /// At the b* and alpha of least error.
    pub(crate) best: Option<Best>,
}

/// Where the error is least.
#[derive(Clone, Deserialize, Serialize)]
pub(crate) struct Best {
    pub(crate) target: BiasTarget,
    pub(crate) alpha: f64,
    /// |G - F| of all fragments, view by view.
    pub(crate) errors: Vec<f32>,
}

/// All fragments at one bias.
#[derive(Default)]
struct Means {
    sums: Sums,
    /// Mean of |G - F|.
    l1: f64,
    change: f64,
    excess: f64,
}

/// One step of an 8-bit image: G above F_Z by more is a visible false shadow.
const VISIBLE: f64 = 1.0 / 255.0;

impl<'a> Fragments<'a> {
    pub(crate) fn new(views: &'a [StoredView], kernel: &Kernel) -> Self {
        let all = |of: &dyn Fn(&StoredView) -> Vec<f64>| views.iter().flat_map(of).collect();
        Self {
            views,
            reference: all(&|view| view.reference(kernel)),
            plain: all(&|view| view.plain(kernel)),
            depths: all(&|view| view.depths.clone()),
        }
    }

    fn means(&self, exact: &[f32], intensities: &[f32]) -> Means {
        let n = intensities.len().max(1) as f64;
        let mut means = Means::default();
        for (i, &g) in intensities.iter().enumerate() {
            let g = f64::from(g);
            means.sums.push((g - self.reference[i]) as f32, self.reference[i] as f32);
            means.change += (g - f64::from(exact[i])).abs() / n;
            means.excess += f64::from(u8::from(g > self.plain[i] + VISIBLE)) / n;
        }
        means.l1 = means.sums.mean();
        means
    }

    fn errors(&self, intensities: &[f32]) -> Vec<f32> {
        intensities.iter().zip(&self.reference).map(|(&g, f)| (f64::from(g) - f).abs() as f32).collect()
    }
}

/// Stores, filters and restores the moments of all fragments: texels and moments, a row each.
fn restored(
    variant: &StoredTechnique,
    views: &[StoredView],
) -> Result<(Vec<f64>, Vec<f64>), EvaluationError> {
    let fail = |error: FilteringError| EvaluationError::Value(error.to_string());
    let technique = &variant.technique;
    let m = technique.channels();
    let (mut texels, mut moments) = (Vec::new(), Vec::new());
    for view in views {
        let field = technique.kernel_field(&view.map, &variant.kernel).map_err(fail)?;
        let first = texels.len();
        texels.resize(first + view.receivers.len() * m, 0.0);
        moments.resize(texels.len(), 0.0);
        let rows = texels[first..].par_chunks_mut(m).zip(moments[first..].par_chunks_mut(m));
        rows.zip(&view.receivers)
            .try_for_each(|((texel, b), receiver)| {
                field.mean(Position::of_texel(receiver.x, receiver.y), texel)?;
                technique.restore(texel, b);
                Ok(())
            })
            .map_err(fail)?;
    }
    Ok((texels, moments))
}

/// Moments of kernels before storage: these lie on the boundary of the valid set, or near it.
fn workload(variant: &StoredTechnique, views: &[StoredView], wanted: usize) -> Vec<Vec<f64>> {
    let all: Vec<_> =
        views.iter().flat_map(|view| view.receivers.iter().map(move |receiver| (view, receiver))).collect();
    let basis = variant.bound().basis();
    let interval = variant.range.interval();
    let chosen = spread(all.len(), wanted);
    let of = |(view, receiver): &(&StoredView, &Receiver)| {
        let z = variant.kernel.distribution(&view.map, receiver.x, receiver.y);
        let depths: Vec<f64> = z.depths().iter().map(|&z| interval.at(2.0 * z - 1.0)).collect();
        let weights: Vec<f64> = z.weights().iter().map(|w| w.to_f64()).collect();
        Target::new(&basis, &depths, &weights).moments
    };
    chosen.into_par_iter().map(|i| of(&all[i])).collect()
}

/// A b* well inside of the valid set of any basis: depths as the zeros of a Chebyshev polynomial.
fn centre(basis: &Basis, interval: DepthInterval) -> Target {
    const DEPTHS: usize = 32;
    let angle = |i: usize| std::f64::consts::PI * (i as f64 + 0.5) / DEPTHS as f64;
    let depths: Vec<f64> = (0..DEPTHS).map(|i| interval.at(angle(i).cos())).collect();
    Target::new(basis, &depths, &[1.0 / DEPTHS as f64; DEPTHS])
}

/// Alphas that all restored moments need, ascending.
fn needed(matrix: &MomentMatrix, moments: &[f64], b_star: &[f64]) -> Vec<f64> {
    let mut needed: Vec<f64> =
        moments.par_chunks(matrix.order()).map(|b| smallest_alpha(matrix, b, b_star)).collect();
    needed.sort_by(f64::total_cmp);
    needed
}

/// Evaluates a way to store moments; `exact` is G without quantisation.
pub(crate) fn evaluate(
    experiment: &QuantizationExperiment,
    variant: &StoredTechnique,
    fragments: &Fragments<'_>,
    exact: &[f32],
) -> Result<Evaluated, EvaluationError> {
    let (texels, moments) = restored(variant, fragments.views)?;
    let basis = variant.bound().basis();
    let interval = variant.range.interval();
    let fail = |error: quantization::QuantizationError| EvaluationError::Value(error.to_string());
    let matrix = MomentMatrix::new(&basis).map_err(fail)?;
    let mut evaluated = Evaluated { records: Vec::new(), biases: Vec::new(), texels, best: None };
    let mut least = f64::INFINITY;
    for &target in &variant.targets {
        let circulated = variant.circulated().filter(|_| target == BiasTarget::Circulated);
        let b_star = match target {
            BiasTarget::Ends => Target::ends(&basis, interval),
            BiasTarget::Fastest => {
                // Where the determinant is to be raised: at the bias that nearly all need.
                let needed = needed(&matrix, &moments, &centre(&basis, interval).moments);
                let alpha = percentile(&needed, NEARLY_ALL);
                let alpha = alpha.clamp(experiment.alphas.from, experiment.alphas.to);
                let workload = workload(variant, fragments.views, experiment.workload);
                fastest(&matrix, &basis, interval, &workload, alpha)
            }
            BiasTarget::Circulated => match circulated {
                Some(c) => Target { moments: c.target.to_vec(), depths: Vec::new(), weights: Vec::new() },
                None => continue,
            },
        };
        let needed = needed(&matrix, &moments, &b_star.moments);
        let failing = |alpha: f64| {
            (needed.len() - needed.partition_point(|&a| a <= alpha)) as f64 / needed.len().max(1) as f64
        };
        let shade = |alpha: f64| intensities(variant, &moments, &b_star.moments, alpha, fragments);
        let means = |alpha: f64| fragments.means(exact, &shade(alpha));
        let row = |role: &str, alpha: f64, means: &Means| QuantizationRecord {
            target: target.name().to_owned(),
            role: role.to_owned(),
            alpha: significant(alpha),
            failure_share: Some(rounded(failing(alpha))),
            ..filled(variant, means)
        };
        let scale = experiment.alphas.values();
        let steps: Vec<Means> = scale.iter().map(|&alpha| means(alpha)).collect();
        evaluated.records.extend(scale.iter().zip(&steps).map(|(&alpha, means)| row("step", alpha, means)));
        let alpha = golden(&scale, &steps, |alpha| means(alpha).l1);
        let best = shade(alpha);
        let at_best = fragments.means(exact, &best);
        evaluated.records.push(row("best", alpha, &at_best));
        let valid_alpha = percentile(&needed, VALID);
        let at_valid = means(valid_alpha);
        evaluated.records.push(row("valid", valid_alpha, &at_valid));
        let at_circulated = circulated.map(|c| (c, means(c.alpha)));
        evaluated.records.extend(at_circulated.iter().map(|(c, means)| row("circulated", c.alpha, means)));
        let numbers = |values: &[f64]| values.iter().map(|v| rounded(*v).to_string()).collect::<Vec<_>>();
        // Depths of a nearly continuous distribution tell nothing.
        let pairs = b_star.depths.iter().zip(&b_star.weights).filter(|_| b_star.depths.len() <= MAX_DEPTHS);
        evaluated.biases.push(BiasRecord {
            bound: variant.bound_name().to_owned(),
            transform: variant.transform.clone(),
            format: variant.format.clone(),
            kernel: variant.kernel_name.clone(),
            target: target.name().to_owned(),
            range: variant.range.name().to_owned(),
            moments: numbers(&b_star.moments).join(" "),
            distribution: pairs.map(|(z, w)| format!("{z}:{}", rounded(*w))).collect::<Vec<_>>().join(" "),
            invalid_unbiased: rounded(failing(0.0)),
            alpha_99: significant(percentile(&needed, NEARLY_ALL)),
            alpha_999: significant(valid_alpha),
            alpha_all: significant(needed.last().copied().unwrap_or_default()),
            valid_l1_error: rounded(at_valid.l1),
            valid_change: rounded(at_valid.change),
            best_alpha: significant(alpha),
            best_l1_error: rounded(at_best.l1),
            best_change: rounded(at_best.change),
            best_excess_share: rounded(at_best.excess),
            best_failure_share: rounded(failing(alpha)),
            circulated_alpha: circulated.map(|c| c.alpha),
            circulated_l1_error: at_circulated.as_ref().map(|(_, means)| rounded(means.l1)),
            circulated_failure_share: circulated.map(|c| rounded(failing(c.alpha))),
            source: circulated.map_or_else(String::new, |c| c.source.to_owned()),
        });
        if at_best.l1 < least {
            least = at_best.l1;
            evaluated.best = Some(Best { target, alpha, errors: fragments.errors(&best) });
        }
    }
    Ok(evaluated)
}

/// Share of the fragments that counts as nearly all.
const NEARLY_ALL: f64 = 0.99;

/// Share of valid vectors that is asked of a bias.
const VALID: f64 = 0.999;

/// Most depths of b* that are recorded.
const MAX_DEPTHS: usize = 16;

/// G with moments in double precision, filtered exactly, and its record.
pub(crate) fn exact(
    variant: &StoredTechnique,
    fragments: &Fragments<'_>,
) -> Result<(Vec<f32>, QuantizationRecord), EvaluationError> {
    let fail = |error: FilteringError| EvaluationError::Value(error.to_string());
    let bound = variant.bound();
    let m = bound.order();
    let technique = TechniqueSpec::from(bound).build().map_err(fail)?;
    let mut intensities = Vec::with_capacity(fragments.depths.len());
    for view in fragments.views {
        let rows = view.receivers.par_iter().zip(&view.depths);
        let of_view: Result<Vec<f32>, _> = rows
            .map(|(receiver, &depth)| {
                let mut sums = [0.0; MAX_MOMENTS];
                let mut values = [0.0; MAX_MOMENTS];
                for (i, j, weight) in variant.kernel.taps() {
                    let z = view.map.at(receiver.x as isize + i, receiver.y as isize + j);
                    technique.evaluate(f64::from(z), &mut values[..m]);
                    sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight * value);
                }
                technique.shade(&sums[..m], depth).map(|g| g as f32)
            })
            .collect();
        intensities.extend(of_view.map_err(fail)?);
    }
    let means = fragments.means(&intensities, &intensities);
    let record = QuantizationRecord {
        transform: "none".to_owned(),
        format: "f64".to_owned(),
        bits_per_texel: 64 * m,
        target: "exact".to_owned(),
        role: "best".to_owned(),
        alpha: bound.double_precision_bias(),
        ..filled(variant, &means)
    };
    Ok((intensities, record))
}

/// Doing nothing, G = 0: every fragment is lit, and nothing is stored.
pub(crate) fn nothing(kernel: &str, fragments: &Fragments<'_>) -> QuantizationRecord {
    let dark = vec![0.0; fragments.depths.len()];
    let Means { sums, l1, .. } = fragments.means(&dark, &dark);
    let none = || "none".to_owned();
    QuantizationRecord {
        bound: NOTHING.to_owned(),
        transform: none(),
        range: none(),
        format: none(),
        kernel: kernel.to_owned(),
        bits_per_texel: 0,
        target: none(),
        role: "nothing".to_owned(),
        alpha: 0.0,
        fragments: sums.count,
        l1_error: rounded(l1),
        standard_error: rounded(sums.standard_error()),
        relative_error: sums.relative_error().map(rounded),
        relative_standard_error: sums.relative_standard_error().map(rounded),
        signed_mean: rounded(-l1),
        change: 0.0,
        excess_share: 0.0,
        failure_share: None,
        error: String::new(),
    }
}

/// What is recorded of a way to store moments that cannot be evaluated: a row with the reason.
pub(crate) fn failed(variant: &StoredTechnique, reason: &EvaluationError) -> Evaluated {
    let record = QuantizationRecord { error: reason.to_string(), ..filled(variant, &Means::default()) };
    Evaluated { records: vec![record], biases: Vec::new(), texels: Vec::new(), best: None }
}

fn filled(variant: &StoredTechnique, means: &Means) -> QuantizationRecord {
    QuantizationRecord {
        bound: variant.bound_name().to_owned(),
        transform: variant.transform.clone(),
        range: variant.range.name().to_owned(),
        format: variant.format.clone(),
        kernel: variant.kernel_name.clone(),
        bits_per_texel: variant.technique.bits_per_texel(),
        target: String::new(),
        role: String::new(),
        alpha: 0.0,
        fragments: means.sums.count,
        l1_error: rounded(means.l1),
        standard_error: rounded(means.sums.standard_error()),
        relative_error: means.sums.relative_error().map(rounded),
        relative_standard_error: means.sums.relative_standard_error().map(rounded),
        signed_mean: rounded(means.sums.signed / means.sums.count.max(1) as f64),
        change: rounded(means.change),
        excess_share: rounded(means.excess),
        failure_share: None,
        error: String::new(),
    }
}

/// G of all fragments under a bias.
fn intensities(
    variant: &StoredTechnique,
    moments: &[f64],
    b_star: &[f64],
    alpha: f64,
    fragments: &Fragments<'_>,
) -> Vec<f32> {
    let bound = variant.biased.with_bias(alpha, b_star);
    let rows = moments.par_chunks(variant.bound().order()).zip(&fragments.depths);
    rows.map(|(b, &depth)| bound.bounds(b, depth).lower as f32).collect()
}

/// An alpha to four digits: more would only make the tables longer.
fn significant(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// The bias of least error: golden sections of ln alpha between the neighbours of the best step.
fn golden(scale: &[f64], steps: &[Means], error: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_8;
    let best = (0..steps.len()).min_by(|&a, &b| steps[a].l1.total_cmp(&steps[b].l1)).unwrap_or_default();
    let mut low = scale[best.saturating_sub(1)].ln();
    let mut high = scale[(best + 1).min(scale.len() - 1)].ln();
    let inner = |low: f64, high: f64| [high - RATIO * (high - low), low + RATIO * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut error_a, mut error_b) = (error(a.exp()), error(b.exp()));
    let mut found = (steps[best].l1, scale[best]);
    for _ in 0..GOLDEN_STEPS {
        for (value, ln) in [(error_a, a), (error_b, b)] {
            if value < found.0 {
                found = (value, ln.exp());
            }
        }
        if error_a < error_b {
            high = b;
            (b, error_b) = (a, error_a);
            a = inner(low, high)[0];
            error_a = error(a.exp());
        } else {
            low = a;
            (a, error_a) = (b, error_b);
            b = inner(low, high)[1];
            error_b = error(b.exp());
        }
    }
    found.1
}
