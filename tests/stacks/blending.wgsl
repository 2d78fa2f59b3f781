// Layers of texels, blended by the device: one instance a layer, the farthest first.

struct Layer {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
}

// Two targets of two channels each: the alpha that is blended with must be none of the values (BHS16 section 4.2).
struct Targets {
    @location(0) first: vec4<f32>,
    @location(1) second: vec4<f32>,
}

@group(0) @binding(0) var<storage, read> values: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> opacities: array<f32>;

const SIDE: u32 = 64u;

@vertex
fn everywhere(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> Layer {
    let at = vec2<f32>(f32(corner & 1u), f32(corner >> 1u)) * 4.0 - 1.0;
    return Layer(vec4<f32>(at, 0.5, 1.0), number);
}

@fragment
fn blend(layer: Layer) -> Targets {
    let texel = vec2<u32>(layer.position.xy);
    let index = layer.number * SIDE * SIDE + texel.y * SIDE + texel.x;
    let value = values[index];
    let alpha = opacities[index];
    return Targets(vec4<f32>(value.xy, 0.0, alpha), vec4<f32>(value.zw, 0.0, alpha));
}
