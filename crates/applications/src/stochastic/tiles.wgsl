// Which tiles of 16x16 texels of a plane somebody will read: those under fragments, then on each level with the ring around.

// Position on the map in texels, depth, and depth that is compared.
@group(0) @binding(0) var<storage, read> fragments: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> plane_distances: array<f32>;
@group(0) @binding(2) var<uniform> plane: FilterPlane;
// One for each tile of each plane.
@group(0) @binding(3) var<storage, read_write> marks: array<atomic<u32>>;

const TILE: u32 = 16u;
const ACROSS: u32 = (WIDTH + TILE - 1u) / TILE;
const TILE_COUNT: u32 = ACROSS * ((HEIGHT + TILE - 1u) / TILE);

@compute @workgroup_size(256)
fn clear_marks(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index < PLANES * TILE_COUNT {
        atomicStore(&marks[index], 0u);
    }
}

@compute @workgroup_size(256)
fn mark_tiles(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= arrayLength(&fragments) {
        return;
    }
    let fragment = fragments[index];
    let between = between_planes(plane.near + fragment.z * plane.range);
    let texel = vec2<u32>(clamp(fragment.xy, vec2<f32>(0.0), vec2<f32>(f32(WIDTH), f32(HEIGHT)) - 1.0));
    let tile = texel.y / TILE * ACROSS + texel.x / TILE;
    atomicStore(&marks[between.lower * TILE_COUNT + tile], 1u);
    if between.share > 0.0 {
        atomicStore(&marks[(between.lower + 1u) * TILE_COUNT + tile], 1u);
    }
}
