fn unpacked(p: vec2<u32>) -> Support {
    return Support(i32(p.x & 511u), i32((p.x >> 9u) & 511u), i32((p.x >> 18u) & 511u), i32(p.y & 511u), i32((p.y >> 9u) & 511u));
}
fn packed(x: Support) -> vec2<u32> {
    return vec2<u32>(u32(x.x0) | (u32(x.x1) << 9u) | (u32(x.x2) << 18u), u32(x.x3) | (u32(x.x4) << 9u));
}
// The columns of a candidate to workgroup memory; a barrier has to follow.
fn load(c: u32, l: u32) {
    for (var j = l; j < u32(DEPTHS); j += 128u) {
        a01[j] = columns[c * CANDIDATE + j];
        a23[j] = columns[c * CANDIDATE + u32(DEPTHS) + j];
    }
}
fn moments_of(c: u32, f: u32) -> vec4<f64> {
    let at = c * 4u * size.stride + f;
    return vec4<f64>(moments[at], moments[at + size.stride], moments[at + 2u * size.stride], moments[at + 3u * size.stride]);
}
fn weights(f: Factors, b: vec4<f64>) -> Five {
    let r = solve(f, b - vec4<f64>(f.b0, f.b1, f.b2, f.b3));
    return Five(1.0lf - r.x, r.x - r.y, r.y - r.z, r.z - r.w, r.w);
}
// Weights may be negative by roundings of their row of the inverse, whose size a vector of signs estimates.
fn sizes(f: Factors) -> vec4<f64> { return solve(f, vec4<f64>(1.0lf, -1.0lf, 1.0lf, 1.0lf)); }
// Whether a weight may be negative for all that double precision knows.
fn is_doubtful(f: Factors, w: Five, r: vec4<f64>) -> bool {
    let sure = w.v0 >= 5e-15lf * abs(r.x) && w.v1 >= 5e-15lf * abs(r.x - r.y) && w.v2 >= 5e-15lf * abs(r.y - r.z)
        && w.v3 >= 5e-15lf * abs(r.z - r.w) && w.v4 >= 5e-15lf * abs(r.w);
    return !(f.is_sound && sure);
}
// Whether the columns hold all depths of a kernel of few depths.
fn is_distribution_of(x: Support, f: i32) -> bool {
    let packed = kernels[f];
    if (packed.x == 0xffffffffu) { return false; }
    let k = unpacked(packed);
    return holds(x, k.x0) && holds(x, k.x1) && holds(x, k.x2) && holds(x, k.x3) && holds(x, k.x4);
}
fn holds(x: Support, j: i32) -> bool { return x.x0 == j || x.x1 == j || x.x2 == j || x.x3 == j || x.x4 == j; }
fn is_infeasible(f: Factors, w: Five, r: vec4<f64>) -> bool {
    let fine = w.v0 >= fma(-5e-14lf, abs(r.x), -3e-16lf) && w.v1 >= fma(-5e-14lf, abs(r.x - r.y), -3e-16lf)
        && w.v2 >= fma(-5e-14lf, abs(r.y - r.z), -3e-16lf) && w.v3 >= fma(-5e-14lf, abs(r.z - r.w), -3e-16lf)
        && w.v4 >= fma(-5e-14lf, abs(r.w), -3e-16lf);
    return !(f.is_sound && fine);
}
fn gain(y: Five, j: i32, front: i32) -> f64 {
    let p = a01[j];
    let q = a23[j];
    return fma(y.v4, q.y, fma(y.v3, q.x, fma(y.v2, p.y, fma(y.v1, p.x, select(y.v0, y.v0 - 1.0lf, j < front)))));
}

var<workgroup> factors: array<vec4<f64>, 4u * DIMENSIONS>;

@compute @workgroup_size(128)
fn moment(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) l: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let first = group.y * 4u;
    for (var i = l; i < 4u * DIMENSIONS; i += 128u) {
        factors[i] = transform[min(first + i % 4u, size.candidates - 1u) * DIMENSIONS + i / 4u];
    }
    workgroupBarrier();
    let f = id.x;
    if (f >= size.programs) { return; }
    var t0 = vec4<f64>(); var t1 = vec4<f64>(); var t2 = vec4<f64>(); var t3 = vec4<f64>();
    for (var start = 0u; start < DIMENSIONS; start += 8u) {
        var p0 = vec4<f64>(); var p1 = vec4<f64>(); var p2 = vec4<f64>(); var p3 = vec4<f64>();
        let end = min(start + 8u, DIMENSIONS);
        for (var r = start; r < end; r++) {
            let m = vec4<f64>(coordinates[r * size.stride + f]);
            p0 = fma(m, factors[4u * r], p0);
            p1 = fma(m, factors[4u * r + 1u], p1);
            p2 = fma(m, factors[4u * r + 2u], p2);
            p3 = fma(m, factors[4u * r + 3u], p3);
        }
        t0 += p0; t1 += p1; t2 += p2; t3 += p3;
    }
    write(first, f, t0);
    write(first + 1u, f, t1);
    write(first + 2u, f, t2);
    write(first + 3u, f, t3);
}
fn write(c: u32, f: u32, b: vec4<f64>) {
    if (c >= size.candidates) { return; }
    let at = c * 4u * size.stride + f;
    moments[at] = b.x;
    moments[at + size.stride] = b.y;
    moments[at + 2u * size.stride] = b.z;
    moments[at + 3u * size.stride] = b.w;
}

@compute @workgroup_size(128)
fn newton(@builtin(local_invocation_index) l: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let c = group.y;
    let begin = group.x * size.share;
    let end = min(begin + size.share, size.programs);
    load(c, l);
    if (l == 0u) { atomicStore(&next, begin); }
    workgroupBarrier();
    var f = -1i; var step = 0i; var shifts = 0i; var guess = 0i;
    var x = Support(0i, 1i, 2i, 3i, 4i);
    var b = vec4<f64>();
    loop {
        if (is_time(f < 0i)) {
            if (f < 0i) {
                let mine = atomicAdd(&next, 1u);
                if (mine >= end) { break; }
                f = i32(mine); step = steps[mine]; x = unpacked(guesses[mine].xy); shifts = 0i; guess = 0i;
                b = moments_of(c, mine);
            }
        }
        if (f < 0i) { continue; }
        let lu = factor(x);
        let w = weights(lu, b);
        let good = !is_infeasible(lu, w, sizes(lu));
        shifts += 1i;
        var more = !good && lu.is_sound && shifts < 6i;
        if (more) {
            let shifted = shift(x, w, step);
            x = shifted.x;
            more = shifted.moved;
        }
        if (!good && !more && guess == 0i) {
            x = unpacked(guesses[f].zw);
            guess = 1i; shifts = 0i; more = true;
        }
        if (!more) {
            if (!good) { x = unpacked(guesses[f].xy); }
            supports[c * size.stride + u32(f)] = packed(x);
            f = -1i;
        }
    }
}

// What the basis of a program proves. Written to `bounds`, -1 where that is not enough; true if another basis may do better.
fn certify(c: u32, f: u32) -> bool {
    let step = steps[f];
    let given = masses[f];
    let mass = given.x;
    let x = unpacked(supports[c * size.stride + f]);
    let b = moments_of(c, f);
    let lu = factor(x);
    let w = weights(lu, b);
    let r = sizes(lu);
    let infeasible = is_infeasible(lu, w, r);
    let p0 = select(0.0lf, 1.0lf, x.x0 < step); let p1 = select(0.0lf, 1.0lf, x.x1 < step); let p2 = select(0.0lf, 1.0lf, x.x2 < step);
    let p3 = select(0.0lf, 1.0lf, x.x3 < step); let p4 = select(0.0lf, 1.0lf, x.x4 < step);
    var value = fma(p4, max(w.v4, 0.0lf), fma(p3, max(w.v3, 0.0lf), fma(p2, max(w.v2, 0.0lf), fma(p1, max(w.v1, 0.0lf), p0 * max(w.v0, 0.0lf)))));
    let y = solve_transposed(lu, vec4<f64>(p1 - p0, p2 - p1, p3 - p2, p4 - p3));
    let y0 = fma(-y.w, lu.b3, fma(-y.z, lu.b2, fma(-y.y, lu.b1, fma(-y.x, lu.b0, p0))));
    var proved = fma(y.w, b.w, fma(y.z, b.z, fma(y.y, b.y, fma(y.x, b.x, y0))));
    let own = c * CANDIDATE + 2u * u32(DEPTHS);
    let e01 = columns[own]; let e23 = columns[own + 1u]; let more = columns[own + 2u]; let errors = columns[own + 3u];
    let of_moments = given.y * errors.y;
    var rounding = fma(abs(y0), more.x, 2e-15lf);
    rounding = fma(abs(y.x), fma(abs(b.x), errors.x, e01.x + of_moments), rounding);
    rounding = fma(abs(y.y), fma(abs(b.y), errors.x, e01.y + of_moments), rounding);
    rounding = fma(abs(y.z), fma(abs(b.z), errors.x, e23.x + of_moments), rounding);
    rounding = fma(abs(y.w), fma(abs(b.w), errors.x, e23.y + of_moments), rounding);
    let tolerance = more.y;
    let low = clamp(least_step(step), 0i, DEPTHS);
    let high = clamp(largest_step(step), low, DEPTHS);
    var best = -1e300lf;
    let before = y0 - 1.0lf;
    for (var j = 0i; j < low; j++) {
        let p = a01[j]; let q = a23[j];
        best = max(best, fma(y.w, q.y, fma(y.z, q.x, fma(y.y, p.y, fma(y.x, p.x, before)))));
    }
    for (var j = low; j < high; j++) {
        let p = a01[j]; let q = a23[j];
        best = max(best, fma(y.w, q.y, fma(y.z, q.x, fma(y.y, p.y, fma(y.x, p.x, select(y0, before, j < step))))));
    }
    for (var j = high; j < DEPTHS; j++) {
        let p = a01[j]; let q = a23[j];
        best = max(best, fma(y.w, q.y, fma(y.z, q.x, fma(y.y, p.y, fma(y.x, p.x, y0)))));
    }
    var lacking = max(best, 0.0lf);
    if (p0 == 0.0lf) { value = 0.0lf; proved = 0.0lf; rounding = 0.0lf; lacking = 0.0lf; }
    // False for what is no number.
    let sound = rounding < 1.0lf;
    proved = select(0.0lf, max(proved - lacking - rounding, 0.0lf), sound);
    let bound = min(max(value, proved), mass);
    let sharp = !infeasible && bound - proved <= tolerance;
    var settled = proved >= mass - tolerance || sharp;
    // With the kernel's weights a basis attains F; what else it seems to attain is rounding.
    if (sharp && proved < mass - tolerance && is_doubtful(lu, w, r)) { settled = bound >= mass - tolerance && is_distribution_of(x, i32(f)); }
    bounds[c * size.stride + f] = select(-1.0lf, bound, settled);
    return !settled && (infeasible || !sound || lacking > 0.5lf * tolerance);
}

@compute @workgroup_size(128)
fn certify_all(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) l: u32, @builtin(workgroup_id) group: vec3<u32>) {
    load(group.y, l);
    workgroupBarrier();
    if (id.x >= size.programs) { return; }
    let again = certify(group.y, id.x);
    enqueue(group.y, id.x, again);
}
@compute @workgroup_size(128)
fn certify_queue(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) l: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let c = group.y;
    let own = (size.round - 1u) * size.candidates + c;
    let count = min(atomicLoad(&counts[own]), size.programs);
    if (group.x * 128u >= count) { return; }
    load(c, l);
    workgroupBarrier();
    if (id.x >= count) { return; }
    let f = queues[own * size.stride + id.x];
    let again = certify(c, f);
    if (size.round < 2u) { enqueue(c, f, again); }
}
fn enqueue(c: u32, f: u32, wanted: bool) {
    let own = size.round * size.candidates + c;
    let at = place(own, wanted);
    if (wanted) { queues[own * size.stride + at] = f; }
}

@compute @workgroup_size(128)
fn pivot_coarse(@builtin(local_invocation_index) l: u32, @builtin(workgroup_id) group: vec3<u32>) { pivot(group.xy, l, false); }
@compute @workgroup_size(128)
fn pivot_full(@builtin(local_invocation_index) l: u32, @builtin(workgroup_id) group: vec3<u32>) { pivot(group.xy, l, true); }

var<workgroup> tree: array<vec2<f64>, 256>;

@compute @workgroup_size(256)
fn sum(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) l: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let c = group.y;
    let f = id.x;
    let at = c * size.stride + f;
    let bound = bounds[at];
    let own = weighting[f];
    // What is no number is left, too.
    let left = !(bound >= 0.0lf);
    let difference = abs(bound - own.x) - own.z;
    tree[l] = select(vec2<f64>(own.y * difference, own.y * difference * difference), vec2<f64>(), left);
    let to = place(2u * size.candidates, left);
    if (left && to < size.capacity) { rest[to] = vec4<u32>(c, f, supports[at]); }
    workgroupBarrier();
    for (var half = 128u; half > 0u; half /= 2u) {
        if (l < half) { tree[l] += tree[l + half]; }
        workgroupBarrier();
    }
    // One bound of each group is checked elsewhere.
    let sampled = (group.x * 97u + c * 31u) % 256u;
    let to_sum = c * size.groups + group.x;
    if (l == 0u) { sums[to_sum].x = tree[0].x; sums[to_sum].y = tree[0].y; }
    if (l == sampled) { sums[to_sum].z = bound; }
}
