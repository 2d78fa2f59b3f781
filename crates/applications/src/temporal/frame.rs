//! One frame of soft shadows over time: the shadow buffer of the last frame becomes that of the next (TC09 section 3).

use rayon::prelude::*;

use super::{
    FilterSource, FrameSample, History, MovingCasters, Restart, ShadowEstimate, TemporalMethod,
    penumbra_width,
};
use crate::samples::PoissonTaps;

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
        if width.is_nan() || width <= 0.0 {
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

#[cfg(test)]
#[path = "frame_tests.rs"]
mod tests;
