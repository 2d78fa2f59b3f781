// Six power moments on the line (order 2 n - 2 with n = 4 points): Cholesky-like factors, orthogonal polynomials,
// roots, and the smaller of two routes to the mass in front of z_f.

const POINTS: u32 = 4u;

struct Solution {
    at_z_f: f32,
    // 1 / (z - z_f), ascending; the first `count`.
    w: array<f32, 3>,
    count: u32,
    singular: bool,
    shifted: array<f32, 4>,
    taylor: array<array<f32, 4>, 4>,
    pivots: array<f32, 4>,
}

fn solve(b: array<f32, CHANNELS>, z_f: f32) -> Solution {
    var hankel: array<f32, 7>;
    var moments = b;
    hankel[0] = 1.0;
    for (var k = 0u; k < CHANNELS; k++) {
        hankel[k + 1u] = moments[k];
    }
    var solution: Solution;
    var factors: array<array<f32, 4>, 4>;
    var power: array<f32, 4>;
    power[0] = 1.0;
    solution.pivots[0] = 1.0;
    solution.taylor[0][0] = 1.0;
    var points = POINTS;
    for (var k = 1u; k < POINTS; k++) { if k < points {
        for (var j = 0u; j < k; j++) {
            var sum = hankel[k + j];
            for (var i = 0u; i < j; i++) {
                sum = sum - factors[k][i] * factors[j][i] * solution.pivots[i];
            }
            factors[k][j] = sum / solution.pivots[j];
        }
        var pivot = hankel[2u * k];
        for (var i = 0u; i < k; i++) {
            pivot = pivot - factors[k][i] * factors[k][i] * solution.pivots[i];
        }
        for (var i = k + 1u; i > 0u; i--) {
            let before = select(0.0, power[max(i, 2u) - 2u], i > 1u);
            power[i - 1u] = z_f * power[i - 1u] + before;
        }
        for (var i = 0u; i < POINTS; i++) {
            solution.taylor[k][i] = power[i];
        }
        for (var j = 0u; j < k; j++) {
            for (var i = 0u; i < POINTS; i++) {
                solution.taylor[k][i] = solution.taylor[k][i] - factors[k][j] * solution.taylor[j][i];
            }
        }
        solution.pivots[k] = pivot;
        if pivot <= pivot_floor(hankel[2u * k]) {
            solution.singular = true;
            solution.pivots[k] = positive_pivot(pivot, hankel[2u * k]);
            points = k + 1u;
        }
    } }
    var q: array<f32, 4>;
    for (var k = 0u; k < POINTS; k++) { if k < points {
        let factor = solution.taylor[k][0] / solution.pivots[k];
        for (var i = 0u; i <= k; i++) {
            q[i] = q[i] + factor * solution.taylor[k][i];
        }
    } }
    if points == 2u {
        solution.w[0] = -(q[1] / q[0]);
    } else if points == 3u {
        let roots = quadratic_roots(q[1] / q[0], q[2] / q[0]);
        solution.w[0] = roots.x;
        solution.w[1] = roots.y;
    } else {
        let roots = cubic_roots(q[1] / q[0], q[2] / q[0], q[3] / q[0]);
        solution.w[0] = roots.x;
        solution.w[1] = roots.y;
        solution.w[2] = roots.z;
    }
    for (var i = 0u; i < POINTS; i++) {
        solution.shifted[i] = hankel[i];
    }
    for (var k = 1u; k < POINTS; k++) {
        for (var j = POINTS - 1u; j >= k; j--) {
            solution.shifted[j] = solution.shifted[j] - z_f * solution.shifted[j - 1u];
        }
    }
    solution.at_z_f = 1.0 / q[0];
    solution.count = points - 1u;
    return solution;
}

// The weight of the point z_f + 1 / w: a sum of squares, in which nothing cancels.
fn christoffel(solution: ptr<function, Solution>, w: f32) -> f32 {
    let n = (*solution).count;
    let is_near = abs(w) >= 1.0;
    let x = select(w, 1.0 / w, is_near);
    let terms = select(n + 1u, n, (*solution).singular);
    var sum = 0.0;
    for (var k = 0u; k < POINTS; k++) { if k < terms {
        var value = 0.0;
        // Coefficients from the highest on, or to it; those above n are 0.
        for (var i = 0u; i < POINTS; i++) { if is_near || i <= n {
            value = value * x + select((*solution).taylor[k][i], (*solution).taylor[k][3u - i], is_near);
        } }
        sum = sum + value * value / (*solution).pivots[k];
    } }
    var weight = 1.0 / sum;
    for (var i = 0u; i < POINTS - 1u; i++) {
        weight = select(weight, weight * (w * w), !is_near && i < n);
    }
    return weight;
}

// The mass in front of z_f as the expectation of the polynomial that is 1 at the points in front and 0 at the others.
fn mass_before(solution: ptr<function, Solution>) -> f32 {
    // Ascending: points in front, z_f, points behind; points at infinity are left out.
    var nodes: array<f32, 4>;
    var table: array<f32, 4>;
    var count = 0u;
    for (var i = POINTS - 1u; i > 0u; i--) {
        let w = (*solution).w[i - 1u];
        if i <= (*solution).count && w < -TINY {
            for (var slot = 0u; slot < POINTS; slot++) {
                nodes[slot] = select(nodes[slot], 1.0 / w, slot == count);
                table[slot] = select(table[slot], 1.0, slot == count);
            }
            count++;
        }
    }
    count++;
    for (var i = POINTS - 1u; i > 0u; i--) {
        let w = (*solution).w[i - 1u];
        if i <= (*solution).count && w > TINY {
            for (var slot = 0u; slot < POINTS; slot++) {
                nodes[slot] = select(nodes[slot], 1.0 / w, slot == count);
            }
            count++;
        }
    }
    for (var order = 1u; order < POINTS; order++) {
        for (var i = POINTS - 1u; i >= order; i--) { if i < count {
            let step = nodes[i] - nodes[i - order];
            table[i] = select((table[i] - table[i - 1u]) / step, 0.0, step == 0.0);
        } }
    }
    var coefficients: array<f32, 4>;
    for (var i = POINTS; i > 0u; i--) { if i <= count {
        for (var j = POINTS - 1u; j >= 1u; j--) { if j < count {
            coefficients[j] = coefficients[j - 1u] - nodes[i - 1u] * coefficients[j];
        } }
        coefficients[0] = table[i - 1u] - nodes[i - 1u] * coefficients[0];
    } }
    var sum = 0.0;
    for (var i = 0u; i < POINTS; i++) { if i < count {
        sum = sum + coefficients[i] * (*solution).shifted[i];
    } }
    return sum;
}

fn bounds_of_solution(solution: ptr<function, Solution>) -> vec2<f32> {
    var front = 0.0;
    var behind = 0.0;
    for (var i = 0u; i < POINTS - 1u; i++) { if i < (*solution).count {
        let w = (*solution).w[i];
        let weight = christoffel(solution, w);
        front = select(front, front + weight, w < 0.0);
        behind = select(behind, behind + weight, w > 0.0);
    } }
    let total = front + (*solution).at_z_f + behind;
    return ordered(smaller(front / total, mass_before(solution)), 1.0 - behind / total);
}

fn bounds(b: array<f32, CHANNELS>, z: f32) -> vec2<f32> {
    var solution = solve(b, variable(z));
    return bounds_of_solution(&solution);
}
