//! Translucent surfaces: the distribution of the light that is taken, its moments and bounds, Fourier opacity.

use applications::translucency::{FourierOpacity, Layer, blended, in_front, taken};
use libtest_mimic::Failed;
use moment_problem::{DepthDistribution, Interval, MomentBound, closed_form};

use crate::table::{Row, Table, close};

/// What the reference states, relative to 1.
const ROUNDING: f64 = 1e-12;

fn powers(z: f64, out: &mut [f64]) {
    (1..).zip(out).for_each(|(k, value)| *value = z.powi(k));
}

pub fn kernels(table: &Table) -> Result<(), Failed> {
    Ok(table.each(kernel)?)
}

fn kernel(row: &Row) -> Result<(), String> {
    let raw: Vec<f64> = row.list("weights")?;
    let total: f64 = raw.iter().sum();
    let weights: Vec<f64> = raw.iter().map(|weight| weight / total).collect();
    let rays: Vec<Vec<[f64; 2]>> =
        serde_json::from_value(row.json("rays")?).map_err(|e| format!("rays: {e}"))?;
    let layer = |&[depth, opacity]: &[f64; 2]| Layer::new(depth, opacity).map_err(|e| e.to_string());
    let rays: Vec<Vec<Layer>> = rays
        .iter()
        .map(|ray| ray.iter().map(layer).collect::<Result<_, String>>())
        .collect::<Result<_, String>>()?;
    let z_f = row.number("z_f")?;
    let background = Layer::new(1.0, 1.0).map_err(|e| e.to_string())?;
    let mean = |of: &dyn Fn(&[Layer]) -> f64| -> f64 {
        weights.iter().zip(&rays).map(|(weight, ray)| weight * of(ray)).sum()
    };
    row.close("F", mean(&|ray| in_front(&[ray, &[background]].concat(), z_f)), ROUNDING)?;
    let mut atoms: Vec<(f64, f64)> = Vec::new();
    let mut moments = [0.0; 6];
    for (weight, ray) in weights.iter().zip(&rays) {
        let mut layers = [ray.as_slice(), &[background]].concat();
        atoms.extend(taken(&layers).into_iter().map(|(depth, share)| (depth, weight * share)));
        // Later surfaces of one depth lie behind earlier ones.
        layers.sort_by(|a, b| a.depth().total_cmp(&b.depth()));
        layers.reverse();
        let own = blended(&layers, vec![0.0; 6], powers, |value| value);
        moments.iter_mut().zip(own).for_each(|(sum, value)| *sum += weight * value);
    }
    for (k, moment) in moments.into_iter().enumerate() {
        row.close(&format!("b{}", k + 1), moment, ROUNDING)?;
    }
    let up_to: f64 = atoms.iter().filter(|(z, _)| *z <= z_f).map(|(_, share)| share).sum();
    row.close("F_le", up_to, ROUNDING)?;
    let (depths, shares): (Vec<f64>, Vec<f64>) = atoms.into_iter().unzip();
    let z = DepthDistribution::new(&depths, &shares).map_err(|e| e.to_string())?;
    for bound in [MomentBound::Hamburger4, MomentBound::Hamburger6] {
        let solver = closed_form(&bound.basis(), Interval::Real).map_err(|e| e.to_string())?;
        let found = solver.ok_or("no closed form")?.bounds_of(&z, z_f).map_err(|e| e.to_string())?;
        let order = bound.order();
        // Opacities and weights are rounded products here, exact there: what that moves grows as bounds steepen.
        let sensitivity = row.optional(&format!("sens{order}"))?;
        let tolerance = sensitivity.map_or(1e-6, |sens| ROUNDING + sens * f64::EPSILON);
        row.close(&format!("lower{order}"), found.lower, tolerance)?;
        row.close(&format!("upper{order}"), found.upper, tolerance)?;
    }
    fourier(row, &weights, &rays, z_f)
}

fn fourier(row: &Row, weights: &[f64], rays: &[Vec<Layer>], z_f: f64) -> Result<(), String> {
    let weighted: Vec<(f64, &[Layer])> =
        weights.iter().copied().zip(rays.iter().map(Vec::as_slice)).collect();
    for (column, pairs) in [("fourier15", 7), ("fourier17", 8), ("fourier31", 15), ("fourier33", 16)] {
        let found = FourierOpacity::new(&weighted, pairs).map(|map| map.shadow(z_f));
        match (found, row.optional(column)?) {
            (Some(got), Some(expected)) => close(column, got, expected, 1e-11 * (1.0 + expected.abs()))?,
            (None, None) => {}
            (got, expected) => return Err(format!("{column}: {got:?} instead of {expected:?}")),
        }
    }
    if let Some(expected) = row.optional("absorption_exact")? {
        // Geometric mean of transmittances.
        let absorption: f64 =
            weighted.iter().map(|(weight, ray)| weight * (1.0 - in_front(ray, z_f)).ln()).sum();
        close("absorption_exact", 1.0 - absorption.exp(), expected, ROUNDING)?;
    }
    Ok(())
}
