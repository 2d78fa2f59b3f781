// Sums of the finest level, with all others in them, to stored means: a thread a texel.

@group(0) @binding(0) var<storage, read> sums: array<f32>;
@group(0) @binding(1) var<storage, read_write> plane_values: array<u32>;
// 0 where no sample reaches.
@group(0) @binding(2) var<storage, read_write> plane_weights: array<f32>;
@group(0) @binding(3) var<uniform> plane: FilterPlane;

@compute @workgroup_size(256)
fn resolve(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= COUNT {
        return;
    }
    let origin = (TOTAL + index) * (CHANNELS + 1u);
    let weight = sums[origin];
    var mean: array<f32, CHANNELS>;
    if weight > 0.0 {
        for (var k = 0u; k < CHANNELS; k++) {
            mean[k] = sums[origin + 1u + k] / weight;
        }
    }
    let to = u32(plane.number) * COUNT + index;
    plane_weights[to] = weight;
    store(to, mean);
}
