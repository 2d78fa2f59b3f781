//! How many moments the kernels of a scene need: as many surfaces as the moment matrix has rank (MSM15 Proposition 4),
//! and as many as leave no room between the sharp bounds.

use super::records::OrderRecord;
use super::scenery::{SceneView, SpeedPlan};
use crate::statistics::rounded;
use applications::Application;
use moment_problem::MomentBound;
use nalgebra::{Matrix5, SymmetricEigen};
use rayon::prelude::*;
use shadow_filtering::{DepthMap, Kernel};

/// Orders whose bounds are compared, ascending.
pub(crate) const ORDERS: [MomentBound; 4] =
    [MomentBound::Hamburger2, MomentBound::Hamburger4, MomentBound::Hamburger6, MomentBound::Hamburger8];

/// Largest rank of the moment matrix of eight moments.
pub(crate) const LARGEST_RANK: usize = 5;

/// What one kernel needs.
struct Need {
    /// 1 to 5.
    rank: usize,
    /// Upper minus lower bound at the biased depth by order.
    gaps: [f64; 4],
    /// F minus the lower bound there.
    losses: [f64; 4],
}

/// Powers 0 to 8 of 2 z - 1, averaged over a kernel.
fn moments(map: &DepthMap, kernel: &Kernel, (x, y): (usize, usize)) -> [f64; 9] {
    let mut moments = [0.0; 9];
    for (i, j, weight) in kernel.taps() {
        let s = 2.0 * f64::from(map.at(x as isize + i, y as isize + j)) - 1.0;
        let mut power = weight;
        for moment in &mut moments {
            *moment += power;
            power *= s;
        }
    }
    moments
}

/// The number of eigenvalues of the moment matrix above a share of the largest.
fn rank(moments: &[f64; 9], tolerance: f64) -> usize {
    let eigenvalues = SymmetricEigen::new(Matrix5::from_fn(|i, j| moments[i + j])).eigenvalues;
    let largest = eigenvalues.max();
    eigenvalues.iter().filter(|&&value| value > tolerance * largest).count().max(1)
}

/// What the kernels of fragments need, evenly spread over a view; one row.
pub(crate) fn needed(plan: &SpeedPlan<'_>, view: &SceneView, number: usize) -> OrderRecord {
    let settings = &plan.experiment.orders;
    let fragments = view.sample(settings.fragments, plan.experiment.scenery.seed, number);
    let one = |&fragment: &u32| {
        let receiver = &view.receivers[fragment as usize];
        let moments = moments(&view.map, &plan.kernel, (receiver.x, receiver.y));
        // The last bias is the largest: at the receiver's own depth its own surface would be the gap.
        let bias = plan.experiment.biases.last().copied().unwrap_or_default();
        let application = plan.hard_shadow(&view.map, view.texel_depth, bias);
        let z = application.compared(receiver);
        let pairs = ORDERS.map(|bound| bound.bounds(&moments[1..], 2.0 * z - 1.0));
        let truth = application.truth(receiver);
        Need {
            rank: rank(&moments, settings.rank_tolerance),
            gaps: pairs.map(|pair| pair.upper - pair.lower),
            losses: pairs.map(|pair| truth - pair.lower),
        }
    };
    let needs: Vec<Need> = fragments.par_iter().map(one).collect();
    let count = needs.len().max(1) as f64;
    let share = |wanted: &dyn Fn(&Need) -> bool| {
        rounded(needs.iter().filter(|need| wanted(need)).count() as f64 / count)
    };
    let ranks = (1..=LARGEST_RANK).map(|rank| share(&|need| need.rank == rank)).collect();
    let by_order = |distances: &dyn Fn(&Need) -> [f64; 4]| {
        let shares = settings.gap_tolerances.iter().map(|&tolerance| {
            let order = |need: &Need| {
                distances(need).iter().position(|&distance| distance < tolerance).unwrap_or(ORDERS.len())
            };
            (0..=ORDERS.len()).map(|wanted| share(&|need| order(need) == wanted)).collect()
        });
        shares.collect()
    };
    OrderRecord {
        scene: view.scene.clone(),
        view: view.view.clone(),
        fragments: needs.len(),
        ranks,
        by_gap: by_order(&|need| need.gaps),
        by_loss: by_order(&|need| need.losses),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rank_is_the_number_of_surfaces() {
        let depths = [0.1f32, 0.35, 0.6, 0.8, 0.97];
        for surfaces in 1..=5 {
            let map: Vec<f32> = (0..81).map(|t| depths[t % surfaces]).collect();
            let map = DepthMap::new(9, 9, map).unwrap();
            let moments = moments(&map, &Kernel::uniform(9).unwrap(), (4, 4));
            assert!((moments[0] - 1.0).abs() < 1e-12);
            assert_eq!(rank(&moments, 1e-6), surfaces);
        }
    }
}
