//! Scenes as files: what a specification may be, files beside the scene, OBJ, and links that lead away.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests fail by panicking and may report")]

use std::fs;
use std::path::{Path, PathBuf};

use scenes::{Scene, load_obj_bytes, load_scene};

/// An empty folder of this test's own, below the build's temporary folder.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn load(path: &Path) -> Result<Scene, String> {
    load_scene(path.to_str().unwrap()).map_err(|error| error.to_string())
}

const GLTF: &str = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"URI"}]}"#;

fn triangle_bytes() -> Vec<u8> {
    [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|c| c.to_le_bytes()).collect()
}

#[test]
fn specifications_are_names_or_paths() {
    assert_eq!(load_scene("stairs").unwrap().name, "stairs");
    for bad in ["castle", "", "scene.fbx", "Stairs"] {
        let message = load_scene(bad).unwrap_err().to_string();
        assert!(
            message.starts_with(&format!(
                "unknown scene {bad:?}: expected stairs, village, grove, hall, smoke, glasshouse or grids, "
            )),
            "{message}"
        );
    }
    let message = load_scene("no/such.glb").unwrap_err().to_string();
    assert!(message.starts_with("no/such.glb: cannot read: "), "{message}");
    let directory = folder("directory").join("a.glb");
    fs::create_dir_all(&directory).unwrap();
    assert!(load(&directory).unwrap_err().ends_with("a.glb: cannot read: not a regular file"));
}

#[test]
fn buffers_beside_the_scene_are_read_and_elsewhere_refused() {
    let folder = folder("buffers");
    let inner = folder.join("scene");
    fs::create_dir_all(inner.join("parts")).unwrap();
    fs::write(inner.join("parts/my triangle.bin"), triangle_bytes()).unwrap();
    fs::write(folder.join("outside.bin"), triangle_bytes()).unwrap();
    let try_uri = |uri: &str| {
        let path = inner.join("a.GLTF");
        fs::write(&path, GLTF.replace("URI", uri)).unwrap();
        load(&path)
    };
    assert_eq!(try_uri("parts/my%20triangle.bin").unwrap().name, "a");
    let outside = folder.join("outside.bin");
    for uri in ["../outside.bin", "%2e%2e/outside.bin", outside.to_str().unwrap(), "parts/../../outside.bin"]
    {
        let message = try_uri(uri).unwrap_err();
        assert!(message.contains("buffers[0]: file ") && message.contains("does not lie in"), "{message}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, inner.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(&folder, inner.join("up")).unwrap();
        for uri in ["link.bin", "up/outside.bin"] {
            let message = try_uri(uri).unwrap_err();
            assert!(message.contains("is a link out of the scene's folder"), "{message}");
        }
        // A link within the folder is fine.
        std::os::unix::fs::symlink(inner.join("parts/my triangle.bin"), inner.join("here.bin")).unwrap();
        assert!(try_uri("here.bin").is_ok());
    }
    assert!(try_uri("parts").unwrap_err().contains("not a regular file"));
    assert!(try_uri("gone.bin").unwrap_err().contains("buffers[0]: file \"gone.bin\" cannot be read"));
}

#[test]
fn an_obj_with_polygons_materials_and_relative_indices_is_read() {
    let folder = folder("obj");
    let mut mask = image::GrayImage::new(2, 1);
    mask.put_pixel(1, 0, image::Luma([255]));
    mask.save(folder.join("mask.png")).unwrap();
    fs::write(
        folder.join("m.mtl"),
        "newmtl leaf\nKd 0.1 0.2 0.3\nmap_d -s 1 1 1 mask.png\nnewmtl odd\nKd 1\n",
    )
    .unwrap();
    let text = "# comment\nmtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0 # corner\nv 0 1 0\nv -0.5 0.5 0\n\
        vt 0 0\nvt 0.25 1\nvn 0 0 2\nusemtl leaf\nf 1/1/1 2/2/1 \\\n 3/2 4//1 -1\nusemtl odd\nf -5 -4 -3\nl 1 2\n";
    fs::write(folder.join("a.obj"), text).unwrap();
    let scene = load(&folder.join("a.obj")).unwrap();
    let names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["leaf", "odd", "ground_added"]);
    assert_eq!(scene.triangle_material, [0, 0, 0, 1, 2, 2]);
    assert_eq!(scene.materials[0].albedo, [0.1, 0.2, 0.3]);
    assert_eq!(scene.materials[1].albedo, [0.8; 3], "a broken Kd keeps the default");
    let mask = scene.materials[0].mask.as_ref().unwrap();
    assert_eq!((mask.alpha.as_slice(), mask.cutoff), (&[0, 255][..], 128));
    // OBJ counts v from below; corners without vt or vn get zero and a computed normal.
    assert_eq!(scene.vertices[0].uv, [0.0, 1.0]);
    assert_eq!(scene.vertices[1].uv, [0.25, 0.0]);
    assert!(scene.vertices.iter().take(5).all(|v| v.normal == [0.0, 0.0, 1.0]));
}

#[test]
fn bad_obj_lines_are_named() {
    let v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (line, expected) in [
        ("f 1 2 4", "bad.obj: line 4: position of \"4\": index 4 is out of range, there are 3"),
        ("f 1 2 -4", "line 4: position of \"-4\": index -4 is out of range, there are 3"),
        ("f 1 2 0", "index 0 is out of range"),
        ("f 1 2 99999999999999999999", "which is no index"),
        ("f 1 2 //", "names no position"),
        ("f 1///4 2 3", "which has more than three parts"),
        ("f 1 2", "no triangles: the file holds only vertices without faces"),
        ("f 1 2 x", "line 4: f with \"x\", which is no index"),
        ("v nan 0 0", "line 4: v: value [NaN, 0.0, 0.0] is not finite"),
        ("v 0 1e999 0", "line 4: v: value [0.0, inf, 0.0]"),
        ("v 0 1e20 0", "exceeds 1e15"),
        ("v 0 0", "line 4: v with 2 of 3 numbers"),
        ("v 0 zero 0", "line 4: v with \"zero\", which is no number"),
        ("vt nan", "line 4: vt [NaN, 0.0] is not finite"),
        ("f 1 1 2", "no triangles: the file holds 1 degenerate triangles"),
        ("", "no triangles: the file holds only vertices without faces"),
        ("l 1 2", "no triangles: the file holds only lines"),
        ("p 1\ncurv 0 1 1 2", "no triangles: the file holds only points, curves and curved surfaces"),
    ] {
        let message = load_obj_bytes("bad.obj", format!("{v}{line}").as_bytes()).unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{line}: {message}");
        println!("{message}");
    }
    assert!(load_obj_bytes("bin.obj", &[0xff, 0xfe, 0, 1, b'\n', 0xc3]).is_err());
    assert!(load_obj_bytes("long.obj", "\\\n".repeat(200_000).as_bytes()).is_err());
}

#[test]
fn what_a_material_library_lacks_is_a_warning() {
    let folder = folder("mtl");
    let try_library = |text: &str| {
        fs::write(folder.join("m.mtl"), text).unwrap();
        fs::write(folder.join("a.obj"), "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
            .unwrap();
        load(&folder.join("a.obj")).unwrap()
    };
    assert!(try_library("newmtl a\nKd nan 2 -1\n").materials[0].albedo == [0.8, 1.0, 0.0]);
    let said = |text: &str, expected: &str| {
        let scene = try_library(text);
        let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
        assert!(warnings.len() == 1 && warnings[0].contains(expected), "{text}: {warnings:?}");
        assert!(scene.materials[0].mask.is_none());
    };
    let gone = "line 1: line 2 of \"m.mtl\": file \"gone.png\" cannot be read";
    said("newmtl a\nmap_d gone.png\n", gone);
    said("newmtl a\nmap_Kd gone.png\n", gone);
    said("newmtl a\nmap_d m.mtl\n", "its format is not known");
    said("newmtl a\nmap_d ../x.png\n", "does not lie in the scene's folder");
    said("newmtl b\n", "usemtl \"a\" is in no mtllib");
    fs::remove_file(folder.join("m.mtl")).unwrap();
    let scene = load(&folder.join("a.obj")).unwrap();
    assert_eq!(scene.warnings.len(), 1);
    assert!(scene.warnings[0].message.contains("line 1: file \"m.mtl\" cannot be read"));
}
