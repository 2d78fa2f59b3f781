//! Soft shadows: methods on a map seen from the light's middle against shadow rays to all of it.

use super::budget::{Budget, Costs};
use super::query::Measured;
use super::race::{Course, FIRST_ROUND, Race, add_chunks, by_view, shuffled};
use super::shipping::BiasInView;
use super::soft_method::{NothingSoft, SoftCandidate, Texels};
use super::together::{Member, Shared};
use crate::error::EvaluationError;
use crate::fragments::light::{penumbra, placed};
use crate::fragments::{LoadedScene, Source};
use crate::kinds::soft_shadows::{SoftShadowsExperiment, surface};
use crate::kinds::speed_accuracy::{FrameSetting, SceneView};
use crate::statistics::Sums;
use applications::PlacedLight;
use applications::rays::{Surface, Triangles};
use applications::soft_shadow::{AreaTruth, BlockerSearch, BlueNoise, Fragment, Penumbra, SoftReceiver};
use applications::soft_shadow::{SoftShadow, percentage_closer_blockers};
use rayon::prelude::*;
use serde::Serialize;
use shadow_filtering::{DepthBias, Receiver};
use shadow_renderer::LightFrame;
use std::ops::Range;

/// A method with everything that has to be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoftChoice {
    /// Method.
    pub technique: String,
    /// How sums are held; depths for methods that compare texels.
    pub format: String,
    /// What is stored of powers of depth: `unit`, `signed` or `sparse`; empty for depths.
    pub storage: String,
    /// Number of moments; 0 for depths.
    pub moments: usize,
    /// Moment bias.
    pub alpha: Option<f64>,
    /// Depth bias in texel depths of the map.
    pub bias_texels: f64,
    /// Depth bias in slopes of the receiver.
    pub bias_slopes: f64,
    /// Side of the shadow map in texels.
    pub size: u32,
    /// Full width in texels of the largest region that is searched for blockers.
    pub region: f64,
    /// Texels read a pixel, on average.
    pub samples: f64,
    /// Its error.
    #[serde(flatten)]
    pub error: Measured,
    /// Memory of a texel.
    pub bits_per_texel: usize,
    /// Memory of the map.
    pub map_bytes: u64,
    /// Modelled cost of a frame, in the unit of hard shadows.
    pub cost: f64,
    /// The same in milliseconds on the card of the budget.
    pub cost_ms: f64,
    /// The depth bias in each view.
    pub depth_bias: Vec<BiasInView>,
}

/// Most receivers that are asked: their shadow rays take most of the time.
const MOST_RECEIVERS: usize = 1 << 15;

/// A view under its light.
struct SoftView {
    frame: LightFrame,
    light: PlacedLight,
    /// By divisor.
    penumbrae: Vec<Penumbra<f64>>,
}

/// A receiver whose truth is known.
struct Known {
    surface: Surface,
    truth: f32,
}

struct Entry {
    candidate: usize,
    divisor: usize,
    cost: f64,
    samples: f64,
}

/// Every method on every map size.
pub(super) struct SoftCourse<'a> {
    experiment: &'a SoftShadowsExperiment,
    candidates: Vec<SoftCandidate>,
    divisors: &'a [u32],
    scenes: &'a [&'a SceneView],
    views: Vec<SoftView>,
    triangles: Triangles,
    truth: AreaTruth,
    noise: BlueNoise,
    entries: Vec<Entry>,
    shuffled: Vec<(u32, u32)>,
    /// In the shuffled order, as far as they were asked; `None` where no triangle was found near.
    known: Vec<Option<Known>>,
    /// Sum of the standard errors of their truths.
    noise_sum: f64,
}

impl<'a> SoftCourse<'a> {
    /// `scenes` are views whose lights have an extent; maps are those of hard shadows by the same divisors.
    pub(super) fn new(
        (experiment, divisors): (&'a SoftShadowsExperiment, &'a [u32]),
        loaded: &LoadedScene<'_>,
        scenes: &'a [&'a SceneView],
        (frame, budget): (FrameSetting, &Budget),
    ) -> Result<Self, EvaluationError> {
        let fail = |reason: String| EvaluationError::Value(format!("scene `{}`: {reason}", loaded.label));
        let Source::Scene(scene) = &loaded.source else {
            return Err(fail("is a stack: shadow rays need triangles".to_owned()));
        };
        let triangles = Triangles::of_scene(scene).map_err(|error| fail(error.to_string()))?;
        let view = |of: &&SceneView| -> Result<SoftView, EvaluationError> {
            let frame = of.frame.ok_or_else(|| fail("a stack has no frame".to_owned()))?;
            let whole = penumbra(&of.light.light, &frame);
            let divided = |&divisor: &u32| {
                let texels_per_unit = whole.texels_per_unit.map(|texels| texels / f64::from(divisor));
                Penumbra { texels_per_unit, ..whole }
            };
            let widths = whole.search(1.0);
            let (width, side) = (widths[0].max(widths[1]), of.map.width());
            if width > side as f64 {
                return Err(fail(format!(
                    "view `{}`: under this light blockers lie within {width:.0} texels, the map has {side}",
                    of.view
                )));
            }
            let light = placed(&of.light.light, &frame);
            Ok(SoftView { frame, light, penumbrae: divisors.iter().map(divided).collect() })
        };
        let views = scenes.iter().map(view).collect::<Result<Vec<_>, _>>()?;
        let seed = experiment.scenery.seed;
        let mut course = Self {
            experiment,
            candidates: SoftCandidate::all(experiment),
            divisors,
            scenes,
            views,
            triangles,
            truth: experiment.truth.nets(seed)?,
            noise: BlueNoise::new(seed),
            entries: Vec::new(),
            shuffled: shuffled(scenes.iter().map(|view| view.receivers.len()), seed),
            known: Vec::new(),
            noise_sum: 0.0,
        };
        course.know(FIRST_ROUND);
        course.enter(frame, budget)?;
        Ok(course)
    }

    /// Fills the list of entries.
    fn enter(&mut self, frame: FrameSetting, budget: &Budget) -> Result<(), EvaluationError> {
        let texels = self.texels();
        let mut costs = Costs::default();
        for (index, candidate) in self.candidates.iter().enumerate() {
            for (divisor, &scale) in self.divisors.iter().enumerate() {
                let maps = self.scenes.iter().zip(&self.views);
                let is_held = |(scene, view): (&&SceneView, &SoftView)| {
                    let map = scene.maps[divisor].as_ref();
                    map.is_some_and(|map| candidate.is_held(map, &view.penumbrae[divisor]))
                };
                if !maps.clone().all(is_held) {
                    continue;
                }
                let side = self.side(scale);
                let (cost, samples) = candidate.cost(frame, side, &texels, f64::from(scale));
                // A width that the light never asks for limits nothing: the method without it is there already.
                let is_same = |entry: &Entry| {
                    let other = &self.candidates[entry.candidate];
                    entry.divisor == divisor && entry.samples == samples && other.moments() == 0
                };
                if candidate.moments() == 0 && self.entries.iter().any(is_same) {
                    continue;
                }
                if costs.admits(budget, cost.total(), candidate.map_bytes(side)) {
                    self.entries.push(Entry { candidate: index, divisor, cost: cost.total(), samples });
                }
            }
        }
        costs.check(budget, "soft shadows", self.entries.is_empty())?;
        self.entries.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        Ok(())
    }

    fn side(&self, divisor: u32) -> u32 {
        self.scenes[0].map.width() as u32 / divisor
    }

    /// What percentage-closer soft shadows read around the first receivers.
    fn texels(&self) -> Vec<Texels> {
        let one = |place: usize| {
            self.known.get(place)?.as_ref()?;
            let (view, fragment) = self.shuffled[place];
            let (scene, view) = (&self.scenes[view as usize], &self.views[view as usize]);
            let receiver = &scene.receivers[fragment as usize];
            let penumbra = &view.penumbrae[0];
            let scale = f64::from(self.divisors[0]);
            let fragment = self.fragment(scene, receiver, &self.experiment.bias[0], scale);
            let search = BlockerSearch::percentage_closer();
            let blockers = percentage_closer_blockers(scene.maps[0].as_ref()?, penumbra, &search, &fragment);
            let has_blockers = blockers.mass > 0.0;
            Some(Texels {
                search: penumbra.search(fragment.depth).map(|width| width * scale),
                filter: has_blockers.then(|| {
                    let average = blockers.average(fragment.depth, 0.0);
                    penumbra.filter(fragment.depth, average).map(|width| width * scale)
                }),
            })
        };
        (0..self.known.len().min(FIRST_ROUND)).into_par_iter().filter_map(one).collect()
    }

    fn fragment(
        &self,
        scene: &SceneView,
        receiver: &Receiver,
        bias: &DepthBias,
        scale: f64,
    ) -> Fragment<f64> {
        let own = Receiver { gradient: receiver.gradient.map(|slope| slope * scale), ..*receiver };
        let limit = self.experiment.scenery.plane_limit;
        let compared = bias.compared(&own, scene.texel_depth * scale, limit);
        Fragment {
            position: [receiver.x, receiver.y].map(|texel| (texel as f64 + 0.5) / scale),
            depth: receiver.depth,
            bias: receiver.depth - compared,
            noise: self.noise.at(receiver.x, receiver.y),
        }
    }

    /// Sends the shadow rays of the first `upto` receivers.
    fn know(&mut self, upto: usize) {
        let upto = upto.min(self.shuffled.len());
        let from = self.known.len();
        if upto <= from {
            return;
        }
        let one = |place: usize| {
            let (number, index) = self.shuffled[place];
            let (scene, view) = (&self.scenes[number as usize], &self.views[number as usize]);
            let receiver = &scene.receivers[index as usize];
            let at = [receiver.x, receiver.y].map(|texel| texel as f64 + 0.5);
            let surface = surface(&self.triangles, &view.frame, receiver, at)?;
            let stream = u64::from(number) << 32 | u64::from(index);
            let Surface { position, triangle } = surface;
            let found =
                self.truth.occluded_fraction(&self.triangles, &view.light, position, Some(triangle), stream);
            Some((Known { surface, truth: found.fraction as f32 }, found.standard_error))
        };
        let found: Vec<_> = (from..upto).into_par_iter().map(one).collect();
        for entry in found {
            self.noise_sum += entry.as_ref().map_or(0.0, |(_, error)| *error);
            self.known.push(entry.map(|(known, _)| known));
        }
    }

    /// With what others may share.
    pub(super) fn member(&self, arm: usize) -> Member {
        let entry = &self.entries[arm];
        let side = self.side(self.divisors[entry.divisor]);
        let candidate = &self.candidates[entry.candidate];
        // Methods without moments keep the depth map alone.
        let bytes = if candidate.moments() > 0 { candidate.map_bytes(side) } else { 0 };
        Member {
            application: "soft shadows",
            name: format!("{}, {}, {side}x{side}", candidate.name(), candidate.format()),
            cost: entry.cost,
            bytes,
            uses: vec![Shared::depth(side)],
        }
    }

    /// What doing nothing errs by, with the confidence of an interval of `log_term`.
    pub(super) fn nothing(&self) -> NothingSoft {
        let mut sums = Sums::default();
        self.known.iter().flatten().for_each(|known| sums.push(known.truth, known.truth));
        let n = sums.count.max(1) as f64;
        let mean = sums.mean();
        // Hoeffding (1963), for one interval that holds with probability 1 - 1e-6.
        let half = (1e6f64.ln() / (2.0 * n)).sqrt();
        NothingSoft { l1_error: mean, l1_error_low: (mean - half).max(0.0) }
    }

    /// Mean standard error of the truths.
    pub(super) fn truth_error(&self) -> f64 {
        self.noise_sum / self.known.iter().flatten().count().max(1) as f64
    }
}

impl Course for SoftCourse<'_> {
    fn arms(&self) -> Vec<(f64, usize)> {
        self.entries.iter().map(|entry| (entry.cost, self.experiment.bias.len())).collect()
    }

    fn receivers(&self) -> usize {
        self.shuffled.len()
    }

    fn most(&self) -> usize {
        MOST_RECEIVERS.min(self.shuffled.len())
    }

    fn sums(
        &mut self,
        arm: usize,
        range: Range<usize>,
        variants: &[usize],
    ) -> Result<Vec<Sums>, EvaluationError> {
        self.know(range.end);
        let Entry { candidate, divisor, .. } = self.entries[arm];
        let candidate = &self.candidates[candidate];
        let scale = f64::from(self.divisors[divisor]);
        let mut sums = vec![Sums::default(); variants.len()];
        for (number, places) in by_view(&self.shuffled, range) {
            let (scene, view) = (&self.scenes[number], &self.views[number]);
            let Some(map) = &scene.maps[divisor] else { continue };
            let lit = SoftShadow {
                scene: &self.triangles,
                light: view.light,
                truth: &self.truth,
                map,
                penumbra: view.penumbrae[divisor],
            };
            let ready = candidate.prepare(map, &lit.penumbra)?;
            let of_chunk = |places: &[usize]| {
                let mut sums = vec![Sums::default(); variants.len()];
                for &place in places {
                    let Some(known) = &self.known[place] else { continue };
                    let receiver = &scene.receivers[self.shuffled[place].1 as usize];
                    for (sums, &variant) in sums.iter_mut().zip(variants) {
                        let bias = &self.experiment.bias[variant];
                        let fragment = self.fragment(scene, receiver, bias, scale);
                        let receiver = SoftReceiver { surface: known.surface, fragment, stream: 0 };
                        let shadow = ready.shadow(&lit, &receiver);
                        sums.push(shadow as f32 - known.truth, known.truth);
                    }
                }
                sums
            };
            add_chunks(&mut sums, &places, CHUNK, of_chunk);
        }
        Ok(sums)
    }
}

/// Receivers of one task.
const CHUNK: usize = 64;

/// An arm as it is told; `nothing` is what doing nothing errs by, above 0.
pub(super) fn choice(
    race: &Race<SoftCourse<'_>>,
    arm: usize,
    nothing: f64,
    (unit, budget): (f64, &Budget),
) -> SoftChoice {
    let (variant, estimate) = race.best_variant(arm);
    let course = &race.course;
    let Entry { candidate, divisor, cost, samples } = course.entries[arm];
    let candidate = &course.candidates[candidate];
    let (bias, scale) = (course.experiment.bias[variant], course.divisors[divisor]);
    let size = course.side(scale);
    let widest = |view: &SoftView| {
        let widths = view.penumbrae[divisor].search(1.0);
        candidate.region(widths[0].max(widths[1]))
    };
    SoftChoice {
        technique: candidate.name(),
        format: candidate.format(),
        storage: candidate.storage(),
        moments: candidate.moments(),
        alpha: candidate.alpha(),
        bias_texels: bias.texels,
        bias_slopes: bias.slopes,
        size,
        region: course.views.iter().map(widest).fold(0.0, f64::max),
        samples,
        error: Measured::new(estimate, nothing),
        bits_per_texel: candidate.bits_per_texel(),
        map_bytes: candidate.map_bytes(size),
        cost: cost / unit,
        cost_ms: budget.milliseconds(cost),
        depth_bias: course.scenes.iter().map(|view| BiasInView::new(bias, scale, view)).collect(),
    }
}
