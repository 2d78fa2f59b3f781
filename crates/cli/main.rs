//! `msm`: arguments, progress and exit codes. The only code that knows every crate.

fn main() {}
