// Alpha masks of the raster pipelines.

struct Mask {
    width: u32,
    height: u32,
    first_bit: u32,
}

const NO_MASK: u32 = 0xffffffffu;

@group(0) @binding(1) var<storage, read> masks: array<Mask>;
@group(0) @binding(2) var<storage, read> mask_bits: array<u32>;

// Whether the nearest texel of the mask has no surface; textures repeat.
fn is_masked_out(index: u32, uv: vec2<f32>) -> bool {
    if index == NO_MASK {
        return false;
    }
    let mask = masks[index];
    let size = vec2<u32>(mask.width, mask.height);
    let texel = min(vec2<u32>(fract(uv) * vec2<f32>(size)), size - 1u);
    let bit = mask.first_bit + texel.y * mask.width + texel.x;
    return ((mask_bits[bit / 32u] >> (bit % 32u)) & 1u) == 0u;
}

