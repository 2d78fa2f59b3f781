//! Maps of local lights against rays through every texel centre, in light space and f64.

use libtest_mimic::{Failed, Trial};
use scenes::*;
use shadow_renderer::*;

use crate::scenes::{Case, Random, ground, jittered_plane, masked, quad, scene_of, soup};

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("local_lights::watertight", watertight),
        Trial::test("local_lights::parallel_plane", parallel_plane),
        Trial::test("local_lights::refused", refused),
        Trial::test("local_lights::flush_with_a_ceiling", flush_with_a_ceiling),
        Trial::test("local_lights::rays_find_planted_faults", rays_can_fail),
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

pub fn lamp(text: &str) -> LightView {
    LightView::new("lamp", text.parse().unwrap(), [0.0; 3])
}

/// A frame amid the scene, which no fitted frame is: much lies behind it, before its near plane, or across.
fn amid(near: f64, far: f64, zoom: f64, [width, height]: [u32; 2]) -> LightFrame {
    let scene = scene_of(&ground(1.0, -5.0));
    let view = lamp("rect:0.1,0.2,-0.1;-0.8,0,-0.6;0.48,-0.6,-0.64");
    let frame = LightFrame::of_view(&scene, &view, width, height).unwrap();
    LightFrame {
        near,
        depth_range: far - near,
        texels_per_unit: [zoom / near; 2],
        origin_texel: [0.4 * f64::from(width), 0.6 * f64::from(height)],
        ..frame
    }
}

/// Scenes on which GPU, CPU and rays have to agree.
pub fn cases() -> Vec<Case> {
    let random = &mut Random(31);
    let mut over = ground(1.5, -1.2);
    over.extend(soup(600, random));
    let over = scene_of(&over);
    let fitted = |name, scene: &Scene, text: &str, width, height| {
        let frame = LightFrame::of_view(scene, &lamp(text), width, height).unwrap();
        Case { name, scene: scene.clone(), frame }
    };
    let above = "rect:0.3,4,0.2;0.2,0,0;0,0,0.1";
    let leaves = masked(over.clone(), 16, 9, random);
    let mut around = soup(400, random);
    around.extend(ground(30.0, -1.0));
    let around = scene_of(&around);
    let turned = masked(around.clone(), 7, 3, random);
    vec![
        fitted("lamp above", &over, above, 100, 70),
        fitted("lamp at the side", &over, "disc:-5,2,1;0,0.3,0;0,0,0.3", 64, 96),
        fitted("lamp in front of much", &over, "rect:0.5,1.7,-1;-0.08,0,-0.06;0.048,-0.06,-0.064", 80, 80),
        fitted("leaves under a lamp", &leaves, above, 90, 80),
        Case { name: "amid the scene", scene: around.clone(), frame: amid(0.1, 3.0, 30.0, [96, 96]) },
        Case {
            name: "amid the scene, far off the map",
            scene: around,
            frame: amid(0.01, 40.0, 4e4, [40, 40]),
        },
        Case { name: "amid leaves", scene: turned, frame: amid(0.05, 2.0, 40.0, [90, 70]) },
    ]
}

/// Where a ray from the origin meets a triangle's plane: weights of the second and third corner, and distance.
fn meet(p: &[[f64; 3]; 3], ray: [f64; 3]) -> [f64; 3] {
    let (e1, e2) = (minus(p[1], p[0]), minus(p[2], p[0]));
    let normal = cross(e1, e2);
    let distance = dot(normal, p[0]) / dot(normal, ray);
    let from_first = minus(ray.map(|c| c * distance), p[0]);
    let size = dot(normal, normal);
    [dot(cross(from_first, e2), normal) / size, dot(cross(e1, from_first), normal) / size, distance]
}

/// How far, in texels, the snapping of corners may move an edge.
const SNAPPING: f64 = 1.5 / 256.0;

struct Ray<'a> {
    case: &'a Case,
    /// Light space.
    corners: Vec<[[f64; 3]; 3]>,
    /// Where each triangle lies on the map, least and greatest x and y, if all of it is in front of the near plane.
    bounds: Vec<Option<[[f64; 2]; 2]>>,
}

impl<'a> Ray<'a> {
    fn new(case: &'a Case) -> Self {
        let (scene, frame) = (&case.scene, &case.frame);
        let eye = frame.eye.unwrap();
        let of = |i: u32| {
            let from_eye = minus(scene.vertices[i as usize].position.map(f64::from), eye);
            [frame.right, frame.down, frame.forward].map(|axis| dot(from_eye, axis))
        };
        let corners: Vec<_> = scene.triangles.iter().map(|t| t.map(of)).collect();
        let bounds = corners.iter().map(|corners| {
            let texel = |p: &[f64; 3], k: usize| {
                p[k] / p[2] * frame.near * frame.texels_per_unit[k] + frame.origin_texel[k]
            };
            let of =
                |k: usize, f: fn(f64, f64) -> f64| corners.iter().map(|p| texel(p, k)).reduce(f).unwrap();
            let in_front = corners.iter().all(|p| p[2] >= frame.near);
            in_front.then(|| [f64::min as fn(f64, f64) -> f64, f64::max].map(|f| [of(0, f), of(1, f)]))
        });
        let bounds = bounds.collect();
        Self { case, corners, bounds }
    }

    /// Whether a triangle lies more than a texel off a position.
    fn is_far(&self, index: usize, texel: [f64; 2]) -> bool {
        self.bounds[index]
            .is_some_and(|[low, high]| (0..2).any(|k| texel[k] < low[k] - 1.0 || texel[k] > high[k] + 1.0))
    }

    /// Through a position on the map.
    fn direction(&self, texel: [f64; 2]) -> [f64; 3] {
        let frame = &self.case.frame;
        let slope = |k: usize| (texel[k] - frame.origin_texel[k]) / (frame.texels_per_unit[k] * frame.near);
        [slope(0), slope(1), 1.0]
    }

    /// Depth and side of a triangle at a texel, `None` if it is not there, and whether that is certain.
    fn at(&self, index: usize, x: u32, y: u32) -> (Option<(f64, bool)>, bool) {
        let (scene, frame) = (&self.case.scene, &self.case.frame);
        let p = &self.corners[index];
        let inside = |texel: [f64; 2]| {
            let [u, v, distance] = meet(p, self.direction(texel));
            u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance >= frame.near
        };
        let centre = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        if self.is_far(index, centre) {
            return (None, true);
        }
        let here = inside(centre);
        // Moved by as much as corners are, all around.
        let around = (0..8).map(|i| f64::from(i) * std::f64::consts::FRAC_PI_4);
        let mut certain = around
            .map(|angle| inside([centre[0] + SNAPPING * angle.cos(), centre[1] + SNAPPING * angle.sin()]))
            .all(|moved| moved == here);
        let ray = self.direction(centre);
        let [u, v, distance] = meet(p, ray);
        let normal = cross(minus(p[1], p[0]), minus(p[2], p[0]));
        // Edge-on, all digits are lost.
        certain &= dot(normal, ray).abs() > 1e-3 * dot(normal, normal).sqrt() * dot(ray, ray).sqrt() || !here;
        let material = &scene.materials[scene.triangle_material[index] as usize];
        if let Some(mask) = material.mask.as_ref().filter(|_| here) {
            let uv = scene.triangles[index].map(|i| scene.vertices[i as usize].uv.map(f64::from));
            let mut texel = [0; 2];
            for (k, size) in [mask.width, mask.height].into_iter().enumerate() {
                let t = uv[0][k] + u * (uv[1][k] - uv[0][k]) + v * (uv[2][k] - uv[0][k]);
                let t = t.rem_euclid(1.0) * f64::from(size);
                certain &= (t - t.round()).abs() > 1e-5;
                texel[k] = (t as usize).min(size as usize - 1);
            }
            if mask.alpha[texel[1] * mask.width as usize + texel[0]] < mask.cutoff {
                return (None, certain);
            }
        }
        let depth = ((distance - frame.near) / frame.depth_range).clamp(0.0, 1.0);
        (here.then_some((depth, dot(normal, p[0]) < 0.0)), certain)
    }
}

/// Compares `stack` with what rays find.
pub fn check(case: &Case, stack: &ShadowMapStack) -> Result<(), String> {
    let rays = Ray::new(case);
    let (mut compared, mut doubtful) = (0, 0);
    for (x, y) in (0..stack.height).flat_map(|y| (0..stack.width).map(move |x| (x, y))) {
        let all: Vec<_> = (0..rays.corners.len()).map(|index| rays.at(index, x, y)).collect();
        if all.iter().any(|found| !found.1) {
            doubtful += 1;
            continue;
        }
        let mut expected: Vec<(f64, bool)> = all.into_iter().filter_map(|found| found.0).collect();
        expected.sort_by(|a, b| a.0.total_cmp(&b.0));
        let found: Vec<Fragment> = stack.layers(x, y).collect();
        let texel = format!("texel ({x}, {y})");
        if found.len() != expected.len() {
            return Err(format!("{texel}: {} fragments instead of {}", found.len(), expected.len()));
        }
        compared += found.len();
        for (layer, (f, e)) in found.iter().zip(&expected).enumerate() {
            // One rounding of depth, and one of planes where they are steep.
            if (f64::from(f.depth) - e.0).abs() > 2.0 / 16_777_216.0 {
                return Err(format!("{texel}, layer {layer}: depth {} instead of {}", f.depth, e.0));
            }
        }
        let sides =
            [found.iter().filter(|f| f.light_facing).count(), expected.iter().filter(|e| e.1).count()];
        if sides[0] != sides[1] {
            return Err(format!("{texel}: {} light-facing fragments instead of {}", sides[0], sides[1]));
        }
    }
    let texels = stack.width * stack.height;
    if doubtful * 2 > texels || compared < 1000 {
        return Err(format!("{doubtful} of {texels} texels in doubt, {compared} fragments compared"));
    }
    Ok(())
}

fn rays_can_fail() -> Result<(), Failed> {
    let case = cases().swap_remove(0);
    let (stack, _) = render_in_frame(&case.scene, &case.frame, Backend::Cpu)?;
    check(&case, &stack)?;
    let mut deeper = stack.clone();
    deeper.depths.iter_mut().for_each(|d| *d = (*d + 4e-7).min(1.0));
    let mut turned = stack.clone();
    turned.light_facing = stack.light_facing.iter().map(|bit| !bit).collect();
    // Depths that would be linear over the map.
    let shifted = LightFrame { origin_texel: case.frame.origin_texel.map(|t| t + 0.02), ..case.frame };
    let (moved, _) = render_in_frame(&case.scene, &shifted, Backend::Cpu)?;
    for (name, faulty) in [("depth", deeper), ("side", turned), ("position", moved)] {
        if check(&case, &faulty).is_ok() {
            return Err(format!("rays missed a wrong {name}").into());
        }
    }
    Ok(())
}

/// Thousands of shared edges, many of them cut by the near plane or far off the map: each ray that meets the plane in front
/// of the near plane meets it once.
fn watertight() -> Result<(), Failed> {
    for (seed, zoom, near) in [(1, 30.0, 0.3), (2, 45.0, 0.9), (3, 3000.0, 0.05)] {
        let mut scene = scene_of(&jittered_plane(40, &mut Random(seed)));
        for vertex in &mut scene.vertices {
            vertex.position = [vertex.position[0] - 20.0, -1.5, vertex.position[2] - 20.0];
        }
        let frame = amid(near, 30.0, zoom, [128, 100]);
        let (stack, _) = render_in_frame(&scene, &frame, Backend::Cpu)?;
        stack.validate()?;
        let mut covered = 0;
        for (x, y) in (0..100).flat_map(|y| (0..128).map(move |x| (x, y))) {
            let at = |depth| frame.unproject([f64::from(x) + 0.5, f64::from(y) + 0.5, depth]);
            let (start, end) = (at(0.0), at(1.0));
            // The plane's distance along the ray, in units of the depth range from the near plane on.
            let t = (-1.5 - start[1]) / (end[1] - start[1]);
            let met = [0, 2].map(|k| start[k] + t * (end[k] - start[k]));
            let within = met.iter().all(|c| c.abs() < 19.9) && t > 1e-3;
            let outside = met.iter().any(|c| c.abs() > 20.1) || t < -1e-3;
            let count = stack.layers(x, y).len();
            assert!(count <= 1, "seed {seed}: texel ({x}, {y}) is covered {count} times");
            assert!(count == 1 || !within, "seed {seed}: texel ({x}, {y}) is a gap");
            assert!(count == 0 || !outside, "seed {seed}: texel ({x}, {y}) is covered");
            covered += count;
        }
        assert!(covered > 2000, "{covered}");
    }
    Ok(())
}

/// A plane parallel to the light has one depth, an inclined one the gradient of its frame.
fn parallel_plane() -> Result<(), Failed> {
    let mut corners = ground(2.0, 0.0);
    corners.extend(quad([[-1.0, 0.5, 1.0], [1.0, 0.5, 1.0], [1.0, 1.5, -1.0], [-1.0, 1.5, -1.0]]));
    let scene = scene_of(&corners);
    let (stack, report) = render_view(&scene, &lamp("disc:0,4,0;1,0,0;0,0,0.5"), 128, 96, Backend::Cpu)?;
    let frame = report.frame;
    let (mut planes, mut slopes) = (0, 0);
    for (x, y) in (0..96).flat_map(|y| (0..128).map(move |x| (x, y))) {
        for f in stack.layers(x, y) {
            assert!(f.light_facing);
            let at = [f64::from(x) + 0.5, f64::from(y) + 0.5, f64::from(f.depth)];
            let position = frame.unproject(at);
            let normal = if f.depth == 1.0 { [0.0, 1.0, 0.0] } else { [0.0, 2.0, 1.0] };
            let expected = frame.gradient(position, normal);
            for k in 0..2 {
                let error = (f64::from(f.gradient[k]) - expected[k]).abs();
                assert!(error < 2e-6, "{f:?} {expected:?}");
            }
            if f.depth == 1.0 {
                assert!(position[1].abs() < 1e-6 && f.gradient[0].abs() < 1e-7, "{f:?}");
                planes += 1;
            } else {
                assert!((2.0 * position[1] + position[2] - 2.0).abs() < 1e-5, "{position:?}");
                slopes += 1;
            }
        }
    }
    // The lamp sees the plane within 27 degrees, so that it fills the map up to the margin.
    assert!(planes == (128 - 10) * (96 - 10) && slopes > 1000, "{planes} {slopes}");
    Ok(())
}

/// Lights inside and behind the scene, with one line that tells why.
fn refused() -> Result<(), Failed> {
    let scene = scene_of(&ground(1.0, 0.0));
    let message = |scene: &Scene, text: &str| {
        let error = render_view(scene, &lamp(text), 64, 64, Backend::Cpu).expect_err("must fail");
        assert!(matches!(error, RenderError::Light(_)), "{error}");
        let message = error.to_string();
        assert!(!message.contains('\n'));
        message
    };
    // U x V points upwards, away from the ground; then to the side of it.
    for text in ["rect:0,1,0;0,0,1;1,0,0", "rect:0,-3,0;1,0,0;0,0,1", "disc:2,1,0;0,1,0;0,0,1"] {
        let message = message(&scene, text);
        assert!(message.contains("behind the scene") && message.contains(text), "{message}");
    }
    // A wall through the light beside its middle, and one through the middle.
    let wall = |x: f32| {
        let mut corners = ground(1.0, -2.0);
        corners.extend([[x, -1.0, -1.0], [x, 1.0, -1.0], [x, 0.0, 1.0]]);
        scene_of(&corners)
    };
    for x in [0.0, 0.4] {
        let message = message(&wall(x), "rect:0,0,0;0.5,0,0;0,0,0.5");
        assert!(message.contains("inside the scene: triangle 2"), "{message}");
    }
    assert!(message(&wall(0.4), "disc:0,0,0;0.5,0,0;0,0,0.5").contains("triangle 2"));
    // Beside the light all is well; a square on its corner is wider than the disc in it.
    render_view(&wall(0.6), &lamp("rect:0,0,0;0.5,0,0;0,0,0.5"), 64, 64, Backend::Cpu)?;
    render_view(&wall(0.6), &lamp("disc:0,0,0;0.4,0,0.4;-0.4,0,0.4"), 64, 64, Backend::Cpu)?;
    assert!(message(&wall(0.6), "rect:0,0,0;0.4,0,0.4;-0.4,0,0.4").contains("triangle 2"));
    // So close below the middle that the map would lose what is far.
    let mut close = ground(1.0, -1e-4);
    close.extend(ground(1.0, -2.0));
    let message = message(&scene_of(&close), "rect:0,0,0;0.1,0,0;0,0,0.1");
    assert!(message.contains("inside the scene: triangle 0 is 1.00e-4"), "{message}");
    let flat = DepthMap::render(&scene, &amid(0.1, 1.0, 30.0, [32, 32]), Sampling::Single);
    assert!(matches!(flat, Err(RenderError::Perspective)));
    Ok(())
}

/// A ceiling in the light's own plane is behind it.
fn flush_with_a_ceiling() -> Result<(), Failed> {
    let mut corners = ground(1.0, 0.0);
    corners.extend(ground(3.0, 1.1));
    let (stack, report) =
        render_view(&scene_of(&corners), &lamp("rect:0,1.1,0;0.2,0,0;0,0,0.2"), 64, 64, Backend::Cpu)?;
    assert_eq!(stack.layer_statistics().max, 1);
    assert!((report.frame.near - 1.1).abs() < 1e-6, "{:?}", report.frame);
    Ok(())
}
