// LEVELS levels in one pass: a workgroup makes them from 16 x 16 texels.

var<workgroup> level: array<array<f32, CHANNELS>, 64>;

@compute @workgroup_size(8, 8)
fn halve(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let texel = vec2<i32>(8u * group.xy + local.xy);
    var value = halved(texel);
    if all(texel < target_size()) {
        store0(texel, value);
    }
    for (var n = 1u; n < LEVELS; n++) {
        let step = 1u << (n - 1u);
        level[thread] = value;
        workgroupBarrier();
        let counts = all((local.xy & vec2<u32>(2u * step - 1u)) == vec2<u32>(0u));
        if counts {
            for (var k = 0u; k < CHANNELS; k++) {
                let above = level[thread][k] + level[thread + step][k];
                let below = level[thread + 8u * step][k] + level[thread + 9u * step][k];
                value[k] = 0.25 * (above + below);
            }
        }
        workgroupBarrier();
        if counts {
            store_level(n, texel >> vec2<u32>(n), value);
        }
    }
}
