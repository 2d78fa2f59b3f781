// The nearest texel of the shadow map for each texel of the rectified map.

@group(0) @binding(0) var depths: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> texels: array<vec4<f32>>;
@group(0) @binding(2) var<uniform> view: Scattering;

@compute @workgroup_size(64)
fn resample(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= COLUMNS * ROWS {
        return;
    }
    let r = (f32(index % COLUMNS) + 0.5) * view.column_width;
    let direction = sine_cosine(view.phi_start + (f32(index / COLUMNS) + 0.5) / view.rows_per_radian);
    let at = floor(view.origin + r * vec2<f32>(direction.y, direction.x) * view.scale);
    let size = vec2<f32>(textureDimensions(depths));
    var depth = 1.0;
    if all(at >= vec2<f32>(0.0)) && all(at < size) {
        let stored = textureLoad(depths, vec2<u32>(at), 0).x;
        if stored < 1.0 {
            depth = clamp_unit(rectified_depth(view, r, view.near + stored * view.range));
        }
    }
    texels[index] = vec4<f32>(depth, depth, 1.0, 0.0);
}
