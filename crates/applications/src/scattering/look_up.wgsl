// A thread a view ray: one look-up of the prefix sums, and the lit share (BHS16 section 2.2).

@group(0) @binding(0) var<storage, read> stored: array<u32>;
// Direction in light space, a unit vector, and length; negative for rays that never end.
@group(0) @binding(1) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> shares: array<f32>;
@group(0) @binding(3) var<uniform> view: Scattering;

// int e^(-sigma_t t) dt between two distances.
fn transmitted_length(start: f32, length: f32) -> f32 {
    let depth = view.extinction * length;
    var lost = length * (1.0 - depth * 0.5 * (1.0 - depth / 3.0 * (1.0 - depth * 0.25 * (1.0 - depth * 0.2))));
    if depth >= 0.1 {
        lost = (1.0 - select(exponential(-depth), 0.0, depth > 87.0)) / view.extinction;
    }
    let before = view.extinction * start;
    return select(exponential(-before), 0.0, before > 87.0) * lost;
}

// Texels that a ray's end lies between, and the shares of the second ones.
struct Place {
    rows: vec2<u32>,
    columns: vec2<u32>,
    down: f32,
    across: f32,
}

fn inner_row(row: i32) -> u32 {
    let rows = i32(ROWS);
    return u32(select(clamp(row, 0, rows - 1), (row + rows) % rows, view.wraps > 0.5));
}

// Of one of the maps, which lie one behind the other.
fn mean_at(map: u32, place: Place) -> array<f32, CHANNELS> {
    var found: array<f32, CHANNELS>;
    for (var corner = 0u; corner < 4u; corner++) {
        let is_right = (corner & 1u) == 1u;
        let is_low = corner >= 2u;
        let weight = select(1.0 - place.down, place.down, is_low)
            * select(1.0 - place.across, place.across, is_right);
        let row = map * ROWS + select(place.rows.x, place.rows.y, is_low);
        let texel = load(row * COLUMNS + select(place.columns.x, place.columns.y, is_right));
        for (var k = 0u; k < CHANNELS; k++) {
            found[k] = found[k] + weight * texel[k];
        }
    }
    return found;
}

@compute @workgroup_size(64)
fn look_up(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&rays) {
        return;
    }
    let ray = rays[index];
    let r = length(ray.xy);
    let is_endless = ray.w < 0.0;
    // Where the look-up ends: at the ray's end, or the last column.
    let end_r = select(min(ray.w * r, view.r_max), view.r_max, is_endless);
    // Prefix u ends at the outer border of texel u.
    let prefix = clamp(end_r / view.column_width - 1.0, 0.0, f32(COLUMNS - 1u));
    let column = u32(prefix);
    let across = prefix - f32(column);
    let next = min(column + 1u, COLUMNS - 1u);
    let along = row_place(view, azimuth(ray.x, ray.y)) - 0.5;
    let row = i32(floor(along));
    let down = along - floor(along);
    let place = Place(vec2<u32>(inner_row(row), inner_row(row + 1)), vec2<u32>(column, next), down, across);
    let depth = stored_depth(clamp_unit(rectified_depth(view, r, ray.z)));
    let cosine = -ray.z;
    var dark = shadowed(dequantise(mean_at(0u, place)), depth, cosine);
    dark = between_spacings(dark, place, r, depth, cosine);
    let lit = clamp_unit(1.0 - dark);
    let reached = end_r / r;
    if r == 0.0 || (!is_endless && ray.w * r <= view.r_max) {
        shares[index] = lit;
        return;
    }
    // All of it is lit beyond.
    let within = transmitted_length(0.0, reached);
    if is_endless {
        let reach = view.extinction * reached;
        let rest = select(exponential(-reach), 0.0, reach > 87.0) / view.extinction;
        shares[index] = select((lit * within + rest) / (within + rest), 1.0, view.extinction == 0.0);
        return;
    }
    let beyond = transmitted_length(reached, ray.w - reached);
    shares[index] = (lit * within + beyond) / (within + beyond);
}
