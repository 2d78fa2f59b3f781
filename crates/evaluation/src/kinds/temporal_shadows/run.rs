//! From an experiment to its tables.

use super::counting;
use super::judge::{CLASSES, Classes, Gathered, Group, Outcome, record};
use super::method::MethodChoice;
use super::picture::{Album, Shown};
use super::records::{TemporalRecord, TemporalViewRecord};
use super::settings::TemporalShadowsExperiment;
use super::timing;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::fragments::chosen;
use crate::lit_frames::{
    Lit, MappedLight, Placed, PointMap, Ready, Scenery, Seen, Sight, Stage, TAP_STREAM, Whole,
    largest_coordinate, middle_map, on_map,
};
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::statistics::rounded;
use applications::rays::{PosedTriangles, Segment, Triangles};
use applications::samples::{HALTON_START, halton};
use applications::samples::{PoissonTaps, TapShape};
use applications::soft_shadow::{AreaTruth, OccludedFraction};
use applications::temporal::{FramePixel, Screen, Shaded, ShadowBuffer, Start, penumbra_width};
use quantization::NumberFormat;
use rayon::prelude::*;
use scenes::vector::minus;
use shadow_filtering::{DepthBias, DepthMap};
use std::sync::atomic::AtomicU32;

/// Taps of the neighbourhood filter, and of search and filter of the first estimate (TC09 section 4).
const TAPS: usize = 16;

/// Frames back from now to which truths are compared, and within which surfaces count as new.
const BACK: usize = 8;

/// Truths that differ by less have not changed: four of their standard errors.
const UNCHANGED: f64 = 0.02;

/// Truths that differ by more have.
const CHANGED: f64 = 0.05;

/// Ages in frames of what was there from the start.
const OLD: u32 = 1 << 20;

/// What does not change during a run.
pub(super) struct Plan<'a> {
    pub(super) experiment: &'a TemporalShadowsExperiment,
    pub(super) truth: AreaTruth,
    pub(super) start_taps: PoissonTaps,
    pub(super) filter_taps: PoissonTaps,
}

/// A method's buffer with what it showed.
struct Track {
    buffer: ShadowBuffer,
    shown: Vec<Option<Shaded>>,
    before: Vec<Option<Shaded>>,
}

/// A light on its way through the frames of a path.
struct Lighting<'a> {
    setting: usize,
    light: &'a MappedLight,
    /// From the light's middle, of what stands still.
    still: PointMap<'a>,
    memory: [Vec<AtomicU32>; 2],
    tracks: Vec<Option<Track>>,
    /// Kept where all frames show the same.
    samples: Option<Vec<Sample>>,
    map: Option<DepthMap>,
    /// Methods without memory, by technique; kept where nothing moves.
    ready: Vec<Option<Ready>>,
}

/// A judged pixel.
#[derive(Clone, Copy)]
pub(super) struct Sample {
    pixel: usize,
    seen: Seen,
    truth: OccludedFraction,
    /// That of some frames before.
    earlier: Option<f64>,
}

/// Pixels of a frame on the map of its point of the light and on that of the middle.
pub(super) struct LitPixels {
    pub(super) seen: Vec<Option<Seen>>,
    placed: Vec<Option<[Placed; 2]>>,
    pub(super) pixels: Vec<Option<FramePixel>>,
}

impl LitPixels {
    /// Percentage-closer soft shadows of a pixel by the frame's own map or by that of the light's middle.
    pub(super) fn start(
        &self,
        pixel: usize,
        centre: bool,
        (map, middle): (&PointMap<'_>, &PointMap<'_>),
        taps: &PoissonTaps,
    ) -> Start {
        match &self.placed[pixel] {
            Some([_, placed]) if centre => middle.start(placed, taps),
            Some([placed, _]) => map.start(placed, taps),
            None => Start::default(),
        }
    }
}

/// What judging leaves.
#[derive(Default)]
struct Ledger {
    rows: Vec<TemporalRecord>,
    views: Vec<TemporalViewRecord>,
    /// Outcomes of all scenes by view, light, path, frame and technique.
    pooled: Vec<(String, [usize; 4], Vec<Outcome>)>,
}

impl TemporalShadowsExperiment {
    /// Walks along all paths, then draws, and times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let seed = self.scenery.seed;
        let plan = Plan {
            experiment: self,
            truth: self.nets()?,
            start_taps: PoissonTaps::new(TapShape::Square, TAPS, seed, TAP_STREAM),
            filter_taps: PoissonTaps::new(TapShape::Disc, TAPS, seed, TAP_STREAM + 1),
        };
        let stages = self.scenery.scenes.iter().enumerate();
        let stages: Vec<Stage> = stages.map(|(i, label)| Stage::load(label, i)).collect::<Result<_, _>>()?;
        for stage in &stages {
            for view in stage.views(&self.scenery.views)? {
                self.light.iter().try_for_each(|light| light.of(view).map(|_| ()))?;
            }
        }
        let mut album = Album::new(self, &stages)?;
        let total = stages.len() * self.path.len();
        let (mut ledger, mut done) = (Ledger::default(), 0);
        for stage in &stages {
            for path in 0..self.path.len() {
                plan.walk(stage, path, &mut ledger, &mut album)?;
                done += 1;
                (context.progress)(done, total);
            }
        }
        plan.pool(&mut ledger);
        let trials = ledger.rows.len();
        let failed = ledger.rows.iter().filter(|row| !row.error.is_empty()).count();
        let mut files = album.files()?;
        files.extend([
            RecordedFile::csv("records.csv", &ledger.rows)?,
            RecordedFile::csv("views.csv", &ledger.views)?,
            RecordedFile::csv("counts.csv", &counting::counts(self))?,
            RecordedFile::csv("samples.csv", &timing::time(&plan, &stages[0])?)?,
        ]);
        Ok(Recorded { files, trials, failed, complete: true })
    }
}

impl Plan<'_> {
    /// One path of a scene, under all lights.
    fn walk(
        &self,
        stage: &Stage,
        path: usize,
        ledger: &mut Ledger,
        album: &mut Album<'_>,
    ) -> Result<(), EvaluationError> {
        let experiment = self.experiment;
        let setting = &experiment.path[path];
        let scenery = stage.on(setting.moving);
        let (window, way) = (experiment.window(), setting.camera(experiment.zoom));
        let constant = setting.is_constant(scenery.scene.has_motion());
        let lights = self.lights(stage, &scenery)?;
        let mut lightings: Vec<Lighting<'_>> = Vec::new();
        for (light, setting) in &lights {
            let still = PosedTriangles { moving: None, ..scenery.posed(0) };
            lightings.push(Lighting {
                setting: *setting,
                light,
                still: PointMap::new(still, light, [0.5; 2], Vec::new()),
                memory: [Vec::new(), Vec::new()],
                tracks: Vec::new(),
                samples: None,
                map: None,
                ready: Vec::new(),
            });
        }
        let mut current = Sight::new(&window, &scenery, &way, 0)?;
        let mut ages = vec![OLD; current.depth.len()];
        let largest = largest_coordinate(&scenery.scene.at(0));
        // Shadow rays in every frame take one tree for all frames.
        let whole = if constant { Some(scenery.whole(0)?) } else { None };
        let exact = whole.as_ref().map(|whole| (whole.triangles(), largest));
        for frame in 0..setting.frames {
            let next =
                if frame == 0 || constant { None } else { Some(Sight::new(&window, &scenery, &way, frame)?) };
            if let Some(next) = &next {
                ages = aged(next, &current, &scenery, &ages);
            }
            let (sight, last) = (next.as_ref().unwrap_or(&current), &current);
            let judged = setting.judged.contains(&(frame + 1));
            let wholes = if judged { Some(self.wholes(&scenery, frame)?) } else { None };
            for lighting in &mut lightings {
                let lit = self.gather(&scenery, (sight, last), lighting, (frame, exact));
                if let Some((now, then)) = &wholes {
                    let whole = (now.triangles(), then.as_ref().map(|then| then.triangles()));
                    let at = At {
                        stage,
                        path,
                        frame,
                        scenery: &scenery,
                        sight,
                        last,
                        ages: &ages,
                        largest,
                        constant,
                    };
                    self.judge(&at, whole, lighting, &lit, ledger, album)?;
                }
            }
            if let Some(next) = next {
                current = next;
            }
        }
        Ok(())
    }

    /// The lights of all wanted views, with their place among the experiment's.
    pub(super) fn lights(
        &self,
        stage: &Stage,
        scenery: &Scenery<'_>,
    ) -> Result<Vec<(MappedLight, usize)>, EvaluationError> {
        let whole = scenery.scene.at(0);
        let mut lights = Vec::new();
        for view in stage.views(&self.experiment.scenery.views)? {
            for (index, light) in self.experiment.light.iter().enumerate() {
                let size = self.experiment.scenery.size;
                lights.push((MappedLight::new(&whole, light.of(view)?, size)?, index));
            }
        }
        Ok(lights)
    }

    fn wholes<'s>(
        &self,
        scenery: &'s Scenery<'_>,
        frame: usize,
    ) -> Result<(Whole<'s>, Option<Whole<'s>>), EvaluationError> {
        let earlier = (scenery.scene.has_motion() && frame >= BACK).then(|| scenery.whole(frame - BACK));
        Ok((scenery.whole(frame)?, earlier.transpose()?))
    }

    /// Pixels on the maps of a frame; tested by shadow rays, too, where there are triangles for them.
    pub(super) fn lit_pixels(
        &self,
        scenery: &Scenery<'_>,
        (sight, last): (&Sight, &Sight),
        (light, map, middle): (&MappedLight, &PointMap<'_>, &PointMap<'_>),
        exact: Option<(&Triangles, f64)>,
    ) -> LitPixels {
        let bias = self.gathering_bias();
        let one = |pixel: usize| {
            let seen = sight.facing(scenery.scene, pixel, light.placed.middle)?;
            let surface = (seen.position, seen.normal);
            let placed = on_map(&map.frame, light.texel_depth, bias, surface)?;
            let centre = on_map(&middle.frame, light.texel_depth, bias, surface)?;
            let (behind, map_distance, moving) = map.test(&placed);
            // What looks away from the frame's point of the light is dark whatever the map says.
            let hides_itself = map.frame.eye.is_some_and(|eye| !seen.faces(eye));
            let hidden = exact.map(|(whole, largest)| {
                let surface = seen.surface(whole, largest);
                let direction = map.frame.eye.map_or([0.0; 3], |eye| minus(eye, surface.position));
                let from = Some(surface.triangle);
                whole.occludes(&Segment { origin: surface.position, direction, endless: false, from })
            });
            let in_shadow = behind || hides_itself;
            let pixel = FramePixel {
                depth: sight.depth[pixel],
                before: last.view.project(seen.position),
                followed: last.view.project(sight.place_in(last, &seen)),
                receiver: map.distance(placed.depth),
                in_shadow,
                hidden: hidden.unwrap_or(in_shadow),
                map_distance,
                moving,
            };
            Some((seen, [placed, centre], pixel))
        };
        let all: Vec<Option<_>> = (0..sight.depth.len()).into_par_iter().map(one).collect();
        LitPixels {
            seen: all.iter().map(|one| one.map(|one| one.0)).collect(),
            placed: all.iter().map(|one| one.map(|one| one.1)).collect(),
            pixels: all.into_iter().map(|one| one.map(|one| one.2)).collect(),
        }
    }

    fn gathering_bias(&self) -> (&DepthBias, f64) {
        (&self.experiment.bias, self.experiment.scenery.plane_limit)
    }

    /// One frame of all methods that gather.
    fn gather(
        &self,
        scenery: &Scenery<'_>,
        sights: (&Sight, &Sight),
        lighting: &mut Lighting<'_>,
        (frame, exact): (usize, Option<(&Triangles, f64)>),
    ) -> LitPixels {
        let Lighting { light, still, memory, tracks, .. } = lighting;
        let posed = scenery.posed(frame);
        let point = halton(HALTON_START + frame as u64);
        let [of_point, of_middle] = std::mem::take(memory);
        let map = PointMap::new(posed, light, point, of_point);
        let moved =
            posed.moving.is_some().then(|| PointMap::new(posed, light, [0.5; 2], of_middle).over(still));
        let middle = moved.as_ref().unwrap_or(still);
        let rays = exact.filter(|_| self.experiment.gathering().any(|(_, method)| method.exact));
        let lit = self.lit_pixels(scenery, sights, (light, &map, middle), rays);
        let start = |pixel: usize, centre: bool| lit.start(pixel, centre, (&map, middle), &self.start_taps);
        let screen = self.screen(light, sights.0);
        let [width, height] = sights.0.size();
        tracks.resize_with(self.experiment.technique.len(), || None);
        for (index, method) in
            self.experiment.gathering().filter(|(_, method)| !method.exact || exact.is_some())
        {
            let track = tracks[index].get_or_insert_with(|| Track {
                buffer: ShadowBuffer::empty(width, height),
                shown: Vec::new(),
                before: Vec::new(),
            });
            let (buffer, shown) =
                method.frame(&track.buffer, &lit.pixels, &screen, &self.filter_taps, &start);
            track.before = std::mem::replace(&mut track.shown, shown);
            track.buffer = buffer;
        }
        let of_middle = moved.map(PointMap::into_memory).unwrap_or_default();
        *memory = [map.into_memory(), of_middle];
        lit
    }

    pub(super) fn screen(&self, light: &MappedLight, sight: &Sight) -> Screen {
        Screen { light_size: light.size(), pixels_per_unit: sight.view.pixels_per_unit() }
    }

    fn judge(
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
            };
            let key = [lighting.setting, at.path, at.frame, index];
            let group = self.group((&at.stage.label, &light.view.name), key, &error);
            ledger.rows.extend(CLASSES.iter().map(|class| record(&group, class, &outcomes)));
            let place = ledger.pooled.iter().position(|(view, k, _)| (view, k) == (&light.view.name, &key));
            match place {
                Some(place) => ledger.pooled[place].2.extend(outcomes),
                None => ledger.pooled.push((light.view.name.clone(), key, outcomes)),
            }
        }
        let shown = Shown { at, light, lit, setting: lighting.setting };
        album.take(self, &shown, &of.0, |index| {
            lighting.tracks[index].as_ref().map(|track| track.shown.as_slice())
        })?;
        if experiment.path[at.path].judged.last() == Some(&(at.frame + 1)) {
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
        let SceneSample { wanted, seed } = SceneSample::of(self.experiment);
        let indices = chosen(all.len(), wanted, seed, at.frame + (at.path << 20));
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

    /// Depth bias of a technique, with the limit of slopes.
    pub(super) fn bias(&self, index: usize) -> (&DepthBias, f64) {
        let own = self.experiment.technique[index].bias.as_ref();
        (own.unwrap_or(&self.experiment.bias), self.experiment.scenery.plane_limit)
    }

    fn group<'g>(
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

    /// Rows over all scenes.
    fn pool(&self, ledger: &mut Ledger) {
        for (view, key, outcomes) in &ledger.pooled {
            let failed = ledger.rows.iter().find(|row| {
                let group = self.group(("", view), *key, "");
                let same =
                    row.technique == group.technique && row.light == group.light && row.path == group.path;
                same && row.frame == group.frame && !row.error.is_empty()
            });
            let error = failed.map(|row| row.error.clone()).unwrap_or_default();
            let group = self.group(("all", view), *key, &error);
            let rows: Vec<TemporalRecord> =
                CLASSES.iter().map(|class| record(&group, class, outcomes)).collect();
            ledger.rows.extend(rows);
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
    last: &'a Sight,
    ages: &'a [u32],
    pub(super) largest: f64,
    pub(super) constant: bool,
}

/// How many pixels are judged.
struct SceneSample {
    wanted: usize,
    seed: u64,
}

impl SceneSample {
    fn of(experiment: &TemporalShadowsExperiment) -> Self {
        Self { wanted: experiment.scenery.fragments, seed: experiment.scenery.seed }
    }
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

/// How many frames ago each pixel's surface came into view.
fn aged(sight: &Sight, last: &Sight, scenery: &Scenery<'_>, ages: &[u32]) -> Vec<u32> {
    let age = |pixel: usize| {
        let triangle = sight.frame.triangle[pixel];
        let position = sight.frame.position[pixel].map(f64::from);
        let moves = triangle != shadow_renderer::NO_TRIANGLE && scenery.scene.moves(triangle);
        let seen = Seen { position, normal: [0.0; 3], triangle, moves };
        let before = last.view.project(sight.place_in(last, &seen));
        last.holds(before).map_or(0, |pixel| ages[pixel].saturating_add(1))
    };
    (0..ages.len()).into_par_iter().map(age).collect()
}
