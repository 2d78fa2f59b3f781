//! How far a sample reaches, and which level of the filter takes it.

use moment_problem::arithmetic::Real;

/// c = m R_L |d_r - d_k| / d_k (SSSM15 equation 6): radius on the receiver plane of the light as seen through a sample
/// at depth `sample`. `texels_per_unit` is m, `light_radius` R_L; depths are distances from the light, above 0.
pub fn circle_of_confusion<R: Real>(texels_per_unit: R, light_radius: R, receiver: R, sample: R) -> R {
    texels_per_unit * light_radius * (receiver - sample).abs() / sample
}

/// w (SSSM15 equation 8): share of a sample of filter radius `radius` that goes to the coarser of two levels, rising
/// from 0.4 to 0.5 times the gather radius R_G; all in texels of the finer level. The finer keeps the rest.
pub fn coarser_weight<R: Real>(gather_radius: R, radius: R) -> R {
    let (end, length) = (R::from_f64(0.5) * gather_radius, R::from_f64(0.1) * gather_radius);
    (R::one() - (end - radius) / length).clamp_unit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_in_focus_are_points_and_levels_take_over_gradually() {
        assert_eq!(circle_of_confusion(10.0, 0.5, 4.0, 4.0), 0.0);
        assert_eq!(circle_of_confusion(10.0, 0.5, 4.0, 2.0), 5.0);
        assert_eq!([3.0, 3.5, 4.0, 9.0].map(|radius| coarser_weight(8.0f32, radius)), [0.0, 0.375, 1.0, 1.0]);
    }
}
