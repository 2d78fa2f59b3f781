//! What area lights do: the truth by shadow rays, and percentage-closer soft shadows in their exact case.

use applications::PlacedLight;
use applications::field::Fit;
use applications::rays::Triangles;
use applications::region::Region;
use applications::soft_shadow::{
    AreaTruth, BlockerSearch, Blockers, DepthField, Filter, Fragment, Penumbra, TruthSettings,
    percentage_closer_soft_shadow,
};
use libtest_mimic::Failed;
use rayon::prelude::*;
use scenes::Outline;

use crate::table::{Row, Table, close};

/// Rays are sent until this standard error.
const STANDARD_ERROR: f64 = 1e-4;

/// Six standard errors, what the reference's own rays differ by.
const RAYS: f64 = 6.0 * STANDARD_ERROR;

/// Formulas of some twenty operations, relative to the size of a length.
const ROUNDING: f64 = 1e-13;

/// The fraction of the light that triangles cover.
pub fn occluded_fractions(table: &Table) -> Result<(), Failed> {
    let settings = TruthSettings { standard_error: STANDARD_ERROR, most_rays: 1 << 20, seed: 1 };
    let truth = AreaTruth::new(settings)?;
    let results: Vec<Result<(), String>> = table
        .rows()
        .into_par_iter()
        .map(|row| occluded_fraction(&row, &truth).map_err(|e| table.located(&row, e)))
        .collect();
    Ok(results.into_iter().collect::<Result<(), String>>()?)
}

fn occluded_fraction(row: &Row, truth: &AreaTruth) -> Result<(), String> {
    let a = row.number("a")?;
    let (outline, b, at_infinity) = match row.text("light")? {
        "rect" => (Outline::Rectangle, row.number("b")?, false),
        "disc" => (Outline::Disc, a, false),
        "dir_rect" => (Outline::Rectangle, row.number("b")?, true),
        "dir_disc" => (Outline::Disc, a, true),
        other => return Err(format!("unknown light `{other}`")),
    };
    let half_axes = [[a, 0.0, 0.0], [0.0, b, 0.0]];
    let middle = [0.0, 0.0, if at_infinity { -1.0 } else { 0.0 }];
    let light = PlacedLight { outline, middle, half_axes, at_infinity };
    let polygons: Vec<Vec<[f32; 3]>> =
        serde_json::from_value(row.json("occluders")?).map_err(|e| format!("occluders: {e}"))?;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for polygon in polygons {
        let first = positions.len() as u32;
        triangles.extend((2..polygon.len() as u32).map(|k| [first, first + k - 1, first + k]));
        positions.extend(polygon);
    }
    let scene = Triangles::new(&positions, &triangles).map_err(|e| e.to_string())?;
    let receiver = row.numbers(["x", "y", "d_r"])?;
    let stream = row.integer("id")?;
    let found = truth.occluded_fraction(&scene, &light, receiver, None, stream);
    close("standard error", found.standard_error, 0.0, STANDARD_ERROR)?;
    row.close("occluded_fraction", found.fraction, RAYS)
}

/// Parallel rectangles as seen from the light's centre, on the near plane: a map without texels.
struct Rectangles {
    /// Low and high corner, and depth.
    all: Vec<(Region<f64>, f64)>,
}

impl Rectangles {
    fn nearest(&self, point: [f64; 2]) -> Option<f64> {
        let holds = |r: &Region<f64>| (0..2).all(|k| r.low[k] <= point[k] && point[k] <= r.high[k]);
        let depths = self.all.iter().filter(|(region, _)| holds(region)).map(|&(_, depth)| depth);
        depths.reduce(f64::min)
    }

    /// Borders of the rectangles within an interval, with its ends.
    fn cuts(&self, k: usize, low: f64, high: f64) -> Vec<f64> {
        let borders = self.all.iter().flat_map(|(r, _)| [r.low[k], r.high[k]]);
        let mut cuts: Vec<f64> = borders.filter(|&b| low < b && b < high).chain([low, high]).collect();
        cuts.sort_by(f64::total_cmp);
        cuts
    }
}

impl DepthField<f64> for Rectangles {
    /// Exact: cells between borders see one rectangle.
    fn in_front(&self, region: &Region<f64>, _: Fit, z: f64) -> Blockers<f64> {
        let area = region.area();
        let mut found = Blockers::none();
        let mut see = |point: [f64; 2], weight: f64| {
            if let Some(depth) = self.nearest(point).filter(|&depth| depth < z) {
                found = found.with(depth, weight);
            }
        };
        if area > 0.0 {
            let [columns, rows] = [0, 1].map(|k| self.cuts(k, region.low[k], region.high[k]));
            for x in columns.windows(2) {
                for y in rows.windows(2) {
                    see([0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])], (x[1] - x[0]) * (y[1] - y[0]) / area);
                }
            }
        } else {
            see(region.low, 1.0);
        }
        found
    }
}

/// Search region, blocker, penumbra, kernel and result of percentage-closer soft shadows, and the same with the
/// epsilon and the umbra shortcut of moment soft shadows, which loses nothing here.
pub fn percentage_closer(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let [a, b, near, far, d_r, x, y] = row.numbers(["a", "b", "near", "far", "d_r", "x", "y"])?;
        let depth_of = |distance: f64| (distance - near) / (far - near);
        let distance_of = |depth: f64| near + depth * (far - near);
        let light = Penumbra {
            half_size: [a, b],
            near: Some(near),
            depth_range: far - near,
            texels_per_unit: [1.0; 2],
        };
        let corners: Vec<[f64; 4]> =
            serde_json::from_value(row.json("rectangles")?).map_err(|e| format!("rectangles: {e}"))?;
        let all = corners.into_iter().zip(row.list("d_o")?).map(|([x0, x1, y0, y1], d)| {
            let on_map = |c: f64| c * near / d;
            let region = Region { low: [on_map(x0), on_map(y0)], high: [on_map(x1), on_map(y1)] };
            (region, depth_of(d))
        });
        let map = Rectangles { all: all.collect() };
        let z = depth_of(d_r);
        let position = [x * near / d_r, y * near / d_r];
        let sizes = |row: &Row, names: [&str; 2], got: [f64; 2]| {
            (0..2).try_for_each(|k| row.close(names[k], got[k], ROUNDING * far))
        };
        sizes(row, ["search_x", "search_y"], light.search(z))?;
        let region = Region::around(position, light.search(z));
        let found = map.in_front(&region, Fit::Covered, z);
        row.close("p_search", found.mass, ROUNDING)?;
        let shade = |search: &BlockerSearch<f64>| {
            let at = Fragment { position, depth: z, bias: 0.0, noise: [0.0; 2] };
            percentage_closer_soft_shadow(&map, &light, search, &Filter::published(), &at)
        };
        // A small kernel magnifies the rounding of where it lies.
        let magnified = |kernel: [f64; 2]| ROUNDING * (1.0 + far / kernel[0].min(kernel[1]).max(1e-9));
        match row.optional("pcss_blocker")? {
            Some(blocker) => {
                let average = found.average(z, 0.0);
                close("pcss_blocker", distance_of(average), blocker, ROUNDING * far)?;
                sizes(row, ["penumbra_x", "penumbra_y"], light.on_receiver(z, average))?;
                let kernel = light.filter(z, average);
                sizes(row, ["kernel_x", "kernel_y"], kernel)?;
                row.close("pcss", shade(&BlockerSearch::percentage_closer()), magnified(kernel))?;
            }
            None => close("p_search without a blocker", found.mass, 0.0, 0.0)?,
        }
        let average = found.average(z, 0.01);
        row.close("mssm_blocker_0.01", distance_of(average), ROUNDING * far)?;
        sizes(row, ["mssm_kernel_x_0.01", "mssm_kernel_y_0.01"], light.filter(z, average))?;
        let published = BlockerSearch::published();
        row.close("mssm_0.01", shade(&published), magnified(light.filter(z, average)))?;
        row.close("umbra", f64::from(found.mass > published.umbra), 0.0)?;
        let fine = found.average(z, 0.001);
        row.close("mssm_blocker_0.001", distance_of(fine), ROUNDING * far)?;
        let later = BlockerSearch { epsilon: 0.001, ..published };
        row.close("mssm_0.001", shade(&later), magnified(light.filter(z, fine)))
    })?)
}
