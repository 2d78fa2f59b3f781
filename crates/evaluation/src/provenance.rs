//! Where a number comes from: code, machine, inputs, command.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What the binary knows about its own build.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Build {
    /// Version of msm.
    pub version: String,
    /// Commit, or "unknown" outside a git checkout.
    pub commit: String,
    /// "true" if the sources differed from the commit, "false" if not, "unknown" outside a git checkout.
    pub dirty: String,
    /// Compiler.
    pub rustc: String,
}

/// Written beside the records of every run.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Provenance {
    /// The code.
    #[serde(flatten)]
    pub build: Build,
    /// The command line.
    pub command: String,
    /// Scale of the experiment.
    pub scale: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// Worker threads.
    pub threads: usize,
    /// Start, UTC, RFC 3339.
    pub started: String,
    /// Wall-clock seconds until the records were complete.
    pub seconds: f64,
    /// CPU model, or "unknown".
    pub cpu: String,
    /// Logical cores.
    pub logical_cores: usize,
    /// Operating system and architecture.
    pub os: String,
    /// SHA-256 of every input file by its name, with as many of its folders as tell it from the others: the experiment,
    /// scene files, and the buffers, images and material libraries that these name.
    pub inputs: BTreeMap<String, String>,
}

/// Hexadecimal SHA-256.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Hashes of the files of scenes, which were read a moment ago; procedural scenes are no files.
pub(crate) fn input_hashes(scenes: &[String]) -> BTreeMap<String, String> {
    let mut files: Vec<PathBuf> = Vec::new();
    for scene in scenes {
        let read = match scenes::load_with_files(scene, &scenes::LoadOptions::default()) {
            Ok((_, read)) => read,
            // A stack of depths.
            Err(_) => vec![PathBuf::from(scene)],
        };
        files.extend(read);
    }
    files.sort();
    files.dedup();
    let hash = |(name, file): (String, &PathBuf)| Some((name, sha256(&std::fs::read(file).ok()?)));
    distinct_names(&files).into_iter().zip(&files).filter_map(hash).collect()
}

/// The last parts of each path, as few as tell it from the others.
fn distinct_names(paths: &[PathBuf]) -> Vec<String> {
    let parts = |path: &Path| -> Vec<String> {
        path.components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let all: Vec<Vec<String>> = paths.iter().map(|path| parts(path)).collect();
    let tail = |parts: &[String], length: usize| parts[parts.len().saturating_sub(length)..].join("/");
    let name = |own: &Vec<String>| {
        let is_free = |n: &usize| all.iter().filter(|other| tail(other, *n) == tail(own, *n)).count() == 1;
        (1..own.len()).find(is_free).map_or_else(|| own.join("/"), |length| tail(own, length))
    };
    all.iter().map(name).collect()
}

/// RFC 3339 in UTC, to the second.
pub(crate) fn utc(time: SystemTime) -> String {
    humantime::format_rfc3339_seconds(time).to_string()
}

/// Name of the CPU as the operating system gives it.
pub(crate) fn cpu_model() -> String {
    let from_proc = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let from_sysctl = || {
        let mut command = std::process::Command::new("sysctl");
        let output = command.args(["-n", "machdep.cpu.brand_string"]).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let from_environment = || std::env::var("PROCESSOR_IDENTIFIER").ok();
    from_proc.or_else(from_environment).or_else(from_sysctl).unwrap_or_else(|| "unknown".to_owned())
}

/// Logical cores this process may use.
pub fn logical_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sha256_of_the_standard_example() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), expected);
    }

    #[test]
    fn scenes_of_one_file_name_and_their_buffers_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let mut scenes = vec!["stairs".to_owned()];
        for (name, height) in [("a", 1.0f32), ("b", 2.0)] {
            let directory = folder.path().join(name);
            std::fs::create_dir(&directory).unwrap();
            let positions = [[0.0, 0.0, 0.0], [1.0, height, 0.0], [0.0, 0.0, 1.0f32]];
            let bytes: Vec<u8> = positions.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
            std::fs::write(directory.join("buffer.bin"), bytes).unwrap();
            let text = format!(
                r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
                "buffers":[{{"uri":"buffer.bin","byteLength":36}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
                "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
                "min":[0,0,0],"max":[1,{height},1]}}]}}"#
            );
            std::fs::write(directory.join("scene.gltf"), text).unwrap();
            scenes.push(directory.join("scene.gltf").to_string_lossy().into_owned());
        }
        let hashes = input_hashes(&scenes);
        let names: Vec<&str> = hashes.keys().map(String::as_str).collect();
        assert_eq!(names, ["a/buffer.bin", "a/scene.gltf", "b/buffer.bin", "b/scene.gltf"]);
        assert_ne!(hashes["a/buffer.bin"], hashes["b/buffer.bin"]);
        let only = input_hashes(&scenes[1..2]);
        assert_eq!(only.keys().collect::<Vec<_>>(), ["buffer.bin", "scene.gltf"]);
    }
}
