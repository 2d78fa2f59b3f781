//! Committed figures and pages are what their records say: each is regenerated and compared byte for byte.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use evaluation::RunDirectory;
use report::Page;
use std::path::{Path, PathBuf};

fn folders(path: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

#[test]
fn every_committed_figure_and_page_follows_from_its_records() {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let mut compared = 0;
    for run in folders(&results).iter().flat_map(|experiment| folders(experiment)) {
        let files = report::page(&RunDirectory::open(&run).unwrap()).unwrap().files();
        for file in &files {
            let recorded = std::fs::read(run.join(&file.name)).unwrap();
            assert!(recorded == file.bytes, "{} differs from its records", run.join(&file.name).display());
            compared += 1;
        }
        // A figure that no code draws any more would be compared with nothing.
        for entry in std::fs::read_dir(&run).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if name.ends_with(".svg") {
                assert!(files.iter().any(|file| file.name == name), "{}", run.join(name).display());
            }
        }
    }
    assert!(compared > 0, "nothing was compared");
}

#[test]
fn the_table_of_the_papers_follows_from_the_committed_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let results = folders(&root.join("results"));
    let pages: Vec<Page> = results
        .iter()
        .flat_map(|experiment| folders(experiment))
        .map(|run| report::page(&RunDirectory::open(&run).unwrap()).unwrap())
        .collect();
    let table = report::comparison(&pages);
    assert!(table.lines().count() > 20, "{table}");
    for page in ["README.md", "results/README.md"] {
        let text = std::fs::read_to_string(root.join(page)).unwrap();
        assert!(text.contains(&table), "{page} lacks\n{table}");
    }
}

/// A copy of the recorded comparison of techniques, in which `change` rewrites experiment, tables and names of files.
fn changed(folder: &Path, change: impl Fn(&str) -> String) -> Page {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/filterable");
    let copy = folder.join("filterable/run");
    std::fs::create_dir_all(&copy).unwrap();
    for entry in std::fs::read_dir(folders(&results).last().unwrap()).unwrap() {
        let (from, name) = entry.map(|entry| (entry.path(), entry.file_name())).unwrap();
        let is_text = ["csv", "toml"].iter().any(|kind| from.extension().is_some_and(|e| e == *kind));
        let bytes = std::fs::read(&from).unwrap();
        let bytes = if is_text { change(&String::from_utf8(bytes).unwrap()).into_bytes() } else { bytes };
        std::fs::write(copy.join(change(&name.into_string().unwrap())), bytes).unwrap();
    }
    report::page(&RunDirectory::open(&copy).unwrap()).unwrap()
}

#[test]
fn a_renamed_technique_keeps_its_claims_and_a_lost_role_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |page: Page| report::comparison(&[page]);
    let before = rows(changed(folder.path(), str::to_owned));
    let rename = |text: &str| {
        let text = text.replace("\"VSM\"", "\"variance\"").replace(",VSM,", ",variance,");
        text.replace("role = \"variance\"", "role = \"VSM\"").replace("-vsm.png", "-variance.png")
    };
    let renamed = rows(changed(folder.path(), rename));
    assert_eq!(renamed, before.replace("; VSM ", "; variance "));
    let lost = rows(changed(folder.path(), |text| text.replace("role = \"VSM\"\n", "")));
    assert_eq!(lost.lines().count(), before.lines().count());
    assert!(lost.contains("not measured by this run: nobody has the role `VSM`"), "{lost}");
    assert!(!before.contains("not measured"), "{before}");
}
