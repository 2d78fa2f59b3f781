//! The CPU backend: bands of rows in parallel, each rasterised, grouped by texel and sorted on its own.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::RenderError;
use crate::assemble::{Band, Key, key};
use crate::edges::for_each_span;
use crate::memory::Budget;
use crate::prepare::{NO_MASK, PreparedTriangle, PreparedTriangles};

/// Texels of a band: its counters and fragments should stay within a core's cache.
const BAND_TEXELS: u32 = 1 << 14;

/// Triangles sorted into bands by one task.
const LISTED: usize = 1 << 14;

/// Triangles fetched at once.
const GATHERED: usize = 64;

/// Time spent in the steps inside the bands, summed over threads.
#[derive(Default)]
pub(crate) struct BandTimes {
    raster: AtomicU64,
    group: AtomicU64,
    sort: AtomicU64,
}

impl BandTimes {
    fn add(counter: &AtomicU64, since: &mut Instant) {
        let now = Instant::now();
        counter.fetch_add((now - *since).as_nanos() as u64, Ordering::Relaxed);
        *since = now;
    }

    pub fn raster(&self) -> Duration {
        Duration::from_nanos(self.raster.load(Ordering::Relaxed))
    }
    pub fn group(&self) -> Duration {
        Duration::from_nanos(self.group.load(Ordering::Relaxed))
    }
    pub fn sort(&self) -> Duration {
        Duration::from_nanos(self.sort.load(Ordering::Relaxed))
    }
}

/// Sorted fragments of the whole map, in bands of rows.
pub(crate) fn rasterize(
    prepared: &PreparedTriangles,
    budget: &Budget,
    times: &BandTimes,
) -> Result<Vec<Band>, RenderError> {
    let band_rows = (BAND_TEXELS / prepared.width).max(1);
    let bands = prepared.height.div_ceil(band_rows);
    let lists: Vec<TrianglesOfBands> = prepared
        .triangles
        .par_chunks(LISTED)
        .enumerate()
        .map(|(chunk, triangles)| TrianglesOfBands::new(triangles, chunk * LISTED, band_rows, bands))
        .collect();
    let total = AtomicU64::new(0);
    (0..bands)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, band| {
            let rows = band * band_rows..((band + 1) * band_rows).min(prepared.height);
            let mut triangles = std::mem::take(&mut scratch.triangles);
            triangles.clear();
            lists.iter().for_each(|list| triangles.extend_from_slice(list.of(band)));
            let done = rasterize_band(prepared, rows, &triangles, scratch, &total, budget, times);
            scratch.triangles = triangles;
            done
        })
        .collect()
}

/// For each band those of a chunk of prepared triangles that reach into it, ascending.
struct TrianglesOfBands {
    starts: Vec<usize>,
    triangles: Vec<u32>,
}

impl TrianglesOfBands {
    fn new(triangles: &[PreparedTriangle], first: usize, band_rows: u32, bands: u32) -> Self {
        let bands_of = |t: &PreparedTriangle| {
            (u32::from(t.bounds[1]) / band_rows) as usize
                ..=((u32::from(t.bounds[3]) - 1) / band_rows) as usize
        };
        let mut starts = vec![0; bands as usize + 1];
        for triangle in triangles {
            for band in bands_of(triangle) {
                starts[band + 1] += 1;
            }
        }
        for band in 0..bands as usize {
            starts[band + 1] += starts[band];
        }
        let mut next = starts.clone();
        let mut list = vec![0; starts[bands as usize]];
        for (index, triangle) in (first..).zip(triangles) {
            for band in bands_of(triangle) {
                list[next[band]] = index as u32;
                next[band] += 1;
            }
        }
        Self { starts, triangles: list }
    }

    fn of(&self, band: u32) -> &[u32] {
        &self.triangles[self.starts[band as usize]..self.starts[band as usize + 1]]
    }
}

/// Buffers kept from band to band: fresh memory costs more than the work on it.
#[derive(Default)]
struct Scratch {
    triangles: Vec<u32>,
    gathered: Vec<PreparedTriangle>,
    texel_of: Vec<u32>,
    unordered: Vec<Key>,
    next: Vec<u32>,
}

fn rasterize_band(
    prepared: &PreparedTriangles,
    rows: std::ops::Range<u32>,
    triangles: &[u32],
    scratch: &mut Scratch,
    total: &AtomicU64,
    budget: &Budget,
    times: &BandTimes,
) -> Result<Band, RenderError> {
    let mut since = Instant::now();
    let (width, first_row) = (prepared.width, rows.start);
    let texels = (width * rows.len() as u32) as usize;
    // Counts go one entry late, so that the prefix sum leaves starts, and the ends end as the next one's starts.
    let mut starts = vec![0u32; texels + 1];
    let Scratch { gathered, texel_of, unordered, next, .. } = scratch;
    texel_of.clear();
    unordered.clear();
    let mut counted = 0;
    for (position, &index) in triangles.iter().enumerate() {
        if position % GATHERED == 0 {
            // Loads of one block overlap; triangle by triangle each would wait for memory.
            let block = &triangles[position..triangles.len().min(position + GATHERED)];
            gathered.clear();
            gathered.extend(block.iter().map(|&t| prepared.triangles[t as usize]));
        }
        let triangle = &gathered[position % GATHERED];
        let planes = (triangle.mask != NO_MASK).then(|| &prepared.mask_planes[triangle.mask as usize]);
        let [x0, y0, ..] = triangle.bounds.map(u32::from);
        for_each_span(triangle, rows.clone(), |y, span| {
            let first_texel = (y - first_row) * width;
            let key_at = |x: u32| {
                key(triangle.depth.depth_at(x - x0, y - y0, triangle.depth_low, triangle.depth_high), index)
            };
            if let Some(planes) = planes {
                for x in span.filter(|x| prepared.masks.passes(planes, x - x0, y - y0)) {
                    starts[(first_texel + x) as usize + 1] += 1;
                    texel_of.push(first_texel + x);
                    unordered.push(key_at(x));
                }
            } else {
                for count in &mut starts[(first_texel + span.start + 1) as usize..][..span.len()] {
                    *count += 1;
                }
                texel_of.extend(first_texel + span.start..first_texel + span.end);
                unordered.extend(span.map(key_at));
            }
        });
        // A band may outgrow the memory by itself, so the check cannot wait for its end.
        if unordered.len() - counted > 1 << 20 {
            let new = (unordered.len() - counted) as u64;
            budget.check(total.fetch_add(new, Ordering::Relaxed) + new)?;
            counted = unordered.len();
        }
    }
    let new = (unordered.len() - counted) as u64;
    budget.check(total.fetch_add(new, Ordering::Relaxed) + new)?;
    BandTimes::add(&times.raster, &mut since);

    for texel in 0..texels {
        starts[texel + 1] += starts[texel];
    }
    next.clone_from(&starts);
    let mut keys = vec![0; unordered.len()];
    for (&texel, &key) in texel_of.iter().zip(&*unordered) {
        let slot = &mut next[texel as usize];
        keys[*slot as usize] = key;
        *slot += 1;
    }
    BandTimes::add(&times.group, &mut since);

    for texel in 0..texels {
        sort(&mut keys[starts[texel] as usize..starts[texel + 1] as usize]);
    }
    starts.pop();
    BandTimes::add(&times.sort, &mut since);
    Ok(Band { starts, keys })
}

/// Ascending; most texels hold few fragments, for which insertion beats the general sort.
fn sort(keys: &mut [Key]) {
    if keys.len() > 24 {
        return keys.sort_unstable();
    }
    for i in 1..keys.len() {
        let inserted = keys[i];
        let mut hole = i;
        while hole > 0 && keys[hole - 1] > inserted {
            keys[hole] = keys[hole - 1];
            hole -= 1;
        }
        keys[hole] = inserted;
    }
}
