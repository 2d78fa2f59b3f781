//! Classes of view rays, and the rows of groups of them.

use super::records::ScatteringRecord;
use crate::statistics::{Sums, percentile, rounded};

/// Depth steps along the rectified row up to the end of a ray.
pub(super) const STEPS: [&str; 5] = ["0-1", "2-3", "4-7", "8-15", "16+"];

/// Degrees between a ray and the light's axis.
pub(super) const EPIPOLE: [&str; 5] = ["0-5", "5-15", "15-30", "30-60", "60-90"];

/// A step of normalised depth that counts.
pub(super) const LEAST_STEP: f64 = 0.02;

pub(super) fn steps_class(steps: usize) -> usize {
    [2, 4, 8, 16].iter().filter(|&&least| steps >= least).count()
}

pub(super) fn epipole_class(degrees: f64) -> usize {
    [5.0, 15.0, 30.0, 60.0].iter().filter(|&&least| degrees >= least).count()
}

/// One technique on one ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    /// NaN where it failed.
    pub(super) answer: f32,
    pub(super) truth: f32,
    /// By shadow rays.
    pub(super) geometry: f32,
    pub(super) steps: u8,
    pub(super) epipole: u8,
}

/// Which rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Class<'a> {
    All,
    /// Rays of one standpoint; chosen by the caller.
    Standpoint(&'a str),
    Steps(usize),
    Epipole(usize),
}

impl<'a> Class<'a> {
    /// Classes of rays whatever their camera.
    pub(super) fn each() -> impl Iterator<Item = Class<'static>> {
        let steps = (0..STEPS.len()).map(Class::Steps);
        [Class::All].into_iter().chain(steps).chain((0..EPIPOLE.len()).map(Class::Epipole))
    }

    fn holds(self, outcome: &Outcome) -> bool {
        match self {
            Self::All | Self::Standpoint(_) => true,
            Self::Steps(steps) => usize::from(outcome.steps) == steps,
            Self::Epipole(epipole) => usize::from(outcome.epipole) == epipole,
        }
    }

    fn names(self) -> [&'a str; 2] {
        match self {
            Self::All => ["all", "all"],
            Self::Standpoint(name) => ["standpoint", name],
            Self::Steps(steps) => ["steps", STEPS[steps]],
            Self::Epipole(epipole) => ["epipole", EPIPOLE[epipole]],
        }
    }
}

/// Names of a group.
pub(super) struct Group<'a> {
    pub(super) scene: &'a str,
    pub(super) view: &'a str,
    pub(super) standpoint: &'a str,
    pub(super) technique: &'a str,
    pub(super) class: Class<'a>,
    /// Whether the group is a sample.
    pub(super) sampled: bool,
    pub(super) bits_per_texel: usize,
}

/// The row of a group. The order of the outcomes is fixed, and so are the rounding errors of the sums.
pub(super) fn record(group: &Group<'_>, outcomes: &[Outcome], error: &str) -> ScatteringRecord {
    let members: Vec<&Outcome> = outcomes.iter().filter(|outcome| group.class.holds(outcome)).collect();
    let answered: Vec<&Outcome> = members.iter().filter(|o| o.answer.is_finite()).copied().collect();
    let (mut map, mut geometry) = (Sums::default(), Sums::default());
    for outcome in &answered {
        map.push(outcome.answer - outcome.truth, outcome.truth);
        geometry.push(outcome.answer - outcome.geometry, outcome.geometry);
    }
    let mut errors: Vec<f64> = answered.iter().map(|o| f64::from((o.answer - o.truth).abs())).collect();
    errors.sort_by(f64::total_cmp);
    let [name, class] = group.class.names();
    ScatteringRecord {
        application: "single scattering".to_owned(),
        scene: group.scene.to_owned(),
        view: group.view.to_owned(),
        standpoint: group.standpoint.to_owned(),
        technique: group.technique.to_owned(),
        group: name.to_owned(),
        class: class.to_owned(),
        rays: members.len(),
        l1_error: rounded(map.mean()),
        standard_error: group.sampled.then(|| rounded(map.standard_error())),
        signed_mean: rounded(map.signed / map.count.max(1) as f64),
        p95: rounded(percentile(&errors, 0.95)),
        maximum: rounded(errors.last().copied().unwrap_or_default()),
        geometry_error: rounded(geometry.mean()),
        bits_per_texel: group.bits_per_texel,
        failed: members.len() - answered.len(),
        error: error.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_fall_into_classes() {
        assert_eq!(
            [0, 1, 2, 7, 8, 16, 99].map(|steps| STEPS[steps_class(steps)]),
            ["0-1", "0-1", "2-3", "4-7", "8-15", "16+", "16+"]
        );
        assert_eq!(
            [0.0, 5.0, 29.9, 90.0].map(|d| EPIPOLE[epipole_class(d)]),
            ["0-5", "5-15", "15-30", "60-90"]
        );
    }

    #[test]
    fn statistics_of_a_known_group() {
        let outcome = |answer, truth, geometry, steps| Outcome { answer, truth, geometry, steps, epipole: 4 };
        let outcomes =
            [outcome(0.75, 0.5, 0.5, 0), outcome(0.25, 0.5, 0.75, 3), outcome(f32::NAN, 0.5, 0.5, 3)];
        let group = |class, sampled| Group {
            scene: "s",
            view: "v",
            standpoint: "c",
            technique: "t",
            class,
            sampled,
            bits_per_texel: 64,
        };
        let all = record(&group(Class::All, false), &outcomes, "");
        assert_eq!((all.rays, all.failed, all.l1_error, all.signed_mean), (3, 1, 0.25, 0.0));
        assert_eq!((all.geometry_error, all.p95, all.maximum, all.standard_error), (0.375, 0.25, 0.25, None));
        let complex = record(&group(Class::Steps(3), true), &outcomes, "");
        assert_eq!((complex.rays, complex.failed, complex.class.as_str()), (2, 1, "8-15"));
        assert_eq!((complex.signed_mean, complex.standard_error), (-0.25, Some(0.0)));
        assert_eq!(record(&group(Class::Epipole(0), true), &outcomes, "").rays, 0);
        assert_eq!(Class::each().count(), 11);
    }
}
