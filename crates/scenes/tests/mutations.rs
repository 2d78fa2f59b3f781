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
    let (mut loaded, rounds) = (0, 6000);
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

#[test]
fn mutated_objs_never_panic() {
    const OBJ: &str = "o thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\nusemtl a\ng x\n\
        f 1/1/1 2/2/1 3//1\nf -1 -2 -3 -4\ns off\nf 1 2 \\\n3\n";
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
    let (mut loaded, rounds) = (0, 6000);
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
