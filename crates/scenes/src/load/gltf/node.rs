//! The node hierarchy, flattened with an explicit stack: its depth is the file's choice.

use super::accessor::{Elements, entry, out_of_range};
use super::affine::{Affine, Trs};
use super::animation::Pose;
use super::buffers::Buffers;
use super::json::{Instancing, Node, Root, Whole};
use crate::error::FileFault;
use crate::load::warnings::{WarningKind, Warnings};
use crate::load::{FileCamera, FileLight};
use crate::vector::norm;

/// Most meshes placed in the world. Instances may cost a file nothing, where their accessors have no bytes.
const MAX_INSTANCES: u64 = 1 << 22;

/// A mesh placed in the world.
pub(super) struct Instance {
    pub mesh: usize,
    pub node: usize,
    pub world_from_mesh: Affine,
    pub skin: Option<Whole>,
}

/// What the nodes of a scene hold, in depth-first order.
#[derive(Default)]
pub(super) struct Placed {
    pub instances: Vec<Instance>,
    /// Meshes that are not visible.
    pub hidden: usize,
    pub cameras: Vec<FileCamera>,
    pub lights: Vec<FileLight>,
}

/// World matrices of all nodes.
pub(super) struct Hierarchy<'a> {
    root: &'a Root,
    pose: &'a Pose,
    worlds: Vec<Option<Affine>>,
    parents: Vec<Option<u32>>,
    start: Affine,
}

impl<'a> Hierarchy<'a> {
    pub(super) fn new(root: &'a Root, pose: &'a Pose) -> Self {
        let mut parents = vec![None; root.nodes.len()];
        for (parent, node) in root.nodes.iter().enumerate() {
            for child in &node.children {
                if let Some(slot @ None) = parents.get_mut(child.index()) {
                    *slot = Some(parent as u32);
                }
            }
        }
        let centre = root.extensions.as_ref().and_then(|e| e.rtc.as_ref()).map_or([0.0; 3], |rtc| rtc.center);
        Self { root, pose, worlds: vec![None; root.nodes.len()], parents, start: Affine::translation(centre) }
    }

    /// All that the default scene holds (or the first one, or without scenes all roots). A node that is reached twice, so
    /// also a cycle, is an error.
    pub(super) fn flatten(
        &mut self,
        buffers: &'a Buffers<'a>,
        warnings: &mut Warnings,
    ) -> Result<Placed, FileFault> {
        let root = self.root;
        let mut stack: Vec<(Whole, Affine, bool)> =
            self.start_nodes(warnings)?.into_iter().rev().map(|index| (index, self.start, true)).collect();
        let mut placed = Placed::default();
        while let Some((index, world_from_parent, shown)) = stack.pop() {
            let at = || format!("nodes[{}]", index.0);
            let node = entry(&root.nodes, index, "nodes")?;
            if self.worlds[index.index()].is_some() {
                return Err(FileFault::invalid(at(), "is reached twice: the nodes form no tree"));
            }
            let world = world_from_parent.then_inner(&self.local(index.index(), node)?);
            self.worlds[index.index()] = Some(world);
            let extensions = node.extensions.as_ref();
            let own = extensions.and_then(|e| e.visibility.as_ref()).and_then(|v| v.visible).unwrap_or(true);
            let shown = shown && self.pose.visible(index.index()).unwrap_or(own);
            if let Some(mesh) = node.mesh {
                if shown {
                    let instancing = extensions.and_then(|e| e.instancing.as_ref());
                    self.place(&mut placed, buffers, (index, mesh, node.skin), &world, instancing)?;
                } else {
                    placed.hidden += 1;
                }
            }
            if let Some(camera) = node.camera {
                let name = node.name.as_deref();
                placed.cameras.extend(perspective(root, camera, &world, name, warnings)?);
            }
            if let Some(light) = extensions.and_then(|e| e.light.as_ref()).filter(|_| shown) {
                placed.lights.push(punctual(root, light.light, &world, node.name.as_deref())?);
            }
            stack.extend(node.children.iter().rev().map(|&child| (child, world, shown)));
        }
        Ok(placed)
    }

    /// The world matrix of a node that need not belong to the scene: a joint.
    pub(super) fn world(&mut self, node: Whole) -> Result<Affine, FileFault> {
        let mut chain = Vec::new();
        let mut next = Some(node.index());
        let mut world = self.start;
        while let Some(index) = next {
            let known = self.worlds.get(index);
            match known {
                None => return Err(out_of_range(format!("nodes[{index}]"), index, self.worlds.len())),
                Some(Some(known)) => {
                    world = *known;
                    break;
                }
                Some(None) => chain.push(index),
            }
            if chain.len() > self.worlds.len() {
                let at = format!("nodes[{}]", node.0);
                return Err(FileFault::invalid(at, "is its own ancestor: the nodes form no tree"));
            }
            next = self.parents[index].map(|parent| parent as usize);
        }
        for &index in chain.iter().rev() {
            world = world.then_inner(&self.local(index, &self.root.nodes[index])?);
            self.worlds[index] = Some(world);
        }
        Ok(world)
    }

    fn local(&self, index: usize, node: &Node) -> Result<Affine, FileFault> {
        let at = || format!("nodes[{index}]");
        match (&node.matrix, self.pose.trs(index)) {
            (_, Some(posed)) => Affine::of_trs(posed, &at),
            (Some(matrix), None) => Affine::of_matrix(matrix, &at),
            (None, None) => Affine::of_trs(&trs(node), &at),
        }
    }

    fn place(
        &self,
        placed: &mut Placed,
        buffers: &'a Buffers<'a>,
        (node, mesh, skin): (Whole, Whole, Option<Whole>),
        world: &Affine,
        instancing: Option<&Instancing>,
    ) -> Result<(), FileFault> {
        let instance =
            |world_from_mesh| Instance { mesh: mesh.index(), node: node.index(), world_from_mesh, skin };
        // Where a skin places a mesh its own node does not, so that instances would coincide.
        let Some(instancing) = instancing.filter(|_| skin.is_none()) else {
            placed.instances.push(instance(*world));
            return Ok(());
        };
        let at = || format!("nodes[{}].extensions.EXT_mesh_gpu_instancing", node.0);
        let open = |name: &str, kind: &str| {
            let index = instancing.attributes.get(name);
            index.map(|&index| Elements::open(self.root, buffers, index, &[kind], name)).transpose()
        };
        let translations = open("TRANSLATION", "VEC3")?;
        // Integers are normalised here, and some files forget to say so.
        let rotations = open("ROTATION", "VEC4")?.map(Elements::into_normalized);
        let scales = open("SCALE", "VEC3")?;
        let all = [&translations, &rotations, &scales];
        let Some(count) = all.iter().copied().flatten().map(Elements::len).next() else {
            placed.instances.push(instance(*world));
            return Ok(());
        };
        if let Some(other) = all.iter().copied().flatten().find(|elements| elements.len() != count) {
            let problem = format!("{} values of one attribute, {count} of another", other.len());
            return Err(FileFault::invalid(at(), problem));
        }
        let total = placed.instances.len() as u64 + count as u64;
        if total > MAX_INSTANCES {
            let (what, limit) = ("instances", MAX_INSTANCES);
            return Err(FileFault::TooMany { at: at(), what, count: total, limit });
        }
        for i in 0..count {
            let rest = Trs::default();
            let trs = Trs {
                translation: translations.as_ref().map_or(rest.translation, |of| of.vector(i)),
                rotation: rotations.as_ref().map_or(rest.rotation, |of| of.vector(i)),
                scale: scales.as_ref().map_or(rest.scale, |of| of.vector(i)),
            };
            let local = Affine::of_trs(&trs, &|| format!("{}: instance {i}", at()))?;
            placed.instances.push(instance(world.then_inner(&local)));
        }
        Ok(())
    }

    /// Of the default scene; all roots where it has none, so that a file which only forgot it shows what it holds.
    fn start_nodes(&self, warnings: &mut Warnings) -> Result<Vec<Whole>, FileFault> {
        let root = self.root;
        let scene = root.scene.unwrap_or_default();
        let found = root.scenes.get(scene.index());
        if let Some(scene) = found.filter(|scene| !scene.nodes.is_empty()) {
            return Ok(scene.nodes.clone());
        }
        if found.is_none() && !root.scenes.is_empty() {
            return Err(out_of_range("scene".into(), scene.index(), root.scenes.len()));
        }
        if !root.nodes.is_empty() && (found.is_some() || root.scene.is_some()) {
            warnings.add(WarningKind::Scene, "", || {
                format!("scene {} has no nodes: all that have no parent are shown", scene.0)
            });
        }
        let roots = self.parents.iter().enumerate().filter(|(_, parent)| parent.is_none());
        Ok(roots.map(|(index, _)| Whole(index as u64)).collect())
    }
}

/// Where a node says that it lies, without a matrix.
pub(super) fn trs(node: &Node) -> Trs {
    let rest = Trs::default();
    Trs {
        translation: node.translation.unwrap_or(rest.translation),
        rotation: node.rotation.unwrap_or(rest.rotation),
        scale: node.scale.unwrap_or(rest.scale),
    }
}

/// Widest vertical field of view of a camera, in radians.
const WIDEST: f64 = 3.1;
/// Narrowest one.
const NARROWEST: f64 = 1e-4;

/// The glTF camera looks along its -z; `None` for what no picture is made from.
fn perspective(
    root: &Root,
    index: Whole,
    world: &Affine,
    node: Option<&str>,
    warnings: &mut Warnings,
) -> Result<Option<FileCamera>, FileFault> {
    let at = format!("cameras[{}]", index.0);
    let mut unused = |why: String| {
        warnings.add(WarningKind::Camera, &at, || format!("{at} is not used: {why}"));
        Ok(None)
    };
    let Some(camera) = root.cameras.get(index.index()) else {
        return unused(format!("there are {}", root.cameras.len()));
    };
    let Some(perspective) = &camera.perspective else { return unused("it is not perspective".into()) };
    let fov = perspective.yfov;
    if !(NARROWEST..=WIDEST).contains(&fov) {
        return unused(format!("yfov {fov} is outside {NARROWEST} to {WIDEST} radians"));
    }
    let eye = world.point([0.0; 3]);
    let forward = world.direction([0.0, 0.0, -1.0]);
    let up = world.direction([0.0, 1.0, 0.0]);
    let usable = |v: [f64; 3]| norm(v) > 0.0 && v.iter().all(|c| c.is_finite());
    if !usable(forward) || !usable(up) || !eye.iter().all(|c| c.is_finite()) {
        return unused("its node has no usable place".into());
    }
    let name = node.or(camera.name.as_deref()).map_or_else(|| at.clone(), str::to_owned);
    Ok(Some(FileCamera { name, eye, forward, up, vertical_fov: fov }))
}

fn punctual(root: &Root, index: Whole, world: &Affine, node: Option<&str>) -> Result<FileLight, FileFault> {
    let lights = root.extensions.as_ref().and_then(|e| e.lights.as_ref());
    let lights = lights.map_or(&[][..], |lights| &lights.lights);
    let light = lights.get(index.index());
    let name = node.or(light.and_then(|light| light.name.as_deref()));
    let name = name.map_or_else(|| format!("light {}", index.0), str::to_owned);
    let kind = light.and_then(|light| light.kind.clone()).unwrap_or_default();
    let direction = world.direction([0.0, 0.0, -1.0]);
    Ok(FileLight { name, kind, position: world.point([0.0; 3]), direction })
}
