//! Every triangle against every texel centre, in wide integers and f64, sharing nothing with the renderer but the
//! light frame.

use scenes::*;
use shadow_renderer::*;

use crate::scenes::Case;

struct Expected {
    depth: f64,
    /// How far rounding may move the depth.
    tolerance: f64,
    light_facing: bool,
}

/// Whether a centre lies inside a triangle, all in units of 1/512 texel. Centres on an edge count as if moved by
/// (e, e^2) for an infinitesimal e: right, and if that decides nothing, down. That is the top-left rule.
fn covers(mut c: [[i128; 2]; 3], centre: [i128; 2]) -> bool {
    let area = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[1][1] - c[0][1]) * (c[2][0] - c[0][0]);
    if area < 0 {
        c.swap(1, 2);
    }
    area != 0
        && (0..3).all(|i| {
            let (p, q) = (c[i], c[(i + 1) % 3]);
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            let value = dx * (centre[1] - p[1]) - dy * (centre[0] - p[0]);
            (value, -dy, dx) > (0, 0, 0)
        })
}

/// Nearest mask texel at uv, or `None` within 1e-6 of a texel's border.
fn passes(mask: &AlphaMask, uv: [f64; 2]) -> Option<bool> {
    let mut texel = [0; 2];
    for (k, size) in [mask.width, mask.height].into_iter().enumerate() {
        let t = uv[k].rem_euclid(1.0) * f64::from(size);
        if (t - t.round()).abs() < 1e-6 && size > 1 {
            return None;
        }
        texel[k] = (t as usize).min(size as usize - 1);
    }
    Some(mask.alpha[texel[1] * mask.width as usize + texel[0]] >= mask.cutoff)
}

/// Compares `stack` with the fragments found by brute force.
pub fn check(case: &Case, stack: &ShadowMapStack) -> Result<(), String> {
    let (scene, frame) = (&case.scene, &case.frame);
    let mut doubtful = 0;
    let projected: Vec<_> = scene
        .triangles
        .iter()
        .map(|triangle| {
            let p = triangle.map(|i| frame.project(scene.vertices[i as usize].position.map(f64::from)));
            (p, p.map(|p| [0, 1].map(|k| 2 * (p[k] * 256.0 + 0.5).floor() as i128)))
        })
        .collect();
    for y in 0..frame.height {
        for x in 0..frame.width {
            let mut expected: Vec<Expected> = Vec::new();
            let mut unsure = false;
            for (index, &(p, snapped)) in projected.iter().enumerate() {
                if !covers(snapped, [i128::from(x) * 512 + 256, i128::from(y) * 512 + 256]) {
                    continue;
                }
                let [e1, e2] = [1, 2].map(|i| [0, 1, 2].map(|k| p[i][k] - p[0][k]));
                let area = e1[0] * e2[1] - e1[1] * e2[0];
                let d = [f64::from(x) + 0.5 - p[0][0], f64::from(y) + 0.5 - p[0][1]];
                let (u, v) = ((d[0] * e2[1] - d[1] * e2[0]) / area, (e1[0] * d[1] - e1[1] * d[0]) / area);
                let (triangle, material) = (scene.triangles[index], scene.triangle_material[index]);
                if let Some(mask) = &scene.materials[material as usize].mask {
                    let uv = triangle.map(|i| scene.vertices[i as usize].uv.map(f64::from));
                    let at = [0, 1].map(|k| uv[0][k] + u * (uv[1][k] - uv[0][k]) + v * (uv[2][k] - uv[0][k]));
                    // Where snapping shapes the triangle, its planes follow the snapped corners.
                    match passes(mask, at).filter(|_| area.abs() > 1.0) {
                        Some(true) => {}
                        Some(false) => continue,
                        None => unsure = true,
                    }
                }
                let [low, high] =
                    [f64::min as fn(f64, f64) -> f64, f64::max].map(|f| f(p[0][2], f(p[1][2], p[2][2])));
                // Thin triangles lose digits, and the thinnest are only known to stay within their own depths.
                let tolerance =
                    if area.abs() < 0.5 { high - low } else { 1e-9 / area.abs() } + 1.5 / 16_777_216.0;
                let depth = (p[0][2] + u * e1[2] + v * e2[2]).clamp(low, high).clamp(0.0, 1.0);
                expected.push(Expected { depth, tolerance, light_facing: area < 0.0 });
            }
            if unsure {
                doubtful += 1;
                continue;
            }
            expected.sort_by(|a, b| a.depth.total_cmp(&b.depth));
            let found: Vec<_> = stack.layers(x, y).collect();
            let texel = format!("texel ({x}, {y})");
            if found.len() != expected.len() {
                return Err(format!("{texel}: {} fragments instead of {}", found.len(), expected.len()));
            }
            for (layer, (f, e)) in found.iter().zip(&expected).enumerate() {
                let tolerance = expected.iter().map(|e| e.tolerance).fold(e.tolerance, f64::max);
                if (f64::from(f.depth) - e.depth).abs() > tolerance {
                    return Err(format!("{texel}, layer {layer}: depth {} instead of {}", f.depth, e.depth));
                }
            }
            let facing = |count: usize| format!("{texel}: {count} light-facing fragments");
            let (found, expected) = (
                found.iter().filter(|f| f.light_facing).count(),
                expected.iter().filter(|e| e.light_facing).count(),
            );
            if found != expected {
                return Err(format!("{} instead of {expected}", facing(found)));
            }
        }
    }
    let texels = frame.width * frame.height;
    if doubtful * 10 > texels {
        return Err(format!("{doubtful} of {texels} texels could not be decided"));
    }
    Ok(())
}
