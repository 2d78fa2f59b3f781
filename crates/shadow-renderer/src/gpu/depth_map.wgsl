// Nearest depths through the ordinary raster pipeline, and their way into a buffer.

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

struct Rows {
    width: u32,
    first: u32,
    count: u32,
    samples: u32,
}

@group(0) @binding(3) var single: texture_depth_2d;
@group(0) @binding(4) var multiple: texture_depth_multisampled_2d;
@group(0) @binding(5) var<storage, read_write> depths: array<f32>;
@group(0) @binding(6) var<uniform> rows: Rows;

@compute @workgroup_size(8, 8)
fn read_single(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < rows.width && id.y < rows.count {
        depths[id.y * rows.width + id.x] = textureLoad(single, vec2<u32>(id.x, rows.first + id.y), 0);
    }
}

@compute @workgroup_size(8, 8)
fn read_multiple(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < rows.width && id.y < rows.count {
        for (var s = 0u; s < rows.samples; s++) {
            depths[(id.y * rows.width + id.x) * rows.samples + s] =
                textureLoad(multiple, vec2<u32>(id.x, rows.first + id.y), s);
        }
    }
}
