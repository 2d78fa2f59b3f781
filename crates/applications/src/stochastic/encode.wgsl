// Filterable values of the surface of each ray, a thread a ray.

// Where the ray starts times texels and distance, distance of the surface, and what the taps of its texel are turned by.
@group(0) @binding(0) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> ray_values: array<u32>;
@group(0) @binding(2) var<uniform> plane: FilterPlane;

@compute @workgroup_size(256)
fn encode_rays(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= COUNT {
        return;
    }
    store(index, quantise(encode(unit((rays[index].z - plane.near) / plane.range))));
}
