fn in_front(b: array<f32, CHANNELS>, z: f32) -> InFront {
    let z_f = variable(z);
    var solution = solve(b, z_f);
    let lower = bounds_of_solution(&solution).x;
    var found: InFront;
    if !(lower > TINY) {
        return found;
    }
    var offsets: array<f32, 3>;
    if solution.singular {
        // Few surfaces, which the moments determine: the roots of their polynomial. One that is z_f up to the root of a
        // rounding is no blocker.
        let least = 64.0 * sqrt(EPSILON);
        if solution.count == 1u {
            offsets[0] = -solution.taylor[1][0];
        } else if solution.count == 2u {
            let roots = quadratic_roots(solution.taylor[2][1], solution.taylor[2][0]);
            offsets[0] = roots.x;
            offsets[1] = roots.y;
        } else {
            let roots = cubic_roots(solution.taylor[3][2], solution.taylor[3][1], solution.taylor[3][0]);
            offsets[0] = roots.x;
            offsets[1] = roots.y;
            offsets[2] = roots.z;
        }
        for (var i = 0u; i < 3u; i++) {
            offsets[i] = select(0.0, offsets[i], offsets[i] < -least);
        }
    } else {
        for (var i = 0u; i < 3u; i++) {
            offsets[i] = select(0.0, 1.0 / solution.w[i], i < solution.count && solution.w[i] < 0.0);
        }
    }
    var mass = 0.0;
    for (var i = 0u; i < 3u; i++) {
        if offsets[i] < 0.0 {
            found = with_point(found, i, z_f + offsets[i], christoffel(&solution, 1.0 / offsets[i]));
            mass = mass + found.weights[i];
        }
    }
    if mass > 0.0 {
        for (var i = 0u; i < 3u; i++) {
            found.weights[i] = found.weights[i] * (lower / mass);
        }
        return found;
    }
    return with_point(found, 0u, z_f, lower);
}
