//! Single scattering: media, rectified coordinates, prefix sums, and rays through a shadow map end to end.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use applications::field::{MAX_CHANNELS, Means};
use applications::scattering::{
    LightAxes, LightMap, Medium, Rectification, Rectified, adaptive_blend, prefix_means, resample, scattered,
    step_weights,
};
use libtest_mimic::Failed;
use moment_problem::arithmetic::{DoubleDouble, Real};
use moment_problem::{DepthDistribution, Interval, MomentBound, closed_form};
use serde::Deserialize;
use shadow_filtering::DepthMap;
use std::f64::consts::{PI, TAU};

use crate::table::{Row, Table, close};

/// Relative: what the reference states for its own sums.
const ROUNDING: f64 = 1e-12;

/// Bounds from moments, per unit of the reference's sensitivity: four roundings of double precision.
const SENSITIVITY: f64 = 4.0 / (1u64 << 53) as f64;

/// Three moments of nearly one surface hold no more of where the other is.
const NEARLY_ONE: f64 = 1e-3;

fn medium(extinction: f64, albedo: f64, anisotropy: f64) -> Result<Medium, String> {
    Medium::new(extinction, albedo, anisotropy).map_err(|e| e.to_string())
}

fn vector(row: &Row, column: &str) -> Result<[f64; 3], String> {
    row.list(column)?.try_into().map_err(|_| format!("{column} has not three numbers"))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    a.map(|value| value / dot(a, a).sqrt())
}

fn relative(row: &Row, column: &str, got: f64) -> Result<(), String> {
    let expected = row.text(column)?;
    if expected == "inf" {
        return if got == f64::INFINITY { Ok(()) } else { Err(format!("{column}: {got} for infinity")) };
    }
    row.close(column, got, ROUNDING * (got.abs() + 1e-3))
}

pub fn closed_forms(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [extinction, albedo, g, irradiance, s] = row.numbers(["sigma_t", "albedo", "g", "E", "s"])?;
        let medium = medium(extinction, albedo, g)?;
        let (view, light) = (unit(vector(row, "view")?), unit(vector(row, "light")?));
        let geometry = row.json("geometry")?;
        let max_integral = medium.transmitted_length(0.0, s);
        let integral = if geometry["type"] == "slits" {
            slits(&geometry, vector(row, "camera")?, view, light, s, &medium)?
        } else {
            let lit: Vec<[serde_json::Value; 2]> =
                serde_json::from_value(row.json("lit")?).map_err(|e| format!("lit: {e}"))?;
            let end = |value: &serde_json::Value| value.as_f64().unwrap_or(f64::INFINITY);
            lit.iter().map(|[from, to]| medium.transmitted_length(end(from), end(to))).sum()
        };
        let tolerance = if geometry["type"] == "slits" { 1e-9 } else { ROUNDING };
        match row.text("integral")? {
            "inf" => close("1 / integral", 1.0 / integral, 0.0, 0.0)?,
            _ => row.close("integral", integral, tolerance * (max_integral.min(1e6) + 1e-3))?,
        }
        relative(row, "max_integral", max_integral)?;
        relative(row, "transmittance", medium.transmittance(s))?;
        let cosine = -dot(light, view);
        row.close("cos_scatter", cosine, ROUNDING)?;
        // The phase function is steep where light is scattered forwards.
        row.close("phase", medium.phase(cosine), 1e-10 * (1.0 + medium.phase(cosine)))?;
        row.close("beta_adaptive", adaptive_blend(cosine), ROUNDING)?;
        if integral.is_finite() {
            let radiance = medium.phase(cosine) * irradiance * integral;
            row.close("radiance_paper", radiance, 1e-9 * (1.0 + radiance))?;
            let of_sigma = radiance * medium.scattering();
            row.close("radiance_sigma_s", of_sigma, 1e-9 * (1.0 + of_sigma))?;
        }
        Ok(())
    })?)
}

/// int V e^(-sigma_t t) dt where light passes an opaque plane through slits.
fn slits(
    geometry: &serde_json::Value,
    camera: [f64; 3],
    view: [f64; 3],
    light: [f64; 3],
    s: f64,
    medium: &Medium,
) -> Result<f64, String> {
    let of = |key: &str| -> Result<[f64; 3], String> {
        serde_json::from_value(geometry[key].clone()).map_err(|e| format!("{key}: {e}"))
    };
    let number = |key: &str| geometry[key].as_f64().ok_or(format!("no {key}"));
    let (o, normal, e) = (of("o")?, of("N")?, unit(of("e")?));
    let (period, duty) = (number("period")?, number("duty")?);
    // Hit of the shadow ray from p + t v against the light: y = q - light (q - o).N / light.N, linear in t.
    let slope = dot(light, normal);
    let relative: [f64; 3] = std::array::from_fn(|k| camera[k] - o[k]);
    let height = |a: [f64; 3]| dot(a, normal) / slope;
    let along = |a: [f64; 3]| dot(a, e) - height(a) * dot(light, e);
    let (start, rate) = (along(relative) / period, along(view) / period);
    // Behind the plane where (q - o).N / light.N > 0.
    let (h, dh) = (height(relative), height(view));
    // Beyond, 1e-26 of the light is left.
    let s = s.min(60.0 / medium.extinction());
    let mut borders = vec![0.0, s];
    if dh != 0.0 {
        borders.push(-h / dh);
    }
    if rate != 0.0 {
        let (low, high) = (start.min(start + rate * s).floor(), start.max(start + rate * s).ceil());
        let mut k = low - 1.0;
        while k <= high {
            borders.extend([(k - start) / rate, (k + duty - start) / rate]);
            k += 1.0;
        }
    }
    borders.retain(|t| *t >= 0.0 && *t <= s);
    borders.sort_by(f64::total_cmp);
    let lit = |t: f64| h + t * dh <= 0.0 || (start + t * rate).rem_euclid(1.0) < duty;
    Ok(borders
        .windows(2)
        .filter(|ends| lit(0.5 * (ends[0] + ends[1])))
        .map(|ends| medium.transmitted_length(ends[0], ends[1]))
        .sum())
}

/// Exact but for 106 bits, so that few surfaces can be told from none.
fn powers(depth: f64) -> Means<DoubleDouble> {
    let mut power = DoubleDouble::one();
    std::array::from_fn(|_| {
        power = power * DoubleDouble::from(depth);
        power
    })
}

/// Means of the powers of texels 0 to u.
fn prefix(depths: &[f64], weights: &[f64]) -> Vec<Means<DoubleDouble>> {
    let mut row: Vec<DoubleDouble> = depths.iter().flat_map(|&depth| powers(depth)).collect();
    prefix_means(&mut row, MAX_CHANNELS, weights.iter().copied());
    row.chunks_exact(MAX_CHANNELS).map(|texel| std::array::from_fn(|k| texel[k])).collect()
}

pub fn prefix_sums(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [extinction, delta] = row.numbers(["sigma_t", "delta"])?;
        let depths = row.list("depths")?;
        let weights = step_weights(&medium(extinction, 1.0, 0.0)?, delta, depths.len());
        let expected = row.list("w")?;
        for (got, expected) in weights.iter().zip(&expected) {
            close("w", *got, *expected, ROUNDING * expected)?;
        }
        let sums = prefix(&depths, &weights);
        for (column, k) in [("prefix_b1", 0), ("prefix_b2", 1), ("prefix_b3", 2), ("prefix_b6", 5)] {
            for (u, expected) in row.list(column)?.iter().enumerate() {
                let got = sums.get(u).ok_or("an empty row")?[k].to_f64();
                close(column, got, *expected, ROUNDING * (expected + 1e-3))?;
            }
        }
        Ok(())
    })?)
}

/// The bounds of a row of the table, and their blend: of the distribution itself, and from its moments, unless it is the only
/// one that has them, where the answer hangs on the last bit of z_f.
fn bounds_met(row: &Row, depths: &[f64], weights: &[f64], z_f: f64) -> Result<(), String> {
    let total: f64 = weights.iter().sum();
    let shares: Vec<f64> = weights.iter().map(|weight| weight / total).collect();
    let z = DepthDistribution::new(depths, &shares).map_err(|e| e.to_string())?;
    let sums = prefix(depths, weights);
    let moments = sums.last().ok_or("an empty row")?;
    let exact = DoubleDouble::from;
    for (order, bound) in [(4, MomentBound::Hamburger4), (6, MomentBound::Hamburger6)] {
        let [lower, upper] = row.numbers([&format!("lower{order}"), &format!("upper{order}")])?;
        let solver = closed_form(&bound.basis(), Interval::Real).map_err(|e| e.to_string())?;
        let found = solver.ok_or("no closed form")?.bounds_of(&z, z_f).map_err(|e| e.to_string())?;
        close(&format!("lower{order}"), found.lower, lower, ROUNDING)?;
        close(&format!("upper{order}"), found.upper, upper, ROUNDING)?;
        let Some(sensitivity) = row.optional(&format!("sens{order}"))? else { continue };
        for (beta, expected) in [(0.0, lower), (0.5, 0.5 * (lower + upper)), (1.0, upper)] {
            let lit = scattered(bound, &moments[..order], exact(z_f), exact(beta)).to_f64();
            let tolerance = ROUNDING + SENSITIVITY * sensitivity;
            close(&format!("{order} moments, beta = {beta}"), 1.0 - lit, expected, tolerance)?;
        }
    }
    Ok(())
}

pub fn look_ups(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [extinction, delta, z_f, s] = row.numbers(["sigma_t", "delta", "z_f", "s"])?;
        let medium = medium(extinction, 1.0, 0.0)?;
        let depths = row.list("depths")?;
        let weights = step_weights(&medium, delta, depths.len());
        let sums = prefix(&depths, &weights);
        for (k, moment) in sums.last().ok_or("an empty row")?.iter().take(6).enumerate() {
            row.close(&format!("b{}", k + 1), moment.to_f64(), ROUNDING)?;
        }
        let total: f64 = weights.iter().sum();
        let before: f64 = depths.iter().zip(&weights).filter(|(z, _)| **z < z_f).map(|(_, w)| w).sum();
        row.close("F", before / total, ROUNDING)?;
        bounds_met(row, &depths, &weights, z_f)?;
        let largest = medium.transmitted_length(0.0, s);
        relative(row, "max_integral", largest)?;
        row.close("integral_exact", (1.0 - before / total) * largest, ROUNDING * (largest + 1.0))
    })?)
}

pub fn rectified(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let axes =
            LightAxes { x: vector(row, "axis_x")?, y: vector(row, "axis_y")?, light: vector(row, "light")? };
        let (camera, point) = (vector(row, "camera")?, vector(row, "point")?);
        let rectification = Rectification {
            camera,
            axes,
            size: [1, 1],
            r_max: 1.0,
            phi_start: 0.0,
            phi_extent: TAU,
            flipped: row.numbers(["flipped_min", "flipped_max"])?,
        };
        let got = rectification.rectify(point);
        let rounding = ROUNDING * (1.0 + row.number("distance")?);
        row.close("r", got.r, rounding)?;
        row.close("flipped", got.flipped, ROUNDING)?;
        row.close("theta", PI - got.flipped, ROUNDING)?;
        if let Some(phi) = row.optional("phi")? {
            // Near the axis the azimuth is that of rounding.
            let turned = (got.phi - phi + PI).rem_euclid(TAU) - PI;
            close("phi", turned, 0.0, rounding / got.r.min(1.0))?;
        }
        let depth = rectification.depth(got.flipped);
        row.close("depth", depth, ROUNDING * (1.0 + depth.abs()))?;
        row.close("depth_clamped", depth.clamp(0.0, 1.0), ROUNDING)
    })?)
}

pub fn resampled(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let b = row.numbers(["b1", "b2", "b3"])?;
        let range = row.numbers(["z_near", "z_far"])?;
        let flipped = row.numbers(["flipped_min", "flipped_max"])?;
        let got = resample(b, range, row.number("r")?, flipped);
        // Three moments hold so much of two depths: rounding over the variance.
        let variance = b[1] - b[0] * b[0];
        let conditioning = 1.0 / variance.abs().max(1e-16);
        let tolerance = (ROUNDING + 1e-14 * conditioning).min(NEARLY_ONE);
        for (k, moment) in got.moments(6).iter().take(6).enumerate() {
            row.close(&format!("out_b{}", k + 1), *moment, tolerance)?;
        }
        if tolerance < 1e-9 {
            row.close("clamped2", got.depths[0], 1e3 * tolerance)?;
            row.close("w2", got.two.weights[0], 1e3 * tolerance)?;
        }
        Ok(())
    })?)
}

#[derive(Deserialize)]
struct Map {
    width: usize,
    height: usize,
    extent: f64,
    z_range: f64,
    depth: Vec<Vec<u32>>,
    camera: [f64; 3],
    rectified: Grid,
}

#[derive(Deserialize)]
struct Grid {
    columns: usize,
    rows: usize,
    r_max: f64,
    flipped_min: f64,
    flipped_max: f64,
    delta: f64,
    depth: Vec<Vec<f64>>,
}

pub fn rays(table: &Table) -> Result<(), Failed> {
    let mut maps: HashMap<String, (Map, DepthMap)> = HashMap::new();
    for row in table.rows() {
        let name = row.text("map")?.to_owned();
        if let Entry::Vacant(vacant) = maps.entry(name) {
            let path = table.sibling(&format!("scatter_map_{}.json", vacant.key()));
            let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            let map: Map = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
            let depths = map.depth.iter().flatten().map(|&d| d as f32 / 4096.0).collect();
            let depths = DepthMap::new(map.width, map.height, depths)?;
            vacant.insert((map, depths));
        }
    }
    let axes = LightAxes { x: [1.0, 0.0, 0.0], y: [0.0, 1.0, 0.0], light: [0.0, 0.0, 1.0] };
    for (map, depths) in maps.values() {
        for (row, line) in map.rectified.depth.iter().enumerate() {
            for (got, expected) in rectified_row(map, depths, axes, row).iter().zip(line) {
                // Printed with nine digits.
                close(&format!("rectified depth of row {row}"), *got, *expected, 1e-8)?;
            }
        }
    }
    Ok(table.each(|row| ray(row, &maps[row.text("map")?], axes))?)
}

/// Depths without a filter, the nearest texel each; 1 outside of the map.
fn rectified_row(map: &Map, depths: &DepthMap, axes: LightAxes, row: usize) -> Vec<f64> {
    let (rectification, light) = placed(map, depths, axes);
    let depth = |column: usize| {
        let [x, y] = rectification.texel(column, row);
        let z = light.occluder(map.camera[0] + x, map.camera[1] + y) - map.camera[2];
        if z.is_finite() {
            rectification.depth(Rectified::of([x, y, z]).flipped).clamp(0.0, 1.0)
        } else {
            1.0
        }
    };
    (0..rectification.size[0]).map(depth).collect()
}

fn placed<'a>(map: &Map, depths: &'a DepthMap, axes: LightAxes) -> (Rectification, LightMap<'a>) {
    let grid = &map.rectified;
    let rectification = Rectification {
        camera: map.camera,
        axes,
        size: [grid.columns, grid.rows],
        r_max: grid.r_max,
        phi_start: 0.0,
        phi_extent: TAU,
        flipped: [grid.flipped_min, grid.flipped_max],
    };
    let texel = map.extent / map.width as f64;
    (
        rectification,
        LightMap { map: depths, corner: [0.0; 2], texel: [texel; 2], near: 0.0, range: map.z_range },
    )
}

fn ray(row: &Row, (map, depths): &(Map, DepthMap), axes: LightAxes) -> Result<(), String> {
    let (rectification, light) = placed(map, depths, axes);
    let [extinction, s] = row.numbers(["sigma_t", "s"])?;
    let (medium, view) = (medium(extinction, 1.0, 0.0)?, unit(vector(row, "view")?));
    let largest = medium.transmitted_length(0.0, s);
    relative(row, "max_integral", largest)?;
    let exact = light.scattered(&medium, map.camera, view, s);
    row.close("integral_map", exact, 1e-11 * (1.0 + largest))?;
    for steps in [16, 32, 64, 128, 256] {
        let marched = light.marched(&medium, (map.camera, view, s), steps, 0.0);
        row.close(&format!("march{steps}"), marched, 1e-9)?;
    }
    let far = Rectified::of(view);
    let z_f = rectification.depth(far.flipped);
    row.close("z_f", z_f, ROUNDING)?;
    let index = rectification.row(far.phi);
    close("row", index as f64, row.number("row")?, 0.0)?;
    let end = ((s * far.r / rectification.column_width()) as usize).min(rectification.size[0] - 1);
    close("u_end", end as f64, row.number("u_end")?, 0.0)?;
    // Whole cells from the camera on, spaced by the published mean.
    let delta = rectification.mean_spacing();
    close("delta", delta, map.rectified.delta, 1e-9 * delta)?;
    let cells = |u: usize| medium.transmitted_length(u as f64 * delta, (u + 1) as f64 * delta);
    let weights: Vec<f64> = (0..rectification.size[0]).map(cells).collect();
    let line = rectified_row(map, depths, axes, index);
    let before: f64 = (0..=end).filter(|&u| line[u] < z_f).map(|u| weights[u]).sum();
    let f = before / weights[..=end].iter().sum::<f64>();
    row.close("F", f, 1e-11)?;
    row.close("pre_exact", (1.0 - f) * largest, 1e-10 * (1.0 + largest))?;
    bounds_met(row, &line[..=end], &weights[..=end], z_f)
}
