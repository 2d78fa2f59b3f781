//! The parts of glTF's JSON that a scene is made from.
//!
//! Read by serde and not by the `gltf` crate, which refuses whole files for what no shadow depends on: `extras` that are no
//! object, attributes of applications, textures without source, channels without node. Whatever is not named here is skipped.

use std::collections::BTreeMap;

use serde::de::{Deserializer, Error, Unexpected, Visitor};
use serde::{Deserialize, de};

/// Index or count. `24.0` is written by some programs and is the same number as 24.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Whole(pub u64);

impl Whole {
    pub(super) fn index(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = Whole;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a whole number from 0 up")
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Whole, E> {
                Ok(Whole(value))
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Whole, E> {
                /// Whole numbers up to here are exact.
                const EXACT: f64 = (1_u64 << 53) as f64;
                if (0.0..=EXACT).contains(&value) && value.fract() == 0.0 {
                    Ok(Whole(value as u64))
                } else {
                    Err(E::invalid_value(Unexpected::Float(value), &self))
                }
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

/// A name, where it is text; anything else is no reason to refuse a scene.
fn text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    let value = serde_json::Value::deserialize(deserializer)?;
    Ok(value.as_str().map(str::to_owned))
}

/// Lists and maps may be `null`, as some programs write empty ones.
fn or_default<'de, D: Deserializer<'de>, T: Deserialize<'de> + Default>(d: D) -> Result<T, D::Error> {
    Ok(Option::<T>::deserialize(d)?.unwrap_or_default())
}

macro_rules! objects {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_attr:meta])* $field:ident: $kind:ty,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, Default, Deserialize)]
        #[serde(rename_all = "camelCase", default)]
        pub(super) struct $name { $($(#[$field_attr])* pub $field: $kind,)* }
    )*};
}

objects! {
    Root {
        asset: Option<Asset>,
        #[serde(deserialize_with = "or_default")]
        extensions_required: Vec<String>,
        #[serde(deserialize_with = "or_default")]
        extensions_used: Vec<String>,
        scene: Option<Whole>,
        #[serde(deserialize_with = "or_default")]
        scenes: Vec<SceneNodes>,
        #[serde(deserialize_with = "or_default")]
        nodes: Vec<Node>,
        #[serde(deserialize_with = "or_default")]
        meshes: Vec<Mesh>,
        #[serde(deserialize_with = "or_default")]
        accessors: Vec<Accessor>,
        #[serde(deserialize_with = "or_default")]
        buffer_views: Vec<BufferView>,
        #[serde(deserialize_with = "or_default")]
        buffers: Vec<Buffer>,
        #[serde(deserialize_with = "or_default")]
        materials: Vec<Material>,
        #[serde(deserialize_with = "or_default")]
        textures: Vec<Texture>,
        #[serde(deserialize_with = "or_default")]
        images: Vec<Image>,
        #[serde(deserialize_with = "or_default")]
        samplers: Vec<Sampler>,
        #[serde(deserialize_with = "or_default")]
        cameras: Vec<Camera>,
        #[serde(deserialize_with = "or_default")]
        skins: Vec<Skin>,
        #[serde(deserialize_with = "or_default")]
        animations: Vec<Animation>,
        extensions: Option<RootExtensions>,
    }
    Asset {
        #[serde(deserialize_with = "text")]
        version: Option<String>,
    }
    SceneNodes {
        #[serde(deserialize_with = "or_default")]
        nodes: Vec<Whole>,
    }
    Node {
        #[serde(deserialize_with = "text")]
        name: Option<String>,
        #[serde(deserialize_with = "or_default")]
        children: Vec<Whole>,
        camera: Option<Whole>,
        mesh: Option<Whole>,
        skin: Option<Whole>,
        matrix: Option<[f64; 16]>,
        translation: Option<[f64; 3]>,
        rotation: Option<[f64; 4]>,
        scale: Option<[f64; 3]>,
        weights: Option<Vec<f64>>,
        extensions: Option<NodeExtensions>,
    }
    NodeExtensions {
        #[serde(rename = "EXT_mesh_gpu_instancing")]
        instancing: Option<Instancing>,
        #[serde(rename = "KHR_lights_punctual")]
        light: Option<LightReference>,
        #[serde(rename = "KHR_node_visibility")]
        visibility: Option<Visibility>,
    }
    Instancing { attributes: BTreeMap<String, Whole>, }
    LightReference { light: Whole, }
    Visibility { visible: Option<bool>, }
    Mesh {
        #[serde(deserialize_with = "or_default")]
        primitives: Vec<Primitive>,
        weights: Option<Vec<f64>>,
    }
    Primitive {
        #[serde(deserialize_with = "or_default")]
        attributes: BTreeMap<String, Whole>,
        indices: Option<Whole>,
        material: Option<Whole>,
        mode: Option<Whole>,
        #[serde(deserialize_with = "or_default")]
        targets: Vec<BTreeMap<String, Whole>>,
        extensions: Option<PrimitiveExtensions>,
    }
    PrimitiveExtensions {
        #[serde(rename = "KHR_draco_mesh_compression")]
        draco: Option<Draco>,
    }
    Draco { buffer_view: Whole, attributes: BTreeMap<String, Whole>, }
    Accessor {
        buffer_view: Option<Whole>,
        byte_offset: Option<Whole>,
        component_type: Whole,
        normalized: bool,
        count: Whole,
        #[serde(rename = "type")]
        kind: String,
        min: Option<de::IgnoredAny>,
        max: Option<de::IgnoredAny>,
        sparse: Option<Sparse>,
    }
    Sparse { count: Whole, indices: SparseIndices, values: SparseValues, }
    SparseIndices { buffer_view: Whole, byte_offset: Option<Whole>, component_type: Whole, }
    SparseValues { buffer_view: Whole, byte_offset: Option<Whole>, }
    BufferView {
        buffer: Whole,
        byte_offset: Option<Whole>,
        byte_length: Whole,
        byte_stride: Option<Whole>,
        extensions: Option<BufferViewExtensions>,
    }
    BufferViewExtensions {
        #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
        meshopt: Option<Meshopt>,
    }
    Meshopt {
        buffer: Whole,
        byte_offset: Option<Whole>,
        byte_length: Whole,
        byte_stride: Whole,
        count: Whole,
        mode: String,
        filter: Option<String>,
    }
    Buffer { uri: Option<String>, byte_length: Whole, extensions: Option<BufferExtensions>, }
    BufferExtensions {
        #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
        meshopt: Option<Fallback>,
    }
    Fallback { fallback: bool, }
    Material {
        #[serde(deserialize_with = "text")]
        name: Option<String>,
        pbr_metallic_roughness: Option<Pbr>,
        #[serde(deserialize_with = "text")]
        alpha_mode: Option<String>,
        alpha_cutoff: Option<f64>,
        extensions: Option<MaterialExtensions>,
    }
    Pbr {
        base_color_factor: Option<[f64; 4]>,
        base_color_texture: Option<TextureInfo>,
        metallic_factor: Option<f64>,
        metallic_roughness_texture: Option<TextureInfo>,
    }
    MaterialExtensions {
        #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
        specular_glossiness: Option<SpecularGlossiness>,
        #[serde(rename = "KHR_materials_transmission")]
        transmission: Option<Transmission>,
    }
    Transmission { transmission_factor: Option<f64>, transmission_texture: Option<TextureInfo>, }
    SpecularGlossiness { diffuse_factor: Option<[f64; 4]>, diffuse_texture: Option<TextureInfo>, }
    TextureInfo { index: Whole, tex_coord: Option<Whole>, extensions: Option<TextureInfoExtensions>, }
    TextureInfoExtensions {
        #[serde(rename = "KHR_texture_transform")]
        transform: Option<TextureTransform>,
    }
    TextureTransform {
        offset: Option<[f64; 2]>,
        rotation: Option<f64>,
        scale: Option<[f64; 2]>,
        tex_coord: Option<Whole>,
    }
    Texture { sampler: Option<Whole>, source: Option<Whole>, extensions: Option<TextureExtensions>, }
    TextureExtensions {
        #[serde(rename = "EXT_texture_webp")]
        webp: Option<TextureSource>,
        #[serde(rename = "MSFT_texture_dds")]
        dds: Option<TextureSource>,
        #[serde(rename = "KHR_texture_basisu")]
        basisu: Option<TextureSource>,
        #[serde(rename = "EXT_texture_avif")]
        avif: Option<TextureSource>,
    }
    TextureSource { source: Option<Whole>, }
    Image { uri: Option<String>, buffer_view: Option<Whole>, }
    Sampler { wrap_s: Option<Whole>, wrap_t: Option<Whole>, }
    Camera {
        #[serde(deserialize_with = "text")]
        name: Option<String>,
        perspective: Option<Perspective>,
    }
    Perspective { yfov: f64, }
    Skin { inverse_bind_matrices: Option<Whole>, #[serde(deserialize_with = "or_default")] joints: Vec<Whole>, }
    Animation {
        #[serde(deserialize_with = "text")]
        name: Option<String>,
        #[serde(deserialize_with = "or_default")]
        channels: Vec<Channel>,
        #[serde(deserialize_with = "or_default")]
        samplers: Vec<AnimationSampler>,
    }
    Channel { sampler: Whole, target: Target, }
    Target { node: Option<Whole>, path: String, extensions: Option<TargetExtensions>, }
    TargetExtensions {
        #[serde(rename = "KHR_animation_pointer")]
        pointer: Option<Pointer>,
    }
    Pointer { pointer: String, }
    AnimationSampler { input: Whole, output: Whole, interpolation: Option<String>, }
    RootExtensions {
        #[serde(rename = "KHR_lights_punctual")]
        lights: Option<Lights>,
        #[serde(rename = "CESIUM_RTC")]
        rtc: Option<Centre>,
    }
    Centre { center: [f64; 3], }
    Lights { #[serde(deserialize_with = "or_default")] lights: Vec<Light>, }
    Light {
        #[serde(deserialize_with = "text")]
        name: Option<String>,
        #[serde(rename = "type", deserialize_with = "text")]
        kind: Option<String>,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nothing_depends_on_may_be_anything() {
        let text = r#"{"asset":{"version":"2.0","extras":"none"},"extras":[1],"nodes":[{"name":7,"mesh":1.0,"children":null}],
            "scenes":[{}],"materials":[{"alphaMode":3}]}"#;
        let root: Root = serde_json::from_str(text).unwrap();
        assert_eq!(root.nodes[0].mesh, Some(Whole(1)));
        assert!(root.nodes[0].name.is_none() && root.scenes[0].nodes.is_empty());
        for bad in ["1.5", "-1", "\"1\"", "1e99"] {
            let text = format!(r#"{{"nodes":[{{"mesh":{bad}}}]}}"#);
            let message = serde_json::from_str::<Root>(&text).unwrap_err().to_string();
            assert!(message.contains("a whole number from 0 up"), "{bad}: {message}");
        }
    }
}
