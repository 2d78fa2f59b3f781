// A thread a fragment: position on the map in texels, depth and bias.

@group(0) @binding(1) var<storage, read> fragments: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> shadows: array<f32>;
@group(0) @binding(3) var<uniform> penumbra: Penumbra;

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&fragments) {
        return;
    }
    let fragment = fragments[index];
    noise = noise_of(index);
    shadows[index] = soft_shadow(penumbra, fragment.xy, fragment.z, fragment.w);
}
