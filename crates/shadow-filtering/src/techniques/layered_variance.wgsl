// Layered variance shadow maps with LAYERS layers of equal size.

const CHANNELS: u32 = 2u * LAYERS;

fn warp(layer: u32, z: f32) -> f32 {
    return unit(z * f32(LAYERS) - f32(layer));
}

fn encode(depth: f32) -> array<f32, CHANNELS> {
    let z = unit(depth);
    var stored: array<f32, CHANNELS>;
    for (var layer = 0u; layer < LAYERS; layer++) {
        let warped = warp(layer, z);
        stored[2u * layer] = warped;
        stored[2u * layer + 1u] = warped * warped;
    }
    return stored;
}

fn shade(filtered: array<f32, CHANNELS>, z_f: f32) -> f32 {
    var stored = filtered;
    let z = unit(z_f);
    let layer = min(u32(z * f32(LAYERS)), LAYERS - 1u);
    return cantelli(stored[2u * layer], stored[2u * layer + 1u], warp(layer, z));
}
