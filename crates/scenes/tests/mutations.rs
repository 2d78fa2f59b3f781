//! Seeded mutations of a small GLB and a small OBJ: the loaders answer every one with a scene or an error.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking and may report")]

mod glb;

use glb::{Glb, quad};
use random_stream::Random;
use scenes::{Scene, SceneError, load_gltf_bytes, load_obj_bytes};

fn pick<'a, T: ?Sized>(random: &mut Random, from: &[&'a T]) -> &'a T {
    from[random.below(from.len())]
}

/// What must hold for any input: an error of one line, or a scene whose parts fit together.
fn check(result: Result<Scene, SceneError>, input: &str) -> bool {
    match result {
        Err(error) => {
            let message = error.to_string();
            assert!(!message.contains('\n') && message.len() < 600, "{message}: {input}");
            false
        }
        Ok(scene) => {
            assert!(!scene.triangles.is_empty() && !scene.views.is_empty(), "{input}");
            assert_eq!(scene.triangles.len(), scene.triangle_material.len(), "{input}");
            assert!(
                scene.triangles.iter().flatten().all(|&i| (i as usize) < scene.vertices.len()),
                "{input}"
            );
            assert!(scene.triangle_material.iter().all(|&m| (m as usize) < scene.materials.len()), "{input}");
            let finite = |v: &[f32]| v.iter().all(|c| c.is_finite());
            assert!(scene.vertices.iter().all(|v| finite(&v.position) && finite(&v.normal) && finite(&v.uv)));
            assert!(finite(&scene.camera.eye) && finite(&scene.camera.target), "{input}");
            assert!(scene.camera.eye != scene.camera.target, "{input}");
            for mask in scene.materials.iter().filter_map(|m| m.mask.as_ref()) {
                assert_eq!(mask.alpha.len(), (mask.width * mask.height) as usize, "{input}");
            }
            true
        }
    }
}

const NUMBERS: [&str; 24] = [
    "0",
    "1",
    "2",
    "3",
    "4",
    "5",
    "7",
    "-1",
    "255",
    "256",
    "65535",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "1e999",
    "-1e38",
    "1e-45",
    "0.5",
    "null",
    "\"x\"",
    "[]",
    "{}",
    "5125",
];

const WORDS: [(&str, &str); 18] = [
    ("POSITION", "NORMAL"),
    ("NORMAL", "POSITION"),
    ("TEXCOORD_1", "TEXCOORD_0"),
    ("VEC3", "VEC2"),
    ("VEC2", "MAT4"),
    ("SCALAR", "VEC4"),
    ("MASK", "BLEND"),
    ("\"bufferView\"", "\"x\""),
    ("\"indices\"", "\"indexes\""),
    ("byteOffset", "byteStride"),
    ("byteLength", "byteOffset"),
    ("\"mesh\":0", "\"mesh\":1"),
    ("\"children\"", "\"camera\""),
    ("perspective", "orthographic"),
    ("image/png", "image/jpeg"),
    ("\"count\"", "\"normalized\""),
    ("scale", "rotation"),
    ("5123", "5126"),
];

/// Spans of the numbers in a JSON text.
fn numbers(json: &str) -> Vec<(usize, usize)> {
    let mut spans = Vec::new();
    let mut start = None;
    for (i, c) in json.char_indices() {
        let part = c.is_ascii_digit() || "-.".contains(c);
        match (part, start) {
            (true, None) => start = Some(i),
            (false, Some(from)) => {
                spans.push((from, i));
                start = None;
            }
            _ => {}
        }
    }
    spans
}

fn edit_json(glb: &mut Glb, random: &mut Random) {
    if random.below(3) == 0 {
        let (from, to) = WORDS[random.below(WORDS.len())];
        let found: Vec<_> = glb.json.match_indices(from).map(|(at, _)| at).collect();
        if !found.is_empty() {
            let at = found[random.below(found.len())];
            glb.json.replace_range(at..at + from.len(), to);
        }
    } else {
        let spans = numbers(&glb.json);
        let (from, to) = spans[random.below(spans.len())];
        glb.json.replace_range(from..to, pick(random, &NUMBERS));
    }
}

fn flip_bytes(bytes: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        bytes[at] = match random.below(4) {
            0 => 0,
            1 => 0xff,
            2 => bytes[at] ^ (1 << random.below(8)),
            _ => random.below(256) as u8,
        };
    }
}

#[test]
fn mutated_glbs_never_panic() {
    let mut random = Random::new(7);
    let (mut loaded, rounds) = (0, rounds(6000));
    for round in 0..rounds {
        let mut glb = quad();
        for _ in 0..=random.below(3) {
            match random.below(3) {
                0 => flip_bytes(&mut glb.bin, &mut random),
                _ => edit_json(&mut glb, &mut random),
            }
        }
        let mut bytes = glb.bytes();
        match random.below(8) {
            0 => flip_bytes(&mut bytes, &mut random),
            1 => bytes.truncate(random.below(bytes.len())),
            _ => {}
        }
        loaded += usize::from(check(load_gltf_bytes("m", &bytes), &format!("round {round}: {}", glb.json)));
    }
    // A loader that refuses everything would pass the loop above.
    assert!(loaded > rounds / 50 && loaded < rounds * 9 / 10, "{loaded} of {rounds} loaded");
}

/// How many inputs each test makes, in place of its usual number.
fn rounds(usual: usize) -> usize {
    std::env::var("MSM_ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(usual)
}

/// A small file with a skin, morph targets, an animation, instances, a sparse accessor, a compressed view, alpha of vertices,
/// a clamped texture, a light and a camera.
fn rich() -> Glb {
    let mut bin = Vec::new();
    let mut views = Vec::new();
    let mut view = |bytes: &[u8]| {
        bin.resize(bin.len().next_multiple_of(4), 0);
        views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, bin.len(), bytes.len()));
        bin.extend(bytes);
    };
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    view(&floats(corners.as_flattened()));
    view(&[0, 1, 2, 0, 2, 3]);
    view(&floats(&[-1.0, 0.0, 2.0, 0.0, 2.0, 1.0, -1.0, 1.0]));
    view(&[255, 255, 255, 255, 255, 0, 0, 200, 0, 255, 0, 100, 0, 0, 255, 0]);
    view(&[0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    view(&floats(&[0.5, 0.5, 0.0, 0.0].repeat(4)));
    view(&floats(&[0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0]));
    view(&floats(&[0.0, 1.0]));
    view(&[2]);
    view(&floats(&[5.0, 5.0, 5.0]));
    view(&glb::png());
    let packed = meshopt::encode_vertex_buffer(&corners).unwrap();
    view(&packed);
    let length = packed.len();
    let offset = bin.len() - length;
    views.push(format!(
        r#"{{"buffer":1,"byteLength":48,"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":{offset},"byteLength":{length},
        "byteStride":12,"count":4,"mode":"ATTRIBUTES"}}}}}}"#
    ));
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,3,4]}}],
"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"spot"}}]}}}},
"nodes":[{{"mesh":0,"skin":0,"weights":[0.5]}},{{"children":[2],"translation":[0,0,3]}},{{"rotation":[0,0,0.6,0.8]}},
{{"mesh":1,"translation":[9,0,0],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":6}}}},"KHR_node_visibility":{{"visible":true}}}}}},
{{"translation":[0,0,8],"camera":0,"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}],
"cameras":[{{"type":"perspective","perspective":{{"yfov":0.5,"znear":0.1}}}}],
"skins":[{{"joints":[1,2]}}],
"animations":[{{"channels":[{{"sampler":0,"target":{{"node":1,"path":"translation"}}}}],"samplers":[{{"input":7,"output":6}}]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":2,"COLOR_0":3,"JOINTS_0":4,"WEIGHTS_0":5}},"indices":1,"material":0,
"targets":[{{"POSITION":8}}]}}]}},{{"primitives":[{{"attributes":{{"POSITION":9}},"indices":1,"material":1}}]}}],
"materials":[{{"alphaMode":"BLEND","pbrMetallicRoughness":{{"baseColorFactor":[1,1,1,0.9],"baseColorTexture":{{"index":0}}}}}},
{{"alphaMode":"MASK","alphaCutoff":0.4}}],
"textures":[{{"source":0,"sampler":0}}],"images":[{{"bufferView":10}}],"samplers":[{{"wrapS":33071,"wrapT":33648}}],
"accessors":[
{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
{{"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"}},
{{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}},
{{"bufferView":3,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"}},
{{"bufferView":4,"componentType":5121,"count":4,"type":"VEC4"}},
{{"bufferView":5,"componentType":5126,"count":4,"type":"VEC4"}},
{{"bufferView":6,"componentType":5126,"count":3,"type":"VEC3"}},
{{"bufferView":7,"componentType":5126,"count":2,"type":"SCALAR"}},
{{"componentType":5126,"count":4,"type":"VEC3","sparse":{{"count":1,"indices":{{"bufferView":8,"componentType":5121}},"values":{{"bufferView":9}}}}}},
{{"bufferView":12,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
"bufferViews":[{}],
"buffers":[{{"byteLength":{}}},{{"byteLength":48,"extensions":{{"EXT_meshopt_compression":{{"fallback":true}}}}}}]}}"#,
        views.join(","),
        bin.len()
    );
    Glb { json, bin }
}

#[test]
fn mutated_poses_never_panic() {
    let whole = load_gltf_bytes("rich", &rich().bytes()).unwrap();
    assert!(whole.warnings.is_empty() && whole.animation.is_some(), "{:?}", whole.warnings);
    let mut random = Random::new(13);
    let rounds = rounds(6000);
    let mut loaded = 0;
    for round in 0..rounds {
        let mut glb = rich();
        for _ in 0..=random.below(3) {
            match random.below(3) {
                0 => flip_bytes(&mut glb.bin, &mut random),
                _ => edit_json(&mut glb, &mut random),
            }
        }
        loaded +=
            usize::from(check(load_gltf_bytes("m", &glb.bytes()), &format!("round {round}: {}", glb.json)));
    }
    assert!(loaded > rounds / 50 && loaded < rounds * 9 / 10, "{loaded} of {rounds} loaded");
}

#[test]
fn mutated_objs_never_panic() {
    const OBJ: &str = "o thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\nusemtl a\ng x\n\
        f 1/1/1 2/2/1 3//1\nf -1 -2 -3 -4\nmtllib a.mtl b.mtl\nf 1 2 4 3\ns off\nf 1 2 \\\n3\n";
    const TOKENS: [&str; 16] = [
        "f",
        "v",
        "vt",
        "vn",
        "0",
        "-1",
        "99999999999",
        "nan",
        "1e39",
        "/",
        "//",
        "\\",
        "#",
        "usemtl",
        "\n",
        "\u{e9}",
    ];
    let mut random = Random::new(11);
    let (mut loaded, rounds) = (0, rounds(6000));
    for round in 0..rounds {
        let mut bytes = OBJ.as_bytes().to_vec();
        for _ in 0..=random.below(3) {
            if random.below(3) == 0 {
                flip_bytes(&mut bytes, &mut random);
            } else {
                let (at, end) = (random.below(bytes.len()), random.below(3));
                let end = (at + end).min(bytes.len());
                bytes.splice(at..end, pick(&mut random, &TOKENS).bytes());
            }
        }
        loaded += usize::from(check(load_obj_bytes("m", &bytes), &format!("round {round}: {bytes:?}")));
    }
    assert!(loaded > rounds / 50 && loaded < rounds * 9 / 10, "{loaded} of {rounds} loaded");
}
