// What a processor can do at most: bytes moved by a copy, products added in registers.

@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> target_: array<vec4<u32>>;

@compute @workgroup_size(256)
fn copy_all(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index < arrayLength(&source) {
        target_[index] = source[index];
    }
}

// Four chains of ROUNDS dependent steps a thread.
@compute @workgroup_size(256)
fn multiply_add(@builtin(global_invocation_id) id: vec3<u32>) {
    var sum = vec4<f32>(f32(id.x), 1.0, 2.0, 3.0);
    let factor = bitcast<vec4<f32>>(source[0]);
    // Eight at a time, so that counting costs little.
    for (var i = 0u; i < ROUNDS; i = i + 8u) {
        sum = fma(fma(fma(fma(sum, factor, factor), factor, factor), factor, factor), factor, factor);
        sum = fma(fma(fma(fma(sum, factor, factor), factor, factor), factor, factor), factor, factor);
    }
    target_[id.x & 255u] = bitcast<vec4<u32>>(sum);
}
