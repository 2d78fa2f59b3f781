//! One frame of soft shadows over time: the shadow buffer of the last frame becomes that of the next (TC09 section 3).

use quantization::NumberFormat;
use rayon::prelude::*;
use thiserror::Error;

use super::{FrameSample, History, Restart, ShadowEstimate, penumbra_width};
use crate::samples::PoissonTaps;

/// From which buffer the neighbourhood filter takes its taps.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum FilterSource {
    /// There is no filter.
    Off,
    /// That of the last frame: what one pass over the screen can do (TC09 section 4).
    Previous,
    /// That of this frame, by another pass.
    Current,
}

/// What counts as a moving caster, for which the history of a pixel is thrown away (TC09 section 3.4).
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum MovingCasters {
    /// Nothing.
    Ignored,
    /// The sign of the texel that the pixel is tested against, as published: of one point of the light.
    Texel,
    /// Anything that moves among the taps of the blocker search: also where this frame's point of the light does not see it.
    Search,
}

/// How shadows are gathered over time. [`TemporalMethod::published`] is the paper, the rest are mends.
#[derive(Clone, Debug, PartialEq)]
pub struct TemporalMethod {
    /// n of percentage-closer soft shadows where a history begins; 0 begins with the frame's own test (equation 5 alone).
    pub start_tests: f64,
    /// k, depths that their average counts as.
    pub start_blockers: f64,
    /// t: from which standard error on the neighbourhood is asked.
    pub threshold: f64,
    /// epsilon of equation 4, a share of the distance from the eye.
    pub tolerance: f64,
    /// Largest difference in distance of neighbours that the filter averages, a share of the distance.
    pub depth_range: f64,
    /// Whether the standard error is that of one more test to either side, and so never 0.
    pub cautious: bool,
    /// Whether equation 7 averages blockers alone.
    pub blockers_only: bool,
    /// n at which counting ends: older tests fade. Infinite as published.
    pub most_tests: f64,
    /// Numbers of the shadow buffer.
    pub format: NumberFormat,
    /// Where the filter looks.
    pub filter: FilterSource,
    /// Whether the last buffer is interpolated between the pixels that belong, or read at the nearest one.
    pub interpolated: bool,
    /// Moving casters.
    pub moving: MovingCasters,
    /// Whether moving receivers are followed to where they were.
    pub follow: bool,
    /// Whether percentage-closer soft shadows use a second map, from the light's middle, instead of the frame's own.
    pub centre_map: bool,
    /// Whether tests are shadow rays in place of lookups: a map of unlimited resolution.
    pub exact: bool,
}

/// Why a method makes no sense.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key} = {value} {reason}")]
pub struct MethodError {
    /// The setting.
    pub key: &'static str,
    /// Its value.
    pub value: f64,
    /// What is wrong.
    pub reason: String,
}

/// A visible pixel in a frame; distances in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePixel {
    /// Distance from the eye along the view.
    pub depth: f64,
    /// Where the surface was seen in the last frame if it stood still: column and row in pixels of the buffer, and distance.
    pub before: [f64; 3],
    /// The same with its own movement.
    pub followed: [f64; 3],
    /// Distance of the surface from the light's plane.
    pub receiver: f64,
    /// tau.
    pub in_shadow: bool,
    /// The same by a shadow ray, where one was sent.
    pub hidden: bool,
    /// Distance from the light's plane of what the map saw.
    pub map_distance: f64,
    /// Whether that moves.
    pub moving: bool,
}

/// What percentage-closer soft shadows say of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// Share of shadow.
    pub fraction: f64,
    /// Average distance of blockers from the light's plane; `None` where there are none.
    pub blocker: Option<f64>,
    /// Whether any tap of the blocker search saw something that moves.
    pub moving: bool,
}

/// The buffer that goes from frame to frame, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowBuffer {
    width: usize,
    height: usize,
    pixels: Vec<Option<History>>,
}

/// What is shown of a pixel, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaded {
    /// Share of shadow as shown.
    pub shadow: f64,
    /// Share of shadow by the pixel's own tests.
    pub estimate: f64,
    /// Their number.
    pub tests: f64,
    /// The standard error that the method believes in.
    pub standard_error: f64,
    /// Whether its history began with this frame.
    pub restarted: bool,
    /// Whether neighbours were asked.
    pub filtered: bool,
    /// Lookups into maps and buffers.
    pub lookups: u32,
}

/// How pixels of a frame become lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// Full size of the light in world units.
    pub light_size: f64,
    /// Pixels per unit of length across the view at distance 1.
    pub pixels_per_unit: f64,
}

/// Lookups of percentage-closer soft shadows: 16 for the search, 16 for the filter.
const START_LOOKUPS: u32 = 32;

impl ShadowBuffer {
    /// A buffer without any history.
    pub fn empty(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![None; width * height] }
    }

    fn at(&self, x: f64, y: f64) -> Option<&History> {
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        if inside { self.pixels[y as usize * self.width + x as usize].as_ref() } else { None }
    }
}

impl TemporalMethod {
    /// As TC09 has it. It states no epsilon; these are a hundredth of the distance for both.
    pub fn published() -> Self {
        Self {
            start_tests: 4.0,
            start_blockers: 16.0,
            threshold: 1.0 / 50.0,
            tolerance: 0.01,
            depth_range: 0.01,
            cautious: false,
            blockers_only: false,
            most_tests: f64::INFINITY,
            format: NumberFormat::F16,
            filter: FilterSource::Previous,
            interpolated: false,
            moving: MovingCasters::Texel,
            follow: false,
            centre_map: false,
            exact: false,
        }
    }

    /// Rejects settings that make no sense. n must not be capped beyond what the format counts.
    ///
    /// # Errors
    /// [`MethodError`] with the setting and its value.
    pub fn check(&self) -> Result<(), MethodError> {
        let fail = |key, value, reason: &str| Err(MethodError { key, value, reason: reason.to_owned() });
        let shares =
            [("threshold", self.threshold), ("tolerance", self.tolerance), ("depth_range", self.depth_range)];
        for (key, value) in shares {
            if !(value > 0.0 && value < 1.0) {
                return fail(key, value, "does not lie in (0, 1)");
            }
        }
        for (key, value) in [("start_tests", self.start_tests), ("start_blockers", self.start_blockers)] {
            if !(0.0..=1024.0).contains(&value) {
                return fail(key, value, "does not lie in [0, 1024]");
            }
        }
        let counts = whole_numbers(self.format);
        if self.most_tests.is_finite() && self.most_tests > counts {
            let reason = format!("is more than the {counts} that {} counts", self.format);
            return fail("most_tests", self.most_tests, &reason);
        }
        if self.most_tests <= self.start_tests.max(1.0) {
            return fail("most_tests", self.most_tests, "leaves no test after the first");
        }
        if counts == 1.0 {
            return fail("format", counts, "is the largest number of this format, which cannot count");
        }
        Ok(())
    }

    /// One frame. `start` is asked for pixels without history, with the method's wish for the map of the light's middle.
    pub fn frame(
        &self,
        before: &ShadowBuffer,
        pixels: &[Option<FramePixel>],
        screen: &Screen,
        taps: &PoissonTaps,
        start: &(dyn Fn(usize, bool) -> Start + Sync),
    ) -> (ShadowBuffer, Vec<Option<Shaded>>) {
        let updated: Vec<Option<(History, Shaded)>> = pixels
            .par_iter()
            .enumerate()
            .map(|(i, pixel)| {
                pixel.as_ref().map(|pixel| self.updated(before, pixel, &|| start(i, self.centre_map)))
            })
            .collect();
        let (histories, mut shaded): (Vec<_>, Vec<_>) =
            updated.into_iter().map(|one| one.map_or((None, None), |(h, s)| (Some(h), Some(s)))).unzip();
        let after = ShadowBuffer { pixels: histories, ..ShadowBuffer { pixels: Vec::new(), ..*before } };
        let source = match self.filter {
            FilterSource::Off => return (after, shaded),
            FilterSource::Previous => before,
            FilterSource::Current => &after,
        };
        shaded.par_iter_mut().enumerate().for_each(|(i, shaded)| {
            if let (Some(shaded), Some(pixel), Some(history)) = (shaded, &pixels[i], &after.pixels[i])
                && shaded.standard_error > self.threshold
            {
                let centre = match self.filter {
                    FilterSource::Off | FilterSource::Previous => self.last_place(pixel),
                    FilterSource::Current => {
                        [(i % after.width) as f64 + 0.5, (i / after.width) as f64 + 0.5, pixel.depth]
                    }
                };
                self.smooth(source, centre, (pixel, history), (screen, taps), shaded);
            }
        });
        (after, shaded)
    }

    fn last_place(&self, pixel: &FramePixel) -> [f64; 3] {
        if self.follow { pixel.followed } else { pixel.before }
    }

    fn updated(
        &self,
        before: &ShadowBuffer,
        pixel: &FramePixel,
        start: &dyn Fn() -> Start,
    ) -> (History, Shaded) {
        let searched = (self.moving == MovingCasters::Search).then(start);
        let disturbed = match self.moving {
            MovingCasters::Ignored => false,
            MovingCasters::Texel => pixel.moving,
            MovingCasters::Search => searched.is_some_and(|found| found.moving),
        };
        let kept = if disturbed { None } else { self.history(before, self.last_place(pixel)) };
        let restarted = kept.is_none();
        // A lookup of the map and one of the buffer.
        let mut lookups = 2 + if searched.is_some() { START_LOOKUPS / 2 } else { 0 };
        let next = match kept {
            Some(history) => self.counted(&history, pixel),
            None if self.start_tests > 0.0 => {
                lookups += START_LOOKUPS - if searched.is_some() { START_LOOKUPS / 2 } else { 0 };
                self.begun(&searched.unwrap_or_else(start), pixel)
            }
            None => {
                let none = History::stored(ShadowEstimate::none(), pixel.depth, pixel.receiver, 0.0);
                self.counted(&none, pixel)
            }
        };
        let history = self.stored(&next);
        let estimate = history.estimate;
        let standard_error =
            if self.cautious { estimate.cautious_error() } else { estimate.standard_error() };
        let share = estimate.fraction().clamp(0.0, 1.0);
        let shaded = Shaded {
            shadow: share,
            estimate: share,
            tests: estimate.tests,
            standard_error,
            restarted,
            filtered: false,
            lookups,
        };
        (history, shaded)
    }

    /// The history of a place in the last buffer, where it is that of the same surface.
    fn history(&self, before: &ShadowBuffer, [x, y, depth]: [f64; 3]) -> Option<History> {
        let belongs = |history: &&History| history.belongs_to(depth, self.tolerance * depth);
        if !self.interpolated {
            return before.at(x, y).filter(belongs).copied();
        }
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (u, v) = (x - 0.5 - left, y - 0.5 - top);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let (mut weight, mut tests, mut shadowed, mut distance) = (0.0, 0.0, 0.0, 0.0);
        let (mut known, mut blocker, mut anyone) = (0.0, 0.0, 0.0);
        for (dx, dy) in corners {
            let share = (1.0 - (u - dx).abs()) * (1.0 - (v - dy).abs());
            let Some(history) = before.at(left + dx + 0.5, top + dy + 0.5).filter(belongs) else { continue };
            weight += share;
            tests += share * history.estimate.tests;
            shadowed += share * history.estimate.shadowed;
            distance += share * history.depth;
            // Averages count by what they are averages of.
            let of =
                share * if self.blockers_only { history.estimate.shadowed } else { history.estimate.tests };
            known += of;
            anyone += share * history.blocker;
            blocker += of * history.blocker;
        }
        // A corner that hardly touches says little of the pixel.
        (weight > LEAST_SHARE).then(|| {
            let estimate = ShadowEstimate { tests: tests / weight, shadowed: shadowed / weight };
            let blocker = if known > 0.0 { blocker / known } else { anyone / weight };
            History::stored(estimate, distance / weight, blocker, 0.0)
        })
    }

    fn begun(&self, start: &Start, pixel: &FramePixel) -> History {
        // Without a blocker there is no penumbra: the receiver itself stands for it.
        let blocker = start.blocker.unwrap_or(pixel.receiver);
        let (tests, blockers) = (self.start_tests, self.start_blockers);
        History::restarted(&Restart { fraction: start.fraction, blocker, tests, blockers }, pixel.depth)
    }

    /// One more test.
    fn counted(&self, history: &History, pixel: &FramePixel) -> History {
        let mut estimate = history.estimate;
        if estimate.tests >= self.most_tests {
            let share = (self.most_tests - 1.0) / estimate.tests;
            estimate = ShadowEstimate { tests: share * estimate.tests, shadowed: share * estimate.shadowed };
        }
        // The buffer has four channels, and none for the count of the average: it follows from n, or from rho, which is how
        // many blockers there were.
        let (samples, blockers) = if self.blockers_only {
            (estimate.shadowed, 0.0)
        } else {
            let tests = (estimate.tests - self.start_tests).max(0.0);
            (tests, if self.start_tests > 0.0 { self.start_blockers } else { 0.0 })
        };
        let in_shadow = if self.exact { pixel.hidden } else { pixel.in_shadow };
        let sample = FrameSample { depth: pixel.depth, in_shadow, map_depth: pixel.map_distance };
        let start = Restart { fraction: 0.0, blocker: 0.0, tests: self.start_tests, blockers };
        History::stored(estimate, history.depth, history.blocker, samples).with(
            &sample,
            &start,
            self.blockers_only,
        )
    }

    /// What the buffer keeps of it.
    fn stored(&self, history: &History) -> History {
        let kept = |value: f64| f64::from(self.format.round_single(value as f32));
        let estimate =
            ShadowEstimate { tests: kept(history.estimate.tests), shadowed: kept(history.estimate.shadowed) };
        History::stored(estimate, kept(history.depth), kept(history.blocker), 0.0)
    }

    /// A box over the penumbra's width, by taps of like depth (TC09 section 3.3).
    fn smooth(
        &self,
        source: &ShadowBuffer,
        [x, y, depth]: [f64; 3],
        (pixel, history): (&FramePixel, &History),
        (screen, taps): (&Screen, &PoissonTaps),
        shaded: &mut Shaded,
    ) {
        let width = penumbra_width(
            screen.light_size,
            pixel.receiver,
            history.blocker.max(LEAST_BLOCKER * pixel.receiver),
            screen.pixels_per_unit,
            pixel.depth,
        );
        shaded.filtered = true;
        shaded.lookups += taps.points().len() as u32;
        // Not of NaN either; a blocker behind the receiver has no penumbra.
        if !(width > 0.0) {
            return;
        }
        let (mut sum, mut count) = (shaded.estimate, 1.0);
        for &[u, v] in taps.points() {
            let tap = source.at(x + 0.5 * width * u, y + 0.5 * width * v);
            if let Some(tap) = tap.filter(|tap| tap.belongs_to(depth, self.depth_range * depth)) {
                sum += tap.estimate.fraction().clamp(0.0, 1.0);
                count += 1.0;
            }
        }
        shaded.shadow = sum / count;
    }
}

/// Least share of interpolated neighbours that belong.
const LEAST_SHARE: f64 = 0.1;

/// Nearest blocker as a share of the receiver's distance: the penumbra of one at the light has no limit.
const LEAST_BLOCKER: f64 = 1e-3;

/// Up to where a format holds every whole number.
fn whole_numbers(format: NumberFormat) -> f64 {
    match format {
        NumberFormat::F16 => 2048.0,
        NumberFormat::F32 => 16_777_216.0,
        NumberFormat::Unorm10 | NumberFormat::Unorm16 | NumberFormat::U32Fixed { .. } => 1.0,
    }
}

#[cfg(test)]
#[path = "frame_tests.rs"]
mod tests;
