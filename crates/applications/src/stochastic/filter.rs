//! The filter of a stochastic shadow map on a plane (SSSM15 section 4): every sample reaches as far as the light is wide when
//! seen through it.

use moment_problem::arithmetic::Real;

use super::circle_of_confusion;

/// The plane parallel to the light for which samples are filtered, and the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterPlane {
    /// m: texels per world unit on the plane at unit distance scaled to this one.
    pub texels_per_unit: f64,
    /// R_L.
    pub light_radius: f64,
    /// Distance of the plane from the light.
    pub depth: f64,
    /// Least radius in texels: in focus 1 / rho^2 has no limit, and a radius below half a texel reaches none.
    pub least_radius: f64,
}

/// A light ray: where it starts on the light, its offset at unit distance, and the depth of the first surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRay {
    /// u.
    pub origin: [f64; 2],
    /// o.
    pub offset: [f64; 2],
    /// d.
    pub depth: f64,
}

/// A sample on a filter plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSample {
    /// Where the light's middle sees it on the plane, in texels: m (u + o d) d_r / d.
    pub position: [f64; 2],
    /// Depth.
    pub depth: f64,
    /// Its own circle of confusion c.
    pub circle: f64,
    /// rho = max(c, c_l, least radius).
    pub radius: f64,
}

impl FilterPlane {
    /// Samples of rays, each with the least circle c_l of the nearer samples whose circle holds its position: what lies behind
    /// an occluder's edge is blurred as the edge is.
    pub fn samples(&self, rays: &[LightRay]) -> Vec<PlaneSample> {
        let place = |ray: &LightRay| {
            let scale = self.texels_per_unit * self.depth / ray.depth;
            let position = [0, 1].map(|k| scale * (ray.origin[k] + ray.offset[k] * ray.depth));
            let circle = circle_of_confusion(self.texels_per_unit, self.light_radius, self.depth, ray.depth);
            PlaneSample { position, depth: ray.depth, circle, radius: circle }
        };
        let placed: Vec<PlaneSample> = rays.iter().map(place).collect();
        let widened = |sample: &PlaneSample| {
            let nearer = placed.iter().filter(|other| {
                other.depth < sample.depth && distance(other.position, sample.position) < other.circle
            });
            let edge = nearer.map(|other| other.circle).fold(f64::INFINITY, f64::min);
            let edge = if edge.is_finite() { edge } else { 0.0 };
            PlaneSample { radius: sample.circle.max(edge).max(self.least_radius), ..*sample }
        };
        placed.iter().map(widened).collect()
    }
}

/// Means of functions of depth at a point of the plane over the samples that reach it, weighted by 1 / rho^2 (equation 7);
/// `None` where none does.
pub fn filtered<const M: usize>(
    samples: &[PlaneSample],
    at: [f64; 2],
    functions: impl Fn(f64) -> [f64; M],
) -> Option<[f64; M]> {
    let (mut sums, mut total) = ([0.0; M], 0.0);
    for sample in samples.iter().filter(|sample| distance(sample.position, at) < sample.radius) {
        let weight = 1.0 / (sample.radius * sample.radius);
        total += weight;
        let values = functions(sample.depth);
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
    (total > 0.0).then(|| sums.map(|sum| sum / total))
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Where a depth lies between filter planes, ascending: the plane before it and the share of the next; depths outside
/// belong to the first or last plane alone. `None` without planes.
pub fn between_planes<R: Real>(planes: &[R], depth: R) -> Option<(usize, R)> {
    let last = planes.len().checked_sub(1)?;
    let after = planes.iter().position(|&plane| plane > depth);
    Some(match after {
        Some(0) => (0, R::zero()),
        Some(next) => (next - 1, (depth - planes[next - 1]) / (planes[next] - planes[next - 1])),
        None => (last, R::zero()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_behind_an_edge_are_blurred_as_it_is() {
        let plane = FilterPlane { texels_per_unit: 10.0, light_radius: 0.5, depth: 4.0, least_radius: 0.5 };
        let ray = |depth| LightRay { origin: [0.0; 2], offset: [0.0; 2], depth };
        let samples = plane.samples(&[ray(2.0), ray(4.0)]);
        assert_eq!([samples[0].radius, samples[1].circle, samples[1].radius], [5.0, 0.0, 5.0]);
        let alone = plane.samples(&[ray(4.0)]);
        assert_eq!(alone[0].radius, 0.5);
        let lit = |depth: f64| [f64::from(u8::from(depth >= 3.0))];
        assert_eq!(filtered(&samples, [3.0, 0.0], lit), Some([0.5]));
        assert_eq!(filtered(&samples, [6.0, 0.0], lit), None);
        assert_eq!(between_planes(&[1.0, 3.0], 2.5), Some((0, 0.75)));
        assert_eq!(
            [0.5, 3.0, 9.0].map(|d| between_planes(&[1.0, 3.0], d)),
            [Some((0, 0.0)), Some((1, 0.0)), Some((1, 0.0))]
        );
        assert_eq!(between_planes::<f64>(&[], 1.0), None);
    }
}
