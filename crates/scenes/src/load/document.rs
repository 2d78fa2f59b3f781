//! glTF 2.0, binary and textual.

use std::borrow::Cow;

use gltf::json::Root;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::Loaded;
use super::accessor::{Buffers, out_of_range};
use super::glb;
use super::material::Materials;
use super::node::flatten;
use super::primitive::{Source, is_triangles};
use super::source::Folder;
use crate::arrays::SceneArrays;
use crate::error::FileFault;

/// Required extensions that change neither geometry nor alpha, or that the accessors read anyhow.
const HARMLESS_EXTENSIONS: [&str; 10] = [
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_materials_unlit",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_texture_transform",
];

/// Most JSON objects of a document. An empty one takes three bytes in the file and hundreds in memory.
const MAX_JSON_OBJECTS: u64 = 1 << 20;

pub(super) fn load(bytes: &[u8], folder: &mut Folder) -> Result<Loaded, FileFault> {
    let (json, binary) = if glb::is_glb(bytes) { glb::split(bytes)? } else { (bytes, None) };
    let root = parse(json)?;
    let buffers = read_buffers(&root, binary, folder)?;
    let (instances, camera) = flatten(&root)?;
    let mut materials = Materials::new(&root, &buffers, folder);
    let mut arrays = SceneArrays::default();
    // Filtered once for each mesh, not for each instance: both may be many.
    let drawn: Vec<Vec<(usize, &Primitive)>> = root
        .meshes
        .iter()
        .map(|mesh| {
            mesh.primitives.iter().enumerate().filter(|(_, primitive)| is_triangles(primitive)).collect()
        })
        .collect();
    for instance in &instances {
        let Some(primitives) = drawn.get(instance.mesh) else {
            return Err(out_of_range("meshes".into(), instance.mesh, root.meshes.len()));
        };
        for &(number, primitive) in primitives {
            let (material, uv_map) = materials.index(primitive.material)?;
            let at = format!("meshes[{}].primitives[{number}]", instance.mesh);
            let source = Source { root: &root, buffers: &buffers, primitive, at };
            let mesh = source.mesh(&arrays, &instance.world_from_mesh, uv_map.as_ref())?;
            arrays.push(&mesh, material);
        }
    }
    let materials = materials.scene;
    Ok(Loaded { arrays, materials, camera })
}

fn parse(json: &[u8]) -> Result<Root, FileFault> {
    // Braces within strings count too: names have few of them, base64 has none.
    let count = json.iter().filter(|&&byte| byte == b'{').count() as u64;
    if count > MAX_JSON_OBJECTS {
        let at = "glTF JSON".into();
        return Err(FileFault::TooMany { at, what: "objects", count, limit: MAX_JSON_OBJECTS });
    }
    let mut root: Root = gltf::json::deserialize::from_slice(json)
        .map_err(|error| FileFault::invalid("glTF JSON", error.to_string()))?;
    if !root.asset.version.starts_with("2.") {
        return Err(FileFault::unsupported("asset", format!("glTF version {:?}", root.asset.version)));
    }
    root.extensions_required.retain(|name| !HARMLESS_EXTENSIONS.contains(&name.as_str()));
    if let Some(name) = root.extensions_required.first() {
        return Err(FileFault::unsupported("extensionsRequired", format!("extension {name:?}")));
    }
    // The crate's validation indexes the accessors with these before it has checked them.
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let position = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
            if let Some(index) = position.filter(|index| index.value() >= root.accessors.len()) {
                let at = format!("meshes[{m}].primitives[{p}].attributes.POSITION");
                return Err(out_of_range(at, index.value(), root.accessors.len()));
            }
        }
    }
    let document = gltf::Document::from_json(root).map_err(|error| match error {
        gltf::Error::Validation(errors) => match errors.first() {
            Some((path, error)) => {
                let more = if errors.len() > 1 {
                    format!(" (and {} more)", errors.len() - 1)
                } else {
                    String::new()
                };
                FileFault::invalid(crate::error::one_line(path.as_str()), format!("{error}{more}"))
            }
            None => FileFault::invalid("glTF", "is not valid"),
        },
        error => FileFault::invalid("glTF", error.to_string()),
    })?;
    Ok(document.into_json())
}

fn read_buffers<'a>(
    root: &Root,
    binary: Option<&'a [u8]>,
    folder: &mut Folder,
) -> Result<Buffers<'a>, FileFault> {
    let mut buffers = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        let at = format!("buffers[{i}]");
        let bytes = match (&buffer.uri, binary) {
            (Some(uri), _) => Cow::Owned(folder.read_uri(uri, &at)?),
            (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
            (None, _) => return Err(FileFault::invalid(at, "has no uri and no binary chunk")),
        };
        let claimed = buffer.byte_length.0;
        if (bytes.len() as u64) < claimed {
            let problem = format!("byteLength {claimed} exceeds the {} bytes that exist", bytes.len());
            return Err(FileFault::invalid(at, problem));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}
