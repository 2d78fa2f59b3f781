//! Alpha masks of triangles, asked where a ray meets one.

use std::sync::Arc;

use scenes::{AlphaMask, Scene};

use super::TriangleError;

/// Marks a triangle without mask.
const NONE: u32 = u32::MAX;

/// The masked ones of some triangles.
#[derive(Default)]
pub(super) struct Masks {
    /// For each triangle its place in `masked` or [`NONE`]; empty where nothing is masked.
    places: Vec<u32>,
    masked: Vec<Masked>,
}

struct Masked {
    uv: [[f64; 2]; 3],
    mask: Arc<AlphaMask>,
}

impl Masks {
    /// Of a scene whose indices are right.
    pub fn new(scene: &Scene) -> Result<Self, TriangleError> {
        if scene.materials.iter().all(|material| material.mask.is_none()) {
            return Ok(Self::default());
        }
        for material in &scene.materials {
            if let Some(what) = material.mask.as_ref().and_then(|mask| mask.fault()) {
                return Err(TriangleError::Mask { material: material.name.clone(), what });
            }
        }
        let mut masks = Self { places: Vec::with_capacity(scene.triangles.len()), masked: Vec::new() };
        for (triangle, (corners, &material)) in
            scene.triangles.iter().zip(&scene.triangle_material).enumerate()
        {
            let Some(mask) = &scene.materials[material as usize].mask else {
                masks.places.push(NONE);
                continue;
            };
            let uv = corners.map(|vertex| scene.vertices[vertex as usize].uv.map(f64::from));
            if !uv.iter().flatten().all(|c| c.is_finite()) {
                return Err(TriangleError::TextureCoordinates { triangle });
            }
            masks.places.push(masks.masked.len() as u32);
            masks.masked.push(Masked { uv, mask: mask.clone() });
        }
        Ok(masks)
    }

    /// Whether a triangle may have holes.
    #[inline(always)]
    pub fn apply_to(&self, triangle: u32) -> bool {
        self.places.get(triangle as usize).is_some_and(|&place| place != NONE)
    }

    /// Whether there is a surface at a point of a triangle, given by the weights of its corners, which need not sum up to 1.
    #[cold]
    pub fn pass(&self, triangle: u32, weights: [f64; 3]) -> bool {
        let Masked { uv, mask } = &self.masked[self.places[triangle as usize] as usize];
        let total: f64 = weights.iter().sum();
        let at = [0, 1].map(|k| (0..3).map(|corner| weights[corner] / total * uv[corner][k]).sum());
        mask.passes(at)
    }
}
