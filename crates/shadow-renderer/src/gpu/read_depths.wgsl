// From a depth target to a buffer, some rows at a time.

struct Rows {
    width: u32,
    first: u32,
    count: u32,
    samples: u32,
}

@group(0) @binding(0) var single: texture_depth_2d;
@group(0) @binding(1) var multiple: texture_depth_multisampled_2d;
@group(0) @binding(2) var<storage, read_write> depths: array<f32>;
@group(0) @binding(3) var<uniform> rows: Rows;

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
