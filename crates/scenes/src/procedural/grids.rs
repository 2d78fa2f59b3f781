//! Two grids of bars over a plain, the upper one larger (SSSM15 Figure 14): what light the lower one lets through depends on
//! which parts of the light the upper one hides.

use super::Parts;
use super::mesh::{Place, SceneMesh};
use crate::{AreaLight, Camera, LightView, Outline};

/// Height, half size, bars across and half width of a bar in metres.
struct Grid {
    height: f64,
    half: f64,
    bars: usize,
    bar: f64,
}

const LOWER: Grid = Grid { height: 1.2, half: 1.6, bars: 7, bar: 0.11 };
const UPPER: Grid = Grid { height: 4.0, half: 3.4, bars: 5, bar: 0.42 };

/// Material of the grid that turns.
pub(crate) const TURNING: &str = "turning";

/// Nothing in it is random.
pub(super) fn build() -> Parts {
    let mut scene = SceneMesh::default();
    let ground = scene.material("ground", [0.62, 0.60, 0.55], None);
    let lower = scene.material("grid", [0.25, 0.35, 0.55], None);
    let upper = scene.material(TURNING, [0.55, 0.30, 0.20], None);
    scene.ground(ground, 6.0, 4);
    for (grid, material) in [(LOWER, lower), (UPPER, upper)] {
        bars(&mut scene, material, &grid);
    }
    let views = [[0.1, -1.0, 0.15], [0.8, -0.6, 0.35], [0.55, -0.26, 0.8], [0.06, -0.07, 0.99]];
    (scene, views, Camera::new([0.5, 9.5, 8.0], [0.0, 0.4, 0.2], 0.7))
}

/// Bars along both axes, those of the second a little above the first: no two surfaces coincide.
fn bars(scene: &mut SceneMesh, material: u32, grid: &Grid) {
    let place = Place::new([0.0; 3], 0.0);
    let Grid { height, half, bars, bar } = *grid;
    for i in 0..bars {
        let at = (2.0 * i as f64 / (bars - 1) as f64 - 1.0) * (half - bar);
        scene.block(material, &place, [at - bar, height, -half], [at + bar, height + 0.05, half]);
        scene.block(material, &place, [-half, height + 0.06, at - bar], [half, height + 0.11, at + bar]);
    }
}

/// A square light right above.
pub(super) fn overhead() -> Option<LightView> {
    let light =
        AreaLight::local(Outline::Rectangle, [0.0, 9.0, 0.0], [[1.2, 0.0, 0.0], [0.0, 0.0, 1.2]]).ok()?;
    Some(LightView::new("overhead", light, [0.0, -1.0, 0.0]))
}
