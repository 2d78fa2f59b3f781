//! `msm bound --plot`: the bounds at every fragment depth, beside those of well-known bases.

use super::input::Input;
use crate::progress::Bar;
use ::report::{BoundChart, BoundCurve};
use anyhow::{Context, anyhow};
use evaluation::write_whole;
use moment_problem::{BoundMethod, Bounds, DepthDistribution, Interval, method};
use rayon::prelude::*;
use std::path::Path;

/// Cells of the first, uniform grid of fragment depths; the kernel's own depths are added.
const CELLS: usize = 64;

/// Bounds never fall as z_f grows, so between two depths they lie between the values there. Cells in which they change
/// by more than this are halved...
const RESOLVED_CHANGE: f64 = 0.01;

/// ... down to a quarter pixel.
const HALVINGS: usize = 6;

/// Bases that every plot of known atoms shows for comparison: variance shadow mapping, moment shadow mapping without
/// and with the knowledge that depths lie in \[0, 1\], and trigonometric moments (MSM15 section 4).
const REFERENCES: [(&str, Interval, &str); 4] = [
    ("power:2", Interval::Real, "power:2 on the line (VSM)"),
    ("power:4", Interval::Real, "power:4 on the line (Hamburger)"),
    ("power:4", Interval::Unit, "power:4 on [0, 1] (Hausdorff)"),
    ("trig:2", Interval::Unit, "trig:2 on [0, 1]"),
];

/// Whether a plot can be written to a file of that name: SVG, and whatever says nothing else.
pub(super) fn is_drawn(path: &Path) -> bool {
    path.extension().is_none_or(|extension| extension.eq_ignore_ascii_case("svg"))
}

/// Computes and writes the plot. `at_z_f` are the bounds that were asked for.
pub(super) fn write(
    path: &Path,
    input: &Input,
    given: &BoundMethod,
    z_f: f64,
    at_z_f: &Bounds,
) -> anyhow::Result<()> {
    let domain = given.interval();
    let distribution = match input {
        Input::Atoms(z) => Some(z),
        Input::Moments(_) => None,
    };
    let range = depth_range(distribution, domain, z_f, at_z_f);
    let depths = fragment_depths(distribution, range, z_f);
    let in_unit = range.0 >= 0.0 && range.1 <= 1.0;
    let mut references = Vec::new();
    // Without atoms only the moments of the given basis are known.
    for (basis, interval, name) in REFERENCES.iter().filter(|_| distribution.is_some()) {
        let basis = basis.parse().context("reference basis")?;
        let shown = (&basis, *interval) == (given.basis(), domain);
        if !shown && (*interval == Interval::Real || in_unit) {
            references.push((method(&basis, *interval, None).context("reference basis")?, *name));
        }
    }
    let bar = Bar::new("bounds for the plot");
    let curve = |method: &BoundMethod, name: String| {
        let at =
            |z_f: f64| input.bounds(method.as_ref(), z_f).ok().map(|bounds| (bounds.lower, bounds.upper));
        BoundCurve { name, points: refined(&depths, &at, &bar) }
    };
    let title = shortened(&format!("{} on {domain}", given.basis()));
    let chart = BoundChart {
        distribution,
        z_f,
        depths: range,
        given: curve(given, title),
        references: references.iter().map(|(method, name)| curve(method, (*name).to_owned())).collect(),
    };
    bar.finish();
    let missing = chart.given.points.iter().filter(|(_, bounds)| bounds.is_none()).count();
    if missing == chart.given.points.len() {
        return Err(anyhow!("no bound of this basis could be certified for the plot"));
    }
    write_whole(path, chart.svg()?.as_bytes())?;
    Ok(())
}

/// \[0, 1\], or on the line what holds the atoms (or the support found) and z_f, with a margin.
fn depth_range(
    distribution: Option<&DepthDistribution>,
    domain: Interval,
    z_f: f64,
    at_z_f: &Bounds,
) -> (f64, f64) {
    let points = distribution.map_or(&at_z_f.support[..], |z| z.depths());
    let (low, high) = points.iter().fold((z_f, z_f), |(low, high), &z| (low.min(z), high.max(z)));
    if domain == Interval::Unit || (low >= 0.0 && high <= 1.0) {
        return (0.0, 1.0);
    }
    let margin = if high > low { 0.25 * (high - low) } else { 0.5 };
    (low - margin, high + margin)
}

fn fragment_depths(distribution: Option<&DepthDistribution>, range: (f64, f64), z_f: f64) -> Vec<f64> {
    let step = (range.1 - range.0) / CELLS as f64;
    let mut depths: Vec<f64> = (0..CELLS).map(|i| range.0 + step * i as f64).collect();
    depths.extend([range.1, z_f]);
    depths.extend(distribution.map_or(&[][..], |z| z.depths()));
    depths.retain(|z| (range.0..=range.1).contains(z));
    depths.sort_by(f64::total_cmp);
    depths.dedup();
    depths
}

/// Values at the given depths and wherever they change quickly.
fn refined(
    depths: &[f64],
    at: &(dyn Fn(f64) -> Option<(f64, f64)> + Sync),
    bar: &Bar,
) -> Vec<(f64, Option<(f64, f64)>)> {
    let finest = (depths[depths.len() - 1] - depths[0]) / (CELLS << HALVINGS) as f64;
    let mut points = Vec::new();
    let mut wanted = depths.to_vec();
    while !wanted.is_empty() {
        bar.expect(wanted.len());
        let values = wanted.into_par_iter().map(|z| {
            let value = at(z);
            bar.advance();
            (z, value)
        });
        points.extend(values.collect::<Vec<_>>());
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let change = |a: (f64, f64), b: (f64, f64)| (b.0 - a.0).abs().max((b.1 - a.1).abs());
        let coarse = points.windows(2).filter_map(|cell| match *cell {
            [(z, Some(a)), (next, Some(b))] if next - z > finest && change(a, b) > RESOLVED_CHANGE => {
                Some(0.5 * (z + next))
            }
            _ => None,
        });
        wanted = coarse.collect();
    }
    points
}

/// Legends have room for about 50 characters.
fn shortened(name: &str) -> String {
    if name.chars().count() <= 50 {
        return name.to_owned();
    }
    format!("{}...", name.chars().take(47).collect::<String>())
}
