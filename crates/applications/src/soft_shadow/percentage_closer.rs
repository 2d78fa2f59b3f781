//! Percentage-closer soft shadows (Fernando 2005): blocker search, penumbra estimate, percentage-closer filtering, all
//! by asking every texel.
//!
//! Exact for one planar occluder parallel to the map and a rectangular light: then all blockers of the search region
//! have one depth, and the filter is the light as seen through it.

use moment_problem::arithmetic::Real;
use shadow_filtering::DepthMap;

use super::penumbra::Penumbra;
use super::reconstruction::Blockers;
use super::{BlockerSearch, Filter, Fragment};
use crate::field::Fit;
use crate::region::{Piece, Region};

/// Depths themselves, which can be compared one by one.
pub trait DepthField<R> {
    /// What lies in front of depth `z` within a region.
    fn in_front(&self, region: &Region<R>, fit: Fit, z: R) -> Blockers<R>;
}

impl<R: Real> DepthField<R> for DepthMap {
    fn in_front(&self, region: &Region<R>, fit: Fit, z: R) -> Blockers<R> {
        let size = [self.width(), self.height()];
        let pieces = |k: usize| fit.pieces(region.low[k].to_f64(), region.high[k].to_f64(), size[k]);
        let (columns, rows) = (pieces(0), pieces(1));
        let texels = |piece: &Piece| {
            let covered = R::from_f64(piece.covered);
            (piece.first..=piece.last).map(move |texel| (texel, covered))
        };
        let mut found = Blockers::none();
        let mut area = R::zero();
        for (y, height) in rows.as_slice().iter().flat_map(texels) {
            let line = &self.depths()[y * size[0]..(y + 1) * size[0]];
            for (x, width) in columns.as_slice().iter().flat_map(texels) {
                let weight = width * height;
                area = area + weight;
                let depth = R::from_f64(f64::from(line[x]));
                if depth < z {
                    found = found.with(depth, weight);
                }
            }
        }
        Blockers { mass: (found.mass / area).min(R::one()), depth_sum: found.depth_sum / area }
    }
}

/// What the blocker search finds.
pub fn percentage_closer_blockers<R: Real>(
    field: &impl DepthField<R>,
    penumbra: &Penumbra<R>,
    search: &BlockerSearch<R>,
    fragment: &Fragment<R>,
) -> Blockers<R> {
    let (region, compared) = search.applied(penumbra, fragment);
    field.in_front(&region, search.fit, compared)
}

/// Shadow intensity of a fragment.
pub fn percentage_closer_soft_shadow<R: Real>(
    field: &impl DepthField<R>,
    penumbra: &Penumbra<R>,
    search: &BlockerSearch<R>,
    filter: &Filter<R>,
    fragment: &Fragment<R>,
) -> R {
    let blockers = percentage_closer_blockers(field, penumbra, search, fragment);
    // Without blockers there is nothing to estimate; the fragment is lit.
    let has_blockers = blockers.mass > R::zero();
    if !has_blockers {
        return R::zero();
    }
    if search.is_umbra(&blockers) {
        return R::one();
    }
    let widths = search.widths(penumbra, fragment.depth, &blockers);
    let (region, compared) = filter.applied(fragment, widths);
    field.in_front(&region, filter.fit, compared).mass
}
