//! Which extensions are read, which leave geometry and alpha alone, and which do not.

use super::json::Root;
use crate::error::FileFault;
use crate::load::warnings::{WarningKind, Warnings};

/// Extensions of geometry, place and alpha that are read.
const READ: [&str; 14] = [
    "CESIUM_RTC",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "MSFT_texture_dds",
];

/// Extensions that move nothing, by the beginning of their names: materials and textures, data of applications, sound,
/// interaction, the environment. A texture that is not read is told of where it is used.
const HARMLESS: [&str; 31] = [
    "ADOBE_materials_",
    "AGI_",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_lights_",
    "EXT_materials_",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_mesh_primitive_edge_visibility",
    "EXT_property",
    "EXT_structural_metadata",
    "EXT_texture_",
    "FB_",
    "GODOT_",
    "GOOGLE_",
    "KHR_audio",
    "KHR_environment_map",
    "KHR_interactivity",
    "KHR_materials_",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_technique",
    "KHR_texture_",
    "KHR_xmp",
    "MOZ_",
    "MPEG_texture_",
    "MSFT_",
    "NV_materials_",
    "OMI_",
    "UNITY_",
    "VRM",
];

/// Fails for an extension that is required and may place or change geometry; warns of one that is only used.
pub(super) fn check(root: &Root, warnings: &mut Warnings) -> Result<(), FileFault> {
    let is_known = |name: &str| READ.contains(&name) || HARMLESS.iter().any(|known| name.starts_with(known));
    if let Some(name) = root.extensions_required.iter().find(|name| !is_known(name)) {
        return Err(FileFault::unsupported("extensionsRequired", format!("extension {name:?}")));
    }
    for name in root.extensions_used.iter().filter(|name| !is_known(name)) {
        warnings.add(WarningKind::UnreadExtension, name, || {
            format!("extensionsUsed: extension {name:?} is not read, and may change what is shown")
        });
    }
    Ok(())
}
