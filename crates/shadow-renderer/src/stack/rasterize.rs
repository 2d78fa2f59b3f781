//! The CPU backend: bands of rows in parallel, each rasterised, grouped by texel and sorted on its own.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::RenderError;
use crate::stack::assemble::{Band, Key, key};
use crate::stack::edges::for_each_span;
use crate::stack::fixed_point::{Depths, Quotient};
use crate::stack::memory::Budget;
use crate::stack::prepare::{NO_MASK, PreparedTriangle, PreparedTriangles};

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
            let [_, y0, _, y1] = t.bounds.map(u32::from);
            (y0 / band_rows) as usize..y1.div_ceil(band_rows) as usize
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
    fragments: Unordered,
    starts: Vec<u32>,
    keys: Vec<Key>,
}

/// Fragments in the order in which they were found.
#[derive(Default)]
struct Unordered {
    /// How many of the places below are taken.
    len: usize,
    texels: Vec<u32>,
    keys: Vec<Key>,
}

/// Fragments computed at once. Rows of small triangles hold a few texels each, so that a loop over exactly those would
/// end in a mispredicted branch every time; the surplus is overwritten by what follows.
const LANES: usize = 4;

impl Unordered {
    /// Makes room for `more` fragments and a row's surplus.
    #[inline]
    fn reserve(&mut self, more: usize) {
        let needed = self.len + more + LANES;
        if needed > self.keys.len() {
            self.texels.resize(needed.next_power_of_two(), 0);
            self.keys.resize(needed.next_power_of_two(), 0);
        }
    }

    /// Adds one.
    #[inline]
    fn push(&mut self, texel: u32, key: Key) {
        (self.texels[self.len], self.keys[self.len]) = (texel, key);
        self.len += 1;
    }

    /// Adds `count` neighbours from `texel` on; depths ascend by `depth.step` from `depth.next`.
    #[inline(always)]
    fn push_row(&mut self, texel: u32, count: usize, mut depth: Depths, triangle: u32) {
        let mut done = 0;
        loop {
            let place = self.len + done;
            let texels = &mut self.texels[place..place + LANES];
            let keys = &mut self.keys[place..place + LANES];
            for (lane, (t, k)) in texels.iter_mut().zip(keys).enumerate() {
                *t = texel + (done + lane) as u32;
                *k = key(depth.next(), triangle);
            }
            done += LANES;
            if done >= count {
                break;
            }
        }
        self.len += count;
    }
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
    let Scratch { gathered, fragments, starts, keys, .. } = scratch;
    fragments.len = 0;
    let mut counted = 0;
    let mut account = |len: usize| {
        let new = (len - std::mem::replace(&mut counted, len)) as u64;
        budget.check(total.fetch_add(new, Ordering::Relaxed) + new)
    };
    for block in triangles.chunks(GATHERED) {
        // Loads of one block overlap; triangle by triangle each would wait for memory.
        gathered.clear();
        gathered.extend(block.iter().map(|&t| prepared.triangles[t as usize]));
        let before = fragments.len;
        for (&index, triangle) in block.iter().zip(&*gathered) {
            let [x0, y0, x1, y1] = triangle.bounds.map(u32::from);
            fragments.reserve(((x1 - x0) * rows.len().min((y1 - y0) as usize) as u32) as usize);
            let planes = (triangle.mask != NO_MASK).then(|| &prepared.mask_planes[triangle.mask as usize]);
            if let Some(weight) = prepared.weights.get(index as usize) {
                for_each_span(triangle, rows.clone(), |y, span| {
                    let shown = |x: &u32| {
                        planes.is_none_or(|of| prepared.masks.passes(of, Some(weight), x - x0, y - y0))
                    };
                    for x in span.filter(shown) {
                        let (value, weight) = (triangle.depth.at(x - x0, y - y0), weight.at(x - x0, y - y0));
                        let depth = Quotient { value, weight }.depth(triangle.depth_low, triangle.depth_high);
                        fragments.push((y - first_row) * width + x, key(depth, index));
                    }
                });
                continue;
            }
            for_each_span(triangle, rows.clone(), |y, span| {
                let depths = |x: u32| {
                    triangle.depth.depths_from(x - x0, y - y0, triangle.depth_low, triangle.depth_high)
                };
                let texel = (y - first_row) * width;
                if let Some(planes) = planes {
                    for x in span.filter(|x| prepared.masks.passes(planes, None, x - x0, y - y0)) {
                        fragments.push_row(texel + x, 1, depths(x), index);
                    }
                } else {
                    fragments.push_row(texel + span.start, span.len(), depths(span.start), index);
                }
            });
        }
        // A band may outgrow the memory by itself, so the check cannot wait for its end.
        if fragments.len - before > 1 << 16 {
            account(fragments.len)?;
        }
    }
    account(fragments.len)?;
    BandTimes::add(&times.raster, &mut since);

    let keys = group(fragments, width as usize * rows.len(), starts, keys);
    BandTimes::add(&times.group, &mut since);

    for range in starts.windows(2) {
        sort(&mut keys[range[0] as usize..range[1] as usize]);
    }
    // Copies go to fresh memory once and in order.
    let band = Band { starts: starts[..starts.len() - 1].to_vec(), keys: keys.to_vec() };
    BandTimes::add(&times.sort, &mut since);
    Ok(band)
}

/// Counting sort by texel: the keys, and in `starts` the first of each of the `texels` texels and the end.
fn group<'a>(
    fragments: &Unordered,
    texels: usize,
    starts: &mut Vec<u32>,
    keys: &'a mut Vec<Key>,
) -> &'a mut [Key] {
    let found = fragments.texels[..fragments.len].iter().zip(&fragments.keys[..fragments.len]);
    starts.clear();
    starts.resize(texels + 1, 0);
    for (&texel, _) in found.clone() {
        starts[texel as usize] += 1;
    }
    let mut sum = 0;
    for start in starts.iter_mut() {
        sum += *start;
        *start = sum;
    }
    if keys.len() < fragments.len {
        keys.resize(fragments.keys.len(), 0);
    }
    let keys = &mut keys[..fragments.len];
    // Each texel is filled from its end, which leaves its start behind.
    for (&texel, &key) in found {
        let place = &mut starts[texel as usize];
        *place -= 1;
        keys[*place as usize] = key;
    }
    keys
}

/// Ascending; most texels hold few fragments, for which insertion beats the general sort and comparing without
/// branches beats insertion.
#[inline]
fn sort(keys: &mut [Key]) {
    let ordered = |a: Key, b: Key| (a.min(b), a.max(b));
    match keys {
        [] | [_] => {}
        [a, b] => (*a, *b) = ordered(*a, *b),
        [a, b, c] => {
            (*a, *b) = ordered(*a, *b);
            (*b, *c) = ordered(*b, *c);
            (*a, *b) = ordered(*a, *b);
        }
        [a, b, c, d] => {
            (*a, *b) = ordered(*a, *b);
            (*c, *d) = ordered(*c, *d);
            (*a, *c) = ordered(*a, *c);
            (*b, *d) = ordered(*b, *d);
            (*b, *c) = ordered(*b, *c);
        }
        _ if keys.len() > 24 => keys.sort_unstable(),
        _ => insertion_sort(keys),
    }
}

fn insertion_sort(keys: &mut [Key]) {
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
