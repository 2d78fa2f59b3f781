//! Average blocker depth from four moments.

use applications::field::{MAX_CHANNELS, Means};
use applications::soft_shadow::{Reconstruction, Warp};
use libtest_mimic::Failed;
use moment_problem::MomentBound;

use crate::table::{Row, Table, close};

/// Where one distribution only has the moments, any rounding matters like a root.
const DETERMINED: f64 = 1e-3;

/// The umbra decision is not judged this near to its threshold.
const UNDECIDED: f64 = 1e-9;

/// 1e-13 + 8 times what one rounding of each moment does to the row.
pub fn blockers(table: &Table) -> Result<(), Failed> {
    // The moments are biased already.
    let technique = Reconstruction::new(MomentBound::Hamburger4, Warp::None, 0.0)?;
    Ok(table.each(|row| {
        let b = row.numbers(["b1", "b2", "b3", "b4"])?;
        let mut means: Means<f64> = [0.0; MAX_CHANNELS];
        means[..4].copy_from_slice(&b);
        let z = row.number("z_f")?;
        let found = technique.blockers(&means, z);
        let tolerance = match (row.flag("determined")?, row.optional("dev_f64")?) {
            (false, Some(deviation)) => 1e-13 + 8.0 * deviation,
            (false, None) | (true, _) => DETERMINED,
        };
        row.close("avg_eps_0.01", found.average(z, 0.01), tolerance)?;
        // The divisor is ten times smaller at least, so is what it forgives.
        row.close("avg_eps_0.001", found.average(z, 0.001), (10.0 * tolerance).min(DETERMINED))?;
        // dev_f64 is that of an average, in which an error of its divisor G counts for z_f - average only.
        row.close("G", found.mass, 16.0 * tolerance)?;
        plain(row, found.average(z, 0.0), found.mass, tolerance)?;
        let mass = row.number("G")?;
        if (mass - 0.99).abs() > UNDECIDED.max(16.0 * tolerance) {
            row.close("umbra_0.01", f64::from(found.mass > 0.99), 0.0)?;
        }
        Ok(())
    })?)
}

/// Without epsilon the average is undefined where nothing is in front, and as good as its divisor.
fn plain(row: &Row, got: f64, mass: f64, tolerance: f64) -> Result<(), String> {
    match row.optional("avg_plain")? {
        Some(average) if mass > 0.01 => close("avg_plain", got, average, 4.0 * tolerance / mass),
        Some(_) | None => close("avg_plain is finite", f64::from(got.is_finite()), 1.0, 0.0),
    }
}
