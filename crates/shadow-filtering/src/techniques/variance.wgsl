// Variance shadow maps.

const CHANNELS: u32 = 2u;

fn encode(depth: f32) -> array<f32, CHANNELS> {
    let z = unit(depth);
    return array<f32, CHANNELS>(z, z * z);
}

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    return cantelli(filtered[0], filtered[1], unit(z_f));
}
