//! What the records of a `speed-accuracy` experiment say, in numbers.

use crate::kinds::rows::{distinct, tables};
use crate::page::{Measured, Text, median_of, percent, player};
use evaluation::{
    FrameSample, GpuRecord, OrderShare, SpeedAccuracyExperiment, SpeedAccuracyRecord, SpeedSample, ViewRecord,
};

tables! {
    /// The recorded tables of a run, with its experiment.
    SpeedTables<'a> of SpeedAccuracyExperiment {
        records: SpeedAccuracyRecord,
        orders: OrderShare,
        views: ViewRecord,
        samples: SpeedSample,
    }
    some_runs {
        gpu: GpuRecord,
        frames: FrameSample,
    }
}

/// Nanoseconds an item over the rounds.
#[derive(Clone, Copy)]
pub(crate) struct Time {
    pub(crate) least: f64,
    pub(crate) median: f64,
    pub(crate) most: f64,
}

impl<'a> SpeedTables<'a> {
    /// Every technique, format and size with its best biases, over all fragments.
    pub(crate) fn best(&self) -> impl Iterator<Item = &SpeedAccuracyRecord> {
        self.records.iter().filter(|r| r.best && r.scene == "all" && r.view == "all")
    }

    /// Side of the largest map.
    pub(crate) fn full_size(&self) -> u32 {
        self.records.iter().map(|r| r.size).max().unwrap_or_default()
    }

    /// [`SpeedTables::best`] on the largest map.
    pub(crate) fn full(&self) -> Vec<&SpeedAccuracyRecord> {
        let size = self.full_size();
        self.best().filter(|r| r.size == size).collect()
    }

    /// The front of error against modelled cost, cheapest first.
    pub(crate) fn front(&self) -> Vec<&SpeedAccuracyRecord> {
        let mut front: Vec<_> = self.best().filter(|r| r.on_front == Some(true)).collect();
        front.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        front
    }

    /// Sides of maps, the largest first.
    pub(crate) fn sizes(&self) -> Vec<u32> {
        let mut sizes = distinct(self.best().map(|r| r.size));
        sizes.sort_unstable_by(|a, b| b.cmp(a));
        sizes
    }

    /// Name and format of the candidate with this role.
    pub(crate) fn player(&self, role: &'static str) -> Measured<(&'a str, String)> {
        let player = player(&self.experiment.technique, role)?;
        Ok((&player.name, player.format()))
    }

    /// The record of the candidate with this role on the map of this size.
    fn of(&self, role: &'static str, size: u32) -> Option<&SpeedAccuracyRecord> {
        let (name, format) = self.player(role).ok()?;
        self.best().find(|r| r.technique == name && r.format == format && r.size == size)
    }

    /// The same technique in the same format and size on a part of the fragments.
    pub(crate) fn part(
        &self,
        of: &SpeedAccuracyRecord,
        scene: &str,
        view: &str,
    ) -> Option<&SpeedAccuracyRecord> {
        self.records.iter().find(|r| {
            r.best
                && r.scene == scene
                && r.view == view
                && r.technique == of.technique
                && r.format == of.format
                && r.size == of.size
        })
    }

    pub(crate) fn scenes(&self) -> Vec<&str> {
        distinct(self.views.iter().map(|view| view.scene.as_str()))
    }

    /// Time an item of a stage.
    pub(crate) fn time(&self, technique: &str, format: &str, precision: &str, stage: &str) -> Option<Time> {
        let of_stage = self.samples.iter().filter(|s| {
            s.technique == technique && s.format == format && s.precision == precision && s.stage == stage
        });
        let mut times: Vec<f64> = of_stage.map(|s| s.time_ns as f64 / s.items.max(1) as f64).collect();
        times.sort_by(f64::total_cmp);
        let (least, most) = (*times.first()?, *times.last()?);
        Some(Time { least, median: times[times.len() / 2], most })
    }

    /// Median over the rounds of a time divided by that of the first technique in the same round.
    pub(crate) fn ratio(&self, technique: &str, format: &str, precision: &str, stage: &str) -> Option<f64> {
        let unit = self.samples.first()?;
        let of = |technique: &str, format: &str, repetition: usize| {
            let found = self.samples.iter().find(|s| {
                s.technique == technique
                    && s.format == format
                    && s.precision == precision
                    && s.stage == stage
                    && s.repetition == repetition
            })?;
            Some(found.time_ns as f64 / found.items.max(1) as f64)
        };
        let mut ratios = Vec::new();
        for repetition in 0.. {
            let Some(time) = of(technique, format, repetition) else { break };
            ratios.push(time / of(&unit.technique, &unit.format, repetition)?);
        }
        median_of(ratios)
    }

    /// Shares of kernels by what they need, each view counting alike: (needs, share).
    pub(crate) fn needs(&self, scene: &str, by: &str, tolerance: f64) -> Vec<(String, f64)> {
        let mut totals: Vec<(String, f64)> = Vec::new();
        let rows = self
            .orders
            .iter()
            .filter(|o| o.by == by && o.tolerance == tolerance && (scene == "all" || o.scene == scene));
        for row in rows {
            match totals.iter_mut().find(|(needs, _)| *needs == row.needs) {
                Some((_, total)) => *total += row.share,
                None => totals.push((row.needs.clone(), row.share)),
            }
        }
        let sum: f64 = totals.iter().map(|(_, total)| total).sum();
        totals.iter_mut().for_each(|(_, total)| *total /= sum.max(f64::MIN_POSITIVE));
        totals
    }

    /// Kinds of need: (by, tolerance), in the order of the file.
    pub(crate) fn need_kinds(&self) -> Vec<(&str, f64)> {
        distinct(self.orders.iter().map(|row| (row.by.as_str(), row.tolerance)))
    }

    /// The answer to the experiment's question.
    pub(crate) fn answer(&self) -> Vec<Text> {
        let share = |value| percent(value, 0);
        let percent = |value| percent(value, 2);
        let mut sentences: Vec<String> = Vec::new();
        let (full, vsm, msm) = (self.full_size(), "VSM, 32 bits", "four moments, 16 bits");
        let vsm = self.of(vsm, full);
        if let (Some(vsm), Some(msm)) = (vsm, self.of(msm, full)) {
            sentences.push(format!(
                "Four moments in {} bits err by {}, variance shadow maps in {} bits by {}, at {:.2} times the modelled cost.",
                msm.bits_per_texel,
                percent(msm.l1_error),
                vsm.bits_per_texel,
                percent(vsm.l1_error),
                msm.cost / vsm.cost
            ));
            if let Some(ratio) = self.ratio(&msm.technique, &msm.format, "f32", "shade") {
                sentences.push(format!(
                    "On a CPU, single precision, shading with them takes {ratio:.1} times as long, and filtering {:.2} times.",
                    self.ratio(&msm.technique, &msm.format, "f32", "filter").unwrap_or(f64::NAN)
                ));
            }
        }
        if let (Some(vsm), Some(halved)) = (vsm, self.of(msm, full / 2)) {
            sentences.push(format!(
                "On a map of half the side they err by {} at {:.2} times the cost of variance shadow maps on the whole.",
                percent(halved.l1_error),
                halved.cost / vsm.cost
            ));
        }
        let front = self.front();
        if let (Some(cheapest), Some(best)) = (front.first(), front.last()) {
            let of = |r: &SpeedAccuracyRecord| {
                format!(
                    "{} in {} at {} ({}, cost {:.2})",
                    r.technique,
                    r.format,
                    r.size,
                    percent(r.l1_error),
                    r.cost
                )
            };
            sentences.push(format!(
                "Of {} combinations {} have none beside them that is both cheaper and more accurate, from {} to {}.",
                self.best().count(),
                front.len(),
                of(cheapest),
                of(best)
            ));
        }
        // The other tolerances are in the tables.
        let kinds = self.need_kinds();
        let middle = |by: &str| {
            let of_kind: Vec<_> = kinds.iter().filter(|kind| kind.0 == by).collect();
            of_kind.get(of_kind.len() / 2).copied().copied()
        };
        for (by, tolerance) in ["rank", "loss"].into_iter().filter_map(middle) {
            let shares: Vec<String> = self
                .needs("all", by, tolerance)
                .iter()
                .map(|(needs, part)| format!("{needs}: {}", share(*part)))
                .collect();
            sentences.push(match by {
                "rank" => {
                    format!("Kernels by number of surfaces (rank at {tolerance:e}): {}.", shares.join(", "))
                }
                _ => format!("Moments that lose less than {tolerance} to PCF: {}.", shares.join(", ")),
            });
        }
        sentences.push(self.gpu_sentence());
        sentences.into_iter().map(Text::from).collect()
    }
}
