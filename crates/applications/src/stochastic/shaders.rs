//! WGSL twins of everything after the rays, as compute passes in the order in which they run: rays are encoded once; then each
//! plane is merged, widened, split into levels, gathered, and stored; then fragments are shaded.
//!
//! Bindings stand in the modules, all in group 0; a name means the same buffer in all of them. [`FilterShaders::buffers`] has the sizes of those
//! that passes write; others are the rays ([`LensMap::for_shader`]), the `fragments`, the `plane_distances`, and the uniform
//! `plane` ([`plane_uniform`]), which changes from plane to plane.

use moment_problem::wgsl::ELEMENTARY;
use shaders::{array, constant, count, flag, unroll};
use shadow_filtering::Technique;

use super::edges::{GAUSSIAN, turn};
use super::layout::{Layout, LevelPlace};
use super::{Footprint, LensMap, PlaneFilter, SampleCentre, TILE};
use crate::packed_values;
use crate::samples::PoissonTaps;

const LENS: &str = include_str!("lens.wgsl");
const ENCODE: &str = include_str!("encode.wgsl");
const MERGE: &str = include_str!("merge.wgsl");
const EDGES: &str = include_str!("edges.wgsl");
const TILES: &str = include_str!("tiles.wgsl");
const GROW: &str = include_str!("grow.wgsl");
const SPLIT: &str = include_str!("split.wgsl");
const GATHER: &str = include_str!("gather.wgsl");
const BOX: &str = include_str!("box.wgsl");
const RESOLVE: &str = include_str!("resolve.wgsl");
const BETWEEN: &str = include_str!("between.wgsl");
const SHADE: &str = include_str!("shade.wgsl");

/// Threads of a group.
const THREADS: usize = 256;

/// Workgroup memory that every adapter has, in single floats.
const WORKGROUP_FLOATS: usize = 4096;

/// An entry point of a module, and its workgroups; more than 65 535 may be spread over y.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterPass {
    /// WGSL.
    pub source: String,
    /// Entry point.
    pub entry: &'static str,
    /// Workgroups.
    pub groups: u32,
}

/// What is filtered, and how.
#[derive(Clone, Copy)]
pub struct FilterShaders<'a> {
    /// The representation.
    pub technique: &'a Technique,
    /// The filter.
    pub filter: &'a PlaneFilter,
    /// Taps of its search for edges.
    pub taps: &'a PoissonTaps,
    /// Texels of the map along columns and rows.
    pub size: [usize; 2],
    /// Number of planes.
    pub planes: usize,
    /// Whether shadows of two planes are interpolated, in place of values.
    pub blend_shadows: bool,
}

impl LensMap {
    /// `rays`: start, distance (1e30 without a surface), and by how much of a turn taps of the ray's texel are rotated.
    pub fn for_shader(&self, seed: u64) -> Vec<[f32; 4]> {
        /// FAR of the shaders.
        const FAR: f32 = 1e30;
        let rays = self.samples().iter().enumerate();
        rays.map(|(place, ray)| [ray.start[0], ray.start[1], ray.distance.min(FAR), turn(seed, place)])
            .collect()
    }
}

/// `plane`: of the plane of that number, where depth 0 is `near` from the light and depth 1 so much farther.
pub fn plane_uniform(map: &LensMap, distance: f64, number: usize, [near, range]: [f64; 2]) -> [f32; 12] {
    let [x, y] = map.lens().aspect();
    let lever = map.lever(distance);
    let circle = map.lens().mean_reach();
    let number = number as f64;
    [lever, 1.0 / map.focus(), 1.0 / distance, circle, x, y, near, range, number, 0.0, 0.0, 0.0]
        .map(|value| value as f32)
}

impl FilterShaders<'_> {
    fn layout(&self) -> Layout {
        Layout::new(self.size, self.filter)
    }

    /// Names of the buffers that passes write, `shadows` of so many fragments among them, and their bytes.
    pub fn buffers(&self, fragments: usize) -> Vec<(&'static str, u64)> {
        let layout = self.layout();
        let (channels, words) = (self.technique.channels(), packed_values::words(self.technique));
        let texels = self.size[0] * self.size[1];
        let finest = layout.levels[0].tiles[0] * layout.levels[0].tiles[1];
        let floats = [
            ("ray_values", texels * words),
            ("links", 2 * texels),
            ("texels", 4 * layout.texels),
            ("values", channels * layout.texels),
            ("distances", texels),
            ("circles", 2 * texels),
            ("marks", finest * self.planes),
            ("tiles", layout.tiles),
            ("sums", 2 * layout.texels * (channels + 1)),
            ("plane_values", texels * words * self.planes),
            ("plane_weights", texels * self.planes),
            ("shadows", fragments),
        ];
        floats.map(|(name, floats)| (name, 4 * floats as u64)).to_vec()
    }

    /// Before all planes: values of the rays, and tiles under so many fragments. `None` for techniques without a shader.
    pub fn before(&self, fragments: usize) -> Option<Vec<FilterPass>> {
        let functions = self.technique.real_time()?.shader()?;
        let [quantise, _] = self.technique.transform_wgsl();
        let store = packed_values::store_wgsl(self.technique, "ray_values")?;
        let encode = self.module("", &[&functions, LENS, &quantise, ENCODE, &store]);
        let tiles = self.module(&count("PLANES", self.planes), &[LENS, BETWEEN, TILES]);
        let texels = self.size[0] * self.size[1];
        let marks = self.planes * self.layout().levels[0].tiles.iter().product::<usize>();
        Some(vec![
            pass(encode, "encode_rays", texels),
            pass(tiles.clone(), "clear_marks", marks),
            pass(tiles, "mark_tiles", fragments),
        ])
    }

    /// Those of a plane. `None` for number formats without a shader.
    pub fn plane(&self) -> Option<Vec<FilterPass>> {
        let (layout, filter) = (self.layout(), self.filter);
        let texels = self.size[0] * self.size[1];
        let channels = count("CHANNELS", self.technique.channels());
        let projected = flag("PROJECTED", filter.centre == SampleCentre::Projected);
        let load = packed_values::load_wgsl(self.technique, "ray_values")?;
        let merge = self.module(&(channels.clone() + &projected), &[LENS, MERGE, &load]);
        let mut passes = vec![
            pass(merge.clone(), "clear_links", texels),
            pass(merge.clone(), "link_rays", texels),
            pass(merge, "merge", texels),
        ];
        let edges = self.edges();
        if filter.edge_taps > 0 {
            passes.push(pass(edges.clone(), "find_edges", texels));
            if filter.edge_smoothing {
                passes.push(pass(edges.clone(), "smooth_rows", texels));
            }
        }
        passes.push(pass(edges, "widen", texels));
        for (place, level) in layout.levels.iter().enumerate() {
            let finer = place.checked_sub(1).map(|finer| &layout.levels[finer]);
            let grow = self.module(&of_tiles(level, finer), &[LENS, GROW]);
            passes.push(pass(grow, "grow", level.tiles[0] * level.tiles[1]));
        }
        for pair in layout.levels.windows(2) {
            let radius = constant("GATHER_RADIUS", filter.gather_radius as f64);
            let constants = channels.clone() + &of_level(&pair[0]) + &of_coarser(&pair[1]) + &radius;
            let split = self.module(&constants, &[SPLIT]);
            passes.push(pass(split, "split", pair[1].size[0] * pair[1].size[1]));
        }
        for (place, level) in layout.levels.iter().enumerate().rev() {
            let coarser = layout.levels.get(place + 1);
            let constants = channels.clone() + &self.of_gathering(place, level, coarser, &layout);
            let tiles = level.tiles[0] * level.tiles[1] * THREADS;
            passes.push(pass(self.module(&constants, &[LENS, GATHER]), "gather", tiles));
            if filter.box_filter {
                let constants = channels.clone() + &of_level(level) + &count("TOTAL", layout.texels);
                let size = level.size[0] * level.size[1];
                passes.push(pass(self.module(&constants, &[BOX]), "smooth_box", size));
            }
        }
        let store = packed_values::store_wgsl(self.technique, "plane_values")?;
        let constants = channels + &count("TOTAL", layout.texels);
        passes.push(pass(self.module(&constants, &[LENS, RESOLVE, &store]), "resolve", texels));
        Some(passes)
    }

    /// After all planes. `None` as before them.
    pub fn shade(&self, fragments: usize) -> Option<FilterPass> {
        let functions = self.technique.real_time()?.shader()?;
        let [_, dequantise] = self.technique.transform_wgsl();
        let load = packed_values::load_wgsl(self.technique, "plane_values")?;
        let constants = count("PLANES", self.planes) + &flag("BLEND_SHADOWS", self.blend_shadows);
        let parts = [&functions, LENS, BETWEEN, &dequantise, SHADE, &load];
        Some(pass(self.module(&constants, &parts), "shade_planes", fragments))
    }

    fn edges(&self) -> String {
        let filter = self.filter;
        let searched = filter.edge_taps > 0;
        let taps: Vec<f64> =
            self.taps.points().iter().flatten().copied().take(2 * filter.edge_taps).collect();
        let constants = count("TAP_COUNT", filter.edge_taps)
            + &array("TAPS", if searched { &taps } else { &[0.0; 2] })
            + &array("GAUSSIAN", &GAUSSIAN)
            + &flag("SMOOTHED", searched && filter.edge_smoothing)
            + &constant("EDGE_REACH", filter.edge_reach)
            + &constant("LEAST_RADIUS", filter.least_radius);
        self.module(&constants, &[ELEMENTARY, LENS, EDGES])
    }

    fn of_gathering(
        &self,
        place: usize,
        level: &LevelPlace,
        coarser: Option<&LevelPlace>,
        layout: &Layout,
    ) -> String {
        let filter = self.filter;
        let span = TILE + 2 * filter.gather_radius;
        // A texel has weight, radius, offset and values.
        let strip = (WORKGROUP_FLOATS / (span * (4 + self.technique.channels()))).clamp(1, 8);
        of_level(level)
            + &of_coarser(coarser.unwrap_or(level))
            + &flag("COARSER", coarser.is_some())
            + &flag("DISC", filter.footprint == Footprint::Disc)
            + &count("TOTAL", layout.texels)
            // Without smoothing sums are put together where they are gathered.
            + &count("GATHERED_FIRST", if filter.box_filter { 0 } else { layout.texels })
            + &count("REACH", filter.gather_radius)
            + &count("STRIDE", if filter.interleaved { 2 } else { 1 })
            + &count("STRIP", strip)
            + &constant("HALF_SIDE", 0.5 * std::f64::consts::PI.sqrt())
            + &constant("SCALE", 1.0 / (1u64 << (2 * place)) as f64)
    }

    fn module(&self, constants: &str, parts: &[&str]) -> String {
        let size = count("WIDTH", self.size[0]) + &count("HEIGHT", self.size[1]);
        unroll(&format!("{size}{constants}\n{}", parts.join("\n")))
    }
}

fn pass(source: String, entry: &'static str, threads: usize) -> FilterPass {
    FilterPass { source, entry, groups: threads.div_ceil(THREADS) as u32 }
}

fn of_level(level: &LevelPlace) -> String {
    count("FIRST", level.first)
        + &count("LEVEL_WIDTH", level.size[0])
        + &count("LEVEL_HEIGHT", level.size[1])
        + &count("TILES_FIRST", level.tiles_first)
}

fn of_coarser(level: &LevelPlace) -> String {
    count("COARSER_FIRST", level.first)
        + &count("COARSER_WIDTH", level.size[0])
        + &count("COARSER_HEIGHT", level.size[1])
}

fn of_tiles(level: &LevelPlace, finer: Option<&LevelPlace>) -> String {
    let below = finer.unwrap_or(level);
    flag("FINEST", finer.is_none())
        + &count("ACROSS", level.tiles[0])
        + &count("DOWN", level.tiles[1])
        + &count("TILES_FIRST", level.tiles_first)
        + &count("FINER_ACROSS", below.tiles[0])
        + &count("FINER_DOWN", below.tiles[1])
        + &count("FINER_TILES_FIRST", below.tiles_first)
}
