// Twin of for_each_span, Plane, Quotient and Masks in ../edges.rs and ../fixed_point.rs: integers only, so that the same
// triangles give the same fragments on every device.

struct Params {
    width: u32,
    first_row: u32,
    items: u32,
    // Index of the first triangle of this batch within the whole list.
    first_triangle: u32,
    // 1 under a local light, when depths and mask coordinates are divided by weights.
    in_perspective: u32,
}

// A 64-bit two's complement integer: low word, high word.
alias Wide = vec2<u32>;

struct Plane {
    base: Wide,
    step_x: Wide,
    step_y: Wide,
}

struct Triangle {
    depth: Plane,
    corner_0: vec2<i32>,
    corner_1: vec2<i32>,
    corner_2: vec2<i32>,
    depth_low: u32,
    depth_high: u32,
    // Reference texel of the planes: x in the lower, y in the upper half.
    reference: u32,
    // Index into mask_planes or NO_MASK.
    mask_index: u32,
}

// A rectangle of at most 16 x 16 texels of one triangle.
struct Item {
    triangle: u32,
    // First texel: x in the lower, y in the upper half.
    origin: u32,
    // Width in the lower, height in the upper half.
    size: u32,
    // Edge functions at the first texel, saturated where their sign cannot change within the rectangle.
    edge_0: i32,
    edge_1: i32,
    edge_2: i32,
}

struct MaskPlanes {
    u: Plane,
    v: Plane,
    width: u32,
    height: u32,
    first_bit: u32,
    padding: u32,
}

const NO_MASK: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(2) var<storage, read> items: array<Item>;
@group(0) @binding(3) var<storage, read> mask_planes: array<MaskPlanes>;
@group(0) @binding(4) var<storage, read> mask_bits: array<u32>;
// Counts of fragments while counting, the next free slots while scattering; one a texel of the band.
@group(0) @binding(5) var<storage, read_write> counters: array<atomic<u32>>;
// x: triangle, y: depth in units of 2^-24; as 64 bits in memory this is the CPU's key.
@group(0) @binding(6) var<storage, read_write> keys: array<vec2<u32>>;
// One a triangle in perspective.
@group(0) @binding(7) var<storage, read> weights: array<Plane>;

fn add(a: Wide, b: Wide) -> Wide {
    let low = a.x + b.x;
    return Wide(low, a.y + b.y + select(0u, 1u, low < a.x));
}

// a * n for n < 2^16, modulo 2^64.
fn scale(a: Wide, n: u32) -> Wide {
    let first = (a.x & 0xffffu) * n;
    let second = (a.x >> 16u) * n + (first >> 16u);
    return Wide((second << 16u) | (first & 0xffffu), a.y * n + (second >> 16u));
}

fn plane_at(plane: Plane, x: u32, y: u32) -> Wide {
    return add(plane.base, add(scale(plane.step_x, x), scale(plane.step_y, y)));
}

// 40 fractional bits to 24, rounded and clamped.
fn depth_at(plane: Plane, x: u32, y: u32, low: u32, high: u32) -> u32 {
    let rounded = add(plane_at(plane, x, y), Wide(1u << 15u, 0u));
    let above = bitcast<i32>(rounded.y) >> 16u;
    if above < 0 {
        return low;
    }
    if above > 0 {
        return high;
    }
    return clamp((rounded.y << 16u) | (rounded.x >> 16u), low, high);
}

fn is_negative(a: Wide) -> bool {
    return (a.y >> 31u) == 1u;
}

fn is_positive(a: Wide) -> bool {
    return !is_negative(a) && (a.x | a.y) != 0u;
}

// Of numbers without sign.
fn is_less(a: Wide, b: Wide) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

fn subtract(a: Wide, b: Wide) -> Wide {
    return Wide(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

fn doubled(a: Wide, bit: u32) -> Wide {
    return Wide((a.x << 1u) | bit, (a.y << 1u) | (a.x >> 31u));
}

// The first `bits` bits after the binary point of value / weight for 0 <= value < weight < 2^63, by long division.
fn fraction_bits(value: Wide, weight: Wide, bits: u32) -> u32 {
    var rest = value;
    var quotient = 0u;
    for (var i = 0u; i < bits; i++) {
        rest = doubled(rest, 0u);
        quotient = quotient << 1u;
        if !is_less(rest, weight) {
            rest = subtract(rest, weight);
            quotient |= 1u;
        }
    }
    return quotient;
}

// What is left of a value after whole multiples of a positive weight, from 0 on also for negative values.
fn remainder(value: Wide, weight: Wide) -> Wide {
    let negative = is_negative(value);
    let size = select(value, subtract(Wide(0u, 0u), value), negative);
    var rest = Wide(0u, 0u);
    for (var i = 0u; i < 64u; i++) {
        let word = select(size.x, size.y, i < 32u);
        rest = doubled(rest, (word >> (31u - (i & 31u))) & 1u);
        if !is_less(rest, weight) {
            rest = subtract(rest, weight);
        }
    }
    if negative && (rest.x | rest.y) != 0u {
        return subtract(weight, rest);
    }
    return rest;
}

// The quotient to 24 bits, rounded and clamped.
fn divided_depth(value: Wide, weight: Wide, low: u32, high: u32) -> u32 {
    if !is_positive(weight) || (!is_negative(value) && !is_less(value, weight)) {
        return high;
    }
    if !is_positive(value) {
        return low;
    }
    return clamp((fraction_bits(value, weight, 25u) + 1u) >> 1u, low, high);
}

// 32 bits after the binary point.
fn fraction_at(plane: Plane, triangle: u32, x: u32, y: u32) -> u32 {
    let value = plane_at(plane, x, y);
    if params.in_perspective == 0u {
        return (value.y << 24u) | (value.x >> 8u);
    }
    let weight = plane_at(weights[triangle], x, y);
    if !is_positive(weight) {
        return 0u;
    }
    return fraction_bits(remainder(value, weight), weight, 32u);
}

// floor(fraction * size) for size < 2^16.
fn texel_of(fraction: u32, size: u32) -> u32 {
    return ((fraction >> 16u) * size + (((fraction & 0xffffu) * size) >> 16u)) >> 16u;
}

fn passes_mask(index: u32, triangle: u32, x: u32, y: u32) -> bool {
    let column = texel_of(fraction_at(mask_planes[index].u, triangle, x, y), mask_planes[index].width);
    let row = texel_of(fraction_at(mask_planes[index].v, triangle, x, y), mask_planes[index].height);
    let bit = mask_planes[index].first_bit + row * mask_planes[index].width + column;
    return ((mask_bits[bit / 32u] >> (bit % 32u)) & 1u) == 1u;
}

// The edge function's change per texel in x and in y.
fn edge_step(p: vec2<i32>, q: vec2<i32>) -> vec2<i32> {
    return vec2<i32>(p.y - q.y, q.x - p.x);
}

fn visit(index: u32, scatter_keys: bool) {
    if index >= params.items {
        return;
    }
    let item = items[index];
    let triangle = triangles[item.triangle];
    let step_0 = edge_step(triangle.corner_0, triangle.corner_1);
    let step_1 = edge_step(triangle.corner_1, triangle.corner_2);
    let step_2 = edge_step(triangle.corner_2, triangle.corner_0);
    let origin = vec2<u32>(item.origin & 0xffffu, item.origin >> 16u);
    let size = vec2<u32>(item.size & 0xffffu, item.size >> 16u);
    // From the planes' reference texel to the first texel of the rectangle.
    let shift = origin - vec2<u32>(triangle.reference & 0xffffu, triangle.reference >> 16u);
    for (var y = 0u; y < size.y; y++) {
        var edges = vec3<i32>(item.edge_0, item.edge_1, item.edge_2)
            + i32(y) * vec3<i32>(step_0.y, step_1.y, step_2.y);
        for (var x = 0u; x < size.x; x++) {
            let at = shift + vec2<u32>(x, y);
            var covered = (edges.x | edges.y | edges.z) >= 0;
            if covered && triangle.mask_index != NO_MASK {
                covered = passes_mask(triangle.mask_index, item.triangle, at.x, at.y);
            }
            if covered {
                let texel = (origin.y + y - params.first_row) * params.width + origin.x + x;
                let slot = atomicAdd(&counters[texel], 1u);
                if scatter_keys {
                    var depth = 0u;
                    if params.in_perspective == 0u {
                        depth = depth_at(triangle.depth, at.x, at.y, triangle.depth_low, triangle.depth_high);
                    } else {
                        let value = plane_at(triangle.depth, at.x, at.y);
                        let weight = plane_at(weights[item.triangle], at.x, at.y);
                        depth = divided_depth(value, weight, triangle.depth_low, triangle.depth_high);
                    }
                    keys[slot] = vec2<u32>(params.first_triangle + item.triangle, depth);
                }
            }
            edges += vec3<i32>(step_0.x, step_1.x, step_2.x);
        }
    }
}

@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3<u32>) {
    visit(id.x, false);
}

@compute @workgroup_size(64)
fn scatter(@builtin(global_invocation_id) id: vec3<u32>) {
    visit(id.x, true);
}
