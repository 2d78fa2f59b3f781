//! Scenes made from a seed, for depth complexity and not for beauty: many surfaces behind each texel of a
//! shadow map, contact shadows beside long ones, and fine structure. One unit is a metre, y is up.
//!
//! A name and a seed give the same bytes on every platform: random numbers come from SplitMix64, and
//! coordinates are computed in 64 bits and rounded to a grid of 2⁻¹⁶, which swallows the last-bit differences
//! between implementations of the sine.

mod cart;
mod glasshouse;
mod grids;
mod grove;
mod hall;
mod mesh;
mod smoke;
mod stairs;
mod village;

use crate::{Camera, LightView, Scene};
pub(crate) use cart::cart;
pub(crate) use grids::TURNING;
pub(crate) use grove::tree;
use mesh::SceneMesh;
pub(crate) use mesh::on_grid;

/// Seed with which [`load_scene`](crate::load_scene) makes procedural scenes.
pub const DEFAULT_SEED: u64 = 2015;

/// Names of the procedural scenes.
pub const NAMES: [&str; 4] = ["stairs", "village", "grove", "hall"];

/// Makes the scene called `name` (one of [`NAMES`], `grids`, `smoke` or `glasshouse`); `None` if there is no such scene.
///
/// - `stairs`: flights of stairs between colonnades and railings, a winged torus knot in flight above them.
/// - `village`: houses with walls, floors, windows and shingled roofs, fences, and a hollow tower.
/// - `grove`: branching trees with alpha-tested leaf cards.
/// - `hall`: a hall with windows, a roof of slats, benches, and a colonnade towards its open side; its camera stands inside.
///
/// - `grids`: two grids of bars over a plain and a square light right above them, `overhead`; few triangles, and not random.
/// - `smoke`: 15 translucent, textured planes between walls and pipes (BHS16 Figure 15).
/// - `glasshouse`: panes of clear and stained glass between bars, and piles of glass plates, up to 64 surfaces in a ray.
///
/// Each has its own ground, a camera, 50 to 300 thousand triangles (the last three have a few hundred) and six light views: `high`, `oblique`,
/// `long` (long shadows beside contact shadows) and `grazing` (a few degrees above the horizon) without extent, `wide`, a
/// sun of 10 degrees, and `lamp`, a rectangle in space. `grove` casts
/// leaf shadows through an alpha mask; solids are closed, so light rays cross surfaces in pairs.
pub fn procedural(name: &str, seed: u64) -> Option<Scene> {
    let (mesh, directions, camera) = match name {
        "stairs" => stairs::build(seed),
        "village" => village::build(seed),
        "grove" => grove::build(seed),
        "hall" => hall::build(seed),
        "grids" => grids::build(),
        "smoke" => smoke::build(seed),
        "glasshouse" => glasshouse::build(seed),
        _ => return None,
    };
    let mut views: Vec<LightView> = ["high", "oblique", "long", "grazing"]
        .into_iter()
        .zip(directions)
        .map(|(name, direction)| LightView::directional(name, direction))
        .collect();
    if name == "grids" {
        views.extend(grids::overhead());
    }
    Some(mesh.into_scene(name, views, camera))
}

/// What a scene's module makes: geometry, the directions of the four views, and the camera.
type Parts = (SceneMesh, [[f32; 3]; 4], Camera);
