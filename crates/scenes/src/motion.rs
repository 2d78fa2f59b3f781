//! Scenes of which a part moves as one: the figure above the stairs, a cart around the tower of the village, a tree of the
//! grove in the wind, the upper one of two grids.

use std::borrow::Cow;
use std::f64::consts::TAU;

use crate::error::SceneError;
use crate::procedural::{self, on_grid};
use crate::vector::{dot, minus};
use crate::{LightView, Scene, load_scene};

/// A rigid movement: world = R p + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    rotation: [[f64; 3]; 3],
    offset: [f64; 3],
}

impl Pose {
    /// Where the part is modelled.
    pub const IDENTITY: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], offset: [0.0; 3] };

    /// Turned by an angle in radians about the y (1) or z (2) axis through `pivot`, then moved.
    fn about(axis: usize, angle: f64, pivot: [f64; 3], moved: [f64; 3]) -> Self {
        let (sin, cos) = angle.sin_cos();
        let mut rotation = Self::IDENTITY.rotation;
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        rotation[a][a] = cos;
        rotation[a][b] = -sin;
        rotation[b][a] = sin;
        rotation[b][b] = cos;
        let offset = [0, 1, 2].map(|k| pivot[k] + moved[k] - dot(rotation[k], pivot));
        Self { rotation, offset }
    }

    /// World position of a point of the part.
    pub fn position(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| dot(self.rotation[k], p) + self.offset[k])
    }

    /// World direction of a direction of the part.
    pub fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| dot(row, v))
    }

    /// The point of the part at a world position.
    pub fn part_position(&self, p: [f64; 3]) -> [f64; 3] {
        self.part_direction(minus(p, self.offset))
    }

    /// The direction of the part along a world direction.
    pub fn part_direction(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (0..3).map(|row| self.rotation[row][k] * v[row]).sum())
    }
}

/// How a part moves.
#[derive(Clone, Copy, Debug)]
enum Motion {
    /// It turns about its vertical axis, rising and sinking.
    Hover { pivot: [f64; 3] },
    /// It drives around the world's vertical axis.
    Circle,
    /// It leans to one side and the other.
    Sway { pivot: [f64; 3] },
}

/// Degrees a frame of what turns.
const TURN: f64 = 1.5;
/// Height in metres to which a hovering figure rises, and the frames of a period.
const RISE: (f64, f64) = (0.4, 40.0);
/// Largest inclination in degrees of a swaying tree, and the frames of a period.
const SWAY: (f64, f64) = (3.0, 24.0);

impl Motion {
    fn pose(self, frame: usize) -> Pose {
        let frame = frame as f64;
        match self {
            Self::Hover { pivot } => {
                let (rise, period) = RISE;
                let moved = [0.0, rise * (TAU * frame / period).sin(), 0.0];
                Pose::about(1, (TURN * frame).to_radians(), pivot, moved)
            }
            Self::Circle => Pose::about(1, (TURN * frame).to_radians(), [0.0; 3], [0.0; 3]),
            Self::Sway { pivot } => {
                let (most, period) = SWAY;
                Pose::about(2, (most * (TAU * frame / period).sin()).to_radians(), pivot, [0.0; 3])
            }
        }
    }
}

/// A scene with, perhaps, a part that moves from frame to frame.
#[derive(Clone, Debug)]
pub struct MovingScene {
    still: Scene,
    part: Option<(Scene, Motion)>,
}

/// Colour of a vertex that has none.
const WHITE: [f32; 4] = [1.0; 4];

/// Material of the figure above the stairs.
const FIGURE: &str = "knot";

/// Number of the tree that sways: the one that is nearest to the camera.
const SWAYING: usize = 15;

impl MovingScene {
    /// Reads a scene. Procedural ones have a part that moves, those of files stand still.
    ///
    /// # Errors
    /// As [`load_scene`].
    pub fn load(spec: &str) -> Result<Self, SceneError> {
        let scene = load_scene(spec)?;
        let of_material = |name: &str| {
            let is_meant: Vec<bool> = scene.materials.iter().map(|m| m.name == name).collect();
            split(&scene, |triangle| is_meant[scene.triangle_material[triangle] as usize])
        };
        Ok(match spec {
            "stairs" => {
                let (still, part) = of_material(FIGURE);
                let motion = Motion::Hover { pivot: middle(&part) };
                Self { still, part: Some((part, motion)) }
            }
            "grids" => {
                let (still, part) = of_material(procedural::TURNING);
                Self { still, part: Some((part, Motion::Circle)) }
            }
            "village" => {
                let part = procedural::cart();
                Self { still: scene, part: Some((part, Motion::Circle)) }
            }
            "grove" => {
                let tree = procedural::tree(procedural::DEFAULT_SEED, SWAYING);
                let (still, part) = split(&scene, |triangle| tree.contains(&triangle));
                let [x, _, z] = middle(&part);
                Self { still, part: Some((part, Motion::Sway { pivot: [x, 0.0, z] })) }
            }
            _ => Self::resting(scene),
        })
    }

    /// A scene of which nothing moves.
    pub fn resting(scene: Scene) -> Self {
        Self { still: scene, part: None }
    }

    /// The scene with its part where it is modelled, at rest.
    pub fn at_rest(self) -> Self {
        match &self.part {
            None => self,
            Some(_) => Self::resting(self.at(0).into_owned()),
        }
    }

    /// Whether anything moves.
    pub fn has_motion(&self) -> bool {
        self.part.is_some()
    }

    /// What stands still, with the views and the camera of the whole.
    pub fn still(&self) -> &Scene {
        &self.still
    }

    /// What moves, where it is modelled.
    pub fn part(&self) -> Option<&Scene> {
        self.part.as_ref().map(|(part, _)| part)
    }

    /// Where the part is in a frame.
    pub fn pose(&self, frame: usize) -> Pose {
        self.part.as_ref().map_or(Pose::IDENTITY, |(_, motion)| motion.pose(frame))
    }

    /// Whether a triangle of [`MovingScene::at`] belongs to the part.
    pub fn moves(&self, triangle: u32) -> bool {
        triangle as usize >= self.still.triangles.len()
    }

    /// The view of a name.
    pub fn view(&self, name: &str) -> Option<&LightView> {
        self.still.views.iter().find(|view| view.name == name)
    }

    /// The whole scene in a frame: triangles that stand still, then those of the part.
    pub fn at(&self, frame: usize) -> Cow<'_, Scene> {
        let Some((part, motion)) = &self.part else { return Cow::Borrowed(&self.still) };
        let pose = motion.pose(frame);
        let mut scene = self.still.clone();
        let (vertices, materials) = (scene.vertices.len() as u32, scene.materials.len() as u32);
        if !scene.colors.is_empty() || !part.colors.is_empty() {
            scene.colors.resize(scene.vertices.len(), WHITE);
            scene
                .colors
                .extend((0..part.vertices.len()).map(|v| part.colors.get(v).copied().unwrap_or(WHITE)));
        }
        scene.vertices.extend(part.vertices.iter().map(|vertex| {
            let mut moved = *vertex;
            moved.position = on_grid(pose.position(vertex.position.map(f64::from)));
            moved.normal = pose.direction(vertex.normal.map(f64::from)).map(|c| c as f32);
            moved
        }));
        scene.triangles.extend(part.triangles.iter().map(|corners| corners.map(|v| v + vertices)));
        scene.triangle_material.extend(part.triangle_material.iter().map(|material| material + materials));
        scene.materials.extend(part.materials.iter().cloned());
        Cow::Owned(scene)
    }
}

/// The triangles that stay and those that move, these with vertices of their own.
fn split(scene: &Scene, moves: impl Fn(usize) -> bool) -> (Scene, Scene) {
    let empty =
        Scene { vertices: Vec::new(), triangles: Vec::new(), triangle_material: Vec::new(), ..scene.clone() };
    let (mut still, mut part) =
        (Scene { vertices: scene.vertices.clone(), colors: scene.colors.clone(), ..empty.clone() }, empty);
    let mut places = vec![u32::MAX; scene.vertices.len()];
    for (index, corners) in scene.triangles.iter().enumerate() {
        let material = scene.triangle_material[index];
        if !moves(index) {
            still.triangles.push(*corners);
            still.triangle_material.push(material);
            continue;
        }
        let corners = corners.map(|v| {
            let place = &mut places[v as usize];
            if *place == u32::MAX {
                *place = part.vertices.len() as u32;
                part.vertices.push(scene.vertices[v as usize]);
                part.colors.extend(scene.colors.get(v as usize));
            }
            *place
        });
        part.triangles.push(corners);
        part.triangle_material.push(material);
    }
    (still, part)
}

/// Middle of the bounds of all vertices.
fn middle(scene: &Scene) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let values = scene.vertices.iter().map(|vertex| f64::from(vertex.position[k]));
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)));
        0.5 * (low + high)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::norm;

    #[test]
    fn scenes_with_a_part_that_moves_lose_nothing() {
        // Nothing moves in the hall.
        assert!(!MovingScene::load("hall").unwrap().has_motion());
        for name in procedural::NAMES.into_iter().filter(|&name| name != "hall").chain(["grids"]) {
            let whole = load_scene(name).unwrap();
            let moving = MovingScene::load(name).unwrap();
            assert!(moving.has_motion(), "{name}");
            let part = moving.part().unwrap().triangles.len();
            let extra = if name == "village" { part } else { 0 };
            let first = moving.at(0);
            assert_eq!(first.triangles.len(), whole.triangles.len() + extra, "{name}");
            assert!(part > 0 && part < whole.triangles.len(), "{name}: {part}");
            assert!(moving.moves(first.triangles.len() as u32 - 1) && !moving.moves(0));
            let (first, later) = (first.into_owned(), moving.at(7).into_owned());
            assert_eq!(first.triangles, later.triangles);
            let moved = first.vertices.iter().zip(&later.vertices).filter(|(a, b)| a.position != b.position);
            assert!(moved.count() > 0, "{name}");
            assert_eq!(moving.at_rest().at(7).vertices, first.vertices);
        }
    }

    #[test]
    fn poses_are_undone() {
        let pose = Motion::Hover { pivot: [1.0, 2.0, 3.0] }.pose(5);
        let p = [0.3, -4.0, 2.0];
        assert!(norm(minus(pose.part_position(pose.position(p)), p)) < 1e-12);
        assert!((norm(pose.direction(p)) - norm(p)).abs() < 1e-12);
        assert_eq!(Motion::Circle.pose(0), Pose::IDENTITY);
    }
}
