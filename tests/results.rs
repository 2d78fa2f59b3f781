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
