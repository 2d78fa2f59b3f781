//! Scenes that may move, frame by frame, as a camera on its path sees them.

use crate::error::EvaluationError;
use crate::fragments::is_stack;
use applications::rays::{PosedTriangles, Surface, Triangles};
use rayon::prelude::*;
use scenes::vector::{cross, dot, minus, normalize};
use scenes::{CameraPath, LightView, MovingScene, Pose, Scene};
use shadow_renderer::{CameraView, Frame, NO_TRIANGLE};

/// A scene in motion and at rest, with trees for rays.
pub(crate) struct Stage {
    pub(crate) label: String,
    scenes: [MovingScene; 2],
    trees: [Trees; 2],
}

struct Trees {
    still: Triangles,
    part: Option<Triangles>,
}

/// A stage on one path: in motion or at rest.
#[derive(Clone, Copy)]
pub(crate) struct Scenery<'a> {
    pub(crate) scene: &'a MovingScene,
    trees: &'a Trees,
}

/// How far a pixel's surface may lie from its triangle along the normal, as a share of the largest coordinate: positions are
/// of single precision.
const REACH: f64 = 4e-6;

/// Distances of one surface in two frames differ by less than this share.
const SAME_SURFACE: f64 = 0.01;

impl Stage {
    /// Reads a scene; `views` are those whose light is wanted.
    pub(crate) fn load(label: &str, index: usize) -> Result<Self, EvaluationError> {
        let key = format!("scenes[{index}]");
        let fail = |reason: String| EvaluationError::key(key.as_str(), format!("scene `{label}`: {reason}"));
        if is_stack(label) {
            return Err(fail("is a stack: shadow rays need triangles".to_owned()));
        }
        let moving = MovingScene::load(label).map_err(|error| fail(error.to_string()))?;
        let scenes = [moving.clone().at_rest(), moving];
        let tree = |scene: &Scene| Triangles::of_scene(scene).map_err(|error| fail(error.to_string()));
        let trees = |scene: &MovingScene| -> Result<Trees, EvaluationError> {
            Ok(Trees { still: tree(scene.still())?, part: scene.part().map(tree).transpose()? })
        };
        let trees = [trees(&scenes[0])?, trees(&scenes[1])?];
        Ok(Self { label: label.to_owned(), scenes, trees })
    }

    /// In motion or at rest.
    pub(crate) fn on(&self, moving: bool) -> Scenery<'_> {
        let place = usize::from(moving);
        Scenery { scene: &self.scenes[place], trees: &self.trees[place] }
    }

    /// The wanted views.
    pub(crate) fn views(&self, names: &[String]) -> Result<Vec<&LightView>, EvaluationError> {
        let known = &self.scenes[0].still().views;
        let views: Vec<&LightView> = known.iter().filter(|view| names.contains(&view.name)).collect();
        if views.is_empty() {
            let list: Vec<&str> = known.iter().map(|view| view.name.as_str()).collect();
            let reason = format!("views = {names:?} match none of {} of `{}`", list.join(", "), self.label);
            return Err(EvaluationError::key("views", reason));
        }
        Ok(views)
    }
}

impl Scenery<'_> {
    /// The scene in a frame, for rays.
    pub(crate) fn posed(&self, frame: usize) -> PosedTriangles<'_> {
        let moving = self.trees.part.as_ref().map(|part| (part, self.scene.pose(frame)));
        PosedTriangles { still: &self.trees.still, moving }
    }

    /// All triangles of a frame in one tree, in the order of [`MovingScene::at`].
    pub(crate) fn whole(&self, frame: usize) -> Result<Whole<'_>, EvaluationError> {
        if !self.scene.has_motion() {
            return Ok(Whole::Still(&self.trees.still));
        }
        let triangles = Triangles::of_scene(&self.scene.at(frame));
        let fail = |error: applications::rays::TriangleError| EvaluationError::Value(error.to_string());
        Ok(Whole::Frame(Box::new(triangles.map_err(fail)?)))
    }
}

/// Triangles of a frame.
pub(crate) enum Whole<'a> {
    Still(&'a Triangles),
    Frame(Box<Triangles>),
}

impl Whole<'_> {
    pub(crate) fn triangles(&self) -> &Triangles {
        match self {
            Self::Still(triangles) => triangles,
            Self::Frame(triangles) => triangles,
        }
    }
}

/// The pixels of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// Width and height of the picture.
    pub(crate) camera: [u32; 2],
    /// By how much what is seen is larger, a share of its sides.
    pub(crate) overscan: f64,
}

impl Window {
    /// Pixels of the border to each side.
    pub(crate) fn margin(&self) -> [u32; 2] {
        self.camera.map(|side| (0.5 * self.overscan * f64::from(side)).round() as u32)
    }
}

/// What the camera sees in a frame, with a border around the picture.
pub(crate) struct Sight {
    pub(crate) frame: Frame,
    pub(crate) view: CameraView,
    /// Distance along the view of each pixel; 0 without a surface.
    pub(crate) depth: Vec<f64>,
    /// Unit normal of each pixel's triangle, towards the camera: interpolated ones tell nothing of shadow.
    normal: Vec<[f64; 3]>,
    pose: Pose,
    /// Pixels of the border to each side.
    pub(crate) margin: [u32; 2],
}

/// A surface that a pixel shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) position: [f64; 3],
    pub(crate) normal: [f64; 3],
    pub(crate) triangle: u32,
    pub(crate) moves: bool,
}

impl Sight {
    /// A frame of a scene on a camera's way.
    pub(crate) fn new(
        window: &Window,
        scenery: &Scenery<'_>,
        path: &CameraPath,
        frame: usize,
    ) -> Result<Self, EvaluationError> {
        let margin = window.margin();
        let [width, height] = [0, 1].map(|k| window.camera[k] + 2 * margin[k]);
        let mut scene = scenery.scene.at(frame).into_owned();
        let mut camera = path.camera(&scenery.scene.still().camera, frame);
        // The same pixels, and more around them.
        let tangent = (0.5 * f64::from(camera.vertical_fov)).tan();
        let larger = tangent * f64::from(height) / f64::from(window.camera[1]);
        camera.vertical_fov = (2.0 * larger.atan()) as f32;
        scene.camera = camera;
        let fail = |error: shadow_renderer::RenderError| EvaluationError::Value(error.to_string());
        let frame_of = Frame::render(&scene, width, height).map_err(fail)?;
        let view = CameraView::new(&camera, width, height).map_err(fail)?;
        let distance = |(position, &triangle): (&[f32; 3], &u32)| {
            if triangle == NO_TRIANGLE { 0.0 } else { view.project(position.map(f64::from))[2] }
        };
        let depth = frame_of.position.par_iter().zip(&frame_of.triangle).map(distance).collect();
        let normal = |(position, &triangle): (&[f32; 3], &u32)| {
            if triangle == NO_TRIANGLE {
                return [0.0; 3];
            }
            let corners = scene.triangles[triangle as usize];
            let [a, b, c] = corners.map(|v| scene.vertices[v as usize].position.map(f64::from));
            let normal = normalize(cross(minus(b, a), minus(c, a)));
            let towards_camera = minus(camera.eye.map(f64::from), position.map(f64::from));
            if dot(normal, towards_camera) < 0.0 { normal.map(|c| -c) } else { normal }
        };
        let normal = frame_of.position.par_iter().zip(&frame_of.triangle).map(normal).collect();
        Ok(Self { frame: frame_of, view, depth, normal, pose: scenery.scene.pose(frame), margin })
    }

    pub(crate) fn size(&self) -> [usize; 2] {
        [self.frame.width as usize, self.frame.height as usize]
    }

    /// Whether a pixel belongs to the picture.
    pub(crate) fn is_shown(&self, pixel: usize) -> bool {
        let [width, height] = self.size();
        let inside = |t: usize, size: usize, margin: u32| {
            let margin = margin as usize;
            (margin..size - margin).contains(&t)
        };
        inside(pixel % width, width, self.margin[0]) && inside(pixel / width, height, self.margin[1])
    }

    /// The surface of a pixel, if it faces a light in space.
    pub(crate) fn facing(&self, scene: &MovingScene, pixel: usize, eye: [f64; 3]) -> Option<Seen> {
        let triangle = self.frame.triangle[pixel];
        if triangle == NO_TRIANGLE {
            return None;
        }
        let position = self.frame.position[pixel].map(f64::from);
        let seen = Seen { position, normal: self.normal[pixel], triangle, moves: scene.moves(triangle) };
        seen.faces(eye).then_some(seen)
    }

    /// Whether a pixel shows a surface at some distance, up to a share of it.
    pub(crate) fn holds(&self, [x, y, distance]: [f64; 3]) -> Option<usize> {
        let [width, height] = self.size();
        let inside = x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64;
        let pixel = if inside { y as usize * width + x as usize } else { return None };
        let is_same = (self.depth[pixel] - distance).abs() < SAME_SURFACE * distance;
        (self.depth[pixel] > 0.0 && is_same).then_some(pixel)
    }

    /// What a frame showed at a place of it: between the pixels of the same surface, where they make most of it.
    pub(crate) fn interpolated(
        &self,
        [x, y, distance]: [f64; 3],
        value: impl Fn(usize) -> Option<f64>,
    ) -> Option<f64> {
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (mut sum, mut weight) = (0.0, 0.0);
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let share = (1.0 - (x - 0.5 - left - dx).abs()) * (1.0 - (y - 0.5 - top - dy).abs());
            let pixel = self.holds([left + dx + 0.5, top + dy + 0.5, distance]);
            if let Some(value) = pixel.and_then(&value) {
                sum += share * value;
                weight += share;
            }
        }
        (weight > 0.5).then(|| sum / weight)
    }

    /// Where a surface was in another frame.
    pub(crate) fn place_in(&self, other: &Self, seen: &Seen) -> [f64; 3] {
        if seen.moves { other.pose.position(self.pose.part_position(seen.position)) } else { seen.position }
    }
}

impl Seen {
    /// Whether a point lies in front of the surface.
    pub(crate) fn faces(&self, point: [f64; 3]) -> bool {
        dot(self.normal, minus(point, self.position)) > 0.0
    }

    /// On the triangles of the frame, for shadow rays; where rounding lost it, the point itself.
    pub(crate) fn surface(&self, whole: &Triangles, largest: f64) -> Surface {
        let found = whole.surface_near(self.position, self.normal, REACH * largest);
        found.unwrap_or(Surface { triangle: self.triangle, position: self.position })
    }
}

/// Largest coordinate of a scene.
pub(crate) fn largest_coordinate(scene: &Scene) -> f64 {
    let all = scene.vertices.iter().flat_map(|vertex| vertex.position);
    all.fold(0.0f64, |largest, c| largest.max(f64::from(c.abs())))
}
