//! Stochastic maps of a frame, filtered on their planes, and what they make of surfaces.

use super::method::StochasticSetting;
use super::records::PlaneRecord;
use crate::error::EvaluationError;
use crate::lit_frames::{MappedLight, Scenery, Seen, Sight, on_map};
use crate::statistics::rounded;
use applications::rays::PosedTriangles;
use applications::samples::{PoissonTaps, TapShape};
use applications::stochastic::{
    FilteredPlane, Lens, LensMap, PlaneFragment, PlaneSet, between_planes, filter_plane,
};
use rayon::prelude::*;
use scenes::vector::dot;
use scenes::{LightView, Outline, Scene};
use shadow_filtering::{DepthBias, Technique};
use std::borrow::Cow;

/// The stream of the taps of the search for edges.
const EDGE_STREAM: u64 = 0xed6e;

/// Texels of one plane that are read.
const PLANE_LOOKUPS: usize = 4;

/// A technique's place, name and setting.
pub(crate) type Named<'a> = (usize, &'a str, &'a StochasticSetting);

/// A frame of a scene under a light.
pub(crate) struct LitFrame<'a> {
    /// Side of maps of the size 1, and the seed of rays and taps.
    size: u32,
    seed: u64,
    scene: Cow<'a, Scene>,
    posed: PosedTriangles<'a>,
    view: LightView,
    /// With the map of that size.
    pub(crate) light: MappedLight,
    pub(super) seen: Vec<Option<Seen>>,
}

/// A representation among those that were filtered together.
struct Member {
    technique: usize,
    first: usize,
    basis: Technique,
    blend_shadows: bool,
}

/// Techniques that are filtered alike, on their planes.
pub(crate) struct Group {
    members: Vec<Member>,
    light: MappedLight,
    /// Distances of the planes from the light.
    single_distances: Vec<f32>,
    depths: Vec<f64>,
    focus: usize,
    planes: Vec<FilteredPlane<f32>>,
}

/// Maps that were traced already, by side, plane in focus and stream.
pub(crate) type Traced = Vec<((u32, u64, u64), LensMap)>;

impl<'a> LitFrame<'a> {
    pub(crate) fn new(
        (size, seed): (u32, u64),
        scenery: &'a Scenery<'_>,
        frame: usize,
        (view, sight): (LightView, &Sight),
    ) -> Result<Self, EvaluationError> {
        let scene = scenery.scene.at(frame);
        let light = MappedLight::new(&scene, view.clone(), size)?;
        let seen = |pixel: usize| {
            let seen = sight.facing(scenery.scene, pixel, light.placed.middle)?;
            // What lies in the light's plane or behind has no place on maps.
            let distance = light.frame.near + light.frame.project(seen.position)[2] * light.frame.depth_range;
            (distance > 0.0).then_some(seen)
        };
        let seen = (0..sight.depth.len()).into_par_iter().map(seen).collect();
        Ok(Self { size, seed, posed: scenery.posed(frame), scene, view, light, seen })
    }

    /// Filters what techniques need, those that are filtered alike together. `stream` tells the points of the light.
    pub(crate) fn groups(
        &self,
        techniques: &[Named<'_>],
        stream: u64,
        traced: &mut Traced,
    ) -> Result<Vec<Group>, EvaluationError> {
        let mut sets: Vec<Vec<Named<'_>>> = Vec::new();
        for &named in techniques {
            match sets.iter_mut().find(|set| set[0].2.shares(named.2)) {
                Some(set) => set.push(named),
                None => sets.push(vec![named]),
            }
        }
        sets.into_iter().map(|set| self.group(&set, stream, traced)).collect()
    }

    fn group(
        &self,
        techniques: &[Named<'_>],
        stream: u64,
        traced: &mut Traced,
    ) -> Result<Group, EvaluationError> {
        let (seed, setting) = (self.seed, techniques[0].2);
        let size = setting.size(self.size);
        let light = MappedLight::new(&self.scene, self.view.clone(), size)?;
        let depths = self.depths(setting);
        let distance = |depth: f64| light.frame.near + depth * light.frame.depth_range;
        let distances: Vec<f64> = depths.iter().map(|&depth| distance(depth)).collect();
        let focus = depths.len() / 2;
        let key = (size, distances[focus].to_bits(), stream);
        if !traced.iter().any(|(known, _)| *known == key) {
            traced.push((key, self.traced(&light, distances[focus], (seed, stream))));
        }
        let Some((_, map)) = traced.iter().find(|(known, _)| *known == key) else {
            return Err(EvaluationError::Value("a map was lost".to_owned()));
        };
        let mut members = Vec::new();
        let mut channels = 0;
        for &(technique, name, setting) in techniques {
            let basis = setting
                .build()
                .map_err(|error| EvaluationError::Value(format!("technique `{name}`: {error}")))?;
            let first = channels;
            channels += basis.channels();
            members.push(Member { technique, first, basis, blend_shadows: setting.blend_shadows });
        }
        let mut values = vec![0.0f32; map.samples().len() * channels];
        values.par_chunks_mut(channels).zip(map.samples()).for_each(|(values, sample)| {
            let depth = (f64::from(sample.distance) - light.frame.near) / light.frame.depth_range;
            for member in &members {
                let out = &mut values[member.first..member.first + member.basis.channels()];
                member.basis.encode(depth.clamp(0.0, 1.0) as f32, out);
            }
        });
        let filter = setting.filter();
        let taps = PoissonTaps::new(TapShape::Disc, filter.edge_taps, seed, EDGE_STREAM);
        let needed = self.needed(&light, &distances);
        let mut planes: Vec<FilteredPlane<f32>> = distances
            .iter()
            .zip(&needed)
            .map(|(&distance, needed)| {
                filter_plane(map, distance, (&values, channels), &filter, (&taps, seed), Some(needed))
            })
            .collect();
        for plane in &mut planes {
            plane.for_each_texel(|values| {
                for member in &members {
                    let format = member.basis.encoding().format();
                    let stored = &mut values[member.first..member.first + member.basis.channels()];
                    stored.iter_mut().for_each(|value| *value = format.round_single(*value));
                }
            });
        }
        let single_distances = distances.iter().map(|&distance| distance as f32).collect();
        Ok(Group { members, light, single_distances, depths, focus, planes })
    }

    /// Depths of the planes.
    fn depths(&self, setting: &StochasticSetting) -> Vec<f64> {
        let Some(count) = setting.receiver_planes else { return setting.planes.clone() };
        let mut seen: Vec<f64> =
            self.seen.iter().flatten().map(|seen| self.light.frame.project(seen.position)[2]).collect();
        seen.sort_by(f64::total_cmp);
        let at = |share: f64| seen.get((share * (seen.len() - 1) as f64).round() as usize).copied();
        let share = |i: usize| if count == 1 { 0.5 } else { i as f64 / (count - 1) as f64 };
        let mut depths: Vec<f64> =
            if seen.is_empty() { Vec::new() } else { (0..count).filter_map(|i| at(share(i))).collect() };
        depths.dedup();
        // Without receivers any plane will do.
        if depths.is_empty() { vec![0.5] } else { depths }
    }

    /// Texels of each plane around which visible surfaces look.
    fn needed(&self, light: &MappedLight, distances: &[f64]) -> Vec<Vec<bool>> {
        let [width, height] = [light.frame.width as usize, light.frame.height as usize];
        let mut needed = vec![vec![false; width * height]; distances.len()];
        for seen in self.seen.iter().flatten() {
            let [x, y, depth] = light.frame.project(seen.position);
            let distance = light.frame.near + depth * light.frame.depth_range;
            let Some((lower, share)) = between_planes(distances, distance) else { continue };
            let texel = |t: f64, size: usize| (t.max(0.0) as usize).min(size - 1);
            let at = texel(y, height) * width + texel(x, width);
            needed[lower][at] = true;
            if share > 0.0 {
                needed[(lower + 1).min(distances.len() - 1)][at] = true;
            }
        }
        needed
    }

    /// Rays from all over the light.
    pub(super) fn traced(&self, light: &MappedLight, focus: f64, streams: (u64, u64)) -> LensMap {
        let frame = &light.frame;
        let far = frame.near + frame.depth_range;
        let depth = (focus - frame.near) / frame.depth_range;
        LensMap::trace(lens(light), focus, streams, |[x, y], point| {
            let offset = light.placed.towards(light.placed.middle, point);
            let start = [0, 1, 2].map(|k| light.placed.middle[k] + offset[k]);
            let through = frame.unproject([x, y, depth]);
            let direction = [0, 1, 2].map(|k| (through[k] - start[k]) * (far / focus));
            let first = self.posed.first(start, direction).map(|(at, _)| at * far);
            ([dot(offset, frame.right), dot(offset, frame.down)], first.filter(|&distance| distance > 0.0))
        })
    }
}

/// The light as the filter has it: a disc stands for a rectangle of equal area.
pub(super) fn lens(light: &MappedLight) -> Lens {
    let factor = match light.placed.outline {
        Outline::Rectangle => 2.0 / std::f64::consts::PI.sqrt(),
        Outline::Disc => 1.0,
    };
    let frame = &light.frame;
    Lens {
        size: [frame.width as usize, frame.height as usize],
        texels: frame.texels_per_unit.map(|texels| texels * frame.near),
        half_size: light.penumbra.half_size.map(|half| factor * half),
    }
}

impl Group {
    /// Techniques of the group, by their place among its members.
    pub(crate) fn techniques(&self) -> impl Iterator<Item = (usize, usize)> {
        self.members.iter().enumerate().map(|(place, member)| (place, member.technique))
    }

    /// Bits of a texel of a plane, and memory of all planes in MiB.
    pub(super) fn memory(&self, member: usize) -> (usize, f64) {
        let bits = self.members[member].basis.bits_per_texel();
        let texels = f64::from(self.light.frame.width) * f64::from(self.light.frame.height);
        (bits, bits as f64 / 8.0 * texels * self.planes.len() as f64 / f64::from(1 << 20))
    }

    pub(super) fn planes(&self) -> usize {
        self.planes.len()
    }

    /// Texels that are read for a surface.
    pub(crate) fn lookups(&self) -> usize {
        PLANE_LOOKUPS * self.planes().min(2)
    }

    pub(super) fn size(&self) -> u32 {
        self.light.frame.width
    }

    /// Rows of planes.csv.
    pub(super) fn plane_records(&self, [scene, view, light, technique]: [&str; 4]) -> Vec<PlaneRecord> {
        let rows = self.planes.iter().zip(&self.depths).enumerate();
        rows.map(|(i, (plane, &depth))| PlaneRecord {
            scene: scene.to_owned(),
            view: view.to_owned(),
            light: light.to_owned(),
            technique: technique.to_owned(),
            depth: rounded(depth),
            in_focus: i == self.focus,
            active_tiles: rounded(plane.active_tiles),
            cut_off: rounded(plane.cut_off),
            merged: rounded(plane.merged),
        })
        .collect()
    }

    /// The shadow of a surface by a member; nothing where no sample reaches it.
    pub(crate) fn shadow(
        &self,
        member: usize,
        bias: (&DepthBias, f64),
        seen: &Seen,
    ) -> Result<Option<f64>, String> {
        let light = &self.light;
        let Some(placed) = on_map(&light.frame, light.texel_depth, bias, (seen.position, seen.normal)) else {
            return Ok(None);
        };
        let distance = light.frame.near + placed.depth * light.frame.depth_range;
        let Member { first, basis, blend_shadows, .. } = &self.members[member];
        let set = PlaneSet {
            distances: &self.single_distances,
            planes: &self.planes,
            technique: basis,
            channels: *first..first + basis.channels(),
            blend_shadows: *blend_shadows,
        };
        let fragment = PlaneFragment {
            position: placed.fragment.position.map(|t| t as f32),
            distance: distance as f32,
            compared: (placed.depth - placed.fragment.bias) as f32,
        };
        let shadow = set.shadow(&fragment).map_err(|error| error.to_string())?;
        Ok(shadow.map(f64::from))
    }
}
