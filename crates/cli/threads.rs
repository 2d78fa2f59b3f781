//! How many threads work.

use evaluation::logical_cores;
use std::io::Write;

/// Threads a core beyond which nothing is gained and memory is lost.
const MOST_A_CORE: usize = 8;

/// The number that was asked for, or as many as make sense, with a note.
pub(crate) fn capped(wanted: Option<usize>) -> Option<usize> {
    let cores = logical_cores();
    let most = MOST_A_CORE * cores;
    wanted.map(|threads| {
        if threads > most {
            let note = format!("msm: note: {threads} threads on {cores} cores gain nothing; {most} work");
            // A closed standard error is no reason to stop.
            let _ = writeln!(std::io::stderr().lock(), "{note}");
        }
        threads.min(most)
    })
}
