struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) depth: f32,
}

@vertex
fn corner(@location(0) position: vec2<f32>, @location(1) depth: f32) -> Corner {
    return Corner(vec4<f32>(position, 0.5, 1.0), depth);
}

@fragment
fn fragment(corner: Corner) -> @location(0) f32 {
    return corner.depth;
}
