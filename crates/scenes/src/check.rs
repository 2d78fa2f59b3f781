//! What every rendering demands of a scene.

use rayon::prelude::*;

use crate::{InvalidScene, Scene};

impl Scene {
    /// Whether it can be rendered; alpha masks and texture coordinates, which few renderings read, are left to those.
    ///
    /// # Errors
    /// [`InvalidScene`] without triangles, with dangling indices, lists of different lengths, or positions that are not
    /// finite.
    pub fn check(&self) -> Result<(), InvalidScene> {
        check(self)
    }

    /// The error that something about this scene makes no sense.
    pub fn inconsistent(&self, what: String) -> InvalidScene {
        InvalidScene::Inconsistent { scene: self.name.clone(), what }
    }
}

fn check(scene: &Scene) -> Result<(), InvalidScene> {
    let fail = |what: String| Err(scene.inconsistent(what));
    if scene.triangles.is_empty() {
        return Err(InvalidScene::Empty(scene.name.clone()));
    }
    if scene.triangles.len() > u32::MAX as usize {
        return fail(format!("{} triangles, more than 2^32 - 1", scene.triangles.len()));
    }
    let (triangles, materials) = (scene.triangles.len(), scene.triangle_material.len());
    if materials != triangles {
        return fail(format!("{triangles} triangles have {materials} material indices"));
    }
    match first_broken(scene) {
        Some(triangle) => fail(fault_of(scene, triangle)),
        None => Ok(()),
    }
}

/// List entries checked by one task.
const CHUNK: usize = 1 << 14;

/// First triangle with a dangling index or a position that is not finite.
fn first_broken(scene: &Scene) -> Option<usize> {
    let (vertices, materials) = (&scene.vertices, scene.materials.len());
    let finite = |position: &[f32; 3]| position.iter().fold(true, |finite, c| finite & c.is_finite());
    // Reading the lists from front to back without a branch is fast, and all there is to do for a sound scene.
    let corners_exist = scene.triangles.par_chunks(CHUNK).all(|chunk| {
        let largest = chunk.iter().flatten().fold(0, |largest, &i| largest.max(i));
        (largest as usize) < vertices.len()
    });
    let materials_exist = scene.triangle_material.par_chunks(CHUNK).all(|chunk| {
        let largest = chunk.iter().fold(0, |largest, &i| largest.max(i));
        (largest as usize) < materials
    });
    let all_finite =
        || vertices.par_chunks(CHUNK).all(|c| c.iter().fold(true, |all, v| all & finite(&v.position)));
    if corners_exist && materials_exist && all_finite() {
        return None;
    }
    (&scene.triangles, &scene.triangle_material).into_par_iter().position_first(|(t, &material)| {
        let sound = |i: &u32| vertices.get(*i as usize).is_some_and(|v| finite(&v.position));
        material as usize >= materials || !t.iter().all(sound)
    })
}

/// What is wrong with a broken triangle.
fn fault_of(scene: &Scene, triangle: usize) -> String {
    let (vertices, material) = (&scene.vertices, scene.triangle_material[triangle]);
    if material as usize >= scene.materials.len() {
        return format!("triangle {triangle} has material {material} of {}", scene.materials.len());
    }
    let corners = scene.triangles[triangle];
    for vertex in corners {
        match vertices.get(vertex as usize) {
            None => return format!("triangle {triangle} has vertex {vertex} of {}", vertices.len()),
            Some(v) if !v.position.iter().all(|c| c.is_finite()) => {
                return format!("vertex {vertex} has position {:?}", v.position);
            }
            Some(_) => {}
        }
    }
    format!("triangle {triangle} is broken")
}
