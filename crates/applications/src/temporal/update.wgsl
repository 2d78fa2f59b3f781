// A frame's test joins the history of each pixel, which begins anew where there is none (TC09 sections 3.2 to 3.4): a thread a
// pixel.

@group(0) @binding(0) var<storage, read> before: array<u32>;
@group(0) @binding(1) var<storage, read_write> after: array<u32>;
@group(0) @binding(2) var<storage, read> pixels: array<Pixel>;
// What percentage-closer soft shadows say: share of shadow, average distance of blockers or 0 without any, 1 if one moves.
@group(0) @binding(3) var<storage, read> starts: array<vec4<f32>>;
// Share of shadow, standard error, number of tests, whether the history is new.
@group(0) @binding(4) var<storage, read_write> shown: array<vec4<f32>>;
@group(0) @binding(5) var<uniform> screen: Screen;

struct Found {
    history: History,
    is_known: bool,
}

// The history of a place in the last buffer, where it is that of the same surface (equation 4).
fn found_at(place: vec3<f32>) -> Found {
    var found: Found;
    let tolerance = TOLERANCE * place.z;
    if !INTERPOLATED {
        if is_on(screen, place.xy) {
            found.history = load_before(pixel_of(screen, place.xy));
            found.is_known = belongs_to(found.history, place.z, tolerance);
        }
        return found;
    }
    let corner = floor(place.xy - 0.5);
    let inner = place.xy - 0.5 - corner;
    var weight = 0.0;
    var sum: History;
    var known = 0.0;
    var anyone = 0.0;
    for (var part = 0u; part < 4u; part++) {
        let step = vec2<f32>(f32(part & 1u), f32(part >> 1u));
        let shares = 1.0 - abs(inner - step);
        let at = corner + step + 0.5;
        if is_on(screen, at) {
            let neighbour = load_before(pixel_of(screen, at));
            if belongs_to(neighbour, place.z, tolerance) {
                let share = shares.x * shares.y;
                weight = weight + share;
                sum.tests = sum.tests + share * neighbour.tests;
                sum.shadowed = sum.shadowed + share * neighbour.shadowed;
                sum.depth = sum.depth + share * neighbour.depth;
                // Averages count by what they are averages of.
                let counted = share * select(neighbour.tests, neighbour.shadowed, BLOCKERS_ONLY);
                known = known + counted;
                anyone = anyone + share * neighbour.blocker;
                sum.blocker = sum.blocker + counted * neighbour.blocker;
            }
        }
    }
    if weight > LEAST_SHARE {
        let blocker = select(anyone / weight, sum.blocker / known, known > 0.0);
        found.history = History(sum.tests / weight, sum.shadowed / weight, sum.depth / weight, blocker);
        found.is_known = true;
    }
    return found;
}

// One more test: n and rho (equation 2), and the average of depths (equation 7).
fn counted(history: History, pixel: Pixel) -> History {
    var next = history;
    if next.tests >= MOST_TESTS {
        let share = (MOST_TESTS - 1.0) / next.tests;
        next.tests = share * next.tests;
        next.shadowed = share * next.shadowed;
    }
    let in_shadow = is_flagged(pixel, select(IN_SHADOW, HIDDEN, EXACT));
    let samples = select(max(next.tests - START_TESTS, 0.0), next.shadowed, BLOCKERS_ONLY);
    let already = START_BLOCKERS + samples;
    let added = select(0.0, 1.0, in_shadow || !BLOCKERS_ONLY);
    if already + added > 0.0 {
        next.blocker = (already * next.blocker + added * pixel.map_distance) / (already + added);
    }
    next.tests = next.tests + 1.0;
    next.shadowed = next.shadowed + select(0.0, 1.0, in_shadow);
    next.depth = pixel.depth;
    return next;
}

@compute @workgroup_size(64)
fn update(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = index_of(id, groups);
    if index >= screen.width * screen.height {
        return;
    }
    let pixel = pixels[index];
    if !is_flagged(pixel, SHOWN) {
        store(index, History(0.0, 0.0, 0.0, 0.0));
        shown[index] = vec4<f32>(0.0);
        return;
    }
    let start = starts[index];
    var disturbed = false;
    if TEXEL_MOVES {
        disturbed = is_flagged(pixel, MOVING);
    }
    if SEARCH_MOVES {
        disturbed = start.z > 0.0;
    }
    var found: Found;
    if !disturbed {
        found = found_at(pixel.before.xyz);
    }
    var next = History(0.0, 0.0, pixel.depth, pixel.receiver);
    if found.is_known {
        next = counted(found.history, pixel);
    } else if START_TESTS > 0.0 {
        let blocker = select(pixel.receiver, start.y, start.y > 0.0);
        next = History(START_TESTS, START_TESTS * start.x, pixel.depth, blocker);
    } else {
        next = counted(next, pixel);
    }
    store(index, next);
    let kept = load_after(index);
    shown[index] = vec4<f32>(
        clamp_unit(fraction(kept)), standard_error(kept), kept.tests, select(1.0, 0.0, found.is_known));
}
