//! The node hierarchy, flattened with an explicit stack: its depth is the file's choice.

use gltf::json::{Index, Node, Root};

use super::accessor::out_of_range;
use crate::Camera;
use crate::error::FileFault;
use crate::vector::{cross, dot};

/// Rows of an affine map: world = linear · local + translation (last column).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine([[f64; 4]; 3]);

impl Affine {
    const IDENTITY: Self = Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    fn then_inner(&self, inner: &Self) -> Self {
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                let sum: f64 = (0..3).map(|k| self.0[row][k] * inner.0[k][column]).sum();
                if column == 3 { sum + self.0[row][3] } else { sum }
            })
        }))
    }

    pub(super) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
    }

    fn direction(&self, d: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])
    }

    fn linear_row(&self, row: usize) -> [f64; 3] {
        [self.0[row][0], self.0[row][1], self.0[row][2]]
    }

    /// Whether the map reverses orientation, so that counter-clockwise becomes clockwise.
    pub(super) fn mirrors(&self) -> bool {
        dot(self.linear_row(0), cross(self.linear_row(1), self.linear_row(2))) < 0.0
    }

    /// Maps a normal (by the cofactors, which exist for singular maps too); the result has any length.
    pub(super) fn normal(&self, n: [f64; 3]) -> [f64; 3] {
        let sign = if self.mirrors() { -1.0 } else { 1.0 };
        std::array::from_fn(|row| {
            sign * dot(cross(self.linear_row((row + 1) % 3), self.linear_row((row + 2) % 3)), n)
        })
    }
}

/// A mesh placed in the world.
pub(super) struct Instance {
    pub mesh: usize,
    pub world_from_mesh: Affine,
}

/// All meshes of the default scene (or the first one, or without scenes all roots) in depth-first order, and
/// its first perspective camera. A node that is reached twice, so also a cycle, is an error.
pub(super) fn flatten(root: &Root) -> Result<(Vec<Instance>, Option<Camera>), FileFault> {
    let mut stack: Vec<(Index<Node>, Affine)> =
        start_nodes(root)?.into_iter().rev().map(|index| (index, Affine::IDENTITY)).collect();
    let mut reached = vec![false; root.nodes.len()];
    let (mut instances, mut camera) = (Vec::new(), None);
    while let Some((index, world_from_parent)) = stack.pop() {
        let at = || format!("nodes[{index}]");
        let node = root.get(index).ok_or_else(|| out_of_range(at(), index.value(), root.nodes.len()))?;
        if std::mem::replace(&mut reached[index.value()], true) {
            return Err(FileFault::invalid(at(), "is reached twice: the nodes form no tree"));
        }
        let world_from_node = world_from_parent.then_inner(&local(node, at)?);
        if let Some(mesh) = node.mesh {
            instances.push(Instance { mesh: mesh.value(), world_from_mesh: world_from_node });
        }
        if let (Some(camera_index), None) = (node.camera, &camera) {
            camera = perspective(root, camera_index, &world_from_node)?;
        }
        stack.extend(node.children.iter().flatten().rev().map(|&child| (child, world_from_node)));
    }
    Ok((instances, camera))
}

fn start_nodes(root: &Root) -> Result<Vec<Index<Node>>, FileFault> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    if let Some(scene) = root.scenes.get(scene) {
        return Ok(scene.nodes.clone());
    }
    if root.scene.is_some() {
        return Err(out_of_range("scene".into(), scene, root.scenes.len()));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
        if let Some(flag) = is_child.get_mut(child.value()) {
            *flag = true;
        }
    }
    Ok((0..root.nodes.len()).filter(|&i| !is_child[i]).map(|i| Index::new(i as u32)).collect())
}

fn local(node: &Node, at: impl Fn() -> String) -> Result<Affine, FileFault> {
    let check = |key: &str, values: &[f32]| {
        if values.iter().all(|v| v.is_finite()) {
            Ok(())
        } else {
            Err(FileFault::invalid(at(), format!("{key} {values:?} is not finite")))
        }
    };
    if let Some(m) = node.matrix {
        check("matrix", &m)?;
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            let bottom = [m[3], m[7], m[11], m[15]];
            return Err(FileFault::invalid(at(), format!("matrix with bottom row {bottom:?} is not affine")));
        }
        return Ok(Affine(std::array::from_fn(|row| {
            std::array::from_fn(|column| f64::from(m[4 * column + row]))
        })));
    }
    let translation = node.translation.unwrap_or_default();
    let scale = node.scale.unwrap_or([1.0; 3]);
    let rotation = node.rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |q| q.0);
    check("translation", &translation)?;
    check("scale", &scale)?;
    check("rotation", &rotation)?;
    let rotation = rotation.map(f64::from);
    let length = rotation.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length < 1e-6 {
        return Err(FileFault::invalid(at(), format!("rotation {rotation:?} is no unit quaternion")));
    }
    // Exporters write quaternions with few digits: without this the mesh would be scaled.
    let [x, y, z, w] = rotation.map(|c| c / length);
    let rotate = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    Ok(Affine(std::array::from_fn(|row| {
        std::array::from_fn(|column| match column {
            3 => f64::from(translation[row]),
            _ => rotate[row][column] * f64::from(scale[column]),
        })
    })))
}

/// The glTF camera looks along its -z; `None` for an orthographic one.
fn perspective(
    root: &Root,
    index: Index<gltf::json::Camera>,
    world_from_camera: &Affine,
) -> Result<Option<Camera>, FileFault> {
    let Some(perspective) = root.get(index).and_then(|camera| camera.perspective.as_ref()) else {
        return Ok(None);
    };
    let at = || format!("cameras[{index}]");
    let fov = perspective.yfov;
    if !(1e-4..=3.1).contains(&fov) {
        return Err(FileFault::invalid(at(), format!("yfov {fov} is outside 0.0001 to 3.1 radians")));
    }
    let eye = world_from_camera.point([0.0; 3]);
    let target = {
        let forward = world_from_camera.direction([0.0, 0.0, -1.0]);
        std::array::from_fn(|axis| eye[axis] + forward[axis])
    };
    let eye = crate::arrays::checked_position(eye, at)?;
    let target = crate::arrays::checked_position(target, at)?;
    if eye == target {
        return Err(FileFault::invalid(at(), format!("looks nowhere: eye and target are both {eye:?}")));
    }
    Ok(Some(Camera { eye, target, vertical_fov: fov }))
}
