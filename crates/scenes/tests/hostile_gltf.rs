//! Damaged and hostile glTF: always one clear line, never a panic, never memory beyond the file's size.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests fail by panicking and may report")]

mod glb;

use glb::{INDICES_AT, POSITIONS_AT, UVS_AT, quad};
use scenes::load_gltf_bytes;

fn message(bytes: &[u8]) -> String {
    let message = load_gltf_bytes("bad.glb", bytes).unwrap_err().to_string();
    assert!(message.starts_with("bad.glb: ") && !message.contains('\n') && message.len() < 500, "{message}");
    println!("{message}");
    message
}

/// The fixture with one piece of JSON replaced fails with a message that contains `expected`.
fn edited(from: &str, to: &str, expected: &str) {
    let message = message(&quad().with(from, to).bytes());
    assert!(message.contains(expected), "{to}: expected {expected:?} in {message:?}");
}

fn patched(at: usize, bytes: &[u8], expected: &str) {
    let message = message(&quad().with_bytes(at, bytes).bytes());
    assert!(message.contains(expected), "expected {expected:?} in {message:?}");
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = quad().bytes();
    for length in 0..bytes.len() {
        assert!(load_gltf_bytes("cut.glb", &bytes[..length]).is_err(), "{length} of {}", bytes.len());
    }
    assert!(message(&bytes[..7]).contains("GLB header: truncated: 7 of 12 bytes"));
    assert!(message(&bytes[..bytes.len() - 1]).contains("does not fit the file's"));
    assert!(message(b"").contains("glTF JSON: EOF"));
    assert!(message(b"not a scene").contains("glTF JSON: expected"));
}

#[test]
fn container_lengths_are_checked() {
    let whole = quad().bytes();
    let patch = |at: usize, word: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        message(&bytes)
    };
    for length in [0, 11, u32::MAX] {
        assert!(patch(8, length).contains(&format!("GLB header: length {length} does not fit")));
    }
    assert!(patch(8, 12).contains("GLB chunk at byte 12: truncated: 0 bytes left"));
    assert!(patch(4, 1).contains("unsupported version 1"));
    assert!(patch(12, u32::MAX).contains("GLB chunk at byte 12: length 4294967295 exceeds the"));
    assert!(patch(16, 0).contains("is not JSON"));
    let bin_header = 20 + u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    assert!(patch(bin_header, 0x7fff_fff0).contains("length 2147483632 exceeds the"));
    assert!(patch(bin_header + 4, 0).contains("buffers[0]: has no uri and no binary chunk"));
}

/// As [`edited`], for a stride of the first buffer view.
fn strided(stride: u64, expected: &str) {
    let view = "\"byteOffset\":0,\"byteLength\":48";
    edited(view, &format!("{view},\"byteStride\":{stride}"), expected);
}

/// As [`edited`], for the matrix of the camera's node.
fn placed(matrix: &str, expected: &str) {
    edited("[1,0,0,0,0,1,0,0,0,0,1,0,0,2,5,1]", matrix, expected);
}

#[test]
fn accessors_and_views_stay_inside_their_bytes() {
    edited(
        "\"count\":4,\"type\":\"VEC3\",\"min\"",
        "\"count\":5,\"type\":\"VEC3\",\"min\"",
        "accessors[0]: byteOffset 0 + 5 elements of 12 bytes, 12 apart, exceeds the 48 bytes of bufferViews[0]",
    );
    edited("\"count\":6", "\"count\":2147483648", "accessors[3]: byteOffset 0 + 2147483648 elements");
    edited(
        "\"count\":4,\"type\":\"VEC3\",\"min\"",
        "\"count\":18446744073709551615,\"type\":\"VEC3\",\"min\"",
        "accessors[0]",
    );
    edited(
        "{\"bufferView\":3,",
        "{\"bufferView\":3,\"byteOffset\":18446744073709551615,",
        "accessors[3]: byteOffset 18446744073709551615",
    );
    edited("{\"bufferView\":3,", "{\"bufferView\":9,", "bufferView");
    edited(
        "\"byteOffset\":128,\"byteLength\":12",
        "\"byteOffset\":128,\"byteLength\":99999",
        "bufferViews[3]: byteOffset 128 + byteLength 99999 exceeds the",
    );
    edited(
        "\"byteOffset\":128",
        "\"byteOffset\":18446744073709551610",
        "bufferViews[3]: byteOffset 18446744073709551610",
    );
    edited("\"buffers\":[{\"byteLength\":", "\"buffers\":[{\"byteLength\":9", "buffers[0]: byteLength 9");
    strided(4, "byteStride 4 is smaller than the element size 12");
    strided(16, "16 apart, exceeds the 48 bytes");
    strided(0, "byteStride 0 is smaller than the element size 12");
    strided(4000000000, "4000000000 apart, exceeds the 48 bytes");
}

#[test]
fn types_and_counts_must_fit() {
    edited(
        "\"count\":6,\"type\":\"SCALAR\"",
        "\"count\":4,\"type\":\"VEC2\"",
        "indices is of type VEC2, expected SCALAR",
    );
    edited(
        "{\"bufferView\":3,\"componentType\":5123",
        "{\"bufferView\":3,\"componentType\":5122",
        "indices are not unsigned integers",
    );
    edited("\"componentType\":5123", "\"componentType\":7", "unknown component type 7");
    edited("\"count\":6", "\"count\":2", "no triangles: the file holds no geometry");
    edited("\"count\":6", "\"count\":0", "no triangles: the file holds no geometry");
    edited(
        "\"count\":4,\"type\":\"VEC3\"}",
        "\"count\":3,\"type\":\"VEC3\"}",
        "3 attribute values for 4 positions",
    );
    edited("\"POSITION\":0,", "\"POSITION\":2,", "POSITION is of type VEC2, expected VEC3");
    edited("\"POSITION\":0,", "", "no triangles: the file holds no geometry");
    edited(
        "\"TEXCOORD_1\":2",
        "\"TEXCOORD_0\":2",
        "meshes[0].primitives[0]: has no TEXCOORD_1 for its alpha mask",
    );
    edited(
        "{\"bufferView\":0,",
        "{\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":3,\"componentType\":5125},\"values\":{\"bufferView\":0}},\"bufferView\":0,",
        "accessors[0].sparse: index 65536 is out of range, there are 4",
    );
}

#[test]
fn regression_position_accessor_out_of_range() {
    edited("\"POSITION\":0,", "\"POSITION\":77,", "accessors[77]: index 77 is out of range, there are 4");
}

#[test]
fn indices_and_numbers_out_of_range_are_named() {
    patched(
        INDICES_AT + 4,
        &4_u16.to_le_bytes(),
        "meshes[0].primitives[0]: indices[2]: index 4 is out of range, there are 4",
    );
    patched(INDICES_AT, &u16::MAX.to_le_bytes(), "index 65535 is out of range");
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        patched(POSITIONS_AT + 16, &bad.to_le_bytes(), "meshes[0].primitives[0]: POSITION 1: value [1.0, ");
        if !bad.is_finite() {
            patched(UVS_AT, &bad.to_le_bytes(), "meshes[0].primitives[0]: TEXCOORD_1 0 is [");
        }
    }
    edited("[10,0,0]", "[1e300,0,0]", "nodes[0]: translation [1e300, 0.0, 0.0] is not finite");
    edited("[10,0,0]", "[1e38,0,0]", "POSITION 0: value [1e38, 0.0, 0.0]");
    edited("[-1,1,1]", "[-1e39,1,1]", "nodes[1]: scale [-1e39, 1.0, 1.0] is not finite");
    edited("[1,0,0,0,0,1,0,0,0,0,1,0,0,2,5,1]", "[1,0,0,0,0,1,0,0,0,0,1e99,0,0,2,5,1]", "nodes[2]: matrix [");
    placed(
        "[1,0,0,0.5,0,1,0,0,0,0,1,0,0,2,5,1]",
        "nodes[2]: matrix with bottom row [0.5, 0.0, 0.0, 1.0] is not affine",
    );
    placed("[NaN,0,0,0,0,1,0,0,0,0,1,0,0,2,5,1]", "glTF JSON");
    edited(
        "\"translation\":[10,0,0]",
        "\"rotation\":[0,0,0,0]",
        "nodes[0]: rotation [0.0, 0.0, 0.0, 0.0] is no unit quaternion",
    );
    edited("\"alphaCutoff\":0.3", "\"alphaCutoff\":-0.5", "materials[0]: alphaCutoff -0.5");
    edited("[0.5,1,1,1]", "[0.5,1,1,1e99]", "materials[0]: baseColorFactor [0.5, 1.0, 1.0, 1e99] is outside");
}

#[test]
fn node_graphs_must_be_trees() {
    edited("\"scale\":[-1,1,1],", "\"scale\":[-1,1,1],\"children\":[0],", "nodes[0]: is reached twice");
    edited("\"children\":[1,2]", "\"children\":[1,1]", "nodes[1]: is reached twice");
    edited("\"children\":[1,2]", "\"children\":[0]", "nodes[0]: is reached twice");
    edited("\"children\":[1,2]", "\"children\":[1,99]", "nodes[99]: index 99 is out of range, there are 3");
    edited("\"scene\":0", "\"scene\":5", "scene: index 5 is out of range, there are 1");
}

#[test]
fn a_deep_chain_of_nodes_does_not_overflow_the_stack() {
    let levels = 300_000;
    let mut nodes: Vec<String> = (1..levels).map(|child| format!("{{\"children\":[{child}]}}")).collect();
    nodes.push("{\"mesh\":0}".into());
    let fixture = quad();
    let start = fixture.json.find("\"nodes\":[{\"tr").unwrap();
    let end = fixture.json.find("\"cameras\"").unwrap();
    let mut deep = fixture.clone();
    deep.json.replace_range(start..end, &format!("\"nodes\":[{}],\n", nodes.join(",")));
    assert_eq!(load_gltf_bytes("deep.glb", &deep.bytes()).unwrap().triangles.len(), 2 + 2);
    let json = format!("{{\"asset\":{}1{}}}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(message(json.as_bytes()).contains("glTF JSON: "));
}

#[test]
fn many_small_objects_are_refused_before_they_are_parsed() {
    let json = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}", "{},".repeat(1 << 20));
    assert!(message(json.as_bytes()).contains("glTF JSON: 1048579 objects exceed the limit of 1048576"));
}

/// Many instances of one mesh, in a small file, are many triangles.
#[test]
fn instancing_is_bounded() {
    let instances = 9_000;
    let children: Vec<String> = (1..=instances).map(|i| i.to_string()).collect();
    let nodes = vec!["{\"mesh\":0}"; instances].join(",");
    let triangles = 2_000;
    let mut glb = quad();
    glb.json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],
"nodes":[{{"children":[{}]}},{nodes}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5121,"count":{count},"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":{count}}}],
"buffers":[{{"byteLength":{length}}}]}}"#,
        children.join(","),
        count = 3 * triangles,
        length = 48 + 3 * triangles,
    );
    // All corners are corner 0: no triangle has area, and yet each counts towards the limit.
    glb.bin.resize(48, 0);
    glb.bin.resize(48 + 3 * triangles, 0);
    let message = message(&glb.bytes());
    assert!(message.contains("triangles exceed the limit of 16777216"), "{message}");
}

#[test]
fn nothing_to_render_is_an_error_with_the_count() {
    let zero_area = [0_u16; 6].iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<u8>>();
    patched(INDICES_AT, &zero_area, "no triangles: the file holds 2 degenerate triangles");
    edited("\"scale\":[-1,1,1]", "\"scale\":[0,0,0]", "no triangles: the file holds 2 degenerate triangles");
    edited("\"mode\":4", "\"mode\":1", "no triangles: the file holds only lines");
    edited("\"mode\":4", "\"mode\":0", "no triangles: the file holds only points");
    edited("\"mode\":4", "\"mode\":9", "mode 9 is not known");
    assert!(message(b"{\"asset\":{\"version\":\"2.0\"}}").contains("no triangles"));
    assert!(
        message(b"{\"asset\":{\"version\":\"1.0\"}}").contains("asset: unsupported glTF version \"1.0\"")
    );
    assert!(message(b"{}").contains("missing field `asset`"));
}

#[test]
fn extensions_that_change_the_data_are_unsupported_by_name() {
    for name in ["KHR_gaussian_splatting", "EXT_mesh_primitive_restart", "X\\nY"] {
        let required = format!("{{\"extensionsRequired\":[\"KHR_materials_unlit\",\"{name}\"],\"asset\"");
        edited("{\"asset\"", &required, &format!("extensionsRequired: unsupported extension \"{name}\""));
    }
}

#[test]
fn images_are_bounded_and_named() {
    let png_at = INDICES_AT + 12;
    // The width in the PNG header, with its checksum left wrong or made right.
    patched(png_at, b"GIF89a..", "images[0]: ");
    patched(png_at + 16, &[0, 1, 0, 0, 0, 1, 0, 0], "images[0]: ");
    let mut huge = glb::png();
    huge[16..24].copy_from_slice(&[0, 0, 0x60, 0, 0, 0, 0x60, 0]);
    let checksum = crc32(&huge[12..29]);
    huge[29..33].copy_from_slice(&checksum.to_be_bytes());
    patched(
        png_at,
        &huge,
        "images[0]: image of 24576 x 24576: 603979776 texels exceed the limit of 67108864",
    );
    let mut cut = glb::png();
    cut.truncate(40);
    cut.resize(glb::png().len(), 0);
    patched(png_at, &cut, "images[0]: image: ");
    edited(
        "{\"bufferView\":4,\"mimeType\":\"image/png\"}",
        "{\"mimeType\":\"image/png\"}",
        "images[0]: has neither",
    );
    edited(
        "\"textures\":[{\"source\":0}]",
        "\"textures\":[{\"source\":3}]",
        "images[3]: index 3 is out of range, there are 1",
    );
    edited("\"index\":0,", "\"index\":3,", "textures[3]: index 3 is out of range, there are 1");
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    })
}

#[test]
fn files_cannot_be_named_from_memory() {
    let uri = |uri: &str| format!("\"buffers\":[{{\"uri\":\"{uri}\",\"byteLength\":");
    edited(
        "\"buffers\":[{\"byteLength\":",
        &uri("scene.bin"),
        "buffers[0]: file \"scene.bin\" cannot be read: the scene comes from memory",
    );
    edited(
        "\"buffers\":[{\"byteLength\":",
        &uri("https://example.org/a.bin"),
        "buffers[0]: unsupported URI scheme \"https\"",
    );
    edited(
        "\"buffers\":[{\"byteLength\":",
        &uri("%2e%2e/a.bin"),
        "buffers[0]: file \"../a.bin\" does not lie in the scene's folder",
    );
    edited("\"buffers\":[{\"byteLength\":", &uri("data:;base64,AAAA"), "exceeds the 3 bytes that exist");
}
