// A pixel of the shadow buffer (TC09 section 3): four numbers, all 0 where there is no history.

struct History {
    // n and rho.
    tests: f32,
    shadowed: f32,
    // Distance from the eye, and average distance of blockers from the light's plane.
    depth: f32,
    blocker: f32,
}

struct Screen {
    // Full size of the light; pixels per unit of length across the view at distance 1.
    light_size: f32,
    pixels_per_unit: f32,
    // Pixels of the buffer.
    width: u32,
    height: u32,
}

struct Pixel {
    // Distances: from the eye, of the surface from the light's plane, of what the frame's map saw from it. IN_SHADOW, HIDDEN,
    // MOVING and SHOWN added up.
    depth: f32,
    receiver: f32,
    map_distance: f32,
    flags: f32,
    // Where the surface was in the last frame: column, row and distance from the eye.
    before: vec4<f32>,
}

const IN_SHADOW: u32 = 1u;
const HIDDEN: u32 = 2u;
const MOVING: u32 = 4u;
const SHOWN: u32 = 8u;

fn is_flagged(pixel: Pixel, flag: u32) -> bool {
    return (u32(pixel.flags) & flag) != 0u;
}

fn index_of(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.y * groups.x * 64u + id.x;
}

fn is_on(screen: Screen, place: vec2<f32>) -> bool {
    return all(place >= vec2<f32>(0.0)) && place.x < f32(screen.width) && place.y < f32(screen.height);
}

fn pixel_of(screen: Screen, place: vec2<f32>) -> u32 {
    return u32(place.y) * screen.width + u32(place.x);
}

fn belongs_to(history: History, depth: f32, tolerance: f32) -> bool {
    return history.depth > 0.0 && abs(depth - history.depth) < tolerance;
}

// psi (equation 2).
fn fraction(history: History) -> f32 {
    return select(0.0, history.shadowed / history.tests, history.tests > 0.0);
}

// Equation 3, or that of one more test to either side.
fn standard_error(history: History) -> f32 {
    if CAUTIOUS {
        let count = history.tests + 2.0;
        let p = (history.shadowed + 1.0) / count;
        return sqrt(p * (1.0 - p) / count);
    }
    let psi = fraction(history);
    let freedom = history.tests - 1.0;
    return sqrt(select(0.0, max(psi * (1.0 - psi), 0.0) / freedom, freedom > 0.0));
}
