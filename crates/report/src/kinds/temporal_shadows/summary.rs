//! What the records of a `temporal-shadows` experiment say, in numbers.

use crate::kinds::rows::tables;
use crate::page::{Measured, Text, percent, player, recorded};
use evaluation::{
    CountRecord, PathSetting, TemporalPictureRecord, TemporalRecord, TemporalShadowsExperiment,
    TemporalViewRecord, TimedSample, with_role,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    TemporalTables<'a> of TemporalShadowsExperiment {
        records: TemporalRecord,
        views: TemporalViewRecord,
        counts: CountRecord,
        samples: TimedSample,
    }
    some_runs {
        pictures: TemporalPictureRecord,
    }
}

/// Roles of the methods that people ask for: what gathers, then what does not.
pub(super) const ASKED: [&str; 9] = [
    "sampling",
    "published",
    "mended",
    "PCSS 16/16",
    "PCSS 32/32",
    "two moments",
    "four moments",
    "stochastic",
    "stochastic, mended",
];

/// Roles of single mends.
pub(super) const MENDS: [&str; 10] = [
    "published in f32",
    "start of weight 1",
    "cautious",
    "blockers only",
    "filter in this frame",
    "interpolated",
    "start from the middle",
    "casters searched",
    "receivers followed",
    "capped",
];

impl TemporalTables<'_> {
    /// The row of a technique over all scenes.
    pub(super) fn row(
        &self,
        at: (&str, &str, usize),
        technique: &str,
        class: &str,
    ) -> Option<&TemporalRecord> {
        self.row_of("all", at, technique, class)
    }

    /// The row of a technique in a scene.
    pub(super) fn row_of(
        &self,
        scene: &str,
        (light, path, frame): (&str, &str, usize),
        technique: &str,
        class: &str,
    ) -> Option<&TemporalRecord> {
        self.records.iter().find(|r| {
            r.scene == scene
                && r.light == light
                && r.path == path
                && r.frame == frame
                && r.technique == technique
                && r.class == class
        })
    }

    /// In the last judged frame of a path.
    pub(super) fn last(
        &self,
        (light, path): (&str, &PathSetting),
        technique: &str,
        class: &str,
    ) -> Option<&TemporalRecord> {
        let frame = *path.judged.last()?;
        self.row((light, &path.name, frame), technique, class)
    }

    /// The path on which nothing moves, and the one on which a part does.
    pub(super) fn still(&self) -> Option<&PathSetting> {
        self.experiment.path.iter().find(|path| path.is_still())
    }

    pub(super) fn moving(&self) -> Option<&PathSetting> {
        self.experiment.path.iter().find(|path| path.moving)
    }

    /// Paths of a camera that moves steadily.
    pub(super) fn steady(&self) -> impl Iterator<Item = &PathSetting> {
        self.experiment.path.iter().filter(|path| !path.moving && !path.is_still() && !path.is_cut())
    }

    pub(super) fn lights(&self) -> impl Iterator<Item = &str> {
        self.experiment.light.iter().map(|light| light.name.as_str())
    }

    /// The light in the middle of the list: neither the smallest nor the largest.
    pub(super) fn middle(&self) -> Option<&str> {
        self.experiment
            .light
            .get((self.experiment.light.len().saturating_sub(1)) / 2)
            .map(|light| light.name.as_str())
    }

    pub(super) fn named(&self, role: &str) -> Option<&str> {
        with_role(&self.experiment.technique, role).map(|technique| technique.name.as_str())
    }

    /// The row of whoever has a role under the middle light.
    pub(super) fn playing(
        &self,
        role: &'static str,
        path: Option<&PathSetting>,
        frame: Option<usize>,
        class: &str,
    ) -> Measured<&TemporalRecord> {
        let name = &player(&self.experiment.technique, role)?.name;
        let (light, path) = (recorded(self.middle())?, recorded(path)?);
        let frame = recorded(frame.or(path.judged.last().copied()))?;
        let row = self.row((light, &path.name, frame), name, class);
        recorded(row.filter(|row| row.receivers > 0))
    }

    /// The answer to the experiment's question.
    pub(super) fn answer(&self) -> Vec<Text> {
        let sentences = [
            self.closest(),
            self.convergence(),
            self.by_rays(),
            self.ghosts(),
            self.counting(),
            self.truth(),
        ];
        sentences.into_iter().flatten().map(Text::from).collect()
    }

    /// Who is nearest to the truth, by light and path.
    fn closest(&self) -> Option<String> {
        let mut parts = Vec::new();
        for path in &self.experiment.path {
            let best = |light: &str| {
                let rows = ASKED.iter().filter_map(|role| self.last((light, path), self.named(role)?, "all"));
                let least = rows.min_by(|a, b| a.l1_error.total_cmp(&b.l1_error))?;
                Some(format!("{} {} ({light} light)", least.technique, percent(least.l1_error, 2)))
            };
            let all: Vec<String> = self.lights().filter_map(best).collect();
            if !all.is_empty() {
                parts.push(format!("on the path \"{}\" {}", path.name, all.join(", ")));
            }
        }
        let text = parts.join("; ");
        (!parts.is_empty()).then(|| format!("Closest to the area light in the last judged frame: {text}."))
    }

    fn convergence(&self) -> Option<String> {
        let (path, light) = (self.still()?, self.middle()?);
        let errors = |role: &str| {
            let name = self.named(role)?;
            let of = |frame: &usize| {
                self.row((light, &path.name, *frame), name, "all").map(|r| percent(r.l1_error, 2))
            };
            Some(format!("{name} {}", path.judged.iter().filter_map(of).collect::<Vec<_>>().join(", ")))
        };
        let all: Vec<String> =
            ["sampling", "published", "mended"].iter().filter_map(|role| errors(role)).collect();
        let frames: Vec<String> = path.judged.iter().map(ToString::to_string).collect();
        (!all.is_empty())
            .then(|| format!("With nothing moving, after {} frames: {}.", frames.join(", "), all.join("; ")))
    }

    fn by_rays(&self) -> Option<String> {
        let (path, light) = (self.still()?, self.middle()?);
        let row = self.last((light, path), self.named("sampling by rays")?, "penumbra")?;
        Some(format!(
            "By shadow rays in place of maps {} frames err by {} in penumbrae, where the method believes in {}: {} of pixels lie \
             within one standard error of the truth.",
            row.frame,
            percent(row.estimate_rms?, 2),
            percent(row.believed_rms?, 2),
            percent(row.within?, 0)
        ))
    }

    fn ghosts(&self) -> Option<String> {
        let (path, light) = (self.moving()?, self.middle()?);
        let of = |role: &str| {
            let name = self.named(role)?;
            let row = self.last((light, path), name, "changed").filter(|row| row.receivers > 0)?;
            Some(format!("{name} {}", percent(row.l1_error, 1)))
        };
        let all: Vec<String> = ASKED.iter().filter_map(|role| of(role)).collect();
        (!all.is_empty()).then(|| format!("Where moving shadows are and were: {}.", all.join(", ")))
    }

    fn counting(&self) -> Option<String> {
        let name = self.named("published")?;
        let last = self.counts.iter().filter(|r| r.technique == name).max_by_key(|r| r.frames)?;
        Some(format!(
            "After {} frames of one pixel {name} ({}) has counted {:.0} tests and errs by {}.",
            last.frames,
            last.format,
            last.tests,
            percent(last.mean_error, 1)
        ))
    }

    fn truth(&self) -> Option<String> {
        let largest = self.views.iter().map(|view| view.largest_standard_error).max_by(f64::total_cmp)?;
        Some(format!("The truth of every pixel has a standard error of at most {}.", percent(largest, 2)))
    }
}
