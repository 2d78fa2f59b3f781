//! What a shader holds of a moment vector: transformed, rounded to a texture's format, biased.

use crate::bound::input::{Input, parse_number};
use crate::outcome::Failure;
use anyhow::anyhow;
use moment_problem::{Basis, BoundMethod, MomentError};
use quantization::bias::{Target, biased};
use quantization::published::{self, Published};
use quantization::{
    AffineTransform, DepthInterval, Encoding, NumberFormat, Search, optimise, plain, transform_range,
};
use serde::Serialize;
use std::io::{self, Write};

/// Options of `msm bound` for moments that went through a texture.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Bias: bounds are those of (1 - alpha) b + alpha b* (MSM15 section 4.2), from 0 to 1.
    #[arg(long, allow_hyphen_values = true)]
    alpha: Option<f64>,
    /// b* of the bias, separated by commas; without it the moments of evenly spread depths.
    #[arg(long, allow_hyphen_values = true, value_name = "B1,B2,..")]
    bias_vector: Option<String>,
    /// Round the moments as a texture of this format does: unorm16, f16, f32 or unorm10.
    #[arg(long, value_name = "FORMAT")]
    storage: Option<NumberFormat>,
    /// Stored is the transform of the moments: identity, plain (each function stretched to [0, 1]), optimal, or a
    /// published one by its name. Without this identity, or plain where fixed point needs it.
    #[arg(long, value_name = "NAME", requires = "storage")]
    transform: Option<String>,
}

/// What is bounded in place of the moments given.
#[derive(Serialize)]
pub(crate) struct Stored {
    /// Number format, if the moments are rounded.
    #[serde(skip_serializing_if = "Option::is_none")]
    storage: Option<String>,
    /// Name of the transform, if the moments are rounded.
    #[serde(skip_serializing_if = "Option::is_none")]
    transform: Option<String>,
    alpha: f64,
    bias_vector: Vec<f64>,
    /// The rounded, biased moments: what the bounds hold for.
    pub moments: Vec<f64>,
    /// Before the bias.
    #[serde(skip)]
    rounded: Vec<f64>,
}

/// Largest order for which the least bias is sought: each trial is a program, and those of more moments take seconds.
const MOST_MOMENTS_REPAIRED: usize = 8;

/// Halvings of the logarithm of alpha: two digits of it.
const HALVINGS: usize = 14;

/// Depths of b* unless it is given. As many as these lie inside the set of moments of any basis, so that a bias repairs
/// moments that miss the set anywhere; those of the ends of \[0, 1\] (MSM15 section 4.2) lie on its border.
const SPREAD: usize = 64;

impl Arguments {
    /// b*.
    fn bias(&self, basis: &Basis) -> Result<Vec<f64>, Failure> {
        let Some(text) = &self.bias_vector else {
            let depth = |i: usize| (i as f64 + 0.5) / SPREAD as f64;
            let depths: Vec<f64> = (0..SPREAD).map(depth).collect();
            return Ok(Target::new(basis, &depths, &[1.0 / SPREAD as f64; SPREAD]).moments);
        };
        let vector = text.split(',').map(|number| parse_number(number, "--bias-vector"));
        let vector: Vec<f64> = vector.collect::<Result<_, _>>()?;
        let input = |reason: String| Err(Failure::Input(anyhow!("--bias-vector: {reason}")));
        if vector.len() != basis.len() {
            return input(format!("{} numbers given, the basis has {} functions", vector.len(), basis.len()));
        }
        match vector.iter().find(|value| !value.is_finite()) {
            Some(value) => input(format!("{value} is not a finite number")),
            None => Ok(vector),
        }
    }

    /// What the options make of the moments; `None` without any of them.
    pub(crate) fn stored(&self, basis: &Basis, input: &Input) -> Result<Option<Stored>, Failure> {
        if self.alpha.is_none() && self.storage.is_none() && self.bias_vector.is_none() {
            return Ok(None);
        }
        let fail = |reason: String| Failure::Input(anyhow!(reason));
        let alpha = self.alpha.unwrap_or(0.0);
        if !(0.0..=1.0).contains(&alpha) {
            return Err(fail(format!("--alpha {alpha}: a bias lies between 0 and 1")));
        }
        if self.bias_vector.is_some() && self.alpha.is_none() {
            return Err(fail("--bias-vector needs --alpha, its share".to_owned()));
        }
        let bias_vector = self.bias(basis)?;
        let exact = match input {
            Input::Atoms(z) => z.moments(basis),
            Input::Moments(moments) => moments.clone(),
        };
        if exact.len() != basis.len() {
            let error = MomentError::Length { expected: basis.len(), got: exact.len() };
            return Err(Failure::Input(error.into()));
        }
        if let Some(value) = exact.iter().find(|value| !value.is_finite()) {
            return Err(fail(format!("--moments: {value} is not a finite number")));
        }
        let (transform, rounded) = match self.storage {
            None => (None, exact),
            Some(format) => {
                let (name, transform) = self.transform(basis, format)?;
                let encoding = Encoding::new(transform, format);
                let codes = encoding.encode(&exact).map_err(|error| Failure::Input(error.into()))?;
                let decoded = encoding.decode(&codes).map_err(|error| Failure::Input(error.into()))?;
                (Some(name), decoded)
            }
        };
        Ok(Some(Stored {
            storage: self.storage.map(NumberFormat::name),
            transform,
            alpha,
            moments: biased(&rounded, &bias_vector, alpha),
            rounded,
            bias_vector,
        }))
    }

    /// The transform and its name.
    fn transform(&self, basis: &Basis, format: NumberFormat) -> Result<(String, AffineTransform), Failure> {
        let interval = DepthInterval::UNIT;
        let fail = |reason: String| Failure::Input(anyhow!("--transform {reason}"));
        let fixed = match format {
            NumberFormat::Unorm8
            | NumberFormat::Unorm10
            | NumberFormat::Unorm16
            | NumberFormat::U32Fixed { .. } => true,
            NumberFormat::F16 | NumberFormat::F32 => false,
        };
        // A hundredth of a code of 16 bits, which is clamped; matrices as printed leave the box by up to 7e-8.
        const OUTSIDE: f64 = 1.5e-7;
        let fits = |transform: &AffineTransform| {
            let (min, max) = transform_range(basis, interval, transform);
            min >= -OUTSIDE && max <= 1.0 + OUTSIDE
        };
        let identity = AffineTransform::identity(basis.len());
        let name = match self.transform.as_deref() {
            Some(name) => name,
            None if fixed && !fits(&identity) => "plain",
            None => "identity",
        };
        let transform = match name {
            "identity" => identity,
            "plain" => plain(basis, interval).map_err(|error| fail(format!("plain: {error}")))?,
            "optimal" => {
                let found = optimise(basis, interval, &Search { seed: 1, ..Search::default() });
                found
                    .and_then(|found| found.transform_on(interval))
                    .map_err(|error| fail(format!("optimal: {error}")))?
            }
            _ => {
                let Some(published) = Published::named(name) else {
                    let known: Vec<&str> = published::ALL.iter().map(|published| published.name).collect();
                    let known = known.join(", ");
                    return Err(fail(format!("`{name}`: known are identity, plain, optimal, {known}")));
                };
                if basis.power_order() != Some(published.order) || published.interval() != interval {
                    let (order, depths) = (published.order, published.interval());
                    return Err(fail(format!("`{name}` is for power:{order} and depths in {depths}")));
                }
                published.transform().map_err(|error| fail(format!("`{name}`: {error}")))?
            }
        };
        if fixed && !fits(&transform) {
            let (min, max) = transform_range(basis, interval, &transform);
            return Err(fail(format!(
                "{name}: values from {min:.3} to {max:.3} do not fit {format}, which holds 0 to 1"
            )));
        }
        Ok((name.to_owned(), transform))
    }

    /// The least bias that makes a vector that no distribution has one that can be bounded, in words.
    pub(crate) fn repair(
        &self,
        method: &BoundMethod,
        moments: &[f64],
        stored: Option<&Stored>,
        z_f: f64,
        error: &MomentError,
    ) -> Option<String> {
        let (MomentError::Infeasible { .. } | MomentError::NotPositiveDefinite { .. }) = error else {
            return None;
        };
        if moments.len() > MOST_MOMENTS_REPAIRED {
            return Some(format!("no bias is sought for more than {MOST_MOMENTS_REPAIRED} moments"));
        }
        let target = self.bias(method.basis()).ok()?;
        let rounded = stored.map_or(moments, |stored| &stored.rounded);
        let valid = |alpha: f64| method.bounds(&biased(rounded, &target, alpha), z_f).is_ok();
        // The set of moments is convex and holds b*: what a bias repairs, a larger one repairs too.
        let (mut low, mut high) = (quantization::bias::SMALLEST_ALPHA.log10(), 0.0f64);
        let mut power = low.ceil();
        while power < 0.0 && !valid(10f64.powf(power)) {
            (low, power) = (power, power + 1.0);
        }
        if power < 0.0 {
            high = power;
        }
        if high == 0.0 && !valid(0.5) {
            return Some("no bias towards this vector repairs it".to_owned());
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if valid(10f64.powf(middle)) { high = middle } else { low = middle }
        }
        // Two digits, rounded up to what is known to do.
        let alpha = 10f64.powf(high);
        let unit = 10f64.powf(high.floor() - 1.0);
        let alpha = (alpha / unit).ceil() * unit;
        let vector: Vec<String> = target.iter().map(f64::to_string).collect();
        Some(format!("--alpha {alpha:.1e} towards {} repairs it", vector.join(",")))
    }
}

impl Stored {
    /// For people.
    pub(crate) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        if let (Some(format), Some(transform)) = (&self.storage, &self.transform) {
            writeln!(out, "stored   {format}, transform {transform}")?;
        }
        if self.alpha > 0.0 {
            writeln!(out, "bias     alpha {:e} towards {}", self.alpha, list(&self.bias_vector))?;
        }
        writeln!(out, "moments  {}, for which the bounds hold: F may lie outside", list(&self.moments))
    }
}
