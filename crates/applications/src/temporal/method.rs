//! How shadows are gathered over time, as published and mended.

use quantization::NumberFormat;
use thiserror::Error;

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
}

/// Up to where a format holds every whole number.
fn whole_numbers(format: NumberFormat) -> f64 {
    match format {
        NumberFormat::F16 => 2048.0,
        NumberFormat::F32 => 16_777_216.0,
        NumberFormat::Unorm8
        | NumberFormat::Unorm10
        | NumberFormat::Unorm16
        | NumberFormat::U32Fixed { .. } => 1.0,
    }
}
