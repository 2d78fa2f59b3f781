// Rectified coordinates of directions and of places on the shadow map, in single precision.

struct Scattering {
    // Camera on the shadow map in texels, texels per world unit.
    origin: vec2<f32>,
    scale: vec2<f32>,
    // z of depth 0 relative to the camera, range of depths in z, distance between columns, largest r.
    near: f32,
    range: f32,
    column_width: f32,
    r_max: f32,
    // First azimuth, rows per radian, least pi - theta, 1 / (greatest - least).
    phi_start: f32,
    rows_per_radian: f32,
    least: f32,
    per_extent: f32,
    // sigma_t; 1 where rows go around the camera.
    extinction: f32,
    wraps: f32,
    unused0: f32,
    unused1: f32,
}

const HALF_TURN: f32 = 3.14159265;
const TURN: f32 = 6.28318531;

// The angle of (x, y), y >= 0, to the positive x axis, to the last digits: WGSL's own may err by 4096 units.
fn upper_angle(y: f32, x: f32) -> f32 {
    let a = abs(x);
    let high = max(a, y);
    if high == 0.0 {
        return 0.0;
    }
    let t = min(a, y) / high;
    // atan t = atan c + atan((t - c) / (1 + c t)) with c = 0, tan(pi / 8) or 1, so that |u| <= tan(pi / 16).
    let is_middle = t > 0.198912367;
    let is_large = t > 0.668178638;
    let c = select(select(0.0, 0.414213562, is_middle), 1.0, is_large);
    let base = select(select(0.0, 0.392699082, is_middle), 0.785398163, is_large);
    let u = (t - c) / (1.0 + c * t);
    let s = u * u;
    let series = u * (1.0 + s * (-0.333333333 + s * (0.2 + s * (-0.142857143 + s * (0.111111111 - s * 0.0909090909)))));
    let first = base + series;
    let octant = select(first, 1.57079633 - first, y > a);
    return select(octant, HALF_TURN - octant, x < 0.0);
}

// Azimuth in [0, 2 pi).
fn azimuth(x: f32, y: f32) -> f32 {
    let angle = upper_angle(abs(y), x);
    let turned = select(angle, TURN - angle, y < 0.0);
    return select(turned, 0.0, turned >= TURN);
}

// Normalised pi - theta, not clamped.
fn rectified_depth(view: Scattering, r: f32, z: f32) -> f32 {
    return (upper_angle(r, -z) - view.least) * view.per_extent;
}

// The place between rows of an azimuth; the middle of the first row is 0.5.
fn row_place(view: Scattering, phi: f32) -> f32 {
    let offset = phi - view.phi_start;
    return select(offset, offset + TURN, offset < 0.0) * view.rows_per_radian;
}
