//! `msm advise`: what it recommends holds on all fragments, and nothing cheaper does.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn msm(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_msm"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

/// The experiment on small maps and all fragments, with fewer candidates and variants.
fn candidates(directory: &Path, scene: &str) -> PathBuf {
    let text = std::fs::read_to_string(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/speed-accuracy.toml"),
    )
    .unwrap();
    let mut table: toml::Table = toml::from_str(&text).unwrap();
    table.remove("scale");
    for (key, value) in
        [("size", "size = 128"), ("fragments", "fragments = 0"), ("divisors", "divisors = [1, 2]")]
    {
        let line: toml::Table = toml::from_str(value).unwrap();
        table.insert(key.to_owned(), line[key].clone());
    }
    let more = format!(
        "scenes = [\"{scene}\"]\nblends = [{{}}, {{ leak_reduction = 0.1 }}]\ntiming = {{ repetitions = 1, fragments = 10 }}"
    );
    let more: toml::Table = toml::from_str(&more).unwrap();
    table.extend(more);
    let kept = |value: &toml::Value| {
        let name = value["name"].as_str().unwrap();
        !(name.starts_with("Trig") || name.starts_with("CSM") || name.starts_with("Hamburger 8"))
    };
    table["technique"].as_array_mut().unwrap().retain(kept);
    // Some of those that are timed are gone.
    table["frames"].as_table_mut().unwrap().remove("techniques");
    let path = directory.join("small.toml");
    std::fs::write(&path, table.to_string()).unwrap();
    path
}

/// Rows over all fragments, by column.
fn records(run: &Path) -> Vec<std::collections::HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(run.join("records.csv")).unwrap();
    let rows = reader.deserialize::<std::collections::HashMap<String, String>>().map(Result::unwrap);
    rows.filter(|row| row["scene"] == "all" && row["format"] != "depth").collect()
}

fn number(row: &std::collections::HashMap<String, String>, key: &str) -> f64 {
    row[key].parse().unwrap()
}

#[test]
fn a_recommendation_holds_on_all_fragments_and_nothing_cheaper_does() {
    for scene in ["stairs", "village", "grove"] {
        let directory = tempfile::tempdir().unwrap();
        let file = candidates(directory.path(), scene);
        let file = file.to_str().unwrap();
        let root = directory.path().to_str().unwrap();
        let run = msm(&["run", file, "--out", root, "--format", "json"]);
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let run: Value = serde_json::from_slice(&run.stdout).unwrap();
        let all = records(Path::new(run["directory"].as_str().unwrap()));
        let rows: Vec<_> = all.iter().filter(|row| row["format"] != "none").collect();
        let mut errors: Vec<f64> =
            rows.iter().filter(|row| row["best"] == "true").map(|row| number(row, "l1_error")).collect();
        errors.sort_by(f64::total_cmp);
        // Exactly what one candidate reaches, and halfway between two.
        let (few, many) = (errors.len() / 8, errors.len() / 2);
        for tolerance in [errors[few] + 1e-8, 0.5 * (errors[many] + errors[many + 1])] {
            let text = tolerance.to_string();
            let advice =
                msm(&["advise", scene, "--tolerance", &text, "--candidates", file, "--format", "json"]);
            assert!(advice.status.success(), "{scene}: {}", String::from_utf8_lossy(&advice.stderr));
            let advice: Value = serde_json::from_slice(&advice.stdout).unwrap();
            let chosen = &advice["recommendation"];
            let cost = chosen["cost"].as_f64().unwrap();
            let matches = |row: &&&std::collections::HashMap<String, String>| {
                let same = |key: &str| number(row, key) == chosen[key].as_f64().unwrap();
                let alpha = match chosen["alpha"].as_f64() {
                    Some(alpha) => row["alpha"].parse() == Ok(alpha),
                    None => row["alpha"].is_empty(),
                };
                row["technique"] == chosen["technique"].as_str().unwrap()
                    && row["format"] == chosen["format"].as_str().unwrap()
                    && alpha
                    && ["size", "bias_texels", "bias_slopes", "beta", "leak_reduction"].into_iter().all(same)
            };
            let row = rows.iter().find(matches).unwrap();
            let error = number(row, "l1_error");
            assert!(error <= tolerance, "{scene}: {chosen} errs by {error}");
            let (low, high) =
                (chosen["l1_error_low"].as_f64().unwrap(), chosen["l1_error_high"].as_f64().unwrap());
            assert!(low - 1e-6 <= error && error <= high + 1e-6, "{scene}: {error} not in {low} to {high}");
            let nothing = advice["nothing"]["l1_error"].as_f64().unwrap();
            let lit = all.iter().find(|row| row["format"] == "none").unwrap();
            assert!((number(lit, "l1_error") - nothing).abs() < 1e-6, "{scene}: {lit:?} {nothing}");
            assert!(error <= 0.5 * nothing, "{scene}: {chosen} is not clearly better than {nothing}");
            let cheaper = rows.iter().filter(|row| number(row, "cost") < cost - 1e-6);
            let refuted = cheaper.inspect(|row| {
                assert!(
                    number(row, "l1_error") > tolerance || number(row, "relative_error") > 0.5,
                    "{scene}, {tolerance}: {row:?} is cheaper than {chosen}"
                );
            });
            assert!(
                refuted.count() > 0,
                "{scene}: the cheapest candidate was recommended, which tests nothing"
            );
            let better = &advice["next_better"];
            assert!(better.is_null() || better["l1_error"].as_f64() < chosen["l1_error"].as_f64());
            let mut costlier = rows.iter().filter(|row| number(row, "cost") > cost + 1e-6);
            if costlier.any(|row| number(row, "l1_error") < error - 1e-6) {
                assert!(
                    !better.is_null(),
                    "{scene}, {tolerance}: a costlier candidate errs less than {chosen}"
                );
            }
        }
    }
}

/// A box of a metre on ground of so many metres along a side, or the ground alone.
fn box_on_ground(directory: &Path, side: f64, with_box: bool) -> String {
    let half = 0.5 * side;
    let mut text = String::from("usemtl ground\n");
    let mut rectangle = |[x0, x1]: [f64; 2], [z0, z1]: [f64; 2], is_up: bool| {
        text += &format!("v {x0} 0 {z0}\nv {x1} 0 {z0}\nv {x1} 0 {z1}\nv {x0} 0 {z1}\n");
        text += if is_up { "f -1 -2 -3 -4\n" } else { "f -4 -3 -2 -1\n" };
    };
    rectangle([-half, half], [-half, half], true);
    if with_box {
        for y in [0, 1] {
            text += &format!("v 0 {y} 0\nv 1 {y} 0\nv 1 {y} 1\nv 0 {y} 1\n");
        }
        text += "f 12 11 10 9\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n";
    } else {
        // It goes on, seen from below: next to nothing, F takes the cleared map for an occluder of the farthest corner.
        let far = side;
        for (x, z) in [([-far, far], [-far, -half]), ([-far, far], [half, far])] {
            rectangle(x, z, false);
        }
        for x in [[-far, -half], [half, far]] {
            rectangle(x, [-half, half], false);
        }
    }
    let path = directory.join(format!("ground-{side}-{with_box}.obj"));
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// The advice, what was said beside it, and the exit code.
fn asked(arguments: &[&str]) -> (Value, String, Option<i32>) {
    let output = msm(&[&["advise"], arguments, &["--format", "json"]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    let advice =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{arguments:?}: {message}"));
    (advice, message, output.status.code())
}

/// The experiment with variance shadow maps in single precision alone, under one bias: their error does not change with the
/// depth range, which grows with the ground.
fn variance_alone(directory: &Path) -> PathBuf {
    let text = std::fs::read_to_string(candidates(directory, "stairs")).unwrap();
    let mut table: toml::Table = toml::from_str(&text).unwrap();
    let more: toml::Table =
        toml::from_str("divisors = [1]\nblends = [{}]\nbiases = [{ texels = 1.0, slopes = 1.0 }]").unwrap();
    table.extend(more);
    // Pictures name techniques that are no longer there.
    for key in ["picture", "every_view", "frames"] {
        table.remove(key);
    }
    let is_kept = |value: &toml::Value| value["method"]["bound"].as_str() == Some("vsm");
    table["technique"].as_array_mut().unwrap().retain(is_kept);
    let path = directory.join("only.toml");
    std::fs::write(&path, table.to_string()).unwrap();
    path
}

#[test]
fn a_large_ground_in_the_light_excuses_no_technique() {
    let directory = tempfile::tempdir().unwrap();
    let file = variance_alone(directory.path());
    let mut found = Vec::new();
    // Texels of the same side, so that only the ground grows.
    for (side, size) in [(20.0, "256"), (40.0, "512"), (80.0, "1024")] {
        let scene = box_on_ground(directory.path(), side, true);
        // Any tolerance is met, by doing nothing as well.
        let (advice, message, code) =
            asked(&[&scene, "--size", size, "--tolerance", "0.5", "--candidates", file.to_str().unwrap()]);
        let nothing = advice["nothing"]["l1_error"].as_f64().unwrap();
        let is_refused = advice["recommendation"].is_null();
        assert_eq!(code, Some(if is_refused { 3 } else { 0 }), "{message}");
        let shown = if is_refused { &advice["next_better"] } else { &advice["recommendation"] };
        let of = |key: &str| shown[key].as_f64().unwrap();
        assert!(is_refused || of("relative_error_high") <= 0.5, "{advice}");
        assert!(!is_refused || of("relative_error_high") > 0.5, "{advice}");
        found.push((
            nothing,
            of("l1_error"),
            [of("relative_error_low"), of("relative_error_high")],
            is_refused,
        ));
    }
    for pair in found.windows(2) {
        // The ground is four times as large, and so much smaller is the mean of anything, that of doing nothing too.
        assert!(pair[1].0 < 0.4 * pair[0].0 && pair[1].1 < 0.4 * pair[0].1, "{found:?}");
        // The companion is the same, but for where the texels lie, and so is the advice.
        let [one, other] = [pair[0].2, pair[1].2];
        assert!(
            one[0] <= 1.1 * other[1] && other[0] <= 1.1 * one[1] && other[1] < 1.5 * other[0],
            "{found:?}"
        );
        assert_eq!(pair[0].3, pair[1].3, "{found:?}");
    }
}

#[test]
fn ground_too_large_for_its_map_is_told_so() {
    let directory = tempfile::tempdir().unwrap();
    // The box is smaller than a texel: a few fragments at most are in shadow.
    for side in [400.0, 100_000.0] {
        let scene = box_on_ground(directory.path(), side, true);
        let (advice, message, code) = asked(&[&scene, "--size", "128"]);
        if advice["recommendation"].is_null() {
            let is_lit = advice["nothing"]["shadowed_share"] == 0.0;
            assert!(
                code == Some(if is_lit { 2 } else { 3 })
                    && message.contains("texels of")
                    && message.lines().count() == 1,
                "{message}"
            );
        } else {
            assert!(advice["recommendation"]["relative_error_high"].as_f64().unwrap() <= 0.5, "{advice}");
        }
    }
    // Without a shadow there is nothing to recommend.
    let scene = box_on_ground(directory.path(), 40.0, false);
    let (advice, message, code) = asked(&[&scene, "--size", "128"]);
    assert!(code == Some(2) && message.contains("in shadow") && message.lines().count() == 1, "{message}");
    assert!(advice["recommendation"].is_null() && advice["next_better"].is_null());
    assert_eq!(advice["nothing"]["l1_error"].as_f64(), Some(0.0));
    let human = msm(&["advise", &scene, "--size", "128"]);
    assert_eq!(human.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&human.stdout).contains("do nothing"));
}

#[test]
fn the_answer_does_not_depend_on_threads() {
    let ask = |threads: &str| {
        let arguments = [
            "advise",
            "stairs",
            "--view",
            "oblique",
            "--size",
            "128",
            "--tolerance",
            "0.1",
            "--format",
            "json",
        ];
        let output = msm(&[&arguments[..], &["--threads", threads]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    assert_eq!(ask("1"), ask("3"));
}

#[test]
fn a_stack_is_judged_at_its_own_size() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().to_str().unwrap();
    let rendered =
        msm(&["render", "stairs", "--view", "oblique", "--size", "96", "--backend", "cpu", "--out", out]);
    assert!(rendered.status.success());
    let stack = directory.path().join("stairs-oblique.stack.npz");
    let stack = stack.to_str().unwrap();
    let output = msm(&["advise", stack, "--tolerance", "0.3", "--format", "json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let advice: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (advice["reference_size"].as_u64(), advice["recommendation"]["size"].as_u64()),
        (Some(96), Some(96))
    );
    let output = msm(&["advise", stack, "--size", "128"]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("96x96") && message.contains("128"), "{message}");
}

#[test]
fn impossible_questions_are_answered_on_one_line() {
    let small = ["--size", "128", "--view", "oblique"];
    for (arguments, named) in [
        (vec!["stairs", "--tolerance", "0"], "tolerance 0"),
        (vec!["stairs", "--tolerance", "1"], "tolerance 1"),
        (vec!["stairs", "--tolerance", "NaN"], "tolerance NaN"),
        (vec!["stairs", "--tolerance", "-0.5"], "-0.5"),
        (vec!["stairs", "--tolerance", "much"], "much"),
        (vec!["stairs", "--relative", "1"], "relative 1"),
        (vec!["nowhere"], "nowhere"),
        (vec!["no-such-file.glb"], "no-such-file.glb"),
        (vec!["stairs", "--view", "noon"], "noon"),
        (vec!["stairs", "--size", "5"], "5"),
        (vec!["stairs", "--threads", "0"], "0 threads"),
        (vec!["stairs", "--candidates", "experiments/bounds.toml"], "speed-accuracy"),
        (vec!["stairs", "--candidates", "missing.toml"], "missing.toml"),
    ] {
        let output = msm(&[&["advise"], arguments.as_slice()].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(named) && message.trim().lines().count() == 1, "{arguments:?}: {message}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
    // Nothing reaches this, but what came closest is of use.
    let output =
        msm(&[&["advise", "stairs", "--tolerance", "1e-6", "--format", "json"], &small[..]].concat());
    assert_eq!(output.status.code(), Some(3));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("nothing meets it") && message.trim().lines().count() == 1, "{message}");
    let advice: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(advice["recommendation"].is_null());
    let best = advice["next_better"]["technique"].as_str().unwrap();
    assert!(message.contains(best), "{message}");
}
