//! Charts of a `speed-accuracy` run: error against cost, memory and time, and what kernels need.

use super::needs::needs;
use super::summary::SpeedTables;
use crate::drawing::{Family, Mark, Scatter};
use crate::error::ReportError;
use crate::page::{Drawing, percent};
use evaluation::SpeedAccuracyRecord;

/// What the modelled cost is in units of.
pub(super) const COST: &str = "modelled cost of a frame; VSM in f32 on the largest map = 1";

/// All figures of a run.
pub(crate) fn draw(tables: &SpeedTables<'_>) -> Result<Vec<Drawing>, ReportError> {
    let sizes = tables.sizes();
    let nothing = tables.nothing().map(|r| r.l1_error).filter(|error| *error > 0.0);
    let mark = |r: &SpeedAccuracyRecord, x: f64, x_range: Option<(f64, f64)>, x_label: &str| {
        let name =
            if r.format == "depth" { r.technique.clone() } else { format!("{}, {}", r.technique, r.format) };
        let relative = nothing.map(|unit| format!(" ({:.3} of no shadows at all)", r.l1_error / unit));
        Mark {
            colour: Family::of(&r.technique).colour,
            x,
            x_range,
            y: r.l1_error,
            y_margin: 2.0 * r.standard_error.unwrap_or_default(),
            shape: sizes.iter().position(|&size| size == r.size).unwrap_or_default() as u32,
            competes: r.format != "depth",
            fails: false,
            label: format!(
                "{name}, {0}x{0} map: error {1}{2}, {x_label}: {x:.3}",
                r.size,
                percent(r.l1_error, 2),
                relative.unwrap_or_default()
            ),
            name,
        }
    };
    let full = tables.full();
    let filterable = || full.iter().filter(|r| r.format != "depth");
    let chart = |id, title, x_label: &str, marks: Vec<Mark>, shown: &[u32]| {
        let scatter = Scatter {
            size: (860, 560),
            title: "",
            x_label,
            y_label: "mean |G - F| over all fragments",
            unit: nothing.map(|unit| (unit, "relative to the error of no shadows at all")),
            names: true,
            shapes: shown.iter().map(|size| format!("{size}x{size} map")).collect(),
            legend: true,
        };
        Ok::<_, ReportError>(Drawing::new(id, title, scatter.svg(id, &marks)?))
    };
    let first = &sizes[..sizes.len().min(1)];
    let bits = "bits per texel";
    let time = "nanoseconds a fragment, one core, f32, a call at a time";
    let timed = filterable().filter_map(|r| {
        let of = tables.time(&r.technique, &r.format, "f32", "shade")?;
        Some(mark(r, of.median, Some((of.least, of.most)), time))
    });
    let mut figures = vec![
        chart(
            "cost",
            "Error against modelled frame cost (lower and further left is better)",
            COST,
            tables.best().map(|r| mark(r, r.cost, None, "modelled cost")).collect(),
            &sizes,
        )?,
        chart(
            "memory",
            "Error against memory on the largest map (lower and further left is better)",
            bits,
            filterable().map(|r| mark(r, r.bits_per_texel as f64, None, bits)).collect(),
            first,
        )?,
        chart(
            "time",
            "Error against time to shade a fragment on one core (lower and further left is better)",
            time,
            timed.collect(),
            first,
        )?,
        needs(tables)?,
    ];
    let adapter = tables.gpu.first().map(|gpu| gpu.adapter.as_str()).unwrap_or_default();
    let label = format!("milliseconds a frame on {adapter}");
    let on_gpu = full.iter().filter_map(|r| {
        let (least, median, most) = tables.gpu_time(&r.technique, &r.format)?;
        Some(mark(r, median, Some((least, most)), &label))
    });
    let on_gpu: Vec<Mark> = on_gpu.collect();
    if !on_gpu.is_empty() {
        let title = "Error against frame time (lower and further left is better)";
        figures.push(chart("gpu", title, &label, on_gpu, first)?);
    }
    Ok(figures)
}
