//! The comment at the head of a file: what it is, where its numbers come from, and how good it was measured to be.

use super::applications;
use super::language::Language;
use super::preset::{Preset, RUN};
use crate::outcome::Failure;
use serde::Serialize;

/// Longest line of a comment.
const WIDTH: usize = 110;

/// What was chosen, for JSON.
#[derive(Serialize)]
pub(super) struct Facts {
    name: String,
    format: String,
    bits_per_texel: usize,
    channels: usize,
    transform: String,
    /// Bits that the transform gains over storing the functions as they are.
    gain_bits: Option<f64>,
    alpha: Option<f64>,
    alpha_reason: String,
    beta: f64,
    leak_reduction: f64,
    bias_texels: f64,
    bias_slopes: f64,
    /// Recorded mean distance from percentage-closer filtering; absent where this combination was not recorded.
    l1_error: Option<f64>,
    standard_error: Option<f64>,
    /// The run that it comes from.
    run: Option<String>,
}

impl Facts {
    pub(super) fn of(preset: &Preset) -> Self {
        let measured = preset.measured.as_ref();
        Self {
            name: preset.technique.name(),
            format: preset.format_name(),
            bits_per_texel: preset.technique.bits_per_texel(),
            channels: preset.technique.channels(),
            transform: preset.spec.transform().to_owned(),
            gain_bits: gain(preset),
            alpha: preset.spec.alpha,
            alpha_reason: preset.why.clone(),
            beta: preset.spec.beta,
            leak_reduction: preset.leak_reduction,
            bias_texels: preset.bias.texels,
            bias_slopes: preset.bias.slopes,
            l1_error: measured.map(|row| row.l1_error),
            standard_error: measured.and_then(|row| row.standard_error),
            run: measured.map(|_| RUN.to_owned()),
        }
    }
}

fn gain(preset: &Preset) -> Option<f64> {
    preset.published().and_then(|published| published.gain_bits().ok())
}

/// Lines of keys and values, wrapped.
struct Comment {
    text: String,
}

impl Comment {
    fn line(&mut self, key: &str, value: &str) {
        let mut line = format!("// {key:<11}");
        for word in value.split_whitespace() {
            if line.len() + word.len() > WIDTH {
                self.text += line.trim_end();
                self.text.push('\n');
                line = format!("// {:<11}", "");
            }
            line += word;
            line.push(' ');
        }
        self.text += line.trim_end();
        self.text.push('\n');
    }
}

/// Of a technique; `stage` is empty for all of it.
pub(super) fn of_technique(preset: &Preset, language: Language, stage: &str) -> String {
    let technique = &preset.technique;
    let mut comment = Comment { text: String::new() };
    let part = if stage.is_empty() { String::new() } else { format!(", {stage} only") };
    comment.line(
        &preset.key,
        &format!(
            "{} in {}, {} bits a texel{part}; written by `msm shader {} --format {} --language {}`",
            technique.name(),
            preset.format_name(),
            technique.bits_per_texel(),
            preset.key,
            preset.format_name(),
            language.name(),
        ),
    );
    if let Some(bound) = preset.spec.bound {
        comment.line("equations", bound.equations());
    }
    comment.line("stored", &stored(preset));
    if let Some(alpha) = preset.spec.alpha {
        comment.line("alpha", &format!("{alpha:e}, moment bias: {}", preset.why));
    }
    let blend = match preset.spec.beta {
        0.0 => "the lower bound".to_owned(),
        beta => format!("lower + {beta} (upper - lower)"),
    };
    let leaks = match preset.leak_reduction {
        0.0 => String::new(),
        leak => format!(", divided by 1 - {leak} and cut off at 1 against light leaks"),
    };
    comment.line(
        "shadow",
        &format!(
            "{blend}{leaks}; z_f is the receiver's depth less {} texel depths and {} slopes",
            preset.bias.texels, preset.bias.slopes
        ),
    );
    comment.line("measured", &measured(preset));
    let texture = match technique.channels() {
        1..=4 => "map0, four channels at most",
        _ => "map0, map1, ..., four channels each",
    };
    comment.line(
        "bindings",
        &format!("{texture}, from 0 on; depth_map 20, depth_samples 21, linear_sampler 22"),
    );
    licence(&mut comment);
    comment.text
}

fn stored(preset: &Preset) -> String {
    match (preset.published(), preset.spec.transform()) {
        (Some(published), name) => {
            let gain = gain(preset).map(|bits| format!(", which gains {bits:.2} bits")).unwrap_or_default();
            format!("the affine transform `{name}`{gain} ({})", published.source)
        }
        (None, "identity") => "the functions of depth as they are".to_owned(),
        (None, name) => format!("the affine transform `{name}`, computed for this basis"),
    }
}

fn measured(preset: &Preset) -> String {
    let kernel = preset.kernel.size();
    let what = format!("mean distance from percentage-closer filtering ({kernel}x{kernel} Gaussian)");
    if let Some(error) = &preset.advised {
        return format!("{what}: {error}");
    }
    let Some(row) = &preset.measured else {
        return format!(
            "{what}: this combination is in no recorded run; `msm advise SCENE` measures it on yours"
        );
    };
    let error = row.standard_error.map(|error| format!(" (standard error {:.2})", 100.0 * error));
    let nothing = preset.nothing.map(|error| format!("; no shadows at all {:.0} %", 100.0 * error));
    format!(
        "{what}: {:.2} %{} on {} fragments of stairs, village and grove with {size}x{size} maps{}; run {RUN}",
        100.0 * row.l1_error,
        error.unwrap_or_default(),
        row.fragments,
        nothing.unwrap_or_default(),
        size = row.size,
    )
}

fn licence(comment: &mut Comment) {
    comment.line("sources", "MSM15 Peters and Klein 2015, BHS16 Peters et al. 2016, GDC16 Peters 2016");
    comment.line("licence", &format!("{} (msm {})", env!("CARGO_PKG_LICENSE"), env!("CARGO_PKG_VERSION")));
}

/// Of a part of an application.
pub(super) fn of_application(name: &str, language: Language) -> Result<String, Failure> {
    let mut comment = Comment { text: String::new() };
    comment.line(name, &format!("written by `msm shader {name} --language {}`", language.name()));
    comment.line("purpose", applications::purpose(name));
    licence(&mut comment);
    Ok(comment.text)
}
