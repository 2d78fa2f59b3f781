// Textures of colour, filtered between the four nearest texels and the two nearest levels as on the CPU.

struct Texture {
    width: u32,
    height: u32,
    levels: u32,
    // Of the finest level's texels; coarser ones follow.
    first: u32,
    wrap_u: u32,
    wrap_v: u32,
}

const NO_TEXTURE: u32 = 0xffffffffu;
const REPEAT: u32 = 0u;
const CLAMP: u32 = 1u;

@group(0) @binding(3) var<storage, read> textures: array<Texture>;
// sRGB in the lowest three bytes.
@group(0) @binding(4) var<storage, read> texels: array<u32>;

fn linear_from_srgb(texel: u32) -> vec3<f32> {
    let s = unpack4x8unorm(texel).xyz;
    return select(pow((s + 0.055) / 1.055, vec3<f32>(2.4)), s / 12.92, s <= vec3<f32>(0.04045));
}

fn place(i: f32, size: u32, wrap: u32) -> u32 {
    let side = f32(size);
    if wrap == REPEAT {
        return min(u32(i - side * floor(i / side)), size - 1u);
    }
    return u32(clamp(i, 0.0, side - 1.0));
}

fn within(coordinate: f32, wrap: u32) -> f32 {
    if wrap == REPEAT {
        return fract(coordinate);
    }
    if wrap == CLAMP {
        return clamp(coordinate, 0.0, 1.0);
    }
    let t = 2.0 * fract(0.5 * coordinate);
    return select(t, 2.0 - t, t > 1.0);
}

fn bilinear(first: u32, size: vec2<u32>, wrap: vec2<u32>, uv: vec2<f32>) -> vec3<f32> {
    let at = vec2<f32>(within(uv.x, wrap.x), within(uv.y, wrap.y)) * vec2<f32>(size) - 0.5;
    let low = floor(at);
    let share = at - low;
    let x0 = place(low.x, size.x, wrap.x);
    let x1 = place(low.x + 1.0, size.x, wrap.x);
    let y0 = first + size.x * place(low.y, size.y, wrap.y);
    let y1 = first + size.x * place(low.y + 1.0, size.y, wrap.y);
    let upper = mix(linear_from_srgb(texels[y0 + x0]), linear_from_srgb(texels[y0 + x1]), share.x);
    let lower = mix(linear_from_srgb(texels[y1 + x0]), linear_from_srgb(texels[y1 + x1]), share.x);
    return mix(upper, lower, share.y);
}

// Linear RGB; `across` and `down` are the changes of uv to the next pixels.
fn colour(index: u32, uv: vec2<f32>, across: vec2<f32>, down: vec2<f32>) -> vec3<f32> {
    if index == NO_TEXTURE {
        return vec3<f32>(1.0);
    }
    let texture = textures[index];
    let wrap = vec2<u32>(texture.wrap_u, texture.wrap_v);
    var size = vec2<u32>(texture.width, texture.height);
    let footprint = max(length(across * vec2<f32>(size)), length(down * vec2<f32>(size)));
    let level = clamp(log2(max(footprint, 1e-9)), 0.0, f32(texture.levels - 1u));
    var first = texture.first;
    for (var i = 0u; i < u32(level); i++) {
        first += size.x * size.y;
        size = max(size / 2u, vec2<u32>(1u));
    }
    let fine = bilinear(first, size, wrap, uv);
    let share = fract(level);
    if share == 0.0 {
        return fine;
    }
    first += size.x * size.y;
    size = max(size / 2u, vec2<u32>(1u));
    return mix(fine, bilinear(first, size, wrap, uv), share);
}

