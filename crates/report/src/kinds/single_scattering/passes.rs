//! Pass times on a graphics processor, where there was one (BHS16 Figure 8).

use super::summary::ScatteringTables;
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, in_percent, median_of, row};
use evaluation::FrameSample;

/// Map, width and height.
type Sizes = (u32, u32, u32);

fn sizes(sample: &FrameSample) -> Sizes {
    (sample.map_size, sample.width, sample.height)
}

impl ScatteringTables<'_> {
    /// All sizes in the order of the file.
    fn sizes(&self) -> Vec<Sizes> {
        distinct(self.frames.iter().map(sizes))
    }

    /// Median time of a pass in milliseconds.
    fn pass_time(&self, technique: &str, pass: &str, at: Sizes) -> Option<f64> {
        let of = self.frames.iter().filter(|s| s.technique == technique && s.pass == pass && sizes(s) == at);
        median_of(of.map(|sample| sample.time_ns as f64 / 1e6))
    }

    /// Time of all passes of a technique at the first sizes, in milliseconds.
    pub(super) fn gpu_time(&self, technique: &str) -> Option<f64> {
        self.gpu.first().filter(|gpu| !gpu.is_software())?;
        let at = *self.sizes().first()?;
        let passes =
            distinct(self.frames.iter().filter(|s| s.technique == technique).map(|s| s.pass.as_str()));
        let times: Vec<f64> = passes.iter().filter_map(|pass| self.pass_time(technique, pass, at)).collect();
        (!times.is_empty()).then(|| times.iter().sum())
    }
}

/// Times by pass and sizes, and the share of the measured bandwidth at the first sizes.
pub(super) fn blocks(tables: &ScatteringTables<'_>) -> Vec<Block> {
    let Some(gpu) = tables.gpu.first() else { return Vec::new() };
    let heading = "Pass times on a graphics processor";
    if tables.frames.is_empty() {
        let adapter = if gpu.adapter.is_empty() { "no adapter" } else { &gpu.adapter };
        let reason = Block::paragraph(format!("None ({adapter}): {}.", gpu.status));
        return vec![Block::heading(3, heading), reason];
    }
    let all = tables.sizes();
    let keys = distinct(tables.frames.iter().map(|s| (s.technique.as_str(), s.pass.as_str())));
    let share = |technique: &str, pass: &str| {
        let at = *all.first()?;
        let of = |s: &&FrameSample| s.technique == technique && s.pass == pass && sizes(s) == at;
        let bytes = tables.frames.iter().find(of)?.least_bytes? as f64;
        let seconds = tables.pass_time(technique, pass, at)? / 1e3;
        Some(in_percent(bytes / seconds / gpu.bytes_per_second?, 0))
    };
    let cells = |&(technique, pass): &(&str, &str)| {
        let time =
            |&at: &Sizes| -> Text { tables.pass_time(technique, pass, at).map(|t| format!("{t:.3}")).into() };
        let mut cells = row![technique, pass];
        cells.extend(all.iter().map(time));
        cells.push(share(technique, pass).into());
        cells
    };
    let table = Table::default()
        .left(["technique", "pass"])
        .right(all.iter().map(|(map, width, height)| format!("{map}², {width}x{height}")))
        .right(["of the bandwidth, %"])
        .rows(keys.iter().map(cells));
    let note = format!(
        "Milliseconds between GPU timestamps, median over frames; by sizes of map and output. The last column: bytes that a pass \
         moves at least over its time at the first sizes, against a plain copy in the same run. Measured on {} ({}, {}, {}): {}.",
        gpu.adapter, gpu.device_type, gpu.api, gpu.driver, gpu.status
    );
    let mut blocks = Block::section(3, heading, table, Some(note.into()));
    if gpu.skipped > 0 {
        let skipped = format!("{} combinations were left out, the last: {}.", gpu.skipped, gpu.last_skipped);
        blocks.push(Block::paragraph(skipped));
    }
    blocks
}
