//! What the records of a `bounds` experiment say, in numbers.

use crate::kinds::rows::tables;
use crate::page::Text;
use evaluation::{BoundsExperiment, BoundsFigure, BoundsRecord, BoundsSample, BoundsTechnique};

/// One technique on one kernel.
pub(crate) struct Row {
    pub(crate) figure: String,
    pub(crate) kernel: String,
    pub(crate) panel: String,
    pub(crate) technique: String,
    pub(crate) moments: usize,
    /// Mean of F - G over z_f in \[0, 1\] by the trapezoidal rule.
    pub(crate) mean_distance: f64,
    /// Largest F - G at a recorded depth.
    pub(crate) largest_distance: f64,
    /// Largest difference between an attained and a proved bound.
    pub(crate) worst_gap: f64,
    pub(crate) failed: usize,
    pub(crate) trials: usize,
    pub(crate) median_time_ns: Option<f64>,
}

tables! {
    /// The recorded tables of a run.
    BoundsTables { records: BoundsRecord, samples: BoundsSample, }
}

impl BoundsTables {
    /// The records of one technique on one kernel, in the order of the file.
    pub(crate) fn of<'a>(
        &'a self,
        figure: &'a str,
        kernel: &'a str,
        technique: &'a str,
    ) -> impl Iterator<Item = &'a BoundsRecord> {
        let wanted =
            move |r: &&BoundsRecord| r.figure == figure && r.kernel == kernel && r.technique == technique;
        self.records.iter().filter(wanted)
    }

    /// One row per kernel and technique.
    pub(crate) fn summary(&self, experiment: &BoundsExperiment) -> Vec<Row> {
        let mut rows = Vec::new();
        for figure in &experiment.figure {
            for kernel in &figure.kernels {
                for technique in &figure.technique {
                    let records: Vec<_> = self.of(&figure.id, kernel, &technique.name).collect();
                    rows.extend(self.row(technique, &records));
                }
            }
        }
        rows
    }

    fn row(&self, technique: &BoundsTechnique, records: &[&BoundsRecord]) -> Option<Row> {
        let first = records.first()?;
        let good = || records.iter().filter(|r| r.error.is_empty());
        let distances: Vec<(f64, f64)> =
            good().filter_map(|r| Some((r.z_f, r.mass_before - r.lower?))).collect();
        let area: f64 =
            distances.windows(2).map(|w| 0.5 * (w[1].0 - w[0].0) * (w[0].1.abs() + w[1].1.abs())).sum();
        let width = match (distances.first(), distances.last()) {
            (Some(first), Some(last)) if last.0 > first.0 => last.0 - first.0,
            _ => f64::NAN,
        };
        let gaps = good().filter_map(|r| Some((r.lower? - r.lower_proved?).max(r.upper_proved? - r.upper?)));
        let times = self.samples.iter().filter(|s| {
            s.figure == first.figure && s.kernel == first.kernel && s.technique == first.technique
        });
        Some(Row {
            figure: first.figure.clone(),
            kernel: first.kernel.clone(),
            panel: technique.panel.clone(),
            technique: technique.name.clone(),
            moments: first.moments,
            mean_distance: area / width,
            largest_distance: distances.iter().map(|d| d.1).fold(f64::NAN, f64::max),
            worst_gap: gaps.fold(0.0, f64::max),
            failed: records.len() - good().count(),
            trials: records.len(),
            median_time_ns: median(times.map(|s| s.time_ns as f64).collect()),
        })
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n % 2 == 1 => Some(values[middle]),
        _ => Some(0.5 * (values[middle - 1] + values[middle])),
    }
}

/// The answer to the experiment's question, one sentence per finding.
pub(crate) fn answer(experiment: &BoundsExperiment, tables: &BoundsTables, rows: &[Row]) -> Vec<Text> {
    let mut sentences = Vec::new();
    for figure in &experiment.figure {
        for kernel in &figure.kernels {
            for mark in &figure.mark {
                let distances: Vec<String> = figure
                    .technique
                    .iter()
                    .filter_map(|technique| {
                        let mut records = tables.of(&figure.id, kernel, &technique.name);
                        let record = records.find(|r| r.z_f == mark.depth && r.error.is_empty())?;
                        let distance = record.mass_before - record.lower?;
                        Some(format!("{} {distance:.3}", technique.name))
                    })
                    .collect();
                if !distances.is_empty() {
                    let at = format!("At z_f = {} ({})", mark.depth, mark.text);
                    let sentence = format!("{at} the distance below PCF is: {}.", distances.join(", "));
                    sentences.push(sentence.into());
                }
            }
        }
        if nested(figure) {
            // What holds over all depths says more than what holds at one.
            sentences.splice(0..0, growth(rows.iter().filter(|row| row.figure == figure.id)).map(Text::from));
        }
    }
    sentences
}

/// Whether each basis of a panel contains all functions of the one before, so that adding moments can be judged.
fn nested(figure: &BoundsFigure) -> bool {
    let mut pairs = 0;
    for (i, technique) in figure.technique.iter().enumerate() {
        let Some(next) = figure.technique[i + 1..].iter().find(|next| next.panel == technique.panel) else {
            continue;
        };
        let (Ok(small), Ok(large)) = (technique.basis(), next.basis()) else { return false };
        let contained = small.functions().iter().all(|function| large.functions().contains(function));
        if next.interval != technique.interval || small.len() >= large.len() || !contained {
            return false;
        }
        pairs += 1;
    }
    pairs > 0
}

/// Whether more moments are better, over all kernels and panels of a figure.
fn growth<'a>(rows: impl Iterator<Item = &'a Row>) -> Option<String> {
    let rows: Vec<&Row> = rows.collect();
    let mut sizes: Vec<usize> = rows.iter().map(|row| row.moments).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let (&smallest, &largest) = (sizes.first()?, sizes.last()?);
    if smallest == largest {
        return None;
    }
    let mut families = 0;
    let mut falling = 0;
    for first in rows.iter().filter(|row| row.moments == smallest) {
        let same = |row: &&&Row| row.kernel == first.kernel && row.panel == first.panel;
        let mut family: Vec<&&Row> = rows.iter().filter(same).collect();
        family.sort_by_key(|row| row.moments);
        families += 1;
        falling += usize::from(family.windows(2).all(|w| w[1].mean_distance < w[0].mean_distance));
    }
    let means: Vec<String> = sizes
        .iter()
        .map(|&m| {
            let of_size: Vec<f64> =
                rows.iter().filter(|row| row.moments == m).map(|row| row.mean_distance).collect();
            format!("{:.3} (m = {m})", of_size.iter().sum::<f64>() / of_size.len() as f64)
        })
        .collect();
    Some(format!(
        "In {falling} of {families} pairs of kernel and family the mean distance to PCF falls with every moment \
         added; on average it is {}.",
        means.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(z_f: f64, mass_before: f64, lower: Option<f64>, error: &str) -> BoundsRecord {
        BoundsRecord {
            figure: "figure".to_owned(),
            kernel: "kernel".to_owned(),
            technique: "technique".to_owned(),
            moments: 2,
            z_f,
            mass_before,
            lower,
            upper: lower.map(|_| 1.0),
            lower_proved: lower.map(|lower| lower - 1e-9),
            upper_proved: lower.map(|_| 1.0),
            error: error.to_owned(),
        }
    }

    #[test]
    fn failed_trials_are_counted_and_do_not_enter_the_mean() {
        let records = vec![
            record(0.0, 0.0, Some(0.0), ""),
            record(0.25, 0.5, None, "solver failed"),
            record(0.5, 0.5, Some(0.1), ""),
            record(0.75, 1.0, Some(9.0), "contradiction"),
            record(1.0, 1.0, Some(0.8), ""),
        ];
        let technique = BoundsTechnique {
            name: "technique".to_owned(),
            panel: "panel".to_owned(),
            basis: "power:2".to_owned(),
            interval: moment_problem::Interval::Unit,
            solver: None,
        };
        let tables = BoundsTables { records, samples: Vec::new() };
        let row = tables.row(&technique, &tables.records.iter().collect::<Vec<_>>()).unwrap();
        assert_eq!((row.failed, row.trials, row.median_time_ns), (2, 5, None));
        // Trapezoids of 0 to 0.4 and of 0.4 to 0.2, each half a unit wide.
        assert!((row.mean_distance - (0.1 + 0.15)).abs() < 1e-12, "{}", row.mean_distance);
        assert!((row.largest_distance - 0.4).abs() < 1e-12 && (row.worst_gap - 1e-9).abs() < 1e-12);
    }
}
