// A second map, right for other inclinations: rays between both mix them.

@group(0) @binding(4) var<storage, read> inverse_sines: array<f32>;

fn inverse_sine_of(map: u32, place: Place) -> f32 {
    let first = inverse_sines[map * ROWS + place.rows.x];
    let second = inverse_sines[map * ROWS + place.rows.y];
    return (1.0 - place.down) * first + place.down * second;
}

fn between_spacings(dark: f32, place: Place, sine: f32, depth: f32, cosine: f32) -> f32 {
    let near = inverse_sine_of(0u, place);
    let far = inverse_sine_of(1u, place);
    if near == far {
        return dark;
    }
    let share = clamp_unit((1.0 / sine - near) / (far - near));
    return dark + share * (shadowed(dequantise(mean_at(1u, place)), depth, cosine) - dark);
}
