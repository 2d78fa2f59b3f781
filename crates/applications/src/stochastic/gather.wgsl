// Sums of a level over the samples that reach each texel (SSSM15 equation 7) and those of the next coarser level: a workgroup a
// tile, whose surroundings are loaded a strip of rows at a time.

@group(0) @binding(0) var<storage, read> texels: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> values: array<f32>;
// Weight and values of all levels as they are gathered, then the same when they are put together.
@group(0) @binding(2) var<storage, read_write> sums: array<f32>;
@group(0) @binding(3) var<storage, read> tiles: array<u32>;
@group(0) @binding(4) var<uniform> plane: FilterPlane;

const TILE: u32 = 16u;
const ACROSS: u32 = (LEVEL_WIDTH + TILE - 1u) / TILE;
const SPAN: u32 = TILE + 2u * REACH;
const LOADED: u32 = STRIP * SPAN;
const SUMMED: u32 = CHANNELS + 1u;

var<workgroup> near_texels: array<vec4<f32>, LOADED>;
var<workgroup> near_values: array<array<f32, CHANNELS>, LOADED>;

fn is_reached(step: vec2<f32>, radius: f32) -> bool {
    if DISC {
        return step.x * step.x + step.y * step.y < radius * radius;
    }
    return all(abs(step) < vec2<f32>(HALF_SIDE * radius));
}

// Between which texels of the coarser level a place lies, and the share of the second one.
fn coarser_place(t: u32, size: u32) -> vec3<f32> {
    let at = clamp(0.5 * (f32(t) + 0.5) - 0.5, 0.0, f32(size - 1u));
    return vec3<f32>(floor(at), min(floor(at) + 1.0, f32(size - 1u)), at - floor(at));
}

@compute @workgroup_size(TILE, TILE)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let tile = group.y * groups.x + group.x;
    let corner = TILE * vec2<u32>(tile % ACROSS, tile / ACROSS);
    if corner.y >= LEVEL_HEIGHT {
        return;
    }
    let at = corner + local.xy;
    var weights = 0.0;
    var found: array<f32, CHANNELS>;
    let is_needed = tiles[TILES_FIRST + tile] != 0u;
    if is_needed {
        // In texels from the corner of what is loaded.
        let own = local.xy + REACH;
        let first_column = own.x - REACH + (REACH % STRIDE);
        for (var start = 0u; start < SPAN; start = start + STRIP) {
            workgroupBarrier();
            for (var i = thread; i < LOADED; i = i + TILE * TILE) {
                let place = corner + vec2<u32>(i % SPAN, start + i / SPAN) - REACH;
                // Before the first texel numbers wrap around.
                if place.x < LEVEL_WIDTH && place.y < LEVEL_HEIGHT {
                    let texel = FIRST + place.y * LEVEL_WIDTH + place.x;
                    near_texels[i] = texels[texel];
                    for (var k = 0u; k < CHANNELS; k++) {
                        near_values[i][k] = values[texel * CHANNELS + k];
                    }
                } else {
                    near_texels[i] = vec4<f32>(0.0);
                }
            }
            workgroupBarrier();
            for (var line = 0u; line < STRIP; line = line + 1u) {
                let row = start + line;
                // Every second one, the texel's own among them.
                let is_within = row + REACH >= own.y && row <= own.y + REACH;
                if is_within && (row + own.y) % STRIDE == 0u {
                    for (var column = first_column; column <= own.x + REACH; column = column + STRIDE) {
                        let sample = near_texels[line * SPAN + column];
                        let step = (vec2<f32>(vec2<u32>(column, row)) - vec2<f32>(own) + sample.zw) / plane.aspect;
                        if sample.x > 0.0 && is_reached(step, sample.y) {
                            let weight = SCALE * sample.x / (sample.y * sample.y);
                            weights = weights + weight;
                            for (var k = 0u; k < CHANNELS; k++) {
                                found[k] = found[k] + weight * near_values[line * SPAN + column][k];
                            }
                        }
                    }
                }
            }
        }
        if COARSER {
            let x = coarser_place(at.x, COARSER_WIDTH);
            let y = coarser_place(at.y, COARSER_HEIGHT);
            for (var part = 0u; part < 4u; part++) {
                let is_right = (part & 1u) == 1u;
                let is_low = part >= 2u;
                let share = select(1.0 - x.z, x.z, is_right) * select(1.0 - y.z, y.z, is_low);
                let place = u32(select(y.x, y.y, is_low)) * COARSER_WIDTH + u32(select(x.x, x.y, is_right));
                let origin = (TOTAL + COARSER_FIRST + place) * SUMMED;
                weights = weights + share * sums[origin];
                for (var k = 0u; k < CHANNELS; k++) {
                    found[k] = found[k] + share * sums[origin + 1u + k];
                }
            }
        }
    }
    if at.x < LEVEL_WIDTH && at.y < LEVEL_HEIGHT {
        let to = (GATHERED_FIRST + FIRST + at.y * LEVEL_WIDTH + at.x) * SUMMED;
        sums[to] = weights;
        for (var k = 0u; k < CHANNELS; k++) {
            sums[to + 1u + k] = found[k];
        }
    }
}
