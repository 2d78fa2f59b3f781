//! Small scenes, each with a reason.

use std::sync::Arc;

use scenes::*;
use shadow_renderer::*;

pub const SLANTED: [f32; 3] = [0.35, -0.8, 0.45];

/// A scene, its light frame and a name for messages.
pub struct Case {
    pub name: &'static str,
    pub scene: Scene,
    pub frame: LightFrame,
}

/// A small generator: tests must not change with a dependency's version.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }
    pub fn point(&mut self, scale: f32) -> [f32; 3] {
        [0; 3].map(|_| scale * self.signed())
    }
}

/// Triangles from corners, three each.
pub fn scene_of(corners: &[[f32; 3]]) -> Scene {
    let vertex = |&position: &[f32; 3]| Vertex { position, normal: [0.0, 1.0, 0.0], uv: [0.0; 2] };
    let count = corners.len() as u32 / 3;
    Scene {
        name: "test".into(),
        vertices: corners.iter().map(vertex).collect(),
        triangles: (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        triangle_material: vec![0; count as usize],
        materials: vec![Material::plain("grey", [0.5; 3])],
        views: vec![LightView::directional("sun", SLANTED)],
        camera: Camera::new([4.0, 3.0, 5.0], [0.0; 3], 0.8),
        ..Scene::default()
    }
}

/// Two triangles, counter-clockwise for corners given counter-clockwise.
pub fn quad(c: [[f32; 3]; 4]) -> Vec<[f32; 3]> {
    vec![c[0], c[1], c[2], c[0], c[2], c[3]]
}

/// A square in the plane y = `height`, front side up.
pub fn ground(half: f32, height: f32) -> Vec<[f32; 3]> {
    quad([[-half, height, half], [half, height, half], [half, height, -half], [-half, height, -half]])
}

/// A plane of `n` x `n` quads with jittered inner vertices: thousands of shared edges in all directions.
pub fn jittered_plane(n: usize, random: &mut Random) -> Vec<[f32; 3]> {
    let mut grid = vec![[0.0; 3]; (n + 1) * (n + 1)];
    for (i, p) in grid.iter_mut().enumerate() {
        let inner = |k: usize| k > 0 && k < n;
        let (x, z) = (i % (n + 1), i / (n + 1));
        let mut jitter = |k| if inner(k) { 0.2 * random.signed() } else { 0.0 };
        *p = [x as f32 + jitter(x), 0.0, z as f32 + jitter(z)];
    }
    let at = |x: usize, z: usize| grid[z * (n + 1) + x];
    (0..n * n)
        .flat_map(|i| {
            let (x, z) = (i % n, i / n);
            quad([at(x, z + 1), at(x + 1, z + 1), at(x + 1, z), at(x, z)])
        })
        .collect()
}

/// Random triangles from needles to large ones.
pub fn soup(count: usize, random: &mut Random) -> Vec<[f32; 3]> {
    let mut corners = Vec::new();
    for _ in 0..count {
        let (centre, size) = (random.point(1.0), random.unit().powi(4) + 0.01);
        corners.extend([0; 3].map(|_| {
            let offset = random.point(size);
            [centre[0] + offset[0], centre[1] + offset[1], centre[2] + offset[2]]
        }));
    }
    corners
}

/// Gives all triangles a mask with a hole pattern and texture coordinates far outside of [0, 1).
pub fn masked(mut scene: Scene, width: u32, height: u32, random: &mut Random) -> Scene {
    let alpha = (0..width * height).map(|_| (255.0 * random.unit()) as u8).collect();
    let mask = AlphaMask { width, height, alpha, cutoff: 128 };
    scene.materials.push(Material { mask: Some(Arc::new(mask)), ..Material::plain("leaf", [0.5; 3]) });
    for (i, material) in scene.triangle_material.iter_mut().enumerate() {
        *material = u32::from(i % 3 != 0); // some stay solid
    }
    for vertex in &mut scene.vertices {
        vertex.uv = [5.0 * random.signed(), 5.0 * random.signed() - 17.0];
    }
    scene
}

/// Every scene on which GPU, CPU and brute force have to agree.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |name, corners: Vec<[f32; 3]>, direction, width, height| {
        let scene = scene_of(&corners);
        let frame = LightFrame::fit(&scene, direction, width, height).unwrap();
        cases.push(Case { name, scene, frame });
    };
    let random = &mut Random(7);
    add("one triangle", vec![[0.0, 0.0, 0.0], [0.3, 0.1, 1.0], [1.0, 0.5, 0.0]], SLANTED, 64, 64);
    add("one texel", soup(20, random), SLANTED, 1, 1);
    add("tall map", soup(200, random), SLANTED, 37, 113);
    add("wide map", soup(200, random), SLANTED, 130, 9);
    add("vertical light", soup(200, random), [0.0, -2.0, 0.0], 64, 64);
    add("light from below", soup(200, random), [0.0, 1.0, 0.001], 64, 64);
    add("shared edges", jittered_plane(24, random), SLANTED, 96, 96);
    let mut coincident = ground(1.0, 0.0);
    coincident.extend(ground(1.0, 0.0));
    coincident.extend(ground(1.0, 0.0).into_iter().rev()); // back side up
    coincident.extend(ground(1.0, 0.0));
    add("coincident surfaces", coincident, SLANTED, 48, 48);
    let mut slivers = ground(1.0, 0.0);
    for _ in 0..200 {
        let (a, b) = (random.point(1.0), random.point(1.0));
        let c = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]) + 0.003 * random.signed());
        slivers.extend([a, b, c]);
    }
    slivers.extend([[0.0, 0.0, 0.0], [0.5, 0.5, 0.5], [1.0, 1.0, 1.0]]); // no area at all
    add("slivers", slivers, SLANTED, 80, 80);
    add(
        "many layers",
        (0..300).flat_map(|i| ground(1.0, 0.001 * (i * 37 % 300) as f32)).collect(),
        [0.1, -1.0, 0.0],
        24,
        24,
    );
    for (name, seed) in [("soup 1", 11), ("soup 2", 12), ("soup 3", 13)] {
        add(name, soup(1500, &mut Random(seed)), Random(seed).point(1.0), 100, 100);
    }

    let mut add_in_frame = |name, scene: Scene, zoom: f64, shift: [f64; 2]| {
        let mut frame = LightFrame::fit(&scene, SLANTED, 64, 64).unwrap();
        frame.texels_per_unit = frame.texels_per_unit.map(|t| t * zoom);
        for (origin, shift) in frame.origin_texel.iter_mut().zip(shift) {
            *origin = (*origin - 32.0) * zoom + 32.0 + shift;
        }
        cases.push(Case { name, scene, frame });
    };
    let mut around = ground(1.0, 0.0);
    around.extend(soup(100, random));
    add_in_frame("huge triangles", scene_of(&around), 400.0, [0.0; 2]);
    add_in_frame("partly off the map", scene_of(&soup(400, random)), 3.0, [20.0, -45.0]);
    add_in_frame("all off the map", scene_of(&soup(50, random)), 1.0, [500.0, 0.0]);
    let clamped =
        Case { name: "depths beyond 0 and 1", scene: scene_of(&soup(200, random)), ..cases.remove(0) };
    let mut frame = LightFrame::fit(&clamped.scene, SLANTED, 64, 64).unwrap();
    frame.near += 0.3 * frame.depth_range;
    frame.depth_range *= 0.4;
    cases.push(Case { frame, ..clamped });
    for (name, width, height) in [("mask 3x5", 3, 5), ("mask 64x32", 64, 32), ("mask 1x1", 1, 1)] {
        let scene = masked(scene_of(&soup(300, random)), width, height, random);
        let frame = LightFrame::fit(&scene, SLANTED, 90, 70).unwrap();
        cases.push(Case { name, scene, frame });
    }
    cases
}
