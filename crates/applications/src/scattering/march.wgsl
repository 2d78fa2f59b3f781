// A thread a view ray: samples of the shadow map at equal distances, moved by the noise of the pixel.

@group(0) @binding(0) var depths: texture_2d<f32>;
// Direction in light space, a unit vector, and the distance from which on nothing changes.
@group(0) @binding(1) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> shares: array<f32>;
@group(0) @binding(3) var<uniform> view: Scattering;
@group(0) @binding(4) var<storage, read> noise: array<f32>;

@compute @workgroup_size(64)
fn march(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&rays) {
        return;
    }
    let ray = rays[index];
    let step = ray.w / f32(STEPS);
    let size = vec2<f32>(textureDimensions(depths));
    let decay = exponential(-smaller(view.extinction * step, 87.0));
    let samples = STEPS;
    var t = noise[index] * step;
    var weight = 1.0;
    var lit = 0.0;
    var total = 0.0;
    for (var i = 0u; i < samples; i++) {
        let at = floor(view.origin + t * ray.xy * view.scale);
        var is_lit = true;
        if all(at >= vec2<f32>(0.0)) && all(at < size) {
            let stored = textureLoad(depths, vec2<u32>(at), 0).x;
            is_lit = stored >= 1.0 || t * ray.z <= view.near + stored * view.range;
        }
        lit = lit + select(0.0, weight, is_lit);
        total = total + weight;
        weight = weight * decay;
        t = t + step;
    }
    shares[index] = lit / total;
}
