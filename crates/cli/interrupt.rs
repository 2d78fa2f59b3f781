//! What Ctrl-C leaves behind: one line that says how to go on.

use std::io::Write;

/// Exit code of a program that a person has interrupted, as shells count: 128 + 2.
const INTERRUPTED: i32 = 130;

/// From now on Ctrl-C ends the program with this advice.
pub(crate) fn advise(how_to_go_on: String) {
    let handler = move || {
        // A closed standard error is no reason to go on; the line clears the rest of a progress bar.
        let _ = writeln!(std::io::stderr().lock(), "\r\x1b[Kmsm: interrupted; {how_to_go_on}");
        std::process::exit(INTERRUPTED);
    };
    // Without a handler Ctrl-C ends the program as well, without a word.
    let _ = ctrlc::set_handler(handler);
}
