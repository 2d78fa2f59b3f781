//! What a correct glTF becomes.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking and may report")]

mod glb;

use glb::{Glb, quad};
use scenes::{Scene, load_gltf_bytes};

fn load(glb: &Glb) -> Scene {
    load_gltf_bytes("fixture.glb", &glb.bytes()).unwrap()
}

fn first_triangle(scene: &Scene) -> [[f32; 3]; 3] {
    scene.triangles[0].map(|i| scene.vertices[i as usize].position)
}

#[test]
fn transforms_reach_positions_normals_and_winding() {
    let scene = load(&quad());
    // Mirrored in x, then moved: corners swap so that the front still faces +z.
    assert_eq!(first_triangle(&scene), [[10.0, 0.0, 0.0], [9.0, 1.0, 0.0], [9.0, 0.0, 0.0]]);
    assert_eq!(scene.vertices[0].normal, [0.0, 0.0, 1.0]);
    let names: Vec<&str> = scene.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(names, ["default", "wide", "lamp"]);
    assert_eq!(scene.views[0].direction, [0.8, -0.6, 0.35]);
}

#[test]
fn the_files_camera_is_used() {
    let camera = load(&quad()).camera;
    assert_eq!((camera.eye, camera.vertical_fov, camera.up), ([10.0, 2.0, 5.0], 0.5, [0.0, 1.0, 0.0]));
    assert!(camera.target[..2] == [10.0, 2.0] && camera.target[2] < 5.0, "{:?}", camera.target);
    let fitted = load(&quad().with(r#","camera":0"#, "")).camera;
    assert!(fitted.eye[2] > 0.5 && fitted.target[0] > 9.0 && fitted.target[0] < 10.0);
}

#[test]
fn masks_keep_alpha_cutoff_and_their_texture_coordinates() {
    let scene = load(&quad());
    let leaf = &scene.materials[0];
    let mask = leaf.mask.as_ref().unwrap();
    // 0.3 * 255 = 76.5
    assert_eq!((mask.width, mask.height, mask.cutoff, mask.alpha.as_slice()), (2, 1, 77, &[255, 64][..]));
    let uvs: Vec<_> = scene.vertices[..4].iter().map(|v| v.uv).collect();
    assert_eq!(uvs, [[0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]]);
    // Mean of red and black in linear light, times the factor 0.5.
    assert_eq!((leaf.name.as_str(), leaf.albedo), ("leaf", [0.25, 0.0, 0.0]));
    assert!(load(&quad().with("MASK", "OPAQUE")).materials[0].mask.is_none());
}

#[test]
fn the_factor_s_alpha_multiplies_the_texture_s() {
    let scene = load(&quad().with("[0.5,1,1,1]", "[1,1,1,0.5]"));
    assert_eq!(scene.materials[0].mask.as_ref().unwrap().cutoff, 153);
}

#[test]
fn texture_transforms_move_the_mask() {
    let extension = r#""texCoord":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0],"scale":[2,1],"texCoord":1}}"#;
    let scene = load(&quad().with(r#""texCoord":1"#, extension));
    assert_eq!(scene.vertices[0].uv, [0.5, 1.0]);
    assert_eq!(scene.vertices[1].uv, [2.5, 0.0]);
}

#[test]
fn strips_and_fans_turn_the_same_way_as_lists() {
    let facing = |glb: &Glb| -> Vec<f32> {
        let scene = load(glb);
        let front = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| scene.vertices[i as usize].position);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        scene.triangles.iter().take(2).map(front).collect()
    };
    let indices = |order: [u16; 4]| order.iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<u8>>();
    let four = quad().with("\"count\":6", "\"count\":4");
    let strip = four.with("\"mode\":4", "\"mode\":5").with_bytes(glb::INDICES_AT, &indices([0, 1, 3, 2]));
    let fan = four.with("\"mode\":4", "\"mode\":6").with_bytes(glb::INDICES_AT, &indices([0, 1, 2, 3]));
    for glb in [&quad(), &strip, &fan] {
        assert_eq!(facing(glb), [1.0, 1.0], "{}", glb.json);
    }
    assert_eq!(facing(&quad().with("[-1,1,1]", "[1,1,1]")), [1.0, 1.0], "not mirrored");
}

#[test]
fn missing_normals_are_flat_and_unused_vertices_left_out() {
    let scene = load(&quad().with(r#""NORMAL":1,"#, ""));
    // Zero stands for the triangle's own.
    assert_eq!(scene.vertices[2].normal, [0.0; 3]);
    let one_triangle = load(&quad().with("\"count\":6", "\"count\":3"));
    let ground = 4;
    assert_eq!(one_triangle.vertices.len(), 3 + ground);
}

#[test]
fn ground_is_added_once_and_only_where_there_is_none() {
    let count = |scene: &Scene| scene.materials.iter().filter(|m| m.name == "ground_added").count();
    assert_eq!(count(&load(&quad())), 1, "a standing quad has no ground");
    assert_eq!(count(&load(&quad().with("\"leaf\"", "\"The Floor\""))), 0, "its name says so");
    assert_eq!(count(&load(&quad().with("\"leaf\"", "\"ground_added\""))), 1, "not twice");
    let lying = quad().with(r#""scale":[-1,1,1]"#, r#""rotation":[-0.70710678,0,0,0.70710678]"#);
    assert_eq!(count(&load(&lying)), 0, "a quad that lies flat is ground");
}

#[test]
fn quantized_positions_and_data_uris_are_read() {
    // Positions as normalised bytes, 4 bytes apart.
    let corners: [u8; 16] = [0, 0, 0, 9, 127, 0, 0, 9, 127, 127, 0, 9, 0, 127, 0, 9];
    let quantized = quad()
        .with(r#"{"asset""#, r#"{"extensionsRequired":["KHR_mesh_quantization"],"asset""#)
        .with(
            r#"{"bufferView":0,"componentType":5126,"count":4"#,
            r#"{"bufferView":0,"componentType":5120,"normalized":true,"count":4"#,
        )
        .with(r#""byteOffset":0,"byteLength":48"#, r#""byteOffset":0,"byteLength":48,"byteStride":4"#)
        .with_bytes(glb::POSITIONS_AT, &corners);
    assert_eq!(first_triangle(&load(&quantized)), [[10.0, 0.0, 0.0], [9.0, 1.0, 0.0], [9.0, 0.0, 0.0]]);

    let length = quad().bin.len();
    let encoded = {
        use base64::Engine;
        base64::engine::general_purpose::STANDARD.encode(quad().bin)
    };
    let textual = quad().with(
        &format!(r#"[{{"byteLength":{length}}}]"#),
        &format!(r#"[{{"byteLength":{length},"uri":"data:application/octet-stream;base64,{encoded}"}}]"#),
    );
    let scene = load_gltf_bytes("fixture.gltf", textual.json.as_bytes()).unwrap();
    assert_eq!(first_triangle(&scene), first_triangle(&load(&quad())));
}

#[test]
fn degenerate_triangles_are_counted_and_the_rest_is_kept() {
    let zero_area = [0_u16, 1, 1].iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<u8>>();
    let scene = load(&quad().with_bytes(glb::INDICES_AT, &zero_area));
    assert_eq!(scene.degenerate_triangles, 1);
    assert_eq!(scene.triangles.len(), 1 + 2, "one and the ground");
}

#[test]
fn points_and_lines_are_skipped() {
    let second = r#""mode":4},{"attributes":{"POSITION":0},"mode":1},{"attributes":{"POSITION":0},"mode":0}"#;
    let scene = load(&quad().with(r#""mode":4}"#, second));
    assert_eq!(scene.triangles.len(), 2 + 2);
}
