//! Frame times on a graphics processor, where there was one.

use crate::speed_summary::SpeedTables;
use evaluation::{FrameSample, WHOLE_FRAME};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Sizes of a frame: map, width, height, kernel.
type Point = (u32, u32, u32, usize);

fn point(sample: &FrameSample) -> Point {
    (sample.map_size, sample.width, sample.height, sample.kernel)
}

impl SpeedTables {
    /// All sizes in the order of the file; the first is the middle of all.
    fn points(&self) -> Vec<Point> {
        let mut points = Vec::new();
        for sample in &self.frames {
            if !points.contains(&point(sample)) {
                points.push(point(sample));
            }
        }
        points
    }

    /// Frame times in milliseconds, ascending: the sum over the passes that `wanted` takes.
    fn frame_times(
        &self,
        (technique, format): (&str, &str),
        at: Point,
        wanted: impl Fn(&str) -> bool,
    ) -> Vec<f64> {
        let mut frames: BTreeMap<usize, f64> = BTreeMap::new();
        let of = self
            .frames
            .iter()
            .filter(|s| s.technique == technique && s.format == format && point(s) == at && wanted(&s.pass));
        for sample in of {
            *frames.entry(sample.frame).or_default() += sample.time_ns as f64 / 1e6;
        }
        let mut frames: Vec<f64> = frames.into_values().collect();
        frames.sort_by(f64::total_cmp);
        frames
    }

    /// Least, median and most of the frame times at the first sizes, on a graphics processor.
    pub(crate) fn gpu_time(&self, technique: &str, format: &str) -> Option<(f64, f64, f64)> {
        self.gpu.as_ref().filter(|gpu| gpu.device_type != "Cpu")?;
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
            let ratio = median(key, at)? / median(("PCF with receiver plane", "depth"), at)?;
            let (map, width, height, kernel) = at;
            let name = format!("{map}², {width}x{height}, {kernel}x{kernel}: {ratio:.2}");
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
        let Some(gpu) = &self.gpu else { return "No GPU times were asked for.".to_owned() };
        if self.frames.is_empty() {
            return format!("No GPU times, and no GPU axis: {}.", gpu.status);
        }
        if gpu.device_type == "Cpu" {
            return format!("No GPU times, and no GPU axis: {} is a software driver.", gpu.adapter);
        }
        let times = (self.gpu_time("VSM", "f32"), self.gpu_time("Hamburger 4", "unorm16"));
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
    pub(crate) fn gpu_table(&self, text: &mut String) {
        // Writing to a string cannot fail.
        let Some(gpu) = &self.gpu else { return };
        text.push_str(if gpu.device_type == "Cpu" && !self.frames.is_empty() {
            "### Frame times on a software driver, which are no GPU times\n\n"
        } else {
            "### Frame times on a graphics processor\n\n"
        });
        if self.frames.is_empty() {
            let adapter = if gpu.adapter.is_empty() { "no adapter" } else { &gpu.adapter };
            let _ = writeln!(text, "None ({adapter}): {}.\n", gpu.status);
            return;
        }
        let points = self.points();
        text.push_str("| technique | format |");
        for (map, width, height, kernel) in &points {
            let _ = write!(text, " {map}², {width}x{height}, {kernel}x{kernel} |");
        }
        let _ = writeln!(
            text,
            " shadow passes | resolve | filter | shade |\n|---|---{}|",
            "|--:".repeat(points.len() + 4)
        );
        let mut techniques: Vec<(&str, &str)> = Vec::new();
        for sample in &self.frames {
            let key = (sample.technique.as_str(), sample.format.as_str());
            if !techniques.contains(&key) {
                techniques.push(key);
            }
        }
        let median = |times: Vec<f64>| match times.get(times.len() / 2) {
            Some(time) => format!("{time:.3}"),
            None => "-".to_owned(),
        };
        for key in techniques {
            let _ = write!(text, "| {} | {} |", key.0, key.1);
            for &at in &points {
                let _ = write!(text, " {} |", median(self.frame_times(key, at, |pass| pass == WHOLE_FRAME)));
            }
            let first = points[0];
            let shadow = self.frame_times(key, first, |pass| ![WHOLE_FRAME, "surfaces"].contains(&pass));
            let resolve = self.frame_times(key, first, |pass| pass == "resolve");
            let filter = self.frame_times(key, first, |pass| pass.starts_with("filter"));
            let shade = self.frame_times(key, first, |pass| pass == "shade");
            let _ = writeln!(
                text,
                " {} | {} | {} | {} |",
                median(shadow),
                median(resolve),
                median(filter),
                median(shade)
            );
        }
        let _ = writeln!(
            text,
            "\nMilliseconds between GPU timestamps, median over frames; whole frames by sizes of map, output and kernel, then \
             parts of the first. 4x multisampled maps with mip maps. Measured on {} ({}, {}, {}): {}.\n",
            gpu.adapter, gpu.device_type, gpu.api, gpu.driver, gpu.status
        );
        if gpu.skipped > 0 {
            let _ = writeln!(
                text,
                "{} combinations were left out, the last: {}.\n",
                gpu.skipped, gpu.last_skipped
            );
        }
    }
}
