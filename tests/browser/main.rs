//! The report in a real browser: filters, points, tables and pictures are used, and nothing is complained about.
//!
//! A copy of the report gets one more script, which does what a reader would and leaves what it saw in the page; headless
//! Chromium prints the page after that. Without Chromium the tests are reported as ignored, or fail if
//! `MSM_REQUIRE_BROWSER` is 1.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

mod film;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use libtest_mimic::{Arguments, Failed, Trial};
use serde_json::Value;

const ACTIONS: &str = include_str!("actions.js");

/// Most that the page may have.
const MOST_BYTES: usize = 6_000_000;

/// Least size of words in charts, in pixels; a hundredth less is rounding.
const LEAST_TEXT: f64 = 10.9;

/// Longest time for one page.
const PATIENCE: Duration = Duration::from_secs(120);

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let trials = vec![
        trial("the_report_works_in_a_browser", report_works),
        trial("a_fault_in_the_script_is_found", fault_is_found),
        trial("phones_need_no_sideways_scrolling", phones),
        trial("frames_play", film::frames_play),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trial(name: &str, test: impl FnOnce(&Path) -> Result<(), Failed> + Send + 'static) -> Trial {
    match chromium() {
        Some(program) => Trial::test(name, move || test(&program)),
        None if std::env::var("MSM_REQUIRE_BROWSER").is_ok_and(|value| value == "1") => {
            Trial::test(name, || Err("MSM_REQUIRE_BROWSER is 1 but chromium is not installed".into()))
        }
        None => Trial::test(name, || Err("needs chromium".into()))
            .with_kind("needs chromium")
            .with_ignored_flag(true),
    }
}

fn chromium() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path).map(|folder| folder.join("chromium")).find(|program| program.is_file())
}

/// The report of committed runs at the scale quick.
fn page(folder: &Path) -> Result<String, Failed> {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("results");
    let mut runs = Vec::new();
    for experiment in ["speed-accuracy", "filterable", "candidate-search", "stability"] {
        let all = std::fs::read_dir(results.join(experiment))?;
        let is_quick = |path: &PathBuf| path.to_string_lossy().ends_with("-quick");
        let newest = all.filter_map(|entry| Some(entry.ok()?.path())).filter(is_quick).max();
        let from = newest.ok_or("no recorded run")?;
        // A copy, because the report is written beside the records.
        let to = folder.join(experiment).join("run");
        std::fs::create_dir_all(&to)?;
        for file in std::fs::read_dir(from)? {
            let file = file?;
            std::fs::copy(file.path(), to.join(file.file_name()))?;
        }
        runs.push(to);
    }
    let html = folder.join("report.html");
    let output = Command::new(env!("CARGO_BIN_EXE_msm"))
        .arg("report")
        .args(&runs)
        .arg("--html")
        .arg(&html)
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    Ok(std::fs::read_to_string(html)?)
}

/// What the added script saw, in a window of this width.
fn seen(program: &Path, folder: &Path, page: &str, width: u32) -> Result<Value, Failed> {
    driven(program, folder, page, ACTIONS, &[&format!("--window-size={width},900")])
}

/// What a script saw in a browser that was started in some way.
fn driven(
    program: &Path,
    folder: &Path,
    page: &str,
    actions: &str,
    started: &[&str],
) -> Result<Value, Failed> {
    // Errors of the page's own script must be heard, so listening begins before it.
    let listening = "<script>window.complaints = [];\
        window.addEventListener('error', (event) => window.complaints.push(event.message));</script>";
    let page = page.replacen("<style>", &format!("{listening}<style>"), 1);
    let page = page.replacen("</body>", &format!("<script>{actions}</script></body>"), 1);
    let file = folder.join("driven.html");
    std::fs::write(&file, page)?;
    let printed = folder.join("dom.html");
    let mut browser = Command::new(program)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"])
        .args(["--virtual-time-budget=5000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .args(started)
        .arg(format!("file://{}", file.display()))
        .stdout(std::fs::File::create(&printed)?)
        .stderr(Stdio::null())
        .spawn()?;
    // A browser that hangs must not hang the tests.
    let begin = Instant::now();
    while browser.try_wait()?.is_none() {
        if begin.elapsed() > PATIENCE {
            browser.kill()?;
            browser.wait()?;
            return Err(format!("the browser had not finished after {PATIENCE:?}").into());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let dom = std::fs::read_to_string(printed)?;
    let start = dom.find("<pre id=\"seen\">").ok_or("the browser did not run the script")?;
    let text =
        dom[start..].split('>').nth(1).and_then(|rest| rest.split('<').next()).ok_or("nothing was seen")?;
    let text = text.replace("&amp;", "&").replace("&lt;", "<").replace("&gt;", ">");
    Ok(serde_json::from_str(&text)?)
}

fn report_works(program: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let page = page(folder.path())?;
    let seen = seen(program, folder.path(), &page, 1200)?;
    let number = |key: &str| seen[key].as_u64().unwrap_or_default();
    assert_eq!(seen["complaints"], serde_json::json!([]), "{seen}");
    assert!(page.len() < MOST_BYTES, "{} bytes", page.len());
    assert!(number("points") > 60, "{seen}");
    // One family fewer, then one memory size fewer, then all again.
    assert!(number("without_vsm") < number("points"), "{seen}");
    assert!(number("without_64_bits") < number("without_vsm"), "{seen}");
    assert_eq!(number("points_again"), number("points"), "{seen}");
    let focused = seen["focused"].as_str().unwrap_or_default();
    assert!(
        focused.contains("error") && focused.contains("cost") && focused.contains("bits a texel"),
        "{seen}"
    );
    // Fewer marks, less ink; a panel an application.
    assert!(seen["ink_without_vsm"][0].as_u64() < seen["ink_without_vsm"][1].as_u64(), "{seen}");
    assert_eq!((number("panels"), number("panels_without")), (1, 0), "{seen}");
    assert_eq!(number("chart_stops"), 1, "{seen}");
    assert_eq!((&seen["arrow"], &seen["arrow_back"]), (&Value::Bool(true), &Value::Bool(true)), "{seen}");
    assert!(seen["is_told"].as_str().unwrap_or_default().contains("arrow keys"), "{seen}");
    assert_eq!((number("first_headings"), number("skipped_levels")), (1, 0), "{seen}");
    assert_eq!(seen["dead_links"], serde_json::json!([]), "{seen}");
    assert_eq!((number("told"), number("first_figure")), (3, 1), "{seen}");
    // Every experiment has its controls; the tables that are folded add none.
    assert!(number("stops") < 250, "{seen}");
    // A table filtered by a word, and sorted by its numbers in both directions.
    assert!(number("rows_found") > 0 && number("rows_found") < number("rows"), "{seen}");
    assert_eq!(seen["ascending"], true, "{seen}");
    assert_eq!(seen["descending"], true, "{seen}");
    assert_eq!(seen["enlarged"], true, "{seen}");
    let different: Vec<u64> =
        seen["compared"].as_array().ok_or("none")?.iter().filter_map(Value::as_u64).collect();
    let [whole, left, right] = different[..] else { return Err(format!("{seen}").into()) };
    assert!(whole > 1000 && left > 100 && right > 100 && left < whole && right < whole, "{seen}");
    assert!(number("zoomed") > 1000, "{seen}");
    assert!(seen["comparer"].as_str().unwrap_or_default().contains("zoom 4"), "{seen}");
    assert!(number("figures") > 8, "{seen}");
    // Each figure that was drawn can be saved in two formats.
    assert!(number("saved") > 16 && number("saved") % 2 == 0, "{seen}");
    let difference: Vec<u64> =
        seen["difference"].as_array().ok_or("none")?.iter().filter_map(Value::as_u64).collect();
    let [agree, grey, changed] = difference[..] else { return Err(format!("{seen}").into()) };
    assert!(agree > 1000 && grey == agree && changed > agree / 2, "{seen}");
    let text = |key: &str| seen[key].as_str().unwrap_or_default().to_owned();
    assert!(text("candidate").starts_with("rank ") && text("candidate").contains(" of 66045: 5."), "{seen}");
    assert_eq!(number("candidate_line"), 1, "{seen}");
    assert!(text("candidates_with").starts_with("595 of 66045"), "{seen}");
    assert_eq!(text("no_candidate"), "not in the family: tan(z)");
    assert_eq!(number("listed"), 8, "{seen}");
    assert!(text("spot").contains("error") && text("spot").contains('%'), "{seen}");
    assert!(text("cell").contains("largest error") || text("cell").contains("no inputs"), "{seen}");
    assert_eq!(seen["tip_left"], true, "{seen}");
    // The newest run of speed and accuracy may be one without a graphics processor, whose frames the papers state.
    assert!(number("papers") > 15, "{seen}");
    Ok(())
}

/// Without the line that draws after a filter was changed, the same actions see something else.
fn fault_is_found(program: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let page = page(folder.path())?;
    let line = "if (box.checked) chosen.add(value); else chosen.delete(value);";
    assert!(page.contains(line));
    let seen = seen(program, folder.path(), &page.replace(line, ""), 1200)?;
    if seen["without_vsm"] != seen["points"] {
        return Err(format!("a filter without effect went unnoticed: {seen}").into());
    }
    Ok(())
}

fn phones(program: &Path) -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let page = page(folder.path())?;
    // Windows of headless Chromium are not narrower; the script narrows the page further.
    let seen = seen(program, folder.path(), &page, 500)?;
    assert_eq!(seen["complaints"], serde_json::json!([]), "{seen}");
    assert!(seen["width"].as_u64().is_some_and(|width| width <= 360), "{seen}");
    assert!(seen["smallest_text"].as_f64().is_some_and(|size| size >= LEAST_TEXT), "{seen}");
    Ok(())
}
