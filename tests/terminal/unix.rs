//! Where a user sits: narrow terminals, none at all, no colours, pipes that close, disks that are full or read-only.
//!
//! Tests that need a terminal are reported as ignored where the system gives none.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::{FromRawFd, OwnedFd};
use std::path::Path;
use std::process::{Command, ExitCode, Output, Stdio};

use libtest_mimic::{Arguments, Failed, Trial};

pub fn main() -> ExitCode {
    let needs_terminal = |name: &str, test: fn() -> Result<(), Failed>| {
        let is_missing = terminal(80).is_err();
        Trial::test(name, test)
            .with_kind(if is_missing { "needs a terminal" } else { "" })
            .with_ignored_flag(is_missing)
    };
    let trials = vec![
        needs_terminal("progress_fits_a_narrow_terminal", progress_fits_a_narrow_terminal),
        needs_terminal("no_colour_means_none", no_colour_means_none),
        Trial::test(
            "without_a_terminal_only_the_answer_is_written",
            without_a_terminal_only_the_answer_is_written,
        ),
        Trial::test("a_reader_that_leaves_is_no_crash", a_reader_that_leaves_is_no_crash),
        Trial::test("a_full_disk_loses_nothing_and_is_told_once", a_full_disk_loses_nothing_and_is_told_once),
        Trial::test(
            "folders_that_cannot_be_written_are_told_at_once",
            folders_that_cannot_be_written_are_told_at_once,
        ),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

/// Arguments of a reproduction in seconds.
fn reproduce(out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msm"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command.args(["reproduce", "--scale", "smoke", "--out", out.to_str().unwrap()]);
    command
}

/// Both ends of a terminal of so many columns.
fn terminal(columns: u16) -> std::io::Result<(File, OwnedFd)> {
    let size = libc::winsize { ws_row: 24, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    let (mut outside, mut inside) = (0, 0);
    // SAFETY: openpty writes two descriptors, reads the size, and takes null for what is not wanted.
    let opened = unsafe {
        libc::openpty(
            &mut outside,
            &mut inside,
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            &raw const size as *mut _,
        )
    };
    if opened != 0 {
        return Err(std::io::Error::last_os_error());
    }
    // SAFETY: openpty has opened both, and nobody else owns them.
    Ok(unsafe { (File::from_raw_fd(outside), OwnedFd::from_raw_fd(inside)) })
}

/// What a command writes to a terminal.
fn on_terminal(mut command: Command, columns: u16) -> (String, bool) {
    let (mut outside, inside) = terminal(columns).unwrap();
    command.stdin(Stdio::null()).stdout(inside.try_clone().unwrap()).stderr(inside);
    let mut child = command.spawn().unwrap();
    // The command holds its end until it is dropped; the child's copies close when it ends.
    drop(command);
    let mut written = Vec::new();
    let mut buffer = [0; 4096];
    // The last read of a terminal that nobody writes to fails.
    while let Ok(count @ 1..) = outside.read(&mut buffer) {
        written.extend_from_slice(&buffer[..count]);
    }
    let success = child.wait().unwrap().success();
    (String::from_utf8_lossy(&written).into_owned(), success)
}

/// Text without control sequences, line by line as they were drawn.
fn visible(text: &str) -> Vec<String> {
    let mut plain = String::new();
    let mut characters = text.chars();
    while let Some(character) = characters.next() {
        if character == '\u{1b}' {
            // A sequence ends with its first letter.
            let _ = characters.by_ref().find(char::is_ascii_alphabetic);
        } else {
            plain.push(character);
        }
    }
    plain.split(['\r', '\n']).filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

fn progress_fits_a_narrow_terminal() -> Result<(), Failed> {
    let out = tempfile::tempdir().unwrap();
    let (text, success) = on_terminal(reproduce(out.path()), 60);
    assert!(success, "{text}");
    let lines = visible(&text);
    let progress: Vec<&String> =
        lines.iter().filter(|line| line.contains("[1/") || line.contains("left")).collect();
    assert!(progress.iter().any(|line| line.contains("running, about")), "{text}");
    assert!(progress.iter().all(|line| line.chars().count() <= 60), "{progress:?}");
    assert!(lines.last().unwrap().starts_with("report: "), "{text}");
    // Answers are whole sentences: none is cut for the screen's sake.
    let answers: Vec<&String> =
        lines.iter().filter(|line| line.contains("-shadows: ") && !line.starts_with('[')).collect();
    assert!(answers.len() >= 4, "{text}");
    assert!(answers.iter().all(|line| line.ends_with('.') && !line.ends_with("...")), "{answers:?}");
    Ok(())
}

fn no_colour_means_none() -> Result<(), Failed> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_msm"));
    command.arg("--help").env("TERM", "xterm-256color").env_remove("NO_COLOR");
    let coloured = |text: &str| text.contains("\u{1b}[") && text.contains('m');
    let (text, _) = on_terminal(command, 80);
    assert!(coloured(&text), "the help has no colours anyway, and this test shows nothing: {text}");
    let mut command = Command::new(env!("CARGO_BIN_EXE_msm"));
    command.arg("--help").env("TERM", "xterm-256color").env("NO_COLOR", "1");
    let (text, _) = on_terminal(command, 80);
    assert!(!text.contains("\u{1b}["), "{text:?}");
    let out = tempfile::tempdir().unwrap();
    let mut command = reproduce(out.path());
    command.env("NO_COLOR", "1");
    let (text, success) = on_terminal(command, 80);
    // Cursor movements are none.
    assert!(
        success
            && !text.split("\u{1b}[").skip(1).any(|rest| rest
                .trim_start_matches(|c: char| c.is_ascii_digit() || c == ';')
                .starts_with('m')),
        "{text:?}"
    );
    Ok(())
}

fn without_a_terminal_only_the_answer_is_written() -> Result<(), Failed> {
    let out = tempfile::tempdir().unwrap();
    let output = reproduce(out.path()).stdin(Stdio::null()).output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(!text.contains('\u{1b}') && text.contains("report: "), "{text}");
    let progress = String::from_utf8(output.stderr).unwrap();
    assert!(!progress.contains("left") && !progress.contains('\u{1b}'), "{progress}");
    Ok(())
}

fn a_reader_that_leaves_is_no_crash() -> Result<(), Failed> {
    let out = tempfile::tempdir().unwrap();
    let mut child = reproduce(out.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut message = String::new();
    child.stderr.take().unwrap().read_to_string(&mut message).unwrap();
    child.wait().unwrap();
    assert!(!message.contains("panicked"), "{message}");
    assert!(out.path().join("report.html").is_file(), "{message}");
    Ok(())
}

fn refused(output: &Output, named: &str) {
    let message = String::from_utf8_lossy(&output.stderr);
    let own: Vec<&str> = message.lines().filter(|line| line.starts_with("msm: ")).collect();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(own.len() == 1 && own[0].contains(named) && !message.contains("panicked"), "{message}");
}

fn a_full_disk_loses_nothing_and_is_told_once() -> Result<(), Failed> {
    let out = tempfile::tempdir().unwrap();
    // No file may grow beyond 64 KiB, and the signal for that is ignored: writes fail as on a full disk.
    let script = format!(
        "trap '' XFSZ; ulimit -f 64; exec '{}' reproduce --scale smoke --out '{}'",
        env!("CARGO_BIN_EXE_msm"),
        out.path().display()
    );
    let output =
        Command::new("bash").current_dir(env!("CARGO_MANIFEST_DIR")).args(["-c", &script]).output().unwrap();
    refused(&output, "cannot write");
    // With room again it goes on, and what was finished is not run anew.
    let output = reproduce(out.path()).args(["--format", "json"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let all = answer["experiments"].as_array().unwrap();
    assert!(all.iter().any(|of| of["was_there"] == true), "{answer}");
    assert!(all.iter().all(|of| of["answer"].as_str().is_some_and(|text| !text.is_empty())), "{answer}");
    Ok(())
}

fn folders_that_cannot_be_written_are_told_at_once() -> Result<(), Failed> {
    use std::os::unix::fs::PermissionsExt as _;
    let out = tempfile::tempdir().unwrap();
    // A file where a folder should be stops everybody, root too.
    let file = out.path().join("file");
    File::create(&file).unwrap().write_all(b"mine").unwrap();
    refused(&reproduce(&file.join("results")).output().unwrap(), "file");
    assert_eq!(std::fs::read(&file).unwrap(), b"mine");
    let locked = out.path().join("locked");
    std::fs::create_dir(&locked).unwrap();
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).unwrap();
    // SAFETY: it asks for a number and has no conditions.
    if unsafe { libc::geteuid() } != 0 {
        refused(&reproduce(&locked.join("results")).output().unwrap(), "locked");
    }
    Ok(())
}
