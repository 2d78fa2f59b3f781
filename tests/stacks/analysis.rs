//! Shapes whose depths, gradients and sides are known in closed form.

use libtest_mimic::{Failed, Trial};
use shadow_renderer::*;

use crate::scenes::{Random, ground, jittered_plane, quad, scene_of};

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("analysis::tilted_plane", tilted_plane),
        Trial::test("analysis::crossing_planes", crossing_planes),
        Trial::test("analysis::sphere", sphere),
        Trial::test("analysis::watertight", watertight),
        Trial::test("analysis::margin", margin),
    ]
}

fn render(corners: &[[f32; 3]], direction: [f32; 3], size: u32) -> (ShadowMapStack, RenderReport) {
    render_stack(&scene_of(corners), direction, size, size, Backend::Cpu).unwrap()
}

/// Depth and gradient of the plane with normal `n` through `p` at texel (x, y), from the frame alone.
fn plane_at(frame: &LightFrame, p: [f64; 3], n: [f64; 3], x: u32, y: u32) -> (f64, [f64; 2]) {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let across = frame.texels_per_unit.map(|texels| dot(n, frame.forward) * frame.depth_range * texels);
    let gradient = [-dot(n, frame.right) / across[0], -dot(n, frame.down) / across[1]];
    let at = frame.project(p);
    let steps = [f64::from(x) + 0.5 - at[0], f64::from(y) + 0.5 - at[1]];
    (at[2] + gradient[0] * steps[0] + gradient[1] * steps[1], gradient)
}

fn near(name: &str, found: f64, expected: f64, tolerance: f64) -> Result<(), Failed> {
    let close = (found - expected).abs() <= tolerance;
    if close { Ok(()) } else { Err(format!("{name}: {found} instead of {expected}").into()) }
}

/// An open ground plane faces the sun from above, and turns its back to a light from below.
fn tilted_plane() -> Result<(), Failed> {
    for direction in [[0.4, -0.9, 0.2], [0.4, 0.9, 0.2], [0.0, -1.0, 0.0], [-3.0, -0.5, 1.0]] {
        let (stack, report) = render(&ground(1.0, 0.25), direction, 100);
        assert!(stack.fragments() > 500);
        for (x, y) in (0..100).flat_map(|y| (0..100).map(move |x| (x, y))) {
            let (depth, gradient) = plane_at(&report.frame, [0.0, 0.25, 0.0], [0.0, 1.0, 0.0], x, y);
            for f in stack.layers(x, y) {
                near("depth", f.depth.into(), depth.clamp(0.0, 1.0), 2e-7)?;
                near("d depth / d x", f.gradient[0].into(), gradient[0], 1e-6)?;
                near("d depth / d y", f.gradient[1].into(), gradient[1], 1e-6)?;
                assert_eq!(f.light_facing, direction[1] < 0.0, "light along {direction:?}");
            }
        }
        // The plane's area on the map, in texels.
        let area = 4.0
            * report.frame.texels_per_unit[0]
            * report.frame.texels_per_unit[1]
            * report.frame.forward[1].abs();
        near("covered texels", stack.fragments() as f64, area, 0.02 * area)?;
    }
    Ok(())
}

/// The planes x + y = 0 and x - y = 0 around the z axis, lit from above: the order changes along the axis.
fn crossing_planes() -> Result<(), Failed> {
    let slope = |s: f32| quad([[-1.0, -s, 1.0], [1.0, s, 1.0], [1.0, s, -1.0], [-1.0, -s, -1.0]]);
    let (stack, report) = render(&[slope(1.0), slope(-1.0)].concat(), [0.0, -1.0, 0.0], 128);
    let (mut texels, mut crossed) = (0, [false; 2]);
    for (x, y) in (0..128).flat_map(|y| (0..128).map(move |x| (x, y))) {
        let layers: Vec<_> = stack.layers(x, y).collect();
        if layers.is_empty() {
            continue;
        }
        texels += 1;
        let planes = [[1.0, -1.0, 0.0], [1.0, 1.0, 0.0]].map(|n| plane_at(&report.frame, [0.0; 3], n, x, y));
        assert_eq!(layers.len(), 2, "texel ({x}, {y})");
        let first = usize::from(planes[1].0 < planes[0].0);
        crossed[first] = true;
        for (layer, (depth, gradient)) in layers.iter().zip([planes[first], planes[1 - first]]) {
            assert!(layer.light_facing);
            near("depth", layer.depth.into(), depth, 2e-7)?;
            near("d depth / d x", layer.gradient[0].into(), gradient[0], 1e-6)?;
        }
    }
    assert!(texels > 10_000 && crossed == [true; 2]);
    Ok(())
}

/// Front and back of a finely tessellated unit sphere.
fn sphere() -> Result<(), Failed> {
    let (rings, sectors) = (150, 300);
    let point = |ring: usize, sector: usize| {
        let (t, p) = (
            std::f64::consts::PI * ring as f64 / rings as f64,
            std::f64::consts::TAU * (sector % sectors) as f64 / sectors as f64,
        );
        [t.sin() * p.cos(), t.cos(), -t.sin() * p.sin()].map(|c| c as f32)
    };
    let corners: Vec<_> = (0..rings * sectors)
        .flat_map(|i| {
            let (r, s) = (i / sectors, i % sectors);
            quad([point(r, s), point(r + 1, s), point(r + 1, s + 1), point(r, s + 1)])
        })
        .collect();
    let (stack, report) = render(&corners, [0.3, -0.7, -0.6], 200);
    let (frame, mut texels) = (report.frame, 0);
    let radius = frame.texels_per_unit;
    let centre = frame.project([0.0; 3]);
    for (x, y) in (0..200).flat_map(|y| (0..200).map(move |x| (x, y))) {
        let [dx, dy] =
            [(f64::from(x) + 0.5 - centre[0]) / radius[0], (f64::from(y) + 0.5 - centre[1]) / radius[1]];
        let within = 1.0 - dx * dx - dy * dy;
        if within < -0.01 {
            assert_eq!(stack.layers(x, y).len(), 0);
        }
        if within < 0.1 {
            continue;
        }
        texels += 1;
        let layers: Vec<_> = stack.layers(x, y).collect();
        assert_eq!(layers.len(), 2, "texel ({x}, {y})");
        for (layer, sign) in layers.iter().zip([-1.0, 1.0]) {
            let depth = centre[2] + sign * within.sqrt() / frame.depth_range;
            near("depth", layer.depth.into(), depth, 3e-4)?;
            let slope = radius.map(|r| -sign / (within.sqrt() * frame.depth_range * r));
            near("d depth / d x", layer.gradient[0].into(), slope[0] * dx, 0.1 * slope[0].abs())?;
            near("d depth / d y", layer.gradient[1].into(), slope[1] * dy, 0.1 * slope[1].abs())?;
            assert_eq!(layer.light_facing, sign < 0.0);
        }
    }
    assert!(texels > 20_000);
    Ok(())
}

/// Thousands of shared edges: every texel inside is covered exactly once, by one plane.
fn watertight() -> Result<(), Failed> {
    for (seed, size) in [(1, 64), (2, 200), (3, 511)] {
        let (stack, report) = render(&jittered_plane(40, &mut Random(seed)), [0.2, -1.0, 0.3], size);
        let corners = [[0.0, 0.0], [0.0, 40.0], [40.0, 40.0], [40.0, 0.0]];
        let outline = corners.map(|[x, z]| report.frame.project([x, 0.0, z]));
        for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
            // Texels from the outline, positive inside.
            let inside = (0..4).map(|i| {
                let (p, q) = (outline[i], outline[(i + 1) % 4]);
                let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
                let value = dx * (f64::from(y) + 0.5 - p[1]) - dy * (f64::from(x) + 0.5 - p[0]);
                value / dx.hypot(dy)
            });
            let inside: Vec<_> = inside.collect();
            let (least, most) = inside.iter().fold((f64::MAX, f64::MIN), |(l, m), &v| (l.min(v), m.max(v)));
            let count = stack.layers(x, y).len();
            let certainly_inside = least > 0.01 || most < -0.01;
            assert!(count <= 1, "seed {seed}: texel ({x}, {y}) is covered {count} times");
            assert!(count == 1 || !certainly_inside, "seed {seed}: texel ({x}, {y}) is a gap");
        }
    }
    Ok(())
}

/// The map's border stays empty where kernels reach over it, and the depth range is used up.
fn margin() -> Result<(), Failed> {
    let corners = crate::scenes::soup(500, &mut Random(5));
    let (stack, _) = render(&corners, [0.5, -0.5, 0.1], 128);
    let (mut used, size) = ([u32::MAX, 0], stack.width);
    for (x, y) in (0..size).flat_map(|y| (0..size).map(move |x| (x, y))) {
        if stack.layers(x, y).len() > 0 {
            used = [used[0].min(x).min(y), used[1].max(x).max(y)];
        }
    }
    assert!(used[0] >= FIT_MARGIN && used[1] < size - FIT_MARGIN, "{used:?}");
    Ok(())
}
