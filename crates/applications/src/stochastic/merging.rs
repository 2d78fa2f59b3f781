//! Rays on a plane, texel by texel.

use rayon::prelude::*;
use shadow_filtering::Precision;

use super::lens_map::LensMap;
use super::level::{Level, add};
use super::plane::{PlaneFilter, SampleCentre};

/// Rays where they meet the plane: those of one texel are merged (section 7.4). Also the distances of what they hit, and how
/// many were merged on average.
pub(super) fn reproject<R: Precision>(
    map: &LensMap,
    plane: f64,
    (values, channels): (&[R], usize),
    filter: &PlaneFilter,
) -> (Level<R>, Vec<R>, f64) {
    let [width, height] = map.lens().size;
    let count = width * height;
    // The plane's own lever is a constant.
    let lever = R::from_f64(map.lever(plane));
    let texel = |index: usize| {
        let [x, y] = map.position(index, lever).map(R::to_f64);
        let inside = x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64;
        inside.then(|| y as usize * width + x as usize)
    };
    let places: Vec<Option<usize>> = (0..count).into_par_iter().map(texel).collect();
    let mut ends = vec![0u32; count + 1];
    places.iter().flatten().for_each(|&place| ends[place + 1] += 1);
    for i in 0..count {
        ends[i + 1] += ends[i];
    }
    let mut next = ends.clone();
    let mut members = vec![0u32; ends[count] as usize];
    for (index, place) in places.iter().enumerate() {
        if let Some(place) = *place {
            members[next[place] as usize] = index as u32;
            next[place] += 1;
        }
    }
    let mut level = Level::empty([width, height], channels);
    let mut distances = vec![R::zero(); count];
    let rows = level.values.par_chunks_mut(channels).zip(&mut level.weight).zip(&mut level.radius);
    let rows = rows.zip(&mut level.offset).zip(&mut distances).enumerate();
    rows.for_each(|(place, ((((out, weight), radius), offset), distance))| {
        let list = &members[ends[place] as usize..ends[place + 1] as usize];
        if list.is_empty() {
            return;
        }
        let share = R::from_f64(1.0 / list.len() as f64);
        let centre = [place % width, place / width].map(|t| R::from_f64(t as f64 + 0.5));
        for &index in list {
            let index = index as usize;
            let seen = R::from_f64(f64::from(map.samples()[index].distance));
            *radius = *radius + share * map.lens().circle(plane, seen);
            *distance = *distance + share * seen;
            if filter.centre == SampleCentre::Projected {
                let at = map.projected::<R>(index);
                (0..2).for_each(|k| offset[k] = offset[k] + share * (at[k] - centre[k]));
            }
            add(out, share, &values[index * channels..(index + 1) * channels]);
        }
        *weight = R::from_f64(list.len() as f64);
    });
    let used = ends.windows(2).filter(|pair| pair[1] > pair[0]).count().max(1);
    (level, distances, members.len() as f64 / used as f64)
}
