// Deferred shading as a compute pass, a thread a pixel.

@group(0) @binding(20) var colour: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(21) var shadow: texture_storage_2d<r32float, write>;

fn texel_of(place: vec2<i32>) -> vec2<f32> {
    let world = vec4<f32>(textureLoad(positions, place, 0).xyz, 1.0);
    return vec2<f32>(dot(light.texel_x, world), dot(light.texel_y, world));
}

@compute @workgroup_size(8, 8)
fn shade_pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    let place = vec2<i32>(id.xy);
    let size = vec2<i32>(textureDimensions(positions));
    if any(place >= size) {
        return;
    }
    // Derivatives as hardware takes them for texels: one for a quad of pixels.
    let even = place & vec2<i32>(-2);
    let odd = min(even + 1, size - 1);
    across = texel_of(vec2<i32>(odd.x, even.y)) - texel_of(even);
    down = texel_of(vec2<i32>(even.x, odd.y)) - texel_of(even);
    let found = shaded(place);
    textureStore(colour, place, found.colour);
    textureStore(shadow, place, vec4<f32>(found.shadow, 0.0, 0.0, 0.0));
}
