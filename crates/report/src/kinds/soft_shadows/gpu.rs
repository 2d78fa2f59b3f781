//! Times of compute passes on a graphics processor, where there was one.

use super::summary::SoftTables;
use crate::drawing::{Series, SeriesChart, SeriesPoint, svg};
use crate::error::ReportError;
use crate::kinds::rows::distinct;
use crate::page::{Block, Drawing, Table, Text, row};
use evaluation::{PassSample, WHOLE_FRAME};

/// Sizes of a frame: map, width, height, region.
type PassSizes = (u32, u32, u32, f64);

fn sizes(sample: &PassSample) -> PassSizes {
    (sample.map_size, sample.width, sample.height, sample.region)
}

fn name((map, width, height, region): PassSizes) -> String {
    format!("{map}², {width}x{height}, {region:.0} texels")
}

impl SoftTables<'_> {
    /// All sizes in the order of the file; the first is the middle of all.
    fn points(&self) -> Vec<PassSizes> {
        distinct(self.passes.iter().map(sizes))
    }

    /// Median time of a pass in milliseconds.
    fn pass_time(&self, technique: &str, at: PassSizes, pass: &str) -> Option<f64> {
        let of = self.passes.iter().filter(|s| s.technique == technique && s.pass == pass && sizes(s) == at);
        let mut times: Vec<u64> = of.map(|sample| sample.time_ns).collect();
        times.sort_unstable();
        times.get(times.len() / 2).map(|&time| time as f64 / 1e6)
    }

    /// Median time in milliseconds of all passes at the middle sizes, on a graphics processor.
    pub(super) fn gpu_time(&self, technique: &str) -> Option<f64> {
        self.gpu.first().filter(|gpu| !gpu.is_software())?;
        self.pass_time(technique, *self.points().first()?, WHOLE_FRAME)
    }

    /// The adapter's name; empty without one.
    pub(super) fn adapter(&self) -> &str {
        self.gpu.first().map_or("", |gpu| gpu.adapter.as_str())
    }

    /// Times by technique and sizes.
    pub(super) fn gpu_blocks(&self) -> Vec<Block> {
        let Some(gpu) = self.gpu.first() else { return Vec::new() };
        if self.passes.is_empty() {
            let adapter = if gpu.adapter.is_empty() { "no adapter" } else { &gpu.adapter };
            let reason = Block::paragraph(format!("None ({adapter}): {}.", gpu.status));
            return vec![Block::heading(2, "Passes on a graphics processor"), reason];
        }
        let heading = if gpu.is_software() {
            "Passes on a software driver, whose times are no GPU times"
        } else {
            "Passes on a graphics processor"
        };
        let points = self.points();
        let cells = |technique: &str| {
            let time = |at: PassSizes, pass: &str| -> Text {
                self.pass_time(technique, at, pass).map(|time| format!("{time:.3}")).into()
            };
            let parts = ["rows", "columns", "shade"].map(|pass| time(points[0], pass));
            let whole = points.iter().map(|&at| time(at, WHOLE_FRAME));
            row![technique].into_iter().chain(parts).chain(whole).collect()
        };
        let techniques = distinct(self.passes.iter().map(|s| s.technique.as_str()));
        let table = Table::default()
            .left(["technique"])
            .right(["rows", "columns", "shade"])
            .right(points.iter().map(|&at| name(at)))
            .rows(techniques.into_iter().map(cells));
        let receivers = self.passes.first().map_or(0, |sample| sample.receivers);
        let note = format!(
            "Milliseconds between GPU timestamps, median over frames: the passes of the first sizes, then from the beginning of \
             the first pass to the end of the last by sizes of map, output and largest search region. Drawing the map and the \
             surfaces is the same for all and not included; {receivers} pixels of the first output show a surface that faces \
             the light. Measured on {} ({}, {}, {}): {}.",
            gpu.adapter, gpu.device_type, gpu.api, gpu.driver, gpu.status
        );
        let mut blocks = Block::section(2, heading, table, Some(note.into()));
        if gpu.skipped > 0 {
            let skipped =
                format!("{} combinations were left out, the last: {}.", gpu.skipped, gpu.last_skipped);
            blocks.push(Block::paragraph(skipped));
        }
        blocks
    }

    /// Time by size of the map and by size of the region.
    pub(super) fn gpu_charts(&self) -> Result<Vec<Drawing>, ReportError> {
        let points = self.points();
        let (Some(&first), false) = (points.first(), self.gpu.first().is_none_or(|gpu| gpu.is_software()))
        else {
            return Ok(Vec::new());
        };
        let by_map = |at: &PassSizes| (first.0, at.1, at.2, at.3) == first;
        let by_region = |at: &PassSizes| (at.0, at.1, at.2, first.3) == first;
        let map: Points = points.iter().copied().filter(by_map).map(|at| (at, f64::from(at.0))).collect();
        let region: Points = points.iter().copied().filter(by_region).map(|at| (at, at.3)).collect();
        let adapter = self.adapter();
        let mut drawings = Vec::new();
        for (id, x_label, of) in [
            ("gpu-map", "side of the shadow map, texels", map),
            ("gpu-region", "largest search region, full width in texels", region),
        ] {
            if of.len() < 2 {
                continue;
            }
            let title = format!("Time of all passes on {adapter} (less is better)");
            let chart = SeriesChart {
                title: &title,
                x_label,
                y_label: "milliseconds",
                y_tick: &|time| format!("{time:.1}"),
            };
            let curves = self.series(of);
            let picture = svg(id, (820, 460), |root| chart.draw(root, &curves))?;
            drawings.push(Drawing::new(id, title.clone(), picture));
        }
        Ok(drawings)
    }

    fn series(&self, mut of: Points) -> Vec<Series> {
        of.sort_by(|a, b| a.1.total_cmp(&b.1));
        let techniques = distinct(self.passes.iter().map(|s| s.technique.as_str()));
        let series = techniques.into_iter().map(|technique| {
            let points = of.iter().filter_map(|&(at, x)| {
                let y = self.pass_time(technique, at, WHOLE_FRAME)?;
                let label = format!("{technique}, {}: {y:.3} ms", name(at));
                Some(SeriesPoint { x, tick: format!("{x:.0}"), y, label })
            });
            Series { name: technique.to_owned(), points: points.collect() }
        });
        series.filter(|series| !series.points.is_empty()).collect()
    }
}

/// Sizes with the one that is varied.
type Points = Vec<(PassSizes, f64)>;
