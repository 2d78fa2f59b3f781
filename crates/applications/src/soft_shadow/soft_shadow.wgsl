// Soft shadows of fragments (BHS16 section 3): search region, blockers, penumbra, filter region, bound.

struct Penumbra {
    // Full widths of the light in texels of the map: world units, or tangents of angles, times texels a unit.
    light: vec2<f32>,
    // Distance of depth 0 from the light; 0 or less for a light at infinity.
    near: f32,
    // World distance from depth 0 to depth 1.
    depth_range: f32,
}

struct Blockers {
    mass: f32,
    depth_sum: f32,
}

// Of the fragment, in [0, 1); 0 without dithering.
var<private> noise: vec2<f32>;

// A corner of the filter region, moved to a texel's so that over all noise every texel counts as often as it is covered.
fn dithered(corner: vec2<f32>) -> vec2<f32> {
    if DITHERED {
        return floor(corner + noise);
    }
    return corner;
}

// Neither region exceeds MOST_WIDTH.
fn limited(widths: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(smaller(widths.x, MOST_WIDTH), smaller(widths.y, MOST_WIDTH));
}

fn search_widths(penumbra: Penumbra, z: f32) -> vec2<f32> {
    let reach = z * penumbra.depth_range;
    return limited(penumbra.light * select(reach, reach / (penumbra.near + reach), penumbra.near > 0.0));
}

fn filter_widths(penumbra: Penumbra, z: f32, average: f32) -> vec2<f32> {
    let blocker = smaller(larger(average, 0.0), z);
    let apart = (z - blocker) * penumbra.depth_range;
    if penumbra.near > 0.0 {
        let receiver = penumbra.near + z * penumbra.depth_range;
        let blocked = penumbra.near + blocker * penumbra.depth_range;
        return limited(penumbra.light * (apart * penumbra.near / (receiver * blocked)));
    }
    return limited(penumbra.light * apart);
}

// Drawn towards the receiver by a weight of SEARCH_EPSILON there; not clamped.
fn average_blocker(blockers: Blockers, z: f32) -> f32 {
    let total = SEARCH_EPSILON + blockers.mass;
    return select(z, (SEARCH_EPSILON * z + blockers.depth_sum) / total, total > 0.0);
}

// The share of the bias that a filter takes.
fn bias_share(widths: vec2<f32>) -> f32 {
    if FULL_BIAS_WIDTH > 0.0 {
        return smaller(larger(larger(widths.x, widths.y) / FULL_BIAS_WIDTH, LEAST_BIAS_SHARE), 1.0);
    }
    return 1.0;
}
