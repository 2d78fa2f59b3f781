// Nearest depths through the ordinary raster pipeline.

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) @interpolate(flat) mask_index: u32,
}

// Shift of all corners in normalised device coordinates: minus the sample's offset from the texel's centre.
@group(0) @binding(0) var<uniform> shift: vec4<f32>;

@vertex
fn corner(@location(0) position: vec3<f32>, @location(1) uv: vec2<f32>, @location(2) mask_index: u32) -> Corner {
    return Corner(vec4<f32>(position.xy + shift.xy, position.z, 1.0), uv, mask_index);
}

@fragment
fn alpha_test(corner: Corner) {
    if is_masked_out(corner.mask_index, corner.uv) {
        discard;
    }
}
