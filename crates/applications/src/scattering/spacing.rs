//! How far apart the samples of a row are taken to be: they lie Delta r / sin(theta) apart on a view ray, and a row is shared by
//! rays of many inclinations theta (BHS16 section 2.2). A wrong spacing is a wrong extinction.

use serde::{Deserialize, Serialize};

use super::{Frustum, Rectified, RectifiedMap, SingleScattering, ViewRay};

/// Which inclination a row's spacing is right for.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Spacing {
    /// The mean of the bounds of theta over the whole frustum, as published.
    Mean,
    /// The mean of the bounds over the frustum at the row's azimuth.
    Row,
    /// The mean sine of inclinations between these bounds, by solid angle.
    #[default]
    Solid,
    /// The mean sine of the view rays that the row is for.
    Rays,
    /// Two maps, for the inclinations a quarter from either bound of the row; rays between them mix both.
    Two,
    /// Each ray's own, for exact distributions only: no error of spacing is left.
    Own,
}

/// Sines below this belong to rays along the light, whose samples all lie in the first column.
const LEAST_SINE: f64 = 1e-3;

/// int sin^2 / int sin over an interval of inclinations.
fn mean_sine([low, high]: [f64; 2]) -> f64 {
    let solid = low.cos() - high.cos();
    let squares = 0.5 * (high - low) - 0.25 * ((2.0 * high).sin() - (2.0 * low).sin());
    if solid > LEAST_SINE * LEAST_SINE { squares / solid } else { (0.5 * (low + high)).sin() }
}

impl Spacing {
    /// 1 / sin(theta) of each row, for each map that is kept; no map for [`Spacing::Own`].
    pub fn inverse_sines(
        self,
        rectified: &RectifiedMap,
        frustum: &Frustum,
        view: &SingleScattering<'_>,
        rays: &[ViewRay],
    ) -> Vec<Vec<f64>> {
        let rectification = &rectified.rectification;
        let rows = rectification.size[1];
        let inverse = |sine: f64| 1.0 / sine.max(LEAST_SINE);
        let bounds = |row: usize| {
            let seen = frustum.inclinations(&rectification.axes, rectification.azimuth(row));
            seen.unwrap_or(rectification.flipped)
        };
        let at = |share: f64| -> Vec<f64> {
            (0..rows).map(bounds).map(|[low, high]| inverse((low + share * (high - low)).sin())).collect()
        };
        match self {
            Self::Mean => {
                let [low, high] = rectification.flipped;
                vec![vec![inverse((0.5 * (low + high)).sin()); rows]]
            }
            Self::Row => vec![at(0.5)],
            Self::Solid => vec![(0..rows).map(|row| inverse(mean_sine(bounds(row)))).collect()],
            Self::Two => vec![at(0.25), at(0.75)],
            Self::Own => Vec::new(),
            Self::Rays => {
                let mut sums = vec![(0.0, 0usize); rows];
                for ray in rays {
                    let at = Rectified::of(view.axes.direction(ray.direction));
                    let (sum, count) = &mut sums[rectification.row(at.phi)];
                    *sum += at.r;
                    *count += 1;
                }
                let mean = |(row, &(sum, count)): (usize, &(f64, usize))| {
                    let [low, high] = bounds(row);
                    inverse(if count > 0 { sum / count as f64 } else { mean_sine([low, high]) })
                };
                vec![sums.iter().enumerate().map(mean).collect()]
            }
        }
    }
}
