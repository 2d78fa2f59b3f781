// Rays on a plane: a list of them for each texel, then their mean, a thread a texel (SSSM15 section 7.4).

@group(0) @binding(0) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> ray_values: array<u32>;
@group(0) @binding(2) var<uniform> plane: FilterPlane;
// The first link of each texel, then the link after each ray; a link is the place of a ray and 1, or 0 at the end.
@group(0) @binding(3) var<storage, read_write> links: array<atomic<u32>>;
// Of all levels, the finest first: weight, radius, offset.
@group(0) @binding(4) var<storage, read_write> texels: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> values: array<f32>;
@group(0) @binding(6) var<storage, read_write> distances: array<f32>;

@compute @workgroup_size(256)
fn clear_links(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let texel = id.y * groups.x * 256u + id.x;
    if texel < COUNT {
        atomicStore(&links[texel], 0u);
    }
}

@compute @workgroup_size(256)
fn link_rays(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= COUNT {
        return;
    }
    let place = centre_of(index) + rays[index].xy * plane.lever;
    if is_inside(place) {
        let before = atomicExchange(&links[texel_of(place)], index + 1u);
        atomicStore(&links[COUNT + index], before);
    }
}

@compute @workgroup_size(256)
fn merge(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let texel = id.y * groups.x * 256u + id.x;
    if texel >= COUNT {
        return;
    }
    let first = atomicLoad(&links[texel]);
    var count = 0u;
    for (var link = first; link != 0u; link = atomicLoad(&links[COUNT + link - 1u])) {
        count = count + 1u;
    }
    let share = 1.0 / f32(max(count, 1u));
    let centre = centre_of(texel);
    var radius = 0.0;
    var distance = 0.0;
    var is_far = false;
    var offset = vec2<f32>(0.0);
    var mean: array<f32, CHANNELS>;
    // Whoever came first stands anywhere in the list; sums in the order of rays are the same every time.
    var last = 0u;
    for (var taken = 0u; taken < count; taken++) {
        var next = 0xffffffffu;
        for (var link = first; link != 0u; link = atomicLoad(&links[COUNT + link - 1u])) {
            next = select(next, link, link > last && link < next);
        }
        last = next;
        let ray = rays[next - 1u];
        is_far = is_far || ray.z >= FAR;
        radius = radius + share * (plane.circle * abs(1.0 / ray.z - plane.per_distance));
        distance = distance + share * min(ray.z, FAR);
        if PROJECTED {
            let at = centre_of(next - 1u) + ray.xy * (1.0 / ray.z - plane.per_focus);
            offset = offset + share * (at - centre);
        }
        let added = load(next - 1u);
        for (var k = 0u; k < CHANNELS; k++) {
            mean[k] = mean[k] + share * added[k];
        }
    }
    texels[texel] = vec4<f32>(f32(count), radius, offset);
    distances[texel] = select(distance, FAR, is_far);
    for (var k = 0u; k < CHANNELS; k++) {
        values[texel * CHANNELS + k] = mean[k];
    }
}
