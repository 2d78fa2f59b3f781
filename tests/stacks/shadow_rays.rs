//! Shadow rays see what the stack holds: nothing before its first layer, something behind it, masked leaves included.

use applications::rays::{Segment, Triangles};
use libtest_mimic::{Failed, Trial};
use scenes::*;
use shadow_renderer::*;

use crate::scenes::Random;

pub fn trials() -> Vec<Trial> {
    vec![Trial::test("shadow_rays::see_the_first_layer", see_the_first_layer)]
}

/// Half the distance in depth of the two points that are asked for, far above the stack's rounding.
const STEP: f64 = 2e-6;

/// Share of texels that may disagree: coverage in the stack is that of corners moved by up to 1/512 texel, which decides at
/// edges and at borders of mask texels.
const DOUBTFUL: f64 = 0.02;

/// Share of texels whose first layer the rays deny.
fn disagreeing(stack: &ShadowMapStack, frame: &LightFrame, triangles: &Triangles) -> f64 {
    let random = &mut Random(4);
    let (mut asked, mut wrong) = (0, 0);
    while asked < 3000 {
        let [x, y] = [stack.width, stack.height].map(|size| (random.unit() * size as f32) as u32);
        let Some(first) = stack.layers(x, y).next() else { continue };
        asked += 1;
        let at = |depth: f64| frame.unproject([f64::from(x) + 0.5, f64::from(y) + 0.5, depth]);
        let start = frame.eye.unwrap_or(at(-0.01));
        let occluded = [-STEP, STEP].map(|step| {
            let origin = at(f64::from(first.depth) + step);
            let direction = [0, 1, 2].map(|k| start[k] - origin[k]);
            triangles.occludes(&Segment { origin, direction, endless: false, from: None })
        });
        wrong += usize::from(occluded != [false, true]);
    }
    wrong as f64 / asked as f64
}

fn see_the_first_layer() -> Result<(), Failed> {
    let scene = load_scene("grove")?;
    let triangles = Triangles::of_scene(&scene)?;
    let positions: Vec<[f32; 3]> = scene.vertices.iter().map(|vertex| vertex.position).collect();
    let solid = Triangles::new(&positions, &scene.triangles)?;
    for name in ["oblique", "lamp"] {
        let view = scene.views.iter().find(|view| view.name == name).ok_or("no such view")?;
        let (stack, report) = render_view(&scene, view, 256, 256, Backend::Cpu)?;
        let share = disagreeing(&stack, &report.frame, &triangles);
        assert!(share <= DOUBTFUL, "{name}: {share} of the texels disagree");
        let without_masks = disagreeing(&stack, &report.frame, &solid);
        assert!(without_masks > 5.0 * DOUBTFUL, "{name}: only {without_masks} without masks");
    }
    Ok(())
}
