//! What a file may lack: ground to receive shadows, and a camera that shows the scene.

use crate::arrays::{Mesh, SceneArrays, doubled_area, unit};
use crate::vector::{cross, dot, norm, normalize};
use crate::{AreaLight, Camera, LightView, Material, Outline, Scene};

/// Name of the material of a ground plane that was added on loading.
pub(crate) const GROUND_ADDED: &str = "ground_added";

/// Cells along each side of the grid on which ground coverage is judged.
const GROUND_CELLS: usize = 48;
/// Share of those cells that must be covered for a surface to count as ground.
const GROUND_COVERAGE: f64 = 0.6;
/// The scene's height is cut into this many slices; a ground surface lies within two neighbouring ones of the
/// lower half. Not just at the bottom: foundations and roots reach below the ground.
const SLICES: usize = 20;
/// Smallest cosine between a ground triangle's normal and the vertical.
const GROUND_UPRIGHT: f64 = 0.9;

/// Axis-aligned bounds, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Bounds {
    /// Bounds of the vertices that triangles use; `None` without triangles.
    pub(crate) fn of(arrays: &SceneArrays) -> Option<Self> {
        if arrays.triangles.is_empty() {
            return None;
        }
        let mut bounds = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
        for &index in arrays.triangles.iter().flatten() {
            let position = arrays.vertices[index as usize].position;
            let position = position.map(f64::from);
            bounds.min = std::array::from_fn(|axis| bounds.min[axis].min(position[axis]));
            bounds.max = std::array::from_fn(|axis| bounds.max[axis].max(position[axis]));
        }
        Some(bounds)
    }

    pub(crate) fn as_array(&self) -> [[f64; 3]; 2] {
        [self.min, self.max]
    }

    /// Half the diagonal.
    pub(crate) fn radius(&self) -> f64 {
        0.5 * norm(self.size())
    }

    fn size(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.max[axis] - self.min[axis])
    }

    fn centre(&self) -> [f64; 3] {
        std::array::from_fn(|axis| 0.5 * (self.max[axis] + self.min[axis]))
    }
}

/// Angular diameter in degrees and direction of the sun that every scene has.
const WIDE_SUN: (f64, [f32; 3]) = (10.0, [0.8, -0.6, 0.35]);

/// Axes of the lamp that every scene has, orthonormal, in thousandths: along the map's rows, down its columns, and the way it
/// shines.
const LAMP: [[f64; 3]; 3] = [[-960.0, 0.0, -280.0], [224.0, -600.0, -768.0], [-168.0, -800.0, 576.0]];
/// Distance of the lamp from the middle of the scene and its half size, in units of half the scene's diagonal. It sees the
/// whole scene within 42 degrees.
const LAMP_DISTANCE: f64 = 1.5;
const LAMP_HALF_SIZE: f64 = 0.05;

/// A scene of these arrays; its own area lights follow the views.
pub(crate) fn scene_of(
    arrays: SceneArrays,
    name: String,
    materials: Vec<Material>,
    mut views: Vec<LightView>,
    camera: Camera,
) -> Scene {
    views.extend(Bounds::of(&arrays).iter().flat_map(area_views));
    let bounds = Bounds::of(&arrays).map_or([[0.0; 3]; 2], |bounds| bounds.as_array());
    let SceneArrays { vertices, triangles, triangle_material, degenerate_triangles, colors, .. } = arrays;
    Scene {
        name,
        vertices,
        triangles,
        triangle_material,
        materials,
        views,
        camera,
        degenerate_triangles,
        colors,
        bounds,
        ..Scene::default()
    }
}

/// Two lights with an extent: `wide`, a sun, and `lamp`, a square, which is left out where coordinates have no room for it.
fn area_views(bounds: &Bounds) -> Vec<LightView> {
    let (degrees, direction) = WIDE_SUN;
    let wide = AreaLight::Sun { outline: Outline::Disc, degrees: [degrees; 2] };
    let radius = 0.5 * norm(bounds.size());
    // Few digits, so that the light can be written down: the power of two at or below a 64th of the radius.
    let step = f64::from_bits(radius.to_bits() & (0x7ff << 52)) / 64.0;
    let rounded = |value: f64| (value / step).round() * step;
    let [right, down, forward] = LAMP;
    let middle = bounds.centre();
    let centre = [0, 1, 2].map(|k| rounded(middle[k] - LAMP_DISTANCE * radius * forward[k] / 1000.0));
    let half = rounded(LAMP_HALF_SIZE * radius);
    let half_axes = [right, down].map(|axis| axis.map(|c| half * c / 1000.0));
    let lamp = AreaLight::local(Outline::Rectangle, centre, half_axes);
    let views = [Some(("wide", wide)), lamp.ok().map(|lamp| ("lamp", lamp))];
    views.into_iter().flatten().map(|(name, light)| LightView::new(name, light, direction)).collect()
}

/// Whether the scene brings its own ground: a used material is named like one (a word begins with "ground" or "floor", any case),
/// or triangles that face up at about one height, in the lower half of the scene, cover most of the footprint.
/// A downward face is no ground, or every box would stand on its own.
pub(crate) fn has_ground(arrays: &SceneArrays, materials: &[Material], bounds: &Bounds) -> bool {
    let named: Vec<bool> = materials
        .iter()
        .map(|material| {
            words(&material.name).any(|word| GROUND_WORDS.iter().any(|begin| word.starts_with(begin)))
        })
        .collect();
    arrays.triangle_material.iter().any(|&material| named[material as usize])
        || ground_coverage(arrays, bounds) >= GROUND_COVERAGE
}

/// How words in the names of ground materials begin.
const GROUND_WORDS: [&str; 2] = ["ground", "floor"];

/// The words of a name in small letters: what stands between other characters than letters, and begins with a capital letter
/// after a small one.
fn words(name: &str) -> impl Iterator<Item = String> {
    let mut words = vec![String::new()];
    let mut after_small = false;
    for c in name.chars() {
        if !c.is_alphabetic() || (c.is_uppercase() && after_small) {
            words.push(String::new());
        }
        after_small = c.is_lowercase();
        if let Some(word) = words.last_mut().filter(|_| c.is_alphabetic()) {
            word.extend(c.to_lowercase());
        }
    }
    words.into_iter()
}

/// Largest share of the footprint's cells whose centre lies below ground triangles of about one height.
fn ground_coverage(arrays: &SceneArrays, bounds: &Bounds) -> f64 {
    let size = bounds.size();
    if size[0] <= 0.0 || size[2] <= 0.0 {
        return 0.0;
    }
    // The second term lets an almost flat scene be its own ground whatever rounding did to its height.
    let slice_height = (size[1] / SLICES as f64).max(1e-3 * size[0].max(size[2]));
    // One bit for each slice.
    let mut covered = vec![0_u32; GROUND_CELLS * GROUND_CELLS];
    for triangle in &arrays.triangles {
        let corners = triangle.map(|index| arrays.vertices[index as usize].position);
        let area = doubled_area(corners[0], corners[1], corners[2]);
        let upright = unit(area).is_some_and(|normal| f64::from(normal[1]) >= GROUND_UPRIGHT);
        let height = corners.iter().map(|corner| f64::from(corner[1]) - bounds.min[1]).sum::<f64>() / 3.0;
        let slice = (height / slice_height) as usize;
        if !upright || slice >= SLICES / 2 {
            continue;
        }
        let cells = corners.map(|corner| {
            [0, 2].map(|axis| (f64::from(corner[axis]) - bounds.min[axis]) / size[axis] * GROUND_CELLS as f64)
        });
        cover(&cells, 1 << slice, &mut covered);
    }
    let cells_in = |slices: u32| covered.iter().filter(|&&cell| cell & slices != 0).count();
    let most = (0..SLICES / 2).map(|slice| cells_in(0b11 << slice)).max().unwrap_or(0);
    most as f64 / covered.len() as f64
}

/// Marks the cells whose centre lies in the triangle, given in cell units, of either orientation.
fn cover(corners: &[[f64; 2]; 3], mark: u32, covered: &mut [u32]) {
    let range = |axis: usize| {
        let values = corners.map(|corner| corner[axis]);
        let low = values[0].min(values[1]).min(values[2]).floor().max(0.0) as usize;
        let high = values[0].max(values[1]).max(values[2]).ceil().min(GROUND_CELLS as f64) as usize;
        low..high
    };
    let side =
        |p: [f64; 2], q: [f64; 2], x: f64, z: f64| (q[0] - p[0]) * (z - p[1]) - (q[1] - p[1]) * (x - p[0]);
    for row in range(1) {
        for column in range(0) {
            let (x, z) = (column as f64 + 0.5, row as f64 + 0.5);
            let sides = [0, 1, 2].map(|i| side(corners[i], corners[(i + 1) % 3], x, z));
            if sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0) {
                covered[row * GROUND_CELLS + column] |= mark;
            }
        }
    }
}

/// Adds a horizontal plane of material [`GROUND_ADDED`] just below the lowest point (by 1/1000 of the scene's
/// largest extent, so that it is not coplanar with a flat base), wide enough for shadows 1.5 heights long.
pub(crate) fn add_ground(arrays: &mut SceneArrays, materials: &mut Vec<Material>, bounds: &Bounds) {
    let size = bounds.size();
    let largest = size[0].max(size[1]).max(size[2]);
    let margin = 1.5 * size[1] + 0.1 * largest;
    let y = (bounds.min[1] - 1e-3 * largest) as f32;
    let (x0, x1) = ((bounds.min[0] - margin) as f32, (bounds.max[0] + margin) as f32);
    let (z0, z1) = ((bounds.min[2] - margin) as f32, (bounds.max[2] + margin) as f32);
    let plane = Mesh {
        positions: vec![[x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0]],
        normals: vec![[0.0, 1.0, 0.0]; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    arrays.push(&plane, materials.len() as u32);
    materials.push(Material { one_sided: true, ..Material::plain(GROUND_ADDED, [0.5; 3]) });
}

/// From the centre of the scene towards the fitted camera: above, and so that [`DEFAULT_LIGHT`](crate::load::DEFAULT_LIGHT) comes from the
/// left and a little from behind. Against the light a picture would show little but unlit surfaces.
const TOWARDS_CAMERA: [f64; 3] = [-0.6, 0.55, 0.6];

/// A camera above the scene, with a vertical field of view of 0.7 radians, from where all triangles just fit into a
/// picture of 16:9.
pub(crate) fn fit_camera(arrays: &SceneArrays, bounds: &Bounds) -> Camera {
    const MARGIN: f64 = 0.93;
    let vertical_fov = 0.7_f64;
    let half_height = MARGIN * (0.5 * vertical_fov).tan();
    let half = [half_height * 16.0 / 9.0, half_height];
    let back = normalize(TOWARDS_CAMERA);
    let right = normalize(cross([0.0, 1.0, 0.0], back));
    let axes = [right, cross(back, right)];
    let centre = bounds.centre();
    // A point p is seen from the eye e if |p_k - e_k| <= half_k (e_back - p_back) on both axes k: with
    // highest_k = max(p_k + half_k p_back) and lowest_k = min(p_k - half_k p_back) over all points that is
    // highest_k - half_k e_back <= e_k <= lowest_k + half_k e_back.
    let (mut highest, mut lowest) = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);
    for &index in arrays.triangles.iter().flatten() {
        let position = arrays.vertices[index as usize].position.map(f64::from);
        let p = [0, 1, 2].map(|axis| position[axis] - centre[axis]);
        for k in [0, 1] {
            let (across, towards) = (dot(p, axes[k]), half[k] * dot(p, back));
            highest[k] = highest[k].max(across + towards);
            lowest[k] = lowest[k].min(across - towards);
        }
    }
    let distance = [0, 1].map(|k| (highest[k] - lowest[k]) / (2.0 * half[k]));
    // The extent of a single point at a huge coordinate is lost to rounding: keep eye and target apart.
    let least = centre.iter().fold(1e-30, |m: f64, c| m.max(c.abs() * 1e-5));
    let distance = distance[0].max(distance[1]).max(least);
    let aside = [0, 1].map(|k| 0.5 * (highest[k] + lowest[k]));
    let target = [0, 1, 2].map(|axis| centre[axis] + aside[0] * axes[0][axis] + aside[1] * axes[1][axis]);
    let eye = std::array::from_fn(|axis| (target[axis] + distance * back[axis]) as f32);
    Camera::new(eye, target.map(|c| c as f32), vertical_fov as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(name: &str) -> Material {
        Material::plain(name, [1.0; 3])
    }

    fn quad(arrays: &mut SceneArrays, corners: [[f32; 3]; 4]) {
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        arrays.push(&Mesh { positions: corners.into(), triangles, ..Mesh::default() }, 0);
    }

    fn wall(arrays: &mut SceneArrays) {
        quad(arrays, [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [4.0, 3.0, 1.0], [0.0, 3.0, 1.0]]);
    }

    #[test]
    fn a_wide_plane_in_the_lower_half_is_ground_if_it_faces_up() {
        for (y, faces_up, expected) in [(0.1, true, true), (1.2, true, true), (0.1, false, false)] {
            let mut arrays = SceneArrays::default();
            wall(&mut arrays);
            let mut floor = [[0.0, y, 0.0], [0.0, y, 4.0], [4.0, y, 4.0], [4.0, y, 0.0]];
            if !faces_up {
                floor.reverse();
            }
            quad(&mut arrays, floor);
            let bounds = Bounds::of(&arrays).unwrap();
            assert_eq!(has_ground(&arrays, &[material("stone")], &bounds), expected, "{y} {faces_up}");
        }
    }

    #[test]
    fn a_roof_a_small_slab_or_walls_alone_are_no_ground() {
        let mut arrays = SceneArrays::default();
        wall(&mut arrays);
        quad(&mut arrays, [[0.0, 2.9, 0.0], [0.0, 2.9, 4.0], [4.0, 2.9, 4.0], [4.0, 2.9, 0.0]]);
        quad(&mut arrays, [[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [1.5, 0.0, 4.0], [1.5, 0.0, 0.0]]);
        let bounds = Bounds::of(&arrays).unwrap();
        assert!(!has_ground(&arrays, &[material("stone")], &bounds));
        assert!(has_ground(&arrays, &[material("Floor tiles")], &bounds), "a name decides");
    }

    #[test]
    fn the_added_ground_lies_below_and_faces_up() {
        let mut arrays = SceneArrays::default();
        wall(&mut arrays);
        let mut materials = vec![material("stone")];
        let bounds = Bounds::of(&arrays).unwrap();
        add_ground(&mut arrays, &mut materials, &bounds);
        assert_eq!(materials[1].name, GROUND_ADDED);
        let with_ground = Bounds::of(&arrays).unwrap();
        assert!(with_ground.min[1] < 0.0 && with_ground.min[1] > -0.01);
        assert!(with_ground.min[0] < -4.0 && with_ground.max[2] > 5.0);
        let last = arrays.triangles[3].map(|i| arrays.vertices[i as usize].position);
        assert!(doubled_area(last[0], last[1], last[2])[1] > 0.0);
        assert!(has_ground(&arrays, &materials, &with_ground));
    }

    #[test]
    fn the_fitted_camera_sees_the_whole_scene_and_not_from_afar() {
        for [width, height, length] in
            [[1.0, 1.0, 1.0], [926.0, 10.0, 118.0], [2.0, 50.0, 3.0], [8.0, 0.0, 8.0]]
        {
            let mut arrays = SceneArrays::default();
            for y in [5.0, 5.0 + height] {
                let at = |x, z| [x, y, z];
                quad(&mut arrays, [at(0.0, 0.0), at(width, 0.0), at(width, length), at(0.0, length)]);
            }
            let camera = fit_camera(&arrays, &Bounds::of(&arrays).unwrap());
            let (eye, target) = (camera.eye.map(f64::from), camera.target.map(f64::from));
            let forward = normalize([0, 1, 2].map(|k| target[k] - eye[k]));
            let right = normalize(cross(forward, [0.0, 1.0, 0.0]));
            let half = (0.5 * f64::from(camera.vertical_fov)).tan();
            let on_picture = |axis: [f64; 3], half: f64| {
                let seen = arrays.vertices.iter().map(|vertex| {
                    let p = [0, 1, 2].map(|k| f64::from(vertex.position[k]) - eye[k]);
                    dot(p, axis) / dot(p, forward) / half
                });
                seen.fold([1.0_f64, -1.0], |[low, high], s| [low.min(s), high.max(s)])
            };
            let across = on_picture(right, half * 16.0 / 9.0);
            let down = on_picture(cross(forward, right), half);
            let reaches = |[low, high]: [f64; 2]| (low + 0.93).abs() < 1e-3 && (high - 0.93).abs() < 1e-3;
            let inside = |[low, high]: [f64; 2]| low > -0.94 && high < 0.94;
            assert!(inside(across) && inside(down), "{width}: {across:?} {down:?}");
            assert!(reaches(across) || reaches(down), "{width}: {across:?} {down:?}");
        }
    }
}
