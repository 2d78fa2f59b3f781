//! Pass times on a graphics processor, where there was one (BHS16 Figure 8).

use super::summary::ScatteringTables;
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, in_percent, median_of, row};
use evaluation::{COPIED_BYTES, FrameSample};

/// Bytes that the copy reads and writes.
const COPIED: f64 = 2.0 * 64.0 * 1024.0 * 1024.0;

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

    /// Bytes that a pass reads and writes at least.
    fn bytes(&self, technique: &str, pass: &str, (map, width, height): Sizes) -> Option<f64> {
        let stored = self.pooled(technique, ("all", "all"))?.bits_per_texel as f64 / 8.0;
        let texels = f64::from(map).powi(2);
        let pixels = f64::from(width) * f64::from(height);
        Some(match pass {
            // Depths of 32 bits, texels of two depths and weights.
            "resample" => texels * (4.0 + 16.0),
            // Every texel is read for the sums of its segment, and again for its own.
            "prefix sums" => texels * (2.0 * 16.0 + stored),
            // A ray and its answer.
            "look up" => pixels * (16.0 + 4.0 + stored),
            "march" => {
                let steps = self.costs.iter().find(|cost| cost.technique == technique)?.steps as f64;
                pixels * (16.0 + 4.0 + 4.0 + 4.0 * steps)
            }
            _ => return None,
        })
    }
}

/// Times by pass and sizes, and the share of the copy's bandwidth at the first sizes.
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
        let copied = COPIED / tables.pass_time(COPIED_BYTES, "copy", at)?;
        let moved = tables.bytes(technique, pass, at)? / tables.pass_time(technique, pass, at)?;
        Some(in_percent(moved / copied, 0))
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
         moves at least over its time at the first sizes, against the copy of 64 MiB. Measured on {} ({}, {}, {}): {}.",
        gpu.adapter, gpu.device_type, gpu.api, gpu.driver, gpu.status
    );
    let mut blocks = Block::section(3, heading, table, Some(note.into()));
    if gpu.skipped > 0 {
        let skipped = format!("{} combinations were left out, the last: {}.", gpu.skipped, gpu.last_skipped);
        blocks.push(Block::paragraph(skipped));
    }
    blocks
}
