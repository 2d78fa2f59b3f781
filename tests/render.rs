//! `msm render`: files that load back, the contract of its JSON, and every way to ask for nonsense.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use scenes::{LightView, load_scene};
use serde_json::Value;
use shadow_renderer::{Backend, ShadowMapStack, render_stack, render_view};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("render").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Runs in `folder`, where `out` is the default target.
fn render(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_msm"))
        .arg("render")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = render(folder, &[arguments, &["--format", "json"]].concat());
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Refused: exit code, nothing on standard output, one line that contains `needle`, no new file or folder.
fn refused(folder: &Path, code: i32, arguments: &[&str], needle: &str) {
    let before = names(folder);
    let output = render(folder, &[arguments, &["--backend", "cpu"]].concat());
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    assert!(message.contains(needle), "{arguments:?}: {message}");
    assert_eq!(names(folder), before, "{arguments:?}");
}

/// A slanted triangle above a ground of two.
const OBJ: &str =
    "v -2 0 -2\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -1 1 -1\nv 0 1.5 1\nv 1 1 -1\nf 1 2 3\nf 1 3 4\nf 5 6 7\n";

#[test]
fn four_files_appear_and_hold_what_they_promise() {
    let folder = folder("files");
    let command = ["stairs", "--view", "long", "--size", "96x64", "--backend", "cpu"];
    let answer = json(&folder, &command);
    let expected =
        ["stairs-long-depth.png", "stairs-long-layers.png", "stairs-long-scene.png", "stairs-long.stack.npz"];
    assert_eq!(names(&folder), ["out"]);
    assert_eq!(names(&folder.join("out")), expected);
    let file = |key: &str| folder.join(answer["files"][key].as_str().unwrap());

    let loaded = ShadowMapStack::load(&file("stack")).unwrap();
    let scene = load_scene("stairs").unwrap();
    let long = scene.views.iter().find(|view| view.name == "long").unwrap();
    let (stack, _) = render_stack(&scene, long.direction, 96, 64, Backend::Cpu).unwrap();
    assert!(loaded == stack, "the file must hold the stack");

    let size = |key: &str| image::image_dimensions(file(key)).unwrap();
    assert_eq!((size("depth"), size("scene")), ((96, 64), (1280, 720)));
    // Map and legend, which needs 96 pixels in height.
    assert!(size("layers").0 > 96 && size("layers").1 == 96);
    let picture = image::open(file("scene")).unwrap().to_rgb8();
    let colors: std::collections::HashSet<[u8; 3]> = picture.pixels().map(|pixel| pixel.0).collect();
    assert!(colors.len() > 100, "only {} colours", colors.len());

    // Again, over the old files: the same bytes, and nothing else left.
    let bytes = std::fs::read(file("stack")).unwrap();
    json(&folder, &command);
    assert_eq!(names(&folder.join("out")), expected);
    assert_eq!(std::fs::read(file("stack")).unwrap(), bytes);
}

/// A lamp over the ground, by text, by file and as the scene's own.
#[test]
fn lights_have_a_place_and_a_size() {
    let folder = folder("lights");
    let lamp = "rect:0.5,4,0;0.5,0,0;0,0,0.25";
    std::fs::write(folder.join("a.obj"), OBJ).unwrap();
    let scene = load_scene(&folder.join("a.obj").to_string_lossy()).unwrap();
    let view = LightView::new("lamp", lamp.parse().unwrap(), [0.0; 3]);
    let (expected, _) = render_view(&scene, &view, 64, 48, Backend::Cpu).unwrap();
    std::fs::write(folder.join("v.toml"), format!("[[view]]\nname = 'mine'\nlight = '{lamp}'\n")).unwrap();
    for (arguments, name) in
        [(["--light", lamp], "a-rect_0.5_4_0_0.5_0_0_0_0_0.25"), (["--views", "v.toml"], "a-mine")]
    {
        let command =
            [&["a.obj", "--size", "64x48", "--backend", "cpu", "--out", "lit"], &arguments[..]].concat();
        let answer = json(&folder, &command);
        assert_eq!(answer["light"].as_str(), Some(lamp));
        assert_eq!(answer["light_frame"]["eye"], serde_json::json!([0.5, 4.0, 0.0]));
        assert_eq!(answer["direction"], serde_json::json!([0.0, -1.0, 0.0]));
        let stack = ShadowMapStack::load(&folder.join(format!("lit/{name}.stack.npz"))).unwrap();
        assert!(stack == expected, "{name}");
    }
    // A sun of some size travels along a view.
    let answer = json(&folder, &["a.obj", "--light", "sun:3x1", "--view", "0,-1,0.5", "--size", "32"]);
    assert_eq!(
        (answer["light"].as_str(), answer["view"].as_str()),
        (Some("sun:3x1"), Some("light 0,-1,0.5 sun:3x1"))
    );
    assert!(answer["light_frame"]["eye"].is_null());
    let answer = json(&folder, &["a.obj", "--view", "lamp", "--size", "32"]);
    assert!(answer["light"].as_str().unwrap().starts_with("rect:"));
}

#[test]
fn lights_that_make_no_sense_are_refused() {
    let folder = folder("bad-lights");
    std::fs::write(folder.join("a.obj"), OBJ).unwrap();
    for (light, needle) in [
        (
            "rect:0,1.2,0;1,0,0;0,0,1",
            "--light: light `rect:0,1.2,0;1,0,0;0,0,1` lies inside the scene: triangle 2",
        ),
        ("disc:0,9,0;0,0,1;1,0,0", "--light: light `disc:0,9,0;0,0,1;1,0,0` lies behind the scene"),
        ("disc:0,9,0;0,0,0;1,0,0", "--light <LIGHT>': half axis U = [0.0, 0.0, 0.0]"),
        (
            "rect:0,9,0;1,0,0;0,0,inf",
            "--light <LIGHT>': light `rect:0,9,0;1,0,0;0,0,inf`: `inf` is no finite number",
        ),
        ("rect:0,9,0;1,0,0;2,0,0", "are parallel"),
        ("sun:-1", "--light <LIGHT>': an angular size of -1 degrees"),
        ("lamp", "--light <LIGHT>': light `lamp`: expected sun:DEGREES"),
    ] {
        refused(&folder, 2, &["a.obj", "--light", light], needle);
    }
    refused(
        &folder,
        2,
        &["a.obj", "--light", "disc:0,9,0;1,0,0;0,0,1", "--view", "default"],
        "--view default: the light",
    );
    std::fs::write(folder.join("v.toml"), "[[view]]\nname = 'in'\nlight = 'rect:0,1.2,0;1,0,0;0,0,1'\n")
        .unwrap();
    refused(
        &folder,
        2,
        &["a.obj", "--views", "v.toml"],
        "view `in`: light `rect:0,1.2,0;1,0,0;0,0,1` lies inside",
    );
    std::fs::write(folder.join("v.toml"), "[[view]]\nname = 'in'\nlight = 'sun:200'\n").unwrap();
    refused(&folder, 2, &["a.obj", "--views", "v.toml"], "v.toml: line 3: an angular size of 200 degrees");
}

#[test]
fn the_contract_of_the_json_output() {
    let folder = folder("json");
    let answer = json(&folder, &["grove", "--size", "64", "--out", "a/b", "--backend", "cpu"]);
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{answer}"));
    assert_eq!((answer["scene"].as_str(), answer["view"].as_str()), (Some("grove"), Some("high")));
    assert_eq!((number(&answer["width"]), number(&answer["height"])), (64.0, 64.0));
    assert_eq!(answer["direction"].as_array().unwrap().len(), 3);
    assert_eq!(answer["backend"], "cpu");
    assert!(answer["adapter"].is_null() && answer["fallback"].is_null());
    for key in ["triangles", "degenerate_on_loading", "degenerate_on_map", "fragments", "covered_texels"] {
        assert!(answer[key].is_u64(), "{key}");
    }
    let layers = &answer["layers"];
    let mean = number(&answer["fragments"]) / number(&answer["covered_texels"]);
    assert!((number(&layers["mean"]) - mean).abs() < 1e-9);
    assert!(number(&layers["p95"]) <= number(&layers["max"]));
    let stages = ["load", "prepare", "device", "raster", "group", "sort", "assemble", "render"];
    for key in stages.iter().chain(&["pictures_and_files"]) {
        assert!(number(&answer["time_ms"][key]) >= 0.0, "{key}");
    }
    for key in ["right", "down", "forward"] {
        let axis = answer["light_frame"][key].as_array().unwrap();
        assert!((axis.iter().map(|c| number(c).powi(2)).sum::<f64>() - 1.0).abs() < 1e-12);
    }
    for key in ["stack", "depth", "layers", "scene"] {
        let path = answer["files"][key].as_str().unwrap();
        assert!(path.starts_with("a/b") && folder.join(path).is_file(), "{path}");
    }
    let text = String::from_utf8(render(&folder, &["grove", "--size", "64"]).stdout).unwrap();
    for word in ["triangles", "fragments", "layers", "backend", "render", "out/grove-high.stack.npz"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn backends_agree_and_say_who_ran() {
    let folder = folder("backends");
    let mut stacks = Vec::new();
    for backend in ["cpu", "gpu", "auto"] {
        let answer = json(&folder, &["stairs", "--size", "64", "--backend", backend]);
        match answer["backend"].as_str().unwrap() {
            "gpu" => assert!(answer["adapter"]["name"].is_string() && answer["fallback"].is_null()),
            _ => assert_eq!(answer["fallback"].is_string(), backend != "cpu", "{answer}"),
        }
        stacks.push(std::fs::read(folder.join(answer["files"]["stack"].as_str().unwrap())).unwrap());
    }
    assert!(stacks[0] == stacks[1] && stacks[0] == stacks[2]);
}

#[test]
fn views_by_name_by_direction_and_from_a_file() {
    let folder = folder("views");
    std::fs::write(folder.join("my scene.obj"), OBJ).unwrap();
    std::fs::write(folder.join("sun.toml"), "[[view]]\nname = 'a/../b'\ndirection = [0, -1, 0]\n").unwrap();
    let run = |arguments: &[&str]| {
        let answer =
            json(&folder, &[&["my scene.obj", "--size", "16", "--backend", "cpu"], arguments].concat());
        let direction: Vec<f64> =
            answer["direction"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
        let stack = answer["files"]["stack"].as_str().unwrap().to_owned();
        assert!(folder.join(&stack).is_file());
        (direction.iter().map(|c| (c * 1e3).round() / 1e3).collect::<Vec<_>>(), stack)
    };
    assert_eq!(run(&[]), (vec![0.8, -0.6, 0.35], "out/my_scene-default.stack.npz".into()));
    assert_eq!(run(&["--view", "default"]).0, [0.8, -0.6, 0.35]);
    assert_eq!(run(&["--view", "0.8,-0.6,0.35"]).1, "out/my_scene-light_0.8_-0.6_0.35.stack.npz");
    assert_eq!(run(&["--view=-1,-2,0"]).0, [-1.0, -2.0, 0.0]);
    assert_eq!(run(&["--view", "-1,-2,0"]).0, [-1.0, -2.0, 0.0]);
    assert_eq!(run(&["--views", "sun.toml"]), (vec![0.0, -1.0, 0.0], "out/my_scene-a_.._b.stack.npz".into()));
    assert_eq!(run(&["--views", "sun.toml", "--view", "a/../b"]).0, [0.0, -1.0, 0.0]);
    refused(&folder, 2, &["my scene.obj", "--views", "sun.toml", "--view", "default"], "a/../b");
}

#[test]
fn the_seed_changes_a_procedural_scene() {
    let folder = folder("seed");
    let stack = |seed: &[&str]| {
        let answer = json(&folder, &[&["grove", "--size", "64", "--backend", "cpu"], seed].concat());
        std::fs::read(folder.join(answer["files"]["stack"].as_str().unwrap())).unwrap()
    };
    let (usual, other) = (stack(&[]), stack(&["--seed", "1"]));
    assert!(usual != other && stack(&["--seed", "1"]) == other && stack(&["--seed", "2015"]) == usual);
    std::fs::write(folder.join("a.obj"), OBJ).unwrap();
    refused(&folder, 2, &["a.obj", "--seed", "1"], "--seed");
}

#[test]
fn bad_input_is_one_line_and_leaves_nothing() {
    let folder = folder("bad");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    write("a.obj", OBJ.as_bytes());
    write("empty.obj", b"v 0 0 0\n");
    write("degenerate.obj", b"v 0 0 0\nv 1 1 1\nf 1 1 2\n");
    write("nan.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write("short.glb", b"glTF\x02\0\0\0");
    // A header that claims 4 GiB, and a chunk of JSON that is none.
    write("long.glb", b"glTF\x02\0\0\0\xff\xff\xff\xff\xf0\xff\xff\xffJSON{");
    write("noise.gltf", &[0x93; 400]);
    write("bad.toml", b"[[view]]\nname = 'low'\ndirection = [0, 0, 0]\n");
    std::fs::create_dir(folder.join("folder.glb")).unwrap();
    let bad = |arguments: &[&str], needle: &str| refused(&folder, 2, arguments, needle);

    bad(&[], "SCENE");
    bad(&["castle"], "stairs, village, grove, hall, smoke, glasshouse or grids");
    bad(&["missing.glb"], "missing.glb");
    bad(&["bad.toml"], "unknown scene");
    for file in ["short.glb", "long.glb", "noise.gltf", "folder.glb", "nan.obj"] {
        bad(&[file], file);
    }
    for file in ["empty.obj", "degenerate.obj"] {
        bad(&[file], "no triangles");
    }
    bad(&["stairs", "--view", "noon"], "high, oblique, long, grazing");
    bad(&["a.obj", "--view", "noon"], "default");
    for view in ["0,0,0", "nan,0,1", "0,inf,0", "1e-60,0,0", "1e300,0,0", "1,2", "1,2,3,4", "1,,3", "", "-1"]
    {
        bad(&["a.obj", "--view", view], &format!("`{view}`"));
    }
    bad(&["a.obj", "--views", "bad.toml"], "view \"low\"");
    bad(&["a.obj", "--views", "missing.toml"], "missing.toml");
    for size in ["0", "64x0", "0x64", "big", "", "-1", "1e3", "8193", "64x64x64", "99999999999", "x", "1.5"] {
        bad(&["a.obj", "--size", size], "--size");
    }
    bad(&["a.obj", "--backend", "magic"], "magic");
    bad(&["a.obj", "--seed=-1"], "--seed");
    bad(&["a.obj", "--format", "xml"], "xml");
}

#[test]
fn a_folder_that_cannot_be_written_is_said_at_once() {
    let folder = folder("unwritable");
    std::fs::write(folder.join("a.obj"), OBJ).unwrap();
    let failed = |out: &str| refused(&folder, 1, &["a.obj", "--size", "16", "--out", out], out);
    // A file in the way, on the last step and on the first.
    failed("a.obj");
    failed("a.obj/below");
    // The name of a picture is taken by a folder: nothing else may appear.
    std::fs::create_dir_all(folder.join("taken/a-default-depth.png/inside")).unwrap();
    failed("taken");
    assert_eq!(names(&folder.join("taken")), ["a-default-depth.png"]);
    if cfg!(target_os = "linux") {
        // Not even root makes a folder there.
        failed("/proc/no/such");
    }
}

/// A stack that fits no memory: 8192^2 texels behind thousands of squares.
#[test]
fn a_stack_beyond_memory_is_refused_before_it_is_allocated() {
    let folder = folder("memory");
    let mut text = String::new();
    for layer in 0..3000 {
        let y = 0.001 * f64::from(layer);
        for (x, z) in [(0, 0), (0, 1), (1, 1), (1, 0)] {
            text += &format!("v {x} {y} {z}\n");
        }
        let first = 4 * layer + 1;
        text += &format!("f {first} {} {} {}\n", first + 1, first + 2, first + 3);
    }
    std::fs::write(folder.join("deep.obj"), text).unwrap();
    refused(
        &folder,
        2,
        &["deep.obj", "--size", "8192", "--view", "0,-1,0", "--out", "new/folder"],
        "use a smaller map",
    );
}
