// Where a distance lies between planes, ascending; outside it belongs to the first or last one alone.

struct Between {
    lower: u32,
    // Of the next plane.
    share: f32,
}

fn between_planes(distance: f32) -> Between {
    var after = PLANES;
    for (var i = PLANES; i > 0u; i--) {
        if plane_distances[i - 1u] > distance {
            after = i - 1u;
        }
    }
    if after == 0u {
        return Between(0u, 0.0);
    }
    if after == PLANES {
        return Between(PLANES - 1u, 0.0);
    }
    let before = plane_distances[after - 1u];
    return Between(after - 1u, (distance - before) / (plane_distances[after] - before));
}
