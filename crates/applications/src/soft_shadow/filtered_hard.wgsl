// Hard shadows filtered over a region of the given full widths in texels.
fn filtered_hard_shadow(widths: vec2<f32>, at: vec2<f32>, z: f32, bias: f32) -> f32 {
    let used = vec2<f32>(larger(widths.x, LEAST_WIDTH), larger(widths.y, LEAST_WIDTH));
    let compared = z - bias_share(used) * bias;
    return biased_bounds(means(at - 0.5 * used, at + 0.5 * used, FILTER_FIT), warped(compared)).x;
}
