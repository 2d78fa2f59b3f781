//! Committed figures and pages are what their records say: each is regenerated and compared byte for byte.
// Clippy's exemption for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used)]

use evaluation::RunDirectory;
use report::Page;
use std::collections::{BTreeSet, HashMap};
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
    let text = std::fs::read_to_string(root.join("results/README.md")).unwrap();
    assert!(text.contains(&table), "results/README.md lacks\n{table}");
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

/// The rows of a table of the newest recorded run of an experiment, by column.
/// Rows of a run of an experiment, the last but so many.
fn recorded_before(experiment: &str, later: usize, table: &str) -> Vec<HashMap<String, String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("results").join(experiment);
    let runs = folders(&root);
    let mut reader = csv::Reader::from_path(runs[runs.len() - 1 - later].join(table)).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn recorded(experiment: &str, table: &str) -> Vec<HashMap<String, String>> {
    recorded_before(experiment, 0, table)
}

fn count(row: &HashMap<String, String>, column: &str) -> usize {
    row[column].parse().unwrap()
}

/// README and docs say "no", "every" and "never" about these numbers.
#[test]
fn statements_without_exception_hold_in_the_records() {
    // docs/stability.md: no form of ours gives NaN or a value outside [0, 1]; in double precision each holds its bound at the
    // recommended bias on these inputs, and breaks it somewhere without a bias.
    let rows = recorded("stability", "records.csv");
    let ours = |row: &&HashMap<String, String>| {
        ["textbook", "MSM15", "GDC16"].iter().all(|published| !row["method"].contains(published))
    };
    assert!(rows.iter().filter(ours).count() > 100);
    for row in rows.iter().filter(ours) {
        assert_eq!((count(row, "not_finite"), count(row, "outside")), (0, 0), "{row:?}");
    }
    let double: Vec<&HashMap<String, String>> =
        rows.iter().filter(ours).filter(|row| row["method"].ends_with(", f64")).collect();
    let methods: BTreeSet<&str> = double.iter().map(|row| row["method"].as_str()).collect();
    assert_eq!(methods.len(), 6, "{methods:?}");
    for method in methods {
        let broken = |wanted: &dyn Fn(&HashMap<String, String>) -> bool| {
            let of = double.iter().filter(|row| row["method"] == method && wanted(row));
            of.map(|row| count(row, "violated")).sum::<usize>()
        };
        assert_eq!(broken(&|row| row["recommended"] == "true"), 0, "{method}");
        assert!(broken(&|row| row["alpha"].parse() == Ok(0.0)) > 0, "{method}");
    }
    // docs/filterable.md: lower bounds cannot exceed PCF of the same depth, so that by the leak none is ahead of it.
    for experiment in ["filterable", "depth-bias", "lp-agreement"] {
        let rows = recorded(experiment, "records.csv");
        let bounds: Vec<_> = rows.iter().filter(|row| !row["unbiased_violations"].is_empty()).collect();
        assert!(!bounds.is_empty());
        for row in bounds {
            assert_eq!(count(row, "unbiased_violations"), 0, "{row:?}");
            assert!(row["leak"].parse::<f64>().unwrap() > -1e-6, "{row:?}");
        }
    }
    // docs/soft-shadows.md: the truth is known to 0.5 %, the light's outline changes it by at most 0.7 %, no query fails.
    for row in recorded("soft-shadows", "views.csv") {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        assert!(
            number("largest_standard_error") <= 0.005 && number("outline_difference") < 0.0075,
            "{row:?}"
        );
    }
    assert!(recorded("soft-shadows", "records.csv").iter().all(|row| count(row, "failed") == 0));
    // The papers' table: no transform gains more than is proved, and ours come near it.
    let gains = recorded("quantization", "gains.csv");
    let bound = |row: &&HashMap<String, String>| row["bound_bits"].parse::<f64>().is_ok();
    assert!(gains.iter().filter(bound).count() >= 5);
    for row in gains.iter().filter(bound) {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        assert!(number("gain_bits") <= number("bound_bits") + 1e-9, "{row:?}");
    }
    // docs/candidate-search.md: no program of the race remained without a certificate, two of the six billion without a race, 34
    // of the ten billion at the size of the paper's workload.
    let uncertified = |later: usize| -> usize {
        recorded_before("candidate-search", later, "stages.csv")
            .iter()
            .map(|row| count(row, "uncertified"))
            .sum()
    };
    assert_eq!([uncertified(RACE), uncertified(WHOLE), uncertified(0)], [0, 2, 34]);
}

/// Runs of the candidate search that came after the race at the scale quick, and after that without a race.
const RACE: usize = 2;
const WHOLE: usize = 1;

/// docs/candidate-search.md: what a race says of candidates that it judged on a part of the fragments holds on all of them.
#[test]
fn intervals_and_ranks_of_the_race_hold_without_a_race() {
    let number = |row: &HashMap<String, String>, column: &str| row[column].parse::<f64>().unwrap();
    let race = recorded_before("candidate-search", RACE, "records.csv");
    let by_basis = |later: usize| -> HashMap<String, HashMap<String, String>> {
        let rows = recorded_before("candidate-search", later, "records.csv").into_iter();
        rows.map(|row| (format!("{}: {}", row["m"], row["basis"]), row)).collect()
    };
    let (exact, large) = (by_basis(WHOLE), by_basis(0));
    assert_eq!(race.len(), exact.len());
    let (mut held, mut left_early, mut same_range) = (0, 0, 0);
    for row in &race {
        let truth = &exact[&format!("{}: {}", row["m"], row["basis"])];
        // Both are rounded to 1e-7.
        let distance = (number(row, "l1_error") - number(truth, "l1_error")).abs();
        held += usize::from(distance <= number(row, "interval") + 2e-7);
        left_early += usize::from(count(row, "fragments") < count(truth, "fragments"));
        if row["m"] == "4" {
            let ranks = count(row, "rank_low")..=count(row, "rank_high");
            assert!(ranks.contains(&count(truth, "rank")), "{row:?} {truth:?}");
            let large = &large[&format!("4: {}", row["basis"])];
            same_range += usize::from(ranks.contains(&count(large, "rank")));
        }
    }
    assert_eq!(same_range, 65_088, "ranks at the scale paper within those of the scale quick");
    assert!(left_early > race.len() / 2 && 100 * held >= 99 * race.len(), "{held} of {}", race.len());
}

/// The recorded comparison, in which the technique that was evaluated on few fragments has the least mean of all.
#[test]
fn few_fragments_make_no_winner() {
    let folder = tempfile::tempdir().unwrap();
    let rows = recorded("filterable", "records.csv");
    let pooled: Vec<_> = rows
        .iter()
        .filter(|row| {
            ["scene", "view", "class"].iter().all(|column| row[*column] == "all") && row["bias"] == "0"
        })
        .collect();
    let few = pooled.iter().min_by_key(|row| count(row, "fragments")).unwrap();
    let most = pooled.iter().map(|row| count(row, "fragments")).max().unwrap();
    assert!(10 * count(few, "fragments") < most, "{few:?}");
    let name = few["technique"].as_str();
    let easy = |text: &str| {
        let cell = format!("{},{},", few["fragments"], few["l1_error"]);
        text.replace(&cell, &format!("{},0.0001,", few["fragments"]))
    };
    let page = changed(folder.path(), easy);
    let page = page.files().into_iter().find(|file| file.name == "README.md").unwrap();
    let text = String::from_utf8(page.bytes).unwrap();
    let answer = text.lines().find(|line| line.starts_with("**Answer.**")).unwrap();
    assert!(answer.contains(&format!("{name} errs by 0.01 %")), "{answer}");
    let order = answer.split("In order of mean").nth(1).unwrap().split(". ").next().unwrap();
    assert!(!order.contains(name) && order.contains("always lit"), "{order}");
    assert!(answer.contains("that it shares with"), "{answer}");
    let closest = answer.split("In order of mean").next().unwrap();
    assert!(closest.contains("Against F at a depth bias of 1 texel") && !closest.contains(name), "{closest}");
}
