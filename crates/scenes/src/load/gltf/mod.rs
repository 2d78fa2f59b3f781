//! glTF 2.0, binary and textual.

mod accessor;
mod affine;
mod animation;
mod buffers;
mod draco;
mod extensions;
mod glb;
mod json;
mod material;
mod node;
mod pose;
mod primitive;
mod transmission;

use std::collections::HashMap;

use accessor::out_of_range;
use animation::Pose;
use buffers::Buffers;
use draco::{Decoded, DracoBudget};
use json::{Primitive, Root};
use material::Materials;
use node::{Hierarchy, Instance, Placed};
use pose::{MorphBudget, Placement, Skins, joint_sets};
use primitive::{Mode, Source, Topology, Wanted};

use super::source::Folder;
use super::warnings::{WarningKind, Warnings};
use super::{Loaded, PoseChoice, recentred};
use crate::arrays::{MAX_TRIANGLES, SceneArrays};
use crate::error::FileFault;

/// Most JSON objects of a document. An empty one takes three bytes in the file and hundreds in memory.
const MAX_JSON_OBJECTS: u64 = 1 << 20;

pub(super) fn load(
    bytes: &[u8],
    folder: &mut Folder,
    choice: &PoseChoice,
    warnings: &mut Warnings,
) -> Result<Loaded, FileFault> {
    let (json, binary) = if glb::is_glb(bytes) { glb::split(bytes)? } else { (bytes, None) };
    let root = parse(json, warnings)?;
    let buffers = Buffers::read(&root, binary, folder)?;
    let pose = Pose::at(&root, &buffers, choice, warnings)?;
    let mut hierarchy = Hierarchy::new(&root, &pose);
    let placed = hierarchy.flatten(&buffers, warnings)?;
    let decoded = decode(&root, &buffers, &placed)?;
    let mut builder = Builder {
        root: &root,
        buffers: &buffers,
        pose: &pose,
        hierarchy,
        materials: Materials::new(&root, &buffers),
        skins: Skins::default(),
        folder,
    };
    let (arrays, origin) =
        recentred(warnings, |origin, warnings| builder.build(&placed, &decoded, origin, warnings))?;
    let materials = builder.materials.scene;
    let holds = other_geometry(&root, &placed);
    let Placed { cameras, lights, .. } = placed;
    let animations = (animation::names(&root), pose.animation());
    Ok(Loaded { arrays, materials, cameras, lights, origin, holds, animations })
}

/// Decoded primitives by mesh and primitive.
type AllDecoded = HashMap<(usize, usize), Decoded>;

/// Decodes what the placed meshes have of compressed primitives, each once.
fn decode(root: &Root, buffers: &Buffers, placed: &Placed) -> Result<AllDecoded, FileFault> {
    let mut all = AllDecoded::new();
    let mut budget = DracoBudget::default();
    let mut seen = vec![false; root.meshes.len()];
    for instance in &placed.instances {
        match seen.get_mut(instance.mesh) {
            Some(seen) if !*seen => *seen = true,
            _ => continue,
        }
        for (number, primitive) in root.meshes[instance.mesh].primitives.iter().enumerate() {
            let extensions = primitive.extensions.as_ref();
            let Some(draco) = extensions.and_then(|e| e.draco.as_ref()) else { continue };
            let at = format!("meshes[{}].primitives[{number}]", instance.mesh);
            let decoded = budget.decode(root, buffers, primitive, draco, &at)?;
            all.insert((instance.mesh, number), decoded);
        }
    }
    Ok(all)
}

/// From placed meshes to triangles.
struct Builder<'a, 'f> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    pose: &'a Pose,
    hierarchy: Hierarchy<'a>,
    materials: Materials<'a>,
    skins: Skins,
    folder: &'f mut Folder,
}

impl<'a> Builder<'a, '_> {
    fn build(
        &mut self,
        placed: &Placed,
        decoded: &'a AllDecoded,
        origin: [f64; 3],
        warnings: &mut Warnings,
    ) -> Result<SceneArrays, FileFault> {
        let mut arrays = SceneArrays::default();
        let mut budget = MorphBudget::default();
        // Filtered once for each mesh, not for each instance: both may be many.
        let mut drawn: Vec<Option<Vec<Drawn<'a>>>> = self.root.meshes.iter().map(|_| None).collect();
        let mut visits = 0_u64;
        for instance in &placed.instances {
            let Some(slot) = drawn.get_mut(instance.mesh) else {
                return Err(out_of_range("meshes".into(), instance.mesh, self.root.meshes.len()));
            };
            let primitives = match slot {
                Some(primitives) => primitives,
                None => slot.insert(triangles_of(self.root, instance.mesh)?),
            };
            for &(number, primitive, mode) in primitives.iter() {
                let at = format!("meshes[{}].primitives[{number}]", instance.mesh);
                // One without triangles costs time, too.
                visits += 1;
                if visits > MAX_TRIANGLES {
                    let (what, limit) = ("primitives", MAX_TRIANGLES);
                    return Err(FileFault::TooMany { at, what, count: visits, limit });
                }
                let compressed = decoded.get(&(instance.mesh, number));
                let (root, buffers) = (self.root, self.buffers);
                let source = Source { root, buffers, primitive, mode, compressed, at };
                self.add(&mut arrays, instance, &source, origin, (&mut budget, &mut *warnings))?;
            }
        }
        Ok(arrays)
    }

    fn add(
        &mut self,
        arrays: &mut SceneArrays,
        instance: &Instance,
        source: &Source<'a>,
        origin: [f64; 3],
        (budget, warnings): (&mut MorphBudget, &mut Warnings),
    ) -> Result<(), FileFault> {
        let material = source.primitive.material;
        let converted = self.materials.get(material, self.folder, warnings)?;
        let (number, uv_map, cutting) = (converted.material, converted.uv_map, converted.cutting().cloned());
        let placement = self.placement(instance, source)?;
        let weights = self.pose.weights(instance.node);
        let weights = weights.or(self.root.nodes[instance.node].weights.as_deref());
        let weights = weights.or(self.root.meshes[instance.mesh].weights.as_deref()).unwrap_or_default();
        if weights.len() > source.primitive.targets.len() {
            warnings.add(WarningKind::MorphWeights, "", || {
                let targets = source.primitive.targets.len();
                format!("{}: {} weights for {targets} morph targets", source.at, weights.len())
            });
        }
        let wanted = Wanted { placement: &placement, weights, uv_map, origin };
        let Some(mesh) = source.mesh(arrays, &wanted, budget, warnings)? else { return Ok(()) };
        let bare = uv_map.is_some() && mesh.uvs.is_empty();
        let Some(cutting) = cutting else {
            let number = if bare { self.materials.untextured(number) } else { number };
            arrays.push(&mesh, number);
            return Ok(());
        };
        let left = arrays.triangles_left();
        let parts = cutting.apply(mesh, left).map_err(|pieces| FileFault::TooMany {
            at: source.at.clone(),
            what: "triangles after cutting them at steps of alpha",
            count: pieces.0,
            limit: left,
        })?;
        for (part, alpha) in parts {
            let number = self.materials.variant(material, alpha)?;
            let number = if bare { self.materials.untextured(number) } else { number };
            arrays.push(&part, number);
        }
        Ok(())
    }

    fn placement(&mut self, instance: &Instance, source: &Source<'a>) -> Result<Placement<'a>, FileFault> {
        let attributes = &source.primitive.attributes;
        let sets = match instance.skin {
            None => None,
            Some(_) => joint_sets(attributes, |name, kinds| source.attribute(name, kinds), &source.at)?,
        };
        let (Some(skin), Some(sets)) = (instance.skin, sets) else {
            return Ok(Placement::Rigid(instance.world_from_mesh));
        };
        let joints = self.skins.matrices(self.root, self.buffers, &mut self.hierarchy, skin)?;
        Ok(Placement::Skinned { joints, sets })
    }
}

/// A primitive with its number and mode.
type Drawn<'a> = (usize, &'a Primitive, Mode);

fn triangles_of(root: &Root, mesh: usize) -> Result<Vec<Drawn<'_>>, FileFault> {
    let mut drawn = Vec::new();
    for (number, primitive) in root.meshes[mesh].primitives.iter().enumerate() {
        let at = format!("meshes[{mesh}].primitives[{number}]");
        if let Topology::Triangles(mode) = Topology::of(primitive, &at)? {
            drawn.push((number, primitive, mode));
        }
    }
    Ok(drawn)
}

/// What the file shows beside triangles.
fn other_geometry(root: &Root, placed: &Placed) -> Vec<&'static str> {
    let mut holds = Vec::new();
    let mut add = |what| {
        if !holds.contains(&what) {
            holds.push(what);
        }
    };
    let mut seen = vec![false; root.meshes.len()];
    for instance in &placed.instances {
        match seen.get_mut(instance.mesh) {
            Some(seen) if !*seen => *seen = true,
            _ => continue,
        }
        for primitive in &root.meshes[instance.mesh].primitives {
            match Topology::of(primitive, "") {
                Ok(Topology::Points) => add("points"),
                Ok(Topology::Lines) => add("lines"),
                Ok(Topology::Triangles(_)) | Err(_) => {}
            }
        }
    }
    if placed.hidden > 0 {
        add("hidden meshes");
    }
    holds
}

fn parse(json: &[u8], warnings: &mut Warnings) -> Result<Root, FileFault> {
    const AT: &str = "glTF JSON";
    let json = super::text::as_utf8(json, AT, warnings)?;
    // Braces within strings count too: names have few of them, base64 has none.
    let count = json.iter().filter(|&&byte| byte == b'{').count() as u64;
    if count > MAX_JSON_OBJECTS {
        return Err(FileFault::TooMany { at: AT.into(), what: "objects", count, limit: MAX_JSON_OBJECTS });
    }
    // Chunks of a GLB are padded, by some programs with zeros.
    let end = json.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    let parsed: Result<Root, _> = serde_json::from_slice(&json[..end]);
    let root = parsed.map_err(|error| match old_version(&json[..end]) {
        Some(version) => too_old(&version),
        None => FileFault::invalid(AT, error.to_string()),
    })?;
    let Some(asset) = &root.asset else {
        return Err(match old_version(&json[..end]) {
            Some(version) => too_old(&version),
            None => FileFault::invalid(AT, "missing field `asset`"),
        });
    };
    match asset.version.as_deref() {
        Some(version) if version.starts_with("2.") || version == "2" => {}
        Some(version) if version.starts_with('1') || version.starts_with('0') => {
            return Err(too_old(version));
        }
        Some(version) => return Err(FileFault::unsupported("asset", format!("glTF version {version:?}"))),
        None => return Err(FileFault::invalid("asset", "missing field `version`")),
    }
    extensions::check(&root, warnings)?;
    Ok(root)
}

fn too_old(version: &str) -> FileFault {
    let convert = "glTF 2.0 is read; convert the file with gltf-pipeline or Blender";
    FileFault::unsupported("asset", format!("glTF version {version:?}: {convert}"))
}

/// The version of a file whose lists are maps: glTF 1.0.
fn old_version(json: &[u8]) -> Option<String> {
    #[derive(serde::Deserialize)]
    struct Old {
        asset: Option<OldAsset>,
        #[serde(default)]
        meshes: serde_json::Value,
    }
    #[derive(serde::Deserialize)]
    struct OldAsset {
        #[serde(default)]
        version: serde_json::Value,
    }
    let old: Old = serde_json::from_slice(json).ok()?;
    let version = old.asset.map(|asset| asset.version).unwrap_or_default();
    let version = version.as_str().map(str::to_owned).or_else(|| version.as_f64().map(|v| format!("{v:.1}")));
    let version = version.or_else(|| old.meshes.is_object().then(|| "1.0".to_owned()))?;
    (version.starts_with('1') || version.starts_with('0')).then_some(version)
}
