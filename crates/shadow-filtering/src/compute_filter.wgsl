// The same as a compute pass: a workgroup filters ALONG x ACROSS texels from a tile that it has read once.

const TILE: u32 = ALONG + SIZE - 1u;

@compute @workgroup_size(GROUP_X, GROUP_Y)
fn filter_axis(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let last = map_size() - 1;
    let first = vec2<i32>(group.xy * vec2<u32>(GROUP_X, GROUP_Y)) - AXIS * i32(SIZE / 2u);
    for (var i = thread; i < TILE * ACROSS; i = i + ALONG * ACROSS) {
        read_into(i, clamp(first + place_of(i), vec2<i32>(0), last));
    }
    workgroupBarrier();
    let texel = vec2<i32>(group.xy * vec2<u32>(GROUP_X, GROUP_Y) + local.xy);
    if any(texel > last) {
        return;
    }
    store_sum(texel, slot(vec2<i32>(local.xy)));
}
