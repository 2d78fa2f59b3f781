//! Formulas of one line: rounding is all that may differ.

use applications::samples::radical_inverse;
use applications::scattering::{self, TwoDepths};
use applications::stochastic;
use applications::temporal::{self, ShadowEstimate};
use libtest_mimic::Failed;
use moment_problem::arithmetic::DoubleDouble;

use crate::table::{Row, Table, close};

/// Relative: some ten roundings of double precision.
const ROUNDING: f64 = 4e-15;

/// The standard error above which TC09 filters no more.
const THRESHOLD: f64 = 1.0 / 50.0;

fn rounded(row: &Row, column: &str, got: f64) -> Result<(), String> {
    row.close(column, got, ROUNDING * (got.abs() + 1e-3))
}

pub fn halton(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let index = row.integer("index")?;
        [("base2", 2), ("base3", 3)]
            .into_iter()
            .try_for_each(|(column, base)| rounded(row, column, radical_inverse(index, base)))
    })?)
}

pub fn penumbra_width(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [size, receiver, blocker, near, eye] =
            row.numbers(["light_size", "receiver", "avg_blocker", "near", "depth_eye"])?;
        let width = temporal::penumbra_width(size, receiver, blocker, near, eye);
        // receiver - blocker cancels exactly, as inputs are meant exactly.
        rounded(row, "width", width)
    })?)
}

pub fn circle_of_confusion(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [m, radius, receiver, sample] = row.numbers(["m", "R_L", "d_r", "d_k"])?;
        let c = stochastic::circle_of_confusion(m, radius, receiver, sample);
        rounded(row, "c", c)?;
        match row.optional("alpha")? {
            Some(alpha) => close("alpha", 1.0 / (c * c), alpha, ROUNDING * alpha),
            None => close("c where alpha is undefined", c, 0.0, 0.0),
        }
    })?)
}

pub fn coarser_weight(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [gather, radius] = row.numbers(["R_G", "rho"])?;
        let w = stochastic::coarser_weight(gather, radius);
        // The difference to the end of the ramp is divided by a tenth of R_G.
        row.close("w", w, 10.0 * ROUNDING)?;
        row.close("one_minus_w", 1.0 - w, 10.0 * ROUNDING)
    })?)
}

pub fn temporal_counts(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [tests, shadowed] = row.numbers(["n", "rho"])?;
        let estimate = ShadowEstimate { tests, shadowed };
        rounded(row, "psi", estimate.fraction())?;
        rounded(row, "variance", estimate.variance())?;
        rounded(row, "standard_error", estimate.standard_error())?;
        let filtered = f64::from(estimate.standard_error() > THRESHOLD);
        row.close("filtered_t_1_50", filtered, 0.0)
    })?)
}

pub fn temporal_statistics(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let mut estimate = ShadowEstimate::none();
        let [psi, variance, error, filtered] =
            ["psi", "variance", "standard_error", "filtered_t_1_50"].map(|column| row.list(column));
        let (psi, variance, error, filtered) = (psi?, variance?, error?, filtered?);
        for (i, tau) in row.list("tau")?.into_iter().enumerate() {
            estimate = estimate.with(tau != 0.0);
            close("psi", estimate.fraction(), psi[i], ROUNDING)?;
            close("variance", estimate.variance(), variance[i], ROUNDING)?;
            close("standard_error", estimate.standard_error(), error[i], ROUNDING)?;
            close("filtered", f64::from(estimate.standard_error() > THRESHOLD), filtered[i], 0.0)?;
        }
        close("length", estimate.tests, psi.len() as f64, 0.0)
    })?)
}

/// The variance below which double precision has too few digits of it.
const SMALL_VARIANCE: f64 = 1e-12;

/// 1e-12 + 16 roundings times the row's condition number, in twice double precision for all rows and in double
/// precision where the variance is not small; there the mean alone.
pub fn two_depths(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let b = row.numbers(["b1", "b2", "b3"])?;
        let precise = scattering::two_depths(b.map(DoubleDouble::from));
        compare_depths(row, precise.depths.map(|z| z.to_f64()), precise.weights.map(|w| w.to_f64()))?;
        let TwoDepths { depths, weights } = scattering::two_depths(b);
        if row.number("c2")? < SMALL_VARIANCE {
            return close("w2 z2 + w3 z3", weights[0] * depths[0] + weights[1] * depths[1], b[0], 1e-12);
        }
        compare_depths(row, depths, weights)
    })?)
}

fn compare_depths(row: &Row, [z2, z3]: [f64; 2], [w2, w3]: [f64; 2]) -> Result<(), String> {
    let sensitivity = |column: &str| Ok::<f64, String>(row.optional(column)?.unwrap_or(0.0));
    for (column, got) in [("z2", z2), ("z3", z3), ("w3", w3)] {
        let sens = sensitivity(&format!("sens_{column}"))?;
        row.close(column, got, 1e-12 + 16.0 * 2f64.powi(-53) * (sens + got.abs()))?;
    }
    close("w2 + w3", w2 + w3, 1.0, 1e-15)?;
    for (column, got) in [("z2_clamped", z2), ("z3_clamped", z3)] {
        let sens = sensitivity(&format!("sens_{}", &column[..2]))?;
        row.close(column, got.clamp(0.0, 1.0), 1e-12 + 16.0 * 2f64.powi(-53) * (sens + 1.0))?;
    }
    Ok(())
}
