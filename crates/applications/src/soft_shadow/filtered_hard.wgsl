// Hard shadows filtered over a region of the given full widths in texels.
fn filtered_hard_shadow(widths: vec2<f32>, at: vec2<f32>, z: f32, bias: f32) -> f32 {
    let used = vec2<f32>(larger(widths.x, LEAST_WIDTH), larger(widths.y, LEAST_WIDTH));
    let compared = z - bias_share(used) * bias;
    let low = dithered(at - 0.5 * used);
    let high = dithered(at + 0.5 * used);
    return biased_bounds(decoded(means(low, high, FILTER_FIT)), warped(compared)).x;
}
