//! From an experiment to its tables.

use super::counting;
use super::judge::{At, BACK, Sample};
use super::outcome::{CLASSES, Outcome, record};
use super::picture::Album;
use super::records::{TemporalPictureRecord, TemporalRecord, TemporalViewRecord};
use super::settings::TemporalShadowsExperiment;
use super::timing;
use crate::error::EvaluationError;
use crate::experiment::kind::RunContext;
use crate::lit_frames::{
    MappedLight, Placed, PointMap, Ready, Scenery, Seen, Sight, Stage, TAP_STREAM, Whole, largest_coordinate,
    on_map,
};
use crate::run::Recorded;
use crate::run_directory::RecordedFile;
use crate::shards::{self, Gathered};
use applications::rays::{PosedTriangles, Segment, Triangles};
use applications::samples::{HALTON_START, PoissonTaps, TapShape, halton};
use applications::soft_shadow::AreaTruth;
use applications::temporal::{FramePixel, Screen, Shaded, ShadowBuffer, Start};
use rayon::prelude::*;
use scenes::vector::minus;
use serde::{Deserialize, Serialize};
use shadow_filtering::{DepthBias, DepthMap};
use std::sync::atomic::AtomicU32;

/// Taps of the neighbourhood filter, and of search and filter of the first estimate (TC09 section 4).
const TAPS: usize = 16;

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
pub(super) struct Track {
    pub(super) buffer: ShadowBuffer,
    pub(super) shown: Vec<Option<Shaded>>,
    pub(super) before: Vec<Option<Shaded>>,
}

/// A light on its way through the frames of a path.
pub(super) struct Lighting<'a> {
    pub(super) setting: usize,
    pub(super) light: &'a MappedLight,
    /// From the light's middle, of what stands still.
    pub(super) still: PointMap<'a>,
    pub(super) memory: [Vec<AtomicU32>; 2],
    pub(super) tracks: Vec<Option<Track>>,
    /// Kept where all frames show the same.
    pub(super) samples: Option<Vec<Sample>>,
    pub(super) map: Option<DepthMap>,
    /// Methods without memory, by technique; kept where nothing moves.
    pub(super) ready: Vec<Option<Ready>>,
}

/// Pixels of a frame on the map of its point of the light and on that of the middle.
pub(super) struct LitPixels {
    pub(super) seen: Vec<Option<Seen>>,
    pub(super) placed: Vec<Option<[Placed; 2]>>,
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
#[derive(Clone, Default, Deserialize, Serialize)]
pub(super) struct Ledger {
    pub(super) rows: Vec<TemporalRecord>,
    pub(super) views: Vec<TemporalViewRecord>,
    /// Outcomes of all scenes by view, light, path, frame and technique.
    pub(super) pooled: Vec<(String, [usize; 4], Vec<Outcome>)>,
    /// Pictures of the path, with their place among all.
    pictures: Vec<(usize, TemporalPictureRecord)>,
    files: Vec<RecordedFile>,
}

impl TemporalShadowsExperiment {
    /// Walks along all paths, then draws, and times alone.
    pub(super) fn evaluate(&self, context: &RunContext<'_>) -> Result<Recorded, EvaluationError> {
        let seed = self.scenery.seed;
        let plan = Plan {
            experiment: self,
            truth: self.truth.nets(self.scenery.seed)?,
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
        let album = Album::new(self, &stages)?;
        let paths = self.path.len();
        let costs: Vec<u64> = stages.iter().flat_map(|_| &self.path).map(|path| path.frames as u64).collect();
        let one = |number: usize| {
            let (mut ledger, mut album) = (Ledger::default(), album.clone());
            plan.walk(&stages[number / paths], number % paths, &mut ledger, &mut album)?;
            (ledger.files, ledger.pictures) = album.files()?;
            Ok(ledger)
        };
        let mut ledger = match shards::numbered(context, "paths through scenes", &costs, &one)? {
            Gathered::All(ledgers) => ledgers.into_iter().fold(Ledger::default(), Ledger::followed_by),
            Gathered::Part(recorded) => return Ok(recorded),
        };
        plan.pool(&mut ledger);
        let trials = ledger.rows.len();
        let failed = ledger.rows.iter().filter(|row| !row.error.is_empty()).count();
        let mut files = std::mem::take(&mut ledger.files);
        ledger.pictures.sort_by_key(|(page, _)| *page);
        if !ledger.pictures.is_empty() {
            let rows: Vec<_> = ledger.pictures.iter().map(|(_, row)| row).collect();
            files.push(RecordedFile::csv("pictures.csv", &rows)?);
        }
        files.extend([
            RecordedFile::csv("records.csv", &ledger.rows)?,
            RecordedFile::csv("views.csv", &ledger.views)?,
            RecordedFile::csv("counts.csv", &counting::counts(self))?,
            RecordedFile::csv("samples.csv", &timing::time(&plan, &stages[0])?)?,
        ]);
        Ok(Recorded { files, trials, failed, complete: true })
    }
}

impl Ledger {
    /// With what judging a later path has left.
    fn followed_by(mut self, later: Self) -> Self {
        self.rows.extend(later.rows);
        self.views.extend(later.views);
        self.pictures.extend(later.pictures);
        self.files.extend(later.files);
        for (view, key, outcomes) in later.pooled {
            self.add(&view, key, outcomes);
        }
        self
    }

    /// Pools outcomes with those of other scenes.
    pub(super) fn add(&mut self, view: &str, key: [usize; 4], outcomes: Vec<Outcome>) {
        match self.pooled.iter_mut().find(|(v, k, _)| (v.as_str(), k) == (view, &key)) {
            Some((_, _, all)) => all.extend(outcomes),
            None => self.pooled.push((view.to_owned(), key, outcomes)),
        }
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
                let at =
                    At { stage, path, frame, scenery: &scenery, sight, last, ages: &ages, largest, constant };
                album.film(&at, lighting);
                if let Some((now, then)) = &wholes {
                    let whole = (now.triangles(), then.as_ref().map(|then| then.triangles()));
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
