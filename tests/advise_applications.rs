//! `msm advise` beyond hard shadows: lights of some size, media, budgets, pictures, and what an implementer is told.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

use std::collections::HashMap;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn msm(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_msm"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

fn advise(arguments: &[&str], code: i32) -> (Value, String) {
    let output = msm(&[&["advise"], arguments, &["--format", "json"]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    (serde_json::from_slice(&output.stdout).unwrap_or(Value::Null), message)
}

/// Kind `soft-shadows` on one small map with all of its fragments, under a light along one view.
fn soft_experiment(directory: &Path, scene: &str, light: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/soft-shadows.toml");
    let mut table: toml::Table = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for key in ["scale", "sweep", "picture", "receiver", "passes", "light"] {
        table.remove(key);
    }
    let more = format!(
        "scenes = [\"{scene}\"]\nviews = [\"oblique\"]\nsize = 128\nfragments = 0\npixels = 10\ncamera = [16, 16]\n\
         timing = {{ repetitions = 1 }}\n[[light]]\nname = \"sun\"\nshape = \"{light}\"\n"
    );
    table.extend(toml::from_str::<toml::Table>(&more).unwrap());
    let path = directory.join("soft.toml");
    std::fs::write(&path, table.to_string()).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn what_is_said_of_soft_shadows_holds_in_the_full_evaluation() {
    let directory = tempfile::tempdir().unwrap();
    let asked = ["stairs", "--view", "oblique", "--size", "128", "--light", "sun:2"];
    let (advice, _) = advise(&asked, 0);
    let soft = &advice["soft_shadows"];
    assert!(soft["recommendation"].is_object(), "{soft}");
    for key in ["technique", "format", "bias_texels", "size", "region", "samples", "l1_error_low", "cost"] {
        assert!(!soft["recommendation"][key].is_null(), "{key} of {soft}");
    }
    let high = soft["recommendation"]["l1_error_high"].as_f64().unwrap();
    assert!(high <= soft["tolerance"].as_f64().unwrap(), "{soft}");

    let file = soft_experiment(directory.path(), "stairs", "sun:2");
    let run = msm(&["run", &file, "--out", directory.path().to_str().unwrap(), "--format", "json"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let run: Value = serde_json::from_slice(&run.stdout).unwrap();
    let records = Path::new(run["directory"].as_str().unwrap()).join("records.csv");
    let mut reader = csv::Reader::from_path(records).unwrap();
    let rows: Vec<HashMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    let biases = [(0.5, 0.5), (0.5, 0.0), (0.5, 2.0), (1.0, 4.0)];
    let mut checked = 0;
    let shown = ["recommendation", "next_cheaper", "next_better"].map(|key| &soft[key]);
    for choice in shown.into_iter().chain(soft["near_ties"].as_array().unwrap()) {
        let format = choice["format"].as_str().unwrap_or_default();
        if choice["size"] != 128 || format.contains("16-bit") {
            continue;
        }
        let number = |key: &str| choice[key].as_f64().unwrap();
        let bias = biases.iter().position(|&bias| bias == (number("bias_texels"), number("bias_slopes")));
        let is_it = |row: &&HashMap<String, String>| {
            row["technique"] == choice["technique"].as_str().unwrap()
                && row["bias"] == bias.unwrap().to_string()
                && (row["population"].as_str(), row["scene"].as_str(), row["group"].as_str())
                    == ("fragments", "all", "all")
        };
        let Some(row) = rows.iter().find(is_it) else { continue };
        let error: f64 = row["mean_error"].parse().unwrap();
        // The full evaluation draws other shadow rays: both truths have a standard error.
        let noise = soft["truth_standard_error"].as_f64().unwrap();
        let (low, high) = (number("l1_error_low"), number("l1_error_high"));
        assert!(low - noise <= error && error <= high + noise, "{choice}: {error}");
        checked += 1;
    }
    assert!(checked > 0, "nothing that was said was in the experiment: {soft}");
}

#[test]
fn without_a_light_of_some_size_nothing_is_said_of_soft_shadows() {
    let (advice, _) = advise(&["stairs", "--view", "oblique", "--size", "128"], 0);
    assert!(
        advice["soft_shadows"].is_null() && advice["scattering"].is_null() && advice["together"].is_null()
    );
    // A lamp in space, by the name of its view or by itself.
    for light in [&["--view", "lamp"][..], &["--light", "rect:0,9,0;1,0,0;0,0,1"]] {
        let (advice, _) = advise(&[&["stairs", "--size", "128", "--tolerance", "0.4"], light].concat(), 0);
        assert!(advice["soft_shadows"]["recommendation"].is_object(), "{advice}");
    }
}

#[test]
fn applications_share_what_they_are_made_from() {
    let asked = ["stairs", "--view", "oblique", "--size", "128", "--light", "sun:1", "--medium", "1,0.9"];
    let (advice, _) = advise(&asked, 0);
    let scattering = &advice["scattering"];
    assert!(scattering["recommendation"]["technique"].is_string(), "{scattering}");
    assert_eq!(scattering["medium"]["anisotropy"], 0.3);
    let together = &advice["together"];
    let number = |key: &str| together[key].as_f64().unwrap();
    assert_eq!(together["members"].as_array().unwrap().len(), 3, "{together}");
    assert!(number("cost") <= number("cost_apart") && number("bytes") <= number("bytes_apart"), "{together}");
    let is_shared = !together["shared"].as_array().unwrap().is_empty();
    assert_eq!(is_shared, number("cost") < number("cost_apart"), "{together}");
}

#[test]
fn budgets_are_kept_or_said_to_be_too_small() {
    let small = ["stairs", "--view", "oblique", "--size", "128"];
    let (free, _) = advise(&[&small[..], &["--tolerance", "0.3"]].concat(), 0);
    let (within, _) = advise(&[&small[..], &["--budget-bytes", "70000"]].concat(), 0);
    let of = |advice: &Value, key: &str| advice["recommendation"][key].as_f64().unwrap();
    assert!(of(&within, "map_bytes") <= 70000.0, "{within}");
    // The most accurate within the budget errs less than the cheapest within a wide tolerance.
    assert!(of(&within, "l1_error") <= of(&free, "l1_error"), "{within} {free}");
    let (_, message) = advise(&[&small[..], &["--budget-ms", "1e-6"]].concat(), 2);
    assert!(message.contains("0.000001 ms") && message.contains("the cheapest takes"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    let (_, message) = advise(&[&small[..], &["--tolerance", "1e-5"]].concat(), 3);
    let met = message.split("--tolerance ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    // What is said to be met is met.
    advise(&[&small[..], &["--tolerance", met]].concat(), 0);
}

#[test]
fn an_implementer_is_told_everything() {
    let asked = ["stairs", "--view", "oblique", "--size", "128", "--kernel", "gaussian:5:1.2"];
    let (advice, _) = advise(&asked, 0);
    assert_eq!(advice["reference"]["kernel"], "gaussian:5:1.2");
    let shipping = &advice["recommendation"]["shipping"];
    let order = shipping["matrix"].as_array().unwrap().len();
    assert!(order >= 1 && shipping["matrix"][0].as_array().unwrap().len() == order, "{shipping}");
    let weights = shipping["kernel"].as_array().unwrap().iter().map(|w| w.as_f64().unwrap());
    assert!((weights.sum::<f64>() - 1.0).abs() < 1e-12, "{shipping}");
    let bias = &shipping["depth_bias"][0];
    let [world, depth, range] = ["world", "depth", "depth_range"].map(|key| bias[key].as_f64().unwrap());
    assert!((world - depth * range).abs() <= 1e-12 * range, "{bias}");
    let text = msm(&[&["advise"], &asked[..]].concat());
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    for words in ["to implement it", "store", "transform", "filter", "depth bias", "reference", "error"] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn pictures_show_what_is_recommended() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("pictures");
    let asked = ["stairs", "--view", "oblique", "--size", "128", "--picture", out.to_str().unwrap()];
    advise(&asked, 0);
    for name in ["reference.png", "recommended.png", "recommended-difference.png", "comparison.png"] {
        let picture = image::open(out.join(name)).unwrap();
        assert!(name == "comparison.png" || (picture.width(), picture.height()) == (1920, 1080), "{name}");
    }
}

#[test]
fn impossible_lights_media_and_kernels_are_told_on_one_line() {
    let small = ["stairs", "--size", "128"];
    for (arguments, named) in [
        (&["--light", "moon:2"][..], "moon:2"),
        (&["--view", "0,0,0"], "0,0,0"),
        (&["--view", "noon"], "noon"),
        (&["--view", "high", "--light", "rect:0,9,0;1,0,0;0,0,1"], "U x V"),
        (&["--medium", "thick"], "thick"),
        (&["--medium", "-1"], "-1"),
        (&["--kernel", "gaussian:8:2"], "8"),
        (&["--kernel", "round:9"], "round:9"),
        (&["--views", "missing.toml"], "missing.toml"),
        (&["--budget-ms", "0"], "0 ms"),
        (&["--bandwidth", "-3"], "-3"),
        (&["--light", "sun:170"], "texels"),
    ] {
        let (_, message) = advise(&[&small[..], arguments].concat(), 2);
        assert!(message.contains(named) && message.lines().count() == 1, "{arguments:?}: {message}");
    }
}

/// Kind `translucent-shadows` with one technique at one bias, on all receivers of a small map.
fn translucent_experiment(directory: &Path, choice: &Value) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/translucent-shadows.toml");
    let mut table: toml::Table = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for key in ["scale", "advice", "colour", "stability", "picture"] {
        table.remove(key);
    }
    let named = |technique: &toml::Value| technique["name"].as_str() == choice["technique"].as_str();
    table["technique"].as_array_mut().unwrap().retain(named);
    let (texels, slopes) = (&choice["bias_texels"], &choice["bias_slopes"]);
    let more = format!(
        "scenes = [\"smoke\"]\nviews = [\"oblique\"]\nsize = 128\nfragments = 0\ntiming = {{ repetitions = 1 }}\n\
         bias = {{ reference = {{ texels = 1.0 }}, technique = {{ texels = {texels}, slopes = {slopes} }} }}\n"
    );
    table.extend(toml::from_str::<toml::Table>(&more).unwrap());
    let path = directory.join("translucent.toml");
    std::fs::write(&path, table.to_string()).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn what_is_said_of_translucent_casters_holds_in_the_full_evaluation() {
    let directory = tempfile::tempdir().unwrap();
    let (advice, _) = advise(&["smoke", "--view", "oblique", "--size", "128"], 0);
    let casters = &advice["translucent_casters"];
    let choice = &casters["recommendation"];
    let number = |value: &Value| value.as_f64().unwrap();
    let (low, high) = (number(&choice["l1_error_low"]), number(&choice["l1_error_high"]));
    assert!(high <= number(&casters["tolerance"]) && high < number(&casters["nothing"]), "{casters}");
    assert_eq!(number(&casters["drawn"]), number(&casters["surfaces"]) + number(&casters["inside"]));
    assert_eq!(advice["together"]["members"].as_array().unwrap().len(), 2);

    let file = translucent_experiment(directory.path(), choice);
    let run = msm(&["run", &file, "--out", directory.path().to_str().unwrap(), "--format", "json"]);
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let run: Value = serde_json::from_slice(&run.stdout).unwrap();
    let records = Path::new(run["directory"].as_str().unwrap()).join("records.csv");
    let mut rows = csv::Reader::from_path(records).unwrap();
    let rows: Vec<HashMap<String, String>> = rows.deserialize().map(Result::unwrap).collect();
    let all = rows.iter().find(|row| row["scene"] == "smoke" && row["class"] == "all").unwrap();
    let error: f64 = all["l1_error"].parse().unwrap();
    // Records are rounded to 1e-9, sums of the race are added in single precision.
    assert!((low - 1e-6..=high + 1e-6).contains(&error), "{error} is not within {low} to {high}");

    let (advice, _) = advise(&["stairs", "--view", "oblique", "--size", "128"], 0);
    assert!(advice["translucent_casters"].is_null(), "{advice}");
}

#[test]
fn a_software_driver_is_never_a_graphics_processor() {
    let (advice, _) = advise(&["stairs", "--view", "oblique", "--size", "64", "--gpu"], 0);
    let (costs, choice) = (&advice["costs"], &advice["recommendation"]);
    let adapter = costs["adapter"].as_str().unwrap();
    match costs["source"].as_str() {
        Some("modelled") => {
            assert!(!adapter.is_empty() && costs["unit_ms"].is_null() && choice["cost_is_measured"] == false);
        }
        Some("measured") => assert!(!adapter.contains("llvmpipe") && costs["unit_ms"].as_f64() > Some(0.0)),
        other => panic!("costs are {other:?}"),
    }
    let (advice, _) = advise(&["stairs", "--view", "oblique", "--size", "64"], 0);
    assert_eq!(advice["costs"]["adapter"], "");
}
