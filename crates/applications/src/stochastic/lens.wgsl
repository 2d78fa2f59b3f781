// A plane of a stochastic soft shadow map, and where rays are on it (SSSM15 section 5).

struct FilterPlane {
    // 1 / distance - 1 / that of the plane in focus, 1 / that in focus, 1 / distance.
    lever: f32,
    per_focus: f32,
    per_distance: f32,
    // t R of equation 6.
    circle: f32,
    // Both axes of the light over their geometric mean.
    aspect: vec2<f32>,
    // Distance of depth 0, and from there to depth 1.
    near: f32,
    range: f32,
    // Place of the plane among all.
    number: f32,
    unused0: f32,
    unused1: f32,
    unused2: f32,
}

const COUNT: u32 = WIDTH * HEIGHT;

// Stands for surfaces that there are none of: shaders have no infinite constant.
const FAR: f32 = 1e30;

fn centre_of(texel: u32) -> vec2<f32> {
    return vec2<f32>(f32(texel % WIDTH), f32(texel / WIDTH)) + 0.5;
}

fn is_inside(place: vec2<f32>) -> bool {
    return all(place >= vec2<f32>(0.0)) && place.x < f32(WIDTH) && place.y < f32(HEIGHT);
}

fn texel_of(place: vec2<f32>) -> u32 {
    return u32(place.y) * WIDTH + u32(place.x);
}
