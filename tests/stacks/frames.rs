//! The camera's view of known shapes.

use libtest_mimic::{Failed, Trial};
use scenes::*;
use shadow_renderer::*;

use crate::scenes::{Random, ground, masked, quad, scene_of, soup};

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("frames::ground_and_shadow", ground_and_shadow),
        Trial::test("frames::a_sphere_does_not_shadow_its_lit_side", sphere),
        Trial::test("frames::clipped_by_the_camera", clipped_by_the_camera),
        Trial::test("frames::threads", threads),
        Trial::test("frames::bad_cameras", bad_cameras),
    ]
}

/// A square casting its shadow straight down onto a plane.
fn ground_and_shadow() -> Result<(), Failed> {
    let mut scene = scene_of(&[ground(4.0, 0.0), ground(1.0, 2.0)].concat());
    scene.camera = Camera::new([0.0, 6.0, 7.0], [0.0; 3], 0.9);
    let down = [0.0, -1.0, 0.0];
    let frame = Frame::render(&scene, 160, 120)?;
    let (stack, report) = render_stack(&scene, down, 256, 256, Backend::Cpu)?;
    let visibility = frame.hard_shadow(&stack, &report.frame);
    let picture = frame.shade(&LightView::directional("down", down), &visibility);
    let (mut lit, mut shadowed) = (0, 0);
    for (i, &triangle) in frame.triangle.iter().enumerate() {
        if triangle == NO_TRIANGLE {
            continue;
        }
        let [x, y, z] = frame.position[i];
        let height = if triangle < 2 { 0.0 } else { 2.0 };
        assert!((y - height).abs() < 1e-5 && frame.normal[i] == [0.0, 1.0, 0.0]);
        let border = (x.abs().max(z.abs()) - 1.0).abs() < 0.05 || x.abs().max(z.abs()) > 3.9;
        let expected = if triangle < 2 && x.abs().max(z.abs()) < 1.0 { 0.0 } else { 1.0 };
        assert!(border || visibility[i] == expected, "({x}, {y}, {z}): {}", visibility[i]);
        *(if visibility[i] == 0.0 { &mut shadowed } else { &mut lit }) += 1;
        let grey = picture.get_pixel(i as u32 % 160, i as u32 / 160).0;
        assert_eq!(grey[0], if visibility[i] == 0.0 { 99 } else { 188 });
    }
    assert!(lit > 5000 && shadowed > 300, "{lit} lit, {shadowed} in shadow");
    Ok(())
}

/// Facets of a sphere that turn away from the light do not lie in the shadow of the next one: no dark dots before the terminator.
fn sphere() -> Result<(), Failed> {
    const RINGS: usize = 60;
    let point = |ring: usize, sector: usize| {
        let angle = |i: usize, n: usize| std::f32::consts::PI * i as f32 / n as f32;
        let (polar, turn) = (angle(ring, RINGS), 2.0 * angle(sector, 2 * RINGS));
        [polar.sin() * turn.cos(), polar.cos(), -polar.sin() * turn.sin()]
    };
    let mut corners = Vec::new();
    for i in 0..RINGS * 2 * RINGS {
        let (ring, sector) = (i / (2 * RINGS), i % (2 * RINGS));
        let [a, b] = [ring, ring + 1].map(|ring| [sector, sector + 1].map(|sector| point(ring, sector)));
        corners.extend(quad([a[0], b[0], b[1], a[1]]));
    }
    let mut scene = scene_of(&corners);
    for vertex in &mut scene.vertices {
        vertex.normal = vertex.position;
    }
    let local = AreaLight::local(Outline::Disc, [3.0, 4.0, -1.0], [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])?;
    for view in
        [LightView::directional("sun", [0.8, -0.6, 0.35]), LightView::new("lamp", local, [-3.0, -4.0, 1.0])]
    {
        let (stack, report) = render_view(&scene, &view, 512, 512, Backend::Cpu)?;
        let mut lit = 0;
        for eye in [[4.0, 3.0, 5.0], [-4.0, 3.0, -5.0], [-5.0, -1.0, 2.0]] {
            let camera = Camera::new(eye, [0.0; 3], 0.5);
            let frame = Frame::render_from(&scene, &camera, [320, 240])?;
            let visibility = frame.hard_shadow(&stack, &report.frame);
            for (i, &visible) in visibility.iter().enumerate() {
                // Also the normal, but for facets that are seen from within at the outline.
                let position = frame.position[i].map(f64::from);
                let arriving = report.frame.arriving(position);
                let cosine = -(0..3).map(|k| arriving[k] * position[k]).sum::<f64>();
                if frame.triangle[i] != NO_TRIANGLE && cosine > 0.1 {
                    assert!(visible == 1.0, "{}: {position:?} is dark at {cosine:.3}", view.name);
                    lit += 1;
                }
            }
        }
        assert!(lit > 10_000, "{lit} pixels in the light");
    }
    Ok(())
}

/// A camera within a room sees walls in every pixel, though all of them reach behind it.
fn clipped_by_the_camera() -> Result<(), Failed> {
    let mut corners = Vec::new();
    for k in 0..3 {
        for side in [-1.0, 1.0] {
            let corner = |a: f32, b: f32| {
                let mut p = [0.0; 3];
                (p[k], p[(k + 1) % 3], p[(k + 2) % 3]) = (5.0 * side, 5.0 * a, 5.0 * b);
                p
            };
            corners.extend(quad([
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ]));
        }
    }
    let mut scene = scene_of(&corners);
    for vertex in &mut scene.vertices {
        vertex.normal = [0.0; 3]; // falls back to the geometric normal
    }
    for target in [[1.0, 0.2, 0.3], [-4.9, 0.0, 0.0], [0.1, 4.0, 0.0], [0.0, -1.0, 0.0], [-3.0, -2.0, 4.0]] {
        scene.camera = Camera::new([0.3, -0.4, 0.2], target, 1.8);
        let frame = Frame::render(&scene, 101, 67)?;
        assert!(frame.covered().all(|c| c), "looking at {target:?}");
        for (p, n) in frame.position.iter().zip(&frame.normal) {
            let wall = (0..3).max_by(|&a, &b| p[a].abs().total_cmp(&p[b].abs())).unwrap();
            assert!((p[wall].abs() - 5.0).abs() < 1e-4, "{p:?}");
            let inwards = n.iter().zip(p).map(|(n, p)| n * p).sum::<f32>() < 0.0;
            assert!(inwards && (n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5, "{n:?} at {p:?}");
        }
    }
    Ok(())
}

fn threads() -> Result<(), Failed> {
    let random = &mut Random(21);
    let scene = masked(scene_of(&soup(400, random)), 7, 5, random);
    let expected = Frame::render(&scene, 90, 77)?;
    assert!(expected.covered().filter(|c| *c).count() > 500);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    assert!(one.install(|| Frame::render(&scene, 90, 77))? == expected);
    Ok(())
}

fn bad_cameras() -> Result<(), Failed> {
    let good = scene_of(&ground(1.0, 0.0));
    let eye = good.camera.eye;
    let cameras = [
        Camera { eye: [f32::NAN, 0.0, 0.0], ..good.camera },
        Camera { target: eye, ..good.camera },
        Camera { vertical_fov: 0.0, ..good.camera },
        Camera { vertical_fov: 3.2, ..good.camera },
        Camera { vertical_fov: f32::NAN, ..good.camera },
    ];
    for camera in cameras {
        let error = Frame::render(&Scene { camera, ..good.clone() }, 8, 8);
        assert!(matches!(error, Err(RenderError::Camera(_))), "{camera:?}");
    }
    assert!(matches!(Frame::render(&good, 0, 8), Err(RenderError::MapSize { .. })));
    Ok(())
}
