// Exponential shadow maps; EXPONENT is c.

const CHANNELS: u32 = 1u;

fn encode(depth: f32) -> array<f32, CHANNELS> {
    return array<f32, CHANNELS>(exponential(EXPONENT * unit(depth)));
}

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    return clamp_unit(1.0 - filtered[0] * exponential(-EXPONENT * unit(z_f)));
}
