//! Mistakes in the files of applications are refused by one line that names line, key and value.

use super::mistakes::refused;
use super::{directory, msm};
use std::path::Path;

/// What shows only when scenes are read: a line of the file is named all the same.
fn refused_late(folder: &Path, text: &str, cases: &[(&str, &str, &str)]) {
    for (i, (old, new, needle)) in cases.iter().enumerate() {
        assert!(text.contains(old), "{old}");
        let path = folder.join(format!("late-{i}.toml"));
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let results = folder.join("late");
        let output =
            msm(&["run", path.to_str().unwrap(), "--scale", "smoke", "--out", results.to_str().unwrap()]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{new}: {message}");
        assert!(message.contains(needle) && message.contains(&format!("late-{i}.toml: line ")), "{message}");
    }
}

#[test]
fn mistakes_about_soft_shadows_name_key_and_value() {
    let folder = directory("soft");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/soft-shadows.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let cases = [
        ("shape = \"sun:4x4\"", "shape = \"sun:infx4\"", "`inf` is no finite number"),
        ("shape = \"sun:4x4\"", "shape = \"moon:4\"", "moon:4"),
        ("shape = \"sun:4x4\"", "shape = \"rect:0,9,0;1,0,0;0,0,1\"", "is a place in one scene"),
        ("standard_error = 0.005", "standard_error = 0.0", "standard_error = 0"),
        ("most_rays = 16384", "most_rays = 8", "most_rays = 8"),
        ("camera = [320, 240]", "camera = [0, 240]", "camera = 0x240"),
        ("method = { most_width = 9.0 }", "method = { storage = \"signed\" }", "storage needs moments"),
        ("bound = \"hausdorff4\"", "bound = \"trigonometric4\"", "Trigonometric 4 gives no distribution"),
        ("bound = \"hamburger6\"", "bound = \"hamburger6\", storage = \"sparse\"", "storage = Sparse"),
        ("centre = [0.0, 0.63, 0.0, 0.63]", "centre = [0.0, 0.63]", "centre has 2 numbers"),
        ("epsilon = 1e-3 }", "epsilon = 2.0 }", "epsilon = 2 "),
        ("width = 5.0", "width = -5.0", "width = -5 "),
        ("light = \"wide\"", "light = \"moon\"", "light `moon`"),
        ("values = { umbra = [0.9,", "values = { umbra = [1.5,", "umbra = 1.5 "),
        ("values = { degrees = [0.0,", "values = { degrees = [200.0,", "200 degrees"),
        ("values = { region = [0.5,", "values = { region = [0.0,", "region = 0 "),
        ("techniques = [\"single precision\"]", "techniques = []", "techniques is empty"),
        ("insets = [[", "insets = [[400, 0, 64], [", "inset [400, 0, 64]"),
        ("id = \"receiver-stairs\"", "id = \"receiver-stairs\"\noutput = [9, 9]", "is drawn as a chart"),
        ("region = 27.0", "region = 2700.0", "2700 texels does not fit a map of"),
        ("map_size = 2048", "map_size = 0", "map size 0"),
        ("    \"PCSS\", \"PCSS, 9x9\"", "    \"moon\", \"PCSS, 9x9\"", "technique `moon`"),
        ("method = {}", "method = { bound = \"hamburger4\" }", "no percentage-closer method"),
    ];
    refused(&folder, &text, &cases);
    // What shows only when scenes are read: triangles for rays, receivers, views of pictures.
    let stack = folder.join("stack");
    let out = stack.to_str().unwrap();
    assert!(msm(&["render", "stairs", "--size", "96", "--backend", "cpu", "--out", out]).status.success());
    let stack = stack.join("stairs-high.stack.npz").display().to_string();
    let smoke_scene = format!("scenes = {:?}", [stack]);
    let late = [
        ("scenes = [\"stairs\"]", smoke_scene.as_str(), "shadow rays need triangles"),
        ("size = 96", "size = 9", "kernel.size"),
        ("shape = \"sun:4x4\"", "shape = \"sun:150x4\"", "texels, the map has 96"),
        ("bound = \"hamburger2\" }", "bound = \"hamburger2\", region = 0.25 }", "the largest region has"),
        ("width = 5.0", "width = 97.0", "a filter of 97 texels exceeds the map of 96"),
    ];
    refused_late(&folder, &text.replacen("views = [\"high\", \"lamp\"]", "views = []", 1), &late);
}

#[test]
fn mistakes_about_single_scattering_name_key_and_value() {
    let folder = directory("scattering");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/single-scattering.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let cases = [
        ("extinction = 1.0", "extinction = -1.0", "extinction = -1"),
        ("extinction = 1.0", "extinction = nan", "extinction = NaN"),
        ("albedo = 0.9", "albedo = 1.5", "albedo = 1.5"),
        ("anisotropy = 0.3", "anisotropy = 1.0", "anisotropy = 1: must lie in (-1, 1)"),
        ("rectified = [512, 512]", "rectified = [1, 512]", "rectified = 1x512: a map needs 2"),
        ("guard_band = 0.05", "guard_band = -0.1", "guard_band = -0.1"),
        ("target = [-1.0, 3.2, 0.0]", "target = [3.0, 3.0, 19.0]", "its frustum has no depth"),
        ("place = \"away\"", "place = \"away\"\nvertical_fov = 4.0", "vertical_fov = 4"),
        ("place = \"away\"", "", "neither place nor eye"),
        ("camera = [320, 180]", "camera = [320, 0]", "camera = 320x0"),
        ("most_rays = 8192", "most_rays = 8", "most_rays = 8"),
        ("method = { steps = 16 }", "method = { steps = 0 }", "0 steps"),
        (
            "method = { steps = 16 }",
            "method = { steps = 16, filtered = true }",
            "filtered is for prefix sums",
        ),
        (
            "{ spacing = \"two\" }",
            "{ spacing = \"two\", adaptive = true }",
            "adaptive needs something that is stored",
        ),
        ("bound = \"csm\", coefficients = 16", "bound = \"csm\", coefficients = 65", "coefficients = 65"),
        ("alpha = 4e-3 }, adaptive", "alpha = 4e-3, beta = 0.5 }, adaptive", "adaptive"),
        ("shifts = [0.25, 0.5]", "shifts = [1.5]", "shift 1.5"),
        ("formats = [\"unorm10\", \"unorm16\"", "formats = [\"unorm9\", \"unorm16\"", "unorm9"),
        ("tolerances = [0.1,", "tolerances = [1.0,", "tolerance 1 "),
        ("insets = [[180, 90, 70]", "insets = [[300, 90, 70]", "inset [300, 90, 70]"),
        ("stretch = 4.0", "stretch = 0.5", "stretch = 0.5"),
    ];
    refused(&folder, &text, &cases);
    // What shows only when scenes are read.
    let late = [
        (
            "views = [\"long\"]",
            "views = [\"lamp\"]",
            "rectified maps need a camera outside of the light's plane",
        ),
        ("scenes = [\"hall\"]", "scenes = [\"dungeon\"]", "dungeon"),
    ];
    refused_late(&folder, &text, &late);
}
