//! Frame times on a graphics processor, where there was one.

use super::summary::SpeedTables;
use crate::kinds::rows::distinct;
use crate::page::{Block, Table, Text, row};
use evaluation::{COMPARED_FRAME, FrameRoute, FrameSample, WHOLE_FRAME};
use std::collections::BTreeMap;

/// Sizes of a frame: map, width, height, kernel, depth samples a texel.
type FrameSizes = (u32, u32, u32, usize, u32);

fn point(sample: &FrameSample) -> FrameSizes {
    (sample.map_size, sample.width, sample.height, sample.kernel, sample.depth_samples)
}

fn name((map, width, height, kernel, samples): FrameSizes) -> String {
    let samples = if samples == 1 { ", not multisampled" } else { "" };
    format!("{map}², {width}x{height}, {kernel}x{kernel}{samples}")
}

impl SpeedTables<'_> {
    /// All sizes in the order of the file; the first is the middle of all.
    fn points(&self) -> Vec<FrameSizes> {
        distinct(self.frames.iter().map(point))
    }

    /// The route that is told: compute passes, which use the whole of every processor, where they were timed.
    fn route(&self) -> FrameRoute {
        let is_compute = self.frames.iter().any(|sample| sample.route == FrameRoute::Compute);
        if is_compute { FrameRoute::Compute } else { FrameRoute::Fragment }
    }

    /// Frame times in milliseconds, ascending: the sum over the passes that `wanted` takes.
    fn frame_times(&self, key: (&str, &str), at: FrameSizes, wanted: impl Fn(&str) -> bool) -> Vec<f64> {
        self.route_times(self.route(), key, at, wanted)
    }

    fn route_times(
        &self,
        route: FrameRoute,
        (technique, format): (&str, &str),
        at: FrameSizes,
        wanted: impl Fn(&str) -> bool,
    ) -> Vec<f64> {
        let mut frames: BTreeMap<usize, f64> = BTreeMap::new();
        let of = self
            .frames
            .iter()
            .filter(|s| s.route == route && s.technique == technique && s.format == format)
            .filter(|s| point(s) == at && wanted(&s.pass));
        for sample in of {
            *frames.entry(sample.frame).or_default() += sample.time_ns as f64 / 1e6;
        }
        let mut frames: Vec<f64> = frames.into_values().collect();
        frames.sort_by(f64::total_cmp);
        frames
    }

    /// Least, median and most of the frame times at the first sizes, on a graphics processor.
    pub(crate) fn gpu_time(&self, technique: &str, format: &str) -> Option<(f64, f64, f64)> {
        self.gpu.first().filter(|gpu| !gpu.is_software())?;
        let at = *self.points().first()?;
        let times = self.frame_times((technique, format), at, |pass| pass == WHOLE_FRAME);
        Some((*times.first()?, times[times.len() / 2], *times.last()?))
    }

    /// Frame times by bits a texel, with the names of the fastest and the slowest.
    pub(crate) fn times_by_bits(&self) -> Option<String> {
        let mut by_bits: BTreeMap<usize, Vec<(f64, String)>> = BTreeMap::new();
        for record in self.full() {
            if let Some((_, time, _)) = self.gpu_time(&record.technique, &record.format) {
                let name = format!("{} in {}", record.technique, record.format);
                by_bits.entry(record.bits_per_texel).or_default().push((time, name));
            }
        }
        let of = |(bits, times): (&usize, &mut Vec<(f64, String)>)| {
            times.sort_by(|a, b| a.0.total_cmp(&b.0));
            let named = |(time, name): &(f64, String)| format!("{time:.2} ms ({name})");
            match times.as_slice() {
                [first, .., last] => format!("{bits} bits: {} to {}", named(first), named(last)),
                rest => format!("{bits} bits: {}", rest.iter().map(named).collect::<String>()),
            }
        };
        let all: Vec<String> = by_bits.iter_mut().map(of).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    /// The sizes at which a technique is faster than percentage-closer filtering, and those at which it is not.
    pub(crate) fn faster_than_comparison(&self, key: (&str, &str)) -> Option<String> {
        self.gpu_time(key.0, key.1)?;
        let median = |key, at| {
            let times = self.frame_times(key, at, |pass| pass == WHOLE_FRAME);
            times.get(times.len() / 2).copied()
        };
        let (mut faster, mut slower) = (Vec::new(), Vec::new());
        for at in self.points() {
            let ratio = median(key, at)? / median((COMPARED_FRAME, "depth"), at)?;
            let name = format!("{}: {ratio:.2}", name(at));
            if ratio < 1.0 { faster.push(name) } else { slower.push(name) }
        }
        let list = |names: Vec<String>| if names.is_empty() { "none".to_owned() } else { names.join("; ") };
        Some(format!(
            "Time over that of PCF with its receiver plane (map, output, kernel). Faster at {}. Slower at {}",
            list(faster),
            list(slower)
        ))
    }

    /// What is said of the graphics processor in the answer.
    pub(crate) fn gpu_sentence(&self) -> String {
        let Some(gpu) = self.gpu.first() else { return "No GPU times were asked for.".to_owned() };
        if self.frames.is_empty() {
            return format!("No GPU times, and no GPU axis: {}.", gpu.status);
        }
        if gpu.is_software() {
            return format!("No GPU times, and no GPU axis: {} is a software driver.", gpu.adapter);
        }
        let time = |role| self.player(role).ok().and_then(|(name, format)| self.gpu_time(name, &format));
        let times = (time("VSM, 32 bits"), time("four moments, 16 bits"));
        let ratio = match times {
            (Some(vsm), Some(msm)) => format!(
                "a frame with four moments in 16 bits takes {:.2} ms, with VSM in 32 bits {:.2} ms, {:.2} times as long",
                msm.1,
                vsm.1,
                msm.1 / vsm.1
            ),
            _ => "see the table".to_owned(),
        };
        let status = if gpu.status == "timed" { String::new() } else { format!(" ({})", gpu.status) };
        format!("On {}{status}: {ratio}.", gpu.adapter)
    }

    /// Frame times by technique and sizes.
    pub(crate) fn gpu_blocks(&self) -> Vec<Block> {
        let Some(gpu) = self.gpu.first() else { return Vec::new() };
        if self.frames.is_empty() {
            let adapter = if gpu.adapter.is_empty() { "no adapter" } else { &gpu.adapter };
            let reason = Block::paragraph(format!("None ({adapter}): {}.", gpu.status));
            return vec![Block::heading(3, "Frame times on a graphics processor"), reason];
        }
        let heading = if gpu.is_software() {
            "Frame times on a software driver, which are no GPU times"
        } else {
            "Frame times on a graphics processor"
        };
        let points = self.points();
        let cells = |key: (&str, &str)| {
            let median = |at, wanted: &dyn Fn(&str) -> bool| -> Text {
                let times = self.frame_times(key, at, wanted);
                times.get(times.len() / 2).map(|time| format!("{time:.3}")).into()
            };
            let whole = points.iter().map(|&at| median(at, &|pass| pass == WHOLE_FRAME));
            let parts = [
                median(points[0], &|pass| ![WHOLE_FRAME, "surfaces"].contains(&pass)),
                median(points[0], &|pass| pass == "resolve"),
                median(points[0], &|pass| pass.starts_with("filter")),
                median(points[0], &|pass| pass == "shade"),
            ];
            row![key.0, key.1].into_iter().chain(whole).chain(parts).collect()
        };
        let techniques = distinct(self.frames.iter().map(|s| (s.technique.as_str(), s.format.as_str())));
        let table = Table::default()
            .left(["technique", "format"])
            .right(points.iter().map(|&at| name(at)))
            .right(["shadow passes", "resolve", "filter", "shade"])
            .rows(techniques.into_iter().map(cells));
        let note = format!(
            "Milliseconds between GPU timestamps, median over frames; whole frames by sizes of map, output and kernel, then \
             parts of the first. 4x multisampled maps with mip maps; passes after rasterisation as {} shaders. Measured on {} ({}, {}, {}): {}.",
            match self.route() {
                FrameRoute::Fragment => "fragment",
                FrameRoute::Compute | FrameRoute::Unchecked => "compute",
            },
            gpu.adapter,
            gpu.device_type,
            gpu.api,
            gpu.driver,
            gpu.status
        );
        let mut blocks = Block::section(3, heading, table, Some(note.into()));
        blocks.extend(self.limit_blocks());
        if gpu.skipped > 0 {
            let skipped =
                format!("{} combinations were left out, the last: {}.", gpu.skipped, gpu.last_skipped);
            blocks.push(Block::paragraph(skipped));
        }
        blocks
    }

    /// Each pass beside what the memory allows.
    fn limit_blocks(&self) -> Vec<Block> {
        const PASSES: [&str; 5] = ["resolve", "filter rows", "filter columns", "mip maps", "shade"];
        let rates =
            self.gpu.first().and_then(|gpu| Some((gpu.bytes_per_second?, gpu.multiply_adds_per_second?)));
        let Some(((bytes, multiply_adds), at)) = rates.zip(self.points().first().copied()) else {
            return Vec::new();
        };
        let of = |(technique, format): (&str, &str), route: FrameRoute, pass: &str| {
            let mut found = self.frames.iter().filter(|s| s.technique == technique && s.format == format);
            let least = found.find(|s| s.route == route && s.pass == pass && point(s) == at)?.least_bytes?;
            let times = self.route_times(route, (technique, format), at, |name| name == pass);
            let time = *times.get(times.len() / 2)?;
            let share = least as f64 / bytes / (time / 1e3);
            Some(format!("{time:.3} ({:.0} %)", 100.0 * share))
        };
        let techniques = distinct(self.frames.iter().map(|s| (s.technique.as_str(), s.format.as_str())));
        let routes = distinct(self.frames.iter().map(|s| s.route));
        let rows = techniques.into_iter().flat_map(|key| {
            let cells = move |&route: &FrameRoute| -> Vec<Text> {
                let name = match route {
                    FrameRoute::Fragment => "fragment",
                    FrameRoute::Compute => "compute",
                    FrameRoute::Unchecked => "unchecked",
                };
                let passes = PASSES.iter().map(|pass| of(key, route, pass).into());
                row![key.0, key.1, name].into_iter().chain(passes).collect()
            };
            routes.iter().map(cells).collect::<Vec<_>>()
        });
        let table = Table::default().left(["technique", "format", "shaders"]).right(PASSES).rows(rows);
        let note = format!(
            "Milliseconds at the first sizes, and in brackets the share of the time that the least possible traffic would take \
             (every input read once, every output written once) at the {:.2} TB/s that a copy of 256 MiB moved in the same run; \
             above 100 % a cache serves. Compute shaders made {:.1} T multiply-adds a second. Unchecked: without naga's checks of \
             indices.",
            bytes / 1e12,
            multiply_adds / 1e12
        );
        Block::section(3, "Passes against the limit of the memory", table, Some(note.into()))
    }
}
