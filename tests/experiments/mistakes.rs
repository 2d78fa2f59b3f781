//! Mistakes in files are refused by one line that names line, key and value.

use super::{directory, msm};
use std::path::Path;

#[test]
fn mistakes_in_the_file_are_errors_that_name_key_and_file() {
    let folder = directory("mistakes");
    let bounds = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/bounds.toml");
    let text = std::fs::read_to_string(bounds).unwrap();
    let cases = [
        ("seed = 1", "seed = 1\nsede = 2", "sede"),
        ("[scale.paper]\ndepths", "[scale.paper]\ndepth", "unknown field `depth`"),
        ("[scale.paper]", "[scale.huge]", ": unknown scale `huge`"),
        ("kind = \"bounds\"", "kind = \"bonds\"", "line 1: kind = \"bonds\""),
        ("kind = \"bounds\"", "", "kind"),
        (
            "[scale.paper]",
            "[[candidate]]\nname = \"VSM\"\n[scale.paper]",
            "[[candidate]] is spelled [[technique]] now",
        ),
        ("question =", "# question =", "line"),
        ("basis = \"z, z^2\"", "basis = \"sinh(z)\"", "sinh"),
        ("interval = \"real\"", "interval = \"unit\", solver = \"magic\"", "magic"),
        ("kernels = [\"two surfaces\"]", "kernels = [\"none\"]", "none"),
        ("seed = 1", "seed = ", "line"),
    ];
    refused(&folder, &text, &cases);
}

/// Old text, new text, word of the message.
type Mistake = (&'static str, &'static str, &'static str);

/// An unknown key, a value that makes no sense and one of another type, for every kind.
#[test]
fn mistakes_in_every_kind_name_line_key_and_value() {
    let cases: [(&str, [Mistake; 5]); 12] = [
        (
            "bounds",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("seed = 1", "seed = \"one\"", "seed"),
                ("depths = 41", "depths = 1", "depths = 1 "),
                ("kernels = [\"two surfaces\"]", "kernels = [\"none\"]", "kernel `none`"),
                ("basis = \"z, z^2\"", "basis = \"sinh(z)\"", "sinh"),
            ],
        ),
        (
            "filterable",
            [
                ("size = 512", "sise = 512", "unknown field `sise`"),
                ("plane_limit = 0.05", "plane_limit = true", "plane_limit"),
                ("size = 1024", "size = 0", "size = 0 "),
                ("surface_gap = 0.004", "surface_gap = -1.0", "surface_gap"),
                ("exponent = 80.0", "exponent = 120.0", "exponent = 120"),
            ],
        ),
        (
            "quantization",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("plane_limit = 0.05", "plane_limit = \"flat\"", "plane_limit"),
                ("hull_points = 201", "hull_points = true", "hull_points"),
                ("basis = \"power:3\"", "basis = \"power:0\"", "power:0"),
                ("alphas = {", "alphas = 3 # {", "alphas"),
            ],
        ),
        (
            "candidate-search",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("cells = 256", "cells = \"many\"", "cells"),
                ("cells = 256", "cells = 8", "cells = 8 "),
                ("plane_limit = 0.05", "plane_limit = []", "plane_limit"),
                ("tolerance = 1e-6", "tolerance = 1.0", "tolerance = 1 "),
            ],
        ),
        (
            "larger-bases",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("recorded = 5000", "recorded = 49", "recorded = 49 is not between 50 and"),
                ("recorded = 5000", "recorded = \"all\"", "recorded"),
                ("orders = [5]", "orders = [9]", "m = 9 is not between"),
                ("[scale.brief]", "[scale.short]", "unknown scale `short`"),
            ],
        ),
        (
            "stability",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("seed = 1", "seed = -1", "-1"),
                ("draws = 40", "draws = 4.5", "draws"),
                ("alpha = 1e-9", "alpha = \"little\"", "alpha"),
                ("plane_limit = 0.05", "plane_limits = 0.05", "plane_limits"),
            ],
        ),
        (
            "speed-accuracy",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("plane_limit = 0.05", "plane_limit = \"flat\"", "plane_limit"),
                ("divisors = [1, 2, 4]", "divisors = [3]", "divisors[0] = 3"),
                ("exponent = 11.0", "exponent = 12.0", "12"),
                ("rounds = 1", "rounds = 0", "in 0 rounds"),
            ],
        ),
        (
            "soft-shadows",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("plane_limit = 0.05", "plane_limit = \"flat\"", "plane_limit"),
                ("shape = \"sun:4x4\"", "shape = \"sun:-4x4\"", "size of -4 degrees"),
                ("exponent = 5.0", "exponent = 50.0", "exponent = 50"),
                ("most_width = 9.0", "most_width = 0.0", "most_width = 0 "),
            ],
        ),
        (
            "temporal-shadows",
            [
                ("frames = 256", "frames = 1", "frames = 1 is not between 2 and 65536"),
                (
                    "most_tests = 512.0",
                    "most_tests = 4096.0",
                    "most_tests = 4096 is more than the 2048 that f16 counts",
                ),
                ("overscan = 0.05", "overscan = -1.0", "overscan = -1 "),
                ("scale = 0.25", "scale = 0.0", "scale = 0 "),
                ("every = 2", "every = 0", "every = 0 does not leave 1 to 64 frames"),
            ],
        ),
        (
            "stochastic-shadows",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("planes = [0.2, 0.95]", "planes = [0.2, 1.95]", "1.95 lies outside of the depth range"),
                ("planes = [0.7]", "planes = []", "zero planes hold no shadow"),
                ("least_radius = 2.0", "least_radius = 9.0", "least_radius = 9 "),
                ("contact = 8.0", "contact = 0.0", "contact = 0 "),
            ],
        ),
        (
            "translucent-shadows",
            [
                ("seed = 1", "sede = 1", "unknown field `sede`"),
                ("opacities = [0.0, 0.02,", "opacities = [1.5, 0.02,", "1.5 lies outside of [0, 1]"),
                ("fourier = 16", "fourier = 2", "fourier = 2 is not between"),
                ("stochastic = 8", "stochastic = 0", "stochastic = 0 is not between"),
                ("sigma = 2.4", "sigma = -2.4", "sigma = -2.4"),
            ],
        ),
        (
            "ranking-map",
            [
                ("follow = 6", "folow = 6", "unknown field `folow`"),
                ("order = 4", "order = 9", "order: m = 9 is not between"),
                ("name = \"512 cells\"", "name = \"128 cells\"", "variation `128 cells` appears twice"),
                ("cells = 512", "cells = 5", "cells = 5 is not between"),
                ("scene = \"village\"", "scene = \"vilage\"", "scene `vilage` is none of `scenes`"),
            ],
        ),
    ];
    for (name, cases) in cases {
        let folder = directory(&format!("every-{name}"));
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("experiments/{name}.toml"));
        let text = std::fs::read_to_string(file).unwrap();
        refused(&folder, &text, &cases);
        for (i, (old, ..)) in cases.iter().enumerate() {
            let path = folder.join(format!("case-{i}.toml"));
            let message = String::from_utf8(msm(&["run", path.to_str().unwrap()]).stderr).unwrap();
            let line = text[..text.find(old).unwrap()].matches('\n').count() + 1;
            assert!(message.contains(&format!("case-{i}.toml: line {line}: ")), "{line}: {message}");
        }
    }
}

/// Runs an experiment with one mistake after the other, as (old text, new text, word of the message).
pub(super) fn refused(folder: &Path, text: &str, cases: &[(&str, &str, &str)]) {
    for (i, (old, new, needle)) in cases.iter().enumerate() {
        assert!(text.contains(old), "{old}");
        let path = folder.join(format!("case-{i}.toml"));
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let out = folder.join("results");
        let output =
            msm(&["run", path.to_str().unwrap(), "--scale", "smoke", "--out", out.to_str().unwrap()]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{new}: {message}");
        assert!(message.contains(needle) && message.contains(&format!("case-{i}.toml")), "{new}: {message}");
        assert!(!out.exists(), "{new}");
    }
}

#[test]
fn mistakes_in_ways_to_store_moments_name_line_and_value() {
    let folder = directory("stores");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/quantization.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let cases = [
        ("\"GDC16 four moments\"]", "\"theta_5\"]", "theta_5"),
        ("formats = [\"unorm16\", \"unorm10\", \"f16\"]", "formats = [\"unorm9\"]", "unorm9"),
        ("kernel = { shape = \"box\", size = 9 }", "", "shape box"),
        ("formats = [\"u32/256\"]", "formats = [\"u32/80\"]", "u32/80"),
        ("baseline = \"MSM15 theta_4\"", "baseline = \"optimal\"", "optimal"),
        ("alphas = { from = 1e-8", "alphas = { from = 0.0", "alphas"),
        ("basis = \"power:3\"", "basis = \"power:0\"", "power:0"),
        (
            "bound = \"trigonometric4\", transforms = [\"plain\", \"optimal\"]",
            "bound = \"trigonometric4\", range = \"signed\", transforms = [\"plain\"]",
            "depths from 0 to 1",
        ),
    ];
    refused(&folder, &text, &cases);
    // The mistake's line is told as well.
    let path = folder.join("case-0.toml");
    let message = String::from_utf8(msm(&["run", path.to_str().unwrap()]).stderr).unwrap();
    assert!(message.contains("line "), "{message}");
}

#[test]
fn mistakes_in_stability_methods_name_line_and_value() {
    let folder = directory("stability");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/stability.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let cases = [
        ("shape = \"pole\"", "shape = \"hole\"", "hole"),
        ("alpha = 1e-9", "alpha = 1.5", "technique[0].method: alpha = 1.5"),
        (
            "centre = [0.0, 0.5]",
            "centre = [0.0]",
            "technique[0].method: centre = [0.0]: are not the 2 numbers",
        ),
        ("name = \"two surfaces\"", "name = \"one surface\"", "family `one surface` appears twice"),
        ("format = \"unorm10\"", "format = \"unorm9\"", "unorm9"),
        ("\"MSM15 theta_4\"", "\"MSM15 theta_5\"", "MSM15 theta_5"),
        (
            "name = \"trigonometric 4, f64\"\n",
            "name = \"trigonometric 4, f64\"\nroute = \"textbook\"\n",
            "not published",
        ),
        ("cells = 12", "cells = 0", "cells = 0"),
        ("x = { from = 1e-8, to = 0.3 }", "x = { from = 0.5, to = 0.3 }", "from = 0.5, to = 0.3"),
    ];
    refused(&folder, &text, &cases);
    let message =
        String::from_utf8(msm(&["run", folder.join("case-1.toml").to_str().unwrap()]).stderr).unwrap();
    assert!(message.contains("line "), "{message}");
}

#[test]
fn mistakes_in_candidates_name_line_and_value() {
    let folder = directory("speed");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/speed-accuracy.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let cases = [
        ("format = \"f16\"", "format = \"unorm16\"", "cannot hold exponential warps"),
        ("exponent = 11.0", "exponent = 12.0", "12"),
        ("transform = \"GDC16 four moments\"", "transform = \"MSM15 theta_2\"", "order of the transform = 2"),
        ("alphas = [5e-7, 5e-6]", "alphas = [1.5]", "alpha = 1.5"),
        ("bound = \"vsm\"", "bound = \"vsm\", alphas = [1e-5]", "`vsm` has no alpha"),
        ("divisors = [1, 2, 4]", "divisors = [3]", "divisors[0] = 3"),
        ("{ leak_reduction = 0.3 }", "{ leak_reduction = 1.0 }", "leak_reduction = 1"),
        ("\"VSM, f32\"", "\"VSM, f64\"", "VSM, f64"),
        ("kernels = [3, 5, 17, 33, 65]", "kernels = [4]", "kernel size 4"),
        ("rounds = 1", "rounds = 0", "in 0 rounds"),
        ("output = [320, 180]", "output = [0, 180]", "every_view"),
        ("gap_tolerances = [0.1, 0.02, 0.004]", "gap_tolerances = [0.0]", "tolerance 0"),
        ("insets = [[112", "insets = [[470", "inset [470"),
    ];
    refused(&folder, &text, &cases);
    let message =
        String::from_utf8(msm(&["run", folder.join("case-1.toml").to_str().unwrap()]).stderr).unwrap();
    assert!(message.contains("line "), "{message}");
}

#[test]
fn mistakes_in_techniques_and_scenes_name_key_and_value() {
    let folder = directory("techniques");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/filterable.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let cases = [
        ("bound = \"vsm\"", "bound = \"vsmm\"", "vsmm"),
        ("bound = \"vsm\"", "kind = \"vsm\"", "bound"),
        ("\nsize = 96", "\nsize = 7", "kernel.size = 9 exceeds the map's size = 7"),
        ("shape = \"box\", size = 1 ", "shape = \"box\", size = 101 ", "comparison.size = 101 exceeds"),
        ("coefficients = 16", "coefficients = \"many\"", "many"),
        ("size = 9, sigma", "size = 8, sigma", "size = 8"),
        ("exponent = 80.0", "exponent = 120.0", "exponent = 120"),
        ("exponent = 42.0", "exponent = 50.0", "exponent = 50"),
        ("texels = 1.0, slopes = 2.0", "texels = -1.0, slopes = 2.0", "texels = -1"),
        ("plane_limit = 0.05", "plane_limit = 7.0", "plane_limit = 7"),
        ("scenes = [\"stairs\"]", "scenes = [\"castle\"]", "castle"),
        ("views = [\"oblique\"]", "views = [\"midnight\"]", "midnight"),
        ("beta = 0.5 }", "beta = 1.5 }", "beta = 1.5"),
        ("layers = 4", "layer = 4", "layer"),
        ("id = \"kernel\",", "id = \"kernel\", texel = [1, 2],", "texel = [1, 2]"),
        ("\nfragments = 400", "\nfragments = 3", "certified_fragments = 4"),
    ];
    for (i, (old, new, needle)) in cases.into_iter().enumerate() {
        assert!(text.contains(old), "{old}");
        let path = folder.join(format!("case-{i}.toml"));
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let out = folder.join("results");
        let command = ["run", path.to_str().unwrap(), "--scale", "smoke", "--out", out.to_str().unwrap()];
        let output = msm(&command);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{new}: {message}");
        assert!(message.contains(needle), "{new}: {message}");
        // Cases that begin with a newline contradict another key, and that one's line is named.
        let line = text[..text.find(old).unwrap()].matches('\n').count() + 1;
        let place = if old.starts_with('\n') { "line ".to_owned() } else { format!("line {line}: ") };
        assert!(message.contains(&format!("case-{i}.toml: {place}")), "{new}: {place}: {message}");
    }
}
