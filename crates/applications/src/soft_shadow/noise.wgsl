// Blue noise over the screen, two numbers a fragment.

@group(0) @binding(4) var<storage, read> noises: array<vec2<f32>>;

fn noise_of(fragment: u32) -> vec2<f32> {
    return noises[fragment];
}
