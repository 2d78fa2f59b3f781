// What the camera sees: world positions (w = 1 where there is a surface), normals towards the camera, albedo.

struct Camera {
    // Clip coordinates of a world position p are rows . (p, 1).
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    w: vec4<f32>,
    eye: vec4<f32>,
}

@group(0) @binding(0) var<uniform> camera: Camera;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) albedo: vec3<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) @interpolate(flat) mask_index: u32,
    @location(5) @interpolate(flat) texture_index: u32,
}

@vertex
fn corner(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) albedo: vec3<f32>,
    @location(3) uv: vec2<f32>,
    @location(4) mask_index: u32,
    @location(5) texture_index: u32,
) -> Corner {
    let p = vec4<f32>(position, 1.0);
    let clip = vec4<f32>(dot(camera.x, p), dot(camera.y, p), dot(camera.z, p), dot(camera.w, p));
    return Corner(clip, position, normal, albedo, uv, mask_index, texture_index);
}

struct Surface {
    @location(0) position: vec4<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) albedo: vec4<f32>,
}

@fragment
fn surface(corner: Corner) -> Surface {
    // Before any pixel is given up, as neighbours take part.
    let across = dpdx(corner.uv);
    let down = dpdy(corner.uv);
    if is_masked_out(corner.mask_index, corner.uv) {
        discard;
    }
    let albedo = corner.albedo * colour(corner.texture_index, corner.uv, across, down);
    let n = normalize(corner.normal);
    let facing = select(n, -n, dot(n, corner.position - camera.eye.xyz) > 0.0);
    return Surface(vec4<f32>(corner.position, 1.0), vec4<f32>(facing, 0.0), vec4<f32>(albedo, 1.0));
}
