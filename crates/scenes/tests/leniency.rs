//! Files that break rules no shadow depends on, compressed data, alpha, and polygons.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking and may report")]

mod fixture;
#[path = "leniency/opacity.rs"]
mod opacity;

use fixture::{Parts, area, assert_bounds, mesh, square};
use scenes::{LoadOptions, Scene, WarningKind, load_obj_bytes, load_with_files};

const ONE_NODE: &str = r#""scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}]"#;

fn kinds(scene: &Scene) -> Vec<WarningKind> {
    scene.warnings.iter().map(|warning| warning.kind).collect()
}

#[test]
fn what_no_shadow_depends_on_is_read_over() {
    let parts = square();
    for more in [
        r#""extras":"text""#,
        r#""extensionsRequired":["KHR_texture_basisu","KHR_materials_volume","KHR_materials_variants","KHR_xmp_json_ld"]"#,
        r#""extensionsUsed":["EXT_mesh_features"],"textures":[{}],"animations":[{"channels":[{"sampler":0,"target":{"path":"rotation"}}],"samplers":[{"input":0,"output":0}]}]"#,
        r#""materials":[{"name":3,"extras":[1],"emissiveFactor":"red"}]"#,
        r#""scene":0.0"#,
    ] {
        let scene = parts.load(&format!("{ONE_NODE},{},{more}", mesh(r#","_HEAT":0,"__BARYCENTRIC":0"#)));
        assert_eq!((scene.triangles.len(), scene.warnings.len()), (4, 0), "{more}");
    }
    let unread = parts.load(&format!(r#"{ONE_NODE},{},"extensionsUsed":["X_fold"]"#, mesh("")));
    assert_eq!(kinds(&unread), [WarningKind::UnreadExtension]);
    // The same in UTF-16 and behind a byte order mark.
    let text = parts.json(&format!("{ONE_NODE},{}", mesh("")));
    let utf16: Vec<u8> =
        [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let marked = [b"\xef\xbb\xbf", text.as_bytes()].concat();
    for (bytes, kind) in [(utf16, WarningKind::Encoding), (marked, WarningKind::ByteOrderMark)] {
        let scene = scenes::load_gltf_bytes("text.gltf", &bytes).unwrap();
        assert_eq!((scene.triangles.len(), kinds(&scene)), (4, vec![kind]));
    }
    let old = r#"{"asset":{"version":"1.0"},"accessors":{"a":{}},"meshes":{"m":{}},"scenes":{"s":{}}}"#;
    let message = scenes::load_gltf_bytes("old.gltf", old.as_bytes()).unwrap_err().to_string();
    assert!(message.contains("unsupported glTF version \"1.0\""), "{message}");
}

#[test]
fn strictness_makes_warnings_errors() {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("strict.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2//1 3//1\nf 1 2\n").unwrap();
    let load =
        |strict| load_with_files(path.to_str().unwrap(), &LoadOptions { strict, ..LoadOptions::default() });
    assert_eq!(kinds(&load(false).unwrap().0), [WarningKind::Normals, WarningKind::ShortFace]);
    let message = load(true).unwrap_err().to_string();
    assert!(message.contains("line 4: normal 1 of \"1//1\" is out of range"), "{message}");
    assert!(message.contains("and 1 more warnings"), "{message}");
}

#[test]
fn sparse_accessors_replace_elements_of_a_view_or_of_zeros() {
    let mut parts = Parts::default();
    let view = parts.view(&fixture::SQUARE.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>());
    let which = parts.view(&[2, 3]);
    let values = parts
        .view(&[1.0_f32, 3.0, 0.0, 0.0, 3.0, 0.0].iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>());
    let sparse = |indices: usize, count: usize| {
        format!(
            r#""sparse":{{"count":{count},"indices":{{"bufferView":{indices},"componentType":5121}},"values":{{"bufferView":{values}}}}}"#
        )
    };
    let accessor = |base: &str, sparse: &str| {
        format!(r#"{{{base}"componentType":5126,"count":4,"type":"VEC3","min":[0],"max":[0],{sparse}}}"#)
    };
    let with = |json: &str| {
        let mut parts = parts.clone();
        parts.raw(json);
        parts.shorts("SCALAR", &fixture::SQUARE_INDICES);
        parts
    };
    let rest = format!("{ONE_NODE},{}", mesh(""));
    let based = with(&accessor(&format!(r#""bufferView":{view},"#), &sparse(which, 2)));
    assert_bounds(&based.load(&rest), [0.0; 3], [1.0, 3.0, 0.0]);
    let zeros = with(&accessor("", &sparse(which, 2)));
    assert_eq!(zeros.load(&rest).degenerate_triangles, 1);
    let descending = parts.view(&[3, 2]);
    let beyond = parts.view(&[2, 4]);
    let with = |json: &str| {
        let mut parts = parts.clone();
        parts.raw(json);
        parts.shorts("SCALAR", &fixture::SQUARE_INDICES);
        parts.refused(&rest)
    };
    assert!(
        with(&accessor("", &sparse(descending, 2)))
            .contains("accessors[0].sparse: indices 3 and 2 do not ascend")
    );
    assert!(
        with(&accessor("", &sparse(beyond, 2)))
            .contains("accessors[0].sparse: index 4 is out of range, there are 4")
    );
    assert!(with(&accessor("", &sparse(which, 200))).contains("200 indices of 1 bytes exceeds the 2 bytes"));
}

#[test]
fn meshopt_views_are_decoded_and_their_sizes_checked_first() {
    let corners: Vec<[f32; 3]> = fixture::SQUARE.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
    let vertices = meshopt::encode_vertex_buffer(&corners).unwrap();
    let indices = meshopt::encode_index_buffer(&[0, 1, 2, 0, 2, 3], 4).unwrap();
    let file = |count: u64, stride: u64, mode: &str, extra: &str| {
        let mut parts = Parts::default();
        let (v, i) = (parts.view(&vertices), parts.view(&indices));
        let compressed = |of: usize, count: u64, stride: u64, mode: &str, length: usize| {
            // Buffer views of this fixture begin at multiples of four, the first at zero.
            let offset = if of == v { 0 } else { vertices.len().next_multiple_of(4) };
            format!(
                r#"{{"buffer":1,"byteLength":0,"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":{offset},
                "byteLength":{length},"byteStride":{stride},"count":{count},"mode":"{mode}"{extra}}}}}}}"#
            )
        };
        let a = parts.raw_view(&compressed(v, count, stride, mode, vertices.len()));
        let b = parts.raw_view(&compressed(i, 6, 2, "TRIANGLES", indices.len()).replace(extra, ""));
        parts.raw(&format!(
            r#"{{"bufferView":{a},"componentType":5126,"count":4,"type":"VEC3","min":[0],"max":[0]}}"#
        ));
        parts.raw(&format!(r#"{{"bufferView":{b},"componentType":5123,"count":6,"type":"SCALAR"}}"#));
        let fallback = r#","uri":"data:application/octet-stream;base64,"#;
        let json = parts.json(&format!("{ONE_NODE},{}", mesh("")));
        let end = json.find(fallback).map(|at| at + json[at..].find('}').unwrap() + 1).unwrap();
        format!(
            r#"{},{{"byteLength":99,"extensions":{{"EXT_meshopt_compression":{{"fallback":true}}}}}}{}"#,
            &json[..end],
            &json[end..]
        )
    };
    let load =
        |text: String| scenes::load_gltf_bytes("packed.gltf", text.as_bytes()).map_err(|e| e.to_string());
    assert_bounds(&load(file(4, 12, "ATTRIBUTES", "")).unwrap(), [0.0; 3], [1.0, 1.0, 0.0]);
    for (count, stride, mode, extra, expected) in [
        (4, 13, "ATTRIBUTES", "", "4 elements of 13 bytes do not fit it"),
        (4, 12, "SHRUNK", "", "mode \"SHRUNK\": is not known"),
        (5, 12, "ATTRIBUTES", "", "do not hold 5 elements"),
        (4, 12, "ATTRIBUTES", r#","filter":"QUATERNION""#, "filter \"QUATERNION\" does not fit"),
        (1 << 40, 256, "ATTRIBUTES", "", "decoded bytes exceed the limit"),
        (u64::MAX >> 11, 256, "ATTRIBUTES", "", "decoded bytes exceed the limit"),
    ] {
        let message = load(file(count, stride, mode, extra)).unwrap_err();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }
}

#[test]
fn broken_draco_data_is_one_line() {
    let mut parts = square();
    let data = parts.view(b"DRACO\x02\x02\x01\x01\x00\x00\x00 not a mesh at all");
    let draco = format!(
        r#","extensions":{{"KHR_draco_mesh_compression":{{"bufferView":{data},"attributes":{{"POSITION":0}}}}}}"#
    );
    let mesh = mesh("").replace(r#""indices":1"#, &format!(r#""indices":1{draco}"#));
    let message = parts.refused(&format!("{ONE_NODE},{mesh}"));
    assert!(message.contains("meshes[0].primitives[0]: Draco compression: "), "{message}");
}

/// A 4 x 1 image: alpha 255, 255, 0, 0.
fn half_clear() -> Vec<u8> {
    let image =
        image::RgbaImage::from_fn(4, 1, |x, _| image::Rgba([200, 100, 50, if x < 2 { 255 } else { 0 }]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Share of the square's area where its material has a surface, by points of a grid on the triangles.
fn covered(scene: &Scene) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for (t, &material) in scene.triangles.iter().zip(&scene.triangle_material) {
        let material = &scene.materials[material as usize];
        if material.name == "ground_added" {
            continue;
        }
        let corners = t.map(|i| &scene.vertices[i as usize]);
        let [a, b, c] = corners.map(|v| v.position.map(f64::from));
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        const N: usize = 60;
        let mut inside = 0;
        for i in 0..N * N {
            // Halves of the unit square folded onto one triangle.
            let (u, v) = ((i % N) as f64 + 0.5, (i / N) as f64 + 0.5);
            let (u, v) = (u / N as f64, v / N as f64);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let w = [1.0 - u - v, u, v];
            let uv = [0, 1].map(|k| (0..3).map(|c| w[c] * f64::from(corners[c].uv[k])).sum::<f64>());
            inside += usize::from(material.mask.as_ref().is_none_or(|mask| mask.passes(uv)));
        }
        sum += doubled * inside as f64 / (N * N) as f64;
        all += doubled;
    }
    assert!((all - 2.0).abs() < 1e-5, "the square was cut but is whole: {all}");
    sum / all
}

/// The square with a material, texture coordinates and, where given, vertices' alpha.
fn leaf(material: &str, sampler: &str, uvs: [f32; 8], alphas: Option<[f32; 4]>) -> Scene {
    let mut parts = square();
    let uvs = parts.floats("VEC2", &uvs);
    let mut attributes = format!(r#","TEXCOORD_0":{uvs}"#);
    if let Some(alphas) = alphas {
        let colors: Vec<f32> = alphas.iter().flat_map(|&alpha| [1.0, 1.0, 1.0, alpha]).collect();
        attributes += &format!(r#","COLOR_0":{}"#, parts.floats("VEC4", &colors));
    }
    let image = parts.view(&half_clear());
    let mesh = mesh(&attributes).replace(r#""indices":1"#, r#""indices":1,"material":0"#);
    parts.load(&format!(
        r#"{ONE_NODE},{mesh},"materials":[{{{material}}}],"images":[{{"bufferView":{image},"mimeType":"image/png"}}],
        "textures":[{{"source":0,"sampler":0}}],"samplers":[{{{sampler}}}]"#
    ))
}

const UNIT: [f32; 8] = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
/// From -1 to 2.
const WIDE: [f32; 8] = [-1.0, 0.0, 2.0, 0.0, 2.0, 1.0, -1.0, 1.0];
const TEXTURED: &str = r#""pbrMetallicRoughness":{"baseColorTexture":{"index":0}}"#;

fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 0.02, "{value}, expected {expected}");
}

#[test]
fn blended_surfaces_are_tested_at_one_half_and_keep_their_opacity() {
    let of = |mode: &str, factor: f64| {
        let pbr = format!(
            r#""alphaMode":"{mode}","pbrMetallicRoughness":{{"baseColorFactor":[1,1,1,{factor}],"baseColorTexture":{{"index":0}}}}"#
        );
        leaf(&pbr, "", UNIT, None)
    };
    near(covered(&of("OPAQUE", 1.0)), 1.0);
    near(covered(&of("MASK", 1.0)), 0.5);
    near(covered(&of("BLEND", 1.0)), 0.5);
    near(covered(&of("BLEND", 0.6)), 0.5);
    near(covered(&of("BLEND", 0.4)), 0.0);
    near(covered(&of("BLEND", 0.0)), 0.0);
    let opacity = of("BLEND", 0.4).materials[0].opacity.clone().unwrap();
    assert_eq!((opacity.factor, opacity.texture.unwrap().alpha.as_slice()), (0.4, &[255, 255, 0, 0][..]));
    assert!(of("MASK", 1.0).materials[0].opacity.is_none());
}

#[test]
fn wrapping_decides_what_lies_beside_a_mask() {
    let mask = format!(r#""alphaMode":"MASK",{TEXTURED}"#);
    // Of three repetitions each is half clear.
    near(covered(&leaf(&mask, "", WIDE, None)), 0.5);
    // To the left the opaque texels go on, to the right the clear ones.
    near(covered(&leaf(&mask, r#""wrapS":33071"#, WIDE, None)), 0.5);
    let left = [-2.0, 0.0, 1.0, 0.0, 1.0, 1.0, -2.0, 1.0];
    near(covered(&leaf(&mask, r#""wrapS":33071"#, left, None)), 5.0 / 6.0);
    near(covered(&leaf(&mask, "", left, None)), 0.5);
    // Mirrored: clear, opaque | opaque, clear | clear, opaque.
    let shifted = [-0.5, 0.0, 0.5, 0.0, 0.5, 1.0, -0.5, 1.0];
    near(covered(&leaf(&mask, r#""wrapS":33648"#, shifted, None)), 1.0);
    near(covered(&leaf(&mask, "", shifted, None)), 0.5);
    // A transform moves the coordinates before they are wrapped.
    let moved = r#""alphaMode":"MASK","pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"offset":[-2,0],"scale":[3,1]}}}}"#;
    near(covered(&leaf(moved, r#""wrapS":33071"#, UNIT, None)), 5.0 / 6.0);
}

#[test]
fn alpha_of_vertices_counts() {
    let mask = format!(r#""alphaMode":"MASK",{TEXTURED}"#);
    near(covered(&leaf(&mask, "", UNIT, Some([1.0; 4]))), 0.5);
    near(covered(&leaf(&mask, "", UNIT, Some([0.4; 4]))), 0.0);
    // Falls from 1 at the bottom to 0 at the top: the lower half of the left half.
    near(covered(&leaf(&mask, "", UNIT, Some([1.0, 1.0, 0.0, 0.0]))), 0.25);
    let plain = r#""alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.8]}"#;
    // 0.8 a >= 0.5.
    near(covered(&leaf(plain, "", UNIT, Some([1.0, 1.0, 0.0, 0.0]))), 0.375);
    let opaque = leaf("", "", UNIT, Some([0.0; 4]));
    near(covered(&opaque), 1.0);
    assert_eq!(opaque.triangles.len(), 4);
}

#[test]
fn a_texture_of_colour_may_be_missing_and_one_of_alpha_not() {
    let mut parts = square();
    let uvs = parts.floats("VEC2", &UNIT);
    let mesh =
        mesh(&format!(r#","TEXCOORD_0":{uvs}"#)).replace(r#""indices":1"#, r#""indices":1,"material":0"#);
    let rest = |mode: &str| {
        format!(
            r#"{ONE_NODE},{mesh},"materials":[{{"alphaMode":"{mode}",{TEXTURED}}}],"images":[{{"uri":"gone.png"}}],"textures":[{{"source":0}}]"#
        )
    };
    let scene = parts.load(&rest("OPAQUE"));
    assert_eq!(kinds(&scene), [WarningKind::MissingTexture]);
    for mode in ["MASK", "BLEND"] {
        assert!(parts.refused(&rest(mode)).contains("images[0]: file \"gone.png\" cannot be read"));
    }
    let sourceless = rest("OPAQUE").replace(r#""textures":[{"source":0}]"#, r#""textures":[{}]"#);
    assert_eq!(kinds(&parts.load(&sourceless)), [WarningKind::MissingTexture]);
    let bare = rest("OPAQUE").replace(&format!(r#","TEXCOORD_0":{uvs}"#), "");
    assert!(parts.load(&bare).warnings.iter().any(|w| w.kind == WarningKind::MissingTexture));
}

fn obj(text: &str) -> Scene {
    load_obj_bytes("test.obj", text.as_bytes()).unwrap()
}

#[test]
fn polygons_keep_their_holes() {
    let ring = "v 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nv 1 0 -1\nv 1 0 -3\nv 3 0 -3\nv 3 0 -1\n";
    let scene = obj(&format!("{ring}f 1 2 3 4 1 5 6 7 8 5\n"));
    assert!((area(&scene) - 12.0).abs() < 1e-6 && scene.warnings.is_empty(), "{}", area(&scene));
    // An arrowhead, from every corner on.
    for start in 0..4 {
        let mut order = [1, 2, 3, 4];
        order.rotate_left(start);
        let [a, b, c, d] = order;
        let scene = obj(&format!("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf {a} {b} {c} {d}\n"));
        assert!((area(&scene) - 4.0).abs() < 1e-6, "{start}: {}", area(&scene));
    }
    let crossing = obj("v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 3 0\nf 1 2 3 4\n");
    assert_eq!(kinds(&crossing), [WarningKind::CrossingPolygon]);
}

#[test]
fn objs_are_read_as_programs_write_them() {
    let cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let marked = format!("\u{feff}{cube}f 1 2 3\n");
    assert_eq!(kinds(&obj(&marked)), [WarningKind::ByteOrderMark]);
    let scene = obj(&format!(
        "mtllib none.mtl\nmtllib c:\\textures\\b.mtl\n{cube}usemtl x\nf 1/7/9 2/7/9 3/7/9\nf 1 2\nf\n"
    ));
    let found = kinds(&scene);
    assert_eq!(
        found,
        [
            WarningKind::MissingLibrary,
            WarningKind::MissingLibrary,
            WarningKind::TextureCoordinates,
            WarningKind::Normals,
            WarningKind::ShortFace
        ]
    );
    assert_eq!([scene.warnings[2].count, scene.warnings[4].count], [3, 2]);
    assert_eq!(scene.vertices[0].normal, [0.0, 0.0, 1.0]);
    let coloured = obj("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
    assert_eq!(coloured.colors[..3], [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]);
    assert_eq!(coloured.colors.len(), coloured.vertices.len());
}

#[test]
fn a_background_is_no_ground_and_groundwork_is() {
    let wall = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let added = |material: &str| {
        let scene = obj(&format!("{wall}usemtl {material}\nf 1 2 3 4\n"));
        scene.materials.iter().any(|m| m.name == "ground_added")
    };
    for name in ["Background", "underground", "playground", "backFloorless", "stone"] {
        assert_eq!(added(name), name != "backFloorless", "{name}");
    }
    for name in ["Ground", "theGround", "FLOOR_tiles", "floor01", "ground_plane"] {
        assert!(!added(name), "{name}");
    }
}
