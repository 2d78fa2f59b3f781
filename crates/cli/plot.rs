//! `msm bound --plot`: the bounds at every fragment depth, beside those of well-known bases.

use crate::bound::Input;
use crate::progress::Bar;
use anyhow::{Context, anyhow};
use evaluation::{Domain, Method, method, write_whole};
use moment_problem::{Bounds, DepthDistribution};
use rayon::prelude::*;
use report::{BoundChart, BoundCurve};
use std::path::Path;

/// Cells of the uniform grid of fragment depths; the kernel's own depths are added.
const CELLS: usize = 400;

/// Bases that every plot of known atoms shows for comparison: variance shadow mapping, moment shadow mapping without
/// and with the knowledge that depths lie in \[0, 1\], and trigonometric moments (MSM15 section 4).
const REFERENCES: [(&str, Domain, &str); 4] = [
    ("power:2", Domain::Real, "power:2 on the line (VSM)"),
    ("power:4", Domain::Real, "power:4 on the line (Hamburger)"),
    ("power:4", Domain::Unit, "power:4 on [0, 1] (Hausdorff)"),
    ("trig:2", Domain::Unit, "trig:2 on [0, 1]"),
];

/// Computes and writes the plot. `at_z_f` are the bounds that were asked for.
pub fn write(
    path: &Path,
    input: &Input,
    given: &Method,
    domain: Domain,
    z_f: f64,
    at_z_f: &Bounds,
) -> anyhow::Result<()> {
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
        if !shown && (*interval == Domain::Real || in_unit) {
            references.push((method(&basis, *interval, None).context("reference basis")?, *name));
        }
    }
    let bar = Bar::new("bounds for the plot");
    let total = depths.len() * (references.len() + 1);
    let curve = |method: &Method, name: String| BoundCurve {
        name,
        points: depths
            .par_iter()
            .map(|&z| {
                let bounds = input.bounds(method.as_ref(), z).ok();
                bar.advance(total);
                (z, bounds.map(|bounds| (bounds.lower, bounds.upper)))
            })
            .collect(),
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
    domain: Domain,
    z_f: f64,
    at_z_f: &Bounds,
) -> (f64, f64) {
    let points = distribution.map_or(&at_z_f.support[..], |z| z.depths());
    let (low, high) = points.iter().fold((z_f, z_f), |(low, high), &z| (low.min(z), high.max(z)));
    if domain == Domain::Unit || (low >= 0.0 && high <= 1.0) {
        return (0.0, 1.0);
    }
    let margin = if high > low { 0.25 * (high - low) } else { 0.5 };
    (low - margin, high + margin)
}

fn fragment_depths(distribution: Option<&DepthDistribution>, range: (f64, f64), z_f: f64) -> Vec<f64> {
    let step = (range.1 - range.0) / CELLS as f64;
    let mut depths: Vec<f64> = (0..CELLS).map(|i| range.0 + step * i as f64).collect();
    depths.extend([range.1, z_f]);
    for &z in distribution.map_or(&[][..], |z| z.depths()) {
        // Bounds may jump at an atom: one depth at it, one a quarter pixel behind it.
        depths.extend([z, z + 0.125 * step]);
    }
    depths.retain(|z| (range.0..=range.1).contains(z));
    depths.sort_by(f64::total_cmp);
    depths.dedup();
    depths
}

/// Legends have room for about 50 characters.
fn shortened(name: &str) -> String {
    if name.chars().count() <= 50 {
        return name.to_owned();
    }
    format!("{}...", name.chars().take(47).collect::<String>())
}
