// The points of `three_points` in front of z_f, or of two surfaces of which two moments tell all.
fn points_in_front(points: ThreePoints, b: array<f32, CHANNELS>, z_f: f32) -> InFront {
    var found: InFront;
    if !points.regular {
        if points.degenerate.x > 0.0 {
            found = chebyshev_in_front(b[0], b[1], z_f);
        }
        return found;
    }
    let w = points.w;
    if w.x < 0.0 {
        let lower = bounds_of(points).x;
        let apart = w.y < 0.0 && w.x < w.y;
        let weight = w.x * w.x * (points.s.x - points.s.y * w.y) / (w.x - w.y);
        // Of two in front the second takes the rest, so that the sum is right even where they nearly coincide.
        let first = select(lower, smaller(larger(weight, 0.0), lower), apart);
        found = with_point(found, 0u, z_f + 1.0 / w.x, first);
        if apart {
            found = with_point(found, 1u, z_f + 1.0 / w.y, lower - first);
        }
    }
    return found;
}
