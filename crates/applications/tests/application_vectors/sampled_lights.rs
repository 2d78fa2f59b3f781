//! The light sampled over time and through a lens.

use applications::stochastic::{FilterPlane, LightRay, Segment, between_planes, filtered, visible_length};
use applications::temporal::{FrameSample, History, Restart};
use libtest_mimic::Failed;
use moment_problem::arithmetic::DoubleDouble;
use moment_problem::hamburger::hamburger4;

use crate::table::{Row, Table, close};

/// Some tens of roundings.
const ROUNDING: f64 = 1e-13;

/// Depths of the stochastic maps are stored in these units.
const DEPTH_UNIT: f64 = 16.0;

/// Four roundings of the stored moments, per unit of the reference's sensitivity.
const SENSITIVITY: f64 = 4.0 / (1u64 << 53) as f64;

pub fn temporal_buffer(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [tests, blockers, tolerance] = row.numbers(["n0", "k", "eps"])?;
        let columns = ["depth", "tau", "pcss", "pcss_blocker", "map_depth"];
        let [depths, tau, fractions, starts, maps] = columns.map(|column| row.list(column));
        let (depths, tau, maps) = (depths?, tau?, maps?);
        let (fractions, starts) = (fractions?, starts?);
        let mut history: Option<(History, Restart)> = None;
        for (frame, &depth) in depths.iter().enumerate() {
            let sample = FrameSample { depth, in_shadow: tau[frame] != 0.0, map_depth: maps[frame] };
            let kept = history.filter(|(history, _)| history.belongs_to(depth, tolerance));
            let restarted = kept.is_none();
            let (next, start) = match kept {
                Some((history, start)) => (history.with(&sample, &start, false), start),
                None => {
                    let start =
                        Restart { fraction: fractions[frame], blocker: starts[frame], tests, blockers };
                    (History::restarted(&start, depth), start)
                }
            };
            history = Some((next, start));
            let expected = |column: &str| -> Result<f64, String> {
                row.list(column)?.get(frame).copied().ok_or(format!("{column} ends before frame {frame}"))
            };
            let estimate = next.estimate;
            for (column, got) in [
                ("restarted", f64::from(u8::from(restarted))),
                ("n", estimate.tests),
                ("rho", estimate.shadowed),
                ("psi", estimate.fraction()),
                ("variance", estimate.variance()),
                ("standard_error", estimate.standard_error()),
                ("avg_blocker", next.blocker),
            ] {
                close(&format!("{column} of frame {frame}"), got, expected(column)?, ROUNDING)?;
            }
        }
        Ok(())
    })?)
}

fn pairs(row: &Row, column: &str) -> Result<Vec<[f64; 2]>, String> {
    serde_json::from_value(row.json(column)?).map_err(|e| format!("{column}: {e}"))
}

pub fn stochastic_filter(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [texels_per_unit, light_radius, depth, least_radius] =
            row.numbers(["m", "R_L", "d_r", "rho_min"])?;
        let plane = FilterPlane { texels_per_unit, light_radius, depth, least_radius };
        let (origins, offsets, depths) = (pairs(row, "u")?, pairs(row, "o")?, row.list("d")?);
        let rays: Vec<LightRay> = (0..depths.len())
            .map(|k| LightRay { origin: origins[k], offset: offsets[k], depth: depths[k] })
            .collect();
        let samples = plane.samples(&rays);
        let (positions, circles, radii) = (pairs(row, "x_p")?, row.list("c")?, row.list("rho")?);
        for (k, sample) in samples.iter().enumerate() {
            let rounding = ROUNDING * (1.0 + positions[k][0].abs() + positions[k][1].abs());
            close(&format!("x of sample {k}"), sample.position[0], positions[k][0], rounding)?;
            close(&format!("y of sample {k}"), sample.position[1], positions[k][1], rounding)?;
            close(&format!("c of sample {k}"), sample.circle, circles[k], ROUNDING * (1.0 + circles[k]))?;
            close(&format!("rho of sample {k}"), sample.radius, radii[k], ROUNDING * (1.0 + radii[k]))?;
        }
        let at: [f64; 2] = row.list("x")?.try_into().map_err(|_| "x has not two numbers")?;
        let receiver = row.number("depth")?;
        let shared = |depth: f64| {
            let z = depth / DEPTH_UNIT;
            [f64::from(u8::from(depth >= receiver)), z, z * z, z * z * z, z * z * z * z]
        };
        let found = filtered(&samples, at, shared);
        let Some([binary, moments @ ..]) = found else {
            return match row.optional("S_binary")? {
                None => Ok(()),
                Some(expected) => Err(format!("no sample reaches what {expected} is the mean of")),
            };
        };
        row.close("S_binary", binary, ROUNDING)?;
        for (k, moment) in moments.into_iter().enumerate() {
            row.close(&format!("b{}", k + 1), moment, ROUNDING)?;
        }
        row.close("S_chebyshev", chebyshev(moments[0], moments[1], receiver), 1e-9)?;
        if let Some(sensitivity) = row.optional("sens4")? {
            let b = moments.map(DoubleDouble::from);
            let lower = hamburger4(&b, DoubleDouble::from(receiver / DEPTH_UNIT)).lower.to_f64();
            row.close("S_hamburger4", 1.0 - lower, 1e-12 + SENSITIVITY * sensitivity)?;
        }
        Ok(())
    })?)
}

/// The lit share by Chebyshev's inequality (SSSM15 equation 5): all of it up to the mean depth.
fn chebyshev(mean: f64, second: f64, depth: f64) -> f64 {
    1.0 - moment_problem::MomentBound::Hamburger2.bounds(&[mean, second], depth / DEPTH_UNIT).lower
}

pub fn stochastic_planes(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let (planes, moments) = (row.list("planes")?, pairs(row, "moments")?);
        let [depth, x] = row.numbers(["depth", "x"])?;
        let (lower, share) = between_planes(&planes, depth).ok_or("no planes")?;
        let upper = (lower + 1).min(planes.len() - 1);
        let blend = |a: f64, b: f64| a + share * (b - a);
        // The last plane may be stated as the end of the interval before it.
        let position = lower as f64 + share;
        close("plane", position, row.number("lower_plane")? + row.number("t")?, ROUNDING)?;
        for (on_plane, plane) in row.list("x_on_planes")?.iter().zip(&planes) {
            close("x on a plane", x * plane / depth, *on_plane, ROUNDING * (1.0 + on_plane.abs()))?;
        }
        let b = [0, 1].map(|k| blend(moments[lower][k], moments[upper][k]));
        row.close("b1", b[0], ROUNDING)?;
        row.close("b2", b[1], ROUNDING)?;
        row.close("S_of_interpolated", chebyshev(b[0], b[1], depth), 1e-11)?;
        let [near, far] = [lower, upper].map(|plane| chebyshev(moments[plane][0], moments[plane][1], depth));
        row.close("interpolated_S", blend(near, far), 1e-11)
    })?)
}

pub fn stochastic_flatland(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [light_radius, depth, x] = row.numbers(["R_L", "d_r", "x"])?;
        let segments: Vec<[f64; 3]> =
            serde_json::from_value(row.json("segments")?).map_err(|e| format!("segments: {e}"))?;
        let segments: Vec<Segment> =
            segments.into_iter().map(|[depth, start, end]| Segment { depth, start, end }).collect();
        let visible = visible_length(light_radius, [x, depth], &segments);
        row.close("S", visible, ROUNDING * light_radius)?;
        row.close("visible_fraction", visible / (2.0 * light_radius), ROUNDING)?;
        row.close("shadow", 1.0 - visible / (2.0 * light_radius), ROUNDING)
    })?)
}
