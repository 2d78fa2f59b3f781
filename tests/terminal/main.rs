//! How the program behaves where a user sits; on systems with terminals of Unix.

// A panic is how a test or benchmark reports.
#![allow(clippy::unwrap_used)]

#[cfg(unix)]
mod unix;

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    unix::main()
}

#[cfg(not(unix))]
fn main() {}
