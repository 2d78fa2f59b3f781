//! A small but complete GLB, made in the test: two nodes, a mirrored child, a camera, an alpha-masked quad of
//! two triangles with normals and texture coordinates, and a PNG in its binary chunk.

#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each test binary uses a part of it; tests fail by panicking"
)]

use std::io::Cursor;

/// JSON and binary chunk of a GLB under construction.
#[derive(Clone)]
pub struct Glb {
    pub json: String,
    pub bin: Vec<u8>,
}

/// Byte offsets of the parts of [`quad`]'s binary chunk.
pub const POSITIONS_AT: usize = 0;
pub const UVS_AT: usize = 96;
pub const INDICES_AT: usize = 128;

impl Glb {
    pub fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.clone().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let total = 12 + 8 + json.len() + 8 + bin.len();
        let mut bytes = b"glTF".to_vec();
        for word in [2, total as u32, json.len() as u32] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(b"JSON");
        bytes.extend(&json);
        bytes.extend((bin.len() as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(&bin);
        bytes
    }

    /// Replaces `from`, which must occur, everywhere in the JSON.
    #[must_use]
    pub fn with(&self, from: &str, to: &str) -> Self {
        assert!(self.json.contains(from), "the fixture has no {from:?}");
        Self { json: self.json.replace(from, to), bin: self.bin.clone() }
    }

    #[must_use]
    pub fn with_bytes(&self, at: usize, bytes: &[u8]) -> Self {
        let mut changed = self.clone();
        changed.bin[at..at + bytes.len()].copy_from_slice(bytes);
        changed
    }
}

/// A 2 x 1 PNG: left texel opaque red, right texel black with alpha 64.
pub fn png() -> Vec<u8> {
    let mut image = image::RgbaImage::new(2, 1);
    image.put_pixel(0, 0, image::Rgba([255, 0, 0, 255]));
    image.put_pixel(1, 0, image::Rgba([0, 0, 0, 64]));
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A unit quad in the plane z = 0 facing +z, under a node moved by (10, 0, 0) and its child mirrored in x.
pub fn quad() -> Glb {
    let mut bin = Vec::new();
    let floats = |bin: &mut Vec<u8>, values: &[f32]| bin.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    floats(&mut bin, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    floats(&mut bin, &[0.0, 0.0, 1.0].repeat(4));
    floats(&mut bin, &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    bin.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    let png = png();
    bin.extend(&png);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},
"scene":0,"scenes":[{{"nodes":[0]}}],
"nodes":[{{"translation":[10,0,0],"children":[1,2]}},
 {{"scale":[-1,1,1],"mesh":0}},
 {{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,2,5,1],"camera":0}}],
"cameras":[{{"type":"perspective","perspective":{{"yfov":0.5,"znear":0.1}}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_1":2}},
 "indices":3,"material":0,"mode":4}}]}}],
"materials":[{{"name":"leaf","alphaMode":"MASK","alphaCutoff":0.3,
 "pbrMetallicRoughness":{{"baseColorFactor":[0.5,1,1,1],"baseColorTexture":{{"index":0,"texCoord":1}}}}}}],
"textures":[{{"source":0}}],"images":[{{"bufferView":4,"mimeType":"image/png"}}],
"accessors":[
 {{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
 {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC3"}},
 {{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}},
 {{"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"}}],
"bufferViews":[
 {{"buffer":0,"byteOffset":0,"byteLength":48}},
 {{"buffer":0,"byteOffset":48,"byteLength":48}},
 {{"buffer":0,"byteOffset":96,"byteLength":32}},
 {{"buffer":0,"byteOffset":128,"byteLength":12}},
 {{"buffer":0,"byteOffset":140,"byteLength":{png_length}}}],
"buffers":[{{"byteLength":{length}}}]}}"#,
        png_length = png.len(),
        length = bin.len(),
    );
    Glb { json, bin }
}
