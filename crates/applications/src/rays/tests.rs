//! Cracks, the tree against brute force, surfaces against themselves.

use super::boxes::BoxTest;
use super::edge_test::Sheared;
use super::*;
use random_stream::Random;
use scenes::vector::minus;
use scenes::{AlphaMask, Camera, Material, Scene, Vertex};

/// Vertices and triangles of hills over `n` x `n` squares.
fn height_field(n: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut random = Random::stream(11, n as u64);
    let height = |x: f64, z: f64, r: &mut Random| 3.0 * (x * 0.7).sin() * (z * 0.4).cos() + 0.1 * r.unit();
    let at = |i: usize| 20.0 * i as f64 / n as f64 - 3.0;
    let positions = (0..(n + 1) * (n + 1))
        .map(|i| {
            let (x, z) = (at(i % (n + 1)), at(i / (n + 1)));
            [x as f32, height(x, z, &mut random) as f32, z as f32]
        })
        .collect();
    let corner = |x: usize, z: usize| (z * (n + 1) + x) as u32;
    let triangles = (0..n * n)
        .flat_map(|i| {
            let (x, z) = (i % n, i / n);
            let [a, b, c, d] = [corner(x, z), corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1)];
            [[a, c, b], [b, c, d]]
        })
        .collect();
    (positions, triangles)
}

/// A ray from above the hills through an inner vertex or the middle of an edge; it must hit, whatever the hills.
fn aimed(n: usize, positions: &[[f32; 3]], random: &mut Random) -> Segment {
    let pick = |r: &mut Random| 1 + (r.unit() * (n - 1) as f64) as usize;
    let (x, z) = (pick(random), pick(random));
    let vertex = |x: usize, z: usize| positions[z * (n + 1) + x].map(f64::from);
    let (first, second) = match (random.unit() * 4.0) as usize {
        0 => (vertex(x, z), vertex(x, z)),
        1 => (vertex(x, z), vertex(x - 1, z)),
        2 => (vertex(x, z), vertex(x, z - 1)),
        _ => (vertex(x, z - 1), vertex(x - 1, z)),
    };
    let target = [0, 1, 2].map(|k| 0.5 * (first[k] + second[k]));
    let spread = |r: &mut Random| 16.0 * r.unit() - 1.0;
    let origin = match (random.unit() * 4.0) as usize {
        0 => [target[0], 8.0, target[2]],
        1 => [spread(random), 8.0, target[2]],
        _ => [spread(random), 5.0 + 5.0 * random.unit(), spread(random)],
    };
    Segment { origin, direction: minus(target, origin), endless: true, from: None }
}

fn misses(scene: &Triangles, rays: &[Segment], meets: fn(&Sheared, &[[f32; 3]; 3]) -> Option<f64>) -> usize {
    rays.iter().filter(|ray| !scene.any(ray, meets)).count()
}

/// What one writes first: edges belong to nobody.
fn strictly_inside(sheared: &Sheared, triangle: &[[f32; 3]; 3]) -> Option<f64> {
    let edges = sheared.edges(triangle).0;
    let inside = edges.iter().all(|&e| e > 0.0) || edges.iter().all(|&e| e < 0.0);
    sheared.meets(triangle).filter(|_| inside)
}

/// Rays that the hills of 200 978 triangles do not stop although brute force says so, of `count` aimed at vertices and
/// middles of edges; and how many miss the hills, under the right test, without padding, and where edges belong to nobody.
fn slipped(count: usize) -> [usize; 4] {
    let n = 317;
    let (positions, triangles) = height_field(n);
    assert_eq!(triangles.len(), 200_978);
    let mut random = Random::stream(5, 0);
    let rays: Vec<Segment> = (0..count).map(|_| aimed(n, &positions, &mut random)).collect();
    let scene = Triangles::new(&positions, &triangles).unwrap();
    // A ray that grazes a summit may leave the hills; brute force tells.
    let leaving = misses(&scene, &rays, Sheared::meets);
    let slipped = rays.iter().filter(|ray| !scene.occludes(ray) && scene.occludes_brute_force(ray)).count();
    let unpadded = misses(&Triangles::padded(&positions, &triangles, 0.0), &rays, Sheared::meets);
    let strict = misses(&scene, &rays, strictly_inside);
    [slipped, leaving, unpadded, strict]
}

/// Rays in all; `MSM_RAYS` sets another number.
const RAYS: usize = 60_000;

/// A ray in so many may graze a summit and leave the hills.
const GRAZING: usize = 600;

#[test]
fn no_ray_slips_through_vertices_and_edges() {
    let rays = std::env::var("MSM_RAYS").map_or(RAYS, |count| count.parse().unwrap());
    let [slipped, leaving, unpadded, strict] = slipped(rays);
    assert!(slipped == 0 && leaving < rays / GRAZING, "{slipped} {leaving}");
    // Both faults let rays through.
    assert!(unpadded > leaving && strict > 1000, "{unpadded} {strict}");
}

/// Segments of all kinds, along axes, ending on vertices, from far outside, from surfaces.
#[test]
fn the_tree_answers_as_brute_force() {
    let n = 24;
    let (positions, triangles) = height_field(n);
    let scene = || Triangles::new(&positions, &triangles).unwrap();
    let (scene, portable) = (scene(), scene().testing_boxes(BoxTest::Portable));
    let mut random = Random::stream(6, 0);
    let mut hits = 0;
    let mut last = LastOccluder::default();
    for i in 0..20_000 {
        let mut ray = aimed(n, &positions, &mut random);
        match i % 8 {
            0 => {}
            1 => ray.endless = false,
            2 => ray.direction = ray.direction.map(|c| c * 1.5),
            3 => ray.direction = [0, 1, 2].map(|_| random.unit() - 0.5),
            4 => ray.direction = [ray.direction[0], 0.0, -0.0],
            5 => ray.origin = [0, 1, 2].map(|k| ray.origin[k] - 40.0 * ray.direction[k]),
            6 => (ray.endless, ray.direction) = (false, ray.direction.map(|c| c * 0.99)),
            _ => {
                let triangle = (random.unit() * triangles.len() as f64) as usize;
                let weights = [random.unit(), random.unit(), random.unit()];
                let total: f64 = weights.iter().sum();
                let corners = triangles[triangle].map(|v| positions[v as usize].map(f64::from));
                ray.origin =
                    [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * corners[c][k]).sum::<f64>() / total);
                ray.direction = [random.unit() - 0.5, random.unit(), random.unit() - 0.5];
                ray.from = Some(triangle as u32);
            }
        }
        let expected = scene.occludes_brute_force(&ray);
        assert_eq!(scene.occludes(&ray), expected, "{i} {ray:?}");
        assert_eq!(portable.occludes(&ray), expected, "{i} {ray:?}");
        assert_eq!(scene.occludes_again(&ray, &mut last), expected, "{i} {ray:?}");
        hits += usize::from(expected);
    }
    assert!((5_000..15_000).contains(&hits), "{hits}");
}

/// A receiver in the plane of a quad sees past the quad's other half.
#[test]
fn surfaces_do_not_shadow_themselves() {
    let positions = [[0.1, 0.3, 0.7], [1.1, 0.7, 0.9], [0.2, 1.3, 1.7], [1.2, 1.7, 1.9]];
    let scene = Triangles::new(&positions, &[[0, 1, 2], [2, 1, 3]]).unwrap();
    let corner = |k: usize| positions[k].map(f64::from);
    let mut random = Random::stream(2, 0);
    let mut shadowed = 0;
    for i in 0..2000 {
        // On the diagonal, or near it.
        let (s, t) = (random.unit(), if i % 2 == 0 { 0.0 } else { 1e-12 * random.unit() });
        let weights = [t, (1.0 - t) * s, (1.0 - t) * (1.0 - s)];
        let origin = [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * corner(c)[k]).sum());
        let direction = [0, 1, 2].map(|_| random.unit() - 0.5);
        let ray = Segment { origin, direction, endless: true, from: Some(0) };
        shadowed += usize::from(scene.occludes(&ray));
    }
    assert_eq!(shadowed, 0);
    let down = Segment { origin: [0.6, 1.0, 0.0], direction: [0.0, 0.0, 1.0], endless: true, from: None };
    assert!(scene.occludes(&down) && !scene.occludes(&Segment { endless: false, ..down }));
}

/// A leaf of four by four texels, every second one a hole, over a solid ground.
fn leaf_over_ground() -> Scene {
    let corner =
        |x: f32, y: f32, z: f32, uv: [f32; 2]| Vertex { position: [x, y, z], normal: [0.0, 1.0, 0.0], uv };
    let square = |y: f32| {
        [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0), (4.0, 4.0)]
            .map(|(x, z)| corner(x, y, z, [0.25 * x - 7.0, 0.25 * z]))
    };
    let alpha = (0..16).map(|t| if (t % 4 + t / 4) % 2 == 0 { 200 } else { 100 }).collect();
    let mask = AlphaMask { width: 4, height: 4, alpha, cutoff: 128 };
    let material = |mask| Material { mask, ..Material::plain("leaf", [0.5; 3]) };
    Scene {
        name: "leaf".into(),
        vertices: [square(0.0), square(1.0)].concat(),
        // The leaf has a back of its own, in the same place.
        triangles: vec![[0, 2, 1], [1, 2, 3], [4, 6, 5], [5, 6, 7], [4, 5, 6], [5, 7, 6]],
        triangle_material: vec![0, 0, 1, 1, 1, 1],
        materials: vec![material(None), material(Some(mask.into()))],
        views: Vec::new(),
        camera: Camera::new([0.0; 3], [1.0; 3], 1.0),
        ..Scene::default()
    }
}

#[test]
fn masked_texels_let_rays_through() {
    let scene = Triangles::of_scene(&leaf_over_ground()).unwrap();
    let solid = |x: f64, z: f64| (x.floor() + z.floor()) % 2.0 == 0.0;
    let mut random = Random::stream(8, 0);
    let mut through = 0;
    for _ in 0..2000 {
        let (x, z) = (4.0 * random.unit(), 4.0 * random.unit());
        let up = Segment { origin: [x, 0.0, z], direction: [0.0, 1.0, 0.0], endless: true, from: Some(0) };
        assert_eq!(scene.occludes(&up), solid(x, z), "{x} {z}");
        assert_eq!(scene.occludes_brute_force(&up), solid(x, z), "{x} {z}");
        through += usize::from(!solid(x, z));
        // A receiver near the leaf lies on it where it has a surface, and on the ground otherwise.
        let found = scene.surface_near([x, 0.6, z], [0.0, -1.0, 0.0], 0.7).unwrap();
        assert_eq!(found.triangle >= 2, solid(x, z), "{found:?}");
        // Neither the front nor the back of the leaf shadows what lies on either.
        if solid(x, z) {
            for (triangle, towards) in [(2, 1.0), (4, -1.0), (4, 1.0)] {
                let origin = [x, 1.0, z];
                let ray =
                    Segment { origin, direction: [0.1, towards, 0.2], endless: true, from: Some(triangle) };
                let expected =
                    towards < 0.0 && (0.0..=4.0).contains(&(x + 0.1)) && (0.0..=4.0).contains(&(z + 0.2));
                assert_eq!(scene.occludes(&ray), expected, "{ray:?}");
            }
        }
    }
    assert!((800..1200).contains(&through), "{through}");
    let without = Triangles::new(&[[0.0; 3], [1.0; 3], [2.0, 0.0, 0.0]], &[[0, 1, 2]]).unwrap();
    assert!(!without.masks().apply_to(0));
}

#[test]
fn bad_masks_are_named() {
    let error = |edit: &dyn Fn(&mut Scene)| {
        let mut scene = leaf_over_ground();
        edit(&mut scene);
        Triangles::of_scene(&scene).err().unwrap().to_string()
    };
    let short = AlphaMask { width: 4, height: 4, alpha: vec![1; 15], cutoff: 1 };
    let message = error(&|scene| scene.materials[1].mask = Some(short.clone().into()));
    assert_eq!(message, "alpha mask of material `leaf` has 15 values for 4x4 texels");
    let message = error(&|scene| scene.vertices[4].uv[1] = f32::NAN);
    assert!(message.starts_with("triangle 2 has an alpha mask"), "{message}");
}

/// A ceiling in the plane of a lamp, written down in single precision above or below it, hides nothing of the lamp; a panel a
/// little below does.
#[test]
fn ceilings_do_not_hide_the_lamp_in_them() {
    for height in [0.7, 1.1, 2.7] {
        let occluded = |below: f32| {
            let y = height as f32 - below;
            let positions = [[-9.0, y, -9.0], [9.0, y, -9.0], [-9.0, y, 9.0], [9.0, y, 9.0]];
            let ceiling = Triangles::new(&positions, &[[0, 1, 2], [1, 3, 2]]).unwrap();
            let mut random = Random::stream(4, 0);
            let rays = (0..500).filter(|_| {
                let origin = [4.0 * random.unit(), 0.0, 4.0 * random.unit()];
                let direction = minus([random.unit(), height, random.unit()], origin);
                ceiling.occludes(&Segment { origin, direction, endless: false, from: None })
            });
            rays.count()
        };
        assert_eq!([occluded(0.0), occluded(1e-3)], [0, 500], "{height}");
    }
}

/// A point known to three digits is put back on its triangle.
#[test]
fn surfaces_are_found_again() {
    let (positions, triangles) = height_field(40);
    let scene = Triangles::new(&positions, &triangles).unwrap();
    let mut random = Random::stream(3, 0);
    for _ in 0..500 {
        let index = random.below(triangles.len());
        let corners = triangles[index].map(|v| positions[v as usize].map(f64::from));
        let weights = [0.2 + random.unit(), 0.2 + random.unit(), 0.2 + random.unit()];
        let total: f64 = weights.iter().sum();
        let exact = [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * corners[c][k]).sum::<f64>() / total);
        let point = [exact[0], exact[1] + 1e-3 * (random.unit() - 0.5), exact[2]];
        let found = scene.surface_near(point, [0.0, -1.0, 0.0], 0.01).unwrap();
        assert_eq!(found.triangle as usize, index);
        assert!((0..3).all(|k| (found.position[k] - exact[k]).abs() < 1e-12), "{found:?} {exact:?}");
    }
    assert_eq!(scene.surface_near([0.0, 50.0, 0.0], [0.0, -1.0, 0.0], 1.0), None);
}

#[test]
fn bad_scenes_are_named_and_empty_ones_occlude_nothing() {
    let error = |p: &[[f32; 3]], t: &[[u32; 3]]| Triangles::new(p, t).err().map(|e| e.to_string());
    assert_eq!(error(&[[0.0; 3]], &[[0, 0, 1]]), Some("triangle 0 uses vertex 1 of 1".to_owned()));
    assert!(error(&[[0.0, f32::NAN, 0.0]], &[]).is_some_and(|e| e.contains("NaN")));
    let ray = Segment { origin: [0.0; 3], direction: [1.0; 3], endless: true, from: None };
    assert!(!Triangles::new(&[], &[]).unwrap().occludes(&ray));
    let point = Triangles::new(&[[1.0; 3]; 3], &[[0, 1, 2]]).unwrap();
    assert!(!point.occludes(&ray) && !point.occludes(&Segment { direction: [0.0; 3], ..ray }));
}

/// The first surface is the one that asking every triangle finds, and a part that moves is where it was moved to.
#[test]
fn first_surfaces_are_the_nearest() {
    let (positions, triangles) = height_field(40);
    let scene = Triangles::new(&positions, &triangles).unwrap();
    let mut random = Random::stream(5, 0);
    let mut hits = 0;
    for _ in 0..2000 {
        let origin = [25.0 * random.unit() - 2.0, 4.0 * random.unit() - 1.0, 25.0 * random.unit() - 2.0];
        let direction =
            [0, 1, 2].map(|k| if k == 1 { 2.0 * random.unit() - 1.6 } else { 30.0 * (random.unit() - 0.5) });
        for endless in [false, true] {
            let sheared = Sheared::new(origin, direction);
            let end = if endless { f64::INFINITY } else { 1.0 };
            let corners = |t: usize| triangles[t].map(|v| positions[v as usize]);
            let met = (0..triangles.len()).filter_map(|t| Some((sheared.meets(&corners(t))?, t as u32)));
            let nearest =
                met.filter(|(at, _)| (0.0..=end).contains(at)).min_by(|a, b| a.partial_cmp(b).unwrap());
            assert_eq!(scene.first(origin, direction, endless), nearest);
            hits += usize::from(nearest.is_some());
        }
        let posed = PosedTriangles { still: &scene, moving: Some((&scene, scenes::Pose::IDENTITY)) };
        let first = scene.first(origin, direction, false);
        assert_eq!(posed.first(origin, direction), first.map(|(at, _)| (at, false)));
    }
    assert!(hits > 500, "{hits}");
}
