//! Judged frames: pixels with their truths, and what every method shows of them.

use super::method::MethodChoice;
use super::outcome::{CLASSES, Classes, Gathered, Group, Outcome, record};
use super::picture::{Album, Shown};
use super::records::TemporalViewRecord;
use super::run::{Ledger, Lighting, LitPixels, Plan, Track};
use crate::error::EvaluationError;
use crate::fragments::{SceneSettings, chosen};
use crate::kinds::stochastic_shadows::{LitFrame, Named, Traced};
use crate::lit_frames::{Lit, MappedLight, Ready, Scenery, Seen, Sight, Stage, middle_map};
use crate::statistics::rounded;
use applications::rays::Triangles;
use applications::soft_shadow::OccludedFraction;
use applications::temporal::penumbra_width;
use quantization::NumberFormat;
use rayon::prelude::*;
use shadow_filtering::DepthBias;

/// Frames back from now to which truths are compared, and within which surfaces count as new.
pub(super) const BACK: usize = 8;

/// Truths that differ by less have not changed: four of their standard errors.
const UNCHANGED: f64 = 0.02;

/// Truths that differ by more have.
const CHANGED: f64 = 0.05;

/// A judged pixel.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pixel: usize,
    seen: Seen,
    truth: OccludedFraction,
    /// That of some frames before.
    earlier: Option<f64>,
}

impl Plan<'_> {
    pub(super) fn judge(
        &self,
        at: &At<'_>,
        (now, then): (&Triangles, Option<&Triangles>),
        lighting: &mut Lighting<'_>,
        lit: &LitPixels,
        ledger: &mut Ledger,
        album: &mut Album<'_>,
    ) -> Result<(), EvaluationError> {
        let experiment = self.experiment;
        let light = lighting.light;
        let samples = match lighting.samples.take() {
            Some(samples) => samples,
            None => self.samples(at, (now, then), light, lit),
        };
        let map = match lighting.map.take() {
            Some(map) => map,
            None => middle_map(at.scenery, light, at.frame)?,
        };
        let before = if !at.scenery.scene.has_motion() || at.frame == 0 {
            None
        } else {
            Some(middle_map(at.scenery, light, at.frame - 1)?)
        };
        let lit_by = |map| Lit { map, light, truth: &self.truth, triangles: now };
        let mut ready = std::mem::take(&mut lighting.ready);
        ready.resize_with(experiment.technique.len(), || None);
        let of = (lit_by(&map), before.as_ref().map(lit_by));
        let is_last = experiment.path[at.path].judged.last() == Some(&(at.frame + 1));
        for (index, technique) in experiment.technique.iter().enumerate() {
            if lighting.tracks[index].is_none() && matches!(technique.choice, MethodChoice::Temporal(_)) {
                continue;
            }
            let (outcomes, error) = match &technique.choice {
                MethodChoice::Temporal(_) => {
                    let track = lighting.tracks[index].as_ref();
                    (track.map(|track| gathered(at, &samples, lit, track)).unwrap_or_default(), String::new())
                }
                MethodChoice::Taps(_) | MethodChoice::Soft(_) => {
                    self.made_anew((at, index), &samples, &of, &mut ready[index])
                }
                MethodChoice::Stochastic(_) if !is_last => continue,
                MethodChoice::Stochastic(setting) => {
                    self.filtered(at, (index, technique.name.as_str(), setting), light, &samples)?
                }
            };
            let key = [lighting.setting, at.path, at.frame, index];
            let group = self.group((&at.stage.label, &light.view.name), key, &error);
            ledger.rows.extend(CLASSES.iter().map(|class| record(&group, class, &outcomes)));
            ledger.add(&light.view.name, key, outcomes);
        }
        let shown = Shown { at, light, lit, setting: lighting.setting };
        album.take(self, &shown, &of.0, |index| {
            lighting.tracks[index].as_ref().map(|track| track.shown.as_slice())
        })?;
        if is_last {
            ledger.views.push(self.view_record(at, lighting, lit, &samples));
        }
        if at.constant {
            lighting.samples = Some(samples);
        }
        if !at.scenery.scene.has_motion() {
            (lighting.map, lighting.ready) = (Some(map), ready);
        }
        Ok(())
    }

    /// Pixels of the picture that face the light, with their truths.
    fn samples(
        &self,
        at: &At<'_>,
        (now, then): (&Triangles, Option<&Triangles>),
        light: &MappedLight,
        lit: &LitPixels,
    ) -> Vec<Sample> {
        let all: Vec<usize> =
            (0..lit.pixels.len()).filter(|&i| lit.pixels[i].is_some() && at.sight.is_shown(i)).collect();
        let SceneSettings { fragments, seed, .. } = self.experiment.scenery;
        let indices = chosen(all.len(), fragments, seed, at.frame + (at.path << 20));
        let sample = |&index: &usize| {
            let pixel = all[index];
            let seen = lit.seen[pixel]?;
            let stream = pixel as u64 + ((at.frame as u64) << 32);
            let occluded = |whole: &Triangles| {
                let surface = seen.surface(whole, at.largest);
                self.truth.occluded_fraction(
                    whole,
                    &light.placed,
                    surface.position,
                    Some(surface.triangle),
                    stream,
                )
            };
            let earlier = then.filter(|_| !seen.moves).map(|then| occluded(then).fraction);
            Some(Sample { pixel, seen, truth: occluded(now), earlier })
        };
        indices.par_iter().filter_map(sample).collect()
    }

    /// Outcomes of a method without memory, and the reason of the first failure.
    fn made_anew(
        &self,
        (at, index): (&At<'_>, usize),
        samples: &[Sample],
        (now, before): &(Lit<'_>, Option<Lit<'_>>),
        kept: &mut Option<Ready>,
    ) -> (Vec<Outcome>, String) {
        let technique = &self.experiment.technique[index];
        let bias = self.bias(index);
        let seed = self.experiment.scenery.seed;
        let Some(method) = technique.choice.anew() else { return (Vec::new(), String::new()) };
        let ready = |lit: &Lit<'_>| Ready::new(method, lit, seed);
        let made = kept.take().map_or_else(|| ready(now), Ok);
        let (ready_now, ready_before) = match (made, before.as_ref().map(ready).transpose()) {
            (Ok(now), Ok(before)) => (&*kept.insert(now), before),
            (Err(error), _) | (_, Err(error)) => {
                let failed = |sample: &Sample| Outcome { shadow: f32::NAN, ..outcome(at, sample, 0.0) };
                return (samples.iter().map(failed).collect(), error.to_string());
            }
        };
        let judged = |sample: &Sample| -> Result<Outcome, String> {
            let shadow = ready_now.shadow(now, bias, &sample.seen, sample.seen.position)?;
            let last = match (before, &ready_before) {
                (Some(before), Some(ready)) => {
                    ready.shadow(before, bias, &sample.seen, sample.seen.position)?
                }
                // What stands still under a light that stands still looks the same.
                _ => shadow,
            };
            let flicker = (at.frame > 0 && sample.is_unchanged(at)).then(|| (shadow - last).abs() as f32);
            Ok(Outcome { flicker, lookups: ready_now.lookups(), ..outcome(at, sample, shadow) })
        };
        let outcomes: Vec<Result<Outcome, String>> = samples.par_iter().map(judged).collect();
        let reason = outcomes.iter().find_map(|outcome| outcome.as_ref().err().cloned()).unwrap_or_default();
        let failed = |sample: &Sample| Outcome { shadow: f32::NAN, ..outcome(at, sample, 0.0) };
        let paired = outcomes.into_iter().zip(samples);
        (paired.map(|(outcome, sample)| outcome.unwrap_or_else(|_| failed(sample))).collect(), reason)
    }

    /// Outcomes of a stochastic map of this frame; its noise from frame to frame is told by its own kind.
    fn filtered(
        &self,
        at: &At<'_>,
        technique: Named<'_>,
        light: &MappedLight,
        samples: &[Sample],
    ) -> Result<(Vec<Outcome>, String), EvaluationError> {
        let SceneSettings { size, seed, .. } = self.experiment.scenery;
        let bias = self.bias(technique.0);
        let lit = LitFrame::new((size, seed), at.scenery, at.frame, (light.view.clone(), at.sight))?;
        let groups = lit.groups(&[technique], at.frame as u64, &mut Traced::new())?;
        let group = &groups[0];
        // Where no sample reaches, nothing blocks.
        let shade = |sample: &Sample| -> Result<f64, String> {
            Ok(group.shadow(0, bias, &sample.seen)?.unwrap_or(0.0))
        };
        let shadows: Vec<Result<f64, String>> = samples.par_iter().map(shade).collect();
        let reason = shadows.iter().find_map(|shadow| shadow.as_ref().err().cloned()).unwrap_or_default();
        let judged = |(sample, shadow): (&Sample, &Result<f64, String>)| {
            let shadow = shadow.as_ref().map_or(f64::NAN, |shadow| *shadow);
            Outcome { lookups: group.lookups() as f32, ..outcome(at, sample, shadow) }
        };
        Ok((samples.iter().zip(&shadows).map(judged).collect(), reason))
    }

    /// Depth bias of a technique, with the limit of slopes.
    pub(super) fn bias(&self, index: usize) -> (&DepthBias, f64) {
        let own = self.experiment.technique[index].bias.as_ref();
        (own.unwrap_or(&self.experiment.bias), self.experiment.scenery.plane_limit)
    }

    pub(super) fn group<'g>(
        &'g self,
        (scene, view): (&'g str, &'g str),
        [light, path, frame, index]: [usize; 4],
        error: &'g str,
    ) -> Group<'g> {
        let technique = &self.experiment.technique[index];
        let (maps, bytes_per_pixel, bits_per_texel) = match &technique.choice {
            MethodChoice::Temporal(method) => {
                let bytes = if method.format == NumberFormat::F16 { 2 } else { 4 };
                // Four channels, one buffer to read and one to write.
                (1 + usize::from(method.centre_map), 2 * 4 * bytes, 32)
            }
            MethodChoice::Stochastic(setting) => (1, 0, setting.bits_per_texel()),
            MethodChoice::Taps(_) | MethodChoice::Soft(_) => {
                (1, 0, technique.choice.anew().map_or(0, |method| method.bits_per_texel()))
            }
        };
        Group {
            scene,
            view,
            light: &self.experiment.light[light].name,
            path: &self.experiment.path[path].name,
            frame: frame + 1,
            technique: &technique.name,
            maps,
            bytes_per_pixel,
            bits_per_texel,
            error,
        }
    }

    fn view_record(
        &self,
        at: &At<'_>,
        lighting: &Lighting<'_>,
        lit: &LitPixels,
        samples: &[Sample],
    ) -> TemporalViewRecord {
        let path = &self.experiment.path[at.path];
        let light = lighting.light;
        let count = samples.len().max(1) as f64;
        let mean = |value: &dyn Fn(&OccludedFraction) -> f64| {
            samples.iter().map(|sample| value(&sample.truth)).sum::<f64>() / count
        };
        let penumbra: Vec<&Sample> = samples.iter().filter(|sample| sample.is_penumbra()).collect();
        let screen = self.screen(light, at.sight);
        let width = |sample: &&Sample| {
            let (placed, pixel) = (lit.placed[sample.pixel].as_ref()?, lit.pixels[sample.pixel].as_ref()?);
            let start = lighting.still.start(&placed[1], &self.start_taps);
            let (size, scale) = (screen.light_size, screen.pixels_per_unit);
            Some(penumbra_width(size, pixel.receiver, start.blocker?, scale, pixel.depth))
        };
        let widths: Vec<f64> = penumbra.iter().filter_map(width).filter(|width| width.is_finite()).collect();
        let rays: u64 = samples.iter().map(|sample| sample.truth.rays as u64).sum();
        TemporalViewRecord {
            scene: at.stage.label.clone(),
            view: light.view.name.clone(),
            light: self.experiment.light[lighting.setting].name.clone(),
            shape: light.view.light.to_string(),
            path: path.name.clone(),
            frames: path.frames,
            moving: at.scenery.scene.has_motion(),
            triangles: at.scenery.scene.at(at.frame).triangles.len(),
            pixels: lit.pixels.iter().flatten().count(),
            judged: samples.len(),
            mean_truth: rounded(mean(&|truth| truth.fraction)),
            mean_standard_error: rounded(mean(&|truth| truth.standard_error)),
            largest_standard_error: rounded(
                samples.iter().map(|s| s.truth.standard_error).fold(0.0, f64::max),
            ),
            rays,
            penumbra: penumbra.len(),
            penumbra_pixels: rounded(widths.iter().sum::<f64>() / widths.len().max(1) as f64),
            seed: self.experiment.scenery.seed,
        }
    }
}

/// A judged frame.
pub(super) struct At<'a> {
    pub(super) stage: &'a Stage,
    pub(super) path: usize,
    pub(super) frame: usize,
    pub(super) scenery: &'a Scenery<'a>,
    pub(super) sight: &'a Sight,
    pub(super) last: &'a Sight,
    pub(super) ages: &'a [u32],
    pub(super) largest: f64,
    pub(super) constant: bool,
}

impl Sample {
    fn is_penumbra(&self) -> bool {
        (0.01..=0.99).contains(&self.truth.fraction)
    }

    /// Whether the truth stays, as far as is known.
    fn is_unchanged(&self, at: &At<'_>) -> bool {
        let stays = |earlier: f64| (earlier - self.truth.fraction).abs() < UNCHANGED;
        !self.seen.moves && (!at.scenery.scene.has_motion() || self.earlier.is_some_and(stays))
    }
}

fn outcome(at: &At<'_>, sample: &Sample, shadow: f64) -> Outcome {
    let changed = sample.earlier.is_some_and(|earlier| (earlier - sample.truth.fraction).abs() > CHANGED);
    let new = at.frame > 0 && (at.ages[sample.pixel] as usize) < BACK;
    Outcome {
        shadow: shadow as f32,
        truth: sample.truth.fraction as f32,
        classes: Classes { penumbra: sample.is_penumbra(), new, changed },
        ..Outcome::default()
    }
}

/// Outcomes of a method that gathers.
fn gathered(at: &At<'_>, samples: &[Sample], lit: &LitPixels, track: &Track) -> Vec<Outcome> {
    let judged = |sample: &Sample| {
        let shaded = track.shown[sample.pixel].as_ref()?;
        let before = lit.pixels[sample.pixel].as_ref().map(|pixel| pixel.before);
        let shown = |pixel: usize| track.before.get(pixel)?.as_ref().map(|shaded| shaded.shadow);
        let last = before.filter(|_| at.frame > 0).and_then(|place| {
            // Interpolation would be a change of its own where nothing moves.
            if at.constant { shown(sample.pixel) } else { at.last.interpolated(place, shown) }
        });
        let flicker =
            last.filter(|_| sample.is_unchanged(at)).map(|last| (shaded.shadow - last).abs() as f32);
        let gathered = Gathered {
            estimate: shaded.estimate as f32,
            believed: shaded.standard_error as f32,
            tests: shaded.tests as f32,
            restarted: shaded.restarted,
            filtered: shaded.filtered,
        };
        let lookups = shaded.lookups as f32;
        Some(Outcome { flicker, gathered: Some(gathered), lookups, ..outcome(at, sample, shaded.shadow) })
    };
    samples.iter().filter_map(judged).collect()
}
