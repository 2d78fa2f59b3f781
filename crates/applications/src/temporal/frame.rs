//! One frame of soft shadows over time: the shadow buffer of the last frame becomes that of the next (TC09 section 3).

use moment_problem::arithmetic::Real;
use rayon::prelude::*;
use std::cmp::Ordering;

use super::{
    FilterSource, FrameSample, History, MovingCasters, Restart, ShadowEstimate, TemporalMethod,
    penumbra_width,
};
use crate::samples::PoissonTaps;

/// A visible pixel in a frame; distances in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FramePixel<R = f64> {
    /// Distance from the eye along the view.
    pub depth: R,
    /// Where the surface was seen in the last frame if it stood still: column and row in pixels of the buffer, and distance.
    pub before: [R; 3],
    /// The same with its own movement.
    pub followed: [R; 3],
    /// Distance of the surface from the light's plane.
    pub receiver: R,
    /// tau.
    pub in_shadow: bool,
    /// The same by a shadow ray, where one was sent.
    pub hidden: bool,
    /// Distance from the light's plane of what the map saw.
    pub map_distance: R,
    /// Whether that moves.
    pub moving: bool,
}

/// What percentage-closer soft shadows say of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start<R = f64> {
    /// Share of shadow.
    pub fraction: R,
    /// Average distance of blockers from the light's plane; `None` where there are none.
    pub blocker: Option<R>,
    /// Whether any tap of the blocker search saw something that moves.
    pub moving: bool,
}

/// The buffer that goes from frame to frame, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowBuffer<R = f64> {
    width: usize,
    height: usize,
    pixels: Vec<Option<History<R>>>,
}

/// What is shown of a pixel, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaded<R = f64> {
    /// Share of shadow as shown.
    pub shadow: R,
    /// Share of shadow by the pixel's own tests.
    pub estimate: R,
    /// Their number.
    pub tests: R,
    /// The standard error that the method believes in.
    pub standard_error: R,
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

impl<R: Real> ShadowBuffer<R> {
    /// A buffer without any history.
    pub fn empty(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![None; width * height] }
    }

    fn at(&self, x: R, y: R) -> Option<&History<R>> {
        let (x, y) = (x.to_f64(), y.to_f64());
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        if inside { self.pixels[y as usize * self.width + x as usize].as_ref() } else { None }
    }
}

impl TemporalMethod {
    /// One frame. `start` is asked for pixels without history, with the method's wish for the map of the light's middle.
    pub fn frame<R: Real + Send + Sync>(
        &self,
        before: &ShadowBuffer<R>,
        pixels: &[Option<FramePixel<R>>],
        screen: &Screen,
        taps: &PoissonTaps,
        start: &(dyn Fn(usize, bool) -> Start<R> + Sync),
    ) -> (ShadowBuffer<R>, Vec<Option<Shaded<R>>>) {
        let updated: Vec<Option<(History<R>, Shaded<R>)>> = pixels
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
                && shaded.standard_error > R::from_f64(self.threshold)
            {
                let centre = match self.filter {
                    FilterSource::Off | FilterSource::Previous => self.last_place(pixel),
                    FilterSource::Current => {
                        let [x, y] = [i % after.width, i / after.width];
                        [R::from_f64(x as f64 + 0.5), R::from_f64(y as f64 + 0.5), pixel.depth]
                    }
                };
                self.smooth(source, centre, (pixel, history), (screen, taps), shaded);
            }
        });
        (after, shaded)
    }

    pub(super) fn last_place<R: Real>(&self, pixel: &FramePixel<R>) -> [R; 3] {
        if self.follow { pixel.followed } else { pixel.before }
    }

    fn updated<R: Real>(
        &self,
        before: &ShadowBuffer<R>,
        pixel: &FramePixel<R>,
        start: &dyn Fn() -> Start<R>,
    ) -> (History<R>, Shaded<R>) {
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
                let none = History::stored(ShadowEstimate::none(), pixel.depth, pixel.receiver, R::zero());
                self.counted(&none, pixel)
            }
        };
        let history = self.stored(&next);
        let estimate = history.estimate;
        let standard_error =
            if self.cautious { estimate.cautious_error() } else { estimate.standard_error() };
        let share = estimate.fraction().clamp_unit();
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
    fn history<R: Real>(&self, before: &ShadowBuffer<R>, [x, y, depth]: [R; 3]) -> Option<History<R>> {
        let tolerance = R::from_f64(self.tolerance);
        let belongs = |history: &&History<R>| history.belongs_to(depth, tolerance * depth);
        if !self.interpolated {
            return before.at(x, y).filter(belongs).copied();
        }
        let (zero, one, half) = (R::zero(), R::one(), R::from_f64(0.5));
        let floor = |t: R| R::from_f64((t - half).to_f64().floor());
        let (left, top) = (floor(x), floor(y));
        let (u, v) = (x - half - left, y - half - top);
        let corners = [(zero, zero), (one, zero), (zero, one), (one, one)];
        let (mut weight, mut tests, mut shadowed, mut distance) = (zero, zero, zero, zero);
        let (mut known, mut blocker, mut anyone) = (zero, zero, zero);
        for (dx, dy) in corners {
            let share = (one - (u - dx).abs()) * (one - (v - dy).abs());
            let place = [left + dx + half, top + dy + half];
            let Some(history) = before.at(place[0], place[1]).filter(belongs) else { continue };
            weight = weight + share;
            tests = tests + share * history.estimate.tests;
            shadowed = shadowed + share * history.estimate.shadowed;
            distance = distance + share * history.depth;
            // Averages count by what they are averages of.
            let of =
                share * if self.blockers_only { history.estimate.shadowed } else { history.estimate.tests };
            known = known + of;
            anyone = anyone + share * history.blocker;
            blocker = blocker + of * history.blocker;
        }
        // A corner that hardly touches says little of the pixel.
        (weight > R::from_f64(LEAST_SHARE)).then(|| {
            let estimate = ShadowEstimate { tests: tests / weight, shadowed: shadowed / weight };
            let blocker = if known > zero { blocker / known } else { anyone / weight };
            History::stored(estimate, distance / weight, blocker, zero)
        })
    }

    fn begun<R: Real>(&self, start: &Start<R>, pixel: &FramePixel<R>) -> History<R> {
        // Without a blocker there is no penumbra: the receiver itself stands for it.
        let blocker = start.blocker.unwrap_or(pixel.receiver);
        let (tests, blockers) = (R::from_f64(self.start_tests), R::from_f64(self.start_blockers));
        History::restarted(&Restart { fraction: start.fraction, blocker, tests, blockers }, pixel.depth)
    }

    /// One more test.
    fn counted<R: Real>(&self, history: &History<R>, pixel: &FramePixel<R>) -> History<R> {
        let (zero, start_tests) = (R::zero(), R::from_f64(self.start_tests));
        let mut estimate = history.estimate;
        let most_tests = R::from_f64(self.most_tests);
        if estimate.tests >= most_tests {
            let share = (most_tests - R::one()) / estimate.tests;
            estimate = ShadowEstimate { tests: share * estimate.tests, shadowed: share * estimate.shadowed };
        }
        // The buffer has four channels, and none for the count of the average: it follows from n, or from rho, which is how
        // many blockers there were.
        let (samples, blockers) = if self.blockers_only {
            (estimate.shadowed, zero)
        } else {
            let tests = (estimate.tests - start_tests).max(zero);
            (tests, if self.start_tests > 0.0 { R::from_f64(self.start_blockers) } else { zero })
        };
        let in_shadow = if self.exact { pixel.hidden } else { pixel.in_shadow };
        let sample = FrameSample { depth: pixel.depth, in_shadow, map_depth: pixel.map_distance };
        let start = Restart { fraction: zero, blocker: zero, tests: start_tests, blockers };
        History::stored(estimate, history.depth, history.blocker, samples).with(
            &sample,
            &start,
            self.blockers_only,
        )
    }

    /// What the buffer keeps of it.
    fn stored<R: Real>(&self, history: &History<R>) -> History<R> {
        let kept = |value: R| R::from_f64(f64::from(self.format.round_single(value.to_f64() as f32)));
        let estimate =
            ShadowEstimate { tests: kept(history.estimate.tests), shadowed: kept(history.estimate.shadowed) };
        History::stored(estimate, kept(history.depth), kept(history.blocker), R::zero())
    }

    /// A box over the penumbra's width, by taps of like depth (TC09 section 3.3).
    fn smooth<R: Real>(
        &self,
        source: &ShadowBuffer<R>,
        [x, y, depth]: [R; 3],
        (pixel, history): (&FramePixel<R>, &History<R>),
        (screen, taps): (&Screen, &PoissonTaps),
        shaded: &mut Shaded<R>,
    ) {
        let width = penumbra_width(
            R::from_f64(screen.light_size),
            pixel.receiver,
            history.blocker.max(R::from_f64(LEAST_BLOCKER) * pixel.receiver),
            R::from_f64(screen.pixels_per_unit),
            pixel.depth,
        );
        shaded.filtered = true;
        shaded.lookups += taps.points().len() as u32;
        // Not of NaN either; a blocker behind the receiver has no penumbra.
        if width.partial_cmp(&R::zero()) != Some(Ordering::Greater) {
            return;
        }
        let (half, range) = (R::from_f64(0.5), R::from_f64(self.depth_range));
        let (mut sum, mut count) = (shaded.estimate, R::one());
        for point in taps.points() {
            let [u, v] = point.map(R::from_f64);
            let tap = source.at(x + half * width * u, y + half * width * v);
            if let Some(tap) = tap.filter(|tap| tap.belongs_to(depth, range * depth)) {
                sum = sum + tap.estimate.fraction().clamp_unit();
                count = count + R::one();
            }
        }
        shaded.shadow = sum / count;
    }
}

/// Least share of interpolated neighbours that belong.
pub(super) const LEAST_SHARE: f64 = 0.1;

/// Nearest blocker as a share of the receiver's distance: the penumbra of one at the light has no limit.
pub(super) const LEAST_BLOCKER: f64 = 1e-3;

#[cfg(test)]
#[path = "frame_tests.rs"]
mod tests;
