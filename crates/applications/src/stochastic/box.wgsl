// Means of gathered sums over 3x3 texels, a thread a texel.

@group(0) @binding(0) var<storage, read_write> sums: array<f32>;
@group(0) @binding(1) var<storage, read> tiles: array<u32>;

const TILE: u32 = 16u;
const ACROSS: u32 = (LEVEL_WIDTH + TILE - 1u) / TILE;
const SUMMED: u32 = CHANNELS + 1u;

@compute @workgroup_size(256)
fn smooth_box(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 256u + id.x;
    if index >= LEVEL_WIDTH * LEVEL_HEIGHT {
        return;
    }
    let at = vec2<u32>(index % LEVEL_WIDTH, index / LEVEL_WIDTH);
    var mean: array<f32, SUMMED>;
    if tiles[TILES_FIRST + at.y / TILE * ACROSS + at.x / TILE] != 0u {
        let first = max(at, vec2<u32>(1u)) - 1u;
        let last = min(at + 1u, vec2<u32>(LEVEL_WIDTH, LEVEL_HEIGHT) - 1u);
        for (var y = first.y; y <= last.y; y = y + 1u) {
            for (var x = first.x; x <= last.x; x = x + 1u) {
                let origin = (FIRST + y * LEVEL_WIDTH + x) * SUMMED;
                for (var k = 0u; k < SUMMED; k++) {
                    mean[k] = mean[k] + sums[origin + k];
                }
            }
        }
        let size = last - first + 1u;
        for (var k = 0u; k < SUMMED; k++) {
            mean[k] = mean[k] / f32(size.x * size.y);
        }
    }
    for (var k = 0u; k < SUMMED; k++) {
        sums[(TOTAL + FIRST + index) * SUMMED + k] = mean[k];
    }
}
