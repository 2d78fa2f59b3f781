//! Summed-area tables: whole numbers bit for bit, means to rounding.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use applications::field::{Fit, Means, MomentField, SummedMoments};
use applications::region::Region;
use libtest_mimic::Failed;
use quantization::{NumberFormat, Rectangle, SummedAreaTable};
use serde_json::Value;

use crate::table::{Row, Table, close};

/// A mean of at most nine sums of whole numbers below 2^32.
const ROUNDING: f64 = 2e-15;

/// Depths of a map in units of 1/4096, which single precision holds.
struct Map {
    size: [usize; 2],
    depths: Vec<f32>,
}

impl Map {
    fn read(table: &Table, name: &str) -> Result<Self, String> {
        let path = table.sibling(&format!("sat_map_{name}.json"));
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let value: Value = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        let rows: Vec<Vec<f64>> = serde_json::from_value(value["depth"].clone())
            .map_err(|e| format!("{}: depth: {e}", path.display()))?;
        if value["depth_unit"] != "1/4096" || rows.is_empty() || rows.iter().any(|r| r.len() != rows[0].len())
        {
            return Err(format!("{} holds no depths in units of 1/4096", path.display()));
        }
        let size = [rows[0].len(), rows.len()];
        Ok(Self { size, depths: rows.into_iter().flatten().map(|d| (d / 4096.0) as f32).collect() })
    }

    fn powers(&self) -> Vec<f64> {
        let texels = self.depths.iter().map(|&d| f64::from(d));
        texels.flat_map(|d| [d, d * d, d * d * d, d * d * d * d]).collect()
    }
}

/// What rows of one map and N share, made once.
fn cached<T>(
    table: &Table,
    make: impl Fn(&Map, u32) -> Result<T, String>,
) -> Result<HashMap<(String, u32), T>, String> {
    let mut found = HashMap::new();
    for row in table.rows() {
        let key = key(&row)?;
        if let Entry::Vacant(place) = found.entry(key) {
            let (map, window) = place.key();
            let made = make(&Map::read(table, map)?, *window).map_err(|e| table.located(&row, e))?;
            place.insert(made);
        }
    }
    Ok(found)
}

fn key(row: &Row) -> Result<(String, u32), String> {
    let texels = row.integer("N")?;
    Ok((row.text("map")?.to_owned(), u32::try_from(texels).map_err(|e| format!("N = {texels}: {e}"))?))
}

/// Codes bit for bit; where the value lies half way between two, either.
pub fn encoding(table: &Table) -> Result<(), Failed> {
    Ok(table.each(|row| {
        let format = NumberFormat::U32Fixed { texels: key(row)?.1 };
        let code = f64::from(format.encode(row.number("value")?));
        row.close("encoded_floor", code, f64::from(row.flag("tie")?))
    })?)
}

/// Sums bit for bit.
pub fn integer_queries(table: &Table) -> Result<(), Failed> {
    let tables = cached(table, |map, texels| {
        let size = (map.size[0], map.size[1], 4);
        SummedAreaTable::new(size, &map.powers(), texels).map_err(|e| e.to_string())
    })?;
    Ok(table.each(|row| {
        let summed = &tables[&key(row)?];
        let [x0, y0, x1, y1] = ["x0", "y0", "x1", "y1"].map(|c| row.integer(c));
        let (x0, y0, x1, y1) = (x0? as usize, y0? as usize, x1? as usize, y1? as usize);
        let rectangle = Rectangle { first: (x0, y0), last: (x1 - 1, y1 - 1) };
        for channel in 0..4 {
            let sum = summed.sum(rectangle, channel).map_err(|e| e.to_string())?;
            row.close(&format!("sum_floor_{}", channel + 1), f64::from(sum), 0.0)?;
            let mean = summed.mean(rectangle, channel).map_err(|e| e.to_string())?;
            row.close(&format!("mean_{}", channel + 1), mean, ROUNDING)?;
        }
        Ok(())
    })?)
}

/// Real rectangles by at most nine queries, each of at most N texels.
pub fn real_queries(table: &Table) -> Result<(), Failed> {
    let fields = cached(table, |map, texels| {
        let powers = |depth: f64, out: &mut [f64]| {
            out.iter_mut().zip(1..).for_each(|(value, order)| *value = depth.powi(order));
        };
        SummedMoments::new(map.size, &map.depths, 4, texels, powers).map_err(|e| e.to_string())
    })?;
    Ok(table.each(|row| {
        let key = key(row)?;
        let field = &fields[&key];
        let region = Region { low: row.numbers(["x0", "y0"])?, high: row.numbers(["x1", "y1"])? };
        let (regions, largest) = field.regions(&region, Fit::Covered);
        // Ends on the grid need no region of their own here.
        let most = row.integer("regions")?;
        if regions as u64 > most || largest as u64 > u64::from(key.1) {
            return Err(format!("{regions} regions of up to {largest} texels where {most} of {} do", key.1));
        }
        let means: Means<f64> = field.means(&region, Fit::Covered).map_err(|e| e.to_string())?;
        // Ends of the rectangle are rounded relative to the map, areas of partly covered texels cancel by as much.
        let cancelled = 64.0 * 2f64.powi(-53) / region.area().min(1.0);
        let half_step = 0.5 / f64::from(NumberFormat::fixed_point_scale(key.1));
        for (channel, &mean) in means.iter().enumerate().take(4) {
            row.close(&format!("mean_{}", channel + 1), mean, ROUNDING + cancelled)?;
            row.close(&format!("exact_{}", channel + 1), mean, half_step + ROUNDING + cancelled)?;
        }
        close("touched texels", touched(&region), row.number("touched_texels")?, 0.0)
    })?)
}

fn touched(region: &Region<f64>) -> f64 {
    let extent = |k: usize| region.high[k].ceil() - region.low[k].floor();
    extent(0) * extent(1)
}
