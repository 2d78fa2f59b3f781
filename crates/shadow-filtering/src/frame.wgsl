// Deferred shading of one directional light: albedo times ambient and shadowed diffuse light.

struct Light {
    // Texel x, texel y and depth of a world position p are rows . (p, 1).
    texel_x: vec4<f32>,
    texel_y: vec4<f32>,
    depth: vec4<f32>,
    // Towards the light, and the depth bias.
    towards: vec4<f32>,
    // Side of the shadow map; leak reduction.
    map: vec4<f32>,
}

@group(0) @binding(10) var<uniform> light: Light;
@group(0) @binding(11) var positions: texture_2d<f32>;
@group(0) @binding(12) var normals: texture_2d<f32>;
@group(0) @binding(13) var albedos: texture_2d<f32>;

struct Pixel {
    @location(0) colour: vec4<f32>,
    @location(1) shadow: f32,
}

fn shaded(place: vec2<i32>) -> Pixel {
    let position = textureLoad(positions, place, 0);
    let world = vec4<f32>(position.xyz, 1.0);
    let texel = vec2<f32>(dot(light.texel_x, world), dot(light.texel_y, world));
    let z_f = dot(light.depth, world) - light.towards.w;
    // Outside of control flow, where derivatives exist.
    let normal = textureLoad(normals, place, 0).xyz;
    let cast_shadow = min(shadow_at(texel, z_f, plane(normal)) / (1.0 - light.map.y), 1.0);
    if position.w == 0.0 {
        return Pixel(vec4<f32>(0.63, 0.74, 0.88, 1.0), 0.0);
    }
    // Surfaces that face away are in their own shadow.
    let shadow = select(1.0, cast_shadow, dot(normal, light.towards.xyz) > 0.0);
    let albedo = textureLoad(albedos, place, 0).rgb;
    let ambient = 0.25 * (0.65 + dot(normal, vec3<f32>(-0.12, 0.35, 0.06)));
    let diffuse = 0.75 * max(dot(normal, light.towards.xyz), 0.0) * (1.0 - shadow);
    return Pixel(vec4<f32>(srgb(albedo * (ambient + diffuse)), 1.0), shadow);
}

// Change of the tangent plane's depth from texel to texel: light space rows minus gradient times rows is along the normal.
fn plane(normal: vec3<f32>) -> vec2<f32> {
    let x = light.texel_x.xyz;
    let y = light.texel_y.xyz;
    let z = light.depth.xyz;
    let along = dot(z, normal) / dot(z, z);
    return -vec2<f32>(dot(x, normal) / dot(x, x), dot(y, normal) / dot(y, y)) / along;
}

fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let c = clamp(linear, vec3<f32>(0.0), vec3<f32>(1.0));
    return select(1.055 * pow(c, vec3<f32>(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3<f32>(0.0031308));
}
